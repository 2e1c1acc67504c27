//! `--record`: a copy of what was read.

use std::process::Stdio;

use super::{assert_exit, capture, devicenet, json_lines, pcapng, run, stderr, stdout, temporary};

#[test]
fn a_copy_can_be_written_in_either_format_and_decodes_the_same() {
    let original = capture("candump-L-mixed.log");
    let json = |file: &str| json_lines(&run(&["decode", "--json", file]));
    for name in ["copy.pcapng", "copy.log"] {
        let copy = temporary(name);
        run(&["decode", "--record", &copy, &original]);
        let (mut expected, found) = (json(&original), json(&copy));
        if name.ends_with("pcapng") {
            // The copy has nanoseconds, the same number.
            assert_eq!(expected[0]["t"].as_f64(), found[0]["t"].as_f64());
        }
        for (expected, found) in expected.iter_mut().zip(&found) {
            expected["t"] = found["t"].clone();
        }
        assert_eq!(expected, found, "{name}");
    }
}

#[test]
fn a_recording_is_converted_on_standard_output_and_never_over_itself() {
    let output = run(&["decode", "--record", "-", &capture("candump-ta.txt")]);
    let original = std::fs::read_to_string(capture("slave-01-startup-poll.log")).unwrap();
    let first: String = original.lines().take(20).map(|line| format!("{line}\n")).collect();
    assert_eq!(stdout(&output), first);
    let file = temporary("itself.log");
    std::fs::write(&file, &original).unwrap();
    let link = temporary("itself-too.log");
    let _ = std::fs::remove_file(&link);
    std::fs::hard_link(&file, &link).unwrap();
    for name in [&file, &link] {
        let output = run(&["decode", "--record", name, &file]);
        assert_exit(&output, 2);
        let input = std::fs::File::open(&file).unwrap();
        let redirected = devicenet(&["decode", "--record", name, "-"]).stdin(input).output().unwrap();
        assert_exit(&redirected, 2);
        assert_eq!(std::fs::read_to_string(&file).unwrap(), original);
    }
}

/// A pcapng file by hand: an interface for Ethernet, one for CAN by the name of `CAN 1`, a packet of each, and a packet of an
/// interface that is not described.
#[test]
fn a_capture_of_more_than_can_is_recorded_with_names_of_one_word() {
    const CAN: &[u8] = &[0, 0, 4, 0x55, 0, 0, 0, 0];
    let interfaces = [(1, &[][..]), (0xE3, b"\x02\0\x05\0CAN 1\0\0\0")];
    let bytes = pcapng::file(&interfaces, &[(0, CAN), (1, CAN), (2, CAN)]);
    let (file, copy) = (temporary("two-networks.pcapng"), temporary("two-networks.log"));
    std::fs::write(&file, bytes).unwrap();
    let output = run(&["decode", "--record", &copy, &file]);
    assert_exit(&output, 1);
    assert_eq!(
        stderr(&output),
        format!(
            "warning: {file}:record 3, byte 1: an interface that was described before expected, \"02 00 00 00\" found\n\
             note: {copy}: a name in a candump log is one word, so \"CAN 1\" is written as \"CAN_1\"\n\
             note: {file}: 1 packet is of other interfaces than CAN, and left out; \
             `devicenet decode --protocol powerlink` reads those of Ethernet\n\
             warning: {file}: 1 record could not be read\n"
        )
    );
    assert_eq!(std::fs::read_to_string(copy).unwrap(), "(0.000000) CAN_1 455#\n");
}

/// Whoever looks only at the beginning still gets the whole copy.
#[test]
fn a_copy_is_complete_when_the_words_are_not_wanted() {
    let (file, copy) = (temporary("long-2.log"), temporary("long-2-copy.log"));
    let log: String =
        (0..50_000).map(|n| format!("({}.{:06}) can0 455#0102\n", n / 1000, n % 1000 * 1000)).collect();
    std::fs::write(&file, &log).unwrap();
    let mut child = devicenet(&["decode", "--record", &copy, &file])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(stderr(&output), "");
    assert!(std::fs::read_to_string(&copy).unwrap() == log);
}

#[test]
fn two_outputs_do_not_share_standard_output() {
    for option in ["--json", "--summary"] {
        let output = run(&["decode", option, "--record", "-", &capture("candump-ta.txt")]);
        assert_exit(&output, 2);
        assert_eq!(stdout(&output), "");
        let expected = format!("error: {option} and `--record -` both want standard output");
        assert!(stderr(&output).starts_with(&expected), "{}", stderr(&output));
    }
}
