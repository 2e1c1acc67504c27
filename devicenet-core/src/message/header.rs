//! Byte 0 of every explicit message.

use core::fmt;

use cip_core::codec::{Full, ParseError, Reader, Wire, Writer};

use crate::id::MacId;

/// Header of an explicit message, connected or not, and of heartbeat and shutdown.
///
/// | Bit | Content |
/// |---|---|
/// | 7 | FRAG: 0 complete message, 1 fragment (byte 1 is the fragmentation byte) |
/// | 6 | XID: transaction ID, chosen by the client, copied by the server |
/// | 5-0 | the MAC ID that is *not* in the identifier: the source where the identifier carries the destination, the destination where it carries the source |
///
/// All 256 values are valid. In a heartbeat or shutdown the MAC ID is that of the identifier: so receivers know a
/// broadcast. Source: CIP Vol. 3; MKS Baratron DMA manual, appendix D.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ExplicitHeader {
    /// FRAG.
    pub fragmented: bool,
    /// XID.
    pub xid: bool,
    /// Bits 5-0.
    pub mac: MacId,
}

impl ExplicitHeader {
    /// The header of a message in one frame.
    #[must_use]
    pub const fn complete(xid: bool, mac: MacId) -> Self {
        Self { fragmented: false, xid, mac }
    }

    /// The header of a fragment or of its acknowledge.
    #[must_use]
    pub const fn fragment(xid: bool, mac: MacId) -> Self {
        Self { fragmented: true, xid, mac }
    }

    /// Reads the header of a message that is never fragmented.
    pub(super) fn read_complete(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        Self::read_expecting(reader, false)
    }

    pub(super) fn read_expecting(reader: &mut Reader<'_>, fragmented: bool) -> Result<Self, ParseError> {
        let offset = reader.offset();
        let header = Self::read(reader)?;
        if header.fragmented != fragmented {
            return Err(ParseError::value("FRAG bit of the header", offset, u8::from(header).into()));
        }
        Ok(header)
    }
}

impl From<u8> for ExplicitHeader {
    fn from(byte: u8) -> Self {
        Self { fragmented: byte & FRAG != 0, xid: byte & XID != 0, mac: MacId::from_low_bits(byte) }
    }
}

impl From<ExplicitHeader> for u8 {
    fn from(header: ExplicitHeader) -> Self {
        let frag = if header.fragmented { FRAG } else { 0 };
        let xid = if header.xid { XID } else { 0 };
        frag | xid | header.mac.number()
    }
}

impl Wire<'_> for ExplicitHeader {
    const NAME: &'static str = "explicit message header";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        reader.u8("header").map(Self::from)
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u8((*self).into())
    }

    fn wire_len(&self) -> usize {
        1
    }
}

/// `MAC ID 10, XID 0` or `MAC ID 10, XID 1, fragment`
impl fmt::Display for ExplicitHeader {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "MAC ID {}, XID {}", self.mac, u8::from(self.xid))?;
        if self.fragmented { f.write_str(", fragment") } else { Ok(()) }
    }
}

const FRAG: u8 = 0x80;
const XID: u8 = 0x40;
