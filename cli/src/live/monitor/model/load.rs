//! How much of the time the bus is busy: by node, by purpose, now and in the past.

use std::collections::VecDeque;

use core::time::Duration;

use devicenet_core::MacId;
use link_core::Instant;

use super::purpose::Purpose;

/// Time that the bus was busy, in nanoseconds.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(in crate::live::monitor) struct Tally {
    /// By sender; the last is for frames whose sender is not known.
    by_node: [u64; MacId::COUNT + 1],
    by_purpose: [u64; Purpose::COUNT],
}

impl Default for Tally {
    fn default() -> Self {
        Self { by_node: [0; MacId::COUNT + 1], by_purpose: [0; Purpose::COUNT] }
    }
}

impl Tally {
    pub(super) fn add(&mut self, busy: u64, node: usize, purpose: Purpose) {
        self.by_node[node] += busy;
        self.by_purpose[purpose.index()] += busy;
    }

    /// Changes every time.
    pub(super) fn scale(&mut self, scale: impl Fn(u64) -> u64) {
        self.by_node = self.by_node.map(&scale);
        self.by_purpose = self.by_purpose.map(&scale);
    }

    fn join(&mut self, other: &Self) {
        self.by_node.iter_mut().zip(other.by_node).for_each(|(sum, busy)| *sum += busy);
        self.by_purpose.iter_mut().zip(other.by_purpose).for_each(|(sum, busy)| *sum += busy);
    }

    /// The parts of a span.
    pub(super) fn load(&self, span: Duration) -> Load {
        let share = |busy: u64| if span.is_zero() { 0.0 } else { busy as f64 / span.as_nanos() as f64 };
        Load {
            all: share(self.by_purpose.iter().sum()),
            by_node: self.by_node.map(share),
            by_purpose: self.by_purpose.map(share),
        }
    }
}

/// Parts of a span, 0 to 1.
#[derive(Clone, PartialEq, Debug)]
pub(in crate::live::monitor) struct Load {
    /// Of all frames.
    pub(in crate::live::monitor) all: f64,
    /// As in [`Tally`].
    pub(in crate::live::monitor) by_node: [f64; MacId::COUNT + 1],
    /// In the order of [`Purpose::ALL`].
    pub(in crate::live::monitor) by_purpose: [f64; Purpose::COUNT],
}

/// What happened in equal spans, of which the last ones are kept.
#[derive(Clone, Debug)]
pub(super) struct Spans<T> {
    length: u64,
    most: usize,
    spans: VecDeque<T>,
    /// The number of the span that is under way, from the zero of time.
    last: u64,
}

impl<T: Clone + Default> Spans<T> {
    /// Spans of a length; `most` that are over, and the one that is under way.
    pub(super) fn new(length: Duration, most: usize) -> Self {
        let mut spans = VecDeque::with_capacity(most + 1);
        spans.push_back(T::default());
        Self { length: length.as_nanos() as u64, most, spans, last: 0 }
    }

    /// The first moment of all: what comes before it was not seen.
    pub(super) fn begin(&mut self, at: Instant) {
        self.last = at.as_nanos() / self.length;
        self.spans.clear();
        self.spans.push_back(T::default());
    }

    /// It is so late.
    pub(super) fn advance(&mut self, now: Instant) {
        let present = now.as_nanos() / self.length;
        for _ in 0..present.saturating_sub(self.last).min(self.most as u64 + 1) {
            if self.spans.len() > self.most {
                self.spans.pop_front();
            }
            self.spans.push_back(T::default());
        }
        self.last = self.last.max(present);
    }

