#![cfg(target_os = "linux")]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::arithmetic_side_effects,
    clippy::indexing_slicing,
    missing_docs
)]
//! `devicenet powerlink` as a user runs it: a managing node and controlled nodes, each a process of its own, on virtual cables.
//!
//! The tests that are marked as ignored need interfaces of their own, so `cargo test` runs them by one test, `on_virtual_cables`, in a
//! network namespace that ends with it.

mod fields;
mod foreign;
mod interruption;
#[path = "../../../transport-ethernet/tests/kernel/namespace.rs"]
mod namespace;
mod network;
#[path = "../live/kernel/process.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod process;
mod rig;
mod usage;

#[test]
fn on_virtual_cables() {
    namespace::run_ignored(&["--test-threads=4"]);
}
