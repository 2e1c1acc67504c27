//! One segment of a path.

use crate::code::{DataTypeCode, DeviceType, VendorId};

/// A segment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Segment<'a> {
    /// Leave through a port, to a link address.
    Port {
        /// The port number.
        port: u16,
        /// The link address behind the port.
        link: &'a [u8],
    },
    /// An ID.
    Logical {
        /// What the ID is of.
        kind: LogicalKind,
        /// How many bytes it takes.
        width: Width,
        /// The ID.
        value: u32,
    },
    /// `0x34 0x04`: the device that must be there.
    ElectronicKey(ElectronicKey),
    /// Parameters of the network.
    Network {
        /// Bits 4-0: 1 schedule, 2 fixed tag, 3 production inhibit time, 16 safety, 31 extended.
        subtype: u8,
        /// One byte, or if bit 4 of the subtype is set any even number.
        data: &'a [u8],
    },
    /// A name of 1-31 ASCII characters.
    Symbol(&'a [u8]),
    /// `0x60`: a name in another alphabet, or a number.
    ExtendedSymbol(ExtendedSymbol<'a>),
    /// `0x80`: data, an even number of bytes.
    Data(&'a [u8]),
    /// `0x91`: a name of up to 255 characters.
    AnsiSymbol(&'a [u8]),
    /// `0xA0-0xBF`: a constructed data type, with its description.
    ConstructedType {
        /// The first byte.
        code: u8,
        /// The description.
        data: &'a [u8],
    },
    /// `0xC0-0xDF`: an elementary data type.
    ElementaryType(DataTypeCode),
}

/// What a logical segment names: bits 4-2 of its first byte.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum LogicalKind {
    /// 0x20
    Class,
    /// 0x24
    Instance,
    /// 0x28
    Member,
    /// 0x2C
    ConnectionPoint,
    /// 0x30
    Attribute,
    /// 0x38, of one byte only.
    Service,
}

/// The number of bytes of a logical segment's value: bits 1-0 of its first byte.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Width {
    /// 00: one byte.
    Bits8,
    /// 01: two bytes.
    Bits16,
    /// 10: four bytes.
    Bits32,
}

/// The key of a device: what a path demands to be at its end.
///
/// | Bytes | Content |
/// |---|---|
/// | 0-1 | vendor |
/// | 2-3 | device type |
/// | 4-5 | product code |
/// | 6 | bit 7 compatible devices are welcome, bits 6-0 major revision |
/// | 7 | minor revision |
///
/// Zero in any of them accepts every value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ElectronicKey {
    /// The vendor.
    pub vendor: VendorId,
    /// The device type.
    pub device_type: DeviceType,
    /// The product code.
    pub product_code: u16,
    /// True if a device that can stand in for the one named is accepted.
    pub compatible: bool,
    /// The major revision, 0-127.
    pub major: u8,
    /// The minor revision.
    pub minor: u8,
}

/// A symbol segment in the extended form: the byte after `0x60` has the format in bits 7-5, the size in bits 4-0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ExtendedSymbol<'a> {
    /// Format and size: `0x20 + n` n characters of two bytes, `0x40 + n` n characters of three bytes, 0xC6 USINT,
    /// 0xC7 UINT, 0xC8 UDINT.
    pub format: u8,
    /// The bytes of the characters or of the number.
    pub data: &'a [u8],
}

impl Segment<'_> {
    /// A logical segment of the smallest width that holds `value`.
    pub const fn logical(kind: LogicalKind, value: u32) -> Self {
        Self::Logical { kind, width: Width::of(value), value }
    }
}

impl LogicalKind {
    /// The word used for it in texts.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Class => "class",
            Self::Instance => "instance",
            Self::Member => "member",
            Self::ConnectionPoint => "connection point",
            Self::Attribute => "attribute",
            Self::Service => "service",
        }
    }

    pub(super) const fn bits(self) -> u8 {
        match self {
            Self::Class => 0x20,
            Self::Instance => 0x24,
            Self::Member => 0x28,
            Self::ConnectionPoint => 0x2C,
            Self::Attribute => 0x30,
            Self::Service => 0x38,
        }
    }
}

impl Width {
    /// The smallest width that holds `value`.
    pub const fn of(value: u32) -> Self {
        match value {
            0..=0xFF => Self::Bits8,
            0x100..=0xFFFF => Self::Bits16,
            0x1_0000.. => Self::Bits32,
        }
    }
}

impl ExtendedSymbol<'_> {
    /// The number of bytes after the format byte; `None` for a format that does not exist.
    pub(super) fn len_of(format: u8) -> Option<usize> {
        let size = usize::from(format & 0x1F);
        match (format & 0xE0, size) {
            (0x20, 1..) => Some(size.saturating_mul(2)),
            (0x40, 1..) => Some(size.saturating_mul(3)),
            (0xC0, 6) => Some(1),
            (0xC0, 7) => Some(2),
            (0xC0, 8) => Some(4),
            _ => None,
        }
    }
}

pub(super) const KEY_FORMAT: u8 = 0x04;
pub(super) const LONG_LINK: u8 = 0x10;
pub(super) const EXTENDED_PORT: u8 = 0x0F;
