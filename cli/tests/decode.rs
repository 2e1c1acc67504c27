//! `devicenet decode` as a user meets it: the built program, its output, its messages, its exit codes.
#![allow(
    clippy::arithmetic_side_effects,
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test may panic"
)]

use std::io::{BufRead as _, BufReader, Write as _};
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

use serde_json::Value;

fn capture(name: &str) -> String {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../tests/captures").join(name);
    path.to_str().expect("a path in UTF-8").to_owned()
}

fn devicenet(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_devicenet"));
    command.args(arguments).env_remove("NO_COLOR").env_remove("CLICOLOR_FORCE");
    command
}

fn run(arguments: &[&str]) -> Output {
    devicenet(arguments).output().unwrap()
}

/// Runs with a recording on standard input.
fn run_with_input(arguments: &[&str], input: &str) -> Output {
    let mut child = devicenet(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(input.as_bytes()).unwrap();
    child.wait_with_output().unwrap()
}

fn stdout(output: &Output) -> &str {
    str::from_utf8(&output.stdout).unwrap()
}

fn stderr(output: &Output) -> &str {
    str::from_utf8(&output.stderr).unwrap()
}

#[track_caller]
fn assert_exit(output: &Output, code: i32) {
    assert_eq!(output.status.code(), Some(code), "stderr: {}", stderr(output));
}

fn json_lines(output: &Output) -> Vec<Value> {
    stdout(output)
        .lines()
        .map(|line| serde_json::from_str(line).unwrap_or_else(|e| panic!("{e}: {line}")))
        .collect()
}

const CAPTURES: [&str; 12] = [
    "bei-mhk5-cos.log",
    "candump-L-mixed.log",
    "candump-ta.txt",
    "icpdas-can8124-poll.log",
    "icpdas-i7242d-cyclic.log",
    "inficon-get-set-assembly-path.log",
    "mks-baratron-explicit.log",
    "session-two-slaves-on-vcan.log",
    "slave-01-startup-poll.log",
    "slave-04-fragmented-response.log",
    "socketcan-le-usec.pcap",
    "socketcan.pcapng",
];

#[test]
fn every_capture_gives_a_line_and_an_object_for_each_frame() {
    for name in CAPTURES {
        let text = run(&["decode", &capture(name)]);
        let json = run(&["decode", "--json", &capture(name)]);
        let objects = json_lines(&json);
        assert_eq!(stdout(&text).lines().count(), objects.len(), "{name}");
        assert_eq!(text.status.code(), json.status.code(), "{name}");
        assert_eq!(stderr(&text), "", "{name}");
        assert!(stdout(&text).lines().all(|line| line.contains("  | ")), "{name}");
        for (object, n) in objects.iter().zip(1u64..) {
            let object = object.as_object().unwrap();
            let first: Vec<_> = object.keys().collect();
            for field in ["t", "n", "id", "ext", "rtr", "dlc", "data"] {
                assert!(object.contains_key(field), "{name}: {field} is missing in {first:?}");
            }
            assert_eq!(object["n"], n, "{name}");
        }
    }
}

#[test]
fn json_keeps_every_digit_of_the_time() {
    let output = run(&["decode", "--json", &capture("slave-01-startup-poll.log")]);
    let first = stdout(&output).lines().next().unwrap();
    let start =
        r#"{"t":1700000002.500300,"n":1,"id":1111,"ext":false,"rtr":false,"dlc":7,"data":"00341245230000","#;
    assert!(first.starts_with(start), "{first}");
}

#[test]
fn formats_of_the_same_traffic_decode_to_the_same_words() {
    let lines = |name| {
        let output = run(&["decode", &capture(name)]);
        stdout(&output).lines().take(20).map(str::to_owned).collect::<Vec<_>>()
    };
    let log = lines("slave-01-startup-poll.log");
    assert_eq!(lines("candump-ta.txt"), log);
    assert_eq!(lines("socketcan-le-usec.pcap"), log);
    assert_eq!(lines("socketcan.pcapng"), log);
}

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
    let directory = run(&["decode", env!("CARGO_MANIFEST_DIR")]);
    assert_exit(&directory, 2);
}

#[test]
fn a_cut_off_file_shows_its_frames_and_then_fails() {
    let whole = std::fs::read(capture("socketcan.pcapng")).unwrap();
    let file = temporary("cut.pcapng");
    std::fs::write(&file, &whole[..whole.len() - 8]).unwrap();
    let output = run(&["decode", &file]);
    assert_exit(&output, 2);
    assert_eq!(stdout(&output).lines().count(), 23);
    assert!(stderr(&output).ends_with("the file is cut off: it ends within the record after frame 23\n"));
}

#[test]
fn wrong_usage_exits_with_2() {
    for arguments in [
        &["decode"][..],
        &["decode", "--mac", "64", "x"],
        &["decode", "--protocol", "profibus", "x"],
        &["decode", "--bit-rate", "fast", "x"],
        &["no-such-command"],
    ] {
        assert_exit(&run(arguments), 2);
    }
}

#[test]
fn help_of_every_command_has_an_example() {
    for arguments in [&["--help"][..], &["decode", "--help"]] {
        let output = run(arguments);
        assert_exit(&output, 0);
        let text = stdout(&output);
        assert!(text.contains("Example") && text.contains("  devicenet decode "), "{text}");
        assert!(text.contains("Exit codes:"), "{text}");
    }
}

/// The reader has seen enough: no message, no failure.
#[test]
fn a_closed_pipe_ends_quietly() {
    let file = temporary("long.log");
    let log: String =
        (0..50_000).map(|n| format!("({}.{:06}) can0 455#0102\n", n / 1000, n % 1000 * 1000)).collect();
    std::fs::write(&file, log).unwrap();
    let mut child =
        devicenet(&["decode", &file]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut reader = BufReader::new(child.stdout.take().unwrap());
    reader.read_line(&mut String::new()).unwrap();
    drop(reader);
    let output = child.wait_with_output().unwrap();
    assert_eq!(stderr(&output), "");
    assert_exit(&output, 0);
}

/// `candump -L can0 | devicenet decode -` shows a frame when it comes, not when a buffer is full.
#[test]
fn a_live_pipe_is_shown_at_once() {
    let mut child = devicenet(&["decode", "-"]).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let mut input = child.stdin.take().unwrap();
    let mut reader = BufReader::new(child.stdout.take().unwrap());
    for n in 0..3 {
        input.write_all(format!("({n}.000000) can0 455#0{n}\n").as_bytes()).unwrap();
        let mut line = String::new();
        reader.read_line(&mut line).unwrap();
        assert!(line.contains(&format!("455  0{n} ")), "{line}");
    }
    drop(input);
    assert!(child.wait().unwrap().code().is_some());
}

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
    let output = run(&["decode", "--record", &file, &file]);
    assert_exit(&output, 2);
    assert_eq!(std::fs::read_to_string(&file).unwrap(), original);
}

/// A path for this test process only.
fn temporary(name: &str) -> String {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("decode-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder.join(name).to_str().expect("a path in UTF-8").to_owned()
}
