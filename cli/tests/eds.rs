//! `devicenet eds` and `devicenet decode --eds` as a user meets them: the built program, its messages, its exit codes.
#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a test may panic"
)]

use std::io::Write as _;
use std::process::{Command, Output, Stdio};

use serde_json::Value;

fn file(name: &str) -> String {
    format!("{}/../tests/eds/{name}.eds", env!("CARGO_MANIFEST_DIR"))
}

fn run(arguments: &[&str], input: &[u8]) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_devicenet"))
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // The program may end before it has read all.
    let _ = child.stdin.take().unwrap().write_all(input);
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
    assert_eq!(output.status.code(), Some(code), "stdout: {}\nstderr: {}", stdout(output), stderr(output));
}

#[test]
fn a_right_file_and_one_with_notes_are_healthy() {
    let output = run(&["eds", "check", &file("block"), &file("old")], b"");
    assert_exit(&output, 0);
    assert!(stdout(&output).contains("block.eds: nothing is wrong\n"));
    assert!(stdout(&output).ends_with("old.eds: 2 notes\n"));
    assert_eq!(stderr(&output), "");
}

#[test]
fn a_finding_shows_its_line() {
    let output = run(&["eds", "check", "-"], b"[File]\n\tDescText = \"x\"\n\tRevision = 1.0;\n");
    assert_exit(&output, 1);
    let expected = "<stdin>:2:16: error[missing_semicolon]: `DescText` does not end; put a `;` here\n  |\n\
                    2 | \tDescText = \"x\"\n  | \t              ^\n";
    assert!(stdout(&output).contains(expected), "{}", stdout(&output));
}

#[test]
fn findings_can_be_allowed() {
    assert_exit(&run(&["eds", "check", &file("missing")], b""), 1);
    let output = run(&["eds", "check", "--allow", "missing_section", &file("missing")], b"");
    assert_exit(&output, 0);
    assert!(stdout(&output).ends_with("missing.eds: nothing is wrong\n"));
    let output = run(&["eds", "check", "--allow", "missing_everything", &file("missing")], b"");
    assert_exit(&output, 2);
}

#[test]
fn findings_are_objects() {
    let output = run(&["--json", "eds", "check", &file("missing")], b"");
    assert_exit(&output, 1);
    let objects: Vec<Value> =
        stdout(&output).lines().map(|line| serde_json::from_str(line).expect("an object a line")).collect();
    assert_eq!(objects.len(), 3);
    let first = &objects[0];
    assert_eq!((&first["kind"], &first["code"]), (&Value::from("finding"), &Value::from("missing_section")));
    assert_eq!(
        (&first["line"], &first["column"], &first["severity"]),
        (&1.into(), &1.into(), &"error".into())
    );
    assert_eq!((&objects[2]["kind"], &objects[2]["errors"]), (&Value::from("file"), &Value::from(2)));
}

#[test]
fn a_file_that_cannot_be_read_does_not_hide_the_others() {
    let output = run(&["eds", "check", "no-such.eds", &file("block")], b"");
    assert_exit(&output, 2);
    assert!(stderr(&output).contains("no-such.eds: "), "{}", stderr(&output));
    assert!(stdout(&output).contains("nothing is wrong"));
    assert_exit(&run(&["eds", "show", "no-such.eds"], b""), 2);
    assert_exit(&run(&["eds", "check"], b""), 2);
    assert_exit(&run(&["eds"], b""), 2);
}

#[test]
fn a_file_that_is_too_long_is_refused() {
    let output = run(&["eds", "check", "-"], &vec![b' '; 16 * 1024 * 1024 + 1]);
    assert_exit(&output, 2);
    assert!(stderr(&output).contains("too long for an EDS"), "{}", stderr(&output));
}

#[test]
fn a_file_is_shown_in_spite_of_its_findings() {
    let output = run(&["eds", "show", &file("syntax")], b"");
    assert_exit(&output, 0);
    assert!(stdout(&output).starts_with("EXAMPLE-88 (EX88)\n"), "{}", stdout(&output));
    assert!(stderr(&output).contains("which `devicenet eds check` tells"), "{}", stderr(&output));
}

#[test]
fn a_file_is_one_object() {
    let output = run(&["--json", "eds", "show", &file("block")], b"");
    assert_exit(&output, 0);
    assert_eq!(stdout(&output).lines().count(), 1);
    let object: Value = serde_json::from_str(stdout(&output)).expect("an object");
    assert_eq!(object["device"]["product_code"], 42);
    assert_eq!(object["params"][1]["scaling"]["divisor"], 10);
    assert_eq!(object["assemblies"][0]["layout"][1]["name"], "State");
    assert_eq!(object["scan_entry"]["connections"][0]["produced"]["size"], 2);
    assert_eq!(object["io_info"]["inputs"][0]["path"], "200424653003");
}

