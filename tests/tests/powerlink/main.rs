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
//! Ethernet POWERLINK: a recording of independent nodes and our machines in the place of theirs, and whole networks with faults.

mod boot;
mod chaos;
mod edges;
mod faults;
mod losses;
mod network;
mod recorded_order;
mod recording;
mod same_number;
mod validity;
