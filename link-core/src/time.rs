//! Time as the cores see it: nanoseconds since an arbitrary zero.

use core::fmt;
use core::ops::{Add, AddAssign};
use core::time::Duration;

/// A moment, in nanoseconds since an arbitrary zero that one program keeps for all its machines.
///
/// 64 bits last for 584 years, so additions saturate instead of failing. There is no `a - b`: the answer to "how
/// long ago" depends on what a negative one should mean, so it is [`checked_since`](Self::checked_since) or
/// [`saturating_since`](Self::saturating_since).
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Instant(u64);

impl Instant {
    /// The arbitrary zero.
    pub const ZERO: Self = Self(0);
    /// Later than every other moment: "never".
    pub const MAX: Self = Self(u64::MAX);

    /// The moment `nanos` nanoseconds after zero.
    #[must_use]
    pub const fn from_nanos(nanos: u64) -> Self {
        Self(nanos)
    }

    /// The moment `micros` microseconds after zero.
    #[must_use]
    pub const fn from_micros(micros: u64) -> Self {
        Self(micros.saturating_mul(1_000))
    }

    /// The moment `millis` milliseconds after zero.
    #[must_use]
    pub const fn from_millis(millis: u64) -> Self {
        Self(millis.saturating_mul(1_000_000))
    }

    /// Nanoseconds since zero.
    #[must_use]
    pub const fn as_nanos(self) -> u64 {
        self.0
    }

    /// How long after `earlier` this is, or `None` if it is before.
    #[must_use]
    pub const fn checked_since(self, earlier: Self) -> Option<Duration> {
        match self.0.checked_sub(earlier.0) {
            Some(nanos) => Some(Duration::from_nanos(nanos)),
            None => None,
        }
    }

    /// How long after `earlier` this is; zero if it is before.
    #[must_use]
    pub const fn saturating_since(self, earlier: Self) -> Duration {
        Duration::from_nanos(self.0.saturating_sub(earlier.0))
    }

    /// This moment plus `span`, at most [`MAX`](Self::MAX).
    #[must_use]
    pub fn saturating_add(self, span: Duration) -> Self {
        Self(self.0.saturating_add(nanos(span)))
    }

    /// This moment plus `millis` milliseconds, at most [`MAX`](Self::MAX).
    #[must_use]
    pub fn saturating_add_millis(self, millis: u32) -> Self {
        // 2^32 ms are less than 2^52 ns.
        self.saturating_add_nanos(u64::from(millis).wrapping_mul(1_000_000))
    }

    /// This moment plus `nanos` nanoseconds, at most [`MAX`](Self::MAX).
    #[must_use]
    pub const fn saturating_add_nanos(self, nanos: u64) -> Self {
        Self(self.0.saturating_add(nanos))
    }

    /// The last moment before this one, at least [`ZERO`](Self::ZERO).
    #[must_use]
    pub const fn preceding(self) -> Self {
        Self(self.0.saturating_sub(1))
    }

    /// This moment minus `span`, at least [`ZERO`](Self::ZERO).
    #[must_use]
    pub fn saturating_sub(self, span: Duration) -> Self {
        Self(self.0.saturating_sub(nanos(span)))
    }
}

impl Add<Duration> for Instant {
    type Output = Self;
    /// Saturates at [`Instant::MAX`].
    fn add(self, span: Duration) -> Self {
        self.saturating_add(span)
    }
}

impl AddAssign<Duration> for Instant {
    fn add_assign(&mut self, span: Duration) {
        *self = self.saturating_add(span);
    }
}

/// Seconds with nine decimals, or as many as the precision says (cut, not rounded, so that a trace never shows a
/// moment that has not come yet).
impl fmt::Display for Instant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (seconds, mut fraction) = (self.0 / NANOS_PER_SECOND, self.0 % NANOS_PER_SECOND);
        let digits = f.precision().unwrap_or(9).min(9);
        if digits == 0 {
            return write!(f, "{seconds}");
        }
        for _ in digits..9 {
            fraction /= 10;
        }
        write!(f, "{seconds}.{fraction:0digits$}")
    }
}

/// Without the 128 bits of [`Duration::as_nanos`], which a small processor pays dearly.
fn nanos(span: Duration) -> u64 {
    span.as_secs().saturating_mul(1_000_000_000).saturating_add(span.subsec_nanos().into())
}

/// Joins [`Instant`] to the standard library's clock: an epoch, and the way there and back.
///
/// ```
/// use core::time::Duration;
/// use link_core::time::Clock;
/// let clock = Clock::start();
/// let deadline = clock.now() + Duration::from_millis(75);
/// // What a run loop gives to its poll or sleep:
/// let wait = clock.until(deadline);
/// assert!(wait <= Duration::from_millis(75));
/// assert_eq!(clock.to_std(deadline).map(|at| clock.instant(at)), Some(deadline));
/// ```
#[cfg(feature = "std")]
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    epoch: std::time::Instant,
}

#[cfg(feature = "std")]
impl Clock {
    /// A clock whose zero is now.
    #[must_use]
    pub fn start() -> Self {
        Self { epoch: std::time::Instant::now() }
    }

    /// The present moment.
    #[must_use]
    pub fn now(&self) -> Instant {
        self.instant(std::time::Instant::now())
    }

    /// A moment of the standard library as ours; one before the epoch is zero.
    #[must_use]
    pub fn instant(&self, at: std::time::Instant) -> Instant {
        Instant::ZERO.saturating_add(at.saturating_duration_since(self.epoch))
    }

    /// Our moment as one of the standard library; `None` where the platform cannot express it.
    #[must_use]
    pub fn to_std(&self, at: Instant) -> Option<std::time::Instant> {
        self.epoch.checked_add(Duration::from_nanos(at.as_nanos()))
    }

    /// How long to sleep until `at`; zero if that has passed.
    #[must_use]
    pub fn until(&self, at: Instant) -> Duration {
        at.saturating_since(self.now())
    }
}

const NANOS_PER_SECOND: u64 = 1_000_000_000;

#[cfg(test)]
mod tests {
    use super::*;
    use std::format;
    extern crate std;

    #[test]
    fn shows_seconds_and_cuts_to_the_precision() {
        let at = Instant::from_nanos(1_000_250_999);
        assert_eq!(format!("{at}"), "1.000250999");
        assert_eq!(format!("{at:.6}"), "1.000250");
        assert_eq!(format!("{at:.0}"), "1");
    }

    #[test]
    fn differences_say_what_a_negative_one_means() {
        let (early, late) = (Instant::from_millis(1), Instant::from_millis(3));
        assert_eq!(late.checked_since(early), Some(Duration::from_millis(2)));
        assert_eq!(early.checked_since(late), None);
        assert_eq!(early.saturating_since(late), Duration::ZERO);
    }

    #[test]
    fn the_end_of_time_saturates() {
        assert_eq!(Instant::MAX + Duration::from_secs(1), Instant::MAX);
        assert_eq!(Instant::ZERO + Duration::MAX, Instant::MAX);
    }
}
