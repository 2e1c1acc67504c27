//! Bit rate detection (paper 3.3): a node learns the rate of the bus before it takes part, and disturbs nothing.
//!
//! The controller is in listen-only mode **\[P\]**. The rest is our decision **\[D\]**:
//!
//! ```text
//!               mode set                       valid frames
//! +-----------+          +-----------+  enough of them  +--------+
//! | Switching |--------->| Listening |----------------->| Locked |
//! +-----------+          +-----------+                  +--------+
//!       ^                      |
//!       +----------------------+  an error, or nothing for the dwell time: the next candidate
//! ```
//!
//! On a silent bus the detector goes round for ever, and a network of detectors alone stays silent. The network manager
//! ends that: it sets the rate and says Hello.
//!
//! **A manager that is alone with detectors** is acknowledged by nobody, for a controller in listen-only mode does not
//! acknowledge. Its error flags spoil what it sends, and the detectors see errors, until after sixteen attempts it is
//! error-passive: from then on its frames look complete to a receiver, and the detectors at the right rate lock.
//!
//! **A controller that samples too slowly is deaf on a busy bus.** Before it takes part it waits for eleven recessive bits of
//! its own length, and at half the rate of the bus there may be no such pause: it sees neither a frame nor an error, and only
//! the dwell time ends that. A controller that samples too fast sees an error at once. So the fastest candidate comes first.
//!
//! [`Detector`] is that machine without a clock: its owner tells it what happens, does as it is told by [`Step`], and keeps
//! the one timer. [`Access`](crate::access::Access) is such an owner.
//!
//! ```
//! use devicenex_core::bit_rate::{Candidates, Detector, Step};
//! use link_core::{BitRate, Mode};
//!
//! let mut detector = Detector::new(Candidates::default(), 2);
//! let listen = |bit_rate| Mode { bit_rate, listen_only: true };
//! assert_eq!(detector.mode(), Some(listen(BitRate::K500)));
//! assert_eq!(detector.mode_set(listen(BitRate::K500)), Step::Listen);
//! assert_eq!(detector.error(), Step::SetMode(listen(BitRate::K250)));
//! assert_eq!(detector.mode_set(listen(BitRate::K250)), Step::Listen);
//! assert_eq!(detector.valid_frame(), Step::Listen);
//! assert_eq!(detector.valid_frame(), Step::Lock(Some(BitRate::K250)));
//! ```

use link_core::{BitRate, Mode};

/// The rates that a detector tries, in their order: one to [`CAPACITY`](Self::CAPACITY). By default 500, 250 and 125
/// kbit/s **\[D\]**.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Candidates {
    rates: heapless::Vec<BitRate, { Candidates::CAPACITY }>,
}

/// Finds the bit rate of a bus; see the [module](self) text.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Detector {
    candidates: Candidates,
    /// The place of the rate that is being tried; `None` if the controller has one of its own.
    place: Option<u8>,
    lock_after: u8,
    stage: Stage,
}

/// How far a [`Detector`] is.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Stage {
    /// The controller has not said yet that it listens at the candidate.
    Switching,
    /// It listens.
    Listening {
        /// In a row.
        valid_frames: u8,
    },
    /// The rate is known.
    Locked,
}

/// What the owner of a [`Detector`] has to do.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[must_use = "the owner has to do it"]
pub enum Step {
    /// Nothing: what was told does not concern the candidate.
    None,
    /// Stop the timer, and set this mode.
    SetMode(Mode),
    /// Start the timer anew; it is over after the dwell time.
    Listen,
    /// Stop the timer: this is the rate; `None` for that of the link, which nobody told.
    Lock(Option<BitRate>),
}

impl Candidates {
    /// The most rates.
    pub const CAPACITY: usize = 4;

    /// These rates; `None` for none, for more than [`CAPACITY`](Self::CAPACITY), and for a rate of zero.
    #[must_use]
    pub fn new(rates: &[BitRate]) -> Option<Self> {
        if rates.is_empty() || rates.contains(&BitRate(0)) {
            return None;
        }
        heapless::Vec::from_slice(rates).ok().map(|rates| Self { rates })
    }

    /// The rates in their order.
    #[must_use]
    pub fn as_slice(&self) -> &[BitRate] {
        &self.rates
    }
}

impl Default for Candidates {
    fn default() -> Self {
        let mut rates = heapless::Vec::new();
        // There is room for four.
        let _ = rates.extend_from_slice(&[BitRate::K500, BitRate::K250, BitRate::K125]);
        Self { rates }
    }
}

impl Detector {
    /// A detector that begins with the first candidate: set its [`mode`](Self::mode). It locks after so many valid frames
    /// in a row; after one if `lock_after` is 0.
    #[must_use]
    pub const fn new(candidates: Candidates, lock_after: u8) -> Self {
        Self { candidates, place: Some(0), lock_after, stage: Stage::Switching }
    }

    /// How far it is.
    #[must_use]
    pub const fn stage(&self) -> Stage {
        self.stage
    }

    /// The rate that is being tried, or was found; `None` for that of the link.
    #[must_use]
    pub fn bit_rate(&self) -> Option<BitRate> {
        self.candidates.rates.get(usize::from(self.place?)).copied()
    }

    /// The mode in which the controller shall be; `None` if it takes none.
    #[must_use]
    pub fn mode(&self) -> Option<Mode> {
        self.bit_rate().map(|bit_rate| Mode { bit_rate, listen_only: true })
    }

