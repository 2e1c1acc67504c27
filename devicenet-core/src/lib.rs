//! DeviceNet
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(test, allow(clippy::arithmetic_side_effects, clippy::as_conversions))]

#[cfg(test)]
extern crate std;

pub mod access;
pub mod id;
pub mod message;
pub mod monitor;

pub use access::Access;
pub use id::{Identifier, MacId};
