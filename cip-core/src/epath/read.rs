//! Reading of segments.

use super::segment::{EXTENDED_PORT, KEY_FORMAT, LONG_LINK};
use super::{ElectronicKey, ExtendedSymbol, LogicalKind, PathForm, Segment, Width, read_pad};
use crate::code::{DataTypeCode, DeviceType, VendorId};
use crate::codec::{ParseError, Reader};

impl<'a> Segment<'a> {
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

fn read_words<'a>(reader: &mut Reader<'a>, field: &'static str) -> Result<&'a [u8], ParseError> {
    let words = usize::from(reader.u8("length in words")?);
    reader.bytes(words.saturating_mul(2), field)
}

fn read_extended_symbol<'a>(reader: &mut Reader<'a>) -> Result<Segment<'a>, ParseError> {
    let offset = reader.offset();
    let format = reader.u8("symbol format")?;
    let len =
        ExtendedSymbol::len_of(format).ok_or(ParseError::value("symbol format", offset, format.into()))?;
    Ok(Segment::ExtendedSymbol(ExtendedSymbol { format, data: reader.bytes(len, "symbol")? }))
}
