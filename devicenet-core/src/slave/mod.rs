//! The slave: a Group 2 Only server, or a server that has the UCMM as well.
//!
//! A master allocates connections of the predefined set through the unconnected port (or through an explicit connection
//! that it opened before), configures them, and exchanges data:
//!
//! ```text
//! 0x406 + 8s   Allocate: explicit     --->              instance 1 established
//! 0x404 + 8s   Allocate: poll         --->              instance 2 configuring
//! 0x404 + 8s   set EPR of instance 2  --->              instance 2 established
//! 0x405 + 8s   poll command           --->   <--- 0x3C0 + s   poll response
//! ```
//!
//! [`Slave`] is the whole of it: [network access](crate::access), the unconnected ports, explicit messages with their
//! fragments, the objects Identity, DeviceNet, Connection and Acknowledge Handler, all I/O connections of the predefined
//! set, indicators, heartbeat. What makes it a device is its [`Application`].
//!
//! # A complete slave
//!
//! Two bytes in, one byte out, by poll. The bus is played by hand: MAC ID 4 is the master.
//!
//! ```
//! use cip_core::code::{DeviceType, VendorId};
//! use cip_core::identity::{DeviceIdentity, ProductName, Revision};
//! use cip_core::message::AllocationChoice;
//! use cip_core::object::Identity;
//! use devicenet_core::MacId;
//! use devicenet_core::slave::{Application, Config, Group2OnlyServer, IoKind};
//!
//! #[derive(Clone, PartialEq, Eq, Hash, Debug)]
//! struct Block {
//!     device: DeviceIdentity,
//!     inputs: [u8; 2],
//!     outputs: [u8; 1],
//! }
//!
//! impl Application for Block {
//!     const IO: AllocationChoice = AllocationChoice::POLL;
//!     type Long = (); // no I/O message is longer than a frame
//!
//!     fn identity(&self) -> Identity<'_> {
//!         Identity::new(&self.device)
//!     }
//!     fn produced(&self, _: IoKind) -> &[u8] {
//!         &self.inputs
//!     }
//!     fn consumed(&mut self, _: IoKind) -> &mut [u8] {
//!         &mut self.outputs
//!     }
//! }
//!
//! // A fictitious vendor. Use the one that ODVA assigned to you.
//! let device = DeviceIdentity {
//!     vendor: VendorId(0x03E7),
//!     device_type: DeviceType::GENERAL_PURPOSE_DISCRETE_IO,
//!     product_code: 42,
//!     revision: Revision::new(1, 1).ok_or("revision")?,
//!     serial: 0x1122_3344,
//!     name: ProductName::new("Example Block").ok_or("name")?,
//! };
//! let config = Config::new(&device, MacId::DEFAULT);
//! let block = Block { device, inputs: [0x34, 0x12], outputs: [0] };
//! let mut slave: Group2OnlyServer<Block> = Group2OnlyServer::new(config, block)?;
//! # use link_core::{Action, Frame, Input, Instant, LinkEvent, Machine, TxOutcome, frame::standard_id};
//! #
//! # let mut now = Instant::ZERO;
//! # let mut sent = Vec::new();
//! # let mut tell = |slave: &mut Group2OnlyServer<Block>, now: Instant, input: Input| {
//! #     let mut inputs = vec![input];
//! #     while let Some(input) = inputs.pop() {
//! #         for action in slave.handle(now, input) {
//! #             if let Action::Transmit(token, frame) = action {
//! #                 sent.push(frame.to_string());
//! #                 inputs.push(Input::TxDone(token, TxOutcome::Sent));
//! #             }
//! #         }
//! #     }
//! # };
//! # tell(&mut slave, now, Input::Link(LinkEvent::Up));
//! # while !slave.access().is_online() {
//! #     now = slave.deadline().ok_or("stuck")?.at;
//! #     tell(&mut slave, now, Input::Tick);
//! # }
//!
//! // Power-up, two seconds, and then what the master sends:
//! for (id, data) in [
//!     (0x5FE, &[0x04, 0x4B, 0x03, 0x01, 0x03, 0x04][..]), // Allocate: explicit and poll
//!     (0x5FC, &[0x04, 0x10, 0x05, 0x02, 0x09, 0x4B, 0x00]), // EPR of poll: 75 ms
//!     (0x5FD, &[0x03]), // poll
//! ] {
//!     // Here a transport would deliver the frame; see `link_core::drive`.
//! #   tell(&mut slave, now, Input::Frame(Frame::new(standard_id(id), data).ok_or("frame")?));
//! }
//! assert_eq!(sent, [
//!     "5FF [7] 00 E7 03 44 33 22 11",
//!     "5FF [7] 00 E7 03 44 33 22 11",
//!     "5FB [3] 04 CB 00",
//!     "5FB [4] 04 90 50 00", // 80 ms are used
//!     "3FF [2] 34 12",
//! ]);
//! assert_eq!(slave.application().outputs, [0x03]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Time
//!
//! With an expected packet rate (EPR) of 80 ms a connection times out after four times that, 320 ms; for its first message
//! it has at least 10 s. The explicit connection begins with an EPR of 2500 ms: it ends 10 s after its last message, and
//! the I/O goes on. A connection whose EPR is 0 never times out.
//!
//! # Cost
//!
//! Code for connections that [`Application::IO`] does not offer falls away, that for what [`Application::PARTS`] leaves out,
//! the memory and the code for long I/O messages with `type Long = ()`, the memory for other connections than poll with
//! `type Long = PollOnly`, and everything about the UCMM in a [`Group2OnlyServer`].
//!
//! # Decisions where the literature is silent
//!
//! | Situation | What happens |
//! |---|---|
//! | a poll command comes while the response to an earlier one waits for its turn | one response serves both; counted in [`Counters::merged`] |
//! | an I/O frame is given back unsent | it is lost, as on the bus: the next message has newer data |
//! | a response in one frame is given back unsent | it is lost: the client asks again |
//! | a fragment of a response is given back unsent | it is sent again after the acknowledge time |
//! | a request comes while the response to an earlier one waits for its turn | the earlier response is dropped, the later request answered |
//! | more than three unconnected requests at once | the fourth is ignored: no request is carried out whose answer would be lost |
//! | a Release or Delete of the connection that carried it | the connection is gone at once, its response still goes out |
//! | poll is allocated where instance 2 is there for change of state already | instance 2 keeps its state, and answers with data from then on |
//! | poll is released while change of state remains | instance 2 stays, and acknowledges without data |
//! | a request comes after a Reset or a new MAC ID was accepted | ignored: the node is leaving |
//! | the network is lost before the response to a Reset was sent | the reset is carried out all the same |
//! | a client opens a connection with identifiers that it has in use | the older connection is closed |

mod allocation;
mod application;
mod bit_rate;
mod broadcast;
mod config;
mod connection_object;
mod connection_view;
mod construct;
mod departure;
mod detection;
mod devicenet_object;
mod dynamic;
mod event;
mod explicit;
mod fast_get;
mod follow;
mod indicator;
mod io;
mod lines;
mod machine;
mod node;
mod output;
mod own;
mod ownership;
mod server;
#[cfg(test)]
mod tests;
mod timer;
mod transfer;
mod ucmm;
mod unconnected;
mod watchdog;

pub use application::{Application, End, IoKind, IoMode, Parts};
pub use bit_rate::{BIT_RATES, BitRateConfig};
pub use config::{Config, Options};
pub use construct::InvalidSlave;
pub use devicenet_object::{Diagnostics, Switches};
pub use event::{Counters, Event, Ignored, SlaveEvent};
pub use indicator::{ModuleStatus, combined_status};
pub use io::{Fragmented, LongMessages, PollOnly};
pub use machine::{Group2OnlyServer, Slave};
