//! The kernel's time of a frame on the clock of a port.

use core::time::Duration;

use crate::time::{Clock, Instant};

/// Brings the kernel's stamps, which follow the wall clock, to a clock that only goes forward.
///
/// The distance of the two clocks is measured now and then. A stamp that would lie before the last known moment, or further
/// ahead than frames can be told late, says that somebody has set the wall clock: then it is measured again, and the stamp
/// is held between the last known moment and the present. So no jump of the wall clock reaches a machine.
#[derive(Debug)]
pub struct Stamps {
    clock: Clock,
    /// What the wall clock, since 1970, is ahead of ours.
    ahead: Duration,
    /// When that was measured.
    measured: Instant,
    /// The latest moment that was told or asked for.
    last: Instant,
}

impl Stamps {
    /// The clock starts now.
    #[must_use]
    pub fn start() -> Self {
        let clock = Clock::start();
        Self { clock, ahead: wall(), measured: Instant::ZERO, last: Instant::ZERO }
    }

    /// The latest moment that is known: the present, but for the work since.
    #[must_use]
    pub const fn last(&self) -> Instant {
        self.last
    }

    /// The present moment.
    pub fn now(&mut self) -> Instant {
        self.last = self.present();
        self.last
    }

    /// The present moment, without holding what waits with an earlier stamp to it.
    #[must_use]
    pub fn present(&self) -> Instant {
        self.last.max(self.clock.now())
    }

    /// The moment of a stamp, since 1970.
    pub fn moment(&mut self, stamp: Duration) -> Instant {
        if let Some(at) = self.on_our_clock(stamp).filter(|at| self.is_trusted(*at)) {
            self.last = at;
            return at;
        }
        let earliest = self.last;
        let now = self.now();
        self.measured = now;
        self.ahead = wall().saturating_sub(now.saturating_since(Instant::ZERO));
        let at = self.on_our_clock(stamp).unwrap_or(now);
        // The present was asked for only to hold the stamp to it: frames behind this one are earlier.
        self.last = at.clamp(earliest, now);
        self.last
    }

    fn is_trusted(&self, at: Instant) -> bool {
        at >= self.last
            && at.saturating_since(self.last) <= TRUSTED
            && at.saturating_since(self.measured) <= MEASURE_AFTER
    }

    fn on_our_clock(&self, stamp: Duration) -> Option<Instant> {
        Some(Instant::ZERO.saturating_add(stamp.checked_sub(self.ahead)?))
    }
}

/// The wall clock since 1970.
fn wall() -> Duration {
    std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default()
}

/// A stamp within this of the last known moment is taken without asking for the present. A wall clock that was set by less
/// goes unnoticed, until the next measurement.
const TRUSTED: Duration = Duration::from_millis(10);
/// How long a measurement holds: so far ahead does a wall clock get that is set again and again.
const MEASURE_AFTER: Duration = Duration::from_millis(100);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stamp_of_now_is_now() {
        let mut stamps = Stamps::start();
        let before = stamps.now();
        let at = stamps.moment(wall());
        let after = stamps.now();
        assert!(before <= at && at <= after, "{before} {at} {after}");
    }

    #[test]
    fn a_frame_that_waits_keeps_its_stamp_while_another_is_sent() {
        let mut stamps = Stamps::start();
        while stamps.present() < Instant::from_millis(1) {
            std::hint::spin_loop();
        }
        let (begin, waiting) = (stamps.present(), wall());
        while stamps.present() < begin + Duration::from_millis(1) {
            std::hint::spin_loop();
        }
        let sent = stamps.present();
        assert!(stamps.moment(waiting) < sent);
    }

    #[test]
    fn a_wall_clock_that_was_set_reaches_nobody() {
        let mut stamps = Stamps::start();
        for jump in [Duration::from_secs(3600), Duration::from_millis(100)] {
            let before = stamps.now();
            let (early, late) = (stamps.moment(wall().saturating_sub(jump)), stamps.moment(wall() + jump));
            let after = stamps.now();
            assert!(before <= early && early <= late && late <= after, "{before} {early} {late} {after}");
        }
    }

    #[test]
    fn nor_does_one_that_is_set_by_little_again_and_again() {
        let mut stamps = Stamps::start();
        let begin = std::time::Instant::now();
        for step in 0..500 {
            stamps.moment(wall() + Duration::from_millis(9) * step);
        }
        let ahead = stamps.last().saturating_since(Instant::ZERO).saturating_sub(begin.elapsed());
        assert!(ahead <= MEASURE_AFTER + TRUSTED, "{ahead:?}");
    }
}
