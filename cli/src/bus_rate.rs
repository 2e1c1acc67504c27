//! The bit rate of a bus, as far as it is known.

use core::fmt;
use core::time::Duration;

use link_core::{BitRate, Frame, Instant};

use crate::bus_time;

/// The bit rate of a bus, and whether it is known: the load of the bus depends on it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum BusRate {
    /// That of a scenario or of a controller, or the user has said it.
    Known(BitRate),
    /// The frames do not fit into less, so that a load computed with it is the most that it can be.
    AtLeast(BitRate),
}

impl BusRate {
    /// What a load is computed with.
    pub(crate) const fn rate(self) -> BitRate {
        match self {
            Self::Known(rate) | Self::AtLeast(rate) => rate,
        }
    }

    /// The rate, if it is the real one.
    pub(crate) const fn known(self) -> Option<BitRate> {
        match self {
            Self::Known(rate) => Some(rate),
            Self::AtLeast(_) => None,
        }
    }

    /// For programs.
    pub(crate) const fn source(self) -> &'static str {
        match self {
            Self::Known(_) => "known",
            Self::AtLeast(_) => "least",
        }
    }

    /// What stands before a load: it is no more than the most that it can be.
    pub(crate) const fn at_most(self) -> &'static str {
        match self {
            Self::Known(_) => "",
            Self::AtLeast(_) => "at most ",
        }
    }
}

/// `125 kbit/s`, `125 kbit/s or more`
impl fmt::Display for BusRate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Known(rate) => rate.fmt(f),
            Self::AtLeast(rate) => write!(f, "{rate} or more"),
        }
    }
}

/// Deduces the least bit rate at which a bus can have carried its frames. Frames cannot be closer together than they are long, so
/// every rate of DeviceNet is taken at its word: what it has still to carry when a frame is received must not be more than the
/// time stamps may be late.
#[derive(Clone, Debug)]
pub(crate) struct LeastRate {
    /// Of [`RATES`], how many are too low.
    refuted: usize,
    /// What each has still to carry, as time.
    backlogs: [Duration; RATES.len()],
    /// When that was.
    last: Instant,
}

impl LeastRate {
    /// Of a bus that may have any.
    pub(crate) const fn new() -> Self {
        Self { refuted: 0, backlogs: [Duration::ZERO; RATES.len()], last: Instant::ZERO }
    }

    /// A frame was received.
    pub(crate) fn see(&mut self, at: Instant, frame: &Frame) {
        // A clock that was set back brings no time, and goes on from there.
        let passed = at.saturating_since(core::mem::replace(&mut self.last, at));
        let bits = u64::from(bus_time::bits(frame));
        for (n, (rate, backlog)) in (1..).zip(RATES.iter().zip(&mut self.backlogs)) {
            let length = Duration::from_nanos(bits * rate.bit_time_nanos().unwrap_or_default());
            *backlog = backlog.saturating_sub(passed) + length;
            if *backlog > LATE {
                self.refuted = self.refuted.max(n);
            }
        }
    }

    /// What is deduced so far. Where the highest is too low as well, the time stamps tell nothing.
    pub(crate) fn rate(&self) -> BitRate {
        RATES.get(self.refuted).copied().unwrap_or(RATES[0])
    }
}

/// Those of DeviceNet.
const RATES: [BitRate; 3] = [BitRate::K125, BitRate::K250, BitRate::K500];
/// So late may a time stamp be: adapters hand over several frames at once, and some stamp them only then.
const LATE: Duration = Duration::from_millis(20);

#[cfg(test)]
mod tests {
    use super::*;
    use link_core::frame::standard_id;

    /// What follows from bursts of so many frames, one behind the other at a rate, five times a second; with one stamp for some at once.
    fn deduced(rate: BitRate, frames: u64, at_once: u64) -> BitRate {
        let frame = Frame::new(standard_id(0x3C1), &[0x55; 8]).unwrap();
        let length = u64::from(bus_time::bits(&frame)) * rate.bit_time_nanos().unwrap();
        let mut least = LeastRate::new();
        for burst in 0..20 {
            for n in 0..frames {
                let end = (n / at_once + 1) * at_once;
                least.see(Instant::from_nanos(burst * 200_000_000 + end * length), &frame);
            }
        }
        least.rate()
    }

    #[test]
    fn frames_that_do_not_fit_into_a_rate_refute_it() {
        assert_eq!(deduced(BitRate::K125, 150, 1), BitRate::K125);
        assert_eq!(deduced(BitRate::K250, 150, 1), BitRate::K250);
        assert_eq!(deduced(BitRate::K500, 150, 1), BitRate::K500);
        // Ten frames of 0.9 ms in the stamp of the last.
        assert_eq!(deduced(BitRate::K125, 150, 10), BitRate::K125);
        // A burst of 5 ms would be one of 20 ms at 125 kbit/s, which stamps may hide.
        assert_eq!(deduced(BitRate::K500, 20, 1), BitRate::K125);
    }

    #[test]
    fn stamps_that_no_rate_explains_tell_nothing() {
        let frame = Frame::new(standard_id(0x3C1), &[0; 8]).unwrap();
        let mut least = LeastRate::new();
        (0..1_000).for_each(|_| least.see(Instant::from_millis(1), &frame));
        assert_eq!(least.rate(), BitRate::K125);
    }

    #[test]
    fn a_clock_that_is_set_back_is_no_burst() {
        let frame = Frame::new(standard_id(0x3C1), &[0; 8]).unwrap();
        let mut least = LeastRate::new();
        for n in 0..1_000 {
            least.see(Instant::from_millis(10_000 * (10 - n / 100) + n % 100), &frame);
        }
        assert_eq!(least.rate(), BitRate::K125);
    }
}
