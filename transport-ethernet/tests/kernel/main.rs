#![cfg(target_os = "linux")]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::arithmetic_side_effects,
    clippy::indexing_slicing,
    missing_docs
)]
//! The port on virtual cables of the kernel.
//!
//! The tests of the modules need interfaces of their own, so `cargo test` runs them by one test, `on_virtual_cables`, in a network
//! namespace that ends with it.

mod frames;
mod late;
mod link;
mod namespace;
mod rig;

#[test]
fn on_virtual_cables() {
    namespace::run_ignored(&[]);
}
