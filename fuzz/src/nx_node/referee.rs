//! What must hold for everything that a device sends and tells.

use std::collections::{BTreeMap, BTreeSet};

use cip_core::connection::{ConnectionState, IoMode};
use devicenex_core::OperationalAddress;
use devicenex_core::connection::ConnectionId;
use devicenex_core::device::DeviceEvent;
use devicenex_core::id::{Direction, Framing, Identifier, Layout, Route, Sender};
use devicenex_core::message::ConnectionInstance;
use link_core::{Frame, Mode};

use super::Machine;

/// What is known from what went in and what came out.
#[derive(Clone, Default)]
pub(super) struct Referee {
    /// The mode that the controller has; `None` off the bus.
    pub(super) mode: Option<Mode>,
    /// Who has asked, by the class of the identifier, and with which transaction; while the node was on line.
    asked: BTreeSet<(u8, u8, Option<u8>)>,
    /// As the events have them.
    states: BTreeMap<u16, ConnectionState>,
    modes: BTreeMap<u16, IoMode>,
}

impl Referee {
    /// A frame came in.
    pub(super) fn hears(&mut self, device: &Machine, frame: &Frame) {
        if !device.access().is_online() || frame.is_remote() {
            return;
        }
        let class = class_of(frame);
        match Identifier::of_frame(frame).layout() {
            Layout::Connection { route, transaction } => self.note(device, class, route, Some(transaction)),
            Layout::Connectionless { route, framing } | Layout::Explicit { route, framing, .. } => {
                let transaction = match framing {
                    Framing::Complete { transaction } => Some(transaction),
                    // In the data of the first one; that it was asked in fragments is enough.
                    Framing::Fragment(_) => frame.data().first().copied(),
                };
                self.note(device, class, route, transaction);
                self.note(device, class, route, None);
            }
            _ => {}
        }
    }

    fn note(&mut self, device: &Machine, class: u8, route: Route, transaction: Option<u8>) {
        let is_request =
            route.direction == Direction::Request && route.destination == device.access().address();
        if is_request && !route.source.is_none() && route.source != route.destination {
            self.asked.insert((class, route.source.number(), transaction));
        }
    }

    /// A frame goes out.
    pub(super) fn sends(&mut self, device: &Machine, frame: &Frame) {
        let mode = self.mode.expect("nothing is sent off the bus");
        assert!(!mode.listen_only, "nothing is sent at a bit rate that was not confirmed: {frame}");
        assert!(!frame.is_remote(), "{frame}");
        let own = device.access().address();
        let id = Identifier::of_frame(frame);
        match id.layout() {
            Layout::Hello { source, .. } => return assert_eq!(source, own, "{frame}"),
            Layout::Connection { route, transaction } => self.answers(own, frame, route, Some(transaction)),
            Layout::Connectionless { route, framing } | Layout::Explicit { route, framing, .. } => {
                let transaction = match framing {
                    Framing::Complete { transaction } => Some(transaction),
                    Framing::Fragment(_) => None,
                };
                self.answers(own, frame, route, transaction);
            }
            Layout::Implicit { .. } | Layout::Standard { .. } => produces(device, id, frame),
            Layout::Roam { .. } | Layout::Reserved(_) => panic!("a device sends no {}", id.layout()),
        }
        assert!(device.access().is_online() && !own.is_none(), "off line there is only Hello: {frame}");
        assert_eq!(id.sender(), Some(Sender::Address(own)), "{frame}");
    }

    /// Nobody is answered who has not asked.
    fn answers(&self, own: OperationalAddress, frame: &Frame, route: Route, transaction: Option<u8>) {
        assert_eq!((route.direction, route.source), (Direction::Response, own), "{frame}");
        let asked = (class_of(frame), route.destination.number(), transaction);
        assert!(self.asked.contains(&asked), "nobody has asked: {frame}");
    }

    /// The events tell one history.
    pub(super) fn tells(&mut self, event: &DeviceEvent) {
        let (connection, from, to) = match *event {
            DeviceEvent::Io { connection, from, to, .. } => (connection, from.into(), to.into()),
            DeviceEvent::Explicit { connection, from, to, .. } => (connection, from.into(), to.into()),
            DeviceEvent::Mode(connection, mode) => {
                let before = self.modes.insert(connection.number().0, mode);
                return assert_ne!(before, Some(mode), "{event}");
            }
            _ => return,
        };
        let number = connection.number().0;
        assert_eq!(self.state(number), from, "{event}");
        self.states.insert(number, to);
        if to == ConnectionState::ESTABLISHED {
            self.modes.remove(&number);
        }
    }

    fn state(&self, number: u16) -> ConnectionState {
        self.states.get(&number).copied().unwrap_or(ConnectionState::NON_EXISTENT)
    }

    /// All has been told: the connections are what the events say.
    pub(super) fn holds(&self, device: &Machine) {
        let mut told = self.states.clone();
        told.retain(|_, state| *state != ConnectionState::NON_EXISTENT);
        let actual: BTreeMap<_, _> =
            device.connections().map(|one| (one.instance.number().0, one.state)).collect();
        assert_eq!(told, actual);
        if !device.access().is_online() {
            assert!(actual.is_empty(), "connections without an address");
        }
        let own = device.access().address();
        let mut produced = BTreeSet::new();
        for one in device.connections() {
            assert!(!matches!(one.instance, ConnectionInstance::Reserved(_)), "{one:?}");
            assert!(!one.requester.is_none() && one.requester != own, "{one:?}");
            if one.produced != ConnectionId::NONE {
                let id = one.produced.identifier().expect("it is an identifier");
                assert_eq!(id.sender(), Some(Sender::Address(own)), "{one:?}");
                assert!(produced.insert(one.produced), "two connections produce with {id}");
            }
            if let Some(Sender::Address(source)) = one.consumed.identifier().and_then(Identifier::sender) {
                assert_ne!(source, own, "{one:?}");
            }
        }
    }

    /// Whoever leaves has forgotten who asked.
    pub(super) fn forget(&mut self, device: &Machine) {
        if !device.access().is_online() {
            self.asked.clear();
        }
    }
}

/// Data go out on established connections only.
fn produces(device: &Machine, id: Identifier, frame: &Frame) {
    let one = device.connections().find(|one| one.produced == ConnectionId::from(id));
    let one = one.unwrap_or_else(|| panic!("no connection produces {frame}"));
    assert_eq!(one.state, ConnectionState::ESTABLISHED, "{frame}");
    let inputs = &device.application().inputs;
    if inputs.len() <= 8 {
        assert!(frame.data().is_empty() || frame.data() == inputs.as_slice(), "{frame}");
    } else {
        assert!(frame.data().first().is_none_or(|byte| byte >> 6 != 3), "no acknowledge: {frame}");
    }
}

/// Bits 28-24.
fn class_of(frame: &Frame) -> u8 {
    (frame.raw_id() >> 24) as u8
}
