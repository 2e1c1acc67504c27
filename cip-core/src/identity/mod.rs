//! The Identity object (class 1): who a device is and how it is.

mod attributes;
mod status;

pub use attributes::{IdentityAttributes, OptionalAttributes};
pub use status::{DeviceState, ExtendedStatus, IdentityStatus};

use core::fmt;

use crate::code::{DeviceType, VendorId};
use crate::codec::{Full, ParseError, Reader, Wire, Writer};
use crate::text::{Quoted, write_decimal};

/// The longest product name, in characters.
pub const PRODUCT_NAME_MAX: usize = 32;

/// What a device is: the part of the Identity object that never changes.
///
/// ```
/// use cip_core::code::{DeviceType, VendorId};
/// use cip_core::identity::{DeviceIdentity, ProductName, Revision};
///
/// let identity = DeviceIdentity {
///     vendor: VendorId(65_000),
///     device_type: DeviceType::GENERAL_PURPOSE_DISCRETE_IO,
///     product_code: 1,
///     revision: Revision::new(1, 2).ok_or("revision")?,
///     serial: 0x0102_0304,
///     name: ProductName::new("Example Block").ok_or("name")?,
/// };
/// assert_eq!(identity.to_string(), "\"Example Block\" 1.2, vendor 65000, General purpose discrete I/O, product 1, serial 0x01020304");
/// # Ok::<(), &str>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DeviceIdentity {
    /// Attribute 1. Assigned by ODVA.
    pub vendor: VendorId,
    /// Attribute 2.
    pub device_type: DeviceType,
    /// Attribute 3, 1-65535.
    pub product_code: u16,
    /// Attribute 4.
    pub revision: Revision,
    /// Attribute 6, unique among the devices of the vendor. Also part of the duplicate MAC ID check.
    pub serial: u32,
    /// Attribute 7.
    pub name: ProductName,
}

/// A revision (attribute 4).
///
/// | Byte | Content |
/// |---|---|
/// | 0 | major, 1-127 |
/// | 1 | minor, 1-255 |
///
/// What was read from a device can break these rules; [`is_valid`](Self::is_valid) tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Revision {
    /// The major revision.
    pub major: u8,
    /// The minor revision.
    pub minor: u8,
}

impl Revision {
    /// A revision by the rules; `None` outside of 1-127 and 1-255.
    pub const fn new(major: u8, minor: u8) -> Option<Self> {
        let revision = Self { major, minor };
        if revision.is_valid() { Some(revision) } else { None }
    }

    /// True if major is 1-127 and minor 1-255.
    pub const fn is_valid(self) -> bool {
        matches!(self.major, 1..=127) && self.minor != 0
    }
}

impl<'a> Wire<'a> for Revision {
    const NAME: &'static str = "revision";

    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        Ok(Self { major: reader.u8("major revision")?, minor: reader.u8("minor revision")? })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.bytes(&[self.major, self.minor])
    }

    fn wire_len(&self) -> usize {
        2
    }
}

impl fmt::Display for Revision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_decimal(f, self.major.into())?;
        f.write_str(".")?;
        write_decimal(f, self.minor.into())
    }
}

/// A product name: up to 32 characters of ISO 8859-1.
#[derive(Clone, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(transparent))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ProductName(heapless::Vec<u8, PRODUCT_NAME_MAX>);

impl ProductName {
    /// The name in the text; `None` if it is too long or has a character beyond ISO 8859-1.
    pub fn new(name: &str) -> Option<Self> {
        let mut bytes = heapless::Vec::new();
        for character in name.chars() {
            bytes.push(u8::try_from(character).ok()?).ok()?;
        }
        Some(Self(bytes))
    }

    /// The name in the bytes; `None` if it is too long.
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        heapless::Vec::from_slice(bytes).ok().map(Self)
    }

    /// The name in the bytes. More than 32 of them do not compile: so the identity of a device can be a constant, in flash.
    ///
    /// ```
    /// use cip_core::identity::ProductName;
    ///
    /// static NAME: ProductName = ProductName::from_array(*b"Example");
    /// assert_eq!(Some(&NAME), ProductName::new("Example").as_ref());
    /// ```
    pub const fn from_array<const N: usize>(bytes: [u8; N]) -> Self {
        Self(heapless::Vec::from_array(bytes))
    }

    /// The characters.
    pub fn as_bytes(&self) -> &[u8] {
        &self.0
    }
}

/// A SHORT_STRING: the length, then the characters.
impl<'a> Wire<'a> for ProductName {
    const NAME: &'static str = "product name";

    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        let offset = reader.offset();
        let len = reader.u8("product name length")?;
        let bytes = reader.bytes(len.into(), "product name")?;
        Self::from_bytes(bytes).ok_or(ParseError::value("product name length", offset, len.into()))
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u8(u8::try_from(self.0.len()).map_err(|_| Full)?)?;
        out.bytes(&self.0)
    }

    fn wire_len(&self) -> usize {
        self.0.len().saturating_add(1)
    }
}

impl fmt::Display for ProductName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&Quoted(&self.0), f)
    }
}

impl fmt::Debug for ProductName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl fmt::Display for DeviceIdentity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.name, f)?;
        f.write_str(" ")?;
        fmt::Display::fmt(&self.revision, f)?;
        f.write_str(", ")?;
        fmt::Display::fmt(&self.vendor, f)?;
        f.write_str(", ")?;
        fmt::Display::fmt(&self.device_type, f)?;
        f.write_str(", product ")?;
        write_decimal(f, self.product_code.into())?;
        f.write_str(", serial 0x")?;
        let [a, b, c, d] = self.serial.to_be_bytes();
        [a, b, c, d].into_iter().try_for_each(|byte| crate::text::write_hex8(f, byte))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::laws;
    use proptest::prelude::*;
    use std::string::ToString;

    #[test]
    fn revisions_by_the_rules() {
        for (major, minor, valid) in
            [(1, 1, true), (127, 255, true), (0, 1, false), (128, 1, false), (1, 0, false)]
        {
            assert_eq!(Revision::new(major, minor).is_some(), valid, "{major}.{minor}");
        }
    }

    #[test]
    fn product_names_are_latin_1_of_32_characters() {
        assert_eq!(ProductName::new("M\u{fc}ller").unwrap().as_bytes(), b"M\xFCller");
        assert_eq!(ProductName::new("\u{20ac}"), None);
        assert!(ProductName::new(&"x".repeat(32)).is_some());
        assert_eq!(ProductName::new(&"x".repeat(33)), None);
        let error = ProductName::parse(&[33; 34]).unwrap_err();
        assert_eq!(error.to_string(), "product name length at offset 0: value 0x21 is not allowed");
    }

    proptest! {
        #[test]
        fn wire_types_keep_the_laws(major: u8, minor: u8, name in proptest::collection::vec(any::<u8>(), 0..=32)) {
            laws::round_trip(&Revision { major, minor }, &mut [0; 3]);
            laws::round_trip(&ProductName::from_bytes(&name).unwrap(), &mut [0; 40]);
        }
    }
}
