//! Absolute deadlines with a name.

use core::hash::{Hash, Hasher};
use core::marker::PhantomData;

use core::time::Duration;

use crate::machine::Deadline;
use crate::time::Instant;

/// The timers that a machine has, as an enumeration: each an index and a name.
pub trait TimerKey<const N: usize>: Copy + 'static {
    /// All of them, in the order in which they are served when several expire at once.
    const ALL: [Self; N];
    /// What each of them waits for, in words ("duplicate MAC ID wait").
    const WHY: [&'static str; N];
    /// The place in [`ALL`](Self::ALL).
    fn index(self) -> usize;
}

/// Every instant that a machine stores.
///
/// It also keeps the latest `now` that the machine was told, because time may not run backwards
/// ([`advance`](Self::advance)). That all instants live here makes [`shift`](Self::shift) possible, by which a model
/// checker tells apart states that differ in more than the time of day.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Timers<K, const N: usize> {
    moments: Moments,
    /// [`Instant::MAX`] where a timer does not run: half the size of an `Option`.
    at: [Instant; N],
    key: PhantomData<K>,
}

/// What there is besides the timers, whatever their number.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Moments {
    now: Instant,
    /// No timer expires before this moment: an early answer for what is asked most. It is no part of the state.
    bound: Instant,
}

impl<K: TimerKey<N>, const N: usize> Timers<K, N> {
    /// No timer runs, and the time is zero.
    #[must_use]
    pub const fn new() -> Self {
        let moments = Moments { now: Instant::ZERO, bound: Instant::MAX };
        Self { moments, at: [Instant::MAX; N], key: PhantomData }
    }

    /// Takes note of the present moment, and returns it; a `now` before the last one is the last one.
    pub fn advance(&mut self, now: Instant) -> Instant {
        later(&mut self.moments.now, now)
    }

    /// The same without a call, for where every frame passes.
    #[inline]
    pub fn advance_inline(&mut self, now: Instant) -> Instant {
        self.moments.now = self.moments.now.max(now);
        self.moments.now
    }

    /// The latest moment that was noted.
    #[must_use]
    pub const fn now(&self) -> Instant {
        self.moments.now
    }

    /// Starts or restarts a timer. One that is set to [`Instant::MAX`] does not run.
    pub fn set(&mut self, key: K, at: Instant) {
        debug_assert!(key.index() < N, "the index {} of a timer is not one of {N}", key.index());
        set(self.at.get_mut(key.index()), &mut self.moments.bound, at);
    }

    /// Starts or restarts a timer that expires `span` from the latest moment that was noted.
    pub fn set_after(&mut self, key: K, span: Duration) {
        self.set(key, self.moments.now.saturating_add(span));
    }

    /// The same for a span in milliseconds, without the arithmetic of [`Duration`].
    pub fn set_after_millis(&mut self, key: K, millis: u32) {
        debug_assert!(key.index() < N, "the index {} of a timer is not one of {N}", key.index());
        start(self.at.get_mut(key.index()), &mut self.moments, millis);
    }

    /// The same without a call, for where every frame passes.
    #[inline]
    pub fn set_after_millis_inline(&mut self, key: K, millis: u32) {
        let at = self.moments.now.saturating_add_millis(millis);
        if let Some(slot) = self.at.get_mut(key.index()) {
            *slot = at;
        }
        self.moments.bound = self.moments.bound.min(at);
    }

    /// Stops a timer.
    #[inline]
    pub fn clear(&mut self, key: K) {
        if let Some(timer) = self.at.get_mut(key.index()) {
            *timer = Instant::MAX;
        }
    }

    /// Stops all timers.
    pub fn clear_all(&mut self) {
        self.at = [Instant::MAX; N];
    }

    /// When a timer expires; `None` if it does not run.
    #[must_use]
    pub fn at(&self, key: K) -> Option<Instant> {
        self.at.get(key.index()).copied().filter(|at| *at != Instant::MAX)
    }

    /// Whether a timer runs that expires by `now`. Most of the time, that is one comparison.
    #[inline]
    pub fn is_due(&mut self, now: Instant) -> bool {
        now >= self.moments.bound && expired(&self.at, &mut self.moments.bound, now).is_some()
    }

    /// Whether a timer may expire by `now`, by one comparison. False is certain; true may be about a timer that was stopped or
    /// started anew since, until [`take_expired`](Self::take_expired) has found that out.
    #[inline]
    #[must_use]
    pub fn may_be_due(&self, now: Instant) -> bool {
        now >= self.moments.bound
    }

    /// Stops and returns the timer that expired first by `now`; of several at the same moment, the first in
    /// [`TimerKey::ALL`].
    pub fn take_expired(&mut self, now: Instant) -> Option<K> {
        let index = expired(&self.at, &mut self.moments.bound, now)?;
        *self.at.get_mut(index)? = Instant::MAX;
        K::ALL.get(index).copied()
    }

