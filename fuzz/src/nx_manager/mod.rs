//! The network manager, against what a bus must never see of one.
//!
//! Three planned addresses with their connections, six devices that may say anything at any time, answers that are right,
//! wrong or none, another manager, while the application and the controller do what they like. After each operation:
//!
//! - an address goes only to a device for which it is planned, or its spare, and which said Hello without one;
//! - no Mini-who, no ROAM and no connection request of a manager that leaves the work to another; off line only Hellos;
//! - connections are asked for only of devices that are on line with their address, and one for explicit messages of whoever has
//!   the address of another;
//! - a consumer is told nothing but what the address of its producer sends with;
//! - no token is used twice, and no more frames are in flight than was said;
//! - nothing is pending after a drain, a second tick changes nothing, and a manager that works has something to wait for as
//!   long as a device is not as planned.

mod answers;
mod ops;

use std::collections::{BTreeMap, BTreeSet};

use arbitrary::Unstructured;
use cip_core::code::{AttributeId, ClassId, InstanceId, ServiceCode};
use cip_core::message::Request;
use devicenex_core::Identifier;
use devicenex_core::id::{Direction, Layout, OperationalAddress};
use devicenex_core::manager::{Attribute, Config, DeviceState, Manager, ManagerEvent};
use devicenex_core::message::{DeviceIdentity, Hello, MiniWho, PortByte, Roam};
use link_core::{
    Action, BitRate, Frame, Input, Instant, LinkCommand, LinkEvent, Machine, Mode, TxOutcome, TxToken,
};

use crate::plant::{NODES, OWN, device, oa, own, plan};
use answers::answer;
use ops::Op;

/// Does to a manager what the bytes say.
pub fn run(data: &[u8]) {
    let mut input = Unstructured::new(data);
    let Ok(choices) = input.arbitrary() else { return };
    let mut network = Network::new(choices);
    while !input.is_empty() {
        let Ok(op) = ops::op(&mut input) else { return };
        network.apply(op);
    }
}

struct Network {
    manager: Manager<5, 3>,
    clock: Instant,
    in_flight: BTreeMap<u16, Frame>,
    /// The last request to each node that was on the bus and has no answer.
    asked: BTreeMap<u8, Frame>,
    /// The devices that said Hello without an address.
    homeless: BTreeSet<DeviceIdentity>,
    /// Where the manager has told of a device that belongs elsewhere.
    misplaced: BTreeSet<OperationalAddress>,
    /// The mode that the controller is to be set to.
    mode: Option<Mode>,
    /// The application asks whom it likes.
    commanded: bool,
}

impl Network {
    fn new(choices: u8) -> Self {
        let choice = |bit: u8| choices >> bit & 1 == 1;
        let mut config = Config::new(own(), oa(OWN), BitRate::K500);
        config.node.access.bus_off_interrupt = choice(0);
        config.learning = choice(1);
        config.early_roam = choice(2);
        config.readdress = !choice(3);
        config.takeover_after = if choice(4) { 20_000 } else { 0 };
        config.rejoin_after = if choice(6) { 0 } else { 3_000 };
        if choice(5) {
            config.poll_interval = 0;
            config.idle_mini_who_interval = 0;
        }
        let mut manager = Manager::new(config);
        for address in &NODES[..3] {
            manager.add_device(Instant::ZERO, plan(*address)).expect("a good plan");
        }
        Self {
            manager,
            clock: Instant::ZERO,
            in_flight: BTreeMap::new(),
            asked: BTreeMap::new(),
            homeless: BTreeSet::new(),
            misplaced: BTreeSet::new(),
            mode: None,
            commanded: false,
        }
    }

    fn apply(&mut self, op: Op) {
        let now = self.clock;
        match op {
            Op::Tick(span) => self.input(now + span, Input::Tick),
            Op::TickInThePast(span) => self.input(now.saturating_sub(span), Input::Tick),
            Op::TickAtDeadline => match self.manager.deadline() {
                Some(deadline) => self.input(deadline.at, Input::Tick),
                None => return,
            },
            Op::Frame(frame) => self.frame(frame),
            Op::Hello { device: which, how } => {
                let source = match how % 6 {
                    0 | 1 => 127,
                    place => NODES[usize::from(place - 2)],
                };
                let direction = if how & 0x80 == 0 { Direction::Request } else { Direction::Response };
                let hello =
                    Hello { source: oa(source), direction, device: device(which), port: PortByte::ZERO };
                self.frame(hello.frame().expect("eight bytes"));
            }
            Op::Answer { node, how } => {
                let Some(request) = self.asked.remove(&NODES[usize::from(node) % NODES.len()]) else {
                    return;
                };
                let Some(response) = answer(&request, how) else { return };
                self.frame(response);
            }
            Op::Data { node, connection } => {
                let source = oa(NODES[usize::from(node) % NODES.len()]);
                let id =
                    Identifier::implicit(Default::default(), source, InstanceId(u16::from(connection % 14)));
                self.frame(id.frame(&[1, 2]).expect("two bytes"));
            }
            Op::Sent(which) => self.tx_done(which, TxOutcome::Sent),
            Op::GivenBack(which) => {
                let outcome = if which & 0x80 == 0 { TxOutcome::Dropped } else { TxOutcome::Unknown };
                self.tx_done(which, outcome);
            }
            Op::Link(event) => self.input(now, Input::Link(event)),
            Op::Command { which, node } => self.command(which, NODES[usize::from(node) % NODES.len()]),
            Op::MiniWho(low) => {
                self.frame(MiniWho { serial_low: low.into() }.frame().expect("a remote frame"))
            }
            Op::Roam(which) => {
                let roam = Roam { target: device(which), requested: oa(which) };
                self.frame(roam.frame().expect("eight bytes"));
            }
        }
        self.check();
    }

