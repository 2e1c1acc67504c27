#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(test, allow(clippy::arithmetic_side_effects, clippy::as_conversions))]
//! Ethernet POWERLINK V2 (EPSG DS 301) as pure state machines: no clock, no socket, no allocation, no `std`.
//!
//! | module | what |
//! |---|---|
//! | [`node`] | [`ControlledNode`], which joins all parts |
//! | [`wire`] | every message with its byte table |
//! | [`ethernet`] | addresses and lengths of frames; the contract is [`link_core::ethernet`] |
//! | [`nmt`] | the NMT state machine |
//! | [`cycle`] | the cycle: frames that do not come |
//! | [`error`] | error counters, error signalling |
//! | [`dictionary`] | the objects |
//! | [`pdo`] | objects in process data |
//! | [`sdo`] | the server by which objects are read and written |
//! | [`indicator`] | status and error LED |
//! | [`managing`] | [`ManagingNode`](managing::ManagingNode), a small managing node for tests and demonstrations |
//! | [`monitor`] | the passive decoder: what every frame on the wire means |
//!
//! # A node is started
//!
//! Eight inputs and eight outputs; the managing node is played by hand.
//!
//! ```
//! use link_core::Instant;
//! use link_core::codec::Writer;
//! use link_core::ethernet::{Action, Input, Machine};
//! use powerlink_core::dictionary::{Access, Device, Entry, Mappable, ObjectAddress, ObjectSet, ObjectType};
//! use powerlink_core::ethernet::{MAX_FRAME, group};
//! use powerlink_core::node::{Config, DefaultMapping};
//! use powerlink_core::pdo::MappingEntry;
//! use powerlink_core::wire::*;
//! use powerlink_core::{ControlledNode, MacAddress, NodeId};
//!
//! #[derive(Default)]
//! struct DigitalIo { inputs: u8, outputs: u8 }
//!
//! impl ObjectSet for DigitalIo {
//!     const ENTRIES: &'static [Entry] = &[
//!         Entry::new(0x6000, 1, "inputs", ObjectType::Unsigned(1), Access::ReadOnly).mapped(Mappable::Transmit),
//!         Entry::new(0x6200, 1, "outputs", ObjectType::Unsigned(1), Access::ReadWrite).mapped(Mappable::Receive),
//!     ];
//!     fn read(&self, at: ObjectAddress, out: &mut Writer<'_>) -> Result<(), AbortCode> {
//!         let value = if at.index == 0x6000 { self.inputs } else { self.outputs };
//!         out.u8(value).map_err(|_| AbortCode::OUT_OF_MEMORY)
//!     }
//!     fn write(&mut self, _: ObjectAddress, data: &[u8]) -> Result<(), AbortCode> {
//!         self.outputs = *data.first().ok_or(AbortCode::LENGTH)?;
//!         Ok(())
//!     }
//!     fn restore(&mut self) {
//!         self.outputs = 0;
//!     }
//! }
//!
//! // A fictitious vendor: the identity is never defaulted.
//! let identity = Identity { vendor_id: 0x0123, product_code: 7, revision: 0x0001_0000, serial_number: 42 };
//! let mac = MacAddress([0x02, 0, 0, 0, 0, 1]);
//! let mut config = Config::new(NodeId(1), mac, Device::new(identity))?;
//! const fn byte(index: u16) -> MappingEntry {
//!     MappingEntry { object: ObjectAddress::new(index, 1), offset: 0, length: 8 }
//! }
//! config.mapping = DefaultMapping { receive: const { &[byte(0x6200)] }, transmit: const { &[byte(0x6000)] } };
//! let mut node: ControlledNode<DigitalIo> = ControlledNode::new(config, DigitalIo { inputs: 0x5A, outputs: 0 })?;
//!
//! let mn = MacAddress([0x02, 0, 0, 0, 0, 0xF0]);
//! let frame = |destination, to, body| Frame { destination, source: mn, to, from: NodeId::MANAGING_NODE, body };
//! let soa = |service| Body::Soa(Soa {
//!     state: NmtStateCode::PRE_OPERATIONAL_1,
//!     flags: Flags::empty(),
//!     service,
//!     target: NodeId(1),
//!     version: POWERLINK_V2,
//! });
//! let command = |command| Body::NmtCommand(NmtCommand { command, data: &[] });
//! let poll = Body::Preq(Preq { flags: Flags::DATA_VALID, pdo_version: PdoVersion(0), data: &[0x0F] });
//! let all = NodeId::BROADCAST;
//! let start = [
//!     frame(group::SOA, all, soa(RequestedService::NO_SERVICE)),
//!     frame(group::SOA, all, soa(RequestedService::IDENT_REQUEST)),
//!     frame(group::SOC, all, Body::Soc(Soc::default())),
//!     frame(group::SOA, all, soa(RequestedService::UNSPECIFIED_INVITE)),
//!     frame(group::ASND, NodeId(1), command(NmtCommandId::ENABLE_READY_TO_OPERATE)),
//!     frame(group::ASND, all, command(NmtCommandId::START_NODE)),
//!     frame(group::SOC, all, Body::Soc(Soc::default())),
//!     frame(mac, NodeId(1), poll),
//! ];
//!
//! let now = Instant::ZERO;
//! let (mut buffer, mut received) = ([0; MAX_FRAME], [0; MAX_FRAME]);
//! let mut trace = Vec::new();
//! node.power_on(now);
//! let inputs = start.iter().map(|frame| frame.emit(&mut received).map(<[u8]>::to_vec));
//! let inputs: Vec<Vec<u8>> = inputs.collect::<Result<_, _>>()?;
//! for input in [Input::Tick].into_iter().chain(inputs.iter().map(|bytes| Input::Frame(bytes))) {
//!     node.input(now, input);
//!     while let Some(action) = node.poll(now, &mut buffer) {
//!         trace.push(match action {
//!             Action::Transmit(bytes) => Frame::parse(bytes)?.to_string(),
//!             Action::Event(event) => event.to_string(),
//!         });
//!     }
//! }
//! trace.retain(|line| !line.contains("LED"));
//! assert_eq!(trace[4..], [
//!     "ResetConfiguration -> NotActive: done",
//!     "NotActive -> PreOperational1: SoA",
//!     "node 1 -> all: IdentResponse, NMT_PRE_OPERATIONAL_1, vendor 0x00000123, product 0x00000007, revision 1.0, PR=0 RS=0",
//!     "PreOperational1 -> PreOperational2: SoC",
//!     "PreOperational2 -> ReadyToOperate: NMTEnableReadyToOperate",
//!     "ReadyToOperate -> Operational: NMTStartNode",
//!     "node 1 -> all: PRes, NMT_OPERATIONAL, EN=0 RD=1, PR=0 RS=0, 1 byte",
//!     "process data of channel 0",
//! ]);
//! assert_eq!(node.objects().outputs, 0x0F);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Limits
//!
//! A controlled node that is polled, and of a managing node what a test needs: no SDO over UDP or in PDOs, no multiple parameters in one SDO command,
//! no poll response chaining, no storage of parameters (0x1010, 0x1011). Objects in process data are of whole bytes.
//! POWERLINK is a trade mark; nothing here was certified by anybody.
//!
//! # Features
//!
//! All are additive. `serde` serialises messages, codes and counters; `defmt` formats them on embedded loggers; `std` passes
//! itself on to the dependencies.

#[cfg(test)]
extern crate std;

pub mod cycle;
pub mod dictionary;
pub mod error;
pub mod ethernet;
#[cfg(feature = "serde")]
mod fields;
pub mod indicator;
pub mod managing;
pub mod monitor;
pub mod nmt;
pub mod node;
pub mod node_id;
pub mod pdo;
pub mod sdo;
pub mod wire;

pub use ethernet::MacAddress;
pub use node::ControlledNode;
pub use node_id::NodeId;
