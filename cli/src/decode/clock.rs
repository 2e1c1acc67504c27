//! The time that a line shows.

use link_core::Instant;

use crate::args::TimeFormat;

/// Turns the time of a frame into that of its line.
pub(super) struct Clock {
    format: TimeFormat,
    /// What times are counted from.
    origin: Option<Instant>,
}

impl Clock {
    pub(super) fn new(format: TimeFormat) -> Self {
        Self { format, origin: None }
    }

    /// Takes note of a frame, which need not be shown.
    #[inline]
    pub(super) fn see(&mut self, at: Instant) {
        self.origin.get_or_insert(at);
    }

    /// The time to show; 0 for a frame that is earlier than what it is counted from.
    #[inline]
    pub(super) fn show(&mut self, at: Instant) -> Instant {
        let origin = match self.format {
            TimeFormat::Absolute => return at,
            TimeFormat::Relative => self.origin.unwrap_or(at),
            TimeFormat::Delta => self.origin.replace(at).unwrap_or(at),
        };
        Instant::from_nanos(at.as_nanos().saturating_sub(origin.as_nanos()))
    }
}
