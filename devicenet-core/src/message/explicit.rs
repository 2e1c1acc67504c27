//! Explicit messages as frames: complete ones, fragments and their acknowledges.
//!
//! The body is that of [`cip_core::message`]: it begins with the service byte. Cutting and reassembly are in
//! [`cip_core::fragment`].

use cip_core::codec::{Full, ParseError, Reader, Tail, Wire, Writer};
use cip_core::fragment::{AckStatus, FragmentByte, FragmentKind};

use super::ExplicitHeader;
use crate::id::MacId;

/// An explicit message in one frame.
///
/// | Byte | Content |
/// |---|---|
/// | 0 | header: FRAG 0, XID, MAC ID |
/// | 1 | service, bit 7 R/R |
/// | 2-7 | the rest of the body, 0 to 6 bytes |
///
/// Source: CIP Vol. 3; MKS Baratron DMA manual, appendix D.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ExplicitMessage<'a> {
    /// XID.
    pub xid: bool,
    /// The MAC ID in the header.
    pub mac: MacId,
    /// From the service byte on; at least that, and at most seven bytes.
    pub body: &'a [u8],
}

/// A fragment of an explicit message.
///
/// | Byte | Content |
/// |---|---|
/// | 0 | header: FRAG 1, XID, MAC ID |
/// | 1 | bits 7-6 type: 00 first, 01 middle, 10 last; bits 5-0 count |
/// | 2-7 | a part of the body, 0 to 6 bytes; six in all but the last fragment |
///
/// Source: CIP Vol. 3, fragmentation protocol; Rockwell 1760-UM003A p. 4-11.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ExplicitFragment<'a> {
    /// XID.
    pub xid: bool,
    /// The MAC ID in the header.
    pub mac: MacId,
    /// First, middle or last, and its count; not an acknowledge.
    pub fragment: FragmentByte,
    /// The part, at most six bytes.
    pub body: &'a [u8],
}

/// The acknowledge of a fragment of an explicit message, on the connection's other identifier.
///
/// | Byte | Content |
/// |---|---|
/// | 0 | header: FRAG 1, XID copied, MAC ID |
/// | 1 | bits 7-6 type 11; bits 5-0 count of the fragment that is acknowledged |
/// | 2 | status: 0 success, 1 too much data, 2-255 reserved |
///
/// Source: CIP Vol. 3, fragmentation protocol; Rockwell 1760-UM003A p. 4-12; POSITAL/BEI MHK5 manual p. 15.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct FragmentAcknowledge {
    /// XID.
    pub xid: bool,
    /// The MAC ID in the header.
    pub mac: MacId,
    count: u8,
    /// Whether the receiver goes on.
    pub status: AckStatus,
}

impl FragmentAcknowledge {
    /// The acknowledge of the fragment with that count, which is taken modulo 64.
    #[must_use]
    pub const fn new(xid: bool, mac: MacId, count: u8, status: AckStatus) -> Self {
        Self { xid, mac, count: count & 0x3F, status }
    }

    /// The count of the fragment, 0 to 63.
    #[must_use]
    pub const fn count(self) -> u8 {
        self.count
    }
}

impl<'a> Wire<'a> for ExplicitMessage<'a> {
    const NAME: &'static str = "explicit message";
    const TAIL: Tail = Tail::Open;

    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        let header = ExplicitHeader::read_complete(reader)?;
        let mut service = *reader;
        service.u8("service")?;
        Ok(Self { xid: header.xid, mac: header.mac, body: rest(reader, MAX_BODY)? })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        ExplicitHeader::complete(self.xid, self.mac).emit(out)?;
        out.bytes(self.body)
    }

    fn wire_len(&self) -> usize {
        self.body.len().saturating_add(1)
    }
}

impl<'a> Wire<'a> for ExplicitFragment<'a> {
    const NAME: &'static str = "explicit fragment";
    const TAIL: Tail = Tail::Open;

    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        let header = ExplicitHeader::read_expecting(reader, true)?;
        let offset = reader.offset();
        let byte = reader.u8("fragmentation byte")?;
        let fragment = FragmentByte::from(byte);
        if fragment.kind == FragmentKind::Acknowledge {
            return Err(ParseError::value("fragment type", offset, byte.into()));
        }
        Ok(Self { xid: header.xid, mac: header.mac, fragment, body: rest(reader, MAX_PART)? })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        ExplicitHeader::fragment(self.xid, self.mac).emit(out)?;
        out.u8(self.fragment.into())?;
        out.bytes(self.body)
    }

    fn wire_len(&self) -> usize {
        self.body.len().saturating_add(2)
    }
}

impl Wire<'_> for FragmentAcknowledge {
    const NAME: &'static str = "fragment acknowledge";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        let header = ExplicitHeader::read_expecting(reader, true)?;
        let offset = reader.offset();
        let byte = reader.u8("fragmentation byte")?;
        let fragment = FragmentByte::from(byte);
        if fragment.kind != FragmentKind::Acknowledge {
            return Err(ParseError::value("fragment type", offset, byte.into()));
        }
        let status = AckStatus::from(reader.u8("acknowledge status")?);
        Ok(Self { xid: header.xid, mac: header.mac, count: fragment.count(), status })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        ExplicitHeader::fragment(self.xid, self.mac).emit(out)?;
        out.u8(FragmentByte::new(FragmentKind::Acknowledge, self.count).into())?;
        out.u8(self.status.into())
    }

    fn wire_len(&self) -> usize {
        3
    }
}

/// What remains, if a frame has room for it.
pub(super) fn rest<'a>(reader: &mut Reader<'a>, most: usize) -> Result<&'a [u8], ParseError> {
    let offset = reader.offset();
    let rest = reader.rest();
    match rest.len().checked_sub(most) {
        None | Some(0) => Ok(rest),
        Some(found) => Err(ParseError {
            field: "data of a CAN frame",
            offset: offset.saturating_add(most),
            kind: cip_core::codec::ParseErrorKind::Trailing { found },
        }),
    }
}

const MAX_BODY: usize = 7;
const MAX_PART: usize = 6;
