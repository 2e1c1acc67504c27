//! Values as text.

use core::fmt::{self, Write as _};

use super::Value;
use crate::epath::Epath;
use crate::text::{Hex, Quoted, write_decimal, write_hex8, write_signed};

/// Numbers in decimal, bit strings in hexadecimal, times with their unit, dates as `2026-11-22`, strings in quotes.
impl fmt::Display for Value<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Bool(value) => f.write_str(if value { "true" } else { "false" }),
            Self::Sint(value) => write_signed(f, value.into()),
            Self::Int(value) => write_signed(f, value.into()),
            Self::Dint(value) => write_signed(f, value.into()),
            Self::Lint(value) => write_signed(f, value),
            Self::Usint(value) => write_decimal(f, value.into()),
            Self::Uint(value) => write_decimal(f, value.into()),
            Self::Udint(value) => write_decimal(f, value.into()),
            Self::Ulint(value) => write_decimal(f, value),
            Self::Real(value) => fmt::Display::fmt(&value, f),
            Self::Lreal(value) => fmt::Display::fmt(&value, f),
            Self::Stime(value) => write_decimal(f, value.into()),
            Self::Date(days) => write_date(f, days),
            Self::TimeOfDay(milliseconds) => write_time_of_day(f, milliseconds),
            Self::DateAndTime { time, date } => {
                write_date(f, date)?;
                f.write_char(' ')?;
                write_time_of_day(f, time)
            }
            Self::String(bytes) | Self::ShortString(bytes) => fmt::Display::fmt(&Quoted(bytes), f),
            Self::Byte(bits) => write_bits(f, &bits.to_be_bytes()),
            Self::Word(bits) => write_bits(f, &bits.to_be_bytes()),
            Self::Dword(bits) => write_bits(f, &bits.to_be_bytes()),
            Self::Lword(bits) => write_bits(f, &bits.to_be_bytes()),
            Self::String2(bytes) | Self::StringN { width: 2, bytes } => write_utf16(f, bytes),
            Self::StringN { width: 1, bytes } => fmt::Display::fmt(&Quoted(bytes), f),
            Self::StringN { bytes: &[], .. } | Self::StringI(&[]) => f.write_str("\"\""),
            Self::StringN { bytes, .. } | Self::StringI(bytes) => fmt::Display::fmt(&Hex(bytes), f),
            Self::Ftime(microseconds) => write_with_unit(f, microseconds.into(), " us"),
            Self::Ltime(microseconds) => write_with_unit(f, microseconds, " us"),
            Self::Itime(milliseconds) => write_with_unit(f, milliseconds.into(), " ms"),
            Self::Time(milliseconds) => write_with_unit(f, milliseconds.into(), " ms"),
            Self::Epath(bytes) => fmt::Display::fmt(&Epath::packed(bytes), f),
            Self::Engunit(unit) => write_bits(f, &unit.to_be_bytes()),
        }
    }
}

fn write_with_unit(f: &mut fmt::Formatter<'_>, value: i64, unit: &str) -> fmt::Result {
    write_signed(f, value)?;
    f.write_str(unit)
}

fn write_bits(f: &mut fmt::Formatter<'_>, big_endian: &[u8]) -> fmt::Result {
    f.write_str("0x")?;
    big_endian.iter().try_for_each(|&byte| write_hex8(f, byte))
}

fn write_utf16(f: &mut fmt::Formatter<'_>, bytes: &[u8]) -> fmt::Result {
    let units = bytes.as_chunks::<2>().0.iter().map(|&unit| u16::from_le_bytes(unit));
    f.write_char('"')?;
    for character in char::decode_utf16(units) {
        let character = character.unwrap_or(char::REPLACEMENT_CHARACTER);
        match character {
            '"' | '\\' => {
                f.write_char('\\')?;
                f.write_char(character)?;
            }
            control if control.is_control() => fmt::Display::fmt(&control.escape_unicode(), f)?,
            printable => f.write_char(printable)?,
        }
    }
    f.write_char('"')
}

fn write_time_of_day(f: &mut fmt::Formatter<'_>, milliseconds: u32) -> fmt::Result {
    let (seconds, millis) = (milliseconds / 1000, milliseconds % 1000);
    let (minutes, seconds) = (seconds / 60, seconds % 60);
    write_padded(f, minutes / 60, 2)?;
    f.write_char(':')?;
    write_padded(f, minutes % 60, 2)?;
    f.write_char(':')?;
    write_padded(f, seconds, 2)?;
    f.write_char('.')?;
    write_padded(f, millis, 3)
}

fn write_date(f: &mut fmt::Formatter<'_>, days: u16) -> fmt::Result {
    let (year, month, day) = date(days);
    write_padded(f, year, 4)?;
    f.write_char('-')?;
    write_padded(f, month, 2)?;
    f.write_char('-')?;
    write_padded(f, day, 2)
}

fn write_padded(f: &mut fmt::Formatter<'_>, value: u32, width: u32) -> fmt::Result {
    for place in (1..width).rev() {
        if value >= 10_u32.saturating_pow(place) {
            break;
        }
        f.write_char('0')?;
    }
    write_decimal(f, value.into())
}

/// Year, month and day of a number of days since 1972-01-01, a leap year.
///
/// A 16-bit number of days ends in 2151. Of the years divisible by four 2100 alone is not a leap year: from its
/// 29 February on, the count goes on as if that day had existed.
fn date(days: u16) -> (u32, u32, u32) {
    let days = u32::from(days);
    let days = if days < DAYS_TO_29_FEBRUARY_2100 { days } else { days.saturating_add(1) };
    let (cycle, day_of_cycle) = (days / 1461, days % 1461);
    let (year_of_cycle, mut day) = match day_of_cycle {
        0..=365 => (0, day_of_cycle),
        later => {
            let later = later.saturating_sub(366);
            (later.saturating_div(365).saturating_add(1), later % 365)
        }
    };
    let year = cycle.saturating_mul(4).saturating_add(year_of_cycle).saturating_add(1972);
    let mut month = 1;
    for length in [31, if year_of_cycle == 0 { 29 } else { 28 }, 31, 30, 31, 30, 31, 31, 30, 31, 30] {
        let Some(rest) = day.checked_sub(length) else { break };
        day = rest;
        month = u32::saturating_add(month, 1);
    }
    (year, month, day.saturating_add(1))
}

const DAYS_TO_29_FEBRUARY_2100: u32 = 32 * 1461 + 59;

#[cfg(test)]
mod tests {
    use super::*;

    /// Dates from the calendar.
    #[test]
    fn dates() {
        let cases = [
            (0, (1972, 1, 1)),
            (59, (1972, 2, 29)),
            (60, (1972, 3, 1)),
            (365, (1972, 12, 31)),
            (366, (1973, 1, 1)),
            (1461, (1976, 1, 1)),
            (10_227, (2000, 1, 1)),
            (10_286, (2000, 2, 29)),
            (46_810, (2100, 2, 28)),
            (46_811, (2100, 3, 1)),
            (u16::MAX, (2151, 6, 6)),
        ];
        for (days, expected) in cases {
            assert_eq!(date(days), expected, "day {days}");
        }
    }
}
