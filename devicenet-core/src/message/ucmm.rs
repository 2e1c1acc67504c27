//! Opening and closing of explicit connections by the Unconnected Message Manager (UCMM).
//!
//! Requests are on `0x780 + client`, responses on `0x740 + server`; the header carries the receiver's MAC ID. They are
//! never fragmented. A request with another service is answered by an [`ErrorResponse`](super::ErrorResponse).
//!
//! Reserved bits: bits 7-4 of the body format byte and reserved codes are kept, because a server answers a reserved
//! format with one that it supports, and a reserved group with an error.

use core::fmt;

use cip_core::code::{InstanceId, ServiceCode};
use cip_core::codec::{Full, ParseError, Reader, Wire, Writer};
use cip_core::message::BodyFormat;

use super::fields::service;
use super::{Direction, ExplicitHeader};
use crate::id::MacId;

/// Open Explicit Messaging Connection request.
///
/// | Byte | Content |
/// |---|---|
/// | 0 | header: FRAG 0, XID, server's MAC ID |
/// | 1 | 0x4B |
/// | 2 | bits 3-0 requested body format; bits 7-4 reserved, 0 |
/// | 3 | bits 7-4 Group Select; bits 3-0 Source Message ID: the client's, for its requests |
///
/// [`GroupSelect::NODE_PING`] asks whether the node is there: nothing is opened. Source: CIP Vol. 3, UCMM; capture of an
/// IAI controller.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct OpenRequest {
    /// XID.
    pub xid: bool,
    /// Who shall open it.
    pub server: MacId,
    /// What the client would like to use.
    pub body_format: FormatByte,
    /// Where the connection shall be.
    pub group: GroupSelect,
    /// From the client's pool: 0-15 in Group 1, 0-4 in Group 3; 0 in Group 2 and for a node ping.
    pub source_message: MessageId,
}

/// Open Explicit Messaging Connection response.
///
/// | Byte | Content |
/// |---|---|
/// | 0 | header: FRAG 0, XID copied, client's MAC ID |
/// | 1 | 0xCB |
/// | 2 | bits 3-0 actual body format; bits 7-4 reserved, 0 |
/// | 3 | bits 7-4 Destination Message ID: in Group 2 the one for the client's requests, else 0; bits 3-0 Source Message ID: the server's, for its responses |
/// | 4-5 | Connection instance ID at the server, little-endian; 0 answers a node ping |
///
/// Source: CIP Vol. 3, UCMM; capture of an IAI controller.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct OpenResponse {
    /// XID.
    pub xid: bool,
    /// Who asked.
    pub client: MacId,
    /// What the client must use.
    pub body_format: FormatByte,
    /// Bits 7-4 of byte 3.
    pub destination_message: MessageId,
    /// Bits 3-0 of byte 3.
    pub source_message: MessageId,
    /// Names the connection when it is closed.
    pub connection: InstanceId,
}

/// Close Connection request.
///
/// | Byte | Content |
/// |---|---|
/// | 0 | header: FRAG 0, XID, server's MAC ID |
/// | 1 | 0x4C |
/// | 2-3 | Connection instance ID, little-endian |
///
/// Source: CIP Vol. 3, UCMM.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct CloseRequest {
    /// XID.
    pub xid: bool,
    /// Who shall close it.
    pub server: MacId,
    /// From the [`OpenResponse`].
    pub connection: InstanceId,
}

/// Close Connection response.
///
/// | Byte | Content |
/// |---|---|
/// | 0 | header: FRAG 0, XID copied, client's MAC ID |
/// | 1 | 0xCC |
///
/// Source: CIP Vol. 3, UCMM; capture of an IAI controller.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct CloseResponse {
    /// XID.
    pub xid: bool,
    /// Who asked.
    pub client: MacId,
}

/// A message group in an Open request: four bits.
///
/// | Value | Group |
/// |---|---|
/// | 0 | Group 1 |
/// | 1 | Group 2 |
/// | 3 | Group 3 |
/// | 15 | node ping |
/// | 2, 4-14 | reserved |
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(transparent))]
pub struct GroupSelect(u8);

impl GroupSelect {
    /// 0
    pub const GROUP_1: Self = Self(0);
    /// 1
    pub const GROUP_2: Self = Self(1);
    /// 3
    pub const GROUP_3: Self = Self(3);
    /// 15: nothing is opened, the answer says that the node is there.
    pub const NODE_PING: Self = Self(15);

    /// The selection of that number; `None` above 15.
    #[must_use]
    pub const fn new(number: u8) -> Option<Self> {
        if number <= NIBBLE { Some(Self(number)) } else { None }
    }

    /// 0 to 15.
    #[must_use]
    pub const fn number(self) -> u8 {
        self.0
    }