    /// The next deadline.
    #[must_use]
    pub fn next(&self) -> Option<Deadline> {
        let mut at = Instant::MAX;
        let index = earliest(&self.at, &mut at)?;
        // By reference: who does not ask for the names has none of them in the program.
        let names: &'static [&'static str; N] = const { &K::WHY };
        Some(Deadline { at, why: names.get(index).copied().unwrap_or_default() })
    }

    /// Moves every stored instant, the noted present included, `span` towards zero.
    pub fn shift(&mut self, span: Duration) {
        self.moments.now = self.moments.now.saturating_sub(span);
        if self.moments.bound != Instant::MAX {
            self.moments.bound = self.moments.bound.saturating_sub(span);
        }
        for at in self.at.iter_mut().filter(|at| **at != Instant::MAX) {
            *at = at.saturating_sub(span);
        }
    }
}

// One copy of the code for the timers of all machines, and of the arithmetic in 64 bits.

#[inline(never)]
fn later(latest: &mut Instant, now: Instant) -> Instant {
    *latest = now.max(*latest);
    *latest
}

/// The product in two halves, which fit into 32 bits: a small processor multiplies no more at once.
#[inline(never)]
fn start(timer: Option<&mut Instant>, moments: &mut Moments, millis: u32) {
    let high = u64::from((millis >> 16).wrapping_mul(NANOS_PER_MILLI >> 6)) << 16;
    let low = u64::from((millis & 0xFFFF).wrapping_mul(NANOS_PER_MILLI >> 6));
    set(timer, &mut moments.bound, moments.now.saturating_add_nanos(high.wrapping_add(low) << 6));
}

fn set(timer: Option<&mut Instant>, bound: &mut Instant, at: Instant) {
    if let Some(timer) = timer {
        *timer = at;
    }
    *bound = at.min(*bound);
}

/// The first of the timers that are over at `now`. When the bound is reached, what it stood for may run later by now, or not at
/// all.
#[inline(never)]
fn expired(timers: &[Instant], bound: &mut Instant, now: Instant) -> Option<usize> {
    if now < *bound {
        return None;
    }
    let first = earliest(timers, bound);
    first.filter(|_| *bound <= now)
}

/// The first of the timers that expire next, and when it does: [`Instant::MAX`] if none runs.
#[inline(never)]
fn earliest(timers: &[Instant], when: &mut Instant) -> Option<usize> {
    let mut first = None;
    *when = Instant::MAX;
    for (index, &at) in timers.iter().enumerate() {
        if at < *when {
            *when = at;
            first = Some(index);
        }
    }
    first
}

/// [`Timers`] of any number, for a machine that is generic over which it has.
pub trait TimerSet<K> {
    /// [`Timers::advance`]
    fn advance(&mut self, now: Instant) -> Instant;
    /// [`Timers::advance_inline`]
    fn advance_inline(&mut self, now: Instant) -> Instant;
    /// [`Timers::now`]
    fn now(&self) -> Instant;
    /// [`Timers::set_after_millis`]
    fn set_after_millis(&mut self, key: K, millis: u32);
    /// [`Timers::set_after_millis_inline`]
    fn set_after_millis_inline(&mut self, key: K, millis: u32);
    /// [`Timers::clear`]
    fn clear(&mut self, key: K);
    /// [`Timers::at`]
    fn at(&self, key: K) -> Option<Instant>;
    /// [`Timers::may_be_due`]
    fn may_be_due(&self, now: Instant) -> bool;
    /// [`Timers::take_expired`]
    fn take_expired(&mut self, now: Instant) -> Option<K>;
    /// [`Timers::next`]
    fn next(&self) -> Option<Deadline>;
    /// [`Timers::shift`]
    fn shift(&mut self, span: Duration);
}

impl<K: TimerKey<N>, const N: usize> TimerSet<K> for Timers<K, N> {
    fn advance(&mut self, now: Instant) -> Instant {
        self.advance(now)
    }
    #[inline]
    fn advance_inline(&mut self, now: Instant) -> Instant {
        self.advance_inline(now)
    }
    fn now(&self) -> Instant {
        self.now()
    }
    fn set_after_millis(&mut self, key: K, millis: u32) {
        self.set_after_millis(key, millis);
    }
    #[inline]
    fn set_after_millis_inline(&mut self, key: K, millis: u32) {
        self.set_after_millis_inline(key, millis);
    }
    #[inline]
    fn clear(&mut self, key: K) {
        self.clear(key);
    }
    fn at(&self, key: K) -> Option<Instant> {
        self.at(key)
    }
    #[inline]
    fn may_be_due(&self, now: Instant) -> bool {
        self.may_be_due(now)
    }
    fn take_expired(&mut self, now: Instant) -> Option<K> {
        self.take_expired(now)
    }
    fn next(&self) -> Option<Deadline> {
        self.next()
    }
    fn shift(&mut self, span: Duration) {
        self.shift(span);
    }
}