    fn frame(&mut self, frame: Frame) {
        if let Some(Ok(hello)) = Hello::of_frame(&frame)
            && hello.source.is_none()
            && hello.direction == Direction::Request
        {
            self.homeless.insert(hello.device);
        }
        self.input(self.clock, Input::Frame(frame));
    }

    fn command(&mut self, which: u8, node: u8) {
        let (now, to) = (self.clock, oa(node));
        self.commanded = true;
        let name = Attribute { class: ClassId::IDENTITY, instance: InstanceId(1), attribute: AttributeId(7) };
        match which % 9 {
            0 => _ = self.manager.remove_device(to),
            1 => _ = self.manager.add_device(now, plan(node)),
            2 => self.manager.suspend(now),
            3 => self.manager.resume(now),
            4 => self.manager.reset(now),
            5 => self.manager.set_learning(which & 0x80 != 0),
            6 => _ = self.manager.get(to, name),
            7 => {
                let data = vec![0x55; usize::from(which >> 2)];
                let request = Request::new(ServiceCode(0x32), ClassId(0x64), InstanceId(1), &data);
                _ = self.manager.request(to, &request, 1 + which / 128);
            }
            _ => _ = self.manager.readdress(to, oa(which)),
        }
        self.drain(now);
    }

    fn input(&mut self, now: Instant, input: Input) {
        self.clock = self.clock.max(now);
        self.manager.input(now, input);
        self.drain(now);
        let (before, pending) = (self.manager.clone(), self.in_flight.len());
        self.manager.input(now, Input::Tick);
        assert_eq!(self.manager, before, "a second tick");
        self.drain(now);
        assert_eq!(self.in_flight.len(), pending);
    }

    fn tx_done(&mut self, which: u8, outcome: TxOutcome) {
        let tokens: Vec<u16> = self.in_flight.keys().copied().collect();
        let Some(&token) = tokens.get(usize::from(which) % tokens.len().max(1)) else { return };
        let frame = self.in_flight.remove(&token).expect("it is in flight");
        if outcome == TxOutcome::Sent {
            match Identifier::of_frame(&frame).layout() {
                Layout::Connection { route, .. }
                | Layout::Connectionless { route, .. }
                | Layout::Explicit { route, .. } => _ = self.asked.insert(route.destination.number(), frame),
                _ => {}
            }
        }
        self.input(self.clock, Input::TxDone(TxToken(token), outcome));
    }

    fn drain(&mut self, now: Instant) {
        let mut actions = 0;
        while let Some(action) = self.manager.poll(now) {
            self.observe(action);
            actions += 1;
            assert!(actions < 300, "the drain does not end");
        }
        assert_ne!(self.manager.deadline().map(|deadline| deadline.why), Some("output pending"));
        if let Some(mode) = self.mode.take() {
            self.manager.input(now, Input::Link(LinkEvent::ModeSet(mode)));
            self.drain(now);
        }
    }

    fn observe(&mut self, action: Action<ManagerEvent>) {
        match action {
            Action::Transmit(TxToken(token), frame) => {
                assert!(!self.in_flight.contains_key(&token), "{frame}: token {token} twice");
                self.in_flight.insert(token, frame);
                assert!(self.in_flight.len() <= self.manager.max_in_flight());
                self.is_allowed(&frame);
            }
            Action::Withdraw(TxToken(token)) => {
                assert!(self.in_flight.contains_key(&token), "nothing to withdraw");
            }
            Action::Event(event) => {
                assert!(!event.to_string().is_empty());
                if let ManagerEvent::Misplaced { at, .. } = event {
                    self.misplaced.insert(at);
                }
            }
            // A controller that does as it is told.
            Action::Link(LinkCommand::SetMode(mode)) => self.mode = Some(mode),
            Action::Link(_) => {}
        }
    }

