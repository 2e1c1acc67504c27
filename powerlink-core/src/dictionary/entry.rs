//! What an object is: address, type, access.

use core::fmt;

use crate::wire::AbortCode;

/// Where an object is.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ObjectAddress {
    /// Index.
    pub index: u16,
    /// Sub-index.
    pub sub: u8,
}

impl ObjectAddress {
    /// An address.
    #[must_use]
    pub const fn new(index: u16, sub: u8) -> Self {
        Self { index, sub }
    }
}

/// `0x1006/0`
impl fmt::Display for ObjectAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "0x{:04X}/{}", self.index, self.sub)
    }
}

/// The type of an object's value.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum ObjectType {
    /// One byte, 0 or 1.
    Boolean,
    /// Unsigned, of so many bytes.
    Unsigned(u8),
    /// Signed, of so many bytes.
    Signed(u8),
    /// Floating point, of so many bytes.
    Real(u8),
    /// Characters, at most so many.
    Text(u16),
    /// Bytes, at most so many.
    Bytes(u16),
}

impl ObjectType {
    /// The length of the value in bytes; `None` where it varies.
    #[must_use]
    pub fn fixed_len(self) -> Option<usize> {
        match self {
            Self::Boolean => Some(1),
            Self::Unsigned(len) | Self::Signed(len) | Self::Real(len) => Some(len.into()),
            Self::Text(_) | Self::Bytes(_) => None,
        }
    }

    /// Whether a value may have so many bytes.
    ///
    /// # Errors
    /// Why it may not.
    pub fn check_len(self, len: usize) -> Result<(), AbortCode> {
        match self {
            Self::Boolean | Self::Unsigned(_) | Self::Signed(_) | Self::Real(_) => {
                if self.fixed_len() == Some(len) { Ok(()) } else { Err(AbortCode::LENGTH) }
            }
            Self::Text(most) | Self::Bytes(most) => {
                if len <= usize::from(most) {
                    Ok(())
                } else {
                    Err(AbortCode::TOO_LONG)
                }
            }
        }
    }
}

/// Who may do what with an object.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Access {
    /// Read, and it never changes.
    Constant,
    /// Read.
    ReadOnly,
    /// Read and written.
    ReadWrite,
    /// Written.
    WriteOnly,
}

impl Access {
    /// Whether it is read.
    #[must_use]
    pub const fn is_readable(self) -> bool {
        match self {
            Self::Constant | Self::ReadOnly | Self::ReadWrite => true,
            Self::WriteOnly => false,
        }
    }

    /// Whether it is written.
    #[must_use]
    pub const fn is_writable(self) -> bool {
        match self {
            Self::ReadWrite | Self::WriteOnly => true,
            Self::Constant | Self::ReadOnly => false,
        }
    }
}

/// Into which PDOs an object may be mapped. Into those that are received only if it is written, into that which is sent only if it
/// is read.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Mappable {
    /// Into none.
    #[default]
    No,
    /// Into those that the node receives: an output of the managing node.
    Receive,
    /// Into that which it sends.
    Transmit,
    /// Into both.
    Both,
}

impl Mappable {
    /// Whether it may be mapped in a direction.
    #[must_use]
    pub const fn allows(self, transmit: bool) -> bool {
        match self {
            Self::No => false,
            Self::Receive => !transmit,
            Self::Transmit => transmit,
            Self::Both => true,
        }
    }
}

/// One object, or several alike in a row: a line of an object dictionary.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Entry {
    /// The first and the last index.
    pub indices: (u16, u16),
    /// The first and the last sub-index.
    pub subs: (u8, u8),
    /// The name.
    pub name: &'static str,
    /// The type.
    pub object_type: ObjectType,
    /// Who may do what.
    pub access: Access,
    /// Into which PDOs it may be mapped.
    pub mappable: Mappable,
    /// The least and the greatest value, of unsigned ones.
    pub range: (u32, u32),
    /// 0 is a value as well, below the least: it says that there is none.
    pub has_none: bool,
}

