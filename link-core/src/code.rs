//! Numbers with names: an open newtype for each code on the wire.

/// Defines an open code: a newtype with named constants, `name`, `Display`, `Debug` and conversions.
///
/// `hex` or `decimal` is how a value without a name is printed, after the label. The crate that uses it decides by its own
/// features `serde` and `defmt` what else is derived.
///
/// ```
/// link_core::codes! {
///     /// What a colour is called.
///     pub struct Colour(u8), "colour" in hex {
///         RED = 0x01, "red";
///     }
/// }
/// assert_eq!((Colour::RED.to_string(), Colour(0x7A).to_string()), ("red".into(), "colour 0x7A".into()));
/// ```
#[macro_export]
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
                $crate::codes!(@write $radix, f, self.0)
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
