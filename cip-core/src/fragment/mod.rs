//! Fragmentation: messages that are longer than a CAN frame (CIP Vol. 3, fragmentation protocol).
//!
//! Both kinds of fragmentation share the fragmentation byte:
//!
//! | Bits 7-6 | Type | Bits 5-0 |
//! |---|---|---|
//! | 00 | first fragment | 0; for I/O also 0x3F = first and only fragment |
//! | 01 | middle fragment | count 1, 2, ... |
//! | 10 | last fragment | count |
//! | 11 | fragment acknowledge (explicit only) | count of the fragment acknowledged |
//!
//! | | Explicit | I/O |
//! |---|---|---|
//! | Used when | the body has more than 7 bytes; bit 7 of the header says so | the configured connection size is above 8 |
//! | Data field | header, fragmentation byte, up to 6 body bytes | fragmentation byte, up to 7 data bytes |
//! | Acknowledged | every fragment | never |
//! | Count | wraps from 63 to 0 | ends at 63: at most 448 bytes |
//! | Cut by | [`explicit_fragment`], [`ExplicitFragments`] | [`IoFragments`] |
//! | Paced by | [`ExplicitTransmit`] | nothing; [`IoTransmit`] keeps the message |
//! | Put together by | [`ExplicitReassembly`]; [`ExplicitReceive`] in a buffer of its owner | [`IoReassembly`] |

mod cut;
mod explicit;
mod io;
mod io_transmit;
#[cfg(test)]
mod properties;
mod receive;
mod transmit;

pub use cut::{
    EmptyMessage, ExplicitFragments, Fragment, IoFragments, explicit_fragment, explicit_piece,
    is_fragmented_explicit,
};
pub use explicit::{AckStatus, ExplicitOutcome, ExplicitReassembly};
pub use io::{IoOutcome, IoReassembly};
pub use io_transmit::IoTransmit;
pub use receive::ExplicitReceive;
pub use transmit::{ExplicitTransmit, TransmitOutcome};

use core::fmt;

/// The most body bytes in a fragment of an explicit message.
pub const EXPLICIT_FRAGMENT_LEN: usize = 6;
/// The longest body of an explicit message that is sent in one frame.
pub const EXPLICIT_UNFRAGMENTED_LEN: usize = 7;
/// The most data bytes in a fragment of an I/O message.
pub const IO_FRAGMENT_LEN: usize = 7;
/// The longest I/O message: 64 fragments, because the count does not wrap.
pub const IO_MESSAGE_MAX: usize = 448;
/// The largest connection size that is sent without a fragmentation byte.
pub const IO_UNFRAGMENTED_LEN: usize = 8;

/// The type of a fragment: bits 7 and 6 of the fragmentation byte.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FragmentKind {
    /// Starts a message.
    First,
    /// Continues it.
    Middle,
    /// Completes it.
    Last,
    /// Acknowledges a fragment of an explicit message.
    Acknowledge,
}

/// The fragmentation byte.
///
/// ```
/// use cip_core::fragment::{FragmentByte, FragmentKind};
///
/// let byte = FragmentByte::from(0x81);
/// assert_eq!((byte.kind, byte.count()), (FragmentKind::Last, 1));
/// assert_eq!(u8::from(byte), 0x81);
/// assert_eq!(byte.to_string(), "last fragment 1");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FragmentByte {
    /// What the fragment is.
    pub kind: FragmentKind,
    count: u8,
}

impl FragmentByte {
    /// The byte of the first fragment of several.
    pub const FIRST: Self = Self { kind: FragmentKind::First, count: 0 };
    /// The byte of an I/O message that needs only one fragment.
    pub const FIRST_AND_ONLY: Self = Self { kind: FragmentKind::First, count: COUNT_MASK };

    /// Joins a type and a count, which is taken modulo 64.
    pub const fn new(kind: FragmentKind, count: u8) -> Self {
        Self { kind, count: count & COUNT_MASK }
    }

    /// The count, 0-63.
    pub const fn count(self) -> u8 {
        self.count
    }
}

impl From<u8> for FragmentByte {
    fn from(byte: u8) -> Self {
        let kind = match byte >> 6 {
            0 => FragmentKind::First,
            1 => FragmentKind::Middle,
            2 => FragmentKind::Last,
            _ => FragmentKind::Acknowledge,
        };
        Self::new(kind, byte)
    }
}

impl From<FragmentByte> for u8 {
    fn from(byte: FragmentByte) -> Self {
        let kind = match byte.kind {
            FragmentKind::First => 0x00,
            FragmentKind::Middle => 0x40,
            FragmentKind::Last => 0x80,
            FragmentKind::Acknowledge => 0xC0,
        };
        kind | byte.count
    }
}

impl fmt::Display for FragmentByte {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if *self == Self::FIRST_AND_ONLY {
            return f.write_str("first and only fragment");
        }
        f.write_str(match self.kind {
            FragmentKind::First => "first fragment ",
            FragmentKind::Middle => "middle fragment ",
            FragmentKind::Last => "last fragment ",
            FragmentKind::Acknowledge => "acknowledge of fragment ",
        })?;
        crate::text::write_decimal(f, self.count.into())
    }
}

const fn next_count(count: u8) -> u8 {
    count.wrapping_add(1) & COUNT_MASK
}

const COUNT_MASK: u8 = 0x3F;
