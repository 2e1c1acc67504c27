//! The offline recovery tool, against the rules of the offline connection set.
//!
//! Other tools, faulted nodes, the controller and the application do what they like. After each operation:
//!
//! - the set is owned only after two requests that were on the bus, each with its second without an answer;
//! - only the owner talks to faulted nodes, one message at a time, and never gives away its own MAC ID;
//! - an ownership response answers a request of another tool, and comes from a tool that asked before it;
//! - off line only network access sends, and no token is used twice;
//! - nothing is pending after a drain, a second tick changes nothing, and no task waits for nothing.

mod ops;

use core::time::Duration;
use std::collections::BTreeMap;

use arbitrary::Unstructured;
use cip_core::code::VendorId;
use devicenet_core::access::{self, Access};
use devicenet_core::message::{DelayOffset, DeviceIdentity, NodeSelection, PortNumber};
use devicenet_core::tool::{Config, OfflineTool, ToolEvent, ToolState};
use devicenet_core::{Identifier, MacId};
use link_core::{Action, Frame, Input, Instant, Machine, TxOutcome, TxToken};

use ops::Op;

/// Does to a tool what the bytes say.
pub fn run(data: &[u8]) {
    let mut input = Unstructured::new(data);
    let mut bus = Bus::new();
    while !input.is_empty() {
        let Ok(op) = ops::op(&mut input) else { return };
        bus.apply(op);
    }
}

struct Bus {
    tool: OfflineTool,
    clock: Instant,
    in_flight: BTreeMap<u16, Frame>,
    /// The frame of the tool that is in flight belongs to a claim that was given up.
    stale: bool,
    /// Since the claim: requests that were on the bus, and when the last was.
    asked: Vec<Instant>,
    /// Another tool asked since the last response.
    owed: bool,
    /// A task of the owner was begun and is not over.
    busy: bool,
}

impl Bus {
    fn new() -> Self {
        Self {
            tool: OfflineTool::new(Config::new(access::Config::new(TOOL, PortNumber::ZERO, mac(OWN)))),
            clock: Instant::ZERO,
            in_flight: BTreeMap::new(),
            stale: false,
            asked: Vec::new(),
            owed: false,
            busy: false,
        }
    }

    fn apply(&mut self, op: Op) {
        let now = self.clock;
        match op {
            Op::Tick(span) => self.input(now + span, Input::Tick),
            Op::TickInThePast(span) => self.input(now.saturating_sub(span), Input::Tick),
            Op::TickAtDeadline => {
                if let Some(deadline) = self.tool.deadline() {
                    self.input(deadline.at, Input::Tick);
                }
            }
            Op::Frame(frame) => self.frame(frame),
            Op::Ownership(which) => {
                let (id, service) = if which & 1 == 0 { (0x7EF, 0x4B) } else { (0x7EE, 0xCB) };
                self.frame(standard(id, &[1, service, 6, 0, 8, 7, 6, 5]));
            }
            Op::Answer(how) => {
                let answers: [&[u8]; 3] = [&[0, 6, 0, 8, 7, 6, 5], &[0x7F, 0xCC], &[how]];
                self.frame(standard(0x7EC, answers[usize::from(how) % 3]));
            }
            Op::Check { which, head } => {
                let node = if which & 1 == 0 { mac(3) } else { self.tool.access().mac_id() };
                let serial = if which & 2 == 0 { 8 } else { 9 };
                let check = [head, 6, 0, serial, 7, 6, 5];
                self.frame(Identifier::duplicate_mac_check(node).frame(&check).expect("seven bytes"));
            }
            Op::Sent(which) => self.tx_done(which, TxOutcome::Sent),
            Op::GivenBack(which) => self.tx_done(which, TxOutcome::Dropped),
            Op::Link(event) => self.input(now, Input::Link(event)),
            Op::Command(which) => self.command(which),
        }
    }

    fn command(&mut self, which: u8) {
        let now = self.clock;
        let begun = match which % 8 {
            0 | 1 => {
                _ = self.tool.claim(now);
                false
            }
            2 => {
                self.tool.release(now);
                false
            }
            3 => self.tool.who(now, DelayOffset::SERIAL).is_ok(),
            4 => self.tool.identify(now, NodeSelection::ALL).is_ok(),
            5 => self.tool.identify_device(now, DEVICE).is_ok(),
            6 => {
                let given = if which & 0x80 == 0 { mac(3) } else { self.tool.access().mac_id() };
                let begun = self.tool.change_mac_id(now, DEVICE, given).is_ok();
                assert!(!begun || given == mac(3), "the own MAC ID is given away");
                begun
            }
            _ => {
                self.tool.reset(now);
                false
            }
        };
        if begun {
            assert!(!self.busy, "two tasks at once");
            assert_eq!(self.tool.state(), ToolState::Owner);
            self.busy = true;
        }
        self.drain(now);
    }

    fn frame(&mut self, frame: Frame) {
        if frame == standard(frame.raw_id() as u16, frame.data()) && frame.raw_id() == 0x7EF {
            self.owed |= !self.asked.is_empty();
        }
        self.input(self.clock, Input::Frame(frame));
    }

    fn input(&mut self, now: Instant, input: Input) {
        self.clock = self.clock.max(now);
        self.tool.input(now, input);
        self.drain(now);
        let mut ticked = self.tool.clone();
        ticked.input(now, Input::Tick);
        assert_eq!(ticked, self.tool, "a second tick changes nothing");
    }

