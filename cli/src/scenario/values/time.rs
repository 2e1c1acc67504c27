//! Times and ranges of times.

use core::fmt;
use core::str::FromStr;
use core::time::Duration;

use serde::de::{self, Deserialize, Deserializer, MapAccess, Visitor};

/// A time with its unit: `"300us"`, `"75ms"`, `"1.5s"`, `"2min"`; units are ns, us, ms, s, min and h.
///
/// ```
/// use devicenet_cli::scenario::Time;
/// assert_eq!("1.5s".parse::<Time>().unwrap().0.as_millis(), 1500);
/// assert!("1.5".parse::<Time>().is_err());
/// ```
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Default)]
pub struct Time(pub Duration);

/// Why a text is not a [`Time`].
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct TimeError {
    found: String,
    problem: &'static str,
}

impl fmt::Display for TimeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{}` {}; expected {EXPECTED_TIME}", self.found, self.problem)
    }
}

impl core::error::Error for TimeError {}

impl FromStr for Time {
    type Err = TimeError;

    fn from_str(text: &str) -> Result<Self, TimeError> {
        let fail = |problem| TimeError { found: text.to_owned(), problem };
        if text.starts_with('-') {
            return Err(fail("must not be negative"));
        }
        let split = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
        let (number, unit) = text.split_at(split);
        let Some((_, nanos)) = UNITS.iter().find(|(name, _)| *name == unit.trim_start()) else {
            return Err(fail(if unit.is_empty() { "has no unit" } else { "has an unknown unit" }));
        };
        let (whole, fraction) = number.split_once('.').unwrap_or((number, ""));
        let digits = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
        if !digits(whole) || (number.contains('.') && !digits(fraction)) {
            return Err(fail("is not a number with a unit"));
        }
        let whole: u64 = whole.parse().map_err(|_| fail("is too long"))?;
        let mut total = whole.checked_mul(*nanos).ok_or_else(|| fail("is too long"))?;
        let mut place = *nanos;
        for digit in fraction.bytes().map(|byte| u64::from(byte - b'0')) {
            // A minute is not a power of ten: its tenth is exact all the same, and so on down to a nanosecond.
            if (place == 0 || place % 10 != 0) && digit != 0 {
                return Err(fail("is finer than a nanosecond"));
            }
            place /= 10;
            total = total.checked_add(digit * place).ok_or_else(|| fail("is too long"))?;
        }
        Ok(Self(Duration::from_nanos(total)))
    }
}

/// The shortest exact form: `75ms`, `1.5s`.
impl fmt::Display for Time {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let nanos = self.0.as_nanos();
        let (unit, size) = match nanos {
            1..1_000 => ("ns", 1),
            1_000..1_000_000 => ("us", 1_000),
            1_000_000..1_000_000_000 => ("ms", 1_000_000),
            _ => ("s", 1_000_000_000),
        };
        let fraction = nanos % size;
        if fraction == 0 {
            return write!(f, "{}{unit}", nanos / size);
        }
        let width = size.ilog10() as usize;
        let digits = format!("{fraction:0width$}");
        write!(f, "{}.{}{unit}", nanos / size, digits.trim_end_matches('0'))
    }
}

impl<'de> Deserialize<'de> for Time {
    fn deserialize<D: Deserializer<'de>>(input: D) -> Result<Self, D::Error> {
        struct Text;
        impl Visitor<'_> for Text {
            type Value = Time;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(EXPECTED_TIME)
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<Time, E> {
                text.parse().map_err(E::custom)
            }
        }
        input.deserialize_any(Text)
    }
}

/// One time, or a range of which the seed draws: `"300us"` or `{ min = "200us", max = "1ms" }`, both ends included.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct TimeRange {
    /// The least.
    pub min: Duration,
    /// The greatest, not below `min`.
    pub max: Duration,
}

impl<'de> Deserialize<'de> for TimeRange {
    fn deserialize<D: Deserializer<'de>>(input: D) -> Result<Self, D::Error> {
        struct TextOrTable;
        impl<'de> Visitor<'de> for TextOrTable {
            type Value = TimeRange;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{EXPECTED_TIME}, or a range such as {{ min = \"1ms\", max = \"2ms\" }}")
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<TimeRange, E> {
                let Time(time) = text.parse().map_err(E::custom)?;
                Ok(TimeRange { min: time, max: time })
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<TimeRange, A::Error> {
                let (mut min, mut max) = (None, None);
                while let Some(key) = map.next_key::<String>()? {
                    match key.as_str() {
                        "min" => min = Some(map.next_value::<Time>()?),
                        "max" => max = Some(map.next_value::<Time>()?),
                        _ => return Err(de::Error::unknown_field(&key, &["min", "max"])),
                    }
                }
                let Time(min) = min.ok_or_else(|| de::Error::missing_field("min"))?;
                let Time(max) = max.ok_or_else(|| de::Error::missing_field("max"))?;
                if min > max {
                    let (min, max) = (Time(min), Time(max));
                    return Err(de::Error::custom(format!(
                        "the range begins at {min} and ends at {max} before that"
                    )));
                }
                Ok(TimeRange { min, max })
            }
        }
        input.deserialize_any(TextOrTable)
    }
}

const EXPECTED_TIME: &str = "a time with a unit (ns, us, ms, s, min, h) such as \"75ms\" or \"1.5s\"";

const UNITS: [(&str, u64); 6] = [
    ("ns", 1),
    ("us", 1_000),
    ("ms", 1_000_000),
    ("s", 1_000_000_000),
    ("min", 60_000_000_000),
    ("h", 3_600_000_000_000),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_exact() {
        for (text, nanos) in [
            ("0s", 0),
            ("300us", 300_000),
            ("75ms", 75_000_000),
            ("1.5s", 1_500_000_000),
            ("2min", 120_000_000_000),
            ("0.5min", 30_000_000_000),
            ("1.000000001s", 1_000_000_001),
            ("3 ms", 3_000_000),
            ("1.000000000000s", 1_000_000_000),
        ] {
            assert_eq!(text.parse(), Ok(Time(Duration::from_nanos(nanos))), "{text}");
        }
    }

    #[test]
    fn a_bad_time_says_what_is_wrong_with_it() {
        for (text, problem) in [
            ("5", "has no unit"),
            ("5m", "has an unknown unit"),
            ("-5ms", "must not be negative"),
            ("ms", "is not a number with a unit"),
            ("1.s", "is not a number with a unit"),
            ("1.2.3s", "is not a number with a unit"),
            ("0.5ns", "is finer than a nanosecond"),
            ("1.0000000001s", "is finer than a nanosecond"),
            ("1.00000000001s", "is finer than a nanosecond"),
            ("99999999999h", "is too long"),
        ] {
            assert_eq!(text.parse::<Time>().map_err(|error| error.problem), Err(problem), "{text}");
        }
    }

    #[test]
    fn times_print_as_they_are_written() {
        for text in ["0s", "300us", "75ms", "1.5s", "120s", "1.000000001s", "12ns"] {
            assert_eq!(text.parse::<Time>().unwrap().to_string(), text);
        }
    }
}
