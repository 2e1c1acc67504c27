//! Numbers with names: an open newtype for each code on the wire.
//!
//! A code is a transparent wrapper of its number, so that a value nobody has named yet survives a round trip. `Display`
//! and `Debug` print the name, or the kind and the number of a code without one.
//!
//! ```
//! use cip_core::code::GeneralStatus;
//!
//! assert_eq!(GeneralStatus(0x0E).to_string(), "Attribute not settable");
//! assert_eq!(GeneralStatus(0x7A).to_string(), "general status 0x7A");
//! ```

mod class;
mod data_type;
mod device_type;
mod service;
mod status;
mod vendor;

pub use class::{AttributeId, ClassId, IdRange, InstanceId};
pub use data_type::DataTypeCode;
pub use device_type::DeviceType;
pub use service::{ServiceCode, ServiceRange};
pub use status::{AdditionalCode, GeneralStatus};
pub use vendor::VendorId;

/// Defines an open code: a newtype with named constants, `name`, `Display`, `Debug` and conversions.
///
/// `hex` or `decimal` is how a value without a name is printed, after the label.
macro_rules! codes {
    (
        $(#[$meta:meta])*
        pub struct $Name:ident($number:ty), $label:literal in $radix:ident {
            $($(#[$note:meta])* $CONSTANT:ident = $value:literal, $text:literal;)*
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(transparent))]
        pub struct $Name(pub $number);

        impl $Name {
            $(
                $(#[$note])*
                #[doc = concat!("`", stringify!($value), "`: ", $text, ".")]
                pub const $CONSTANT: Self = Self($value);
            )*

            /// Every code that has a name, for listings.
            pub const NAMED: &'static [Self] = &[$(Self($value)),*];

            /// The name, if the code has one.
            pub const fn name(self) -> Option<&'static str> {
                match self.0 {
                    $($value => Some($text),)*
                    _ => None,
                }
            }
        }

        impl From<$number> for $Name {
            fn from(number: $number) -> Self {
                Self(number)
            }
        }

        impl From<$Name> for $number {
            fn from(code: $Name) -> Self {
                code.0
            }
        }

        impl core::fmt::Display for $Name {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                if let Some(name) = self.name() {
                    return f.write_str(name);
                }
                f.write_str(concat!($label, " "))?;
                $crate::code::codes!(@write $radix, f, self.0)
            }
        }

        impl core::fmt::Debug for $Name {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                core::fmt::Display::fmt(self, f)
            }
        }

        #[cfg(feature = "defmt")]
        impl defmt::Format for $Name {
            fn format(&self, f: defmt::Formatter<'_>) {
                match self.name() {
                    Some(name) => defmt::write!(f, "{=str}", name),
                    None => defmt::write!(f, "{=str} {:#x}", $label, self.0),
                }
            }
        }
    };
    (@write hex, $f:expr, $number:expr) => {
        $crate::text::write_prefixed_hex($f, u32::from($number))
    };
    (@write decimal, $f:expr, $number:expr) => {
        $crate::text::write_decimal($f, u64::from($number))
    };
}
pub(crate) use codes;

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    #[test]
    fn named_codes_are_distinct() {
        let mut names: std::vec::Vec<_> = ServiceCode::NAMED.iter().map(ToString::to_string).collect();
        let count = names.len();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), count);
    }

    #[test]
    fn unknown_codes_print_kind_and_number() {
        assert_eq!(ServiceCode(0x7A).to_string(), "service 0x7A");
        assert_eq!(ClassId(0x64).to_string(), "class 0x64");
        assert_eq!(ClassId(0x0300).to_string(), "class 0x0300");
        assert_eq!(InstanceId(101).to_string(), "instance 101");
        assert_eq!(VendorId(60000).to_string(), "vendor 60000");
        assert_eq!(DeviceType(0x64).to_string(), "device type 0x64");
        assert_eq!(std::format!("{:?}", GeneralStatus(0xD0)), "general status 0xD0");
    }
}
