//! One segment of a path.

use super::{PathForm, read_pad, write_pad};
use crate::code::{DataTypeCode, DeviceType, VendorId};
use crate::codec::{Full, ParseError, Reader, Writer};

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

impl<'a> Segment<'a> {
    /// A logical segment of the smallest width that holds `value`.
    pub const fn logical(kind: LogicalKind, value: u32) -> Self {
        Self::Logical { kind, width: Width::of(value), value }
    }

    /// Reads the segment at the front of `reader`.
    pub fn read(reader: &mut Reader<'a>, form: PathForm) -> Result<Self, ParseError> {
        let offset = reader.offset();
        let first = reader.u8("segment")?;
        let low = first & 0x1F;
        match first >> 5 {
            0 => read_port(reader, first, form),
            1 => read_logical(reader, first, offset, form),
            2 if low & 0x10 == 0 => {
                Ok(Self::Network { subtype: low, data: reader.bytes(1, "network segment")? })
            }
            2 => Ok(Self::Network { subtype: low, data: read_words(reader, "network segment")? }),
            3 if low == 0 => read_extended_symbol(reader),
            3 => Ok(Self::Symbol(reader.bytes(low.into(), "symbol")?)),
            4 => match low {
                0x00 => Ok(Self::Data(read_words(reader, "data segment")?)),
                0x11 => {
                    let len = usize::from(reader.u8("symbol length")?);
                    let name = reader.bytes(len, "symbol")?;
                    read_pad(reader, !len.is_multiple_of(2))?;
                    Ok(Self::AnsiSymbol(name))
                }
                _ => Err(ParseError::value("data segment subtype", offset, first.into())),
            },
            5 => {
                let len = reader.u8("data type length")?;
                Ok(Self::ConstructedType { code: first, data: reader.bytes(len.into(), "data type")? })
            }
            6 => Ok(Self::ElementaryType(DataTypeCode(first))),
            _ => Err(ParseError::value("segment type", offset, first.into())),
        }
    }

    /// Writes the segment. `Full` also stands for a segment whose data do not fit its layout: more than 255 words or
    /// bytes, or an odd number of bytes where words are counted.
    pub fn emit(&self, form: PathForm, out: &mut Writer<'_>) -> Result<(), Full> {
        match *self {
            Self::Port { port, link } => emit_port(port, link, form, out),
            Self::Logical { kind, width, value } => emit_logical(kind, width, value, form, out),
            Self::ElectronicKey(key) => {
                out.bytes(&[0x34, KEY_FORMAT])?;
                key.emit(out)
            }
            Self::Network { subtype, data } => {
                out.u8(0x40 | (subtype & 0x1F))?;
                match (subtype & 0x10 == 0, data.len()) {
                    (true, 1) => out.bytes(data),
                    (true, _) => Err(Full),
                    (false, _) => emit_words(data, out),
                }
            }
            Self::Symbol(name) => {
                let len = u8::try_from(name.len()).ok().filter(|len| (1..=31).contains(len)).ok_or(Full)?;
                out.u8(0x60 | len)?;
                out.bytes(name)
            }
            Self::ExtendedSymbol(symbol) => {
                out.bytes(&[0x60, symbol.format])?;
                out.bytes(symbol.data)
            }
            Self::Data(data) => {
                out.u8(0x80)?;
                emit_words(data, out)
            }
            Self::AnsiSymbol(name) => {
                out.bytes(&[0x91, u8::try_from(name.len()).map_err(|_| Full)?])?;
                out.bytes(name)?;
                write_pad(out, !name.len().is_multiple_of(2))
            }
            Self::ConstructedType { code, data } => {
                out.bytes(&[0xA0 | (code & 0x1F), u8::try_from(data.len()).map_err(|_| Full)?])?;
                out.bytes(data)
            }
            Self::ElementaryType(code) => out.u8(code.0),
        }
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

    const fn bits(self) -> u8 {
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

impl ElectronicKey {
    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        let vendor = VendorId(reader.u16("key vendor")?);
        let device_type = DeviceType(reader.u16("key device type")?);
        let product_code = reader.u16("key product code")?;
        let major = reader.u8("key major revision")?;
        let minor = reader.u8("key minor revision")?;
        let compatible = major & 0x80 != 0;
        Ok(Self { vendor, device_type, product_code, compatible, major: major & 0x7F, minor })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u16(self.vendor.0)?;
        out.u16(self.device_type.0)?;
        out.u16(self.product_code)?;
        out.u8((self.major & 0x7F) | if self.compatible { 0x80 } else { 0 })?;
        out.u8(self.minor)
    }
}

fn read_port<'a>(reader: &mut Reader<'a>, first: u8, form: PathForm) -> Result<Segment<'a>, ParseError> {
    let len = if first & LONG_LINK != 0 { Some(reader.u8("link address length")?) } else { None };
    let port = match first & 0x0F {
        EXTENDED_PORT => reader.u16("extended port")?,
        port => port.into(),
    };
    let link = reader.bytes(len.unwrap_or(1).into(), "link address")?;
    read_pad(reader, form == PathForm::Padded && len.is_some() && !link.len().is_multiple_of(2))?;
    Ok(Segment::Port { port, link })
}

