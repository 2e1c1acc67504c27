#![allow(
    clippy::arithmetic_side_effects,
    clippy::as_conversions,
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test may panic: that is how it fails"
)]
//! DeviceNeX: devices and network access on the simulated bus.

mod access;
mod block;
mod connectionless;
mod plant;
mod silence;
