//! The frames of a recording, as passive decoders tell of them: which answers which.

#[cfg(feature = "serde")]
pub mod json;

use core::time::Duration;

use crate::Instant;

/// A frame of the recording that may be answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Seen {
    /// Its number in the recording.
    pub n: u64,
    /// When it was on the bus.
    pub at: Instant,
}

/// A frame that another one answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Answered {
    /// Its number in the recording.
    pub n: u64,
    /// From its end to the end of the answer. Of a fragmented message the last fragment counts.
    pub latency: Duration,
}

impl Seen {
    /// What an answer at `at` says of this frame.
    #[must_use]
    pub fn answered(self, at: Instant) -> Answered {
        Answered { n: self.n, latency: at.saturating_since(self.at) }
    }
}
