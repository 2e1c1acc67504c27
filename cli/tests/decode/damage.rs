//! Recordings with bad lines, cut off, or none at all.

use super::{assert_exit, capture, run, run_with_input, stderr, stdout, temporary};

#[test]
fn a_bad_line_is_a_warning_with_its_place_and_the_rest_is_read() {
    let log = "(1.000000) can0 456#014B03010301\n(1.000300) can0 453#01CBx\n(1.000400) can0 455#\n";
    let output = run_with_input(&["decode", "-"], log);
    assert_exit(&output, 1);
    assert_eq!(
        stderr(&output),
        "warning: <stdin>:2:25: two hexadecimal digits expected, \"x\" found\n\
         warning: <stdin>: 1 line could not be read\n"
    );
    assert_eq!(stdout(&output).lines().count(), 2);
}

/// candump says what it lost, a capture of several interfaces holds more than CAN: no findings, but worth knowing.
#[test]
fn what_a_recording_tells_besides_its_frames_is_a_note() {
    let output = run(&["decode", "--strict", &capture("candump/two.log")]);
    assert!(!stderr(&output).contains("could not be read"), "{}", stderr(&output));
    let note = format!(
        "note: {}: 4 frames were lost when it was recorded, as it says itself\n",
        capture("candump/two.log")
    );
    assert!(stderr(&output).ends_with(&note), "{}", stderr(&output));
}

#[test]
fn strict_stops_at_a_bad_line() {
    let log = "(1.000000) can0 456#014B03010301\nnonsense\n(1.000400) can0 455#\n";
    let output = run_with_input(&["decode", "--strict", "-"], log);
    assert_exit(&output, 2);
    assert_eq!(stderr(&output), "error: <stdin>:2:1: \"(\" and a time expected, \"nonsense\" found\n");
    assert_eq!(stdout(&output).lines().count(), 1, "what was read before is shown");
}

#[test]
fn what_is_no_recording_is_an_error() {
    let missing = run(&["decode", "no-such-file.log"]);
    assert_exit(&missing, 2);
    assert!(stderr(&missing).starts_with("error: no-such-file.log: No such file"), "{}", stderr(&missing));
    let manifest = run(&["decode", concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml")]);
    assert_exit(&manifest, 2);
    assert!(
        stderr(&manifest)
            .contains("not a recording: candump log or screen output, pcap, pcapng or Vector ASC")
    );
    // It holds a log, which is not what is meant.
    let scenario = run(&["decode", concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/plant.toml")]);
    assert_exit(&scenario, 2);
    assert!(stderr(&scenario).contains("`devicenet simulate`"), "{}", stderr(&scenario));
    let directory = run(&["decode", env!("CARGO_MANIFEST_DIR")]);
    assert_exit(&directory, 2);
    let expected = concat!("error: ", env!("CARGO_MANIFEST_DIR"), ": is a directory, not a recording\n");
    assert_eq!(stderr(&directory), expected);
}

#[test]
fn a_cut_off_file_shows_its_frames_and_then_fails() {
    let whole = std::fs::read(capture("socketcan.pcapng")).unwrap();
    let file = temporary("cut.pcapng");
    std::fs::write(&file, &whole[..whole.len() - 8]).unwrap();
    let output = run(&["decode", &file]);
    assert_exit(&output, 2);
    assert_eq!(stdout(&output).lines().count(), 23);
    assert!(stderr(&output).ends_with("it ends within the record after frame 23\n"));
}

/// What was read before the damage is summed up and recorded.
#[test]
fn a_cut_off_file_is_summed_up_and_recorded_and_then_fails() {
    let whole = std::fs::read(capture("socketcan.pcapng")).unwrap();
    let (file, copy) = (temporary("cut-2.pcapng"), temporary("cut-2.log"));
    std::fs::write(&file, &whole[..whole.len() - 8]).unwrap();
    let output = run(&["decode", "--summary", "--record", &copy, &file]);
    assert_exit(&output, 2);
    assert!(
        stderr(&output).starts_with(&format!("error: {file}: the file is cut off")),
        "{}",
        stderr(&output)
    );
    assert!(stdout(&output).contains(": 23 frames in "), "{}", stdout(&output));
    assert_eq!(std::fs::read_to_string(&copy).unwrap().lines().count(), 23);
    let log = "(1.000000) can0 455#01\nnonsense\n(1.000400) can0 455#\n";
    let output = run_with_input(&["decode", "--summary", "--strict", "-"], log);
    assert!(
        stdout(&output).starts_with("can0: 1 frame in 0.000 s, 0 with a problem\n"),
        "{}",
        stdout(&output)
    );
    assert!(stderr(&output).starts_with("error: <stdin>:2:1: "), "{}", stderr(&output));
}
