//! A whole frame.

use core::fmt;

use link_core::codec::{Full, ParseError, Reader, Wire, Writer};
use link_core::text::ByteCount;

use super::{
    IdentResponse, MessageType, NmtCommand, NmtRequest, Preq, Pres, Sdo, ServiceId, Soa, Soc, StatusResponse,
};
use crate::ethernet::{ETHERNET_HEADER, ETHERTYPE, MIN_FRAME, POWERLINK_HEADER};
use crate::{MacAddress, NodeId};

/// The headers of every frame.
///
/// | Offset | Content |
/// |---|---|
/// | 0-5 | destination MAC address |
/// | 6-11 | source MAC address |
/// | 12-13 | EtherType 0x88AB, in network order |
/// | 14 | bit 7 reserved, bits 6-0 message type |
/// | 15 | destination node |
/// | 16 | source node |
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Header {
    /// Destination MAC address.
    pub destination: MacAddress,
    /// Source MAC address.
    pub source: MacAddress,
    /// What kind of message it is.
    pub message_type: MessageType,
    /// Destination node.
    pub to: NodeId,
    /// Source node.
    pub from: NodeId,
}

/// A frame with its content.
///
/// What follows the content is padding and is not looked at; [`emit`](Self::emit) pads to the shortest length of Ethernet.
///
/// ```
/// use powerlink_core::ethernet::group;
/// use powerlink_core::wire::{Body, Frame, Header, MessageType, Soc};
/// use powerlink_core::{MacAddress, NodeId};
///
/// let soc = Frame {
///     destination: group::SOC,
///     source: MacAddress([0x02, 0, 0, 0, 0, 0xF0]),
///     to: NodeId::BROADCAST,
///     from: NodeId::MANAGING_NODE,
///     body: Body::Soc(Soc::default()),
/// };
/// let mut buffer = [0xA5; 64];
/// let bytes = soc.emit(&mut buffer)?;
/// assert_eq!((bytes.len(), Frame::parse(bytes)), (60, Ok(soc.clone())));
/// assert_eq!(soc.to_string(), "MN -> all: SoC, net time 0.000000000, relative 0 us");
/// # Ok::<(), link_core::codec::Full>(())
/// ```
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Frame<'a> {
    /// Destination MAC address.
    pub destination: MacAddress,
    /// Source MAC address.
    pub source: MacAddress,
    /// Destination node.
    pub to: NodeId,
    /// Source node.
    pub from: NodeId,
    /// The message.
    pub body: Body<'a>,
}

