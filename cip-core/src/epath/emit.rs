//! Writing of segments.

use core::ops::RangeInclusive;

use super::segment::{EXTENDED_PORT, KEY_FORMAT, LONG_LINK};
use super::{ElectronicKey, ExtendedSymbol, LogicalKind, PathForm, Segment, Width, write_pad};
use crate::codec::{Full, Writer};

/// Why a segment could not be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum SegmentError {
    /// The buffer is too small.
    #[error(transparent)]
    Full(#[from] Full),
    /// A field has a value that its layout has no room for; it would be read as another one, or not at all.
    #[error("the segment has no room for this {field}")]
    Unfit {
        /// The field.
        field: &'static str,
    },
}

impl Segment<'_> {
    /// Writes the segment. What it is read back from is the same segment: a value that its layout cannot hold (a major
    /// revision above 127, an odd number of bytes where words are counted, a length or ID too large) is an error. After
    /// an error nothing of it is left in `out`.
    ///
    /// ```
    /// use cip_core::codec::Writer;
    /// use cip_core::epath::{LogicalKind, PathForm, Segment, SegmentError, Width};
    ///
    /// let mut buffer = [0; 8];
    /// let mut out = Writer::new(&mut buffer);
    /// let narrow = Segment::Logical { kind: LogicalKind::Class, width: Width::Bits8, value: 0x300 };
    /// assert_eq!(narrow.emit(PathForm::Packed, &mut out), Err(SegmentError::Unfit { field: "class" }));
    /// assert_eq!(Segment::logical(LogicalKind::Class, 0x300).emit(PathForm::Packed, &mut out), Ok(()));
    /// assert_eq!(out.written(), [0x21, 0x00, 0x03]);
    /// ```
    pub fn emit(&self, form: PathForm, out: &mut Writer<'_>) -> Result<(), SegmentError> {
        let start = out.len();
        let result = self.emit_parts(form, out);
        if result.is_err() {
            out.truncate(start);
        }
        result
    }

    fn emit_parts(&self, form: PathForm, out: &mut Writer<'_>) -> Result<(), SegmentError> {
        match *self {
            Self::Port { port, link } => emit_port(port, link, form, out),
            Self::Logical { kind, width, value } => emit_logical(kind, width, value, form, out),
            Self::ElectronicKey(key) => {
                out.bytes(&[0x34, KEY_FORMAT])?;
                key.emit(out)
            }
            Self::Network { subtype, data } => {
                let subtype = within(subtype, 0..=0x1F, "network segment subtype")?;
                out.u8(0x40 | subtype)?;
                match (subtype & 0x10 == 0, data.len()) {
                    (true, 1) => Ok(out.bytes(data)?),
                    (true, _) => Err(SegmentError::Unfit { field: "network segment" }),
                    (false, _) => emit_words(data, "network segment", out),
                }
            }
            Self::Symbol(name) => {
                let len = within(narrow(name.len(), "symbol")?, 1..=31, "symbol")?;
                out.u8(0x60 | len)?;
                Ok(out.bytes(name)?)
            }
            Self::ExtendedSymbol(ExtendedSymbol { format, data }) => {
                let len =
                    ExtendedSymbol::len_of(format).ok_or(SegmentError::Unfit { field: "symbol format" })?;
                if data.len() != len {
                    return Err(SegmentError::Unfit { field: "symbol" });
                }
                out.bytes(&[0x60, format])?;
                Ok(out.bytes(data)?)
            }
            Self::Data(data) => {
                out.u8(0x80)?;
                emit_words(data, "data segment", out)
            }
            Self::AnsiSymbol(name) => {
                out.bytes(&[0x91, narrow(name.len(), "symbol")?])?;
                out.bytes(name)?;
                Ok(write_pad(out, !name.len().is_multiple_of(2))?)
            }
            Self::ConstructedType { code, data } => {
                let code = within(code, 0xA0..=0xBF, "data type")?;
                out.bytes(&[code, narrow(data.len(), "data type")?])?;
                Ok(out.bytes(data)?)
            }
            Self::ElementaryType(code) => Ok(out.u8(within(code.0, 0xC0..=0xDF, "data type")?)?),
        }
    }
}

impl ElectronicKey {
    fn emit(&self, out: &mut Writer<'_>) -> Result<(), SegmentError> {
        let major = within(self.major, 0..=0x7F, "key major revision")?;
        out.u16(self.vendor.0)?;
        out.u16(self.device_type.0)?;
        out.u16(self.product_code)?;
        out.u8(major | if self.compatible { 0x80 } else { 0 })?;
        Ok(out.u8(self.minor)?)
    }
}

fn emit_port(port: u16, link: &[u8], form: PathForm, out: &mut Writer<'_>) -> Result<(), SegmentError> {
    let short = u8::try_from(port).ok().filter(|&port| port < EXTENDED_PORT);
    let long = link.len() != 1;
    out.u8(short.unwrap_or(EXTENDED_PORT) | if long { LONG_LINK } else { 0 })?;
    if long {
        out.u8(narrow(link.len(), "link address")?)?;
    }
    if short.is_none() {
        out.u16(port)?;
    }
    out.bytes(link)?;
    Ok(write_pad(out, form == PathForm::Padded && long && !link.len().is_multiple_of(2))?)
}

fn emit_logical(
    kind: LogicalKind,
    width: Width,
    value: u32,
    form: PathForm,
    out: &mut Writer<'_>,
) -> Result<(), SegmentError> {
    let unfit = SegmentError::Unfit { field: kind.name() };
    match width {
        Width::Bits8 => {
            out.u8(kind.bits())?;
            Ok(out.u8(u8::try_from(value).map_err(|_| unfit)?)?)
        }
        // A service has one byte only.
        Width::Bits16 | Width::Bits32 if kind == LogicalKind::Service => Err(unfit),
        Width::Bits16 => {
            out.u8(kind.bits() | 1)?;
            write_pad(out, form == PathForm::Padded)?;
            Ok(out.u16(u16::try_from(value).map_err(|_| unfit)?)?)
        }
        Width::Bits32 => {
            out.u8(kind.bits() | 2)?;
            write_pad(out, form == PathForm::Padded)?;
            Ok(out.u32(value)?)
        }
    }
}

fn emit_words(data: &[u8], field: &'static str, out: &mut Writer<'_>) -> Result<(), SegmentError> {
    if !data.len().is_multiple_of(2) {
        return Err(SegmentError::Unfit { field });
    }
    out.u8(narrow(data.len() / 2, field)?)?;
    Ok(out.bytes(data)?)
}

/// A length that has one byte.
fn narrow(len: usize, field: &'static str) -> Result<u8, SegmentError> {
    u8::try_from(len).map_err(|_| SegmentError::Unfit { field })
}

fn within(value: u8, range: RangeInclusive<u8>, field: &'static str) -> Result<u8, SegmentError> {
    if range.contains(&value) { Ok(value) } else { Err(SegmentError::Unfit { field }) }
}
