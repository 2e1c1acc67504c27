//! The fragmentation byte of a reading.

use core::fmt;

use crate::fragment::{FragmentByte, FragmentKind};
use crate::text::write_prefixed_hex;

/// A fragmentation byte.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Frag {
    /// Type and count.
    pub byte: FragmentByte,
    /// Status of an acknowledge.
    pub status: Option<u8>,
}

impl Frag {
    /// Without the status of an acknowledge.
    #[must_use]
    pub const fn new(byte: FragmentByte) -> Self {
        Self { byte, status: None }
    }

    /// `first`, `middle`, `last`, `ack`.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self.byte.kind {
            FragmentKind::First => "first",
            FragmentKind::Middle => "middle",
            FragmentKind::Last => "last",
            FragmentKind::Acknowledge => "ack",
        }
    }
}

/// `last fragment 2`; `acknowledge of fragment 0: too much data`.
impl fmt::Display for Frag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.byte, f)?;
        match self.status {
            Some(0) | None => Ok(()),
            Some(1) => f.write_str(": too much data"),
            Some(status) => {
                f.write_str(": status ")?;
                write_prefixed_hex(f, status.into())
            }
        }
    }
}
