//! A station: a machine and its adapter.

use std::collections::VecDeque;
use std::fmt;
use std::time::Duration;

use link_core::Instant;

use crate::rng::Rng;

/// Names a station of one segment: 0 is the first that was added.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct StationId(pub(super) usize);

impl StationId {
    /// Its place in the order of the stations.
    #[must_use]
    pub const fn index(self) -> usize {
        self.0
    }
}

/// `station 3`
impl fmt::Display for StationId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "station {}", self.0)
    }
}

/// What a station is like.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct StationConfig {
    /// For traces and messages.
    pub name: String,
    /// From an input to the frame that follows from it.
    pub reaction: Duration,
    /// What may be added to that, by chance.
    pub jitter: Duration,
}

impl StationConfig {
    /// A station that answers at once.
    #[must_use]
    pub fn named(name: impl Into<String>) -> Self {
        Self { name: name.into(), reaction: Duration::ZERO, jitter: Duration::ZERO }
    }
}

#[derive(Debug)]
pub(super) struct Station<M> {
    pub(super) config: StationConfig,
    pub(super) machine: M,
    /// Frames that were handed to the adapter, in order.
    pub(super) outbox: VecDeque<Vec<u8>>,
    /// When the last of them is ready to be sent.
    pub(super) ready: Instant,
    /// The cable is in.
    pub(super) is_plugged: bool,
    /// How often the adapter has lost its link or its power, and with it what it had to send and what was on its way.
    pub(super) connection: u64,
    pub(super) rng: Rng,
}

impl<M> Station<M> {
    /// When a frame that is handed over now is ready to be sent: never before an earlier one.
    pub(super) fn react(&mut self, now: Instant) -> Instant {
        let nanos = u64::try_from(self.config.jitter.as_nanos()).unwrap_or(u64::MAX);
        let jitter = if nanos == 0 { 0 } else { self.rng.below(nanos.saturating_add(1)) };
        let at = now + self.config.reaction + Duration::from_nanos(jitter);
        self.ready = self.ready.max(at);
        self.ready
    }

    /// The adapter loses its link or its power. Returns how many frames it had to send.
    pub(super) fn disconnect(&mut self) -> usize {
        self.connection += 1;
        self.ready = Instant::ZERO;
        self.outbox.drain(..).count()
    }
}
