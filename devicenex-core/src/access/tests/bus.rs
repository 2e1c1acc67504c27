//! One node, and the tester as the rest of the bus.

use core::time::Duration;
use std::collections::VecDeque;
use std::vec::Vec;

use link_core::frame::extended_id;
use link_core::{
    Action, BitRate, BusErrorKind, Frame, Input, Instant, LinkCommand, LinkEvent, Machine, Mode, TxOutcome,
};

use super::super::{Access, AccessEvent, Config, Role, StateKind};
use crate::id::{Direction, OperationalAddress};
use crate::message::{DeviceIdentity, Hello, MiniWho, PortByte, Roam};

/// The identity of the node. The vendor is fictitious.
pub(super) const OWN: DeviceIdentity = device(0x1122_3344);
/// A device that keeps an address against the node, when both join.
pub(super) const LOWER: DeviceIdentity = device(0x1122_3343);
/// A device that gives way to it.
pub(super) const HIGHER: DeviceIdentity = device(0x1122_3345);

/// The identifier of the node's Hello request without an address, and with address 67; of its response with that.
pub(super) const HELLO_127: u32 = 0x1FFE_4433;
pub(super) const HELLO_67: u32 = 0x1F86_4433;
pub(super) const RESPONSE_67: u32 = 0x1F87_4433;
pub(super) const DATA: [u8; 8] = [0x22, 0x11, 0x34, 0x12, 0x07, 0x00, 0x01, 0x00];

const fn device(serial: u32) -> DeviceIdentity {
    DeviceIdentity { vendor: cip_core::code::VendorId(0x1234), product_code: 7, major_revision: 1, serial }
}

pub(super) fn oa(number: u8) -> OperationalAddress {
    OperationalAddress::new(number).unwrap()
}

/// A device that says nothing unasked on line.
pub(super) fn config() -> Config {
    Config { announcement: 0, ..Config::new(OWN, PortByte::ZERO, Role::Device) }
}

/// A network manager with address 67, at 250 kbit/s.
pub(super) fn manager() -> Config {
    let role = Role::NetworkManager { address: oa(67), bit_rate: BitRate::K250 };
    Config { announcement: 0, ..Config::new(OWN, PortByte::ZERO, role) }
}

pub(super) fn listen_only(bit_rate: BitRate) -> Mode {
    Mode { bit_rate, listen_only: true }
}

pub(super) fn active(bit_rate: BitRate) -> Mode {
    Mode { bit_rate, listen_only: false }
}

/// A node in some state.
pub(super) type Make = fn(Config) -> Bus;

pub(super) struct Bus {
    pub(super) node: Access,
    pub(super) now: Instant,
    in_flight: bool,
    transmits: VecDeque<Frame>,
    withdrawals: usize,
    links: VecDeque<LinkCommand>,
    /// The mode that the controller is in.
    mode: Option<Mode>,
    filter: Option<link_core::FilterSet>,
    pub(super) events: Vec<AccessEvent>,
}

impl Bus {
    /// A node without power.
    pub(super) fn dark(config: Config) -> Self {
        Self {
            node: Access::new(config),
            now: Instant::ZERO,
            in_flight: false,
            transmits: VecDeque::new(),
            withdrawals: 0,
            links: VecDeque::new(),
            mode: None,
            filter: None,
            events: Vec::new(),
        }
    }

    /// A node that was given power just now.
    pub(super) fn power_up(config: Config) -> Self {
        let mut bus = Self::dark(config);
        bus.link(LinkEvent::Up);
        bus
    }

    /// A device that listens at the first rate.
    pub(super) fn listening(config: Config) -> Self {
        let mut bus = Self::power_up(config);
        bus.sets_mode(listen_only(BitRate::K500));
        bus
    }

    /// A node whose controller takes part, and whose first Hello is with it.
    pub(super) fn greeting(config: Config) -> Self {
        let is_device = config.role == Role::Device;
        let mut bus = Self::power_up(config);
        if is_device {
            bus.sets_mode(listen_only(BitRate::K500));
            bus.hears_any();
            bus.hears_any();
            bus.sets_mode(active(BitRate::K500));
        } else {
            bus.sets_mode(active(BitRate::K250));
        }
        bus.is(StateKind::Hello1);
        bus
    }

