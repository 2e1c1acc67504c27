//! How long a connection waits.
//!
//! | Timer | Used by | Value | Started |
//! |---|---|---|---|
//! | inactivity, explicit | servers and clients | T | when established, and by every message received |
//! | inactivity, I/O, before the first message | consumers | 10 s, or T if that is longer | when the connection becomes established |
//! | inactivity, I/O | consumers | T | by every message consumed, by Reset, by setting the EPR again |
//! | transmission trigger | change of state and cyclic producers | EPR | when established, and by every production |
//! | production inhibit | change of state producers | attribute 17 | by every production |
//!
//! T is the expected packet rate (EPR) times 4, or what attribute 18 says. With an EPR of 0 none of these timers runs but
//! the production inhibit. Source: CIP Vol. 1 and 3, Connection object.

use core::num::NonZeroU16;

use link_core::timers::TimerSet;

use super::TimeoutMultiplier;

/// What is to be done with the inactivity timer (watchdog) of a connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[must_use = "a watchdog that nobody starts never expires"]
pub enum Watchdog {
    /// Nothing.
    Keep,
    /// Let it run no longer.
    Stop,
    /// Start it anew, for T; with a rate of 0 it does not run.
    Start,
    /// Start it for the first message: for T, but at least 10 s.
    StartFirst,
}

impl Watchdog {
    /// Does with a timer what it says, for a connection with this expected packet rate and multiplier.
    #[inline]
    pub fn apply<K>(
        self,
        timers: &mut impl TimerSet<K>,
        timer: K,
        expected_packet_rate: u16,
        multiplier: TimeoutMultiplier,
    ) {
        match self.millis(expected_packet_rate, multiplier) {
            Some(millis) => timers.set_after_millis(timer, millis),
            None if self != Self::Keep => timers.clear(timer),
            None => {}
        }
    }

    /// When it expires, from now on, under the expected packet rate and the multiplier of the connection; `None`: it does not run.
    /// `None` for [`Keep`](Self::Keep) too, which leaves the timer as it is.
    #[inline]
    pub const fn millis(self, expected_packet_rate: u16, multiplier: TimeoutMultiplier) -> Option<u32> {
        match self {
            Self::Keep | Self::Stop => None,
            Self::Start => time_out(expected_packet_rate, multiplier),
            Self::StartFirst => first_time_out(expected_packet_rate, multiplier),
        }
    }
}

/// The steps in which a device measures the expected packet rate, in milliseconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(transparent))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TimerResolution(NonZeroU16);

impl TimerResolution {
    /// 10 ms, the most common one.
    pub const DEFAULT: Self = Self::new(10).unwrap();

    /// 1 ms, with which no rate is rounded.
    pub const FINEST: Self = Self(NonZeroU16::MIN);

    /// A resolution of so many milliseconds; `None` for 0. Products have 2, 8, 10, 50 and 100 ms.
    pub const fn new(millis: u16) -> Option<Self> {
        match NonZeroU16::new(millis) {
            Some(millis) => Some(Self(millis)),
            None => None,
        }
    }

    /// In milliseconds.
    pub const fn millis(self) -> u16 {
        self.0.get()
    }

    /// The rate that the device uses when it is asked for `requested` milliseconds: the next multiple, 0 for 0; `None` if
    /// that does not fit into 16 bits.
    pub const fn round_up(self, requested: u16) -> Option<u16> {
        // Where it is constant, that leaves no code for the rest; from the loop the compiler would not find out.
        if self.millis() == 1 {
            return Some(requested);
        }
        match remainder(requested, self.millis()) {
            0 => Some(requested),
            rest => requested.checked_add(self.millis().saturating_sub(rest)),
        }
    }
}

impl Default for TimerResolution {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// T: how long a connection waits for a message, in milliseconds; `None`, for ever, if the rate is 0.
///
/// A reserved multiplier counts as the default.
pub const fn time_out(expected_packet_rate: u16, multiplier: TimeoutMultiplier) -> Option<u32> {
    if expected_packet_rate == 0 {
        return None;
    }
    let factor = match multiplier.factor() {
        Some(factor) => factor,
        None => 4,
    };
    Some(widening_mul(expected_packet_rate, factor))
}

/// How long an I/O connection waits for the first message: T, but at least 10 s; `None`, for ever, if the rate is 0.
pub const fn first_time_out(expected_packet_rate: u16, multiplier: TimeoutMultiplier) -> Option<u32> {
    match time_out(expected_packet_rate, multiplier) {
        Some(millis) if millis < FIRST_TIME_OUT_MILLIS => Some(FIRST_TIME_OUT_MILLIS),
        other => other,
    }
}

/// 10 s: the least time for the first message of an I/O connection ("pre-consumption").
pub const FIRST_TIME_OUT_MILLIS: u32 = 10_000;

/// By shifts, for a processor without a divider: it would be the only division of a small slave, and its routine larger
/// than any function here.
const fn remainder(number: u16, divisor: u16) -> u16 {
    let mut rest = number;
    let mut multiple = divisor.wrapping_shl(divisor.leading_zeros());
    loop {
        if rest >= multiple {
            rest = rest.saturating_sub(multiple);
        }
        if multiple == divisor {
            return rest;
        }
        multiple >>= 1;
    }
}

const fn widening_mul(a: u16, b: u16) -> u32 {
    let ([a0, a1], [b0, b1]) = (a.to_le_bytes(), b.to_le_bytes());
    u32::from_le_bytes([a0, a1, 0, 0]).saturating_mul(u32::from_le_bytes([b0, b1, 0, 0]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 3594 becomes 3600 with 10 ms: Konvolucio.DeviceNet unit-test logs.
    #[test]
    fn rates_are_rounded_up() {
        let round = |millis| TimerResolution::DEFAULT.round_up(millis);
        assert_eq!([0, 1, 10, 75, 3594].map(round), [0, 10, 10, 80, 3600].map(Some));
        assert_eq!([65_530, 65_531, 65_535].map(round), [Some(65_530), None, None]);
        assert_eq!(TimerResolution::new(1).and_then(|step| step.round_up(65_535)), Some(65_535));
        assert_eq!(TimerResolution::new(0), None);
    }

    proptest::proptest! {
        #[test]
        fn remainders_are_those_of_a_division(number: u16, divisor in 1..=u16::MAX, small in 1..=200_u16) {
            proptest::prop_assert_eq!(Some(remainder(number, divisor)), number.checked_rem(divisor));
            proptest::prop_assert_eq!(Some(remainder(number, small)), number.checked_rem(small));
        }
    }

    #[test]
    fn time_outs() {
        let multiplier = TimeoutMultiplier::default();
        assert_eq!(time_out(2500, multiplier), Some(10_000));
        assert_eq!(time_out(80, multiplier), Some(320));
        assert_eq!(time_out(0, multiplier), None);
        assert_eq!(time_out(65_530, TimeoutMultiplier(7)), Some(33_551_360));
        assert_eq!(time_out(10, TimeoutMultiplier(200)), Some(40));
        assert_eq!(first_time_out(80, multiplier), Some(10_000));
        assert_eq!(first_time_out(2510, multiplier), Some(10_040));
        assert_eq!(first_time_out(0, multiplier), None);
    }
}
