//! What goes wrong on the way from one station to another.

use std::fmt;
use std::time::Duration;

use link_core::Instant;

use super::station::StationId;
use crate::rng::{Rng, threshold};

/// A frame on its way to one receiver.
#[derive(Clone, Copy, Debug)]
pub struct Passage<'a> {
    /// When its first byte was sent.
    pub start: Instant,
    /// The number of the frame, from 0.
    pub number: u64,
    /// Who sent it; `None` for one that came from outside.
    pub from: Option<StationId>,
    /// Who is to receive it.
    pub to: StationId,
    /// The frame without its CRC.
    pub bytes: &'a [u8],
}

/// What becomes of a frame at one receiver.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Fate {
    /// It arrives.
    Pass,
    /// It does not arrive.
    Lose,
    /// It arrives with a wrong CRC: the adapter tells that, and drops it.
    Corrupt,
    /// It arrives twice.
    Twice,
    /// It arrives later, behind others that were sent after it.
    Late(Duration),
    /// Other bytes arrive, with a right CRC.
    Replace(Vec<u8>),
}

/// Names a fault of one segment.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct FaultId(pub(super) usize);

/// A fault that decides for each frame and receiver.
pub(super) struct Fault(Box<dyn FnMut(&Passage<'_>) -> Fate>);

impl Fault {
    pub(super) fn new(fault: impl FnMut(&Passage<'_>) -> Fate + 'static) -> Self {
        Self(Box::new(fault))
    }

    pub(super) fn judge(&mut self, passage: &Passage<'_>) -> Fate {
        (self.0)(passage)
    }
}

impl fmt::Debug for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Fault")
    }
}

/// A fault that strikes with a probability, by random numbers of its own.
pub fn rate(seed: u64, probability: f64, fate: Fate) -> impl FnMut(&Passage<'_>) -> Fate + 'static {
    let (mut rng, threshold) = (Rng::new(seed, FAULTS), threshold(probability));
    move |_| if rng.chance(threshold) { fate.clone() } else { Fate::Pass }
}

/// A fault that strikes those frames of a kind whose number, from 0, is in a range. A frame counts once for each receiver.
pub fn nth(
    mut is_meant: impl FnMut(&Passage<'_>) -> bool + 'static,
    numbers: std::ops::Range<u64>,
    fate: Fate,
) -> impl FnMut(&Passage<'_>) -> Fate + 'static {
    let mut seen = 0;
    move |passage| {
        if !is_meant(passage) {
            return Fate::Pass;
        }
        seen += 1;
        if numbers.contains(&(seen - 1)) { fate.clone() } else { Fate::Pass }
    }
}

/// The stream of random numbers for faults.
const FAULTS: u64 = 0x0FA0_17ED;
