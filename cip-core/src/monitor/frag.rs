//! The fragmentation byte of a reading.

use crate::fragment::{FragmentByte, FragmentKind};

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
