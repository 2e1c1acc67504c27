//! What the application can ask, and tell.

use core::time::Duration;

use link_core::Instant;

use super::config::{Config, CounterSetMode, MacIdSource};
use super::event::Counters;
use super::extent::{Complete, Extent};
use super::indicator::NetworkStatus;
use super::machine::Access;
use super::state::{Cause, Fault, State};
use crate::id::MacId;

/// A command that cannot be carried out. Nothing was changed.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CommandError {
    /// [`MacIdSource::Switches`]. Over the network: 0x0E, attribute not settable.
    #[error("the MAC ID comes from switches: turn them, then call reset_with_switches")]
    MacIdFromSwitches,
    /// [`CounterSetMode::OnlyZero`]. Over the network: 0x09, invalid attribute value.
    #[error("the bus-off counter can only be set to 0, not to {0}")]
    CounterNotZero(u8),
}

impl Access {
    /// The state, with its data.
    #[must_use]
    pub const fn state(&self) -> State {
        self.state
    }

    /// Whether the node takes part in normal communication.
    #[must_use]
    pub const fn is_online(&self) -> bool {
        matches!(self.state, State::OnLine { .. })
    }

    /// Why the node is off line; `None` if it is not faulted.
    #[must_use]
    pub const fn fault(&self) -> Option<Fault> {
        match self.state {
            State::CommFault { fault, .. } => Some(fault),
            State::NonExistent
            | State::SendingDupMac { .. }
            | State::WaitingDupMac { .. }
            | State::OnLine { .. } => None,
        }
    }

    /// DeviceNet object, attribute 1.
    #[must_use]
    pub const fn mac_id(&self) -> MacId {
        self.mac_id
    }

    /// BOI: DeviceNet object, attribute 3.
    #[must_use]
    pub const fn bus_off_interrupt(&self) -> bool {
        self.bus_off_interrupt
    }

    /// DeviceNet object, attribute 4: how often the controller went off the bus since power-up, at most 255.
    #[must_use]
    pub const fn bus_off_counter(&self) -> u8 {
        self.bus_off_counter
    }

    /// DeviceNet object, attribute 10: Quick Connect as it will be at the next start.
    #[must_use]
    pub const fn quick_connect(&self) -> bool {
        self.quick_connect.stored
    }

    /// What was counted since the machine was made.
    #[must_use]
    pub const fn counters(&self) -> &Counters {
        &self.counters
    }

    /// What it was made with.
    #[must_use]
    pub const fn config(&self) -> &Config {
        &self.config
    }

    /// The network status indicator, as far as network access decides it: on line it is
    /// [`FlashingGreen`](NetworkStatus::FlashingGreen) here, and what the connections make of it in a slave or master.
    #[must_use]
    pub const fn network_status(&self) -> NetworkStatus {
        match self.state {
            State::NonExistent | State::SendingDupMac { .. } | State::WaitingDupMac { .. } => {
                NetworkStatus::Off
            }
            State::OnLine { .. } => NetworkStatus::FlashingGreen,
            State::CommFault { offline, .. } if offline.indicating => NetworkStatus::FlashingRedGreen,
            State::CommFault { .. } => NetworkStatus::SolidRed,
        }
    }

    /// Starts anew, as after a power cycle: BOI as configured, the bus-off counter 0, Quick Connect as stored. It leads
    /// out of every fault, that of a duplicate included. A node without link power goes on waiting for it.
    pub fn reset(&mut self, now: Instant) {
        self.reset_within::<Complete>(now, self.mac_id);
    }

    /// Starts anew, as [`reset`](Self::reset), with the MAC ID that the switches show now.
    pub fn reset_with_switches(&mut self, now: Instant, mac_id: MacId) {
        self.reset_within::<Complete>(now, mac_id);
    }

    pub(crate) fn reset_within<P: Extent>(&mut self, now: Instant, mac_id: MacId) {
        self.mac_id = mac_id;
        self.timers.advance(now);
        self.bus_off_interrupt = self.config.bus_off_interrupt;
        self.bus_off_counter = 0;
        if P::QUICK_CONNECT {
            self.quick_connect.active = self.quick_connect.stored;
        }
        self.start_anew::<P>(Cause::Reset);
    }

    /// Sets the MAC ID (DeviceNet object, attribute 1) and starts anew. Send the response, and the shutdown message if
    /// there is to be one, before that: they go out under the old MAC ID.
    ///
    /// Setting the MAC ID that is in use restarts the node too, unless
    /// [`same_mac_id_restarts`](Config::same_mac_id_restarts) is off.
    ///
    /// # Errors
    /// [`CommandError::MacIdFromSwitches`] if switches set it.
    pub fn set_mac_id(&mut self, now: Instant, mac_id: MacId) -> Result<(), CommandError> {
        self.set_mac_id_within::<Complete>(now, mac_id)
    }

    pub(crate) fn set_mac_id_within<P: Extent>(
        &mut self,
        now: Instant,
        mac_id: MacId,
    ) -> Result<(), CommandError> {
        self.timers.advance(now);
        if self.config.mac_id_source == MacIdSource::Switches {
            return Err(CommandError::MacIdFromSwitches);
        }
        if P::CHOICES && mac_id == self.mac_id && !self.config.same_mac_id_restarts {
            return Ok(());
        }
        self.mac_id = mac_id;
        self.start_anew::<P>(Cause::MacIdSet);
        Ok(())
    }

    /// Sets BOI: what the next bus-off leads to. It does not lead out of a fault.
    pub const fn set_bus_off_interrupt(&mut self, restart: bool) {
        self.bus_off_interrupt = restart;
    }

    /// Writes the bus-off counter, as Set_Attribute_Single of attribute 4 does: it becomes 0.
    ///
    /// # Errors
    /// [`CommandError::CounterNotZero`] for another value than 0 with [`CounterSetMode::OnlyZero`].
    pub const fn set_bus_off_counter(&mut self, value: u8) -> Result<(), CommandError> {
        match self.config.counter_set_mode {
            CounterSetMode::OnlyZero if value != 0 => Err(CommandError::CounterNotZero(value)),
            CounterSetMode::OnlyZero | CounterSetMode::AnyValueClears => {
                self.clear_bus_off_counter();
                Ok(())
            }
        }
    }

    /// Sets the bus-off counter to 0.
    pub const fn clear_bus_off_counter(&mut self) {
        self.bus_off_counter = 0;
    }

    /// Sets all that it [counted](Self::counters) to 0, the bus-off counter not.
    pub fn clear_counters(&mut self) {
        self.counters = Counters::default();
    }

    /// Stores Quick Connect (attribute 10). It takes effect at the next power-up or reset.
    pub const fn set_quick_connect(&mut self, enabled: bool) {
        self.quick_connect.stored = enabled;
    }

    /// Moves every instant that the machine stores towards zero, so that a model checker can compare histories of
    /// different age.
    pub fn shift_time(&mut self, span: Duration) {
        self.timers.shift(span);
    }

    fn start_anew<P: Extent>(&mut self, cause: Cause) {
        if self.state != State::NonExistent {
            self.restart::<P>(cause);
        }
    }
}
