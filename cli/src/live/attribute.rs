//! An attribute and its value, as people write them.

use core::fmt;
use core::ops::RangeInclusive;
use core::str::FromStr;

use cip_core::code::{AttributeId, ClassId, InstanceId};
use cip_core::names::{AttributeInfo, attribute_info};
use cip_core::value::AttributeValue;

use crate::text::{UPPER, hex_bytes, push_hex, unsigned};

/// `CLASS/INSTANCE/ATTRIBUTE`
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct AttributePath {
    /// The class.
    pub class: ClassId,
    /// The instance; 0 is the class itself.
    pub instance: InstanceId,
    /// The attribute.
    pub attribute: AttributeId,
}

impl AttributePath {
    /// What is known of it.
    pub(super) fn info(&self) -> Option<&'static AttributeInfo> {
        attribute_info(self.class, self.instance, self.attribute)
    }

    /// A value of it in words.
    pub(super) fn words<'a>(&self, data: &'a [u8]) -> AttributeValue<'a> {
        AttributeValue { class: self.class, instance: self.instance, attribute: self.attribute, data }
    }

    /// The bytes of a value: `12`, `0x0C`, `-3`, which must be one that the attribute may have; `hex:0C00`, which may be anything.
    ///
    /// # Errors
    /// What was expected.
    pub(super) fn value(&self, text: &str) -> Result<Vec<u8>, String> {
        if let Some(digits) = text.strip_prefix("hex:") {
            return hex_bytes(digits)
                .filter(|bytes| !bytes.is_empty())
                .ok_or_else(|| format!("`{text}`: pairs of hexadecimal digits expected after hex:"));
        }
        let known = self.info().and_then(|info| {
            let ranges: Vec<_> = info.shape.numbers().collect();
            Some((info.shape.size()?, ranges)).filter(|(_, ranges)| !ranges.is_empty())
        });
        let Some((size, ranges)) = known else {
            return Err(format!(
                "`{text}`: {self} takes no number; give its bytes as they are on the wire, such as hex:0C00"
            ));
        };
        let number = number(text)
            .filter(|number| ranges.iter().any(|range| range.contains(number)))
            .ok_or_else(|| {
                let takes: Vec<String> = ranges.iter().map(words).collect();
                let takes = format!("`{text}`: {self} takes {}", takes.join(" or "));
                let is_signed = ranges.iter().any(|range| *range.start() < 0);
                // Only the bytes of that number: those of another would be sent by whoever copies them.
                let Some(number) = number_of(text, size, is_signed) else { return takes };
                let mut hex = Vec::new();
                push_hex(&mut hex, &number.to_le_bytes()[..size], UPPER);
                let hex = String::from_utf8_lossy(&hex);
                format!("{takes}; to send {text} all the same, give its bytes: hex:{hex}")
            })?;
        Ok(number.to_le_bytes()[..size].to_vec())
    }
}

/// `0 to 63`, `65535`
fn words(range: &RangeInclusive<i128>) -> String {
    match (range.start(), range.end()) {
        (first, last) if first == last => first.to_string(),
        (first, last) => format!("{first} to {last}"),
    }
}

/// A number that so many bytes can hold.
fn number_of(text: &str, size: usize, is_signed: bool) -> Option<i128> {
    let bits = 8 * size as u32;
    let range = if is_signed { -(1 << (bits - 1))..1 << (bits - 1) } else { 0..1 << bits };
    number(text).filter(|number| range.contains(number))
}

/// `12`, `0x0C`, `-3`.
pub(super) fn number(text: &str) -> Option<i128> {
    let (sign, digits) = text.strip_prefix('-').map_or((1, text), |digits| (-1, digits));
    unsigned(digits).map(|number| sign * i128::from(number))
}

impl FromStr for AttributePath {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts: Vec<Option<u16>> =
            text.split('/').map(|part| number(part).and_then(|number| u16::try_from(number).ok())).collect();
        let [Some(class), Some(instance), Some(attribute)] = parts[..] else {
            return Err(
                "CLASS/INSTANCE/ATTRIBUTE expected, three numbers up to 65535 such as 1/1/7 or 0x64/1/3"
                    .into(),
            );
        };
        if attribute > u8::MAX.into() {
            return Err(format!(
                "attribute {attribute}: it is one byte in the messages of DeviceNet, 0 to 255"
            ));
        }
        Ok(Self { class: ClassId(class), instance: InstanceId(instance), attribute: AttributeId(attribute) })
    }
}

/// `Identity 1 Vendor ID`, `class 0x64 1 attribute 3`
impl fmt::Display for AttributePath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {} ", self.class, self.instance.0)?;
        match self.info() {
            Some(info) => f.write_str(info.name),
            None => fmt::Display::fmt(&self.attribute, f),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(text: &str) -> AttributePath {
        text.parse().unwrap()
    }

    #[test]
    fn paths_in_decimal_and_hexadecimal() {
        assert_eq!(path("1/1/7"), path("0x01/0x1/0X07"));
        assert_eq!(path("1/1/7").to_string(), "Identity 1 Product name");
        for text in ["", "1/1", "1/1/7/8", "1/1/-7", "a/1/1", "65536/1/1", "1//1", "+1/1/1", "1/1/256"] {
            assert!(text.parse::<AttributePath>().is_err(), "{text}");
        }
    }

    #[test]
    fn values_take_the_size_of_their_attribute() {
        // Connection 2: EPR is a UINT; DeviceNet 1: the MAC ID is a USINT.
        assert_eq!(path("5/2/9").value("200"), Ok(vec![0xC8, 0x00]));
        assert_eq!(path("5/2/9").value("0xC8"), Ok(vec![0xC8, 0x00]));
        assert_eq!(path("3/1/1").value("63"), Ok(vec![63]));
        assert_eq!(path("5/2/5").value("0xFFFF"), Ok(vec![0xFF, 0xFF]));
        assert_eq!(path("15/1/16").value("-2"), Ok(vec![0xFE, 0xFF]), "a scaling offset is an INT");
        assert_eq!(path("100/1/1").value("hex:0a0B"), Ok(vec![0x0A, 0x0B]));
        for (attribute, text) in [
            ("3/1/1", "256"),
            ("3/1/1", "64"),
            ("3/1/1", "-1"),
            ("3/1/2", "3"),
            ("3/1/3", "2"),
            ("5/2/5", "0x800"),
            ("5/2/12", "4"),
            ("5/2/18", "8"),
            ("3/1/1", "--1"),
            ("3/1/1", "-+1"),
            ("5/2/9", "65536"),
            ("5/2/9", "two"),
            ("100/1/1", "1"),
            ("100/1/1", "hex:"),
            ("100/1/1", "hex:012"),
            ("100/1/1", "hex:+1"),
        ] {
            assert!(path(attribute).value(text).is_err(), "{attribute} {text}");
        }
        assert_eq!(path("3/1/1").value("hex:40"), Ok(vec![64]), "bytes are sent as they are");
    }

    #[test]
    fn only_the_bytes_of_the_number_itself_are_proposed() {
        let takes = |attribute: &str, text: &str| path(attribute).value(text).unwrap_err();
        for text in ["300", "abc", "18446744073709551617", "-1"] {
            assert_eq!(takes("3/1/1", text), format!("`{text}`: DeviceNet 1 MAC ID takes 0 to 63"));
        }
        assert!(takes("3/1/1", "64").ends_with("to send 64 all the same, give its bytes: hex:40"));
        assert!(takes("5/2/5", "0x800").ends_with("give its bytes: hex:0008"));
    }
}
