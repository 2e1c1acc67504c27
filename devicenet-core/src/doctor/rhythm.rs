//! The rhythm in which a slave produces by change of state or cyclic, and what does not fit into it.
//!
//! A single producer sends when something changes, when its application wants it, and so long after its last message, whatever that
//! was, as its expected packet rate says. Who goes on at that rate as if nothing had been sent in between is two.

use core::time::Duration;

use link_core::Instant;

use super::patient::{AGAIN, Seen};
use crate::monitor;

/// The last messages of a slave.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Rhythm {
    last: Option<Message>,
    /// When the two before it were, the newer one first.
    earlier: [Option<Instant>; 2],
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
    /// An error came before it, so that it may have waited.
    may_be_late: bool,
}

/// What may have become of the message before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Before {
    /// It got through.
    Sent,
    /// It was not acknowledged: this is another attempt, with what the data are by now.
    Unacknowledged,
    /// There was an error since, by which it may have been destroyed for somebody: then it is sent again at once.
    Doubtful,
}

/// What did not fit of late.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Doubt {
    first: Seen,
    /// Of messages that are certainly or likely of a second producer.
    points: u16,
    /// Messages that the application explains as well, a point each.
    possible: u16,
    /// Messages that nothing but the application explains.
    triggered: u16,
}

/// What a message says.
enum Points {
    /// That it fits.
    None,
    /// That it came early, without a change, and not as if it were of a second producer.
    Triggered,
    /// That it is of a second producer, or of an application that triggers what has not changed.
    Possible,
    /// So much that there are two producers.
    Second(u16),
}

impl Rhythm {
    pub(super) const NEW: Self = Self { last: None, earlier: [None; 2], other: None, doubt: None };

    /// A message. Returns the first one that did not fit, if there are too many of them.
    pub(super) fn message(
        &mut self,
        seen: Seen,
        data: &[u8],
        rhythm: &monitor::Rhythm,
        before: Before,
    ) -> Option<Seen> {
        let message = Message::new(seen.at, data, before);
        let is_again = self.is_again(&message, before);
        let points = if is_again { Points::None } else { self.points(&message, rhythm) };
        match self.last {
            Some(last) if last.is_same(&message) => {}
            last => self.other = last,
        }
        let before = self.last.replace(message);
        match (before, &mut self.last) {
            // Its time is that of the first attempt.
            (Some(before), Some(last)) if is_again => last.at = before.at,
            (before, _) => self.earlier = [before.map(|before| before.at), self.earlier[0]],
        }
        let within = SHORTEST_SPAN.max(rhythm.period.saturating_mul(PERIODS));
        self.doubt = self.doubt.filter(|doubt| seen.at.saturating_since(doubt.first.at) <= within);
        match points {
            Points::None => return None,
            Points::Triggered => {
                if let Some(doubt) = &mut self.doubt {
                    doubt.triggered = doubt.triggered.saturating_add(1);
                }
                return None;
            }
            Points::Possible => {
                let doubt = self.doubt.get_or_insert(Doubt::of(seen));
                doubt.possible = doubt.possible.saturating_add(1);
            }
            Points::Second(points) => {
                let doubt = self.doubt.get_or_insert(Doubt::of(seen));
                doubt.points = doubt.points.saturating_add(points);
            }
        }
        self.doubt.filter(|doubt| doubt.is_enough()).map(|doubt| doubt.first)
    }

    /// Whether a message is the one before again.
    fn is_again(&self, message: &Message, before: Before) -> bool {
        match before {
            Before::Sent => false,
            Before::Unacknowledged => true,
            Before::Doubtful => self
                .last
                .is_some_and(|last| last.is_same(message) && message.at.saturating_since(last.at) <= AGAIN),
        }
    }

    fn points(&self, message: &Message, rhythm: &monitor::Rhythm) -> Points {
        let Some(last) = self.last else { return Points::None };
        let gap = message.at.saturating_since(last.at);
        let is_early = gap.saturating_mul(2) < rhythm.period;
        if !last.may_be_late && (gap.saturating_mul(2) < rhythm.inhibit || rhythm.is_cyclic && is_early) {
            // Half of the time is more than a busy bus can take.
            return Points::Second(CERTAIN);
        }
        let tolerance = rhythm.period.checked_div(PARTS).unwrap_or_default().max(SHORTEST_TOLERANCE);
        // One that sends the same on and on, at its own time, as if nothing had been sent in between.
        let is_in_time =
            |before: Instant| message.at.saturating_since(before).abs_diff(rhythm.period) <= tolerance;
        if last.is_same(message) {
            // The time of a single producer begins with its last message.
            let is_of_another = gap.saturating_add(tolerance) < rhythm.period
                && !self.is_steady(gap)
                && self.earlier.into_iter().flatten().any(is_in_time);
            return match (is_of_another, is_early) {
                (true, _) => Points::Possible,
                // Nothing has changed, and it was not time yet.
                (false, true) => Points::Triggered,
                (false, false) => Points::None,
            };
        }
        let Some(other) = self.other.filter(|other| other.is_same(message)) else { return Points::None };
        // A value that comes and goes by halves of it could be a single one.
        let is_half = gap.saturating_mul(2).abs_diff(rhythm.period) <= tolerance.saturating_mul(4);
        if is_in_time(other.at) && !is_half { Points::Second(LIKELY) } else { Points::None }
    }

    /// The distance from the last message is about that from the one before: so an application does it that triggers from a timer.
    fn is_steady(&self, gap: Duration) -> bool {
        let Some((last, before)) = self.last.zip(self.earlier[0]) else { return false };
        let gap_before = last.at.saturating_since(before);
        gap.min(gap_before).saturating_mul(3) >= gap.max(gap_before).saturating_mul(2)
    }
}

impl Doubt {
    const fn of(first: Seen) -> Self {
        Self { first, points: 0, possible: 0, triggered: 0 }
    }

    fn is_enough(&self) -> bool {
        // An application that triggers without a change does so at any time, now and then at that of a second producer.
        let possible = if self.possible >= self.triggered { self.possible } else { 0 };
        self.points.saturating_add(possible) >= TOO_MANY
    }
}

impl Message {
    fn new(at: Instant, data: &[u8], before: Before) -> Self {
        // FNV-1a.
        let digest = data.iter().fold(0xCBF2_9CE4_8422_2325, |digest: u64, &byte| {
            (digest ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3)
        });
        Self { at, len: data.len(), digest, may_be_late: before == Before::Doubtful }
    }

    fn is_same(&self, other: &Self) -> bool {
        (self.len, self.digest) == (other.len, other.digest)
    }
}

/// What no single sender does.
const CERTAIN: u16 = 4;
/// What it does now and then.
const LIKELY: u16 = 2;
const TOO_MANY: u16 = 12;
/// Within which they count together.
const SHORTEST_SPAN: Duration = Duration::from_secs(10);
const PERIODS: u32 = 12;
/// A message is in time if it differs by less than such a part of the expected packet rate.
const PARTS: u32 = 50;
const SHORTEST_TOLERANCE: Duration = Duration::from_millis(2);
