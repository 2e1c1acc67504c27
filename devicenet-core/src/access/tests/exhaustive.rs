//! Every state that the machine can get into, by every order of inputs.
//!
//! The real machine is explored, not a model of it: two machines that differ only in the time of day and in what they
//! counted are the same.

use std::vec::Vec;

use link_core::link::LinkCommandKind;
use link_core::{
    Action, BitRate, BusErrorKind, Frame, Input, LinkCommand, LinkEvent, Machine, Mode, TxOutcome,
    frame::standard_id,
};

use super::super::{Access, AccessEvent, BusOffWhileChecking, Cause, CheckRequest, Config, State, StateKind};
use super::bus::*;
use link_core::machine_laws;

/// A machine, and what the bus knows of it.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
struct World {
    node: Access,
    /// Whether the controller takes part, and whether it was told to come back.
    on_the_bus: bool,
    restarting: bool,
    in_flight: bool,
    /// Requests that were acknowledged, and seconds that passed without objection, since the last start.
    acknowledged: u8,
    seconds: u8,
}

#[derive(Clone, Copy, Debug)]
enum Step {
    Hear(u16, &'static [u8]),
    Link(LinkEvent),
    Done(TxOutcome),
    Deadline,
    Reset,
    SetMacId,
}

const STEPS: &[Step] = &[
    Step::Hear(CHECK, &TWIN_REQUEST),
    Step::Hear(CHECK, &TWIN_RESPONSE),
    Step::Hear(CHECK, &[]),
    Step::Hear(0x42F, &TWIN_REQUEST),
    Step::Hear(0x7ED, &[0x3F, 0x4B, 0x00]),
    Step::Hear(0x7ED, &[0x3F, 0x4B, 0x02]),
    Step::Hear(0x7ED, &[0x3F, 0x4C]),
    Step::Hear(0x7ED, &[0x3F, 0x4C, 0x34, 0x12, 0x45, 0x23, 0x00, 0x00]),
    Step::Hear(0x7ED, &[0x25, 0x4D, 0x34, 0x12, 0x45, 0x23, 0x00, 0x00]),
    Step::Link(LinkEvent::Up),
    Step::Link(LinkEvent::Down),
    Step::Link(LinkEvent::BusOff),
    Step::Link(LinkEvent::BusError(BusErrorKind::Ack)),
    Step::Link(LinkEvent::Refused(LinkCommandKind::Reset)),
    Step::Link(LinkEvent::ModeSet(Mode { bit_rate: BitRate::K125, listen_only: false })),
    Step::Done(TxOutcome::Sent),
    Step::Done(TxOutcome::Withdrawn),
    Step::Done(TxOutcome::Dropped),
    Step::Deadline,
    Step::Reset,
    Step::SetMacId,
];

impl World {
    fn new(mut config: Config) -> Self {
        // Twice the delay of the Who response below, so that the two waits interleave in few ways.
        config.identify_timeout = 360;
        Self {
            node: Access::new(config),
            on_the_bus: false,
            restarting: false,
            in_flight: false,
            acknowledged: 0,
            seconds: 0,
        }
    }

    /// What follows from a step; `None` if it cannot happen now.
    fn step(&self, step: Step) -> Option<Self> {
        let mut next = self.clone();
        let mut now = self.node.timers.now();
        match step {
            Step::Hear(id, data) => {
                next.node.input(now, Input::Frame(Frame::new(standard_id(id), data)?));
            }
            Step::Link(event) => {
                match event {
                    LinkEvent::Up => next.on_the_bus = true,
                    LinkEvent::Down | LinkEvent::BusOff => next.on_the_bus = false,
                    _ => {}
                }
                next.restarting &= !matches!(event, LinkEvent::Up | LinkEvent::Refused(_));
                next.node.input(now, Input::Link(event));
            }
            Step::Done(TxOutcome::Sent) if !self.on_the_bus => return None,
            Step::Done(outcome) if self.in_flight => {
                next.in_flight = false;
                next.node.input(now, Input::TxDone(Access::TOKEN, outcome));
            }
            Step::Done(_) => return None,
            Step::Deadline => {
                now = self.node.deadline()?.at;
                next.node.input(now, Input::Tick);
            }
            Step::Reset => next.node.reset(now),
            Step::SetMacId => next.node.set_mac_id(now, mac(37)).unwrap(),
        }
        while let Some(action) = next.node.poll(now) {
            next.observe(action);
        }
        assert_ne!(next.node.deadline().map(|deadline| deadline.why), Some("output pending"));
        next.node.shift_time(now.saturating_since(link_core::Instant::ZERO));
        next.node.forget_counts();
        Some(next)
    }

