//! Elementary data types and their values (CIP Vol. 1, appendix C).
//!
//! ```
//! use cip_core::code::DataTypeCode;
//! use cip_core::codec::Reader;
//! use cip_core::data_type::{DataType, Value};
//!
//! let ty = DataType::from_code(DataTypeCode(0xDA)).ok_or("unknown type")?;
//! let value = ty.read(&mut Reader::new(b"\x08GRT1-DRT")).map_err(|_| "too short")?;
//! assert_eq!(value, Value::ShortString(b"GRT1-DRT"));
//! assert_eq!(value.to_string(), "\"GRT1-DRT\"");
//! # Ok::<(), &str>(())
//! ```

mod display;
mod value;

pub use value::Value;

use core::ops::RangeInclusive;

use crate::code::DataTypeCode;

/// An elementary data type. All multi-byte values are little-endian.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum DataType {
    /// One byte as an attribute: 0 false, 1 true. One bit in an assembly.
    Bool,
    /// Signed, 1 byte.
    Sint,
    /// Signed, 2 bytes.
    Int,
    /// Signed, 4 bytes.
    Dint,
    /// Signed, 8 bytes.
    Lint,
    /// Unsigned, 1 byte.
    Usint,
    /// Unsigned, 2 bytes.
    Uint,
    /// Unsigned, 4 bytes.
    Udint,
    /// Unsigned, 8 bytes.
    Ulint,
    /// IEEE 754, 4 bytes.
    Real,
    /// IEEE 754, 8 bytes.
    Lreal,
    /// Synchronous time, 4 bytes.
    Stime,
    /// Days since 1972-01-01, 2 bytes.
    Date,
    /// Milliseconds since midnight, 4 bytes.
    TimeOfDay,
    /// Time of day, then date, 6 bytes.
    DateAndTime,
    /// A 16-bit length and as many characters of 1 byte.
    String,
    /// 8 bits.
    Byte,
    /// 16 bits.
    Word,
    /// 32 bits.
    Dword,
    /// 64 bits.
    Lword,
    /// A 16-bit length and as many characters of 2 bytes.
    String2,
    /// Microseconds, signed, 4 bytes.
    Ftime,
    /// Microseconds, signed, 8 bytes.
    Ltime,
    /// Milliseconds, signed, 2 bytes.
    Itime,
    /// A 16-bit character width, a 16-bit length, and the characters.
    StringN,
    /// An 8-bit length and as many characters of ISO 8859-1.
    ShortString,
    /// Milliseconds, signed, 4 bytes.
    Time,
    /// A path, packed on DeviceNet. Takes all bytes that remain.
    Epath,
    /// Engineering unit, 2 bytes.
    Engunit,
    /// International string. Takes all bytes that remain.
    StringI,
}

impl DataType {
    /// All types in the order of their codes.
    pub const ALL: [Self; 30] = [
        Self::Bool,
        Self::Sint,
        Self::Int,
        Self::Dint,
        Self::Lint,
        Self::Usint,
        Self::Uint,
        Self::Udint,
        Self::Ulint,
        Self::Real,
        Self::Lreal,
        Self::Stime,
        Self::Date,
        Self::TimeOfDay,
        Self::DateAndTime,
        Self::String,
        Self::Byte,
        Self::Word,
        Self::Dword,
        Self::Lword,
        Self::String2,
        Self::Ftime,
        Self::Ltime,
        Self::Itime,
        Self::StringN,
        Self::ShortString,
        Self::Time,
        Self::Epath,
        Self::Engunit,
        Self::StringI,
    ];

    /// True for whole numbers and times that can be negative.
    pub const fn is_signed(self) -> bool {
        matches!(
            self,
            Self::Sint
                | Self::Int
                | Self::Dint
                | Self::Lint
                | Self::Itime
                | Self::Time
                | Self::Ftime
                | Self::Ltime
        )
    }