    /// The name; `None` for a reserved value.
    #[must_use]
    pub const fn name(self) -> Option<&'static str> {
        match self {
            Self::GROUP_1 => Some("Group 1"),
            Self::GROUP_2 => Some("Group 2"),
            Self::GROUP_3 => Some("Group 3"),
            Self::NODE_PING => Some("node ping"),
            _ => None,
        }
    }
}

/// The name, or `reserved group 7`.
impl fmt::Display for GroupSelect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.name() {
            Some(name) => f.write_str(name),
            None => write!(f, "reserved group {}", self.0),
        }
    }
}

impl fmt::Debug for GroupSelect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for GroupSelect {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "group select {=u8}", self.0);
    }
}

/// A Message ID in four bits, 0 to 15.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(transparent))]
pub struct MessageId(u8);

impl MessageId {
    /// 0
    pub const ZERO: Self = Self(0);

    /// The Message ID of that number; `None` above 15.
    #[must_use]
    pub const fn new(number: u8) -> Option<Self> {
        if number <= NIBBLE { Some(Self(number)) } else { None }
    }

    /// 0 to 15.
    #[must_use]
    pub const fn number(self) -> u8 {
        self.0
    }
}

/// The byte that tells a body format: bits 3-0 the format, bits 7-4 reserved.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(transparent))]
pub struct FormatByte(pub u8);

impl FormatByte {
    /// The format; `None` for a reserved code.
    #[must_use]
    pub const fn format(self) -> Option<BodyFormat> {
        BodyFormat::from_code(self.0 & NIBBLE)
    }

    /// Bits 7-4, in place: 0 unless something is wrong.
    #[must_use]
    pub const fn reserved_bits(self) -> u8 {
        self.0 & !NIBBLE
    }
}

impl From<BodyFormat> for FormatByte {
    fn from(format: BodyFormat) -> Self {
        Self(format.code())
    }
}

impl Wire<'_> for OpenRequest {
    const NAME: &'static str = "UCMM open request";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        let header = ExplicitHeader::read_complete(reader)?;
        service(reader, OPEN, Direction::Request)?;
        let body_format = FormatByte(reader.u8("body format")?);
        let byte = reader.u8("group select and source Message ID")?;
        Ok(Self {
            xid: header.xid,
            server: header.mac,
            body_format,
            group: GroupSelect(byte >> 4),
            source_message: MessageId(byte & NIBBLE),
        })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        ExplicitHeader::complete(self.xid, self.server).emit(out)?;
        let group_and_source = self.group.0 << 4 | self.source_message.0;
        out.bytes(&[OPEN.request_byte(), self.body_format.0, group_and_source])
    }

    fn wire_len(&self) -> usize {
        4
    }
}

impl Wire<'_> for OpenResponse {
    const NAME: &'static str = "UCMM open response";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        let header = ExplicitHeader::read_complete(reader)?;
        service(reader, OPEN, Direction::Response)?;
        let body_format = FormatByte(reader.u8("body format")?);
        let byte = reader.u8("destination and source Message ID")?;
        Ok(Self {
            xid: header.xid,
            client: header.mac,
            body_format,
            destination_message: MessageId(byte >> 4),
            source_message: MessageId(byte & NIBBLE),
            connection: InstanceId(reader.u16("connection instance ID")?),
        })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        ExplicitHeader::complete(self.xid, self.client).emit(out)?;
        let messages = self.destination_message.0 << 4 | self.source_message.0;
        out.bytes(&[OPEN.response_byte(), self.body_format.0, messages])?;
        out.u16(self.connection.0)
    }

    fn wire_len(&self) -> usize {
        6
    }
}

impl Wire<'_> for CloseRequest {
    const NAME: &'static str = "UCMM close request";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        let header = ExplicitHeader::read_complete(reader)?;
        service(reader, CLOSE, Direction::Request)?;
        let connection = InstanceId(reader.u16("connection instance ID")?);
        Ok(Self { xid: header.xid, server: header.mac, connection })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        ExplicitHeader::complete(self.xid, self.server).emit(out)?;
        out.u8(CLOSE.request_byte())?;
        out.u16(self.connection.0)
    }

    fn wire_len(&self) -> usize {
        4
    }
}

impl Wire<'_> for CloseResponse {
    const NAME: &'static str = "UCMM close response";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        let header = ExplicitHeader::read_complete(reader)?;
        service(reader, CLOSE, Direction::Response)?;
        Ok(Self { xid: header.xid, client: header.mac })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        ExplicitHeader::complete(self.xid, self.client).emit(out)?;
        out.u8(CLOSE.response_byte())
    }

    fn wire_len(&self) -> usize {
        2
    }
}

const OPEN: ServiceCode = ServiceCode(0x4B);
const CLOSE: ServiceCode = ServiceCode(0x4C);
const NIBBLE: u8 = 0x0F;
