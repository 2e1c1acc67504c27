//! The Parameter object (class 0x0F): what its descriptors say.

use core::fmt;

use crate::text::write_hex16;

bitflags::bitflags! {
    /// The descriptor of a parameter (attribute 4).
    ///
    /// | Bit | Meaning |
    /// |---|---|
    /// | 0 | the link path can be set |
    /// | 1 | the values have names: Get_Enum_String |
    /// | 2 | scaling |
    /// | 3 | the scaling factors are parameters |
    /// | 4 | read only |
    /// | 5 | monitor: the value changes by itself |
    /// | 6 | scaling with extended precision |
    /// | 7-15 | reserved |
    ///
    /// A word from a device is kept as it is: make one with `from_bits_retain`.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
    #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
    pub struct ParameterDescriptor: u16 {
        /// Attributes 2 and 3, the link path, can be set.
        const SETTABLE_PATH = 0x0001;
        /// The values have names, which Get_Enum_String tells.
        const ENUMERATED = 0x0002;
        /// Attributes 13-16 scale the value.
        const SCALING = 0x0004;
        /// Attributes 17-20 name the parameters that scale the value.
        const SCALING_LINKS = 0x0008;
        /// The value cannot be set.
        const READ_ONLY = 0x0010;
        /// The value changes by itself.
        const MONITOR = 0x0020;
        /// Attribute 21 takes part in the scaling.
        const EXTENDED_PRECISION = 0x0040;
    }
}

bitflags::bitflags! {
    /// The descriptor of the class (attribute 8 of instance 0).
    ///
    /// | Bit | Meaning |
    /// |---|---|
    /// | 0 | there are parameter instances |
    /// | 1 | they have the full set of attributes, 1-21, and not only 1-6 |
    /// | 2 | a value is kept over a power cycle only after Save |
    /// | 3 | all parameters are stored in non-volatile memory |
    /// | 4-15 | reserved |
    ///
    /// A word from a device is kept as it is: make one with `from_bits_retain`.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
    #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
    pub struct ParameterClassDescriptor: u16 {
        /// There are parameter instances.
        const INSTANCES = 0x0001;
        /// The instances have the full set of attributes.
        const FULL_ATTRIBUTES = 0x0002;
        /// Values are stored by the service Save.
        const SAVE_NEEDED = 0x0004;
        /// Parameters are stored in non-volatile memory.
        const NON_VOLATILE = 0x0008;
    }
}

macro_rules! in_words {
    ($Name:ident: $($FLAG:ident $text:literal),*) => {
        impl fmt::Display for $Name {
            /// The word, and its known bits by name.
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                let names = [$((Self::$FLAG, $text)),*];
                let set = names.into_iter().filter(|&(flag, _)| self.contains(flag)).map(|(_, name)| name);
                write_flags(f, self.bits(), set)
            }
        }

        #[cfg(feature = "defmt")]
        impl defmt::Format for $Name {
            fn format(&self, f: defmt::Formatter<'_>) {
                defmt::write!(f, "{=u16:#06x}", self.bits());
            }
        }
    };
}

in_words!(ParameterDescriptor:
    SETTABLE_PATH "settable path",
    ENUMERATED "enumerated",
    SCALING "scaling",
    SCALING_LINKS "scaling links",
    READ_ONLY "read only",
    MONITOR "monitor",
    EXTENDED_PRECISION "extended precision"
);

in_words!(ParameterClassDescriptor:
    INSTANCES "instances",
    FULL_ATTRIBUTES "full attributes",
    SAVE_NEEDED "save needed",
    NON_VOLATILE "non-volatile"
);

/// `0x0012 (enumerated, read only)`
fn write_flags(
    f: &mut fmt::Formatter<'_>,
    bits: u16,
    names: impl Iterator<Item = &'static str>,
) -> fmt::Result {
    f.write_str("0x")?;
    write_hex16(f, bits)?;
    let mut separator = " (";
    for name in names {
        f.write_str(separator)?;
        f.write_str(name)?;
        separator = ", ";
    }
    f.write_str(if separator == ", " { ")" } else { "" })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    #[test]
    fn descriptors_in_words() {
        assert_eq!(ParameterDescriptor::empty().to_string(), "0x0000");
        let descriptor = ParameterDescriptor::ENUMERATED | ParameterDescriptor::READ_ONLY;
        assert_eq!(descriptor.to_string(), "0x0012 (enumerated, read only)");
        let all = ParameterDescriptor::from_bits_retain(0xFFFF);
        assert_eq!(
            all.to_string(),
            "0xFFFF (settable path, enumerated, scaling, scaling links, read only, monitor, extended precision)"
        );
        let class = ParameterClassDescriptor::from_bits_retain(0x000F);
        assert_eq!(class.to_string(), "0x000F (instances, full attributes, save needed, non-volatile)");
    }
}
