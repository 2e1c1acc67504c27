#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::arithmetic_side_effects,
    missing_docs
)]
//! The live commands on the simulated bus and on recordings, as a user runs them.

mod ask;
mod fields;
#[cfg(target_os = "linux")]
mod kernel;
mod load;
mod monitor;
mod record;
mod recover;
mod scan;
#[cfg(target_os = "linux")]
mod terminal;
mod tshark;
mod usage;

use std::process::{Command, Output};

/// A bus of two slaves without a master, and the command with these arguments on it.
pub(crate) fn devicenet(arguments: &[&str]) -> Run {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/live");
    let output =
        Command::new(env!("CARGO_BIN_EXE_devicenet")).args(arguments).current_dir(folder).output().unwrap();
    Run { output }
}

pub(crate) struct Run {
    output: Output,
}

impl Run {
    pub(crate) fn code(&self) -> i32 {
        self.output.status.code().unwrap()
    }

    pub(crate) fn out(&self) -> String {
        String::from_utf8(self.output.stdout.clone()).unwrap()
    }

    pub(crate) fn err(&self) -> String {
        String::from_utf8(self.output.stderr.clone()).unwrap()
    }

    /// The one line that says what is wrong, apart from notes.
    pub(crate) fn error(&self) -> String {
        let errors: Vec<String> =
            self.err().lines().filter_map(|line| line.strip_prefix("error: ")).map(str::to_owned).collect();
        assert_eq!(errors.len(), 1, "{}", self.err());
        errors.concat()
    }

    pub(crate) fn json(&self) -> Vec<serde_json::Value> {
        self.out().lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    }
}
