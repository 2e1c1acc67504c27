//! SDO over ASnd: the sequence layer and the command layer.

use core::fmt;

use link_core::codec::{Full, ParseError, Reader, Wire, Writer};
use link_core::text::ByteCount;

use super::{AbortCode, SdoCommandId};

/// SDO, an ASnd from one node to another.
///
/// | Offset | Content |
/// |---|---|
/// | 18-21 | [`SdoSequence`] |
/// | 22.. | [`SdoCommand`], or zeros where the sequence layer speaks for itself |
///
/// A frame that ends behind the sequence layer, and one with zeros there, are the same: without a command.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Sdo<'a> {
    /// Which frame of the connection it is.
    pub sequence: SdoSequence,
    /// What it asks or answers.
    pub command: Option<SdoCommand<'a>>,
}

/// The sequence layer: numbers and acknowledges frames.
///
/// | Offset | Content |
/// |---|---|
/// | 18 | bits 7-2 ReceiveSequenceNumber, bits 1-0 ReceiveCon |
/// | 19 | bits 7-2 SendSequenceNumber, bits 1-0 SendCon |
/// | 20-21 | reserved |
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct SdoSequence {
    /// The last good frame of the other side.
    pub receive: SequenceHalf,
    /// The number of this frame.
    pub send: SequenceHalf,
}

/// One direction of a connection.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct SequenceHalf {
    /// 0 to 63.
    pub number: u8,
    /// What it says of the connection.
    pub connection: Con,
}

/// ReceiveCon and SendCon.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Con {
    /// 0: no connection.
    None,
    /// 1: initialisation.
    Initialisation,
    /// 2: the connection is valid.
    Valid,
    /// 3: as SendCon, valid, and to be acknowledged at once; as ReceiveCon, send again what was not acknowledged.
    Request,
}

/// The command layer: reading and writing of objects.
///
/// | Offset | Content |
/// |---|---|
/// | 22 | reserved |
/// | 23 | transaction ID, chosen by the client |
/// | 24 | bit 7 response, bit 6 abort, bits 5-4 [`Segmentation`] |
/// | 25 | command |
/// | 26-27 | SegmentSize: the bytes behind this header |
/// | 28-29 | reserved |
/// | 30-33 | only with [`Segmentation::Initiate`]: the size of all data |
/// | 30.. | data |
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct SdoCommand<'a> {
    /// Chosen by the client, and the same in the response.
    pub transaction: u8,
    /// Whether it is of the server.
    pub is_response: bool,
    /// Whether it ends the transfer without success: the data are an [`AbortCode`].
    pub is_abort: bool,
    /// Which part of the transfer it is.
    pub segmentation: Segmentation,
    /// The command.
    pub command: SdoCommandId,
    /// The data, without the size of all data.
    pub data: &'a [u8],
}

/// Which part of a transfer a command is.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Segmentation {
    /// All of it.
    Expedited,
    /// The first part of several.
    Initiate {
        /// The size of all data, in bytes.
        total: u32,
    },
    /// Neither the first nor the last part.
    Segment,
    /// The last part.
    Complete,
}

/// Whether SegmentSize of the first part of several counts the four bytes that tell the size of all data.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum InitiateSize {
    /// It does.
    #[default]
    Counted,
    /// It does not.
    NotCounted,
}

impl SequenceHalf {
    /// A half with a number, of which six bits count.
    #[must_use]
    pub const fn new(number: u8, connection: Con) -> Self {
        Self { number: number & NUMBER, connection }
    }

    const fn of_byte(byte: u8) -> Self {
        let connection = match byte & CON {
            0 => Con::None,
            1 => Con::Initialisation,
            2 => Con::Valid,
            _ => Con::Request,
        };
        Self { number: byte >> 2, connection }
    }

    const fn byte(self) -> u8 {
        let connection = match self.connection {
            Con::None => 0,
            Con::Initialisation => 1,
            Con::Valid => 2,
            Con::Request => 3,
        };
        (self.number << 2) | connection
    }
}

impl<'a> SdoCommand<'a> {
    /// A command of a client in one part.
    #[must_use]
    pub const fn request(transaction: u8, command: SdoCommandId, data: &'a [u8]) -> Self {
        let segmentation = Segmentation::Expedited;
        Self { transaction, is_response: false, is_abort: false, segmentation, command, data }
    }

    /// Why the transfer failed; `None` if it did not.
    #[must_use]
    pub fn abort(&self) -> Option<AbortCode> {
        let code = self.data.first_chunk().filter(|_| self.is_abort)?;
        Some(AbortCode(u32::from_le_bytes(*code)))
    }

    /// Reads a command of a peer with its own opinion of SegmentSize.
    ///
    /// # Errors
    /// As [`Wire::read`].
    pub fn read_as(reader: &mut Reader<'a>, initiate: InitiateSize) -> Result<Self, ParseError> {
        let [_, transaction, flags, command] = reader.array("SDO command header")?;
        let size = usize::from(reader.u16("SegmentSize")?);
        reader.u16("reserved")?;
        let (segmentation, len) = match flags & SEGMENTATION {
            0 => (Segmentation::Expedited, size),
            INITIATE => {
                let offset = reader.offset();
                let total = reader.u32("total size")?;
                let counted = match initiate {
                    InitiateSize::Counted => TOTAL_SIZE,
                    InitiateSize::NotCounted => 0,
                };
                let len = size.checked_sub(counted).ok_or(ParseError::value(
                    "SegmentSize",
                    offset.saturating_sub(4),
                    flags.into(),
                ))?;
                (Segmentation::Initiate { total }, len)
            }
            SEGMENT => (Segmentation::Segment, size),
            _ => (Segmentation::Complete, size),
        };
        Ok(Self {
            transaction,
            is_response: flags & RESPONSE != 0,
            is_abort: flags & ABORT != 0,
            segmentation,
            command: SdoCommandId(command),
            data: reader.bytes(len, "SDO data")?,
        })
    }

