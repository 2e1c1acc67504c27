#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(test, allow(clippy::arithmetic_side_effects, clippy::as_conversions))]
//! Ethernet POWERLINK V2 (EPSG DS 301) as pure state machines: no clock, no socket, no allocation, no `std`.

#[cfg(test)]
extern crate std;

pub mod cycle;
pub mod dictionary;
pub mod error;
pub mod ethernet;
pub mod indicator;
pub mod machine;
pub mod nmt;
pub mod node_id;
pub mod pdo;
pub mod sdo;
pub mod wire;

pub use ethernet::MacAddress;
pub use node_id::NodeId;
