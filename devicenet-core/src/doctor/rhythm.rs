//! The rhythm in which a slave produces by change of state or cyclic, and what does not fit into it.
//!
//! A single producer sends when something changes, and so long after its last message, whatever that was, as its expected packet
//! rate says. Who does not is two.

use core::time::Duration;

use link_core::Instant;

use super::patient::Seen;
use crate::monitor;

/// The last messages of a slave.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Rhythm {
    last: Option<Message>,
    /// The last one with other data than that.
    other: Option<Message>,
    doubt: Option<Doubt>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Message {
    at: Instant,
    len: usize,
    /// Of all of its data, of which there can be more than anybody keeps.
    digest: u64,
}

/// What did not fit of late.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Doubt {
    first: Seen,
    points: u8,
}

impl Rhythm {
    pub(super) const NEW: Self = Self { last: None, other: None, doubt: None };

    /// A message. `is_again`: it is the one before again, which was not acknowledged, or was destroyed for somebody. Returns the first
    /// one that did not fit, if there are too many of them.
    pub(super) fn message(
        &mut self,
        seen: Seen,
        data: &[u8],
        rhythm: &monitor::Rhythm,
        is_again: bool,
    ) -> Option<Seen> {
        let message = Message::new(seen.at, data);
        let points = if is_again { 0 } else { self.points(&message, rhythm) };
        match self.last {
            Some(last) if last.is_same(&message) => {}
            last => self.other = last,
        }
        self.last = Some(message);
        if points == 0 {
            return None;
        }
        let within = SHORTEST_SPAN.max(rhythm.period.saturating_mul(PERIODS));
        let held = self.doubt.filter(|doubt| seen.at.saturating_since(doubt.first.at) <= within);
        let mut doubt = held.unwrap_or(Doubt { first: seen, points: 0 });
        doubt.points = doubt.points.saturating_add(points);
        self.doubt = Some(doubt);
        (doubt.points >= TOO_MANY).then_some(doubt.first)
    }

    fn points(&self, message: &Message, rhythm: &monitor::Rhythm) -> u8 {
        let Some(last) = self.last else { return 0 };
        let gap = message.at.saturating_since(last.at);
        let is_early = gap.saturating_mul(2) < rhythm.period;
        if gap.saturating_mul(2) < rhythm.inhibit || rhythm.is_cyclic && is_early {
            // Half of the time is more than a busy bus can take.
            return CERTAIN;
        }
        if last.is_same(message) {
            // Nothing has changed, and it was not time yet.
            return if is_early { LIKELY } else { 0 };
        }
        let Some(other) = self.other.filter(|other| other.is_same(message)) else { return 0 };
        // One that sends the same on and on, at its own time, as if nothing had been sent in between.
        let since = message.at.saturating_since(other.at);
        let tolerance = rhythm.period.checked_div(PARTS).unwrap_or_default().max(SHORTEST_TOLERANCE);
        let is_in_time = since.abs_diff(rhythm.period) <= tolerance;
        // A value that comes and goes by halves of it could be a single one.
        let is_half = gap.saturating_mul(2).abs_diff(rhythm.period) <= tolerance.saturating_mul(4);
        if is_in_time && !is_half { LIKELY } else { 0 }
    }
}

impl Message {
    fn new(at: Instant, data: &[u8]) -> Self {
        // FNV-1a.
        let digest = data.iter().fold(0xCBF2_9CE4_8422_2325, |digest: u64, &byte| {
            (digest ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3)
        });
        Self { at, len: data.len(), digest }
    }

    fn is_same(&self, other: &Self) -> bool {
        (self.len, self.digest) == (other.len, other.digest)
    }
}

/// What no single sender does.
const CERTAIN: u8 = 2;
/// What it does now and then.
const LIKELY: u8 = 1;
const TOO_MANY: u8 = 6;
/// Within which they count together.
const SHORTEST_SPAN: Duration = Duration::from_secs(10);
const PERIODS: u32 = 12;
/// A message is in time if it differs by less than such a part of the expected packet rate.
const PARTS: u32 = 50;
const SHORTEST_TOLERANCE: Duration = Duration::from_millis(2);