    /// A device without an address, after both Hellos.
    pub(super) fn standby(config: Config) -> Self {
        let mut bus = Self::greeting(config);
        bus.says_both(HELLO_127);
        bus.is(StateKind::Standby);
        bus.events.clear();
        bus
    }

    /// A device that was given address 67, and whose first Hello with it is with the controller.
    pub(super) fn roamed(config: Config) -> Self {
        let mut bus = Self::standby(config);
        bus.roam(OWN, 67);
        bus.is(StateKind::Hello1);
        bus.events.clear();
        bus
    }

    /// A device on line with address 67.
    pub(super) fn online(config: Config) -> Self {
        let mut bus = Self::roamed(config);
        bus.says_both(HELLO_67);
        bus.is(StateKind::Online);
        bus.events.clear();
        bus
    }

    #[track_caller]
    pub(super) fn says_both(&mut self, id: u32) {
        for _ in 0..2 {
            self.sends(id);
            self.acknowledges();
            self.wait(1000);
        }
    }

    pub(super) fn input(&mut self, input: Input) {
        self.node.input(self.now, input);
        self.drain();
    }

    pub(super) fn link(&mut self, event: LinkEvent) {
        if let LinkEvent::ModeSet(mode) = event {
            self.mode = Some(mode);
        }
        self.input(Input::Link(event));
    }

    pub(super) fn hears(&mut self, frame: Frame) {
        self.input(Input::Frame(frame));
    }

    /// A frame that is nobody's business here.
    pub(super) fn hears_any(&mut self) {
        self.hears(Frame::new(extended_id(0x0102_0304), &[1]).unwrap());
    }

    pub(super) fn hello(&mut self, device: DeviceIdentity, address: u8, direction: Direction) {
        let hello = Hello { source: oa(address), direction, device, port: PortByte::ZERO };
        self.hears(hello.frame().unwrap());
    }

    pub(super) fn request(&mut self, device: DeviceIdentity, address: u8) {
        self.hello(device, address, Direction::Request);
    }

    pub(super) fn response(&mut self, device: DeviceIdentity, address: u8) {
        self.hello(device, address, Direction::Response);
    }

    pub(super) fn roam(&mut self, target: DeviceIdentity, address: u8) {
        self.hears(Roam { target, requested: oa(address) }.frame().unwrap());
    }

    pub(super) fn mini_who(&mut self) {
        self.hears(MiniWho { serial_low: 1 }.frame().unwrap());
    }

    /// An error on the bus.
    pub(super) fn error(&mut self) {
        self.link(LinkEvent::BusError(BusErrorKind::Stuff));
    }

    /// A command of the application, and what follows from it.
    pub(super) fn command<T>(&mut self, command: impl FnOnce(&mut Access, Instant) -> T) -> T {
        let result = command(&mut self.node, self.now);
        self.drain();
        result
    }

    /// Lets time pass, with a tick at each deadline on the way.
    pub(super) fn wait(&mut self, millis: u64) {
        let until = self.now + Duration::from_millis(millis);
        while let Some(deadline) = self.node.deadline().filter(|deadline| deadline.at <= until) {
            self.now = self.now.max(deadline.at);
            self.input(Input::Tick);
        }
        self.now = until;
    }

    /// The Hello that was handed to the controller.
    #[track_caller]
    pub(super) fn sends(&mut self, id: u32) {
        assert_eq!(self.transmits.pop_front(), Frame::new(extended_id(id), &DATA));
    }

    /// Another node acknowledges the frame.
    #[track_caller]
    pub(super) fn acknowledges(&mut self) {
        self.done(TxOutcome::Sent);
    }

    /// The controller says what became of the frame.
    #[track_caller]
    pub(super) fn done(&mut self, outcome: TxOutcome) {
        assert!(self.in_flight, "nothing is in flight");
        self.in_flight = false;
        self.input(Input::TxDone(Access::TOKEN, outcome));
    }

    /// The same, if a frame is in flight.
    pub(super) fn answer(&mut self, outcome: TxOutcome) {
        if self.in_flight {
            self.done(outcome);
        }
    }

    #[track_caller]
    pub(super) fn sends_nothing(&self) {
        assert_eq!(self.transmits, []);
    }

