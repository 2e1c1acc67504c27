//! The cycle: when SoCs come, and which do not.

use core::time::Duration;

use link_core::Instant;

use super::{Problem, Reading};
use crate::wire::Soc;

/// The cycle as it was seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Cycle {
    /// SoCs.
    pub socs: u64,
    /// Those that did not come.
    pub missing: u64,
    /// Intervals between two SoCs that followed one another.
    pub intervals: u64,
    /// The shortest interval.
    pub min: Duration,
    /// The longest interval.
    pub max: Duration,
    sum: Duration,
    /// The last SoC of this run of the cycle: when, and its RelativeTime.
    last: Option<(Instant, u64)>,
    /// By how much RelativeTime grows, µs.
    period: Option<u64>,
}

impl Cycle {
    pub(super) const fn new() -> Self {
        Self {
            socs: 0,
            missing: 0,
            intervals: 0,
            min: Duration::ZERO,
            max: Duration::ZERO,
            sum: Duration::ZERO,
            last: None,
            period: None,
        }
    }

    /// The mean interval; `None` before there are two SoCs.
    #[must_use]
    pub fn mean(&self) -> Option<Duration> {
        let nanos = self.sum.as_nanos().checked_div(u128::from(self.intervals))?;
        u64::try_from(nanos).ok().map(Duration::from_nanos)
    }

    /// The most that an interval was away from the mean.
    #[must_use]
    pub fn jitter(&self) -> Option<Duration> {
        let mean = self.mean()?;
        Some(self.max.saturating_sub(mean).max(mean.saturating_sub(self.min)))
    }

    /// What the managing node says that the cycle is, by the time in its SoCs.
    #[must_use]
    pub fn nominal(&self) -> Option<Duration> {
        self.period.map(Duration::from_micros)
    }

    /// The managing node has left the cycle.
    pub(super) const fn pause(&mut self) {
        self.last = None;
    }

    /// A SoC whose time was not captured.
    pub(super) const fn count_cut(&mut self) {
        self.socs = self.socs.saturating_add(1);
        self.pause();
    }

    pub(super) fn observe(&mut self, reading: &mut Reading<'_>, soc: &Soc) {
        self.socs = self.socs.saturating_add(1);
        let Some((before, relative)) = self.last.replace((reading.at, soc.relative_time)) else { return };
        let interval = reading.at.checked_since(before);
        let missing = match soc.relative_time.checked_sub(relative) {
            Some(0) => interval.map_or(0, |interval| self.missing_by_interval(interval)),
            Some(grown) => self.missing_by_relative_time(grown),
            // The managing node has started again.
            None => {
                self.period = None;
                return;
            }
        };
        if missing > 0 {
            self.missing = self.missing.saturating_add(missing);
            reading.flag(Problem::SocMissing { count: missing });
            return;
        }
        // A clock that was set back has measured nothing.
        let Some(interval) = interval else { return };
        reading.interval = Some(interval);
        self.min = if self.intervals == 0 { interval } else { self.min.min(interval) };
        self.max = self.max.max(interval);
        self.sum = self.sum.saturating_add(interval);
        self.intervals = self.intervals.saturating_add(1);
    }

    fn missing_by_relative_time(&mut self, grown: u64) -> u64 {
        let cycles = self.period.filter(|&period| grown.checked_rem(period) == Some(0));
        match cycles.and_then(|period| grown.checked_div(period)) {
            Some(cycles) => cycles.saturating_sub(1),
            // The first two SoCs, or another cycle length.
            None => {
                self.period = Some(grown);
                0
            }
        }
    }

    /// For a managing node that does not tell the time.
    fn missing_by_interval(&self, interval: Duration) -> u64 {
        let Some(mean) = self.mean().filter(|_| self.intervals >= SETTLED) else { return 0 };
        let halves = interval.as_nanos().saturating_mul(2).checked_div(mean.as_nanos()).unwrap_or(0);
        // Rounded: one and a half cycles are two.
        let cycles = halves.saturating_add(1) / 2;
        u64::try_from(cycles).unwrap_or(u64::MAX).saturating_sub(1)
    }
}

/// Intervals after which their mean is taken for the cycle.
const SETTLED: u64 = 8;
