//! The wire types: the data field of every DeviceNet message, with its layout.
//!
//! Each type reads and writes the *whole* data field of one frame ([`Wire::parse`], [`Wire::emit`]); what it means
//! depends on the identifier. [`frame`] joins the two. [`for_each_wire_type`](crate::for_each_wire_type) lists them all.
//!
//! | Identifier | Messages |
//! |---|---|
//! | `0x407 + 8n` | [`DuplicateMacCheck`] |
//! | `0x406 + 8s` | [`UnconnectedAllocate`], [`UnconnectedRelease`] |
//! | `0x403 + 8s` | [`UnconnectedAllocateResponse`], [`UnconnectedReleaseResponse`], [`ErrorResponse`], [`ExplicitMessage`], [`ExplicitFragment`], [`FragmentAcknowledge`], [`Heartbeat`], [`Shutdown`] |
//! | `0x404 + 8s` | [`ExplicitMessage`], [`ExplicitFragment`], [`FragmentAcknowledge`] |
//! | `0x780 + n` | [`OpenRequest`] (also as node ping), [`CloseRequest`] |
//! | `0x740 + n` | [`OpenResponse`], [`CloseResponse`], [`ErrorResponse`], [`Heartbeat`], [`Shutdown`] |
//! | `0x400 + 8m` | [`BitStrobeCommand`], [`EmptyIo`] |
//! | other I/O | raw data, [`EmptyIo`], [`IoFragment`] |
//! | 0x7ED | [`CommunicationFaultedRequest`]: [`WhoRequest`], [`IdentifyRequest`], [`IdentifyDeviceRequest`], [`ChangeMacIdRequest`] |
//! | 0x7EC | [`CommunicationFaultedResponse`]: [`WhoResponse`], [`IdentifyResponse`] |
//! | 0x7EE, 0x7EF | [`OfflineOwnership`] |
//!
//! What is done about reserved bits says each module: they are either refused, or kept and can be asked for.

mod broadcast;
mod duplicate_mac;
mod explicit;
mod fields;
mod header;
mod io;
#[cfg(test)]
mod laws;
mod list;
mod offline;
mod selection;
mod ucmm;
mod unconnected;

pub use cip_core::codec::{ParseError, ParseErrorKind, Wire};

pub use broadcast::{DeviceState, Heartbeat, HeartbeatFlags, Shutdown, ShutdownCode};
pub use duplicate_mac::DuplicateMacCheck;
pub use explicit::{ExplicitFragment, ExplicitMessage, FragmentAcknowledge};
pub use fields::{DeviceIdentity, Direction, PortNumber};
pub use header::ExplicitHeader;
pub use io::{BitStrobeCommand, EmptyIo, IoFragment};
pub use offline::{
    ChangeMacIdRequest, CommunicationFaultedRequest, CommunicationFaultedResponse, IdentifyDeviceRequest,
    IdentifyRequest, IdentifyResponse, OfflineOwnership, WhoRequest, WhoResponse,
};
pub use selection::{DelayOffset, Mask, NodeSelection};
pub use ucmm::{CloseRequest, CloseResponse, FormatByte, GroupSelect, MessageId, OpenRequest, OpenResponse};
pub use unconnected::{
    ErrorResponse, UnconnectedAllocate, UnconnectedAllocateResponse, UnconnectedRelease,
    UnconnectedReleaseResponse,
};

use cip_core::codec::Writer;
use link_core::Frame;

use crate::id::Identifier;

/// The frame that carries a message; `None` only for a message whose free data are too long for a frame.
///
/// ```
/// use devicenet_core::{Identifier, MacId, message::{self, CloseResponse}};
///
/// let server = MacId::new(20).unwrap();
/// let response = CloseResponse { xid: false, client: MacId::new(2).unwrap() };
/// let frame = message::frame(Identifier::unconnected_response(server), &response).unwrap();
/// assert_eq!(frame.to_string(), "754 [2] 02 CC");
/// ```
#[must_use]
pub fn frame<'a>(id: Identifier, message: &impl Wire<'a>) -> Option<Frame> {
    let mut data = [0; Frame::MAX_DATA];
    let mut writer = Writer::new(&mut data);
    message.emit(&mut writer).ok()?;
    id.frame(writer.written())
}
