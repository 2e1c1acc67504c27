#![allow(
    clippy::arithmetic_side_effects,
    clippy::as_conversions,
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test may panic: that is how it fails"
)]
//! DeviceNet: golden vectors, captures, traces of networks.

mod access;
mod captures;
mod harness;
mod line;
mod monitored;
mod networks;
mod robustness;
mod vectors;
mod wire;
mod worked;
