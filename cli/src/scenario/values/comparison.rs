//! Comparisons with a number.

use core::fmt;
use core::str::FromStr;

use serde::de::{self, Deserialize, Deserializer, Visitor};

/// A comparison with a number: `"<128"`, `">=96"`, `"=0"`, or just the number.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Comparison {
    /// How.
    pub relation: Relation,
    /// With what.
    pub bound: u16,
}

/// The relation of a [`Comparison`].
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Relation {
    /// `<`
    Less,
    /// `<=`
    LessOrEqual,
    /// `=`
    Equal,
    /// `!=`
    NotEqual,
    /// `>=`
    GreaterOrEqual,
    /// `>`
    Greater,
}

impl Comparison {
    /// Whether it holds of `value`.
    #[must_use]
    pub fn holds(self, value: u16) -> bool {
        match self.relation {
            Relation::Less => value < self.bound,
            Relation::LessOrEqual => value <= self.bound,
            Relation::Equal => value == self.bound,
            Relation::NotEqual => value != self.bound,
            Relation::GreaterOrEqual => value >= self.bound,
            Relation::Greater => value > self.bound,
        }
    }
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = match self.relation {
            Relation::Less => "<",
            Relation::LessOrEqual => "<=",
            Relation::Equal => "=",
            Relation::NotEqual => "!=",
            Relation::GreaterOrEqual => ">=",
            Relation::Greater => ">",
        };
        write!(f, "{sign} {}", self.bound)
    }
}

impl FromStr for Comparison {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = RELATIONS.iter().find_map(|(sign, relation)| Some((relation, text.strip_prefix(sign)?)));
        let (relation, number) = found.unwrap_or((&Relation::Equal, text));
        match number.trim().parse() {
            Ok(bound) => Ok(Self { relation: *relation, bound }),
            Err(_) => Err(format!("`{text}` is not a comparison; expected {EXPECTED_COMPARISON}")),
        }
    }
}

impl<'de> Deserialize<'de> for Comparison {
    fn deserialize<D: Deserializer<'de>>(input: D) -> Result<Self, D::Error> {
        struct TextOrNumber;
        impl Visitor<'_> for TextOrNumber {
            type Value = Comparison;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(EXPECTED_COMPARISON)
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<Comparison, E> {
                text.parse().map_err(E::custom)
            }

            fn visit_i64<E: de::Error>(self, number: i64) -> Result<Comparison, E> {
                let bound = u16::try_from(number)
                    .map_err(|_| E::invalid_value(de::Unexpected::Signed(number), &self))?;
                Ok(Comparison { relation: Relation::Equal, bound })
            }
        }
        input.deserialize_any(TextOrNumber)
    }
}

const EXPECTED_COMPARISON: &str = "a number, or one with a sign (<, <=, =, !=, >=, >) such as \"<128\"";

/// As they are read: the longer sign before its prefix.
const RELATIONS: [(&str, Relation); 7] = [
    ("<=", Relation::LessOrEqual),
    (">=", Relation::GreaterOrEqual),
    ("!=", Relation::NotEqual),
    ("==", Relation::Equal),
    ("<", Relation::Less),
    (">", Relation::Greater),
    ("=", Relation::Equal),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comparisons_hold_as_written() {
        let holds = |text: &str, value| text.parse::<Comparison>().unwrap().holds(value);
        assert!(holds("<128", 127) && !holds("<128", 128));
        assert!(holds("<=128", 128) && !holds("<=128", 129));
        assert!(holds("= 0", 0) && holds("0", 0) && !holds("0", 1));
        assert!(holds("!=0", 1) && !holds("!=0", 0));
        assert!(holds(">=96", 96) && !holds(">96", 96));
        assert!("<x".parse::<Comparison>().is_err());
    }
}
