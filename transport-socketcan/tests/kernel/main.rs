#![cfg(target_os = "linux")]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::arithmetic_side_effects,
    clippy::indexing_slicing,
    missing_docs
)]
//! The port on CAN interfaces of a real kernel.
//!
//! The tests of the modules need `vcan` and the right to make interfaces, so `cargo test` runs them by one test of its own,
//! `on_a_real_kernel`: in a user-mode kernel that `scripts/can-kernel` boots.

mod at_once;
mod bus;
mod errors;
mod frames;
mod interface;
mod late_echo;
mod queue;
mod rig;
mod slcan;

use std::path::Path;
use std::process::{Command, Stdio};

/// Every test of this program that is marked as ignored, with interfaces.
#[test]
fn on_a_real_kernel() {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scripts/can-kernel");
    let check = Command::new(&script).arg("--ready").stdin(Stdio::null()).output().expect("the script runs");
    if !check.status.success() {
        let why = String::from_utf8_lossy(&check.stderr).trim().to_owned();
        assert!(std::env::var_os("DEVICENET_REQUIRE_CAN_KERNEL").is_none(), "no kernel with CAN: {why}");
        eprintln!("SKIPPED: the tests on a real kernel: {why}");
        return;
    }
    // Once as a virtual interface is, once with the echo of a frame behind the transmit queue, where hardware has it.
    run(&script, &[], &["--skip", "late_echo::"]);
    run(&script, &["--echo"], &["--skip", "at_once::"]);
}

fn run(script: &Path, kernel: &[&str], tests: &[&str]) {
    let run = Command::new(script)
        .args(kernel)
        .arg("--")
        .arg(std::env::current_exe().expect("this program"))
        .args(["--ignored", "--test-threads=1"])
        .args(tests)
        .stdin(Stdio::null())
        .output()
        .expect("the script runs");
    let (out, err) = (String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
    println!("{out}{err}");
    assert!(run.status.success(), "{}", run.status);
    assert!(!out.contains(" 0 passed"), "nothing ran");
}
