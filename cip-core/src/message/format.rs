//! The body formats of explicit messages.

use core::fmt;

use crate::code::{ClassId, InstanceId};

/// How a request on a connection names its object. Agreed when the connection is opened or allocated; the value in
/// the response binds both sides.
///
/// | Value | Request body after the service byte |
/// |---|---|
/// | 0 | class u8, instance u8, service data |
/// | 1 | class u8, instance u16, service data |
/// | 2 | class u16, instance u16, service data |
/// | 3 | class u16, instance u8, service data |
/// | 4 | path size u8 in words, packed path, service data |
/// | 5-15 | reserved |
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BodyFormat {
    /// 0: what nearly every DeviceNet slave uses.
    #[default]
    Class8Instance8,
    /// 1
    Class8Instance16,
    /// 2
    Class16Instance16,
    /// 3
    Class16Instance8,
    /// 4
    CipPath,
}

impl BodyFormat {
    /// All formats, in the order of their codes.
    pub const ALL: [Self; 5] = [
        Self::Class8Instance8,
        Self::Class8Instance16,
        Self::Class16Instance16,
        Self::Class16Instance8,
        Self::CipPath,
    ];

    /// The format with this code; `None` for the reserved codes.
    pub const fn from_code(code: u8) -> Option<Self> {
        Some(match code {
            0 => Self::Class8Instance8,
            1 => Self::Class8Instance16,
            2 => Self::Class16Instance16,
            3 => Self::Class16Instance8,
            4 => Self::CipPath,
            _ => return None,
        })
    }

    /// The code, 0-4.
    pub const fn code(self) -> u8 {
        match self {
            Self::Class8Instance8 => 0,
            Self::Class8Instance16 => 1,
            Self::Class16Instance16 => 2,
            Self::Class16Instance8 => 3,
            Self::CipPath => 4,
        }
    }

    /// True if both IDs fit into the format.
    pub const fn can_address(self, class: ClassId, instance: InstanceId) -> bool {
        let narrow_class = class.0 <= 0xFF;
        let narrow_instance = instance.0 <= 0xFF;
        match self {
            Self::Class8Instance8 => narrow_class && narrow_instance,
            Self::Class8Instance16 => narrow_class,
            Self::Class16Instance8 => narrow_instance,
            Self::Class16Instance16 | Self::CipPath => true,
        }
    }
}

impl fmt::Display for BodyFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Class8Instance8 => "8/8",
            Self::Class8Instance16 => "8/16",
            Self::Class16Instance16 => "16/16",
            Self::Class16Instance8 => "16/8",
            Self::CipPath => "CIP path",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_inverse() {
        for format in BodyFormat::ALL {
            assert_eq!(BodyFormat::from_code(format.code()), Some(format));
        }
        assert!((5..=u8::MAX).all(|code| BodyFormat::from_code(code).is_none()));
    }
}
