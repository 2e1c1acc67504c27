//! Numbers, dates, times and paths as they are written.

use core::fmt;
use std::vec::Vec;

/// A date.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Date {
    /// The year.
    pub year: u16,
    /// The month, 1-12.
    pub month: u8,
    /// The day, 1-31.
    pub day: u8,
}

/// A time of day.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Time {
    /// 0-23.
    pub hour: u8,
    /// 0-59.
    pub minute: u8,
    /// 0-59.
    pub second: u8,
}

/// `2026-11-22`
impl fmt::Display for Date {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04}-{:02}-{:02}", self.year, self.month, self.day)
    }
}

/// `10:00:00`
impl fmt::Display for Time {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:02}:{:02}:{:02}", self.hour, self.minute, self.second)
    }
}

#[cfg(feature = "serde")]
impl serde::Serialize for Date {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

#[cfg(feature = "serde")]
impl serde::Serialize for Time {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// Decimal, `0x` hexadecimal or `0b` binary, with an optional sign. Of a number beyond 128 bits the nearest.
pub(super) fn integer(text: &str) -> Option<i128> {
    let (is_negative, digits) = match text.strip_prefix('-') {
        Some(digits) => (true, digits),
        None => (false, text.strip_prefix('+').unwrap_or(text)),
    };
    let prefix = digits.get(..2).map(str::to_ascii_lowercase);
    let (radix, digits) = match prefix.as_deref() {
        Some("0x") => (16, digits.get(2..)?),
        Some("0b") => (2, digits.get(2..)?),
        _ => (10, digits),
    };
    if digits.is_empty() {
        return None;
    }
    let mut number: i128 = 0;
    for digit in digits.chars() {
        let digit = digit.to_digit(radix)?;
        number = number.saturating_mul(radix.into()).saturating_add(digit.into());
    }
    Some(if is_negative { number.saturating_neg() } else { number })
}

/// A number with a point or an exponent, or an integer.
pub(super) fn real(text: &str) -> Option<f64> {
    let is_numeric = text.bytes().all(|byte| byte.is_ascii_digit() || b"+-.eE".contains(&byte));
    if is_numeric { text.parse().ok() } else { None }
}

/// `mm-dd-yyyy`; two digits of the year are those of 1970-2069.
pub(super) fn date(text: &str) -> Option<Date> {
    let mut parts = text.split('-');
    let (month, day, year) = (parts.next()?, parts.next()?, parts.next()?);
    if parts.next().is_some() {
        return None;
    }
    let (month, day, digits) = (digits(month)?, digits(day)?, year.len());
    let year = digits_of(year)?;
    let year = match digits {
        4 => year,
        2 if year < 70 => year.saturating_add(2000),
        2 => year.saturating_add(1900),
        _ => return None,
    };
    let is_leap = year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    let days = match month {
        2 if is_leap => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    };
    let is_valid = (1..=12).contains(&month) && (1..=days).contains(&day);
    is_valid.then_some(Date { year, month, day })
}

/// `hh:mm:ss`
pub(super) fn time(text: &str) -> Option<Time> {
    let mut parts = text.split(':');
    let time =
        Time { hour: digits(parts.next()?)?, minute: digits(parts.next()?)?, second: digits(parts.next()?)? };
    let is_valid = parts.next().is_none() && time.hour < 24 && time.minute < 60 && time.second < 60;
    is_valid.then_some(time)
}

/// `major.minor`
pub(super) fn revision(text: &str) -> Option<(u16, u16)> {
    let (major, minor) = text.split_once('.')?;
    Some((digits_of(major)?, digits_of(minor)?))
}

/// Bytes in hexadecimal, two digits each, between blanks.
pub(super) fn path(text: &str) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    for word in text.split_ascii_whitespace() {
        let (pairs, rest) = word.as_bytes().as_chunks::<2>();
        if !rest.is_empty() {
            return None;
        }
        for &[high, low] in pairs {
            let digit = |digit: u8| char::from(digit).to_digit(16).and_then(|digit| u8::try_from(digit).ok());
            bytes.push(digit(high)? << 4 | digit(low)?);
        }
    }
    Some(bytes)
}

fn digits(text: &str) -> Option<u8> {
    digits_of(text).and_then(|number| u8::try_from(number).ok())
}

/// `u16::from_str` would take a sign.
fn digits_of(text: &str) -> Option<u16> {
    if text.bytes().all(|byte| byte.is_ascii_digit()) { text.parse().ok() } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers() {
        let cases = [
            ("0", 0),
            ("-32769", -32769),
            ("+7", 7),
            ("0x00fF", 255),
            ("0B101", 5),
            ("-0x10", -16),
            ("007", 7),
        ];
        for (text, number) in cases {
            assert_eq!(integer(text), Some(number), "{text}");
        }
        for text in ["", "-", "0x", "1.0", "0b2", "12a", "1 2", "--1", "é", "0xé"] {
            assert_eq!(integer(text), None, "{text}");
        }
        assert_eq!(integer(&"9".repeat(60)), Some(i128::MAX));
    }

    #[test]
    fn reals() {
        assert_eq!(real("-1.5e3"), Some(-1500.0));
        assert_eq!(real("10"), Some(10.0));
        for text in ["", ".", "inf", "NaN", "1,5", "e"] {
            assert_eq!(real(text), None, "{text}");
        }
    }

    #[test]
    fn dates_and_times() {
        assert_eq!(date("02-29-2024"), Some(Date { year: 2024, month: 2, day: 29 }));
        assert_eq!(date("4-1-99"), Some(Date { year: 1999, month: 4, day: 1 }));
        for text in
            ["02-29-2023", "13-01-2024", "2024-01-13", "01/13/2024", "1-1-2024-1", "+1-1-2024", "1-1-202"]
        {
            assert_eq!(date(text), None, "{text}");
        }
        assert_eq!(time("23:59:59").map(|time| (time.hour, time.second)), Some((23, 59)));
        for text in ["24:00:00", "1:60:00", "10:00", "10:00:00:00", "10-00-00"] {
            assert_eq!(time(text), None, "{text}");
        }
        assert_eq!(revision("1.12"), Some((1, 12)));
        assert_eq!(revision("1"), None);
    }

    #[test]
    fn paths() {
        assert_eq!(path("20 04 24 65 30 03"), Some([0x20, 0x04, 0x24, 0x65, 0x30, 0x03].to_vec()));
        assert_eq!(path(" 2004  2465 "), Some([0x20, 0x04, 0x24, 0x65].to_vec()));
        assert_eq!(path(""), Some(Vec::new()));
        for text in ["2", "20 4", "20 SLOT", "0x20", "20,04"] {
            assert_eq!(path(text), None, "{text}");
        }
    }
}