/// What a frame says.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Body<'a> {
    /// Start of cycle.
    Soc(Soc),
    /// Poll request.
    Preq(Preq<'a>),
    /// Poll response.
    Pres(Pres<'a>),
    /// Start of the asynchronous phase.
    Soa(Soa),
    /// ASnd: who a node is.
    IdentResponse(IdentResponse),
    /// ASnd: what went wrong.
    StatusResponse(StatusResponse),
    /// ASnd: a node asks for an NMT command.
    NmtRequest(NmtRequest<'a>),
    /// ASnd: an NMT command.
    NmtCommand(NmtCommand<'a>),
    /// ASnd: SDO.
    Sdo(Sdo<'a>),
    /// ASnd of a service that is not known here.
    OtherAsnd(ServiceId, &'a [u8]),
    /// A message type that is not known here.
    Other(MessageType, &'a [u8]),
}

/// Why bytes are not a POWERLINK frame.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum FrameError {
    /// The frame is of another protocol.
    #[error("EtherType 0x{0:04X} is not POWERLINK")]
    OtherProtocol(u16),
    /// The frame is cut, or a field has a value that cannot be.
    #[error(transparent)]
    Malformed(#[from] ParseError),
}

impl Header {
    /// Reads the headers; the content remains in `reader`.
    ///
    /// # Errors
    /// [`FrameError`] if the frame ends in them, or is of another protocol.
    pub fn read(reader: &mut Reader<'_>) -> Result<Self, FrameError> {
        let Some((destination, source, [e0, e1, message_type, to, from])) =
            reader.peek().first_chunk().and_then(parts)
        else {
            return Err(Self::cut(reader));
        };
        let ethertype = u16::from_be_bytes([e0, e1]);
        if ethertype != ETHERTYPE {
            return Err(FrameError::OtherProtocol(ethertype));
        }
        reader.bytes(HEADERS, "headers")?;
        Ok(Self {
            destination: MacAddress(destination),
            source: MacAddress(source),
            message_type: MessageType(message_type & MESSAGE_TYPE),
            to: NodeId(to),
            from: NodeId(from),
        })
    }

    /// In which part a frame ends that is shorter than its headers.
    #[cold]
    fn cut(reader: &mut Reader<'_>) -> FrameError {
        let mut end = || -> Result<FrameError, ParseError> {
            reader.array::<6>("destination MAC")?;
            reader.array::<6>("source MAC")?;
            let ethertype = u16::from_be_bytes(reader.array("EtherType")?);
            if ethertype == ETHERTYPE {
                reader.array::<3>("POWERLINK header")?;
            }
            Ok(FrameError::OtherProtocol(ethertype))
        };
        end().unwrap_or_else(FrameError::Malformed)
    }

    /// Writes the headers.
    ///
    /// # Errors
    /// [`Full`] if there is no room.
    pub fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.bytes(&self.bytes())
    }

    /// The headers as they are sent.
    #[inline]
    pub(crate) const fn bytes(&self) -> [u8; HEADERS] {
        let ([d0, d1, d2, d3, d4, d5], [s0, s1, s2, s3, s4, s5]) = (self.destination.0, self.source.0);
        let ([e0, e1], kind) = (ETHERTYPE.to_be_bytes(), self.message_type.0);
        [d0, d1, d2, d3, d4, d5, s0, s1, s2, s3, s4, s5, e0, e1, kind, self.to.0, self.from.0]
    }
}

impl<'a> Frame<'a> {
    /// Reads a frame as a raw socket delivers it: without the CRC, padded or not.
    ///
    /// # Errors
    /// [`FrameError`] if it is of another protocol, ends before its content does, or has a value that cannot be.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, FrameError> {
        let mut reader = Reader::new(bytes);
        let Header { destination, source, message_type, to, from } = Header::read(&mut reader)?;
        let body = Body::read(message_type, &mut reader)?;
        Ok(Self { destination, source, to, from, body })
    }

    /// Writes the frame to the front of `buffer`, padded with zeros to [`MIN_FRAME`].
    ///
    /// # Errors
    /// [`Full`] if the buffer is too short.
    pub fn emit<'b>(&self, buffer: &'b mut [u8]) -> Result<&'b [u8], Full> {
        let mut out = Writer::new(buffer);
        let message_type = self.body.message_type();
        let Self { destination, source, to, from, .. } = *self;
        Header { destination, source, message_type, to, from }.emit(&mut out)?;
        self.body.emit(&mut out)?;
        pad(&mut out, MIN_FRAME)?;
        Ok(out.into_written())
    }
}

impl<'a> Body<'a> {
    /// The message type of the POWERLINK header.
    #[must_use]
    pub const fn message_type(&self) -> MessageType {
        match self {
            Self::Soc(_) => MessageType::SOC,
            Self::Preq(_) => MessageType::PREQ,
            Self::Pres(_) => MessageType::PRES,
            Self::Soa(_) => MessageType::SOA,
            Self::IdentResponse(_)
            | Self::StatusResponse(_)
            | Self::NmtRequest(_)
            | Self::NmtCommand(_)
            | Self::Sdo(_)
            | Self::OtherAsnd(..) => MessageType::ASND,
            Self::Other(message_type, _) => *message_type,
        }
    }

    /// Reads the content that follows the headers.
    ///
    /// # Errors
    /// [`ParseError`] if it is cut, or a field has a value that cannot be.
    pub fn read(message_type: MessageType, reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        Ok(match message_type {
            MessageType::SOC => Self::Soc(Soc::read(reader)?),
            MessageType::PREQ => Self::Preq(Preq::read(reader)?),
            MessageType::PRES => Self::Pres(Pres::read(reader)?),
            MessageType::SOA => Self::Soa(Soa::read(reader)?),
            MessageType::ASND => match ServiceId(reader.u8("ServiceID")?) {
                ServiceId::IDENT_RESPONSE => Self::IdentResponse(IdentResponse::read(reader)?),
                ServiceId::STATUS_RESPONSE => Self::StatusResponse(StatusResponse::read(reader)?),
                ServiceId::NMT_REQUEST => Self::NmtRequest(NmtRequest::read(reader)?),
                ServiceId::NMT_COMMAND => Self::NmtCommand(NmtCommand::read(reader)?),
                ServiceId::SDO => Self::Sdo(Sdo::read(reader)?),
                other => Self::OtherAsnd(other, reader.rest()),
            },
            other => Self::Other(other, reader.rest()),
        })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        match self {
            Self::Soc(soc) => soc.emit(out),
            Self::Preq(preq) => preq.emit(out),
            Self::Pres(pres) => pres.emit(out),
            Self::Soa(soa) => soa.emit(out),
            Self::IdentResponse(ident) => asnd(ServiceId::IDENT_RESPONSE, ident, out),
            Self::StatusResponse(status) => asnd(ServiceId::STATUS_RESPONSE, status, out),
            Self::NmtRequest(request) => asnd(ServiceId::NMT_REQUEST, request, out),
            Self::NmtCommand(command) => asnd(ServiceId::NMT_COMMAND, command, out),
            Self::Sdo(sdo) => asnd(ServiceId::SDO, sdo, out),
            Self::OtherAsnd(service, data) => {
                out.u8(service.0)?;
                out.bytes(data)
            }
            Self::Other(_, data) => out.bytes(data),
        }
    }
}

/// Fills with zeros up to `len` bytes.
pub(crate) fn pad(out: &mut Writer<'_>, len: usize) -> Result<(), Full> {
    while let Some(missing) = len.checked_sub(out.len()).filter(|missing| *missing > 0) {
        out.bytes(ZEROS.get(..missing).unwrap_or(&ZEROS))?;
    }
    Ok(())
}

fn asnd<'a>(service: ServiceId, body: &impl Wire<'a>, out: &mut Writer<'_>) -> Result<(), Full> {
    out.u8(service.0)?;
    body.emit(out)
}

/// `MN -> node 1: NMTStartNode`
impl fmt::Display for Frame<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} -> {}: {}", self.from, self.to, self.body)
    }
}

