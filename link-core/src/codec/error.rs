//! What can be wrong with bytes, and with the room for them.

use core::fmt;

use crate::text::ByteCount;

/// Bytes that are not the message they should be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ParseError {
    /// The field, or for trailing data the message, that is wrong.
    pub field: &'static str,
    /// Where the field starts, in bytes from the start of what was parsed.
    pub offset: usize,
    /// What is wrong with it.
    pub kind: ParseErrorKind,
}

/// What is wrong with a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ParseErrorKind {
    /// The bytes end inside the field.
    Short {
        /// Bytes that the field takes.
        expected: usize,
        /// Bytes that are there.
        found: usize,
    },
    /// The message is complete and bytes follow.
    Trailing {
        /// Bytes that follow.
        found: usize,
    },
    /// The field has a value that the layout does not allow.
    Value {
        /// The value.
        found: u32,
    },
}

impl ParseError {
    /// An error about the value of a field.
    pub const fn value(field: &'static str, offset: usize, found: u32) -> Self {
        Self { field, offset, kind: ParseErrorKind::Value { found } }
    }

    /// True if more bytes could have made the message valid.
    pub const fn is_short(&self) -> bool {
        matches!(self.kind, ParseErrorKind::Short { .. })
    }
}

impl fmt::Display for ParseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} at offset {}: ", self.field, self.offset)?;
        match self.kind {
            ParseErrorKind::Short { expected, found } => {
                write!(f, "{} expected, {found} found", ByteCount(expected))
            }
            ParseErrorKind::Trailing { found } => write!(f, "{found} trailing {}", ByteCount(found).unit()),
            ParseErrorKind::Value { found } => write!(f, "value 0x{found:02X} is not allowed"),
        }
    }
}

impl core::error::Error for ParseError {}

/// The buffer of a [`Writer`](super::Writer) has no room for the field; nothing of the field was written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[error("no room left in the buffer")]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Full;