#[test]
fn json_has_numbers_that_no_machine_has() {
    let sheet =
        b"[Params]\n Param1 = 0, 0, \"\", 0, 0xC6, 1, \"Flow\", \"\", \"\", 0, 99999999999999999999999, 0;\n";
    let output = run(&["eds", "show", "--json", "-"], sheet);
    assert_exit(&output, 0);
    assert!(stdout(&output).contains("\"maximum\":99999999999999999999999"), "{}", stdout(&output));
    serde_json::from_str::<Value>(stdout(&output)).expect("an object");
}

#[test]
fn names_in_a_file_do_not_command_the_terminal() {
    let sheet = b"[Device]\n VendName = \"\x1b[2JWorks\";\n ProdName = \x1b[31mRed;\n\
        [Params]\n Param1 = 0, 0, \"\", 0, 0xC6, 1, \"\x1b[5mFlow\", \"\", \"\", 0, 9, 0;\n";
    for command in ["show", "check"] {
        let output = run(&["eds", command, "-"], sheet);
        assert!(!stdout(&output).contains('\x1b'), "{}", stdout(&output));
    }
}

#[test]
fn decode_says_which_file_is_for_nothing() {
    let log = b"(1700000006.060000) can0 455#\n(1700000006.060300) can0 3CA#8102\n";
    let output = run(&["decode", "--eds", &file("block"), "-"], log);
    assert_exit(&output, 0);
    assert!(stderr(&output).contains("names nothing in the recording"), "{}", stderr(&output));
    assert!(stderr(&output).contains("say `--eds 10="), "{}", stderr(&output));
    let output = run(&["decode", "--eds", &format!("11={}", file("block")), "-"], log);
    assert_exit(&output, 0);
    assert!(stderr(&output).ends_with("no parameter and no I/O data of node 11\n"), "{}", stderr(&output));
    let output = run(&["decode", "--eds", &format!("10={}", file("block")), "-"], log);
    assert_exit(&output, 0);
    assert!(stdout(&output).contains("[Inputs: 0x81 (IN0, IN7); State: Fault (2)]"), "{}", stdout(&output));
    assert_eq!(stderr(&output), "");
}

#[test]
fn decode_refuses_what_it_cannot_use() {
    assert_exit(&run(&["decode", "--eds", "no-such.eds", "-"], b""), 2);
    let for_ten = format!("10={}", file("block"));
    let output = run(&["decode", "--eds", &for_ten, "--eds", &for_ten, "-"], b"");
    assert_exit(&output, 2);
    assert!(stderr(&output).contains("two files for node 10"), "{}", stderr(&output));
}

/// What it is read for first would leave nothing for the others, and they would seem to be empty.
#[test]
fn standard_input_can_be_read_once() {
    for arguments in [
        &["eds", "check", "-", "-"][..],
        &["decode", "-", "--eds", "-"],
        &["decode", "-", "--eds", "10=-"],
        &["decode", "recording.log", "--eds", "-", "--eds", "10=-"],
    ] {
        let output = run(arguments, b"(1.0) can0 455#\n");
        assert_exit(&output, 2);
        let expected =
            "error: `-` is given 2 times: standard input can be read once, name files for the others\n";
        assert_eq!(stderr(&output), expected, "{arguments:?}");
    }
}

/// A path that was read of a connection is no more than that: a node that starts again has others, those of the file
/// unless they are read again.
#[test]
fn a_path_is_forgotten_when_its_node_starts_again() {
    let poll = "can0 455#\n(9.0) can0 3CA#8102\n";
    let log = format!(
        "(1.0) can0 456#014B03010301\n(1.1) can0 453#01CB00\n(1.2) {poll}\
         (2.0) can0 454#010E05020E\n(2.1) can0 453#018E200424013003\n(2.2) {poll}\
         (3.0) can0 457#00341245230000\n(3.1) can0 456#014B03010301\n(3.2) can0 453#01CB00\n(3.3) {poll}"
    );
    let output = run(&["decode", "--eds", &format!("10={}", file("block")), "-"], log.as_bytes());
    let responses: Vec<bool> = stdout(&output)
        .lines()
        .filter(|line| line.contains(" 3CA "))
        .map(|line| line.contains("State: Fault (2)"))
        .collect();
    assert_eq!(responses, [true, false, true], "{}", stdout(&output));
}

#[test]
fn what_is_no_eds_is_not_shown() {
    for (input, told) in [
        (&b""[..], "error: <stdin>: the file is empty: it is no EDS\n"),
        (b"a letter\n", "error: <stdin>: no section such as [Device] in it: it is no EDS\n"),
        (b"[ letter ]\na = b;\n", "error: <stdin>: no section such as [Device] in it: it is no EDS\n"),
    ] {
        let recording = format!("{}/../tests/captures/slave-01-startup-poll.log", env!("CARGO_MANIFEST_DIR"));
        for arguments in [
            &["eds", "show", "-"][..],
            &["eds", "show", "--json", "-"],
            &["decode", "--eds", "-", &recording],
        ] {
            let output = run(arguments, input);
            assert_exit(&output, 2);
            assert_eq!((stdout(&output), stderr(&output)), ("", told));
        }
    }
}
