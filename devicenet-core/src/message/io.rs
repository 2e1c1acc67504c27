//! I/O messages: no header, no service; the meaning lies in the identifier and in the sizes of the connection.

use cip_core::codec::{Full, ParseError, Reader, Tail, Wire, Writer};
use cip_core::fragment::{FragmentByte, FragmentKind};

use super::explicit::rest;
use crate::id::MacId;

/// Bit-strobe command of a master in run mode, on `0x400 + 8m`, where m is the *master*: one output bit for each node.
///
/// | Byte | Content |
/// |---|---|
/// | n / 8 | bit n % 8 is the output bit of the slave with MAC ID n; bit 0 is the least significant |
///
/// Eight bytes, every value is valid. Every slave whose bit-strobe connection is established answers, whatever its bit.
/// A strobe without data is [`EmptyIo`]: the master is idle. Source: CIP Vol. 3; Networking with DeviceNet (Circuit
/// Cellar 98, 1998); NI-DNET manual.
///
/// ```
/// use devicenet_core::{MacId, message::{BitStrobeCommand, Wire}};
///
/// let strobe = BitStrobeCommand::default().with(MacId::new(37).unwrap(), true);
/// assert_eq!(BitStrobeCommand::parse(&[0, 0, 0, 0, 0x20, 0, 0, 0]), Ok(strobe));
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(transparent))]
pub struct BitStrobeCommand {
    bits: u64,
}

impl BitStrobeCommand {
    /// Bit n of the number is the output bit of MAC ID n.
    #[must_use]
    pub const fn from_bits(bits: u64) -> Self {
        Self { bits }
    }

    /// Bit n of the number is the output bit of MAC ID n.
    #[must_use]
    pub const fn bits(self) -> u64 {
        self.bits
    }

    /// The output bit of a slave.
    #[must_use]
    pub const fn bit(self, slave: MacId) -> bool {
        self.bits & bit_of(slave) != 0
    }

    /// The command with another output bit for a slave.
    #[must_use]
    pub const fn with(self, slave: MacId, on: bool) -> Self {
        let others = self.bits & !bit_of(slave);
        Self { bits: if on { others | bit_of(slave) } else { others } }
    }
}

/// An I/O message without data: the sender is idle, acknowledges, or has nothing configured to send.
///
/// | Byte | Content |
/// |---|---|
/// | - | none: DLC 0 |
///
/// Source: CIP Vol. 3; MKS Baratron DMA manual, appendix D.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct EmptyIo;

/// A fragment of an I/O message on a connection whose configured size is above eight bytes. Nothing on the wire says so.
///
/// | Byte | Content |
/// |---|---|
/// | 0 | bits 7-6 type: 00 first, 01 middle, 10 last; bits 5-0 count, 0x3F in a first fragment that is the only one |
/// | 1-7 | a part of the data, 0 to 7 bytes |
///
/// Never acknowledged; an acknowledge type is refused. Source: CIP Vol. 3, fragmentation protocol; ICP DAS I-7242D
/// manual p. 95.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct IoFragment<'a> {
    /// First, middle or last, and its count; not an acknowledge.
    pub fragment: FragmentByte,
    /// The part, at most seven bytes.
    pub data: &'a [u8],
}

impl Wire<'_> for BitStrobeCommand {
    const NAME: &'static str = "bit-strobe command";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        reader.u64("strobe bits").map(Self::from_bits)
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u64(self.bits)
    }

    fn wire_len(&self) -> usize {
        8
    }
}

impl Wire<'_> for EmptyIo {
    const NAME: &'static str = "empty I/O message";

    fn read(_: &mut Reader<'_>) -> Result<Self, ParseError> {
        Ok(Self)
    }

    fn emit(&self, _: &mut Writer<'_>) -> Result<(), Full> {
        Ok(())
    }

    fn wire_len(&self) -> usize {
        0
    }
}

impl<'a> Wire<'a> for IoFragment<'a> {
    const NAME: &'static str = "I/O fragment";
    const TAIL: Tail = Tail::Open;

    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        let offset = reader.offset();
        let byte = reader.u8("fragmentation byte")?;
        let fragment = FragmentByte::from(byte);
        if fragment.kind == FragmentKind::Acknowledge {
            return Err(ParseError::value("fragment type", offset, byte.into()));
        }
        Ok(Self { fragment, data: rest(reader, MAX_PART)? })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u8(self.fragment.into())?;
        out.bytes(self.data)
    }

    fn wire_len(&self) -> usize {
        self.data.len().saturating_add(1)
    }
}

const fn bit_of(slave: MacId) -> u64 {
    1_u64.rotate_left(u32::from_le_bytes([slave.number(), 0, 0, 0]))
}

const MAX_PART: usize = 7;
