//! One manager, and the tester as the rest of the bus.

use core::time::Duration;
use std::string::{String, ToString};
use std::vec::Vec;

use cip_core::code::{DeviceType, VendorId};
use cip_core::identity::{ProductName, Revision};
use link_core::frame::extended_id;
use link_core::{
    Action, BitRate, Frame, Input, Instant, LinkCommand, LinkEvent, Machine, TxOutcome, TxToken,
};

use super::super::*;
use crate::id::{Direction, OperationalAddress};
use crate::message::{DeviceIdentity, Hello, MiniWho, PortByte};

/// The device that is planned for address 67, its spare, and one of another kind.
pub(super) const PLANNED: DeviceIdentity = device(7, 0x1122_3344);
pub(super) const SPARE: DeviceIdentity = device(7, 0x1122_3345);
pub(super) const STRANGER: DeviceIdentity = device(8, 0x1122_3346);
/// For which the plan of a consumer is.
pub(super) const CONSUMER: DeviceIdentity = device(3, 0xA);

const fn device(product_code: u16, serial: u32) -> DeviceIdentity {
    DeviceIdentity { vendor: VendorId(0x1234), product_code, major_revision: 1, serial }
}

pub(super) fn oa(number: u8) -> OperationalAddress {
    OperationalAddress::new(number).unwrap()
}

/// Of a manager with address 1 and a serial number that ends in 0x0100.
pub(super) fn config() -> Config {
    let own = cip_core::identity::DeviceIdentity {
        vendor: VendorId(0x1234),
        device_type: DeviceType::COMMUNICATIONS_ADAPTER,
        product_code: 1,
        revision: Revision::new(1, 1).unwrap(),
        serial: 0x0100,
        name: ProductName::new("Example Manager").unwrap(),
    };
    let mut config = Config::new(own, oa(1), BitRate::K500);
    config.node.access.announcement = 0;
    config
}

/// The producer at address 67, every 100 ms.
pub(super) fn producer() -> PlannedDevice<4> {
    let mut plan = PlannedDevice::new(oa(67), IdentityPattern::exact(PLANNED));
    plan.spares.push(IdentityPattern::exact(SPARE)).unwrap();
    plan.connections.push(PlannedConnection::producer(100)).unwrap();
    plan
}

/// Consumes what 67 produces, with address 5.
pub(super) fn consumer(rate: u16) -> PlannedDevice<4> {
    let mut plan = PlannedDevice::new(oa(5), IdentityPattern::exact(CONSUMER));
    let source = Source { address: oa(67), connection: 0 };
    plan.connections.push(PlannedConnection::consumer(source, rate)).unwrap();
    plan
}

#[derive(Clone)]
pub(super) struct Bus {
    pub(super) manager: Manager<4, 4>,
    pub(super) now: Instant,
    /// With the controller.
    pub(super) in_flight: Vec<(TxToken, Frame)>,
    pub(super) events: Vec<ManagerEvent>,
}

impl Bus {
    /// A manager that was given power just now.
    pub(super) fn power_up(config: Config, plan: impl IntoIterator<Item = PlannedDevice<4>>) -> Self {
        let mut manager = Manager::new(config);
        for planned in plan {
            manager.add_device(Instant::ZERO, planned).unwrap();
        }
        let mut bus = Self { manager, now: Instant::ZERO, in_flight: Vec::new(), events: Vec::new() };
        bus.input(Input::Link(LinkEvent::Up));
        bus
    }

    /// A manager that has just got on line.
    pub(super) fn on_line(config: Config, plan: impl IntoIterator<Item = PlannedDevice<4>>) -> Self {
        let mut bus = Self::power_up(config, plan);
        for _ in 0..2 {
            bus.acknowledges();
            bus.wait(1000);
        }
        assert!(bus.manager.access().is_online());
        bus
    }

