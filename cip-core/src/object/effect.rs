//! What a service asks of the owner of the objects, beyond the answer.

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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[must_use = "an effect is carried out by the owner of the objects, or not at all"]
pub struct Effects {
    /// Reset the device.
    pub reset: Option<ResetType>,
    /// Everything else.
    pub of: Effect,
}

impl Effects {
    /// Nothing is left to do.
    pub const NONE: Self = Self { reset: None, of: Effect::empty() };

    /// Reset the device.
    pub const fn reset(kind: ResetType) -> Self {
        Self { reset: Some(kind), of: Effect::empty() }
    }

    /// True if nothing is left to do.
    pub const fn is_none(self) -> bool {
        self.reset.is_none() && self.of.is_empty()
    }

    /// The effects of two services one after the other: of two resets, the second.
    pub fn then(self, next: Self) -> Self {
        Self { reset: next.reset.or(self.reset), of: self.of.union(next.of) }
    }
}

impl From<Effect> for Effects {
    fn from(of: Effect) -> Self {
        Self { reset: None, of }
    }
}
