//! What may be done with an attribute.

use super::Failure;
use super::failure::wrong_length;
use crate::code::{AttributeId, GeneralStatus};
use crate::names::Access;

/// One attribute that an object has: its number, what may be done with it, and how long a value is.
///
/// Names and types are in [`names`](crate::names), so that a device that prints nothing carries no strings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AttributeRule {
    /// The number.
    pub id: AttributeId,
    /// What may be done with it.
    pub access: Access,
    /// How long a value is.
    pub size: Size,
}

/// How many bytes the value of an attribute takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Size {
    /// Always as many.
    Bytes(u16),
    /// A SHORT_STRING: one byte with the number of characters, then these.
    ShortString,
    /// All that the message has: the object checks the length when it is set.
    Any,
}

impl AttributeRule {
    /// An attribute that can be read, with values of `size` bytes.
    pub const fn get(id: u16, size: u16) -> Self {
        Self { id: AttributeId(id), access: Access::Get, size: Size::Bytes(size) }
    }

    /// An attribute that can be read and set, with values of `size` bytes.
    pub const fn get_set(id: u16, size: u16) -> Self {
        Self { id: AttributeId(id), access: Access::GetSet, size: Size::Bytes(size) }
    }

    /// The same attribute with values of another size.
    #[must_use]
    pub const fn sized(self, size: Size) -> Self {
        Self { size, ..self }
    }

    /// True if the attribute can be set.
    pub const fn is_settable(&self) -> bool {
        matches!(self.access, Access::GetSet)
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

/// The rule of an attribute; 0x14 if the object does not have it.
pub(super) fn rule_of(rules: &[AttributeRule], id: AttributeId) -> Result<&AttributeRule, Failure> {
    rules.iter().find(|rule| rule.id == id).ok_or(Failure::new(GeneralStatus::ATTRIBUTE_NOT_SUPPORTED))
}
