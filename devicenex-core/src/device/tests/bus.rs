//! One device, and the tester as the rest of the bus.

use core::time::Duration;
use std::collections::VecDeque;
use std::string::{String, ToString};
use std::vec::Vec;

use cip_core::code::{DeviceType, InstanceId, VendorId};
use cip_core::connection::{End, IoMode};
use cip_core::identity::{DeviceIdentity, ProductName, Revision};
use cip_core::object::Identity;
use link_core::frame::{extended_id, standard_id};
use link_core::{
    Action, FilterSet, Frame, Input, Instant, LinkCommand, LinkEvent, Machine, TxOutcome, TxToken,
};

use crate::access::{Role, StateKind};
use crate::device::{Application, Config, Device, DeviceEvent, Fragmented, Offer};
use crate::message::{ConnectionInstance, PortByte};

/// Vendor 0x03E7, product 0x2A, revision 1, serial 0x11223344; as many bytes as a test likes.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Station {
    pub(super) device: DeviceIdentity,
    pub(super) inputs: Vec<u8>,
    pub(super) outputs: Vec<u8>,
    pub(super) offer: Offer,
    pub(super) selected: u16,
    /// Where [`Application::rest`] was called.
    pub(super) rests: Vec<(ConnectionInstance, IoMode)>,
}

impl Application for Station {
    const SELECTS_ASSEMBLIES: bool = true;
    type Long = Fragmented<32>;

    fn offered(&self) -> Offer {
        self.offer
    }

    fn identity(&self) -> Identity<'_> {
        Identity::new(&self.device)
    }

    fn produced(&self, _: ConnectionInstance) -> &[u8] {
        &self.inputs
    }

    fn consumed(&mut self, _: ConnectionInstance) -> &mut [u8] {
        &mut self.outputs
    }

    fn assembly(&self, _: ConnectionInstance, end: End) -> Option<InstanceId> {
        Some(InstanceId(if end == End::Produced { self.selected } else { 100 }))
    }

    fn select_assembly(&mut self, _: ConnectionInstance, end: End, assembly: InstanceId) -> bool {
        if end == End::Consumed || !(1..=9).contains(&assembly.0) {
            return false;
        }
        self.selected = assembly.0;
        self.inputs = std::vec![0xEE; usize::from(assembly.0) * 8];
        true
    }

    fn rest(&mut self, connection: ConnectionInstance, mode: IoMode) {
        self.rests.push((connection, mode));
        self.outputs.fill(0);
    }
}

pub(super) fn identity() -> DeviceIdentity {
    DeviceIdentity {
        vendor: VendorId(0x03E7),
        device_type: DeviceType::GENERAL_PURPOSE_DISCRETE_IO,
        product_code: 0x2A,
        revision: Revision::new(1, 1).unwrap(),
        serial: 0x1122_3344,
        name: ProductName::new("Example Block 2I1O").unwrap(),
    }
}

pub(super) fn station() -> Station {
    Station {
        device: identity(),
        inputs: std::vec![0x34, 0x12],
        outputs: std::vec![0],
        offer: Offer::all(),
        selected: 1,
        rests: Vec::new(),
    }
}

pub(super) type Node = Device<Station, 40, 6>;

#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Bus {
    pub(super) node: Node,
    pub(super) now: Instant,
    pub(super) sent: VecDeque<Frame>,
    pub(super) events: Vec<DeviceEvent>,
    pub(super) filter: Option<FilterSet>,
    /// Frames that the controller has, while it is [stuck](Self::stuck).
    pub(super) held: Vec<(TxToken, Frame)>,
    pub(super) stuck: bool,
    /// What the controller says of the next frames.
    pub(super) outcome: TxOutcome,
}

impl Bus {
    /// On line with OA 67, two input bytes `34 12`, one output byte.
    pub(super) fn new() -> Self {
        Self::with(|_| {}, |_| {})
    }

    pub(super) fn with(change: impl FnOnce(&mut Config), fit: impl FnOnce(&mut Station)) -> Self {
        let mut config = Config::new(&identity(), PortByte::ZERO, Role::Device);
        config.access.announcement = 0;
        change(&mut config);
        let mut application = station();
        fit(&mut application);
        let mut bus = Self {
            node: Device::new(config, application).unwrap(),
            now: Instant::ZERO,
            sent: VecDeque::new(),
            events: Vec::new(),
            filter: None,
            held: Vec::new(),
            stuck: false,
            outcome: TxOutcome::Sent,
        };
        bus.link(LinkEvent::Up);
        bus.joins();
        bus
    }

    /// Two Mini-whos tell the bit rate; then ROAM to OA 67.
    fn joins(&mut self) {
        let mini_who = Frame::remote(extended_id(0x1FFE_0001), 8).unwrap();
        while self.node.access().state().kind() == StateKind::DetectingBitRate {
            self.input(Input::Frame(mini_who));
        }
        self.wait(2000);
        assert_eq!(self.node.access().state().kind(), StateKind::Standby);
        self.hears(0x1EFE_4433, &[0x22, 0x11, 0xE7, 0x03, 0x2A, 0, 1, 67]);
        self.wait(2000);
        assert!(self.node.access().is_online());
        self.forget();
    }