fn emit_port(port: u16, link: &[u8], form: PathForm, out: &mut Writer<'_>) -> Result<(), Full> {
    let short = u8::try_from(port).ok().filter(|&port| port < EXTENDED_PORT);
    let long = link.len() != 1;
    out.u8(short.unwrap_or(EXTENDED_PORT) | if long { LONG_LINK } else { 0 })?;
    if long {
        out.u8(u8::try_from(link.len()).map_err(|_| Full)?)?;
    }
    if short.is_none() {
        out.u16(port)?;
    }
    out.bytes(link)?;
    write_pad(out, form == PathForm::Padded && long && !link.len().is_multiple_of(2))
}

fn read_logical<'a>(
    reader: &mut Reader<'a>,
    first: u8,
    offset: usize,
    form: PathForm,
) -> Result<Segment<'a>, ParseError> {
    let kind = match first & 0x3C {
        0x20 => LogicalKind::Class,
        0x24 => LogicalKind::Instance,
        0x28 => LogicalKind::Member,
        0x2C => LogicalKind::ConnectionPoint,
        0x30 => LogicalKind::Attribute,
        0x34 if first == 0x34 => {
            let at = reader.offset();
            return match reader.u8("key format")? {
                KEY_FORMAT => Ok(Segment::ElectronicKey(ElectronicKey::read(reader)?)),
                other => Err(ParseError::value("key format", at, other.into())),
            };
        }
        0x38 if first == 0x38 => LogicalKind::Service,
        _ => return Err(ParseError::value("logical segment", offset, first.into())),
    };
    let (width, value) = match first & 0x03 {
        0 => (Width::Bits8, reader.u8(kind.name())?.into()),
        1 => {
            read_pad(reader, form == PathForm::Padded)?;
            (Width::Bits16, reader.u16(kind.name())?.into())
        }
        2 => {
            read_pad(reader, form == PathForm::Padded)?;
            (Width::Bits32, reader.u32(kind.name())?)
        }
        _ => return Err(ParseError::value("logical segment", offset, first.into())),
    };
    Ok(Segment::Logical { kind, width, value })
}

fn emit_logical(
    kind: LogicalKind,
    width: Width,
    value: u32,
    form: PathForm,
    out: &mut Writer<'_>,
) -> Result<(), Full> {
    match width {
        Width::Bits8 => {
            out.u8(kind.bits())?;
            out.u8(u8::try_from(value).map_err(|_| Full)?)
        }
        Width::Bits16 => {
            out.u8(kind.bits() | 1)?;
            write_pad(out, form == PathForm::Padded)?;
            out.u16(u16::try_from(value).map_err(|_| Full)?)
        }
        Width::Bits32 => {
            out.u8(kind.bits() | 2)?;
            write_pad(out, form == PathForm::Padded)?;
            out.u32(value)
        }
    }
}

fn read_words<'a>(reader: &mut Reader<'a>, field: &'static str) -> Result<&'a [u8], ParseError> {
    let words = usize::from(reader.u8("length in words")?);
    reader.bytes(words.saturating_mul(2), field)
}

fn emit_words(data: &[u8], out: &mut Writer<'_>) -> Result<(), Full> {
    if !data.len().is_multiple_of(2) {
        return Err(Full);
    }
    out.u8(u8::try_from(data.len() / 2).map_err(|_| Full)?)?;
    out.bytes(data)
}

fn read_extended_symbol<'a>(reader: &mut Reader<'a>) -> Result<Segment<'a>, ParseError> {
    let offset = reader.offset();
    let format = reader.u8("symbol format")?;
    let size = usize::from(format & 0x1F);
    let len = match (format & 0xE0, size) {
        (0x20, 1..) => size.saturating_mul(2),
        (0x40, 1..) => size.saturating_mul(3),
        (0xC0, 6) => 1,
        (0xC0, 7) => 2,
        (0xC0, 8) => 4,
        _ => return Err(ParseError::value("symbol format", offset, format.into())),
    };
    Ok(Segment::ExtendedSymbol(ExtendedSymbol { format, data: reader.bytes(len, "symbol")? }))
}

const KEY_FORMAT: u8 = 0x04;
const LONG_LINK: u8 = 0x10;
const EXTENDED_PORT: u8 = 0x0F;
