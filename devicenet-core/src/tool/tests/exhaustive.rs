//! Every state that the tool can get into, by every order of inputs.
//!
//! The real machine is explored, not a model of it: two machines that differ only in the time of day and in what they
//! counted are the same.

use core::time::Duration;

use link_core::{Action, BusErrorKind, Input, Instant, LinkEvent, Machine, TxOutcome, TxToken};

use super::super::event::Counters;
use super::super::state::{State, Task};
use super::super::{OfflineTool, ToolEvent, ToolState};
use super::bus::*;
use crate::access::Access;
use crate::message::{DelayOffset, NodeSelection};
use link_core::machine_laws;

/// A machine, and what the bus knows of it.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
struct World {
    tool: OfflineTool,
    /// The frame of the offline connection set that is in flight.
    in_flight: Option<link_core::Frame>,
    /// It belongs to a claim that was given up.
    stale: bool,
    /// The requests that were on the bus since the tool claimed, and the time since the last.
    asked: u8,
    silence: Duration,
    /// Another tool asked, and is owed an answer.
    owed: bool,
}

#[derive(Clone, Copy, Debug)]
enum Step {
    Hear(&'static str),
    Link(LinkEvent),
    Done(TxOutcome),
    /// The frame of network access was sent.
    Checked,
    Deadline,
    Claim,
    Release,
    Who,
    Identify,
    ChangeMacId,
}

const STEPS: &[Step] = &[
    Step::Hear("7EF: 01 4B 06 00 08 07 06 05"),
    Step::Hear("7EE: 01 CB 06 00 08 07 06 05"),
    Step::Hear("7EC: 00 06 00 08 07 06 05"),
    Step::Hear("7EC: 7F CC"),
    Step::Hear("7EC: 7F"),
    Step::Hear("41F: 00 06 00 08 07 06 05"),
    Step::Hear("41F: 80 34 12 99 99 00 00"),
    Step::Hear("42F: 80 34 12 99 99 00 00"),
    Step::Link(LinkEvent::Up),
    Step::Link(LinkEvent::Down),
    Step::Link(LinkEvent::BusOff),
    Step::Link(LinkEvent::BusError(BusErrorKind::Bit)),
    Step::Done(TxOutcome::Sent),
    Step::Done(TxOutcome::Withdrawn),
    Step::Done(TxOutcome::Dropped),
    Step::Checked,
    Step::Deadline,
    Step::Claim,
    Step::Release,
    Step::Who,
    Step::Identify,
    Step::ChangeMacId,
];

impl World {
    fn new() -> Self {
        let mut config = config();
        // Few ways for the waits to interleave.
        config.who_wait = config.ownership_wait;
        config.change_wait = config.ownership_wait;
        config.access.offline_set = false;
        let bus = Bus::online_as(config);
        let mut world = Self {
            tool: bus.tool,
            in_flight: None,
            stale: false,
            asked: 0,
            silence: Duration::ZERO,
            owed: false,
        };
        world.settle(bus.now);
        world
    }

    /// What follows from a step; `None` if it cannot happen now.
    fn step(&self, step: Step) -> Option<Self> {
        let mut next = self.clone();
        let now = self.tool.timers.now();
        match step {
            Step::Hear(text) => {
                let claims = text.starts_with("7EF") && self.tool.access().is_online();
                next.owed |= claims && self.asked != 0;
                next.tool.input(now, Input::Frame(frame(text)));
            }
            Step::Link(event) => next.tool.input(now, Input::Link(event)),
            Step::Done(outcome) => {
                let sent = next.in_flight.take()?;
                if outcome == TxOutcome::Sent && sent.raw_id() == 0x7EF && !self.stale {
                    (next.asked, next.silence) = (next.asked.saturating_add(1).min(2), Duration::ZERO);
                }
                next.tool.input(now, Input::TxDone(TxToken(1), outcome));
            }
            Step::Checked => next.tool.input(now, Input::TxDone(Access::TOKEN, TxOutcome::Sent)),
            Step::Deadline => {
                let at = self.tool.deadline()?.at;
                next.silence = next.silence.saturating_add(at.saturating_since(now)).min(next.wait());
                next.tool.input(at, Input::Tick);
            }
            Step::Claim => next.tool.claim(now).ok()?,
            Step::Release => next.tool.release(now),
            Step::Who => next.tool.who(now, DelayOffset::SERIAL).ok()?,
            Step::Identify => next.tool.identify(now, NodeSelection::MacId(mac(63))).ok()?,
            Step::ChangeMacId => next.tool.change_mac_id(now, DEVICE, mac(3)).ok()?,
        }
        next.settle(next.tool.timers.now());
        Some(next)
    }

    fn wait(&self) -> Duration {
        self.tool.config.ownership_wait
    }

    fn settle(&mut self, now: Instant) {
        while let Some(action) = self.tool.poll(now) {
            self.observe(action);
        }
        if self.tool.state() == ToolState::Idle {
            (self.asked, self.silence, self.owed) = (0, Duration::ZERO, false);
            self.stale = self.in_flight.is_some();
        }
        let deadline = self.tool.deadline();
        assert_ne!(deadline.map(|deadline| deadline.why), Some("output pending"));
        let busy = self.tool.state.sending().is_some();
        assert!(!busy || deadline.is_some() || self.in_flight.is_some(), "stuck: {self:?}");
        self.tool.shift_time(now.saturating_since(Instant::ZERO));
        self.tool.counters = Counters::default();
        self.tool.found = self.tool.found.min(1);
        if let State::Owner { task: Task::ChangeMacId { checks, .. }, .. } = &mut self.tool.state {
            *checks = (*checks).min(2);
        }
        self.tool.access.forget_counts();
    }

    fn observe(&mut self, action: Action<ToolEvent>) {
        let on_line = self.tool.access().is_online();
        match action {
            Action::Transmit(TxToken(1), frame) => {
                assert!(self.in_flight.is_none(), "two frames in flight");
                assert!(on_line, "{frame} off line");
                match frame.raw_id() {
                    0x7EF => assert_eq!(self.tool.state(), ToolState::Claiming),
                    0x7EE => {
                        assert!(self.owed, "an answer that nobody asked for");
                        self.owed = false;
                    }
                    _ => assert_eq!(self.tool.state(), ToolState::Owner, "{frame} without the set"),
                }
                (self.in_flight, self.stale) = (Some(frame), false);
            }
            Action::Withdraw(TxToken(1)) => assert!(self.in_flight.is_some(), "nothing to withdraw"),
            Action::Event(ToolEvent::StateChanged { to, .. }) => match to {
                ToolState::Idle => {}
                ToolState::Claiming => assert!(on_line),
                ToolState::Owner => {
                    assert_eq!((self.asked, self.silence), (2, self.wait()), "the set is owned too early");
                }
            },
            Action::Transmit(..) | Action::Withdraw(_) | Action::Event(_) | Action::Link(_) => {}
        }
    }
}

/// No order of inputs breaks an assertion, and every conversation ends: with nothing but answers of the port and time,
/// the tool waits for commands.
#[test]
fn no_order_of_inputs_leads_astray() {
    let seen = machine_laws::reachable(World::new(), STEPS, World::step, 20_000);
    for world in &seen {
        let mut next = world.clone();
        for _ in 0..12 {
            let step = if next.in_flight.is_some() { Step::Done(TxOutcome::Sent) } else { Step::Deadline };
            let Some(following) = next.step(step) else { break };
            next = following;
        }
        assert!(next.tool.state.sending().is_none(), "a task that never ends: {world:?}");
    }
}
