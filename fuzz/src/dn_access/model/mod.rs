//! Network access once more, as small as the table of CIP Vol. 3, chapter 2 allows: rows 1 to 15, the two waits, and the
//! offline connection set. Written from the table; it shares nothing with the machine but the configuration.

mod input;
mod output;
mod state;

use devicenet_core::access::{Config, CounterSetMode, MacIdSource, StateKind};
use link_core::Instant;

use super::ops::{Command, DEVICE};

use state::{Controller, Kind};
pub(super) use state::{Fault, State};

#[derive(Clone, Debug)]
pub(super) struct Model {
    config: Config,
    pub(super) now: Instant,
    pub(super) state: State,
    pub(super) mac: u8,
    pub(super) bus_off_interrupt: bool,
    pub(super) bus_off_counter: u8,
    pub(super) quick_connect: bool,
    quick_connect_active: bool,
    /// The frame in flight, and whether its fate still matters.
    pub(super) in_flight: Option<(Kind, bool)>,
    /// The machine owes a withdrawal.
    pub(super) withdraw_due: bool,
}

impl Model {
    pub(super) fn new(config: Config) -> Self {
        Self {
            now: Instant::ZERO,
            state: State::NonExistent,
            mac: config.mac_id.number(),
            bus_off_interrupt: config.bus_off_interrupt,
            bus_off_counter: 0,
            quick_connect: config.quick_connect,
            quick_connect_active: false,
            in_flight: None,
            withdraw_due: false,
            config,
        }
    }

    pub(super) fn kind(&self) -> StateKind {
        match self.state {
            State::NonExistent => StateKind::NonExistent,
            State::Sending { .. } => StateKind::SendingDupMac,
            State::Waiting { .. } => StateKind::WaitingDupMac,
            State::OnLine { .. } => StateKind::OnLine,
            State::Faulted(_) => StateKind::CommFault,
        }
    }

    /// The controller is off the bus, as far as the node knows.
    pub(super) fn is_off_the_bus(&self) -> bool {
        matches!(
            self.state,
            State::Faulted(Fault::BusOff)
                | State::Sending { controller: Controller::BackOff(_) | Controller::Restarting { .. }, .. }
        )
    }

    /// The identifier that the node must hear.
    pub(super) fn must_hear(&self) -> Option<u32> {
        match self.state {
            State::NonExistent | State::Faulted(Fault::BusOff) => None,
            State::Sending { .. } | State::Waiting { .. } | State::OnLine { .. } => Some(self.own_check()),
            State::Faulted(Fault::Duplicate { .. }) => self.config.offline_set.then_some(0x7ED),
        }
    }

    /// Whether the machine must accept the command.
    pub(super) fn command(&mut self, command: Command) -> bool {
        match command {
            Command::Reset => self.reset(),
            Command::ResetWithSwitches(mac) => {
                self.mac = mac.number();
                self.reset();
            }
            Command::SetMacId(_) if self.config.mac_id_source == MacIdSource::Switches => return false,
            Command::SetMacId(mac) => {
                if mac.number() != self.mac || self.config.same_mac_id_restarts {
                    self.mac = mac.number();
                    self.start_anew();
                }
            }
            Command::SetBusOffInterrupt(on) => self.bus_off_interrupt = on,
            Command::SetBusOffCounter(value) => {
                if value != 0 && self.config.counter_set_mode == CounterSetMode::OnlyZero {
                    return false;
                }
                self.bus_off_counter = 0;
            }
            Command::ClearBusOffCounter => self.bus_off_counter = 0,
            Command::SetQuickConnect(on) => self.quick_connect = on,
        }
        true
    }

    /// Rows 1 and 14.
    fn reset(&mut self) {
        self.bus_off_interrupt = self.config.bus_off_interrupt;
        self.bus_off_counter = 0;
        self.quick_connect_active = self.quick_connect;
        self.start_anew();
    }

    fn start_anew(&mut self) {
        if self.state != State::NonExistent {
            self.send_request(0);
        }
    }

    fn own_check(&self) -> u32 {
        0x407 + 8 * u32::from(self.mac)
    }
}

/// Port, vendor and serial number.
fn own_bytes() -> [u8; 7] {
    let [low, high] = DEVICE.vendor.0.to_le_bytes();
    let [a, b, c, d] = DEVICE.serial.to_le_bytes();
    [0, low, high, a, b, c, d]
}
