//! The time that is shown: `--from` and `--to`.

use core::time::Duration;

use link_core::Instant;

use crate::args::DecodeArgs;
use crate::scenario::Time;

/// A part of a recording.
pub(super) struct Span {
    /// Since the first frame.
    from: Duration,
    to: Duration,
    first: Option<Instant>,
}

impl Span {
    pub(super) fn new(args: &DecodeArgs) -> Self {
        let from = args.from.map_or(Duration::ZERO, |Time(from)| from);
        let to = args.to.map_or(Duration::MAX, |Time(to)| to);
        Self { from, to, first: None }
    }

    /// The first frame of the recording.
    pub(super) fn begin(&self) -> Instant {
        self.first.unwrap_or_default()
    }

    /// Whether a frame is in it; one that is earlier than the first is at 0.
    #[inline]
    pub(super) fn contains(&mut self, at: Instant) -> bool {
        let since = at.saturating_since(*self.first.get_or_insert(at));
        (self.from..=self.to).contains(&since)
    }
}
