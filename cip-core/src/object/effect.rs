//! What a service asks of the owner of the objects, beyond the answer.

use core::fmt;

use crate::message::ResetType;

bitflags::bitflags! {
    /// What a service has changed or asks for.
    ///
    /// | Bit | Meaning |
    /// |---|---|
    /// | 0 | an attribute was set |
    /// | 1 | Identity: the heartbeat interval was set |
    /// | 2 | Acknowledge Handler: its timer, its limit or its connection was set |
    /// | 3 | Assembly: data were set |
    /// | 4 | Parameter: a value was set |
    /// | 5-7 | Parameter: reset, restore, save all values |
    /// | 8-15 | for the objects of the application |
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
    #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
    pub struct Effect: u16 {
        /// An attribute of whatever object was set: what is non-volatile wants to be stored.
        const ATTRIBUTE_SET = 0x0001;
        /// The heartbeat interval of the Identity object has a new value.
        const HEARTBEAT_INTERVAL = 0x0002;
        /// An attribute of the Acknowledge Handler has a new value.
        const ACKNOWLEDGE = 0x0004;
        /// The data of an assembly were set by an explicit message.
        const ASSEMBLY_DATA = 0x0008;
        /// The value of a parameter was set.
        const PARAMETER_VALUE = 0x0010;
        /// All parameters shall have their default values.
        const PARAMETERS_RESET = 0x0020;
        /// All parameters shall have the values that were saved.
        const PARAMETERS_RESTORE = 0x0040;
        /// The values of all parameters shall be saved.
        const PARAMETERS_SAVE = 0x0080;
        /// All bits that the application gives a meaning to.
        const APPLICATION = 0xFF00;
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Effect {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{=u16:#06x}", self.bits());
    }
}

/// What is left to do when the response has been sent. Objects call nobody: they answer, and say this.
///
/// A reset must wait until its response is on the network.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(from = "Fields", into = "Fields")
)]
#[must_use = "an effect is carried out by the owner of the objects, or not at all"]
pub struct Effects {
    /// Bits 15-0 [`of`](Self::of); [`RESET`], if the device is to be reset, and in bits 31-24 how. One word, as a
    /// [`Failure`](super::Failure) is: what an object returns is then two registers.
    word: u32,
}

impl Effects {
    /// Nothing is left to do.
    pub const NONE: Self = Self { word: 0 };

    /// Reset the device.
    pub const fn reset(kind: ResetType) -> Self {
        Self { word: RESET | u32::from_be_bytes([kind.0, 0, 0, 0]) }
    }

    /// How to reset the device, if it is to be reset.
    pub const fn reset_type(self) -> Option<ResetType> {
        let [kind, ..] = self.word.to_be_bytes();
        if self.word & RESET == 0 { None } else { Some(ResetType(kind)) }
    }

    /// Everything else.
    pub const fn of(self) -> Effect {
        let [low, high, ..] = self.word.to_le_bytes();
        Effect::from_bits_retain(u16::from_le_bytes([low, high]))
    }

    /// True if nothing is left to do.
    pub const fn is_none(self) -> bool {
        self.word == 0
    }

    /// The same, and this too.
    pub const fn and(self, of: Effect) -> Self {
        let [low, high] = of.bits().to_le_bytes();
        Self { word: self.word | u32::from_le_bytes([low, high, 0, 0]) }
    }

    /// The effects of two services one after the other: of two resets, the second.
    pub fn then(self, next: Self) -> Self {
        let reset = if next.reset_type().is_some() { next } else { self };
        reset.and(self.of().union(next.of()))
    }
}

impl From<Effect> for Effects {
    fn from(of: Effect) -> Self {
        Self::NONE.and(of)
    }
}

impl fmt::Debug for Effects {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Effects").field("reset", &self.reset_type()).field("of", &self.of()).finish()
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Effects {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "Effects {} {}", self.reset_type(), self.of());
    }
}

/// Effects as they are serialised.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "Effects")]
struct Fields {
    reset: Option<ResetType>,
    of: Effect,
}

#[cfg(feature = "serde")]
impl From<Effects> for Fields {
    fn from(effects: Effects) -> Self {
        Self { reset: effects.reset_type(), of: effects.of() }
    }
}

#[cfg(feature = "serde")]
impl From<Fields> for Effects {
    fn from(fields: Fields) -> Self {
        Self::from(fields.of).then(fields.reset.map_or(Self::NONE, Self::reset))
    }
}

const RESET: u32 = 1 << 16;
