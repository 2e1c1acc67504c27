//! What must come out of the model of the bus, named as it is described.
#![allow(
    clippy::arithmetic_side_effects,
    clippy::indexing_slicing,
    clippy::as_conversions,
    clippy::unwrap_used
)]

mod arbitration;
mod commands;
mod confinement;
mod differential;
mod faults;
mod harness;
mod letter;
mod nodes;
mod rates;
mod referee;
mod segments;
