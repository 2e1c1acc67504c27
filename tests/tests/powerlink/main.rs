#![allow(
    clippy::arithmetic_side_effects,
    clippy::as_conversions,
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used,
    missing_docs,
    reason = "tests panic to fail"
)]
//! Ethernet POWERLINK: a recording of independent nodes, and our node in the place of theirs.

mod boot;
mod network;
mod recording;
