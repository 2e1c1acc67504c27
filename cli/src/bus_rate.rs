//! The bit rate of a bus, as far as it is known.

use core::fmt;
use core::time::Duration;

use link_core::{BitRate, Frame, Instant};

use crate::bus_time;
use crate::exit::Failure;

/// The bit rate of a bus, and whether it is known: the load of the bus depends on it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum BusRate {
    /// That of a scenario or of a controller.
    Known(BitRate),
    /// The user has said it, and nothing refutes it.
    Said(BitRate),
    /// The frames do not fit into less, so that a load computed with it is the most that it can be.
    AtLeast(BitRate),
}

impl BusRate {
    /// What a load is computed with.
    pub(crate) const fn rate(self) -> BitRate {
        match self {
            Self::Known(rate) | Self::Said(rate) | Self::AtLeast(rate) => rate,
        }
    }

    /// The rate, if it is the real one.
    pub(crate) const fn known(self) -> Option<BitRate> {
        match self {
            Self::Known(rate) | Self::Said(rate) => Some(rate),
            Self::AtLeast(_) => None,
        }
    }

    /// The rate, if only the user knows it.
    pub(crate) const fn said(self) -> Option<BitRate> {
        match self {
            Self::Said(rate) => Some(rate),
            Self::Known(_) | Self::AtLeast(_) => None,
        }
    }

    /// For programs.
    pub(crate) const fn source(self) -> &'static str {
        match self {
            Self::Known(_) | Self::Said(_) => "known",
            Self::AtLeast(_) => "least",
        }
    }

    /// What stands before a load: it is no more than the most that it can be.
    pub(crate) const fn at_most(self) -> &'static str {
        match self {
            Self::Known(_) | Self::Said(_) => "",
            Self::AtLeast(_) => "at most ",
        }
    }
}

/// `125 kbit/s`, `125 kbit/s or more`
impl fmt::Display for BusRate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Known(rate) | Self::Said(rate) => rate.fmt(f),
            Self::AtLeast(rate) => write!(f, "{rate} or more"),
        }
    }
}

/// The frames of a bus do not fit into the bit rate that the user has said.
pub(crate) fn too_low(file: &str, said: BitRate, bus: &str, needed: BitRate) -> Failure {
    Failure::Usage(format!("{file}: {}", why_too_low(said, bus, needed)))
}

/// `--bit-rate is too low: ..`
pub(crate) fn why_too_low(said: BitRate, bus: &str, needed: BitRate) -> String {
    format!("--bit-rate is too low: {said} cannot carry the frames of {bus}, which need {needed} at least")
}

/// Deduces the least bit rate at which a bus can have carried its frames, and whether one that somebody has said is enough. Frames
/// cannot be closer together than they are long, so every rate of DeviceNet is taken at its word: what it has still to carry when a
/// frame is received must not be more than the time stamps may be late.
#[derive(Clone, Debug)]
pub(crate) struct LeastRate {
    /// By rate.
    backlogs: [Backlog; RATES.len()],
    /// Of the rate that somebody has said.
    said: Option<Backlog>,
    /// When the last frame was.
    last: Instant,
}

/// What a bus of a rate has still to carry.
#[derive(Clone, Copy, Debug)]
struct Backlog {
    rate: BitRate,
    /// As time.
    waits: Duration,
    /// It was more than there can be.
    is_refuted: bool,
}

impl Backlog {
    const fn new(rate: BitRate) -> Self {
        Self { rate, waits: Duration::ZERO, is_refuted: false }
    }

    fn see(&mut self, passed: Duration, bits: u64) {
        let length = Duration::from_nanos(bits * 1_000_000_000 / u64::from(self.rate.0.max(1)));
        self.waits = self.waits.saturating_sub(passed) + length;
        self.is_refuted |= self.waits > LATE;
    }
}

impl LeastRate {
    /// Of a bus that may have any, or the one that somebody has said.
    pub(crate) const fn new(said: Option<BitRate>) -> Self {
        let [a, b, c] = RATES;
        let said = match said {
            Some(rate) => Some(Backlog::new(rate)),
            None => None,
        };
        Self { backlogs: [Backlog::new(a), Backlog::new(b), Backlog::new(c)], said, last: Instant::ZERO }
    }

    /// A frame was received.
    pub(crate) fn see(&mut self, at: Instant, frame: &Frame) {
        // A clock that was set back brings no time, and goes on from there.
        let passed = at.saturating_since(core::mem::replace(&mut self.last, at));
        let bits = u64::from(bus_time::bits(frame));
        self.backlogs.iter_mut().chain(&mut self.said).for_each(|backlog| backlog.see(passed, bits));
    }

    /// What is deduced so far. Where the highest is too low as well, the time stamps tell nothing.
    pub(crate) fn rate(&self) -> BitRate {
        self.fitting().unwrap_or(RATES[0])
    }

    /// The rate that is needed at least, if the one that somebody has said is too low.
    pub(crate) fn needed(&self) -> Option<BitRate> {
        self.said.filter(|said| said.is_refuted)?;
        self.fitting()
    }

    /// The lowest that is not refuted.
    fn fitting(&self) -> Option<BitRate> {
        // A rate is refuted by what refutes a higher one.
        let refuted = self.backlogs.iter().rposition(|backlog| backlog.is_refuted);
        RATES.get(refuted.map_or(0, |place| place + 1)).copied()
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
        let mut least = LeastRate::new(None);
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

    /// Bursts at 250 kbit/s.
    #[test]
    fn a_rate_that_somebody_has_said_is_refuted_by_frames_that_do_not_fit() {
        let frame = Frame::new(standard_id(0x3C1), &[0x55; 8]).unwrap();
        let length = u64::from(bus_time::bits(&frame)) * 4_000;
        for (said, needed) in
            [(100_000, true), (125_000, true), (200_000, true), (245_000, false), (250_000, false)]
        {
            let mut least = LeastRate::new(Some(BitRate(said)));
            assert_eq!(least.needed(), None);
            for n in 0..300 {
                least.see(Instant::from_nanos(n * length), &frame);
            }
            assert_eq!(least.needed(), needed.then_some(BitRate::K250), "{said}");
        }
        // Where no rate fits, the stamps are to blame.
        let mut least = LeastRate::new(Some(BitRate::K125));
        (0..1_000).for_each(|_| least.see(Instant::from_millis(1), &frame));
        assert_eq!(least.needed(), None);
    }

    #[test]
    fn stamps_that_no_rate_explains_tell_nothing() {
        let frame = Frame::new(standard_id(0x3C1), &[0; 8]).unwrap();
        let mut least = LeastRate::new(None);
        (0..1_000).for_each(|_| least.see(Instant::from_millis(1), &frame));
        assert_eq!(least.rate(), BitRate::K125);
    }

    #[test]
    fn a_clock_that_is_set_back_is_no_burst() {
        let frame = Frame::new(standard_id(0x3C1), &[0; 8]).unwrap();
        let mut least = LeastRate::new(None);
        for n in 0..1_000 {
            least.see(Instant::from_millis(10_000 * (10 - n / 100) + n % 100), &frame);
        }
        assert_eq!(least.rate(), BitRate::K125);
    }
}