    /// Shares a time out among the spans that it is in.
    pub(super) fn spread(&mut self, from: Instant, to: Instant, mut add: impl FnMut(&mut T, u64)) {
        self.advance(to);
        let (mut from, to) = (from.as_nanos(), to.as_nanos());
        while from < to {
            let span = from / self.length;
            let until = to.min((span + 1) * self.length);
            let back = usize::try_from(self.last - span.min(self.last)).unwrap_or(usize::MAX);
            let index = self.spans.len().checked_sub(back + 1);
            if let Some(found) = index.and_then(|index| self.spans.get_mut(index)) {
                add(found, until - from);
            }
            from = until;
        }
    }

    /// The oldest first, with the one that is under way.
    pub(super) fn iter(&self) -> impl DoubleEndedIterator<Item = &T> + ExactSizeIterator {
        self.spans.iter()
    }

    /// Changes all that are kept.
    pub(super) fn each(&mut self, change: impl FnMut(&mut T)) {
        self.spans.iter_mut().for_each(change);
    }

    /// When the oldest began.
    pub(super) fn since(&self) -> Instant {
        Instant::from_nanos((self.last + 1 - self.spans.len() as u64) * self.length)
    }
}

/// The load of the last second.
#[derive(Clone, Debug)]
pub(super) struct Window(pub(super) Spans<Tally>);

impl Window {
    pub(super) fn new() -> Self {
        Self(Spans::new(SLICE, SLICES))
    }

    pub(super) fn load(&self, begin: Instant, now: Instant) -> Load {
        let mut sum = Tally::default();
        self.0.iter().for_each(|tally| sum.join(tally));
        sum.load(now.saturating_since(self.0.since().max(begin)))
    }
}

/// The load of the last minutes, a value a second.
#[derive(Clone, Debug)]
pub(super) struct History(pub(super) Spans<[u64; Purpose::COUNT]>);

impl History {
    pub(super) fn new() -> Self {
        Self(Spans::new(SECOND, SECONDS))
    }

    /// Of the seconds that are over, the oldest first: parts of a second, 0 to 1.
    pub(super) fn shares(&self) -> Vec<[f64; Purpose::COUNT]> {
        let over = self.0.iter().len() - 1;
        self.0.iter().take(over).map(|busy| busy.map(|nanos| nanos as f64 / 1e9)).collect()
    }
}

/// The window moves in steps of this.
const SLICE: Duration = Duration::from_millis(100);
const SLICES: usize = 10;
const SECOND: Duration = Duration::from_secs(1);
const SECONDS: usize = 300;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_that_spans_two_slices_counts_in_both() {
        let us = Instant::from_micros;
        let mut spans = Spans::<u64>::new(SLICE, 2);
        spans.begin(us(0));
        spans.spread(us(99_600), us(100_400), |sum, busy| *sum += busy);
        assert_eq!(spans.iter().copied().collect::<Vec<_>>(), [400_000, 400_000]);
        spans.spread(us(350_000), us(350_001), |sum, busy| *sum += busy);
        assert_eq!(spans.iter().copied().collect::<Vec<_>>(), [400_000, 0, 1_000]);
        assert_eq!(spans.since(), us(100_000));
        // What is older than all of them is forgotten, and a long silence leaves nothing.
        spans.spread(us(0), us(1), |sum, busy| *sum += busy);
        spans.advance(Instant::from_millis(86_400_000));
        assert_eq!(spans.iter().copied().collect::<Vec<_>>(), [0, 0, 0]);
        assert_eq!(spans.since(), Instant::from_millis(86_399_800));
    }

    #[test]
    fn a_full_bus_is_a_load_of_one() {
        let mut window = Window::new();
        let begin = Instant::from_millis(5_000);
        window.0.begin(begin);
        let mut at = begin;
        let length = Duration::from_micros(888);
        while at < Instant::from_millis(9_777) {
            let to = at + length;
            window.0.spread(at, to, |tally, busy| tally.add(busy, 3, Purpose::Poll));
            at = to;
        }
        let load = window.load(begin, at);
        assert_eq!((load.all, load.by_node[3], load.by_purpose[0]), (1.0, 1.0, 1.0));
    }
}
