//! `devicenet decode` as a user meets it: the built program, its output, its messages, its exit codes.
#![allow(
    clippy::arithmetic_side_effects,
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test may panic"
)]

mod copy;
mod damage;
mod frames;
mod nex;
mod pcapng;
mod powerlink;
mod powerlink_losses;
mod powerlink_tshark;
mod selection;
mod summary;
#[path = "../live/tshark.rs"]
mod tshark;
mod usage;

use std::io::ErrorKind::BrokenPipe;
use std::io::Write as _;
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
    let written = child.stdin.take().unwrap().write_all(input.as_bytes());
    // A command that refuses its arguments may end before it has read anything.
    assert!(written.as_ref().map_or_else(|error| error.kind() == BrokenPipe, |()| true), "{written:?}");
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

/// A path for this test process only.
fn temporary(name: &str) -> String {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("decode-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder.join(name).to_str().expect("a path in UTF-8").to_owned()
}
