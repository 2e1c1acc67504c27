#![allow(
    clippy::arithmetic_side_effects,
    clippy::as_conversions,
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test may panic: that is how it fails"
)]
//! Network access of both protocols, in every interleaving of two and three nodes, by a model checker on the real machines.

mod devicenet;
mod devicenex;
mod model;
