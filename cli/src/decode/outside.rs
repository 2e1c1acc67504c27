//! What is on the bus but is no DeviceNet frame, and cannot be.

use core::fmt;

use crate::recording::ErrorFrame;

/// An entry of a recording that no monitor is asked about.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Outside {
    /// The controller reported an error.
    Error(ErrorFrame),
    /// A CAN FD frame, which every DeviceNet node answers with an error frame.
    Fd,
}

impl Outside {
    /// A stable name, as those of the problems that a monitor finds.
    pub(super) fn code(self) -> &'static str {
        match self {
            Self::Error(_) => "error_frame",
            Self::Fd => "can_fd_frame",
        }
    }
}

impl fmt::Display for Outside {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Error(error) => error.fmt(f),
            Self::Fd => f.write_str("CAN FD frame"),
        }
    }
}
