//! Limits: how values of a type compare, and what its lowest and highest values are.

use crate::codec::{Full, Writer};
use crate::data_type::DataType;

/// The value of a numeric type, to compare it.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub(super) enum Number {
    Integer(i128),
    Real(f64),
}

impl Number {
    /// The number in the bytes; `None` if they are not one value of a numeric type.
    pub(super) fn of(data_type: DataType, bytes: &[u8]) -> Option<Self> {
        let (&last, _) = bytes.split_last()?;
        match data_type {
            _ if data_type.size() != Some(bytes.len()) => None,
            DataType::Real => Some(Self::Real(f32::from_le_bytes(bytes.try_into().ok()?).into())),
            DataType::Lreal => Some(Self::Real(f64::from_le_bytes(bytes.try_into().ok()?))),
            _ => {
                let sign = if data_type.is_signed() && last >= 0x80 { 0xFF } else { 0 };
                let mut wide = [sign; 16];
                wide.get_mut(..bytes.len())?.copy_from_slice(bytes);
                Some(Self::Integer(i128::from_le_bytes(wide)))
            }
        }
    }
}

/// The bytes of a value: the last, the one before, all others.
pub(super) type Pattern = [u8; 3];

/// Writes `value`, or the pattern if there is none.
pub(super) fn emit_or(
    value: &[u8],
    pattern: Pattern,
    data_type: DataType,
    out: &mut Writer<'_>,
) -> Result<(), Full> {
    if !value.is_empty() {
        return out.bytes(value);
    }
    let [last, before, others] = pattern;
    let size = data_type.size().unwrap_or(usize::from(data_type == DataType::ShortString));
    (0..size).rev().try_for_each(|behind| {
        out.u8(match behind {
            0 => last,
            1 => before,
            _ => others,
        })
    })
}

pub(super) const fn lowest(data_type: DataType) -> Pattern {
    match data_type {
        DataType::Real => [0xFF, 0x7F, 0xFF],
        DataType::Lreal => [0xFF, 0xEF, 0xFF],
        _ if data_type.is_signed() => [0x80, 0, 0],
        _ => ZERO,
    }
}

pub(super) const fn highest(data_type: DataType) -> Pattern {
    match data_type {
        DataType::Real => [0x7F, 0x7F, 0xFF],
        DataType::Lreal => [0x7F, 0xEF, 0xFF],
        DataType::Bool => [1, 0, 0],
        DataType::ShortString => ZERO,
        _ if data_type.is_signed() => [0x7F, 0xFF, 0xFF],
        _ => [0xFF; 3],
    }
}

/// The default of a parameter that does not tell one.
pub(super) const ZERO: Pattern = [0; 3];