    fn observe(&mut self, action: Action<AccessEvent>) {
        match action {
            Action::Transmit(_, frame) => {
                assert!(!self.in_flight, "two frames in flight");
                self.in_flight = true;
                let own = match self.node.state().kind() {
                    StateKind::SendingDupMac => frame.raw_id() == u32::from(CHECK) && frame.data() == REQUEST,
                    StateKind::OnLine => frame.raw_id() == u32::from(CHECK),
                    StateKind::CommFault => frame.raw_id() == 0x7EC,
                    StateKind::NonExistent | StateKind::WaitingDupMac => false,
                };
                assert!(own, "{frame} in {:?}", self.node.state());
            }
            Action::Withdraw(_) => assert!(self.in_flight, "nothing to withdraw"),
            Action::Event(AccessEvent::StateChanged { to, cause, .. }) => self.changed(to, cause),
            Action::Link(LinkCommand::Reset) => (self.on_the_bus, self.restarting) = (false, true),
            Action::Event(_) | Action::Link(_) => {}
        }
    }

    fn changed(&mut self, to: StateKind, cause: Cause) {
        match cause {
            Cause::RequestSent | Cause::QuickConnect => self.acknowledged += 1,
            Cause::WaitOver => self.seconds += 1,
            _ => (self.acknowledged, self.seconds) = (0, 0),
        }
        if to == StateKind::OnLine {
            let required = if self.node.config.quick_connect { (1, 0) } else { (2, 2) };
            assert_eq!((self.acknowledged, self.seconds), required, "on line too early");
            // Under Quick Connect the rest is done on line.
            (self.acknowledged, self.seconds) = (0, 0);
        }
    }
}

/// All worlds that can be reached.
fn explore(config: Config) -> Vec<World> {
    machine_laws::reachable(World::new(config), STEPS, World::step, 1_000).into_iter().collect()
}

fn configurations() -> Vec<Config> {
    let mut all = Vec::new();
    for bits in 0_u8..16 {
        let mut config = config();
        config.bus_off_interrupt = bits & 1 != 0;
        config.quick_connect = bits & 2 != 0;
        config.offline_set = bits & 4 != 0;
        if bits & 8 != 0 {
            config.bus_off_while_checking = BusOffWhileChecking::FollowInterrupt;
        }
        all.push(config);
    }
    all
}

/// No order of inputs breaks an assertion of [`World::step`], and from everywhere a way leads on line: with another node
/// on the bus and nobody who objects, after a reset, all it takes is power and a controller that comes back when told to.
#[test]
fn no_order_of_inputs_leads_astray() {
    for config in configurations() {
        for world in explore(config) {
            let mut next = world.step(Step::Reset).unwrap();
            for _ in 0..20 {
                if next.node.is_online() {
                    break;
                }
                let without_power = next.node.state().kind() == StateKind::NonExistent;
                let step = if without_power || next.restarting {
                    Step::Link(LinkEvent::Up)
                } else if next.in_flight {
                    Step::Done(if next.on_the_bus { TxOutcome::Sent } else { TxOutcome::Dropped })
                } else {
                    Step::Deadline
                };
                next = next.step(step).unwrap();
            }
            assert!(next.node.is_online(), "stuck: {world:?}");
        }
    }
}

/// The request counter is in the state, so it cannot disagree with it.
#[test]
fn waiting_for_the_second_time_means_two_acknowledged_requests() {
    for world in explore(config()) {
        match world.node.state() {
            State::WaitingDupMac { request: CheckRequest::First } => assert_eq!(world.acknowledged, 1),
            State::WaitingDupMac { request: CheckRequest::Second } => assert_eq!(world.acknowledged, 2),
            State::NonExistent
            | State::SendingDupMac { .. }
            | State::OnLine { .. }
            | State::CommFault { .. } => {}
        }
    }
}