    pub(super) fn input(&mut self, input: Input) {
        let mut inputs = std::vec![input];
        while let Some(input) = inputs.pop() {
            for action in self.manager.handle(self.now, input) {
                match action {
                    Action::Transmit(token, frame) => self.in_flight.push((token, frame)),
                    Action::Withdraw(token) => {
                        self.in_flight.retain(|(other, _)| *other != token);
                        inputs.push(Input::TxDone(token, TxOutcome::Withdrawn));
                    }
                    Action::Link(LinkCommand::SetMode(mode)) => {
                        inputs.push(Input::Link(LinkEvent::ModeSet(mode)));
                    }
                    Action::Link(_) => {}
                    Action::Event(event) => self.events.push(event),
                }
            }
        }
    }

    /// What it has with the controller gets on the bus, and what follows from that.
    pub(super) fn acknowledges(&mut self) -> Vec<String> {
        let mut sent = Vec::new();
        while !self.in_flight.is_empty() {
            let (token, frame) = self.in_flight.remove(0);
            sent.push(frame.to_string());
            self.input(Input::TxDone(token, TxOutcome::Sent));
        }
        sent
    }

    #[track_caller]
    pub(super) fn sends(&mut self, expected: &[&str]) {
        assert_eq!(self.acknowledges(), expected);
    }

    pub(super) fn frame(&mut self, frame: Frame) {
        self.input(Input::Frame(frame));
    }

    /// `1C038600: 8E 34 12`
    #[track_caller]
    pub(super) fn hears(&mut self, text: &str) {
        let (id, data) = text.split_once(':').unwrap();
        let data: Vec<u8> =
            data.split_whitespace().map(|byte| u8::from_str_radix(byte, 16).unwrap()).collect();
        self.frame(Frame::new(extended_id(u32::from_str_radix(id, 16).unwrap()), &data).unwrap());
    }

    pub(super) fn hello(&mut self, source: u8, direction: Direction, device: DeviceIdentity) {
        let hello = Hello { source: oa(source), direction, device, port: PortByte::ZERO };
        self.frame(hello.frame().unwrap());
    }

    pub(super) fn mini_who(&mut self, serial_low: u16) {
        self.frame(MiniWho { serial_low }.frame().unwrap());
    }

    /// Time passes, deadline by deadline; nothing gets on the bus.
    pub(super) fn wait(&mut self, millis: u64) {
        let end = self.now + Duration::from_millis(millis);
        while let Some(deadline) = self.manager.deadline().filter(|deadline| deadline.at <= end) {
            self.now = self.now.max(deadline.at);
            self.input(Input::Tick);
        }
        self.now = end;
        self.input(Input::Tick);
    }

    /// The same while everything gets on the bus.
    pub(super) fn wait_on_the_bus(&mut self, millis: u64) -> Vec<String> {
        let end = self.now + Duration::from_millis(millis);
        let mut sent = self.acknowledges();
        while let Some(deadline) = self.manager.deadline().filter(|deadline| deadline.at <= end) {
            self.now = self.now.max(deadline.at);
            self.input(Input::Tick);
            sent.extend(self.acknowledges());
        }
        self.now = end;
        self.input(Input::Tick);
        sent.extend(self.acknowledges());
        sent
    }

    #[track_caller]
    pub(super) fn is(&self, address: u8, state: DeviceState) {
        assert_eq!(self.manager.device(oa(address)).unwrap().state, state, "{:#?}", self.said());
    }

    /// What it told since the last time, without its own network access.
    pub(super) fn tells(&mut self) -> Vec<String> {
        let said = self.said();
        self.events.clear();
        said
    }

    fn said(&self) -> Vec<String> {
        let own = |event: &&ManagerEvent| !matches!(event, ManagerEvent::Node(_));
        self.events.iter().filter(own).map(ToString::to_string).collect()
    }

    // The stages of a device with address 67.

    pub(super) fn probing() -> Self {
        let bus = Self::on_line(config(), [producer()]);
        bus.is(67, DeviceState::Probing);
        bus
    }

    /// Somewhere between two Mini-whos, long after the answers to the first.
    pub(super) fn missing() -> Self {
        let mut bus = Self::probing();
        bus.wait_on_the_bus(1500);
        bus.is(67, DeviceState::Missing);
        bus
    }

