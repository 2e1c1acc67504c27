//! The values that a scenario file writes in a form of its own: times, ranges of times, bit rates, comparisons, names of
//! slaves, bytes.

mod comparison;
mod rate;
mod time;

use core::fmt;

use serde::de::{self, Deserialize, Deserializer, Visitor};

pub use comparison::{Comparison, Relation};
pub(super) use rate::{RateSetting, rate};
pub use time::{Time, TimeError, TimeRange};

/// A slave of a master: the name of its node, or its MAC ID.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) enum SlaveName {
    /// `"valve"`
    Node(String),
    /// `10`, range not checked.
    Mac(i64),
}

impl<'de> Deserialize<'de> for SlaveName {
    fn deserialize<D: Deserializer<'de>>(input: D) -> Result<Self, D::Error> {
        struct NameOrNumber;
        impl Visitor<'_> for NameOrNumber {
            type Value = SlaveName;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("the name of a slave, or its MAC ID")
            }

            fn visit_i64<E: de::Error>(self, mac: i64) -> Result<SlaveName, E> {
                Ok(SlaveName::Mac(mac))
            }

            fn visit_str<E: de::Error>(self, name: &str) -> Result<SlaveName, E> {
                Ok(SlaveName::Node(name.to_owned()))
            }
        }
        input.deserialize_any(NameOrNumber)
    }
}
