//! Bit rates.

use core::fmt;

use serde::de::{self, Deserialize, Deserializer, Visitor};

/// `125_000`, `"125k"` or `"auto"`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(in crate::scenario) enum RateSetting {
    /// bit/s, range not checked.
    Fixed(i64),
    /// To be found by listening.
    Auto,
}

impl<'de> Deserialize<'de> for RateSetting {
    fn deserialize<D: Deserializer<'de>>(input: D) -> Result<Self, D::Error> {
        struct NumberOrAuto;
        impl Visitor<'_> for NumberOrAuto {
            type Value = RateSetting;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(EXPECTED_RATE)
            }

            fn visit_i64<E: de::Error>(self, rate: i64) -> Result<RateSetting, E> {
                Ok(RateSetting::Fixed(rate))
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<RateSetting, E> {
                match text {
                    "auto" => Ok(RateSetting::Auto),
                    _ => (rate(text).map(RateSetting::Fixed))
                        .ok_or_else(|| E::invalid_value(de::Unexpected::Str(text), &self)),
                }
            }
        }
        input.deserialize_any(NumberOrAuto)
    }
}

/// bit/s of `125k` or `1M`.
pub(in crate::scenario) fn rate(text: &str) -> Option<i64> {
    let (number, unit) = match text.strip_suffix(['k', 'K']) {
        Some(number) => (number, 1_000),
        None => (text.strip_suffix('M')?, 1_000_000),
    };
    let number: u32 = number.trim_end().parse().ok()?;
    i64::from(number).checked_mul(unit)
}

const EXPECTED_RATE: &str = "a bit rate in bit/s such as 125_000, or a text such as \"125k\"";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bit_rates_may_have_a_unit() {
        for (text, expected) in [
            ("125k", Some(125_000)),
            ("500 K", Some(500_000)),
            ("1M", Some(1_000_000)),
            ("125", None),
            ("k", None),
        ] {
            assert_eq!(rate(text), expected, "{text}");
        }
    }
}
