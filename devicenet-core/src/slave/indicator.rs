//! The indicators.

use core::fmt;

use cip_core::identity::{DeviceState, IdentityStatus};

use crate::access::NetworkStatus;

/// What the module status (MS) indicator shows.
///
/// | MS | Condition | Identity state |
/// |---|---|---|
/// | flashing red and green | self test | 1 |
/// | flashing green | standby, needs configuration | 2 |
/// | green | normal operation | 3 |
/// | flashing red | recoverable fault, minor or major | 3 or 4 |
/// | red | unrecoverable fault | 5 |
/// | off | no power | 0 |
///
/// Sources: Rockwell 1784-PCIDS and 1734-ADN manuals.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum ModuleStatus {
    /// Dark.
    Off,
    /// Flashing red and green.
    FlashingRedGreen,
    /// Flashing green.
    FlashingGreen,
    /// Green.
    SolidGreen,
    /// Flashing red.
    FlashingRed,
    /// Red.
    SolidRed,
}

/// What a combined module and network status (MNS) indicator shows.
///
/// | MNS | Meaning |
/// |---|---|
/// | off | not powered, or not on line |
/// | flashing green | on line, not allocated |
/// | green | on line, allocated |
/// | flashing red | recoverable fault, or an I/O connection timed out |
/// | red | unrecoverable fault, duplicate MAC ID, or bus-off |
/// | flashing red and green | self test, or a faulted node that was asked to identify itself |
///
/// Sources: Rockwell 1756-DNB and Hilscher manuals; Buerkert 8681 manual.
#[must_use]
pub const fn combined_status(module: ModuleStatus, network: NetworkStatus) -> NetworkStatus {
    match (module, network) {
        (ModuleStatus::SolidRed, _) | (_, NetworkStatus::SolidRed) => NetworkStatus::SolidRed,
        (ModuleStatus::FlashingRedGreen, _) | (_, NetworkStatus::FlashingRedGreen) => {
            NetworkStatus::FlashingRedGreen
        }
        (ModuleStatus::FlashingRed, _) | (_, NetworkStatus::FlashingRed) => NetworkStatus::FlashingRed,
        (ModuleStatus::Off, _) => NetworkStatus::Off,
        (ModuleStatus::SolidGreen | ModuleStatus::FlashingGreen, _) => network,
    }
}

impl ModuleStatus {
    /// What follows from attributes 5 and 8 of the Identity object.
    #[must_use]
    pub fn of(state: DeviceState, status: IdentityStatus) -> Self {
        let unrecoverable =
            IdentityStatus::MINOR_UNRECOVERABLE_FAULT.union(IdentityStatus::MAJOR_UNRECOVERABLE_FAULT);
        let recoverable =
            IdentityStatus::MINOR_RECOVERABLE_FAULT.union(IdentityStatus::MAJOR_RECOVERABLE_FAULT);
        match state {
            DeviceState::MAJOR_UNRECOVERABLE_FAULT => Self::SolidRed,
            _ if status.intersects(unrecoverable) => Self::SolidRed,
            DeviceState::MAJOR_RECOVERABLE_FAULT => Self::FlashingRed,
            _ if status.intersects(recoverable) => Self::FlashingRed,
            DeviceState::NONEXISTENT => Self::Off,
            DeviceState::SELF_TESTING => Self::FlashingRedGreen,
            DeviceState::STANDBY => Self::FlashingGreen,
            _ => Self::SolidGreen,
        }
    }
}

impl fmt::Display for ModuleStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Off => "off",
            Self::FlashingRedGreen => "flashing red and green",
            Self::FlashingGreen => "flashing green",
            Self::SolidGreen => "green",
            Self::FlashingRed => "flashing red",
            Self::SolidRed => "red",
        })
    }
}
