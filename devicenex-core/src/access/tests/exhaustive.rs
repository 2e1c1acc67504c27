//! Every state that the machine can get into, by every order of inputs.
//!
//! The real machine is explored, not a model of it: two machines that differ only in the time of day and in what they
//! counted are the same.

use std::collections::HashSet;
use std::vec::Vec;

use link_core::link::LinkCommandKind;
use link_core::{
    Action, BitRate, BusErrorKind, Frame, Input, Instant, LinkCommand, LinkEvent, Machine, Mode, TxOutcome,
    machine_laws,
};

use super::super::{Access, AccessEvent, Cause, Config, StateKind};
use super::bus::*;
use crate::bit_rate::Candidates;
use crate::id::Direction;
use crate::message::{DeviceIdentity, Hello, MiniWho, PortByte, Roam};

/// A machine, and what the bus knows of it.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
struct World {
    node: Access,
    on_the_bus: bool,
    in_flight: bool,
    /// What the controller was asked last, and has not done.
    mode_asked: Option<Mode>,
    restarting: bool,
    /// What it does.
    mode: Option<Mode>,
    /// Waits that passed without objection since the last start.
    waits: u8,
}

#[derive(Clone, Copy, Debug)]
enum Step {
    Hello(DeviceIdentity, u8, Direction),
    Roam(u8),
    MiniWho,
    Link(LinkEvent),
    ModeSet,
    Done(TxOutcome),
    Deadline,
    Reset,
    SetAddress,
}

const STEPS: &[Step] = &[
    Step::Hello(LOWER, 67, Direction::Request),
    Step::Hello(HIGHER, 67, Direction::Request),
    Step::Hello(HIGHER, 67, Direction::Response),
    Step::Hello(LOWER, 127, Direction::Request),
    Step::Roam(67),
    Step::MiniWho,
    Step::Link(LinkEvent::Up),
    Step::Link(LinkEvent::Down),
    Step::Link(LinkEvent::BusOff),
    Step::Link(LinkEvent::BusError(BusErrorKind::Ack)),
    Step::Link(LinkEvent::Refused(LinkCommandKind::SetMode)),
    Step::Link(LinkEvent::Refused(LinkCommandKind::Reset)),
    Step::ModeSet,
    Step::Done(TxOutcome::Sent),
    Step::Done(TxOutcome::Withdrawn),
    Step::Done(TxOutcome::Dropped),
    Step::Deadline,
    Step::Reset,
    Step::SetAddress,
];

impl World {
    fn new(mut config: Config) -> Self {
        // One wait after another, so that they interleave in few ways.
        config.bus_off_back_off = config.hello_wait;
        config.candidates = Candidates::new(&[BitRate::K125, BitRate::K250]).unwrap();
        Self {
            node: Access::new(config),
            on_the_bus: false,
            in_flight: false,
            mode_asked: None,
            restarting: false,
            mode: None,
            waits: 0,
        }
    }

    /// What follows from a step; `None` if it cannot happen now.
    fn step(&self, step: Step) -> Option<Self> {
        let mut next = self.clone();
        let mut now = self.node.timers.now();
        let mut input = |input| next.node.input(now, input);
        match step {
            Step::Hello(device, address, direction) => {
                let hello = Hello { source: oa(address), direction, device, port: PortByte::ZERO };
                input(Input::Frame(hello.frame()?));
            }
            Step::Roam(address) => {
                input(Input::Frame(Roam { target: OWN, requested: oa(address) }.frame()?));
            }
            Step::MiniWho => input(Input::Frame(MiniWho { serial_low: 1 }.frame()?)),
            Step::Link(event) => {
                input(Input::Link(event));
                match event {
                    LinkEvent::Up => (next.on_the_bus, next.restarting) = (true, false),
                    LinkEvent::Down | LinkEvent::BusOff => {
                        (next.on_the_bus, next.mode, next.mode_asked) = (false, None, None);
                    }
                    LinkEvent::Refused(LinkCommandKind::SetMode) => {
                        next.mode_asked = None;
                        self.mode_asked?;
                    }
                    LinkEvent::Refused(_) if !self.restarting => return None,
                    LinkEvent::Refused(_) => next.restarting = false,
                    _ => {}
                }
            }
            Step::ModeSet => {
                let mode = self.mode_asked?;
                input(Input::Link(LinkEvent::ModeSet(mode)));
                (next.mode, next.mode_asked) = (Some(mode), None);
            }
            Step::Done(_) if !self.in_flight => return None,
            Step::Done(TxOutcome::Sent) if !self.on_the_bus => return None,
            Step::Done(outcome) => {
                input(Input::TxDone(Access::TOKEN, outcome));
                next.in_flight = false;
            }
            Step::Deadline => {
                now = self.node.deadline()?.at;
                next.node.input(now, Input::Tick);
            }
            Step::Reset => next.node.reset(now),
            Step::SetAddress => next.node.set_address(now, oa(67)),
        }
        while let Some(action) = next.node.poll(now) {
            next.observe(action);
        }
        assert_ne!(next.node.deadline().map(|deadline| deadline.why), Some("output pending"));
        next.node.shift_time(now.saturating_since(Instant::ZERO));
        next.node.clear_counters();
        next.node.clear_bus_off_counter();
        Some(next)
    }

