//! What came last.

use core::time::Duration;
use std::collections::VecDeque;

use link_core::Instant;

/// What came in the last span, as far as there is room for it.
#[derive(Clone, Debug)]
pub(super) struct Ring<T> {
    span: Duration,
    most: usize,
    kept: VecDeque<(Instant, T)>,
    /// How many there was no room for, by the beginning of their slice of the span.
    dropped: VecDeque<(Instant, u64)>,
}

impl<T> Ring<T> {
    /// With room for so many.
    pub(super) const fn new(span: Duration, most: usize) -> Self {
        Self { span, most, kept: VecDeque::new(), dropped: VecDeque::new() }
    }

    pub(super) fn push(&mut self, at: Instant, what: T) {
        self.forget(at);
        if self.kept.len() >= self.most
            && let Some((at, _)) = self.kept.pop_front()
        {
            self.drop_one(at);
        }
        self.kept.push_back((at, what));
    }

    /// Gives everything that came in the span before a moment, the oldest first, and says how many more there were: exactly, but for a
    /// hundredth of the span.
    pub(super) fn take(&mut self, now: Instant) -> (VecDeque<(Instant, T)>, u64) {
        self.forget(now);
        let dropped = self.dropped.drain(..).map(|(_, count)| count).sum();
        (core::mem::take(&mut self.kept), dropped)
    }

    fn drop_one(&mut self, at: Instant) {
        let slice = self.slice();
        match self.dropped.back_mut() {
            Some((begin, count)) if at.saturating_since(*begin) < slice => *count += 1,
            _ => self.dropped.push_back((at, 1)),
        }
    }

    /// What came before the span is not wanted.
    fn forget(&mut self, now: Instant) {
        let oldest = now.saturating_sub(self.span);
        let slice = self.slice();
        while self.kept.front().is_some_and(|(at, _)| *at < oldest) {
            self.kept.pop_front();
        }
        while self.dropped.front().is_some_and(|(begin, _)| begin.saturating_add(slice) < oldest) {
            self.dropped.pop_front();
        }
    }

    fn slice(&self) -> Duration {
        self.span / SLICES
    }
}

/// How finely what was dropped is told apart by time.
const SLICES: u32 = 100;

#[cfg(test)]
mod tests {
    use super::*;

    fn at(millis: u64) -> Instant {
        Instant::from_millis(millis)
    }

    #[test]
    fn what_there_is_no_room_for_is_counted() {
        let mut ring = Ring::new(Duration::from_secs(1), 3);
        for millis in [0, 10, 900, 1_000, 1_001, 1_002] {
            ring.push(at(millis), millis);
        }
        // 0 was too old at 1.001; 10 and 900 had to go.
        let (kept, dropped) = ring.take(at(1_002));
        assert_eq!(kept.iter().map(|(_, what)| *what).collect::<Vec<_>>(), [1_000, 1_001, 1_002]);
        assert_eq!(dropped, 3, "0 is within a hundredth of the span");
        assert_eq!(ring.take(at(1_003)).1, 0);
    }

    #[test]
    fn what_was_dropped_long_ago_is_not_missed() {
        let mut ring = Ring::new(Duration::from_secs(1), 3);
        (0..100).for_each(|millis| ring.push(at(millis), millis));
        ring.push(at(2_000), 2_000);
        let (kept, dropped) = ring.take(at(2_500));
        assert_eq!((kept.len(), dropped), (1, 0));
    }
}
