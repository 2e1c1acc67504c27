//! What a client can set on a connection.

use super::{TimeoutMultiplier, TimerResolution, WatchdogAction};
use crate::code::GeneralStatus;

/// The settable attributes of a connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Settings {
    pub(super) expected_packet_rate: u16,
    pub(super) production_inhibit_time: u16,
    pub(super) watchdog_action: WatchdogAction,
    pub(super) multiplier: TimeoutMultiplier,
}

impl Settings {
    pub(super) const fn new(expected_packet_rate: u16, watchdog_action: WatchdogAction) -> Self {
        Self {
            expected_packet_rate,
            production_inhibit_time: 0,
            watchdog_action,
            multiplier: TimeoutMultiplier(0),
        }
    }

    /// Attribute 9, in ms.
    pub const fn expected_packet_rate(&self) -> u16 {
        self.expected_packet_rate
    }

    /// Attribute 12.
    pub const fn watchdog_action(&self) -> WatchdogAction {
        self.watchdog_action
    }

    /// Attribute 17, in ms.
    pub const fn production_inhibit_time(&self) -> u16 {
        self.production_inhibit_time
    }

    /// Attribute 18.
    pub const fn multiplier(&self) -> TimeoutMultiplier {
        self.multiplier
    }

    /// Sets attribute 17, at most the expected packet rate; 0x09 if it is more, unless that rate is 0.
    pub fn set_production_inhibit_time(&mut self, millis: u16) -> Result<(), GeneralStatus> {
        inhibit_within(millis, self.expected_packet_rate)?;
        self.production_inhibit_time = millis;
        Ok(())
    }

    /// Sets attribute 18; 0x09 for a reserved value.
    pub fn set_multiplier(&mut self, multiplier: TimeoutMultiplier) -> Result<(), GeneralStatus> {
        if multiplier.factor().is_none() {
            return Err(GeneralStatus::INVALID_ATTRIBUTE_VALUE);
        }
        self.multiplier = multiplier;
        Ok(())
    }

    /// Rounds and stores attribute 9, and returns what is used from now on; 0x09 if it does not fit, or is less than the
    /// production inhibit time. What follows from it for the connection is
    /// [`IoCause::PacketRateSet`](super::IoCause::PacketRateSet) or
    /// [`ExplicitCause::PacketRateSet`](super::ExplicitCause::PacketRateSet).
    pub fn set_packet_rate(
        &mut self,
        requested: u16,
        resolution: TimerResolution,
    ) -> Result<u16, GeneralStatus> {
        let used = resolution.round_up(requested).ok_or(GeneralStatus::INVALID_ATTRIBUTE_VALUE)?;
        inhibit_within(self.production_inhibit_time, used)?;
        self.expected_packet_rate = used;
        Ok(used)
    }

    /// Sets attribute 12; 0x09 for an action that is not among those of this kind of connection.
    pub fn set_watchdog_action(
        &mut self,
        action: WatchdogAction,
        allowed: &[WatchdogAction],
    ) -> Result<(), GeneralStatus> {
        if !allowed.contains(&action) {
            return Err(GeneralStatus::INVALID_ATTRIBUTE_VALUE);
        }
        self.watchdog_action = action;
        Ok(())
    }
}

/// A production that is inhibited for longer than the packet rate could never be on time.
const fn inhibit_within(inhibit: u16, packet_rate: u16) -> Result<(), GeneralStatus> {
    if packet_rate != 0 && inhibit > packet_rate {
        return Err(GeneralStatus::INVALID_ATTRIBUTE_VALUE);
    }
    Ok(())
}
