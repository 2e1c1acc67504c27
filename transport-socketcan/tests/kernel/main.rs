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

mod adapter;
mod at_once;
mod bus;
mod errors;
mod frames;
mod interface;
mod late_echo;
mod queue;
mod real_kernel;
mod rig;
mod slcan;

/// Once as a virtual interface is, once with the echo of a frame behind the transmit queue, where hardware has it.
#[test]
fn on_a_real_kernel() {
    real_kernel::run_ignored(&[
        (&[], &["--test-threads=1", "--skip", "late_echo::"]),
        (&["--echo"], &["--test-threads=1", "--skip", "at_once::"]),
    ]);
}
