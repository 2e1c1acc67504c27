#![forbid(unsafe_code)]
// Runs on a host, on data of its own making: sizes, bit counts and virtual times are far from their limits, and an
// index out of range is a defect that must stop a simulation rather than falsify it.
#![allow(clippy::arithmetic_side_effects, clippy::indexing_slicing, clippy::as_conversions)]
//! A simulated CAN bus, exact to the bit, in virtual time, with faults.
//!
//! The failures that matter on a fieldbus happen below the frame: two nodes with one identifier destroy each other's
//! frames, a node goes bus-off, a wrong bit rate stops everybody, a lone node is never acknowledged. So this bus is
//! not a queue of messages. It follows CAN 2.0 B (Bosch 1991) and ISO 11898-1 for every bit in which something can
//! differ, and takes the short way where nothing can.
//!
//! ```text
//!  Machine   Machine   Machine      any protocol, each with a clock of its own
//!     |         |         |         Input / Action
//!  mailboxes mailboxes mailboxes    the smallest arbitration key goes first
//!     |         |         |
//!  controller   |     controller    TEC, REC, error-active, error-passive, bus-off; acceptance filter
//!     |     controller    |
//!     |         |         |         drive:  1 recessive, 0 dominant
//!  ---+---------+---------+-------  wire:   AND of what all drive, then faults
//!     |         |         |         sample: each compares, destuffs, checks, acknowledges, flags
//!
//!  SOF| identifier  |RTR IDE|r0 DLC| data  | CRC-15 |del|ACK|del|  EOF  | IFS |     | SOF
//!   0 | arbitration         |      bit errors from here     ^           |     |
//!     |                     |                               |pulled by  |3 bit|+8 bit for a passive sender
//!  any error: |flag 6..12 dominant (passive: 6 recessive)|delimiter 8 recessive| IFS, and again
//! ```
//!
//! | exact | simplified |
//! |---|---|
//! | bit stuffing, CRC, length and time of every frame | no propagation delay: the wire is one point |
//! | arbitration, bit by bit, among 11 and 29 bit, data and remote frames | a frame is delivered at the end of EOF, not one bit before |
//! | bit, stuff, CRC, form and ACK errors, and in which bit each node sees them | classic CAN only |
//! | error counters, flags, delimiters, overload frames, suspend transmission | a bit rate is a whole number of nanoseconds |
//! | sampling and synchronisation where bit rates or clocks differ | clocks within 0.4 % are in step on the wire |
//!
//! # Two machines on a bus
//! ```
//! use std::convert::Infallible;
//! use std::time::Duration;
//! use link_core::{Action, BitRate, Deadline, Frame, Input, Instant, LinkEvent, Machine, TxToken, frame::standard_id};
//! use transport_mock::{BusConfig, Network, NodeConfig, Record};
//!
//! /// Asks once at power-up.
//! #[derive(Clone, Default)]
//! struct Asks { question: Option<Frame>, answer: Option<Frame> }
//!
//! impl Machine for Asks {
//!     type Event = Infallible;
//!     fn input(&mut self, _: Instant, input: Input) {
//!         match input {
//!             Input::Link(LinkEvent::Up) => self.question = Frame::new(standard_id(0x100), &[42]),
//!             Input::Frame(frame) => self.answer = Some(frame),
//!             _ => {}
//!         }
//!     }
//!     fn poll(&mut self, _: Instant) -> Option<Action<Infallible>> {
//!         Some(Action::Transmit(TxToken(0), self.question.take()?))
//!     }
//!     fn deadline(&self) -> Option<Deadline> { None }
//!     fn max_in_flight(&self) -> usize { 1 }
//! }
//!
//! /// Answers every frame with its data.
//! #[derive(Clone, Default)]
//! struct Echoes { answer: Option<Frame> }
//!
//! impl Machine for Echoes {
//!     type Event = Infallible;
//!     fn input(&mut self, _: Instant, input: Input) {
//!         if let Input::Frame(frame) = input {
//!             self.answer = Frame::new(standard_id(0x200), frame.data());
//!         }
//!     }
//!     fn poll(&mut self, _: Instant) -> Option<Action<Infallible>> {
//!         Some(Action::Transmit(TxToken(0), self.answer.take()?))
//!     }
//!     fn deadline(&self) -> Option<Deadline> { None }
//!     fn max_in_flight(&self) -> usize { 1 }
//! }
//!
//! let mut network = Network::<()>::new(BusConfig::new(BitRate::K500, 1));
//! let asks = network.add_silent(NodeConfig::named("asks"), Asks::default());
//! network.add_silent(NodeConfig::named("echoes"), Echoes::default());
//!
//! let mut trace = Vec::new();
//! network.run_until(Instant::ZERO + Duration::from_millis(1), &mut |record: &Record<'_, ()>| {
//!     if let Record::Frame(frame) = record {
//!         trace.push(format!("{:.6} {}", frame.end, frame.frame));
//!     }
//! });
//! // The controllers wait for 11 recessive bits, 22 us, and the frame has 52 bits and 2 of stuffing.
//! assert_eq!(trace, ["0.000130 100 [1] 2A", "0.000246 200 [1] 2A"]);
//! assert!(network.machine::<Asks>(asks).unwrap().answer.is_some());
//! ```

pub mod bus;
pub mod change;
pub mod ethernet;
pub mod network;
mod node;
pub mod nodes;
pub mod port;
pub mod realtime;
pub mod record;
pub mod referee;
pub mod rng;
mod timeline;

#[cfg(test)]
mod test_support;

pub use bus::{Counters, ErrorState, Fault, FaultId, Flag, Scope, Which};
pub use change::{Change, Reaction};
pub use network::{BusConfig, Network, NodeConfig, NodeId};
pub use port::{Ended, NetworkPort};
pub use record::{Ignore, Interest, Only, Record, Sink};
pub use referee::{Rule, Violation};