    /// The node asks for a mode, and for nothing else; the controller obeys.
    #[track_caller]
    pub(super) fn sets_mode(&mut self, mode: Mode) {
        self.asks_for_mode(mode);
        self.link(LinkEvent::ModeSet(mode));
    }

    #[track_caller]
    pub(super) fn asks_for_mode(&mut self, mode: Mode) {
        let modes: Vec<_> = self
            .links
            .drain(..)
            .filter_map(|command| match command {
                LinkCommand::SetMode(mode) => Some(mode),
                LinkCommand::SetFilter(_) | LinkCommand::Reset => None,
            })
            .collect();
        assert_eq!(modes, [mode]);
    }

    #[track_caller]
    pub(super) fn is(&self, kind: StateKind) {
        assert_eq!(self.node.state().kind(), kind);
    }

    /// The frame in flight was withdrawn, once.
    #[track_caller]
    pub(super) fn withdraws(&mut self) {
        assert_eq!(core::mem::take(&mut self.withdrawals), 1, "withdrawals");
    }

    /// How often the controller was told to restart since it was last asked.
    pub(super) fn controller_restarts(&mut self) -> usize {
        self.links.drain(..).filter(|command| *command == LinkCommand::Reset).count()
    }

    /// The filter that was last set.
    #[track_caller]
    pub(super) fn filter(&self) -> link_core::FilterSet {
        self.filter.clone().expect("no filter was set")
    }

    #[track_caller]
    pub(super) fn tells(&self, event: AccessEvent) {
        assert!(self.events.contains(&event), "{event:?} is not among {:?}", self.events);
    }

    /// What a node may send in its state, whatever happened to it.
    #[track_caller]
    fn may_send(&self, frame: &Frame) {
        assert!(
            self.mode.is_some_and(|mode| !mode.listen_only && self.node.bit_rate() == Some(mode.bit_rate))
                || self.node.bit_rate().is_none(),
            "{frame} at a bit rate that was not confirmed: {:?}",
            self.mode
        );
        let hello = Hello::of_frame(frame).expect("a Hello").expect("a Hello that can be read");
        assert_eq!((hello.source, hello.device), (self.node.address(), OWN));
        let allowed = match self.node.state().kind() {
            StateKind::NonExistent | StateKind::DetectingBitRate | StateKind::BusOff | StateKind::Faulted => {
                false
            }
            StateKind::Hello1 | StateKind::Hello2 | StateKind::Standby => {
                hello.direction == Direction::Request
            }
            StateKind::Online => hello.direction == Direction::Response,
        };
        assert!(allowed, "{hello} in {:?}", self.node.state());
    }

    fn drain(&mut self) {
        while let Some(action) = self.node.poll(self.now) {
            match action {
                Action::Transmit(token, frame) => {
                    assert_eq!(token, Access::TOKEN);
                    assert!(!self.in_flight, "two frames in flight");
                    self.in_flight = true;
                    self.may_send(&frame);
                    self.transmits.push_back(frame);
                }
                Action::Withdraw(token) => {
                    assert_eq!(token, Access::TOKEN);
                    assert!(self.in_flight, "nothing to withdraw");
                    self.withdrawals += 1;
                }
                Action::Link(LinkCommand::SetFilter(filter)) => self.filter = Some(filter),
                Action::Link(command) => self.links.push_back(command),
                Action::Event(event) => self.events.push(event),
            }
        }
        let pending = self.node.deadline().is_some_and(|deadline| deadline.why == "output pending");
        assert!(!pending, "drained, and yet output is pending");
    }
}

impl Bus {
    /// The controller does one of the things that it was asked to do.
    pub(super) fn obeys(&mut self, choice: u8) {
        match choice {
            0 => self.answer(TxOutcome::Sent),
            1 => self.answer(TxOutcome::Dropped),
            _ => match self.links.pop_back() {
                Some(LinkCommand::SetMode(mode)) => {
                    self.links.clear();
                    self.link(LinkEvent::ModeSet(mode));
                }
                Some(LinkCommand::Reset) => self.link(LinkEvent::Up),
                Some(LinkCommand::SetFilter(_)) | None => {}
            },
        }
    }
}