    pub(super) fn forget(&mut self) {
        self.sent.clear();
        self.events.clear();
    }

    pub(super) fn link(&mut self, event: LinkEvent) {
        self.input(Input::Link(event));
    }

    pub(super) fn input(&mut self, input: Input) {
        self.node.input(self.now, input);
        self.drain();
    }

    pub(super) fn drain(&mut self) {
        while let Some(action) = self.node.poll(self.now) {
            match action {
                Action::Transmit(token, frame) if self.stuck => self.held.push((token, frame)),
                Action::Transmit(token, frame) => {
                    if self.outcome == TxOutcome::Sent {
                        self.sent.push_back(frame);
                    }
                    self.node.input(self.now, Input::TxDone(token, self.outcome));
                }
                Action::Withdraw(token) => {
                    let held = self.held.iter().position(|(other, _)| *other == token);
                    self.held.remove(held.expect("it was handed out"));
                    self.node.input(self.now, Input::TxDone(token, TxOutcome::Withdrawn));
                }
                Action::Link(LinkCommand::SetFilter(filter)) => self.filter = Some(filter),
                Action::Link(LinkCommand::SetMode(mode)) => {
                    self.node.input(self.now, Input::Link(LinkEvent::ModeSet(mode)));
                }
                Action::Link(_) => {}
                Action::Event(event) => self.events.push(event),
            }
        }
        assert!(self.node.deadline().is_none_or(|deadline| deadline.at >= self.now));
    }

    /// The controller sends what it has.
    pub(super) fn unstick(&mut self) {
        self.stuck = false;
        let mut held: Vec<_> = core::mem::take(&mut self.held);
        held.sort_by_key(|(_, frame)| frame.arbitration_key());
        for (token, frame) in held {
            self.sent.push_back(frame);
            self.input(Input::TxDone(token, TxOutcome::Sent));
        }
    }

    /// A data frame: 29 bits, or 11 below 0x800.
    pub(super) fn hears(&mut self, id: u32, data: &[u8]) {
        self.input(Input::Frame(frame(id, data)));
    }

    /// Time passes, deadline by deadline.
    pub(super) fn wait(&mut self, millis: u64) {
        let end = self.now + Duration::from_millis(millis);
        while let Some(deadline) = self.node.deadline().filter(|deadline| deadline.at <= end) {
            self.now = deadline.at.max(self.now);
            self.input(Input::Tick);
        }
        self.now = end;
        self.input(Input::Tick);
    }

    #[track_caller]
    pub(super) fn sends(&mut self, id: u32, data: &[u8]) {
        let sent = self.sent.pop_front().map(|frame| frame.to_string());
        assert_eq!(sent, Some(frame(id, data).to_string()), "then {:?}", self.trace());
    }

    #[track_caller]
    pub(super) fn is_silent(&mut self) {
        assert!(self.sent.is_empty(), "{:?}", self.trace());
    }

    pub(super) fn trace(&self) -> Vec<String> {
        self.sent.iter().map(ToString::to_string).collect()
    }

    /// What was told since the last time, in words.
    pub(super) fn told(&mut self) -> Vec<String> {
        self.events.drain(..).map(|event| event.to_string()).collect()
    }

    /// The manager asks for a connection, and gets this answer.
    #[track_caller]
    pub(super) fn connects(&mut self, request: &[u8], response: &[u8]) {
        self.hears(0x1D86_0209, request);
        self.sends_besides(0x1D03_8609, response);
    }

    /// Among what it sends.
    #[track_caller]
    pub(super) fn sends_besides(&mut self, id: u32, data: &[u8]) {
        let expected = frame(id, data);
        let place = self.sent.iter().position(|sent| sent.id() == expected.id());
        let sent = place.and_then(|place| self.sent.remove(place)).map(|frame| frame.to_string());
        assert_eq!(sent, Some(expected.to_string()), "besides {:?}", self.trace());
    }

    /// The manager asks over explicit connection 1, Message ID 0.
    #[track_caller]
    pub(super) fn asks(&mut self, request: &[u8], response: &[u8]) {
        self.hears(0x1086_0205, request);
        self.sends_besides(0x1003_8605, response);
    }

    /// With explicit connection 1, Message ID 0, EPR 0.
    pub(super) fn explicit() -> Self {
        let mut bus = Self::new();
        bus.opens_explicit();
        bus
    }

    #[track_caller]
    pub(super) fn opens_explicit(&mut self) {
        self.connects(&[0x4B, 0xD0, 1, 0, 0, 0, 1], &[0x4B, 0xD0, 0, 0, 0]);
        self.forget();
    }

    /// The state of an instance, 0 if it does not exist.
    pub(super) fn state(&self, instance: u16) -> u8 {
        let number = InstanceId(instance);
        self.node.connections().find(|one| one.instance.number() == number).map_or(0, |one| one.state.0)
    }
}

pub(super) fn frame(id: u32, data: &[u8]) -> Frame {
    match u16::try_from(id) {
        Ok(id @ 0..0x800) => Frame::new(standard_id(id), data).unwrap(),
        _ => Frame::new(extended_id(id), data).unwrap(),
    }
}

/// As a trace shows it.
pub(super) fn id(raw: u32) -> String {
    crate::id::Identifier::of_frame(&frame(raw, &[])).to_string()
}
