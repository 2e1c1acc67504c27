//! The bit rate of a bus, as far as it is known.

use core::fmt;
use core::time::Duration;

use link_core::{BitRate, Frame, Instant};

use crate::bus_time;
use crate::exit::Failure;
use crate::output;

/// The bit rate of a bus, and whether it is known: the load of the bus depends on it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum BusRate {
    /// That of a scenario or of a controller.
    Known(BitRate),
    /// The user has said it, and nothing refutes it.
    Said(BitRate),
    /// The frames do not fit into less, so that a load of theirs computed with it is the most that it can be.
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

    /// What a load that is computed with it is of the real one, in a time with errors or without: of their length only the least is known.
    pub(crate) const fn bound(self, has_errors: bool) -> Bound {
        match (self, has_errors) {
            (Self::Known(_) | Self::Said(_), _) => Bound::Exact,
            (Self::AtLeast(_), false) => Bound::AtMost,
            (Self::AtLeast(_), true) => Bound::About,
        }
    }
}

/// What a load is of the real one.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Bound {
    Exact,
    AtMost,
    About,
}

impl Bound {
    /// Before the load.
    pub(crate) const fn words(self) -> &'static str {
        match self {
            Self::Exact => "",
            Self::AtMost => "at most ",
            Self::About => "about ",
        }
    }

    /// The same where there is little room.
    pub(crate) const fn sign(self) -> &'static str {
        match self {
            Self::Exact => "",
            Self::AtMost => "≤",
            Self::About => "≈",
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

/// What the frames of a bus make of the bit rate that the user has said.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Doubt {
    /// Once there were too many for it, and not by far: their time stamps may have been late.
    Once,
    /// It cannot be: they need so much at least.
    TooLow(BitRate),
}

impl Doubt {
    /// `--bit-rate is too low: ..`
    pub(crate) fn why(self, said: BitRate, bus: &str) -> String {
        match self {
            Self::Once => format!(
                "--bit-rate is in doubt: once, the frames of {bus} came closer together than {said} can carry; unless their time \
                 stamps were late it is too low, so it counts as not known"
            ),
            Self::TooLow(needed) => format!(
                "--bit-rate is too low: {said} cannot carry the frames of {bus}, which need {needed} at least"
            ),
        }
    }

    /// Tells of it where a recording is read.
    ///
    /// # Errors
    /// The recording cannot have come at that bit rate.
    pub(crate) fn tell(self, file: &str, said: BitRate, bus: &str) -> Result<(), Failure> {
        let why = format!("{file}: {}", self.why(said, bus));
        match self {
            Self::Once => {
                output::warn(why);
                Ok(())
            }
            Self::TooLow(_) => Err(Failure::Usage(why)),
        }
    }
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
    /// It is more than there can be, and has been since the bus was idle.
    is_too_much: bool,
    /// How often it was.
    episodes: u32,
    /// It was so much that no time stamp explains it.
    is_far_too_much: bool,
}

impl Backlog {
    const fn new(rate: BitRate) -> Self {
        Self { rate, waits: Duration::ZERO, is_too_much: false, episodes: 0, is_far_too_much: false }
    }

    fn see(&mut self, passed: Duration, bits: u64) {
        let length = Duration::from_nanos(bits * 1_000_000_000 / u64::from(self.rate.0.max(1)));
        let waited = self.waits.saturating_sub(passed);
        self.waits = waited + length;
        self.is_too_much &= !waited.is_zero();
        if self.waits > LATE && !core::mem::replace(&mut self.is_too_much, true) {
            self.episodes = self.episodes.saturating_add(1);
        }
        self.is_far_too_much |= self.waits > FAR_TOO_LATE;
    }

    /// It was more than there can be, at least once.
    const fn is_refuted(&self) -> bool {
        self.episodes > 0
    }

    /// The same, and a late time stamp is not the reason.
    const fn is_certain(&self) -> bool {
        self.episodes > 1 || self.is_far_too_much
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

    /// The rate that somebody has said, and what there is against it.
    pub(crate) fn doubt(&self) -> Option<(BitRate, Doubt)> {
        let said = self.said.as_ref().filter(|said| said.is_refuted())?;
        let needed = self.fitting()?;
        Some((said.rate, if said.is_certain() { Doubt::TooLow(needed) } else { Doubt::Once }))
    }

    /// The lowest that is not refuted.
    fn fitting(&self) -> Option<BitRate> {
        // A rate is refuted by what refutes a higher one.
        let refuted = self.backlogs.iter().rposition(Backlog::is_refuted);
        RATES.get(refuted.map_or(0, |place| place + 1)).copied()
    }
}

/// Those of DeviceNet.
const RATES: [BitRate; 3] = [BitRate::K125, BitRate::K250, BitRate::K500];
/// So late may a time stamp be: adapters hand over several frames at once, and some stamp them only then.
const LATE: Duration = Duration::from_millis(20);
/// So late is none.
const FAR_TOO_LATE: Duration = Duration::from_millis(100);

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

    /// All the time at 250 kbit/s.
    #[test]
    fn a_rate_that_somebody_has_said_is_refuted_by_frames_that_do_not_fit() {
        let frame = Frame::new(standard_id(0x3C1), &[0x55; 8]).unwrap();
        let length = u64::from(bus_time::bits(&frame)) * 4_000;
        for (said, is_too_low) in
            [(100_000, true), (125_000, true), (200_000, true), (245_000, false), (250_000, false)]
        {
            let said = BitRate(said);
            let mut least = LeastRate::new(Some(said));
            assert_eq!(least.doubt(), None);
            for n in 0..1_000 {
                least.see(Instant::from_nanos(n * length), &frame);
            }
            assert_eq!(least.doubt(), is_too_low.then_some((said, Doubt::TooLow(BitRate::K250))));
        }
        // Where no rate fits, the stamps are to blame.
        let mut least = LeastRate::new(Some(BitRate::K125));
        (0..1_000).for_each(|_| least.see(Instant::from_millis(1), &frame));
        assert_eq!(least.doubt(), None);
    }

    /// A frame of 0.9 ms every 2 ms, and an adapter that tells some of them late, all at once.
    #[test]
    fn a_time_stamp_that_is_late_once_refutes_nothing() {
        let frame = Frame::new(standard_id(0x3C1), &[0x55; 8]).unwrap();
        let of_stalls: [(&[u64], u64, Option<Doubt>); 4] = [
            (&[], 60, None),
            (&[1_000], 40, None),
            (&[1_000], 60, Some(Doubt::Once)),
            (&[1_000, 3_000], 60, Some(Doubt::TooLow(BitRate::K250))),
        ];
        for (stalls, length, doubt) in of_stalls {
            let mut least = LeastRate::new(Some(BitRate::K125));
            for due in (0..5_000).step_by(2) {
                let stall = stalls.iter().find(|&&begin| (begin..begin + length).contains(&due));
                let stamp = stall.map_or(due, |begin| begin + length);
                least.see(Instant::from_millis(stamp), &frame);
            }
            assert_eq!(least.doubt(), doubt.map(|doubt| (BitRate::K125, doubt)), "{stalls:?} {length}");
        }
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