    fn is_allowed(&self, frame: &Frame) {
        let layout = Identifier::of_frame(frame).layout();
        if let Layout::Hello { .. } = layout
            && MiniWho::of_frame(frame).is_none()
        {
            return;
        }
        assert!(self.manager.access().is_online(), "{frame} off line");
        match layout {
            Layout::Hello { .. } => assert!(self.manager.works(), "{frame}: another manager works"),
            Layout::Roam { .. } => {
                assert!(self.manager.works(), "{frame}: another manager works");
                let Some(Ok(roam)) = Roam::of_frame(frame) else { panic!("{frame}: no ROAM") };
                let view = self.manager.device(roam.requested).expect("a planned address");
                assert!(view.plan.accepts(&roam.target), "{roam}: it is not planned");
                assert!(self.homeless.contains(&roam.target), "{roam}: it did not ask");
            }
            // What is not planned can be readdressed, and the application asks whom it likes.
            Layout::Connection { route, .. }
                if route.direction == Direction::Request
                    && !self.commanded
                    && NODES[..3].contains(&route.destination.number()) =>
            {
                let state = self.manager.device(route.destination).expect("it is planned").state;
                // Over an explicit connection whoever has the address of another is told its own, whatever becomes of that other
                // meanwhile.
                let is_told = self.misplaced.contains(&route.destination) && self.manager.config().readdress;
                let is_explicit = matches!(frame.data(), [0x4B, byte, ..] if byte >> 4 & 7 == 5);
                let may_be_asked = state.is_on_line() || is_told && is_explicit;
                assert!(may_be_asked && self.manager.works(), "{frame}: {state:?}");
            }
            Layout::Explicit { route, .. } => {
                if let [0x10, 5, _, 5, id @ ..] = frame.data()
                    && route.direction == Direction::Request
                {
                    // What OA 67 produces.
                    let id = u32::from_le_bytes(id.try_into().expect("a connection ID"));
                    assert_eq!(id >> 17 & 0x7F, 67, "{frame}: not its producer");
                }
            }
            _ => {}
        }
    }

    fn check(&self) {
        let polls = self.manager.config().poll_interval != 0;
        let waits = self.manager.deadline().is_some() || !self.in_flight.is_empty() || !polls;
        let unfinished = |state| !matches!(state, DeviceState::Idle | DeviceState::Running);
        assert!(waits || !self.manager.devices().any(|view| unfinished(view.state)), "stuck");
        let idle = self.manager.devices().all(|view| view.state == DeviceState::Idle);
        assert!(idle || self.manager.works(), "a manager that does not work");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On line, and the plant as it is planned, answer by answer.
    fn running() -> Network {
        let mut network = Network::new(0);
        network.apply(Op::Link(LinkEvent::Up));
        for _ in 0..2 {
            network.apply(Op::Sent(0));
            network.apply(Op::TickAtDeadline);
        }
        assert!(network.manager.works());
        for _ in 0..400 {
            network.apply(Op::Sent(0));
            for (node, which) in [(0, 2), (1, 0), (2, 3)] {
                network.apply(Op::Answer { node, how: which << 2 });
            }
            let runs =
                |address: &u8| network.manager.device(oa(*address)).unwrap().state == DeviceState::Running;
            if NODES[..3].iter().all(runs) {
                return network;
            }
        }
        panic!("{:?}", network.manager.devices().map(|view| view.state).collect::<Vec<_>>());
    }

    /// Without this the oracle would have nothing to judge.
    #[test]
    fn a_plant_is_brought_up() {
        running();
    }

    /// Whatever happens, in whatever order: bytes of a small generator of our own.
    #[test]
    fn random_operations() {
        let rounds = std::env::var("ROUNDS").map_or(300, |rounds| rounds.parse().expect("a number"));
        let mut random = 0x9E37_79B9_7F4A_7C15_u64;
        for _ in 0..rounds {
            let mut bytes = vec![0; 1200];
            for byte in &mut bytes {
                random ^= random << 13;
                random ^= random >> 7;
                random ^= random << 17;
                *byte = random.to_le_bytes()[2];
            }
            // On line at first: link up, two Hellos.
            let start = [bytes[0], 9, 0, 7, 0, 2, 7, 0, 2];
            run(&[&start, &bytes[..]].concat());
        }
    }

    #[test]
    #[should_panic(expected = "it did not ask")]
    fn a_roam_to_a_device_that_did_not_ask_is_noticed() {
        let mut network = running();
        network.homeless.clear();
        let roam = Roam { target: device(0), requested: oa(67) }.frame().unwrap();
        network.is_allowed(&roam);
    }

    #[test]
    #[should_panic(expected = "it is not planned")]
    fn a_roam_to_the_wrong_device_is_noticed() {
        let network = running();
        network.is_allowed(&Roam { target: device(5), requested: oa(67) }.frame().unwrap());
    }
}
