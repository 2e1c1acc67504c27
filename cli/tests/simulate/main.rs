//! `devicenet simulate` as a user meets it: the built program, its output, its messages, its exit codes.
#![allow(
    clippy::arithmetic_side_effects,
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test may panic"
)]

mod actions;
#[cfg(unix)]
mod interruption;
mod plant;
mod python;
mod served;
mod usage;
mod verdict;
mod views;

use std::path::PathBuf;
use std::process::{Command, Output};

use serde_json::Value;

const VALVE: &str = r#"
[bus]
duration = "3s"
[[node]]
name = "valve"
protocol = "devicenet"
role = "access"
mac = 10
quick_connect = true
identity = { vendor = 0x1234, serial = 0x00002345 }
[[node]]
name = "can0"
role = "external"
"#;

/// A file of this test only, removed at its end.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str, content: &str) -> Self {
        let path = std::env::temp_dir().join(format!("devicenet-simulate-{}-{name}", std::process::id()));
        std::fs::write(&path, content).expect("a temporary file");
        Self(path)
    }

    fn path(&self) -> &str {
        self.0.to_str().expect("a path in UTF-8")
    }

    fn read(&self) -> Vec<u8> {
        std::fs::read(&self.0).expect("it was written")
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

fn devicenet(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_devicenet")).args(arguments).output().expect("the program runs")
}

fn stdout(output: &Output) -> &str {
    core::str::from_utf8(&output.stdout).expect("UTF-8")
}

fn stderr(output: &Output) -> &str {
    core::str::from_utf8(&output.stderr).expect("UTF-8")
}

#[track_caller]
fn lines_of_json(output: &Output) -> Vec<Value> {
    stdout(output).lines().map(|line| serde_json::from_str(line).expect(line)).collect()
}