    fn observe(&mut self, action: Action<AccessEvent>) {
        match action {
            Action::Transmit(_, frame) => {
                assert!(!self.in_flight, "two frames in flight");
                self.in_flight = true;
                self.may_send(&frame);
            }
            Action::Withdraw(_) => assert!(self.in_flight, "nothing to withdraw"),
            Action::Link(LinkCommand::SetMode(mode)) => self.mode_asked = Some(mode),
            Action::Link(LinkCommand::Reset) => self.restarting = true,
            Action::Link(LinkCommand::SetFilter(_)) => {}
            Action::Event(AccessEvent::StateChanged { to, cause, .. }) => {
                match (to, cause) {
                    (StateKind::Hello1, _) => self.waits = 0,
                    (StateKind::Hello2 | StateKind::Online | StateKind::Standby, Cause::WaitOver) => {
                        self.waits += 1;
                    }
                    _ => {}
                }
                if matches!(to, StateKind::Online | StateKind::Standby) {
                    assert_eq!(self.waits, 2, "{to} after {} waits", self.waits);
                }
            }
            Action::Event(_) => {}
        }
    }

    fn may_send(&self, frame: &Frame) {
        let mode = self.mode.expect("a mode was set");
        assert!(!mode.listen_only, "{frame} in listen-only mode");
        assert_eq!(self.node.bit_rate(), Some(mode.bit_rate), "{frame} at a rate that was not confirmed");
        assert!(self.on_the_bus, "{frame} off the bus");
    }
}

fn reachable(config: Config) -> Vec<World> {
    machine_laws::reachable(World::new(config), STEPS, World::step, 20_000).into_iter().collect()
}

fn configs() -> [Config; 4] {
    let with = |mut config: Config, boi: bool| {
        config.bus_off_interrupt = boi;
        config.early_roam = boi;
        config
    };
    [with(config(), false), with(config(), true), with(manager(), false), with(manager(), true)]
}

/// The rules are asserted in every step; here, that all states are reached but those of the other role.
#[test]
fn no_order_of_inputs_breaks_a_rule() {
    for config in configs() {
        let is_device = config.role == super::super::Role::Device;
        let worlds = reachable(config);
        let kinds: HashSet<_> = worlds.iter().map(|world| world.node.state().kind()).collect();
        assert_eq!(kinds.len(), if is_device { 8 } else { 7 }, "{} worlds: {kinds:?}", worlds.len());
    }
}

/// From everywhere the application can get the node on line by a reset, on a bus that does its part.
#[test]
fn a_reset_leads_on_line_from_everywhere() {
    for config in configs() {
        for start in reachable(config) {
            let mut world = start.step(Step::Reset).unwrap();
            for _ in 0..40 {
                let next = [
                    world.step(Step::Done(TxOutcome::Sent)),
                    world.step(Step::Done(TxOutcome::Dropped)),
                    world.step(Step::ModeSet),
                    (world.restarting || !world.on_the_bus)
                        .then(|| world.step(Step::Link(LinkEvent::Up)))
                        .flatten(),
                    (world.node.state().kind() == StateKind::DetectingBitRate)
                        .then(|| world.step(Step::MiniWho))
                        .flatten(),
                    (world.node.state().kind() == StateKind::Standby)
                        .then(|| world.step(Step::Roam(67)))
                        .flatten(),
                    world.step(Step::Deadline),
                ];
                let Some(next) = next.into_iter().flatten().next() else { break };
                world = next;
                if world.node.is_online() {
                    break;
                }
            }
            assert!(world.node.is_online(), "{:?} from {:?}", world.node.state(), start.node.state());
        }
    }
}
