//! What may be done with an attribute.

use core::fmt;

use super::Failure;
use super::failure::wrong_length;
use crate::code::{AttributeId, GeneralStatus};
use crate::names::Access;

/// One attribute that an object has: its number, what may be done with it, and how long a value is. Four bytes, because
/// tables of them are what a small device has most of.
///
/// Names and types are in [`names`](crate::names), so that a device that prints nothing carries no strings.
///
/// ```
/// use cip_core::object::{AttributeRule, Size};
///
/// const RULES: &[AttributeRule] = &[
///     AttributeRule::get(1, 2),                          // a UINT that can be read
///     AttributeRule::get_set(2, 1),                      // a USINT that can be set, too
///     AttributeRule::get(7, 0).sized(Size::ShortString), // a name
/// ];
/// assert!(RULES[1].is_settable());
/// assert_eq!(RULES[0].size(), Size::Bytes(2));
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct AttributeRule {
    id: AttributeId,
    /// Bit 15: can be set. Bits 14-0: [`SHORT_STRING`], [`ANY`], or the number of bytes.
    packed: u16,
}

/// How many bytes the value of an attribute takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Size {
    /// Always as many; more than 32765, which no message can carry, are as good as that.
    Bytes(u16),
    /// A SHORT_STRING: one byte with the number of characters, then these.
    ShortString,
    /// All that the message has: the object checks the length when it is set.
    Any,
}

impl AttributeRule {
    /// An attribute that can be read, with values of `size` bytes.
    pub const fn get(id: u16, size: u16) -> Self {
        Self { id: AttributeId(id), packed: 0 }.sized(Size::Bytes(size))
    }

    /// An attribute that can be read and set, with values of `size` bytes.
    pub const fn get_set(id: u16, size: u16) -> Self {
        Self { id: AttributeId(id), packed: SETTABLE }.sized(Size::Bytes(size))
    }

    /// The same attribute with values of another size.
    #[must_use]
    pub const fn sized(self, size: Size) -> Self {
        let size = match size {
            Size::Bytes(bytes) if bytes < SHORT_STRING => bytes,
            Size::Bytes(_) => SHORT_STRING.saturating_sub(1),
            Size::ShortString => SHORT_STRING,
            Size::Any => ANY,
        };
        Self { packed: self.packed & SETTABLE | size, ..self }
    }

    /// The number of the attribute.
    pub const fn id(&self) -> AttributeId {
        self.id
    }

    /// What may be done with it.
    pub const fn access(&self) -> Access {
        if self.is_settable() { Access::GetSet } else { Access::Get }
    }

    /// True if the attribute can be set.
    pub const fn is_settable(&self) -> bool {
        self.packed & SETTABLE != 0
    }

    /// How long a value is.
    pub const fn size(&self) -> Size {
        match self.packed & !SETTABLE {
            SHORT_STRING => Size::ShortString,
            ANY => Size::Any,
            bytes => Size::Bytes(bytes),
        }
    }
}

impl fmt::Debug for AttributeRule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("AttributeRule")
            .field("id", &self.id)
            .field("access", &self.access())
            .field("size", &self.size())
            .finish()
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for AttributeRule {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{} {} {}", self.id, self.access(), self.size());
    }
}

impl Size {
    /// The number of bytes that the value at the front of `data` takes; 0x13 if they are not all there.
    pub fn of_value(self, data: &[u8]) -> Result<usize, Failure> {
        let size = match self {
            Self::Bytes(size) => usize::from(size),
            Self::ShortString => data.first().map_or(1, |&len| usize::from(len).saturating_add(1)),
            Self::Any => data.len(),
        };
        if size > data.len() { Err(GeneralStatus::NOT_ENOUGH_DATA.into()) } else { Ok(size) }
    }

    /// Demands that `data` are one value: 0x13 if they are shorter, 0x15 if they are longer.
    pub fn check(self, data: &[u8]) -> Result<(), Failure> {
        match self.of_value(data)? {
            size if size == data.len() => Ok(()),
            size => Err(wrong_length(data.len(), size)),
        }
    }
}

/// The rule of an attribute, if the object has it.
pub(super) fn rule_of(rules: &[AttributeRule], id: AttributeId) -> Option<&AttributeRule> {
    rules.iter().find(|rule| rule.id == id)
}

const SETTABLE: u16 = 0x8000;
const ANY: u16 = 0x7FFF;
const SHORT_STRING: u16 = 0x7FFE;