impl Entry {
    /// One object that cannot be mapped, with any value.
    #[must_use]
    pub const fn new(
        index: u16,
        sub: u8,
        name: &'static str,
        object_type: ObjectType,
        access: Access,
    ) -> Self {
        Self {
            indices: (index, index),
            subs: (sub, sub),
            name,
            object_type,
            access,
            mappable: Mappable::No,
            range: (0, u32::MAX),
            has_none: false,
        }
    }

    /// The same for all sub-indices up to `last`.
    #[must_use]
    pub const fn up_to_sub(mut self, last: u8) -> Self {
        let (first, _) = self.subs;
        self.subs = (first, last);
        self
    }

    /// The same for all indices up to `last`.
    #[must_use]
    pub const fn up_to_index(mut self, last: u16) -> Self {
        let (first, _) = self.indices;
        self.indices = (first, last);
        self
    }

    /// The same, to be mapped into PDOs.
    #[must_use]
    pub const fn mapped(mut self, mappable: Mappable) -> Self {
        self.mappable = mappable;
        self
    }

    /// The same with a least and a greatest value.
    #[must_use]
    pub const fn within(mut self, least: u32, greatest: u32) -> Self {
        self.range = (least, greatest);
        self
    }

    /// The same with 0 as a value besides the range.
    #[must_use]
    pub const fn or_none(mut self) -> Self {
        self.has_none = true;
        self
    }

    /// The line of an address.
    ///
    /// # Errors
    /// Whether the object or only the sub-index is missing.
    pub fn find(entries: &'static [Self], at: ObjectAddress) -> Result<&'static Self, AbortCode> {
        let mut missing = AbortCode::NO_OBJECT;
        for entry in entries {
            let ((first, last), (first_sub, last_sub)) = (entry.indices, entry.subs);
            if !(first..=last).contains(&at.index) {
                continue;
            }
            if (first_sub..=last_sub).contains(&at.sub) {
                return Ok(entry);
            }
            missing = AbortCode::NO_SUB_INDEX;
        }
        Err(missing)
    }

    /// Whether it may be read.
    ///
    /// # Errors
    /// Why it may not.
    pub const fn check_read(&self) -> Result<(), AbortCode> {
        if self.access.is_readable() { Ok(()) } else { Err(AbortCode::WRITE_ONLY) }
    }

    /// Whether a value may be written.
    ///
    /// # Errors
    /// Why it may not.
    pub fn check_write(&self, data: &[u8]) -> Result<(), AbortCode> {
        if !self.access.is_writable() {
            return Err(AbortCode::READ_ONLY);
        }
        self.object_type.check_len(data.len())?;
        match (self.object_type, unsigned(data)) {
            (ObjectType::Boolean, Some(2..)) => Err(AbortCode::VALUE_TOO_HIGH),
            (ObjectType::Unsigned(_), Some(value)) => self.check_range(value),
            _ => Ok(()),
        }
    }

    /// Whether every value of the right length may be written.
    pub(crate) const fn takes_any_value(&self) -> bool {
        match self.object_type {
            ObjectType::Boolean => false,
            ObjectType::Unsigned(_) => matches!(self.range, (0, u32::MAX)),
            ObjectType::Signed(_) | ObjectType::Real(_) | ObjectType::Text(_) | ObjectType::Bytes(_) => true,
        }
    }

    /// Whether an unsigned value is in the range.
    ///
    /// # Errors
    /// On which side it is out of it.
    pub const fn check_range(&self, value: u32) -> Result<(), AbortCode> {
        match self.range {
            _ if self.has_none && value == 0 => Ok(()),
            (_, greatest) if value > greatest => Err(AbortCode::VALUE_TOO_HIGH),
            (least, _) if value < least => Err(AbortCode::VALUE_TOO_LOW),
            _ => Ok(()),
        }
    }
}

/// A little-endian number of up to four bytes.
pub(crate) fn unsigned(data: &[u8]) -> Option<u32> {
    let mut bytes = [0; 4];
    bytes.get_mut(..data.len())?.iter_mut().zip(data).for_each(|(to, &from)| *to = from);
    Some(u32::from_le_bytes(bytes))
}
