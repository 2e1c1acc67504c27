//! The network status indicator.

use core::fmt;

/// What the network status (NS) indicator of a device shows. Flashing is 0.5 s on and 0.5 s off; flashing red and green
/// is 0.5 s of each.
///
/// | Condition, the first that holds | NS |
/// |---|---|
/// | no power, or no network power | off |
/// | duplicate MAC ID check not completed | off |
/// | communication fault, and an Identify request was accepted | flashing red and green |
/// | communication fault: duplicate MAC ID, or bus-off | red |
/// | on line, an I/O connection timed out | flashing red |
/// | on line, allocated to a master, or a connection established | green |
/// | on line, nothing allocated | flashing green |
///
/// Sources: Rockwell 1734-ADN and 1756-DNB manuals; Buerkert 8681 manual; HMS Anybus indicator table.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum NetworkStatus {
    /// Dark.
    Off,
    /// Flashing green, 1 Hz.
    FlashingGreen,
    /// Green.
    SolidGreen,
    /// Flashing red, 1 Hz.
    FlashingRed,
    /// Red.
    SolidRed,
    /// Red and green in turn, 1 Hz.
    FlashingRedGreen,
}

impl fmt::Display for NetworkStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Off => "off",
            Self::FlashingGreen => "flashing green",
            Self::SolidGreen => "green",
            Self::FlashingRed => "flashing red",
            Self::SolidRed => "red",
            Self::FlashingRedGreen => "flashing red and green",
        })
    }
}
