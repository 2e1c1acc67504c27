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
//! | [`client`] | requests to another node: connectionless, for a connection, on a connection |
//! | [`connection`] | the instances of connections, what each is by default, the identifiers that it uses |
//! | [`device`] | a node that answers requests, and consumes and produces data |
//! | [`id`] | operational addresses, the layouts of identifiers, receive filters |
//! | [`manager`] | the network manager: addresses, connections, replacement |
//! | [`message`] | the data field of every message, with its byte table |
//! | [`monitor`] | the passive decoder: what every frame on the bus means |
//!
//! A machine is told what happens as [`Input`](link_core::Input), and hands out what is to be done as
//! [`Action`](link_core::Action): see [`link_core`].
//!
//! A device in thirty lines is in the text of [`device`].
//!
//! # A device gets an address
//!
//! The bus is played by hand: two frames tell the bit rate, another node acknowledges, and a network manager sends a ROAM.
//!
//! ```
//! use devicenex_core::access::{Access, Config, Role, StateKind};
//! use devicenex_core::message::{DeviceIdentity, MiniWho, PortByte, Roam};
//! use devicenex_core::OperationalAddress;
//! use link_core::{Action, Input, Instant, LinkCommand, LinkEvent, Machine, TxOutcome};
//!
//! // A fictitious vendor: the identity is never defaulted.
//! let device = DeviceIdentity { vendor: 0x0123.into(), product_code: 0x0456, major_revision: 2, serial: 0x1122_3344 };
//! let mut node = Access::new(Config::new(device, PortByte::ZERO, Role::Device));
//! let mini_who = MiniWho { serial_low: 1 }.frame().unwrap();
//! let roam = Roam { target: device, requested: OperationalAddress::try_from(67)? }.frame().unwrap();
//!
//! let mut now = Instant::ZERO;
//! let mut trace = Vec::new();
//! let mut inputs = vec![Input::Link(LinkEvent::Up)];
//! while !node.is_online() {
//!     let input = inputs.pop().unwrap_or(Input::Tick);
//!     for action in node.handle(now, input) {
//!         match action {
//!             Action::Transmit(token, frame) => {
//!                 trace.push(format!("{now:.1} {frame}"));
//!                 inputs.push(Input::TxDone(token, TxOutcome::Sent));
//!             }
//!             Action::Link(LinkCommand::SetMode(mode)) => {
//!                 if mode.listen_only {
//!                     inputs.extend([Input::Frame(mini_who); 2]);
//!                 }
//!                 inputs.push(Input::Link(LinkEvent::ModeSet(mode)));
//!             }
//!             Action::Event(event) => trace.push(format!("{now:.1} {event}")),
//!             Action::Withdraw(_) | Action::Link(_) => {}
//!         }
//!     }
//!     if node.state().kind() == StateKind::Standby {
//!         inputs.push(Input::Frame(roam));
//!     } else if inputs.is_empty() {
//!         now = node.deadline().map_or(now, |deadline| deadline.at);
//!     }
//! }
//! assert_eq!(trace, [
//!     "0.0 NonExistent -> DetectingBitRate: link up",
//!     "0.0 bit rate 500 kbit/s",
//!     "0.0 DetectingBitRate -> Hello1: bit rate locked",
//!     "0.0 1FFE4433 [8] 22 11 23 01 56 04 02 00",
//!     "1.0 Hello1 -> Hello2: wait over",
//!     "1.0 1FFE4433 [8] 22 11 23 01 56 04 02 00",
//!     "2.0 Hello2 -> Standby: wait over",
//!     "2.0 OA 67 assigned",
//!     "2.0 Standby -> Hello1: ROAM",
//!     "2.0 1F864433 [8] 22 11 23 01 56 04 02 00",
//!     "3.0 Hello1 -> Hello2: wait over",
//!     "3.0 1F864433 [8] 22 11 23 01 56 04 02 00",
//!     "4.0 Hello2 -> Online: wait over",
//! ]);
//! # Ok::<(), devicenex_core::id::InvalidAddress>(())
//! ```
//!
//! # Limits
//!
//! Two devices without an address that share the low half of their serial number collide, and a ROAM does not tell its
//! sender: both are the paper's, see [`Identifier::sender`]. A DeviceNet node and a DeviceNeX connection with 11 bits would share identifiers:
//! they do not belong on one bus.
//!
//! # Features
//!
//! All are additive. `serde` serialises identifiers, messages and counters; `defmt` formats them on embedded loggers;
//! `std` passes itself on to the dependencies.

#[cfg(test)]
extern crate std;

pub mod access;
pub mod bit_rate;
pub mod client;
pub mod connection;
mod counter;
pub mod device;
pub mod id;
mod link_object;
pub mod manager;
pub mod message;
pub mod monitor;

pub use access::Access;
pub use device::Device;
pub use id::{Identifier, OperationalAddress};