impl<K, const N: usize> PartialEq for Timers<K, N> {
    fn eq(&self, other: &Self) -> bool {
        (self.moments.now, self.at) == (other.moments.now, other.at)
    }
}

impl<K, const N: usize> Eq for Timers<K, N> {}

impl<K, const N: usize> Hash for Timers<K, N> {
    fn hash<H: Hasher>(&self, state: &mut H) {
        (self.moments.now, self.at).hash(state);
    }
}

impl<K: TimerKey<N>, const N: usize> Default for Timers<K, N> {
    fn default() -> Self {
        Self::new()
    }
}

/// 64 times 15 625.
const NANOS_PER_MILLI: u32 = 1_000_000;

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Clone, Copy, PartialEq, Eq, Debug)]
    enum Key {
        A,
        B,
    }

    impl TimerKey<2> for Key {
        const ALL: [Self; 2] = [Key::A, Key::B];
        const WHY: [&'static str; 2] = ["a", "b"];
        fn index(self) -> usize {
            self as usize
        }
    }

    const fn ms(millis: u64) -> Instant {
        Instant::from_millis(millis)
    }

    #[test]
    fn the_earliest_expires_first_and_only_once() {
        let mut timers = Timers::<Key, 2>::new();
        timers.set(Key::A, ms(5));
        timers.set(Key::B, ms(3));
        assert_eq!(timers.next(), Some(Deadline { at: ms(3), why: "b" }));
        assert_eq!(timers.take_expired(ms(2)), None);
        assert_eq!(timers.take_expired(ms(9)), Some(Key::B));
        assert_eq!(timers.take_expired(ms(9)), Some(Key::A));
        assert_eq!(timers.take_expired(ms(9)), None);
    }

    #[test]
    fn equal_deadlines_are_served_in_the_order_of_the_keys() {
        let mut timers = Timers::<Key, 2>::new();
        timers.set(Key::B, ms(3));
        timers.set(Key::A, ms(3));
        assert_eq!(timers.take_expired(ms(3)), Some(Key::A));
    }

    #[test]
    fn time_never_runs_backwards() {
        let mut timers = Timers::<Key, 2>::new();
        assert_eq!(timers.advance(ms(7)), ms(7));
        assert_eq!(timers.advance(ms(4)), ms(7));
    }

    #[test]
    fn a_timer_set_to_never_does_not_run() {
        let mut timers = Timers::<Key, 2>::new();
        timers.set(Key::A, Instant::MAX);
        assert_eq!((timers.at(Key::A), timers.next()), (None, None));
        timers.shift(Duration::from_millis(1));
        assert_eq!(timers, Timers::new());
        assert_eq!(timers.take_expired(ms(u64::MAX)), None);
    }

    /// What was set and cleared on the way is forgotten.
    #[test]
    fn equal_timers_are_equal_whatever_their_past() {
        let mut timers = Timers::<Key, 2>::new();
        timers.set(Key::A, ms(1));
        timers.set(Key::A, ms(9));
        let mut other = Timers::<Key, 2>::new();
        other.set(Key::A, ms(9));
        assert_eq!(timers, other);
        assert_eq!(timers.take_expired(ms(8)), None);
        assert!(!timers.is_due(ms(8)) && timers.is_due(ms(9)));
        assert!(!timers.may_be_due(ms(8)) && timers.may_be_due(ms(9)));
        assert_eq!(timers.take_expired(ms(9)), Some(Key::A));
        assert_eq!(timers.take_expired(ms(9)), None);
    }

    #[test]
    fn a_span_in_milliseconds_is_the_same_span() {
        let mut timers = Timers::<Key, 2>::new();
        timers.advance(ms(7));
        timers.set_after(Key::A, Duration::from_millis(10_000));
        timers.set_after_millis(Key::B, 10_000);
        assert_eq!(timers.at(Key::A), timers.at(Key::B));
        assert!(!timers.is_due(ms(10_006)));
        assert!(timers.is_due(ms(10_007)));
        for millis in [0, 1, 0xFFFF, 0x1_0000, 0x1_0001, 0xFFFF_0000, u32::MAX] {
            timers.set_after(Key::A, Duration::from_millis(millis.into()));
            timers.set_after_millis(Key::B, millis);
            assert_eq!(timers.at(Key::A), timers.at(Key::B), "{millis} ms");
            timers.set_after_millis_inline(Key::B, millis);
            assert_eq!(timers.at(Key::A), timers.at(Key::B), "{millis} ms");
        }
    }

    #[test]
    fn shifting_makes_histories_of_equal_shape_equal() {
        let mut early = Timers::<Key, 2>::new();
        early.advance(ms(10));
        early.set_after(Key::A, Duration::from_millis(5));
        let mut late = Timers::<Key, 2>::new();
        late.advance(ms(110));
        late.set_after(Key::A, Duration::from_millis(5));
        assert_ne!(early, late);
        late.shift(Duration::from_millis(100));
        assert_eq!(early, late);
    }
}