    /// The controller takes no mode: from now on frames count at the rate that it has.
    pub fn listen_at_rate_of_link(&mut self) -> Step {
        if self.stage == Stage::Locked {
            return Step::None;
        }
        self.place = None;
        self.stage = Stage::Listening { valid_frames: 0 };
        Step::Listen
    }

    /// The controller is in that mode.
    pub fn mode_set(&mut self, mode: Mode) -> Step {
        if self.stage != Stage::Switching || Some(mode) != self.mode() {
            return Step::None;
        }
        self.stage = Stage::Listening { valid_frames: 0 };
        Step::Listen
    }

    /// A frame was received without an error.
    pub fn valid_frame(&mut self) -> Step {
        let Stage::Listening { valid_frames } = &mut self.stage else { return Step::None };
        *valid_frames = valid_frames.saturating_add(1);
        if *valid_frames < self.lock_after {
            return Step::Listen;
        }
        self.stage = Stage::Locked;
        Step::Lock(self.bit_rate())
    }

    /// The controller saw an error on the bus.
    pub fn error(&mut self) -> Step {
        self.next_candidate()
    }

    /// Nothing was received for the dwell time.
    pub fn dwell_over(&mut self) -> Step {
        self.next_candidate()
    }

    fn next_candidate(&mut self) -> Step {
        let Stage::Listening { valid_frames } = &mut self.stage else { return Step::None };
        *valid_frames = 0;
        let Some(place) = self.place else { return Step::Listen };
        let next = place.saturating_add(1);
        self.place = Some(if usize::from(next) < self.candidates.rates.len() { next } else { 0 });
        self.stage = Stage::Switching;
        self.mode().map_or(Step::None, Step::SetMode)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn listen(bit_rate: BitRate) -> Mode {
        Mode { bit_rate, listen_only: true }
    }

    fn listening() -> Detector {
        let mut detector = Detector::new(Candidates::default(), 2);
        assert_eq!(detector.mode_set(listen(BitRate::K500)), Step::Listen);
        detector
    }

    #[test]
    fn goes_round_for_ever_on_a_silent_bus() {
        let mut detector = listening();
        for rate in [BitRate::K250, BitRate::K125, BitRate::K500].into_iter().cycle().take(300) {
            assert_eq!(detector.dwell_over(), Step::SetMode(listen(rate)));
            assert_eq!(detector.mode_set(listen(rate)), Step::Listen);
        }
    }

    #[test]
    fn an_error_between_two_frames_starts_the_count_anew() {
        let mut detector = listening();
        assert_eq!(detector.valid_frame(), Step::Listen);
        assert_eq!(detector.error(), Step::SetMode(listen(BitRate::K250)));
        assert_eq!(detector.mode_set(listen(BitRate::K250)), Step::Listen);
        assert_eq!(detector.valid_frame(), Step::Listen);
        assert_eq!(detector.stage(), Stage::Listening { valid_frames: 1 });
    }

    #[test]
    fn what_comes_before_the_mode_is_set_belongs_to_the_rate_before() {
        let mut detector = listening();
        assert_eq!(detector.error(), Step::SetMode(listen(BitRate::K250)));
        assert_eq!(detector.error(), Step::None);
        assert_eq!(detector.valid_frame(), Step::None);
        assert_eq!(detector.dwell_over(), Step::None);
        assert_eq!(detector.mode_set(listen(BitRate::K500)), Step::None, "another rate");
        let active = Mode { bit_rate: BitRate::K250, listen_only: false };
        assert_eq!(detector.mode_set(active), Step::None, "it would disturb");
        assert_eq!(detector.stage(), Stage::Switching);
    }

    #[test]
    fn once_locked_it_stays() {
        let mut detector = listening();
        assert_eq!(detector.valid_frame(), Step::Listen);
        assert_eq!(detector.valid_frame(), Step::Lock(Some(BitRate::K500)));
        assert_eq!((detector.error(), detector.dwell_over()), (Step::None, Step::None));
        assert_eq!(detector.mode_set(listen(BitRate::K500)), Step::None);
        assert_eq!(detector.listen_at_rate_of_link(), Step::None);
        assert_eq!((detector.stage(), detector.bit_rate()), (Stage::Locked, Some(BitRate::K500)));
    }

    #[test]
    fn without_a_choice_it_counts_at_the_rate_of_the_link() {
        let mut detector = Detector::new(Candidates::default(), 2);
        assert_eq!(detector.listen_at_rate_of_link(), Step::Listen);
        assert_eq!((detector.valid_frame(), detector.error()), (Step::Listen, Step::Listen));
        assert_eq!((detector.valid_frame(), detector.dwell_over()), (Step::Listen, Step::Listen));
        assert_eq!((detector.valid_frame(), detector.valid_frame()), (Step::Listen, Step::Lock(None)));
    }

    #[test]
    fn candidates_are_one_to_four_rates() {
        assert_eq!(Candidates::new(&[]), None);
        assert_eq!(Candidates::new(&[BitRate(0)]), None);
        assert_eq!(Candidates::new(&[BitRate::M1; 5]), None);
        let one = Candidates::new(&[BitRate::M1]).unwrap();
        assert_eq!(one.as_slice(), [BitRate::M1]);
        let mut detector = Detector::new(one, 1);
        assert_eq!(detector.mode_set(listen(BitRate::M1)), Step::Listen);
        assert_eq!(detector.error(), Step::SetMode(listen(BitRate::M1)), "it tries again");
        let default = [BitRate::K500, BitRate::K250, BitRate::K125];
        assert_eq!(Candidates::default().as_slice(), default);
    }
}
