//! One master, and the tester as the rest of the bus.

use core::time::Duration;
use std::collections::VecDeque;
use std::string::{String, ToString};
use std::vec::Vec;

use cip_core::code::DeviceType;
use cip_core::identity::{DeviceIdentity, ProductName, Revision};
use link_core::{Action, Frame, Input, Instant, LinkEvent, Machine, TxOutcome, TxToken};

use super::super::*;
use crate::id::{Identifier, MacId, Purpose};

pub(super) type Scanner = Master<4, 32>;

pub(super) fn mac(number: u8) -> MacId {
    MacId::new(number).unwrap()
}

/// Master 4 of a fictitious vendor.
pub(super) fn config() -> Config {
    let device = DeviceIdentity {
        vendor: 0x1234.into(),
        device_type: DeviceType::COMMUNICATIONS_ADAPTER,
        product_code: 1,
        revision: Revision { major: 1, minor: 1 },
        serial: 0x0000_2345,
        name: ProductName::new("Example Master").unwrap(),
    };
    Config::new(device, mac(4))
}

/// Slave 63 of the specification's worked trace: two bytes in, one byte out, polled every 75 ms.
pub(super) fn polled() -> ScanEntry {
    let poll = PollConnection { produce: 2, consume: 1, expected_packet_rate: 75 };
    let key = ElectronicKey {
        vendor: Some(0x03E7.into()),
        device_type: Some(7.into()),
        product_code: Some(0x2A),
        revision: None,
    };
    ScanEntry { key, poll: Some(poll), ..ScanEntry::explicit_only(mac(63)) }
}

pub(super) struct Bus {
    pub(super) master: Scanner,
    pub(super) now: Instant,
    in_flight: VecDeque<(TxToken, Frame)>,
    pub(super) withdrawn: Vec<TxToken>,
    pub(super) events: Vec<String>,
}

/// `5FC: 04 0E 01 01 01`, as the specification prints frames.
#[track_caller]
pub(super) fn frame(text: &str) -> Frame {
    let (id, data) = text.split_once(':').unwrap();
    let data: Vec<u8> = data.split_whitespace().map(|byte| u8::from_str_radix(byte, 16).unwrap()).collect();
    Identifier::new(u16::from_str_radix(id, 16).unwrap()).unwrap().frame(&data).unwrap()
}

impl Bus {
    /// A master that is on line, two seconds after power-up.
    #[track_caller]
    pub(super) fn online(config: Config, entries: &[ScanEntry]) -> Self {
        let mut bus = Self::checking(config, entries);
        bus.sends("427: 00 34 12 45 23 00 00");
        bus.wait(1000);
        bus.sends("427: 00 34 12 45 23 00 00");
        bus.wait(1000);
        assert!(bus.master.access().is_online());
        bus
    }

    /// A master that was given power just now.
    #[track_caller]
    pub(super) fn checking(config: Config, entries: &[ScanEntry]) -> Self {
        let mut master = Scanner::new(config);
        for entry in entries {
            master.add_slave(Instant::ZERO, *entry).unwrap();
        }
        let mut bus = Self {
            master,
            now: Instant::ZERO,
            in_flight: VecDeque::new(),
            withdrawn: Vec::new(),
            events: Vec::new(),
        };
        bus.input(Input::Link(LinkEvent::Up));
        bus
    }

    /// The same, with slave 63 running and the first scan about to begin.
    #[track_caller]
    pub(super) fn running(config: Config) -> Self {
        let mut bus = Self::online(config, &[polled()]);
        bus.brings_up_63();
        bus.events.clear();
        bus
    }

    /// The worked trace up to the established poll connection.
    #[track_caller]
    pub(super) fn brings_up_63(&mut self) {
        for (request, response) in [
            ("5FE: 04 4B 03 01 01 04", "5FB: 04 CB 00"),
            ("5FC: 44 10 05 01 0C 03", "5FB: 44 90"),
            ("5FC: 04 0E 01 01 01", "5FB: 04 8E E7 03"),
            ("5FC: 44 0E 01 01 02", "5FB: 44 8E 07 00"),
            ("5FC: 04 0E 01 01 03", "5FB: 04 8E 2A 00"),
            ("5FC: 44 4B 03 01 02 04", "5FB: 44 CB 00"),
            ("5FC: 04 0E 05 02 07", "5FB: 04 8E 02 00"),
            ("5FC: 44 0E 05 02 08", "5FB: 44 8E 01 00"),
            ("5FC: 04 10 05 02 09 4B 00", "5FB: 04 90 50 00"),
        ] {
            self.sends(request);
            self.hears(response);
        }
    }

