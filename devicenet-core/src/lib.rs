#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(test, allow(clippy::arithmetic_side_effects, clippy::as_conversions))]
//! DeviceNet (CIP on CAN) as pure state machines: no clock, no socket, no allocation, no `std`.
//!
//! | module | what |
//! |---|---|
//! | [`id`] | MAC IDs, the 2048 identifiers, receive filters |
//! | [`message`] | the data field of every message, with its byte table |
//! | [`access`] | network access: the duplicate MAC ID check, bus-off, the offline connection set of a faulted node |
//! | [`client`] | the explicit client: requests, fragments, time-outs, responses |
//! | [`doctor`] | health rules over the monitor: what is wrong, since when, why, and what to check next |
//! | [`master`] | the scanner: brings slaves up, polls them, brings them back |
//! | [`monitor`] | the passive decoder: it learns connections from the traffic and says what each frame means |
//! | [`slave`] | the slave: Group 2 Only server, or server with the UCMM |
//! | [`tool`] | the offline recovery tool: finds faulted nodes and gives them a MAC ID |
//!
//! A machine is told what happens as [`Input`](link_core::Input), and hands out what is to be done as
//! [`Action`](link_core::Action): see [`link_core`]. What drives it is a transport: a simulated bus, SocketCAN, a
//! microcontroller's CAN driver, or a test that plays the bus by hand.
//!
//! # A node gets on line
//!
//! The bus is played by hand: another node acknowledges each request, and nobody objects.
//!
//! ```
//! use core::time::Duration;
//! use devicenet_core::access::{Access, AccessEvent, Config, StateKind};
//! use devicenet_core::message::{DeviceIdentity, PortNumber};
//! use devicenet_core::MacId;
//! use link_core::{Action, Input, Instant, LinkEvent, Machine, TxOutcome};
//!
//! // A fictitious vendor: the identity is never defaulted.
//! let device = DeviceIdentity { vendor: 0x1234.into(), serial: 0x0000_2345 };
//! let mut node = Access::new(Config::new(device, PortNumber::ZERO, MacId::try_from(37)?));
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
//!             Action::Event(event) => trace.push(format!("{now:.1} {event}")),
//!             Action::Withdraw(_) | Action::Link(_) => {}
//!         }
//!     }
//!     if inputs.is_empty() {
//!         now = node.deadline().map_or(now, |deadline| deadline.at);
//!     }
//! }
//! assert_eq!(trace, [
//!     "0.0 NonExistent -> SendingDupMac: link up",
//!     "0.0 52F [7] 00 34 12 45 23 00 00",
//!     "0.0 SendingDupMac -> WaitingDupMac: request sent",
//!     "1.0 WaitingDupMac -> SendingDupMac: wait over",
//!     "1.0 52F [7] 00 34 12 45 23 00 00",
//!     "1.0 SendingDupMac -> WaitingDupMac: request sent",
//!     "2.0 WaitingDupMac -> OnLine: wait over",
//! ]);
//! # Ok::<(), devicenet_core::id::InvalidMacId>(())
//! ```
//!
//! # The same on a real bus
//!
//! That loop exists: [`link_core::drive()`] runs a machine on a [`Port`](link_core::Port). With its feature
//! `embedded-can`, link-core makes a port of any `embedded_can` driver.
//!
//! ```
//! use core::ops::ControlFlow;
//! use devicenet_core::MacId;
//! use devicenet_core::access::{Access, AccessEvent, NetworkStatus};
//! use link_core::{Port, drive};
//!
//! # fn show(_: NetworkStatus) {}
//! # fn store(_: MacId) {}
//! /// Returns when the port fails for good.
//! fn run<P: Port>(node: &mut Access, port: &mut P) -> P::Error {
//!     let ended = drive(node, port, |node, _now, event| {
//!         match event {
//!             AccessEvent::StateChanged { .. } | AccessEvent::Identify { .. } => show(node.network_status()),
//!             // A tool repaired the node: it must know its MAC ID after the next power cycle.
//!             AccessEvent::MacIdAssigned { to, .. } => store(to),
//!             _ => {}
//!         }
//!         ControlFlow::<core::convert::Infallible>::Continue(())
//!     });
//!     match ended {
//!         Err(error) => error,
//!     }
//! }
//! ```
//!
//! # A loop of one's own
//!
//! While [`drive`](link_core::drive()) runs, only an event leads to the machine. A slave whose inputs are sampled, or one
//! that tells no events, is driven by [`drain`](link_core::drain), which is what that loop does between two waits:
//!
//! ```
//! use core::convert::Infallible;
//! use core::ops::ControlFlow;
//! use core::time::Duration;
//! # use cip_core::message::AllocationChoice;
//! # use cip_core::identity::DeviceIdentity;
//! # use cip_core::object::Identity;
//! # use devicenet_core::slave::{Application, IoKind, PollOnly};
//! use devicenet_core::slave::{Event, Group2OnlyServer};
//! use link_core::{Deadline, Machine, Port, drain};
//!
//! # #[derive(Clone, PartialEq, Eq, Hash, Debug)]
//! # struct Block { device: DeviceIdentity, inputs: [u8; 1], outputs: [u8; 1] }
//! # impl Application for Block {
//! #     const IO: AllocationChoice = AllocationChoice::POLL;
//! #     type Long = PollOnly;
//! #     fn identity(&self) -> Identity<'_> { Identity::new(&self.device) }
//! #     fn produced(&self, _: IoKind) -> &[u8] { &self.inputs }
//! #     fn consumed(&mut self, _: IoKind) -> &mut [u8] { &mut self.outputs }
//! # }
//! # struct Pins;
//! # impl Pins { fn read(&self) -> u8 { 0 } fn write(&mut self, _: u8) {} }
//! # fn note(_: Event) {}
//! type Slave = Group2OnlyServer<Block>; // `Block`: one byte in, one byte out, by poll
//!
//! /// Returns when the port fails for good.
//! fn run<P: Port>(slave: &mut Slave, port: &mut P, pins: &mut Pins) -> Result<Infallible, P::Error> {
//!     let mut on_event = |_: &mut Slave, _now, event| {
//!         note(event);
//!         ControlFlow::<Infallible>::Continue(())
//!     };
//!     let mut now = port.now();
//!     loop {
//!         let ControlFlow::Continue(()) = drain(slave, port, now, &mut on_event)?;
//!         // The bus may be silent. A tick that the slave has not asked for changes nothing.
//!         let sample = Deadline { at: now + Duration::from_millis(10), why: "inputs to sample" };
//!         let input;
//!         (now, input) = port.wait(Deadline::earlier(slave.deadline(), Some(sample)))?;
//!         slave.input(now, input);
//!         pins.write(slave.application().outputs[0]);
//!         // After the input: if that was a poll command, the response already has this sample.
//!         slave.application_mut().inputs = [pins.read()];
//!     }
//! }
//! ```
//!
//! # What the bus may do to it
//!
//! Any frame, in any state, at any time: nothing panics, nothing is allocated, and the work for one input is bounded. A
//! malformed frame is a counter and a typed event; a command that cannot be carried out is a typed error. Machines are
//! `Clone + Eq + Hash`, so that the real code can be model-checked.
//!
//! # Features
//!
//! All are additive. `serde` serialises identifiers, messages and counters; `defmt` formats them on embedded loggers;
//! `std` passes itself on to the dependencies.
//!
//! # Sources
//!
//! The layouts and rules follow the ODVA CIP Networks Library, Vol. 3 (DeviceNet Adaptation of CIP), as far as public
//! material tells them: articles, manuals of devices, recordings. Each type names where its layout comes from, and what
//! that material leaves open is a documented default in [`access::Config`]. Only the test of ODVA can show that a
//! device conforms; this crate claims nothing of the kind.

#[cfg(test)]
extern crate std;

pub mod access;
pub mod client;
mod collision;
mod counter;
pub mod doctor;
pub mod id;
pub mod master;
pub mod message;
pub mod monitor;
pub mod slave;
pub mod tool;

pub use access::Access;
pub use id::{Identifier, MacId};
