//! Which faulted nodes are meant, and when they answer.

use cip_core::codec::{ParseError, Reader};

use crate::id::MacId;

/// Byte 0 of Who and of the short Identify: which faulted nodes are meant.
///
/// | Bit | Content |
/// |---|---|
/// | 7 | reserved, 0 |
/// | 6 | Match: 1 only the node whose MAC ID is Value, 0 Value is a mask |
/// | 5-0 | Value; as a mask 0x3F means every node |
///
/// Source: ICP DAS I-7242D manual p. 93.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum NodeSelection {
    /// The nodes with this MAC ID.
    MacId(MacId),
    /// The nodes whose MAC ID fits a mask of six bits. What fits says [`MaskPredicate`](crate::access::MaskPredicate).
    Mask(Mask),
}

/// A mask of six bits over MAC IDs.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(transparent))]
pub struct Mask(u8);

impl Mask {
    /// 0x3F: every node.
    pub const ALL: Self = Self(ALL_BITS);

    /// The mask of those bits; `None` for more than six.
    #[must_use]
    pub const fn new(bits: u8) -> Option<Self> {
        if bits <= ALL_BITS { Some(Self(bits)) } else { None }
    }

    /// The bits.
    #[must_use]
    pub const fn bits(self) -> u8 {
        self.0
    }
}

impl NodeSelection {
    /// Every faulted node: Match 0, Value 0x3F.
    pub const ALL: Self = Self::Mask(Mask::ALL);

    pub(super) fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        let offset = reader.offset();
        let byte = reader.u8("Match and Value")?;
        Self::from_byte(byte).ok_or(ParseError::value("Match and Value", offset, byte.into()))
    }

    const fn from_byte(byte: u8) -> Option<Self> {
        match byte {
            0x00..=0x3F => Some(Self::Mask(Mask(byte))),
            0x40..=0x7F => Some(Self::MacId(MacId::from_low_bits(byte))),
            0x80..=0xFF => None,
        }
    }

    pub(super) const fn byte(self) -> u8 {
        match self {
            Self::MacId(mac) => MATCH | mac.number(),
            Self::Mask(mask) => mask.0,
        }
    }
}

/// A byte of a [`WhoResponse`](super::WhoResponse), 0 to 6.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(transparent))]
pub struct DelayOffset(u8);

impl DelayOffset {
    /// The lowest byte of the serial number, which differs most between the devices of a plant.
    pub const SERIAL: Self = Self(3);

    /// The offset of that number; `None` above 6.
    #[must_use]
    pub const fn new(number: u8) -> Option<Self> {
        if number <= 6 { Some(Self(number)) } else { None }
    }

    /// 0 to 6.
    #[must_use]
    pub const fn number(self) -> u8 {
        self.0
    }
}

const MATCH: u8 = 0x40;
const ALL_BITS: u8 = 0x3F;
