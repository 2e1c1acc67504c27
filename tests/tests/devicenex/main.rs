#![allow(
    clippy::arithmetic_side_effects,
    clippy::as_conversions,
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test may panic: that is how it fails"
)]
//! DeviceNeX: network access, devices and their manager on the simulated bus.

mod access;
mod block;
mod connectionless;
mod manager;
mod plant;
mod silence;
mod works;
