//! The bit rate as the DeviceNet object knows it, and its automatic detection.

use link_core::BitRate;

/// The bit rate of a node.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BitRateConfig {
    /// The rate at start: from non-volatile memory, or from the switches.
    pub rate: BitRate,
    /// Switches set it: it cannot be set over the network. Default: no.
    pub from_switches: bool,
    /// Listen for the rate that is in use before anything else; [`rate`](Self::rate) is what is tried first. Default: no.
    pub detect: bool,
}

impl BitRateConfig {
    /// A rate that can be set over the network.
    #[must_use]
    pub const fn new(rate: BitRate) -> Self {
        Self { rate, from_switches: false, detect: false }
    }
}

/// The three rates of DeviceNet, in the order of their numbers in attribute 2 of the DeviceNet object.
///
/// | Number | Rate |
/// |---|---|
/// | 0 | 125 kbit/s |
/// | 1 | 250 kbit/s |
/// | 2 | 500 kbit/s |
pub const BIT_RATES: [BitRate; 3] = [BitRate::K125, BitRate::K250, BitRate::K500];

pub(super) fn number(rate: BitRate) -> u8 {
    match rate {
        BitRate::K250 => 1,
        BitRate::K500 => 2,
        _ => 0,
    }
}

/// The rate after `rate` in the round of the detection.
pub(super) fn next(rate: BitRate) -> BitRate {
    match rate {
        BitRate::K125 => BitRate::K250,
        BitRate::K250 => BitRate::K500,
        _ => BitRate::K125,
    }
}
