//! The tool, and the tester as faulted nodes and other tools.

use std::string::{String, ToString};
use std::vec::Vec;

use link_core::{Action, Frame, Input, Instant, LinkEvent, Machine, TxOutcome, TxToken};

use super::super::*;
use crate::access;
use crate::id::{Identifier, MacId};
use crate::message::{DeviceIdentity, PortNumber};

pub(super) struct Bus {
    pub(super) tool: OfflineTool,
    pub(super) now: Instant,
    pub(super) in_flight: Option<(TxToken, Frame)>,
    pub(super) withdrawals: usize,
    pub(super) events: Vec<String>,
}

pub(super) fn mac(number: u8) -> MacId {
    MacId::new(number).unwrap()
}

/// The faulted device of the specification's examples: vendor 6, serial number 0x05060708.
pub(super) const DEVICE: DeviceIdentity =
    DeviceIdentity { vendor: cip_core::code::VendorId(6), serial: 0x0506_0708 };

#[track_caller]
pub(super) fn frame(text: &str) -> Frame {
    let (id, data) = text.split_once(':').unwrap();
    let data: Vec<u8> = data.split_whitespace().map(|byte| u8::from_str_radix(byte, 16).unwrap()).collect();
    Identifier::new(u16::from_str_radix(id, 16).unwrap()).unwrap().frame(&data).unwrap()
}

/// Tool 5 of a fictitious vendor.
pub(super) fn config() -> Config {
    let device = DeviceIdentity { vendor: 0x1234.into(), serial: 0x0000_2345 };
    Config::new(access::Config::new(device, PortNumber::ZERO, mac(5)))
}

impl Bus {
    /// Tool 5, on line.
    pub(super) fn online() -> Self {
        Self::online_as(config())
    }

    pub(super) fn online_as(config: Config) -> Self {
        let device = config.access.device;
        let [a, b, c, d] = device.serial.to_le_bytes();
        let check = std::format!("42F: 00 34 12 {a:02X} {b:02X} {c:02X} {d:02X}");
        let tool = OfflineTool::new(config);
        let mut bus = Self { tool, now: Instant::ZERO, in_flight: None, withdrawals: 0, events: Vec::new() };
        bus.input(Input::Link(LinkEvent::Up));
        assert_eq!(bus.tool.claim(bus.now), Err(CommandError::NotOnLine));
        for _ in 0..2 {
            bus.sends(&check);
            bus.wait(1000);
        }
        assert!(bus.tool.access().is_online());
        bus
    }

    /// The owner of the set.
    pub(super) fn owner() -> Self {
        let mut bus = Self::online();
        bus.command(|tool, now| tool.claim(now)).unwrap();
        for _ in 0..2 {
            bus.sends("7EF: 05 4B 34 12 45 23 00 00");
            bus.wait(1000);
        }
        assert_eq!(bus.tool.state(), ToolState::Owner);
        bus.events.clear();
        bus
    }

    pub(super) fn input(&mut self, input: Input) {
        self.tool.input(self.now, input);
        self.drain();
    }

    pub(super) fn command<T>(&mut self, command: impl FnOnce(&mut OfflineTool, Instant) -> T) -> T {
        let result = command(&mut self.tool, self.now);
        self.drain();
        result
    }

    #[track_caller]
    pub(super) fn hears(&mut self, text: &str) {
        self.input(Input::Frame(frame(text)));
    }

    pub(super) fn wait(&mut self, millis: u64) {
        let until = self.now + core::time::Duration::from_millis(millis);
        while let Some(deadline) = self.tool.deadline().filter(|deadline| deadline.at <= until) {
            self.now = self.now.max(deadline.at);
            self.input(Input::Tick);
        }
        self.now = until;
    }

    #[track_caller]
    pub(super) fn sends(&mut self, expected: &str) {
        let (token, sent) = self.in_flight.take().expect(expected);
        assert_eq!(sent, frame(expected), "{sent}");
        self.input(Input::TxDone(token, TxOutcome::Sent));
    }

    /// The frame is given back, or withdrawn.
    #[track_caller]
    pub(super) fn gives_back(&mut self, expected: &str, outcome: TxOutcome) {
        let (token, sent) = self.in_flight.take().expect(expected);
        assert_eq!(sent, frame(expected), "{sent}");
        self.input(Input::TxDone(token, outcome));
    }

    #[track_caller]
    pub(super) fn tells(&mut self, expected: &[&str]) {
        assert_eq!(core::mem::take(&mut self.events), expected);
    }

    fn drain(&mut self) {
        while let Some(action) = self.tool.poll(self.now) {
            match action {
                Action::Transmit(token, frame) => {
                    assert!(self.in_flight.is_none(), "two frames in flight");
                    self.in_flight = Some((token, frame));
                }
                Action::Withdraw(_) => self.withdrawals += 1,
                Action::Link(_) => {}
                Action::Event(ToolEvent::Access(_)) => {}
                Action::Event(event) => self.events.push(event.to_string()),
            }
        }
        assert_ne!(self.tool.deadline().map(|deadline| deadline.why), Some("output pending"));
    }
}
