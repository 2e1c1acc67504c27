//! What the application asks of network access, and what it can ask about it.

use core::time::Duration;

use link_core::{BitRate, Instant};

use super::config::Config;
use super::event::Counters;
use super::machine::Access;
use super::state::{Cause, Fault, HelloStage, Restart, State};
use crate::id::OperationalAddress;

impl Access {
    /// The state, with its data.
    #[must_use]
    pub const fn state(&self) -> &State {
        &self.state
    }

    /// What it was told at the start.
    #[must_use]
    pub const fn config(&self) -> &Config {
        &self.config
    }

    /// The address that the node has, wants, or had; [`OperationalAddress::NONE`] if none.
    #[must_use]
    pub const fn address(&self) -> OperationalAddress {
        self.address
    }

    /// Whether it has its address, and may use connections.
    #[must_use]
    pub const fn is_online(&self) -> bool {
        matches!(self.state, State::Online { .. })
    }

    /// The bit rate of the bus, once it is known, or set; `None` before, and where it is that of the link.
    #[must_use]
    pub const fn bit_rate(&self) -> Option<BitRate> {
        self.bit_rate
    }

    /// Why it is faulted.
    #[must_use]
    pub const fn fault(&self) -> Option<Fault> {
        match self.state {
            State::Faulted { fault } => Some(fault),
            _ => None,
        }
    }

    /// How often the controller went off the bus since power-up or reset.
    #[must_use]
    pub const fn bus_off_counter(&self) -> u8 {
        self.bus_off_counter
    }

    /// BOI.
    #[must_use]
    pub const fn bus_off_interrupt(&self) -> bool {
        self.bus_off_interrupt
    }

    /// How long others have to object after each Hello, in ms.
    #[must_use]
    pub const fn hello_wait(&self) -> u16 {
        self.hello_wait
    }

    /// What it counted.
    #[must_use]
    pub const fn counters(&self) -> &Counters {
        &self.counters
    }

    /// Starts anew, as after a power cycle: without the address that it was given, and all as configured. It leads out of
    /// every fault. A node without link power goes on waiting for it.
    pub fn reset(&mut self, now: Instant) {
        self.timers.advance(now);
        self.address = self.config.first_address();
        self.hello_wait = self.config.hello_wait;
        self.bus_off_interrupt = self.config.bus_off_interrupt;
        self.bus_off_counter = 0;
        self.restarts_left = self.config.bus_off_restarts;
        match self.state {
            State::NonExistent => {}
            State::BusOff { .. } | State::Faulted { fault: Fault::Restart } => {
                let restart = Restart::Restarting { commanded: false };
                self.enter(State::BusOff { restart }, Cause::Reset);
            }
            State::DetectingBitRate { .. }
            | State::Hello { .. }
            | State::Standby { .. }
            | State::Online { .. }
            | State::Faulted { fault: Fault::Mode } => self.start(Cause::Reset),
        }
    }

    /// Sets the address (link object, attribute 1), and says Hello with it; [`OperationalAddress::NONE`] gives it up. Send
    /// the response before that: it goes out under the old address. A node that does not take part in the bus yet begins
    /// with the address when it does.
    pub fn set_address(&mut self, now: Instant, address: OperationalAddress) {
        self.timers.advance(now);
        match self.state {
            State::Hello { stage: HelloStage::SettingMode { .. }, .. }
            | State::NonExistent
            | State::DetectingBitRate { .. }
            | State::BusOff { .. }
            | State::Faulted { .. } => self.address = address,
            State::Hello { .. } | State::Standby { .. } | State::Online { .. } => {
                self.rejoin(address, Cause::AddressSet);
            }
        }
    }

    /// Sets BOI: what the next bus-off leads to. It does not bring back a node that is off the bus.
    pub const fn set_bus_off_interrupt(&mut self, restart: bool) {
        self.bus_off_interrupt = restart;
    }

    /// Sets the bus-off counter to 0.
    pub const fn clear_bus_off_counter(&mut self) {
        self.bus_off_counter = 0;
    }

    /// Sets all that it [counted](Self::counters) to 0, the bus-off counter not.
    pub fn clear_counters(&mut self) {
        self.counters = Counters::default();
    }

    /// Sets how long others have to object after the next Hello, in ms. Not kept over a reset.
    pub const fn set_hello_wait(&mut self, millis: u16) {
        self.hello_wait = millis;
    }

    /// Moves every instant that the machine stores towards zero, so that a model checker can compare histories of
    /// different age.
    pub fn shift_time(&mut self, span: Duration) {
        self.timers.shift(span);
    }
}
