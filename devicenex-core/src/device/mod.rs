//! The device: a node that answers requests, and consumes and produces data.
//!
//! Whoever wants something of it, a network manager or another device, needs one request and one response **\[P\]**; there is no
//! master:
//!
//! ```text
//! 0x1D8602tt   Connection request: instance 7, EPR 500   --->
//!                                   <---   0x1D0386tt   Connection response
//!                                   <---   0x00860007   data, to everybody that consumes them
//! ```
//!
//! [`Device`] is the whole of it: [network access](crate::access), the connectionless server, the connection request server,
//! explicit messages with their fragments, all kinds of implicit [connections](crate::connection), the objects Identity,
//! Message Router, link object, Connection and Acknowledge Handler. What makes it a device is its [`Application`].
//!
//! # A complete device
//!
//! Two bytes in, one byte out. The bus is played by hand: OA 1 is the network manager.
//!
//! ```
//! use cip_core::code::{DeviceType, VendorId};
//! use cip_core::identity::{DeviceIdentity, ProductName, Revision};
//! use cip_core::object::Identity;
//! use devicenex_core::access::Role;
//! use devicenex_core::device::{Application, Config, Device};
//! use devicenex_core::message::{ConnectionInstance, PortByte};
//!
//! #[derive(Clone, PartialEq, Eq, Hash, Debug)]
//! struct Block {
//!     device: DeviceIdentity,
//!     inputs: [u8; 2],
//!     outputs: [u8; 1],
//! }
//!
//! impl Application for Block {
//!     type Long = (); // no implicit message is longer than a frame
//!
//!     fn identity(&self) -> Identity<'_> {
//!         Identity::new(&self.device)
//!     }
//!     fn produced(&self, _: ConnectionInstance) -> &[u8] {
//!         &self.inputs
//!     }
//!     fn consumed(&mut self, _: ConnectionInstance) -> &mut [u8] {
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
//! let config = Config::new(&device, PortByte::ZERO, Role::Device);
//! let block = Block { device, inputs: [0x34, 0x12], outputs: [0] };
//! let mut node = Device::<Block, 32, 4>::new(config, block)?;
//! # use link_core::{Action, Frame, Input, Instant, LinkCommand, LinkEvent, Machine, TxOutcome, frame::extended_id};
//! #
//! # let mut now = Instant::ZERO;
//! # let mut sent = Vec::new();
//! # let mini_who = Frame::remote(extended_id(0x1FFE_0001), 8).ok_or("frame")?;
//! # let mut tell = |node: &mut Device<Block, 32, 4>, now: Instant, input: Input| {
//! #     let mut inputs = vec![input];
//! #     while let Some(input) = inputs.pop() {
//! #         for action in node.handle(now, input) {
//! #             match action {
//! #                 Action::Transmit(token, frame) => {
//! #                     sent.push(frame.to_string());
//! #                     inputs.push(Input::TxDone(token, TxOutcome::Sent));
//! #                 }
//! #                 Action::Link(LinkCommand::SetMode(mode)) => {
//! #                     if mode.listen_only {
//! #                         inputs.extend([Input::Frame(mini_who); 2]);
//! #                     }
//! #                     inputs.push(Input::Link(LinkEvent::ModeSet(mode)));
//! #                 }
//! #                 _ => {}
//! #             }
//! #         }
//! #     }
//! # };
//! # tell(&mut node, now, Input::Link(LinkEvent::Up));
//! # while node.access().state().kind() != devicenex_core::access::StateKind::Standby {
//! #     now = node.deadline().ok_or("stuck")?.at;
//! #     tell(&mut node, now, Input::Tick);
//! # }
//! # let roam = Frame::new(extended_id(0x1EFE_4433), &[0x22, 0x11, 0xE7, 0x03, 0x2A, 0x00, 0x01, 67]).ok_or("frame")?;
//! # tell(&mut node, now, Input::Frame(roam));
//! # while !node.access().is_online() {
//! #     now = node.deadline().ok_or("stuck")?.at;
//! #     tell(&mut node, now, Input::Tick);
//! # }
//!
//! // Bit rate, Hello, and a ROAM to OA 67; and then what the manager sends:
//! for (id, data) in [
//!     (0x1D86_0200, &[0x4B, 0xC0, 0x07, 0x00, 0x00, 0x00, 0x00][..]), // multicast, producing
//!     (0x1D86_0201, &[0x4B, 0xC2, 0x03, 0x00, 0x64, 0x00, 0x00]), // polled, EPR 100 ms, Message ID 2
//!     (0x0202_C303, &[0x03]), // poll
//!     (0x1C86_0202, &[0x0E, 0x01, 0x01, 0x06]), // serial number, without a connection
//! ] {
//!     // Here a transport would deliver the frame; see `link_core::drive`.
//! #   tell(&mut node, now, Input::Frame(Frame::new(extended_id(id), data).ok_or("frame")?));
//! }
//! # let sent: Vec<_> = sent.split_off(4);
//! assert_eq!(sent, [
//!     "00860007 [2] 34 12",
//!     "1D038600 [5] 4B C0 00 00 00",
//!     "1D038601 [5] 4B C2 00 64 00",
//!     "02860003 [2] 34 12",
//!     "1C038602 [5] 8E 44 33 22 11",
//! ]);
//! assert_eq!(node.application().outputs, [0x03]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Time
//!
//! With an expected packet rate (EPR) of 100 ms a connection that consumes times out after four times that; for its first
//! message it has at least 10 s. One that produces sends at least every EPR. With an EPR of 0 there is no time-out, and what is
//! produced is sent when it changes. An explicit connection that was asked for with two bytes has an EPR of 2500 ms. What a
//! time-out leads to is the watchdog action: timed out (0), deleted (1), begun anew (2), and for explicit connections
//! deleted when the requester's last I/O connection ends (3).
//!
//! # Decisions where the paper is silent
//!
//! What a connection request is answered with, what connectionless requests and the objects do: see the tables of
//! [`connection`](crate::connection), and those below.
//!
//! | Situation | What happens |
//! |---|---|
//! | the first data of a producer | go out when it is established: before the connection response, for I/O has priority |
//! | a dynamic connection for explicit messages | is established at once: nothing about it has to be configured |
//! | a dynamic I/O connection that nobody configures | is deleted 10 s after the last service for it ([`Config::configuring_time_out`]), or with the requester's last explicit connection |
//! | a second request for a connection, by the same node | granted: it begins anew, and is as by default |
//! | the same, by another node | refused with 0x0C, unless the connection timed out; joined, if it produces to many |
//! | an explicit connection with the identifiers of another one of the same client | takes its place |
//! | a client opens instance 1 while another has it | refused with 0x0C: there are dynamic ones |
//! | the node gives up its address, or leaves the bus | all connections are gone |
//! | a consumer is told whose data to consume while it is established | it waits for the first message as if it had just been established |
//! | a poll command comes while the response to an earlier one waits for its turn | one response serves both; counted in [`Counters::merged`] |
//! | an implicit frame is given back unsent | it is lost, as on the bus: the next message has newer data |
//! | a response in one frame is given back unsent | it is lost: the client asks again |
//! | a fragment of a response is given back unsent | it is sent again after the acknowledge time |
//! | a request comes while the response to an earlier one waits for its turn | the earlier response is dropped, the later request answered |
//! | more than four requests without a connection at once | the fifth is ignored: no request is carried out whose answer would be lost |
//! | a Delete of the connection that carried it | the connection is gone at once, its response still goes out |
//! | a request comes after a Reset or a new address was accepted | ignored: the node is leaving |
//! | the network is lost before the response to a Reset was sent | the reset is carried out all the same |
//! | a request on a connection that ends before it names an object | 0x13 |

mod application;
mod config;
mod connect;
mod connection_object;
mod connectionless;
mod construct;
mod departure;
mod doors;
mod event;
mod explicit;
mod follow;
mod implicit;
mod line;
mod long;
mod machine;
mod output;
mod server;
mod slot;
#[cfg(test)]
mod tests;
mod timer;

pub use application::{Application, Offer};
pub use config::Config;
pub use construct::{Connection, InvalidDevice};
pub use event::{Counters, DeviceEvent, Ignored};
pub use implicit::NotProducing;
pub use long::{Fragmented, LongMessages};
pub use machine::Device;
