//! The wire types: every message of POWERLINK V2 that a controlled node meets, with its layout.
//!
//! A [`Frame`] is a whole Ethernet frame without its CRC; its [`Body`] is one of the messages. Each message reads and writes
//! what stands behind the headers ([`Wire`]); [`for_each_wire_type`](crate::for_each_wire_type) lists them. Offsets in the
//! tables count from the first byte of the Ethernet frame.
//!
//! | Message type | Messages |
//! |---|---|
//! | SoC | [`Soc`] |
//! | PReq, PRes | [`Preq`], [`Pres`] |
//! | SoA | [`Soa`] |
//! | ASnd | [`IdentResponse`], [`StatusResponse`], [`NmtRequest`], [`NmtCommand`], [`Sdo`] |
//!
//! All numbers are little-endian but the EtherType. Reserved bytes are written as zeros and ignored when read. What follows
//! the content of a frame is padding, never data: sizes come from the fields, not from the length of the frame.
//!
//! Layouts: EPSG DS 301 as shown by openPOWERLINK 2.7.2 (`frame.h`), Wireshark (`packet-epl.c`) and vendors' manuals.

mod code;
mod cycle;
mod flags;
mod frame;
mod ident;
#[cfg(test)]
mod laws;
mod list;
mod nmt;
mod sdo;
mod status;
#[cfg(test)]
mod vectors;

pub use link_core::codec::{ParseError, ParseErrorKind, Wire};

pub use code::{
    AbortCode, ErrorCode, MessageType, NmtCommandId, NmtStateCode, RequestedService, SdoCommandId, ServiceId,
};
pub use cycle::{NetTime, POWERLINK_V2, PdoVersion, Preq, Pres, Soa, Soc};
pub use flags::{AsyncRequest, Flags};
pub use frame::{Body, Frame, FrameError, Header};
pub use ident::{ConfigurationStamp, FeatureFlags, IdentResponse, Identity, IpParameters, Revision};
pub use nmt::{MAX_COMMAND_DATA, NmtCommand, NmtRequest, NodeList};
pub use sdo::{Con, InitiateSize, Sdo, SdoCommand, SdoSequence, Segmentation, SequenceHalf};
pub use status::{EntryType, ErrorEntry, MAX_ENTRIES, MIN_ENTRIES, StatusResponse};

pub(crate) use cycle::POLL_FIELDS;
pub(crate) use frame::{MESSAGE_TYPE, pad};
pub(crate) use sdo::{COMMAND_HEADER, TOTAL_SIZE};