impl fmt::Display for Body<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Soc(soc) => soc.fmt(f),
            Self::Preq(preq) => preq.fmt(f),
            Self::Pres(pres) => pres.fmt(f),
            Self::Soa(soa) => soa.fmt(f),
            Self::IdentResponse(ident) => ident.fmt(f),
            Self::StatusResponse(status) => status.fmt(f),
            Self::NmtRequest(request) => request.fmt(f),
            Self::NmtCommand(command) => command.fmt(f),
            Self::Sdo(sdo) => sdo.fmt(f),
            Self::OtherAsnd(service, data) => write!(f, "{service}, {}", ByteCount(data.len())),
            Self::Other(message_type, data) => write!(f, "{message_type}, {}", ByteCount(data.len())),
        }
    }
}

/// Destination, source, and the rest of the headers.
fn parts(headers: &[u8; HEADERS]) -> Option<([u8; 6], [u8; 6], [u8; 5])> {
    let (destination, rest) = headers.split_first_chunk()?;
    let (source, rest) = rest.split_first_chunk()?;
    Some((*destination, *source, *rest.first_chunk()?))
}

/// The bits of the message type in its byte.
pub(crate) const MESSAGE_TYPE: u8 = 0x7F;
/// Those of Ethernet and of POWERLINK.
const HEADERS: usize = ETHERNET_HEADER + POWERLINK_HEADER;
const ZEROS: [u8; 64] = [0; 64];