    /// The device joins: it is waited for.
    pub(super) fn found() -> Self {
        let mut bus = Self::missing();
        bus.hello(127, Direction::Request, PLANNED);
        bus.is(67, DeviceState::Found);
        bus
    }

    pub(super) fn assigned() -> Self {
        let mut bus = Self::found();
        bus.wait_on_the_bus(1020);
        bus.is(67, DeviceState::Assigned);
        bus
    }

    pub(super) fn joining() -> Self {
        let mut bus = Self::assigned();
        bus.hello(67, Direction::Request, PLANNED);
        bus.is(67, DeviceState::Joining);
        bus
    }

    pub(super) fn connecting() -> Self {
        let mut bus = Self::joining();
        bus.wait(1000);
        bus.acknowledges();
        bus.hello(67, Direction::Request, PLANNED);
        bus.wait(1020);
        bus.is(67, DeviceState::Connecting);
        bus
    }

    pub(super) fn running() -> Self {
        let mut bus = Self::connecting();
        bus.answers_connection();
        bus.is(67, DeviceState::Running);
        bus
    }

    pub(super) fn retrying() -> Self {
        let mut bus = Self::running();
        bus.wait(1000);
        bus.is(67, DeviceState::Retrying);
        bus
    }

    pub(super) fn lost() -> Self {
        let mut bus = Self::retrying();
        bus.wait_on_the_bus(1600);
        bus.is(67, DeviceState::Lost);
        bus
    }

    pub(super) fn conflict() -> Self {
        let mut bus = Self::missing();
        bus.hello(67, Direction::Response, STRANGER);
        bus.is(67, DeviceState::Conflict);
        bus
    }

    /// 67 grants what it was asked for last: connection 7, every 100 ms.
    #[track_caller]
    pub(super) fn answers_connection(&mut self) {
        let sent = self.acknowledges();
        let request = sent.iter().find(|frame| frame.starts_with("1D8602")).expect("a connection request");
        let transaction = &request[6..8];
        self.hears(&std::format!("1D0386{transaction}: 4B C0 00 64 00"));
    }

    /// Whoever has the address answers the four questions about its identity.
    pub(super) fn identifies(&mut self, device: DeviceIdentity) {
        let [vendor, product] = [device.vendor.0, device.product_code].map(u16::to_le_bytes);
        let values = [
            vendor.to_vec(),
            product.to_vec(),
            std::vec![device.major_revision, 1],
            device.serial.to_le_bytes().to_vec(),
        ];
        for value in values {
            self.answers_get(&value);
        }
    }

    /// The same; the first question has been sent already.
    pub(super) fn identifies_from(&mut self, request: &str, device: DeviceIdentity) {
        let [low, high] = device.vendor.0.to_le_bytes();
        self.hears(&std::format!("1C0386{}: 8E {low:02X} {high:02X}", &request[6..8]));
        let [low, high] = device.product_code.to_le_bytes();
        self.answers_get(&[low, high]);
        self.answers_get(&[device.major_revision, 1]);
        self.answers_get(&device.serial.to_le_bytes());
    }

    /// The answer of 67 to the attribute that it was asked for last.
    #[track_caller]
    pub(super) fn answers_get(&mut self, value: &[u8]) {
        let sent = self.acknowledges();
        let request = sent.iter().rev().find(|frame| frame.starts_with("1C8602")).expect("a request");
        let value: String = value.iter().map(|byte| std::format!(" {byte:02X}")).collect();
        self.hears(&std::format!("1C0386{}: 8E{value}", &request[6..8]));
    }

    /// The manager found the device on line, with its connection, of that packet rate.
    pub(super) fn adopted(rate: u16) -> Self {
        let mut plan = producer();
        plan.connections[0].expected_packet_rate = rate;
        let mut bus = Self::on_line(config(), [plan]);
        bus.identifies(PLANNED);
        bus.answers_get(&[3]);
        bus.answers_get(&0x8086_0007_u32.to_le_bytes());
        bus.answers_get(&rate.to_le_bytes());
        bus.is(67, DeviceState::Running);
        bus
    }
}
