//! Values of elementary types.

use super::DataType;
use crate::codec::{Full, ParseError, Reader, Writer};

/// A value of an elementary type. Strings keep their bytes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Value<'a> {
    /// BOOL
    Bool(bool),
    /// SINT
    Sint(i8),
    /// INT
    Int(i16),
    /// DINT
    Dint(i32),
    /// LINT
    Lint(i64),
    /// USINT
    Usint(u8),
    /// UINT
    Uint(u16),
    /// UDINT
    Udint(u32),
    /// ULINT
    Ulint(u64),
    /// REAL
    Real(f32),
    /// LREAL
    Lreal(f64),
    /// STIME
    Stime(u32),
    /// DATE: days since 1972-01-01.
    Date(u16),
    /// TIME_OF_DAY: milliseconds since midnight.
    TimeOfDay(u32),
    /// DATE_AND_TIME
    DateAndTime {
        /// Milliseconds since midnight.
        time: u32,
        /// Days since 1972-01-01.
        date: u16,
    },
    /// STRING
    String(&'a [u8]),
    /// BYTE
    Byte(u8),
    /// WORD
    Word(u16),
    /// DWORD
    Dword(u32),
    /// LWORD
    Lword(u64),
    /// STRING2: an even number of bytes.
    String2(&'a [u8]),
    /// FTIME: microseconds.
    Ftime(i32),
    /// LTIME: microseconds.
    Ltime(i64),
    /// ITIME: milliseconds.
    Itime(i16),
    /// STRINGN
    StringN {
        /// Bytes of a character.
        width: u16,
        /// A whole number of characters.
        bytes: &'a [u8],
    },
    /// SHORT_STRING
    ShortString(&'a [u8]),
    /// TIME: milliseconds.
    Time(i32),
    /// EPATH
    Epath(&'a [u8]),
    /// ENGUNIT
    Engunit(u16),
    /// STRINGI
    StringI(&'a [u8]),
}

impl DataType {
    /// Reads a value of the type. A BOOL other than 0 and 1 is an error.
    pub fn read<'a>(self, reader: &mut Reader<'a>) -> Result<Value<'a>, ParseError> {
        let field = self.code().name().unwrap_or("value");
        Ok(match self {
            Self::Bool => Value::Bool(read_bool(reader)?),
            Self::Sint => Value::Sint(reader.i8(field)?),
            Self::Int => Value::Int(reader.i16(field)?),
            Self::Dint => Value::Dint(reader.i32(field)?),
            Self::Lint => Value::Lint(reader.i64(field)?),
            Self::Usint => Value::Usint(reader.u8(field)?),
            Self::Uint => Value::Uint(reader.u16(field)?),
            Self::Udint => Value::Udint(reader.u32(field)?),
            Self::Ulint => Value::Ulint(reader.u64(field)?),
            Self::Real => Value::Real(reader.f32(field)?),
            Self::Lreal => Value::Lreal(reader.f64(field)?),
            Self::Stime => Value::Stime(reader.u32(field)?),
            Self::Date => Value::Date(reader.u16(field)?),
            Self::TimeOfDay => Value::TimeOfDay(reader.u32(field)?),
            Self::DateAndTime => {
                let [a, b, c, d, e, f] = reader.array(field)?;
                Value::DateAndTime {
                    time: u32::from_le_bytes([a, b, c, d]),
                    date: u16::from_le_bytes([e, f]),
                }
            }
            Self::String => Value::String(read_string(reader, 1, field)?),
            Self::Byte => Value::Byte(reader.u8(field)?),
            Self::Word => Value::Word(reader.u16(field)?),
            Self::Dword => Value::Dword(reader.u32(field)?),
            Self::Lword => Value::Lword(reader.u64(field)?),
            Self::String2 => Value::String2(read_string(reader, 2, field)?),
            Self::Ftime => Value::Ftime(reader.i32(field)?),
            Self::Ltime => Value::Ltime(reader.i64(field)?),
            Self::Itime => Value::Itime(reader.i16(field)?),
            Self::StringN => {
                let offset = reader.offset();
                let width = reader.u16("character width")?;
                let bytes = read_string(reader, width, field)?;
                if width == 0 {
                    return Err(ParseError::value("character width", offset, 0));
                }
                Value::StringN { width, bytes }
            }
            Self::ShortString => {
                let len = reader.u8("string length")?;
                Value::ShortString(reader.bytes(len.into(), field)?)
            }
            Self::Time => Value::Time(reader.i32(field)?),
            Self::Epath => Value::Epath(reader.rest()),
            Self::Engunit => Value::Engunit(reader.u16(field)?),
            Self::StringI => Value::StringI(reader.rest()),
        })
    }
}

impl Value<'_> {
    /// The type of the value.
    pub const fn data_type(&self) -> DataType {
        match self {
            Self::Bool(_) => DataType::Bool,
            Self::Sint(_) => DataType::Sint,
            Self::Int(_) => DataType::Int,
            Self::Dint(_) => DataType::Dint,
            Self::Lint(_) => DataType::Lint,
            Self::Usint(_) => DataType::Usint,
            Self::Uint(_) => DataType::Uint,
            Self::Udint(_) => DataType::Udint,
            Self::Ulint(_) => DataType::Ulint,
            Self::Real(_) => DataType::Real,
            Self::Lreal(_) => DataType::Lreal,
            Self::Stime(_) => DataType::Stime,
            Self::Date(_) => DataType::Date,
            Self::TimeOfDay(_) => DataType::TimeOfDay,
            Self::DateAndTime { .. } => DataType::DateAndTime,
            Self::String(_) => DataType::String,
            Self::Byte(_) => DataType::Byte,
            Self::Word(_) => DataType::Word,
            Self::Dword(_) => DataType::Dword,
            Self::Lword(_) => DataType::Lword,
            Self::String2(_) => DataType::String2,
            Self::Ftime(_) => DataType::Ftime,
            Self::Ltime(_) => DataType::Ltime,
            Self::Itime(_) => DataType::Itime,
            Self::StringN { .. } => DataType::StringN,
            Self::ShortString(_) => DataType::ShortString,
            Self::Time(_) => DataType::Time,
            Self::Epath(_) => DataType::Epath,
            Self::Engunit(_) => DataType::Engunit,
            Self::StringI(_) => DataType::StringI,
        }
    }

    /// Writes the value. `Full` also stands for a string longer than its length field can say, or with a broken last
    /// character.
    pub fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        match *self {
            Self::Bool(value) => out.u8(value.into()),
            Self::Sint(value) => out.i8(value),
            Self::Int(value) | Self::Itime(value) => out.i16(value),
            Self::Dint(value) | Self::Ftime(value) | Self::Time(value) => out.i32(value),
            Self::Lint(value) | Self::Ltime(value) => out.i64(value),
            Self::Usint(value) | Self::Byte(value) => out.u8(value),
            Self::Uint(value) | Self::Word(value) | Self::Date(value) | Self::Engunit(value) => {
                out.u16(value)
            }
            Self::Udint(value) | Self::Dword(value) | Self::Stime(value) | Self::TimeOfDay(value) => {
                out.u32(value)
            }
            Self::Ulint(value) | Self::Lword(value) => out.u64(value),
            Self::Real(value) => out.f32(value),
            Self::Lreal(value) => out.f64(value),
            Self::DateAndTime { time, date } => {
                out.u32(time)?;
                out.u16(date)
            }
            Self::String(bytes) => emit_string(bytes, 1, out),
            Self::String2(bytes) => emit_string(bytes, 2, out),
            Self::StringN { width, bytes } => {
                out.u16(width)?;
                emit_string(bytes, width, out)
            }
            Self::ShortString(bytes) => {
                out.u8(u8::try_from(bytes.len()).map_err(|_| Full)?)?;
                out.bytes(bytes)
            }
            Self::Epath(bytes) | Self::StringI(bytes) => out.bytes(bytes),
        }
    }
}

fn read_bool(reader: &mut Reader<'_>) -> Result<bool, ParseError> {
    let offset = reader.offset();
    match reader.u8("BOOL")? {
        0 => Ok(false),
        1 => Ok(true),
        other => Err(ParseError::value("BOOL", offset, other.into())),
    }
}

fn read_string<'a>(reader: &mut Reader<'a>, width: u16, field: &'static str) -> Result<&'a [u8], ParseError> {
    let characters = reader.u16("string length")?;
    reader.bytes(usize::from(characters).saturating_mul(width.into()), field)
}

fn emit_string(bytes: &[u8], width: u16, out: &mut Writer<'_>) -> Result<(), Full> {
    let width = usize::from(width);
    let characters = bytes.len().checked_div(width).ok_or(Full)?;
    if !bytes.len().is_multiple_of(width) {
        return Err(Full);
    }
    out.u16(u16::try_from(characters).map_err(|_| Full)?)?;
    out.bytes(bytes)
}
