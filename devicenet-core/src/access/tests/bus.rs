//! One node, and the tester as the rest of the bus.

use core::time::Duration;
use std::collections::VecDeque;
use std::vec::Vec;

use link_core::{
    Action, Frame, Input, Instant, LinkCommand, LinkEvent, Machine, TxOutcome, frame::standard_id,
};

use super::super::{Access, AccessEvent, Config, StateKind};
use crate::id::MacId;
use crate::message::{DeviceIdentity, PortNumber};

/// MAC ID 37, whose check is on 0x52F. The identity is fictitious.
pub(super) fn config() -> Config {
    let device = DeviceIdentity { vendor: 0x1234.into(), serial: 0x0000_2345 };
    Config::new(device, PortNumber::ZERO, mac(37))
}

pub(super) fn mac(number: u8) -> MacId {
    MacId::new(number).unwrap()
}

pub(super) const CHECK: u16 = 0x52F;
pub(super) const REQUEST: [u8; 7] = [0x00, 0x34, 0x12, 0x45, 0x23, 0x00, 0x00];
pub(super) const RESPONSE: [u8; 7] = [0x80, 0x34, 0x12, 0x45, 0x23, 0x00, 0x00];
/// The same of another device.
pub(super) const TWIN_REQUEST: [u8; 7] = [0x00, 0x34, 0x12, 0x99, 0x99, 0x00, 0x00];
pub(super) const TWIN_RESPONSE: [u8; 7] = [0x80, 0x34, 0x12, 0x99, 0x99, 0x00, 0x00];

pub(super) struct Bus {
    pub(super) node: Access,
    pub(super) now: Instant,
    in_flight: bool,
    transmits: VecDeque<Frame>,
    withdrawals: usize,
    links: VecDeque<LinkCommand>,
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
            events: Vec::new(),
        }
    }

    /// A node that was given power just now.
    pub(super) fn power_up(config: Config) -> Self {
        let mut bus = Self::dark(config);
        bus.link(LinkEvent::Up);
        bus
    }

    /// A node in `WaitingDupMac` after its first request.
    pub(super) fn waiting(config: Config) -> Self {
        let mut bus = Self::power_up(config);
        bus.sends(CHECK, &REQUEST);
        bus.acknowledges();
        bus
    }

    /// A node on line, two seconds after power-up.
    pub(super) fn online(config: Config) -> Self {
        let mut bus = Self::waiting(config);
        bus.wait(1000);
        bus.sends(CHECK, &REQUEST);
        bus.acknowledges();
        bus.wait(1000);
        bus.is(StateKind::OnLine);
        bus
    }

    /// A node that was faulted by a duplicate while it was waiting.
    pub(super) fn faulted(config: Config) -> Self {
        let mut bus = Self::waiting(config);
        bus.hears(CHECK, &TWIN_RESPONSE);
        bus.is(StateKind::CommFault);
        bus.events.clear();
        bus
    }

    pub(super) fn input(&mut self, input: Input) {
        self.node.input(self.now, input);
        self.drain();
    }

    pub(super) fn link(&mut self, event: LinkEvent) {
        self.input(Input::Link(event));
    }

    pub(super) fn hears(&mut self, id: u16, data: &[u8]) {
        self.input(Input::Frame(Frame::new(standard_id(id), data).unwrap()));
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

    /// The frame that was handed to the controller.
    #[track_caller]
    pub(super) fn sends(&mut self, id: u16, data: &[u8]) {
        let expected = Frame::new(standard_id(id), data).unwrap();
        assert_eq!(self.transmits.pop_front(), Some(expected));
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

    #[track_caller]
    pub(super) fn is(&self, kind: StateKind) {
        assert_eq!(self.node.state().kind(), kind);
    }

    /// The frame in flight was withdrawn, once.
    #[track_caller]
    pub(super) fn withdraws(&mut self) {
        assert_eq!(core::mem::take(&mut self.withdrawals), 1, "withdrawals");
    }

    #[track_caller]
    pub(super) fn withdraws_nothing(&self) {
        assert_eq!(self.withdrawals, 0, "withdrawals");
    }

    /// The identifiers among all 2048 that pass the filter that was last set.
    pub(super) fn listens_to(&mut self) -> Vec<u16> {
        let mut filters = self.links.drain(..).filter_map(|command| match command {
            LinkCommand::SetFilter(filter) => Some(filter),
            _ => None,
        });
        let filter = filters.next_back().expect("no filter was set");
        (0..=0x7FF).filter(|&raw| filter.accepts(&Frame::new(standard_id(raw), &[]).unwrap())).collect()
    }

    /// How often the controller was told to restart since it was last asked.
    pub(super) fn controller_restarts(&mut self) -> usize {
        self.links.drain(..).filter(|command| *command == LinkCommand::Reset).count()
    }

    #[track_caller]
    pub(super) fn tells(&self, event: AccessEvent) {
        assert!(self.events.contains(&event), "{event:?} is not among {:?}", self.events);
    }

    /// What a node may send in its state, whatever happened to it.
    #[track_caller]
    fn may_send(&self, frame: &Frame) {
        let check = u32::from(0x407 + 8 * u16::from(self.node.mac_id().number()));
        let is_check = frame.raw_id() == check && frame.dlc() == 7;
        let allowed = match self.node.state().kind() {
            StateKind::NonExistent | StateKind::WaitingDupMac => false,
            StateKind::SendingDupMac => is_check && frame.data()[0] == 0,
            StateKind::OnLine => is_check,
            StateKind::CommFault => frame.raw_id() == 0x7EC,
        };
        assert!(allowed, "{frame} in {:?}", self.node.state());
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
                Action::Link(command) => self.links.push_back(command),
                Action::Event(event) => self.events.push(event),
            }
        }
        let pending = self.node.deadline().is_some_and(|deadline| deadline.why == "output pending");
        assert!(!pending, "drained, and yet output is pending");
    }
}

impl Access {
    /// For explorations: machines that differ only in what they counted are the same.
    pub(crate) fn forget_counts(&mut self) {
        self.clear_counters();
        self.clear_bus_off_counter();
    }
}