    /// Answers every request with what the scan list wants, until all slaves run; polls of those that do stay unanswered.
    #[track_caller]
    pub(super) fn answers_everything(&mut self, entries: &[ScanEntry]) {
        let running =
            |bus: &Self, entry: &ScanEntry| bus.master.state(entry.mac_id) == Some(SlaveState::Running);
        while !entries.iter().all(|entry| running(self, entry)) {
            let (_, request) = *self.in_flight.front().expect("a request");
            let (id, data) = (Identifier::of_frame(&request).unwrap(), request.data());
            self.sends(&std::format!("{:03X}: {}", id.raw(), hex(data)));
            let slave = id.mac_id().unwrap();
            if !matches!(id.purpose(), Purpose::ExplicitRequest | Purpose::Group2UnconnectedRequest) {
                continue;
            }
            let entry = entries.iter().find(|entry| entry.mac_id == slave).unwrap();
            let agreed = IoInstance::ALL
                .into_iter()
                .find(|instance| data.get(3) == Some(&(instance.instance().0 as u8)))
                .and_then(|instance| entry.agreed(instance));
            let size = |size: Option<u16>| std::format!(" {:02X} 00", size.unwrap_or(0));
            let value = match data.get(1..) {
                Some([0x4B, ..]) => " 00".into(),
                Some([0x0E, 0x05, _, 7]) => size(agreed.unwrap().produce),
                Some([0x0E, 0x05, _, 8]) => size(agreed.unwrap().consume),
                Some([0x0E, ..]) => " 01 00".into(),
                Some([0x10, 0x05, _, 9, low, high]) => std::format!(" {low:02X} {high:02X}"),
                _ => String::new(),
            };
            let response = Identifier::explicit_response(slave).raw();
            self.hears(&std::format!("{response:03X}: {:02X} {:02X}{value}", data[0], data[1] | 0x80));
        }
    }

    pub(super) fn input(&mut self, input: Input) {
        if let Input::TxDone(token, _) = input {
            self.in_flight.retain(|(other, _)| *other != token);
        }
        self.master.input(self.now, input);
        self.drain();
    }

    #[track_caller]
    pub(super) fn hears(&mut self, text: &str) {
        self.input(Input::Frame(frame(text)));
    }

    /// A command of the application, and what follows from it.
    pub(super) fn command<T>(&mut self, command: impl FnOnce(&mut Scanner, Instant) -> T) -> T {
        let result = command(&mut self.master, self.now);
        self.drain();
        result
    }

    /// Lets time pass, with a tick at each deadline on the way.
    pub(super) fn wait(&mut self, millis: u64) {
        let until = self.now + Duration::from_millis(millis);
        while let Some(deadline) = self.master.deadline().filter(|deadline| deadline.at <= until) {
            self.now = self.now.max(deadline.at);
            self.input(Input::Tick);
        }
        self.now = until;
    }

    /// The frame that was handed out first is this one, and is on the bus now.
    #[track_caller]
    pub(super) fn sends(&mut self, expected: &str) {
        let (token, sent) = self.in_flight.pop_front().unwrap_or_else(|| panic!("{expected} not sent"));
        assert_eq!(sent, frame(expected), "{sent}");
        self.input(Input::TxDone(token, TxOutcome::Sent));
    }

    /// The same, if it is this one.
    pub(super) fn try_sends(&mut self, expected: &str) -> bool {
        let due = self.in_flight.front().is_some_and(|(_, sent)| *sent == frame(expected));
        if due {
            self.sends(expected);
        }
        due
    }

    /// The frame that was handed out first never gets on the bus.
    #[track_caller]
    pub(super) fn drops(&mut self, expected: &str) {
        let (token, sent) = self.in_flight.pop_front().unwrap();
        assert_eq!(sent, frame(expected), "{sent}");
        self.input(Input::TxDone(token, TxOutcome::Dropped));
    }

    /// The frame that was handed out first, whose fate is open.
    #[track_caller]
    pub(super) fn takes(&mut self) -> (TxToken, Frame) {
        self.in_flight.pop_front().unwrap()
    }

    pub(super) fn in_flight_ids(&self) -> Vec<u32> {
        self.in_flight.iter().map(|(_, frame)| frame.raw_id()).collect()
    }

    #[track_caller]
    pub(super) fn sends_nothing(&self) {
        assert_eq!(self.in_flight, []);
    }

    #[track_caller]
    pub(super) fn tells(&mut self, expected: &str) {
        let place = self.events.iter().position(|event| event == expected);
        let place = place.unwrap_or_else(|| panic!("{expected:?} is not among {:#?}", self.events));
        self.events.remove(place);
    }

    #[track_caller]
    pub(super) fn is(&self, slave: u8, state: SlaveState, status: ScannerStatus) {
        assert_eq!(self.master.state(mac(slave)), Some(state));
        assert_eq!(self.master.status(mac(slave)), Some(status));
    }

    fn drain(&mut self) {
        while let Some(action) = self.master.poll(self.now) {
            match action {
                Action::Transmit(token, frame) => {
                    assert!(self.in_flight.iter().all(|(other, _)| *other != token), "{token:?} twice");
                    self.in_flight.push_back((token, frame));
                    assert!(self.in_flight.len() <= self.master.max_in_flight());
                }
                Action::Withdraw(token) => self.withdrawn.push(token),
                Action::Link(_) => {}
                Action::Event(event) => self.events.push(event.to_string()),
            }
        }
        let pending = self.master.deadline().is_some_and(|deadline| deadline.why == "output pending");
        assert!(!pending, "drained, and yet output is pending");
    }
}

fn hex(data: &[u8]) -> String {
    data.iter().map(|byte| std::format!("{byte:02X} ")).collect()
}
