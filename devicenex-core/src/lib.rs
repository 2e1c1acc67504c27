#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(test, allow(clippy::arithmetic_side_effects, clippy::as_conversions))]
//! DeviceNeX, DeviceNet over 29-bit identifiers, as pure state machines: no clock, no socket, no allocation, no `std`.
//!
//! DeviceNeX comes from one paper: K. H. Tang and R. McLaughlin, *The Feasibility Study of DeviceNet over Extended CAN*
//! (University of Warwick). It has no other public definition, and the paper leaves much open. What stands in these pages
//! is therefore marked:
//!
//! | mark | meaning |
//! |---|---|
//! | **\[P\]** | the paper says so |
//! | **\[R\]** | our reading of a passage that is ambiguous or garbled |
//! | **\[D\]** | our decision where the paper is silent: the *profile* of this crate |
//!
//! | module | what |
//! |---|---|
//! | [`access`] | network access: Hello, Mini-who, ROAM, who keeps an address |
//! | [`bit_rate`] | bit rate detection without a word |
//! | [`id`] | operational addresses, the layouts of identifiers, receive filters |
//! | [`message`] | the data field of every message, with its byte table |
//!
//! # Features
//!
//! All are additive. `serde` serialises identifiers, messages and counters; `defmt` formats them on embedded loggers;
//! `std` passes itself on to the dependencies.

#[cfg(test)]
extern crate std;

pub mod access;
pub mod bit_rate;
pub mod id;
pub mod message;

pub use access::Access;
pub use id::{Identifier, OperationalAddress};