    fn tx_done(&mut self, which: u8, outcome: TxOutcome) {
        let tokens: Vec<u16> = self.in_flight.keys().copied().collect();
        let Some(&token) = tokens.get(usize::from(which) % tokens.len().max(1)) else { return };
        let frame = self.in_flight.remove(&token).expect("it is in flight");
        if outcome == TxOutcome::Sent && frame.raw_id() == 0x7EF && !self.stale {
            self.asked.push(self.clock);
        }
        self.input(self.clock, Input::TxDone(TxToken(token), outcome));
    }

    fn drain(&mut self, now: Instant) {
        let mut actions = 0;
        while let Some(action) = self.tool.poll(now) {
            self.observe(action);
            actions += 1;
            assert!(actions < 40, "the drain does not end");
        }
        if self.tool.state() == ToolState::Idle {
            self.asked.clear();
            (self.owed, self.busy, self.stale) = (false, false, !self.in_flight.is_empty());
        }
        let deadline = self.tool.deadline();
        assert_ne!(deadline.map(|deadline| deadline.why), Some("output pending"));
        let waits = deadline.is_some() || !self.in_flight.is_empty();
        assert!(waits || !self.busy && self.tool.state() != ToolState::Claiming, "stuck");
    }

    fn observe(&mut self, action: Action<ToolEvent>) {
        match action {
            Action::Transmit(TxToken(token), frame) => {
                assert!(self.in_flight.insert(token, frame).is_none(), "{frame}: token {token} twice");
                assert!(self.in_flight.len() <= self.tool.max_in_flight());
                if TxToken(token) == Access::TOKEN {
                    return;
                }
                assert!(self.tool.access().is_online(), "{frame} off line");
                self.stale = false;
                match frame.raw_id() {
                    0x7EF => assert_eq!(self.tool.state(), ToolState::Claiming, "{frame}"),
                    0x7EE => assert!(core::mem::take(&mut self.owed), "{frame}: nobody asked"),
                    0x7ED => {
                        assert_eq!(self.tool.state(), ToolState::Owner, "{frame}");
                        assert!(self.busy, "{frame}: nobody wants it");
                    }
                    _ => panic!("{frame}: not of the offline connection set"),
                }
            }
            Action::Withdraw(TxToken(token)) => {
                assert!(self.in_flight.contains_key(&token), "nothing to withdraw");
            }
            Action::Event(ToolEvent::StateChanged { to: ToolState::Owner, .. }) => {
                let [.., first, second] = self.asked[..] else { panic!("owner after {:?}", self.asked) };
                let waits = [second.saturating_since(first), self.clock.saturating_since(second)];
                assert!(waits.iter().all(|wait| *wait >= SECOND), "owner after {waits:?}");
            }
            Action::Event(
                ToolEvent::WhoDone { .. }
                | ToolEvent::IdentifyDone { .. }
                | ToolEvent::Recovered { .. }
                | ToolEvent::NotRecovered { .. },
            ) => self.busy = false,
            Action::Event(ToolEvent::EventsLost(_)) => panic!("events are fetched after each input"),
            Action::Event(_) | Action::Link(_) => {}
        }
    }
}

fn standard(id: u16, data: &[u8]) -> Frame {
    Frame::new(link_core::frame::standard_id(id), data).expect("at most eight bytes")
}

fn mac(number: u8) -> MacId {
    MacId::new(number).expect("below 64")
}

const OWN: u8 = 5;
const TOOL: DeviceIdentity = DeviceIdentity { vendor: VendorId(0x1234), serial: 0x0A05_0301 };
const DEVICE: DeviceIdentity = DeviceIdentity { vendor: VendorId(6), serial: 0x0506_0708 };
const SECOND: Duration = Duration::from_secs(1);

#[cfg(test)]
mod tests {
    use super::*;

    /// Without this the oracle would have nothing to judge.
    #[test]
    fn a_tool_that_nobody_answers_owns_the_set() {
        let mut bus = Bus::new();
        bus.apply(Op::Link(link_core::LinkEvent::Up));
        for command in [None, Some(Op::Command(0))] {
            if let Some(command) = command {
                bus.apply(command);
            }
            for _ in 0..2 {
                bus.apply(Op::Sent(0));
                bus.apply(Op::TickAtDeadline);
            }
        }
        assert_eq!(bus.tool.state(), ToolState::Owner);
        bus.apply(Op::Command(3));
        assert!(bus.busy);
        bus.apply(Op::Sent(0));
        bus.apply(Op::Answer(0));
        bus.apply(Op::TickAtDeadline);
        assert!(!bus.busy, "the answers were waited for");
    }

    #[test]
    #[should_panic(expected = "nobody asked")]
    fn an_answer_that_nobody_asked_for_is_found() {
        let frame = standard(0x7EE, &[5, 0xCB, 0, 0, 0, 0, 0, 0]);
        let mut bus = Bus::new();
        bus.apply(Op::Link(link_core::LinkEvent::Up));
        for _ in 0..2 {
            bus.apply(Op::Sent(0));
            bus.apply(Op::TickAtDeadline);
        }
        bus.observe(Action::Transmit(TxToken(1), frame));
    }
}