    /// Writes a command for a peer with its own opinion of SegmentSize.
    ///
    /// # Errors
    /// As [`Wire::emit`].
    pub fn emit_as(&self, out: &mut Writer<'_>, initiate: InitiateSize) -> Result<(), Full> {
        let (bits, total) = match self.segmentation {
            Segmentation::Expedited => (0, None),
            Segmentation::Initiate { total } => (INITIATE, Some(total)),
            Segmentation::Segment => (SEGMENT, None),
            Segmentation::Complete => (COMPLETE, None),
        };
        let response = if self.is_response { RESPONSE } else { 0 };
        let abort = if self.is_abort { ABORT } else { 0 };
        let counted = match initiate {
            InitiateSize::Counted if total.is_some() => TOTAL_SIZE,
            InitiateSize::Counted | InitiateSize::NotCounted => 0,
        };
        let size = u16::try_from(self.data.len().saturating_add(counted)).map_err(|_| Full)?;
        out.bytes(&[0, self.transaction, bits | response | abort, self.command.0])?;
        out.u16(size)?;
        out.u16(0)?;
        if let Some(total) = total {
            out.u32(total)?;
        }
        out.bytes(self.data)
    }
}

impl Wire<'_> for SdoSequence {
    const NAME: &'static str = "SDO sequence layer";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        let [receive, send, _, _] = reader.array("SDO sequence layer")?;
        Ok(Self { receive: SequenceHalf::of_byte(receive), send: SequenceHalf::of_byte(send) })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.bytes(&[self.receive.byte(), self.send.byte(), 0, 0])
    }

    fn wire_len(&self) -> usize {
        4
    }
}

impl<'a> Wire<'a> for SdoCommand<'a> {
    const NAME: &'static str = "SDO command layer";

    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        Self::read_as(reader, InitiateSize::Counted)
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        self.emit_as(out, InitiateSize::Counted)
    }

    fn wire_len(&self) -> usize {
        let total = if matches!(self.segmentation, Segmentation::Initiate { .. }) { TOTAL_SIZE } else { 0 };
        self.data.len().saturating_add(COMMAND_HEADER).saturating_add(total)
    }
}

impl<'a> Sdo<'a> {
    /// Reads the body for a peer with its own opinion of SegmentSize.
    ///
    /// # Errors
    /// As [`Wire::read`].
    pub fn read_as(reader: &mut Reader<'a>, initiate: InitiateSize) -> Result<Self, ParseError> {
        let sequence = SdoSequence::read(reader)?;
        let has_command = match reader.peek() {
            [] => false,
            // Nil with no data: padding.
            [_, _, flags, command, low, high, ..] => [flags & MEANING, *command, *low, *high] != [0; 4],
            _ => reader.peek().iter().any(|&byte| byte != 0),
        };
        let command = if has_command { Some(SdoCommand::read_as(reader, initiate)?) } else { None };
        Ok(Self { sequence, command })
    }
}

impl<'a> Wire<'a> for Sdo<'a> {
    const NAME: &'static str = "SDO";
    const TAIL: link_core::codec::Tail = link_core::codec::Tail::Open;

    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        Self::read_as(reader, InitiateSize::Counted)
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        self.sequence.emit(out)?;
        self.command.map_or(Ok(()), |command| command.emit(out))
    }

    fn wire_len(&self) -> usize {
        self.command.map_or(0, |command| command.wire_len()).saturating_add(4)
    }
}

/// `rcon=2/0 scon=2/1`: what each direction says, and its number.
impl fmt::Display for SdoSequence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let con = |half: SequenceHalf| half.byte() & CON;
        let (receive, send) = (self.receive, self.send);
        write!(f, "rcon={}/{} scon={}/{}", con(receive), receive.number, con(send), send.number)
    }
}

/// `WriteByIndex, transaction 3, 8 bytes`; `WriteByIndex response, transaction 0, abort: object does not exist`
impl fmt::Display for SdoCommand<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let response = if self.is_response { " response" } else { "" };
        write!(f, "{}{response}, transaction {}", self.command, self.transaction)?;
        if let Some(code) = self.abort() {
            return write!(f, ", abort: {code}");
        }
        match self.segmentation {
            Segmentation::Expedited => {}
            Segmentation::Initiate { total } => write!(f, ", first part of {total} bytes")?,
            Segmentation::Segment => f.write_str(", part")?,
            Segmentation::Complete => f.write_str(", last part")?,
        }
        write!(f, ", {}", ByteCount(self.data.len()))
    }
}

impl fmt::Display for Sdo<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "SDO, {}", self.sequence)?;
        self.command.map_or(Ok(()), |command| write!(f, ", {command}"))
    }
}

/// The header of the command layer.
pub(crate) const COMMAND_HEADER: usize = 8;
/// The size of all data, in the first part of several.
pub(crate) const TOTAL_SIZE: usize = 4;

const NUMBER: u8 = 0x3F;
const CON: u8 = 0x03;
const RESPONSE: u8 = 0x80;
const ABORT: u8 = 0x40;
const SEGMENTATION: u8 = 0x30;
const MEANING: u8 = RESPONSE | ABORT | SEGMENTATION;
const INITIATE: u8 = 0x10;
const SEGMENT: u8 = 0x20;
const COMPLETE: u8 = 0x30;