    /// The whole numbers that a value can be, bits and times included; `None` for everything else.
    ///
    /// ```
    /// use cip_core::data_type::DataType;
    ///
    /// assert_eq!(DataType::Usint.numbers(), Some(0..=255));
    /// assert_eq!(DataType::Bool.numbers(), Some(0..=1));
    /// assert_eq!(DataType::Real.numbers(), None);
    /// ```
    pub fn numbers(self) -> Option<RangeInclusive<i128>> {
        if matches!(self, Self::Real | Self::Lreal | Self::DateAndTime) {
            return None;
        }
        if self == Self::Bool {
            return Some(0..=1);
        }
        let numbers = |signed: (i128, i128), unsigned: u64| match self.is_signed() {
            true => signed.0..=signed.1,
            false => 0..=unsigned.into(),
        };
        Some(match self.size()? {
            1 => numbers((i8::MIN.into(), i8::MAX.into()), u8::MAX.into()),
            2 => numbers((i16::MIN.into(), i16::MAX.into()), u16::MAX.into()),
            4 => numbers((i32::MIN.into(), i32::MAX.into()), u32::MAX.into()),
            8 => numbers((i64::MIN.into(), i64::MAX.into()), u64::MAX),
            _ => return None,
        })
    }

    /// The type with this code, of either set of codes.
    pub fn from_code(code: DataTypeCode) -> Option<Self> {
        let canonical = code.canonical();
        Self::ALL.into_iter().find(|ty| ty.code() == canonical)
    }

    /// The code, of the set 0xC1-0xDE.
    pub const fn code(self) -> DataTypeCode {
        match self {
            Self::Bool => DataTypeCode::BOOL,
            Self::Sint => DataTypeCode::SINT,
            Self::Int => DataTypeCode::INT,
            Self::Dint => DataTypeCode::DINT,
            Self::Lint => DataTypeCode::LINT,
            Self::Usint => DataTypeCode::USINT,
            Self::Uint => DataTypeCode::UINT,
            Self::Udint => DataTypeCode::UDINT,
            Self::Ulint => DataTypeCode::ULINT,
            Self::Real => DataTypeCode::REAL,
            Self::Lreal => DataTypeCode::LREAL,
            Self::Stime => DataTypeCode::STIME,
            Self::Date => DataTypeCode::DATE,
            Self::TimeOfDay => DataTypeCode::TIME_OF_DAY,
            Self::DateAndTime => DataTypeCode::DATE_AND_TIME,
            Self::String => DataTypeCode::STRING,
            Self::Byte => DataTypeCode::BYTE,
            Self::Word => DataTypeCode::WORD,
            Self::Dword => DataTypeCode::DWORD,
            Self::Lword => DataTypeCode::LWORD,
            Self::String2 => DataTypeCode::STRING2,
            Self::Ftime => DataTypeCode::FTIME,
            Self::Ltime => DataTypeCode::LTIME,
            Self::Itime => DataTypeCode::ITIME,
            Self::StringN => DataTypeCode::STRINGN,
            Self::ShortString => DataTypeCode::SHORT_STRING,
            Self::Time => DataTypeCode::TIME,
            Self::Epath => DataTypeCode::EPATH,
            Self::Engunit => DataTypeCode::ENGUNIT,
            Self::StringI => DataTypeCode::STRINGI,
        }
    }

    /// The number of bytes of a value, if all values have the same.
    pub const fn size(self) -> Option<usize> {
        Some(match self {
            Self::Bool | Self::Sint | Self::Usint | Self::Byte => 1,
            Self::Int | Self::Uint | Self::Word | Self::Date | Self::Itime | Self::Engunit => 2,
            Self::Dint | Self::Udint | Self::Dword | Self::Real => 4,
            Self::Stime | Self::TimeOfDay | Self::Ftime | Self::Time => 4,
            Self::DateAndTime => 6,
            Self::Lint | Self::Ulint | Self::Lword | Self::Lreal | Self::Ltime => 8,
            Self::String | Self::String2 | Self::StringN | Self::ShortString => return None,
            Self::Epath | Self::StringI => return None,
        })
    }
}

#[cfg(test)]
mod tests;
