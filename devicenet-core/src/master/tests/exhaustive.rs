//! Every state that a master with one slave can get into, by every order of inputs.
//!
//! The real machine is explored, not a model of it: two machines that differ only in the time of day and in what they
//! counted are the same.

use core::time::Duration;
use std::collections::HashSet;
use std::vec::Vec;

use link_core::{Action, Frame, Input, Instant, LinkEvent, Machine, TxOutcome, TxToken};

use super::super::*;
use super::bus::{config, frame, mac, polled};
use crate::client::Waits;
use link_core::machine_laws;

type Scanner = Master<1, 16>;

/// A machine, and what the bus knows of it.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
struct World {
    master: Scanner,
    in_flight: Vec<(TxToken, Frame)>,
    /// The last request on the bus that has no answer.
    asked: Option<Frame>,
    /// The slave proved what it is since it was contacted.
    matched: bool,
}

#[derive(Clone, Copy, Debug)]
enum Step {
    Hear(&'static str),
    /// The answer to the last request.
    Answer(Answer),
    Link(LinkEvent),
    Done(u16, TxOutcome),
    Deadline,
    Restart,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Answer {
    Good,
    /// Another number than the scan list has.
    Other,
}

const STEPS: &[Step] = &[
    Step::Answer(Answer::Good),
    Step::Answer(Answer::Other),
    Step::Hear("3FF: 34 12"),
    Step::Link(LinkEvent::Up),
    Step::Link(LinkEvent::Down),
    Step::Done(0, TxOutcome::Sent),
    Step::Done(0x1002, TxOutcome::Sent),
    Step::Done(0x1003, TxOutcome::Sent),
    Step::Deadline,
    Step::Restart,
];

impl World {
    fn new() -> Self {
        // Few waits, of few lengths, so that they interleave in few ways.
        let waits = Waits { acknowledge: WAIT, response: WAIT, next_fragment: WAIT };
        let mut config = Config {
            connected: waits,
            unconnected: waits,
            interscan_delay: WAIT,
            response_wait: WAIT,
            retry_after: WAIT,
            retry_at_most: WAIT,
            tries: 1,
            deferred_delete: false,
            ..config()
        };
        config.node.access.offline_set = false;
        let mut master = Scanner::new(config);
        let poll = PollConnection { produce: 2, consume: 1, expected_packet_rate: 250 };
        let key = ElectronicKey { vendor: Some(0x03E7.into()), ..ElectronicKey::default() };
        master.add_slave(Instant::ZERO, ScanEntry { poll: Some(poll), key, ..polled() }).unwrap();
        master.set_run(true);
        let mut world = Self { master, in_flight: Vec::new(), asked: None, matched: false };
        world.settle(Instant::ZERO);
        world
    }

    /// What follows from a step; `None` if it cannot happen now.
    fn step(&self, step: Step) -> Option<Self> {
        let mut next = self.clone();
        let now = self.master.timers.now();
        match step {
            Step::Hear(text) => next.master.input(now, Input::Frame(frame(text))),
            Step::Answer(answer) => {
                let request = next.asked.take()?;
                let response = response_to(&request, answer)?;
                next.matched = match request.data() {
                    [_, 0x0E, 1, 1, 1] => answer == Answer::Good,
                    [_, 0x4B, 3, 1, 1, _] => false,
                    _ => self.matched,
                };
                next.master.input(now, Input::Frame(response));
            }
            Step::Link(event) => next.master.input(now, Input::Link(event)),
            Step::Done(token, outcome) => {
                let place = next.in_flight.iter().position(|(other, _)| other.0 == token)?;
                let (token, sent) = next.in_flight.remove(place);
                if token == TxToken(0x1003) && outcome == TxOutcome::Sent {
                    next.asked = Some(sent);
                }
                next.master.input(now, Input::TxDone(token, outcome));
            }
            Step::Deadline => next.master.input(self.master.deadline()?.at, Input::Tick),
            Step::Restart => next.master.restart_slave(now, mac(63)).ok()?,
        }
        next.settle(next.master.timers.now());
        Some(next)
    }

    fn settle(&mut self, now: Instant) {
        while let Some(action) = self.master.poll(now) {
            self.observe(action);
        }
        let deadline = self.master.deadline();
        assert_ne!(deadline.map(|deadline| deadline.why), Some("output pending"));
        let on_line = self.master.access().is_online();
        assert!(!on_line || deadline.is_some() || !self.in_flight.is_empty(), "stuck: {self:?}");
        let runs = self.master.state(mac(63)) == Some(SlaveState::Running);
        assert!(runs || self.master.input_data(mac(63), IoInstance::Poll).is_none(), "data of nobody");
        // What nobody waits for any more is not answered.
        if !self.master.board.get(&self.master.slots, mac(63)).unwrap().conversation.is_busy() {
            self.asked = None;
        }
        self.master.shift_time(now.saturating_since(Instant::ZERO));
        self.master.node.forget_counts();
        self.master.counters = Counters::default();
        self.master.cycle.number = 0;
        // Of interest only without an interscan delay.
        (self.master.cycle.given_way, self.master.cycle.unanswered) = (0, 0);
        self.master.cycle.explicit_given = self.master.cycle.explicit_given.min(1);
        for slot in self.master.board.all_mut(&mut self.master.slots) {
            slot.counters = SlaveCounters::default();
            slot.failures = 0;
            slot.status = ScannerStatus::NORMAL;
            slot.inputs[0].status = ScannerStatus::NORMAL;
        }
        self.in_flight.sort_by_key(|(token, _)| *token);
    }

    fn observe(&mut self, action: Action<MasterEvent>) {
        match action {
            Action::Transmit(token, frame) => {
                assert!(self.in_flight.iter().all(|(other, _)| *other != token), "{token:?} twice");
                self.in_flight.push((token, frame));
                assert!(self.in_flight.len() <= self.master.max_in_flight());
                if token >= TxToken(0x1001) {
                    assert!(self.master.access().is_online(), "{frame} off line");
                }
                if frame.raw_id() == 0x5FD {
                    assert!(self.matched, "outputs to the wrong device");
                    assert_eq!(self.master.state(mac(63)), Some(SlaveState::Running));
                }
            }
            Action::Withdraw(token) => {
                assert!(self.in_flight.iter().any(|(other, _)| *other == token), "nothing to withdraw");
            }
            Action::Event(_) | Action::Link(_) => {}
        }
    }

    /// A step that leads on: the port answers, the slave answers well, time passes.
    fn good_step(&self) -> Option<Self> {
        let done = self.in_flight.first().map(|(token, _)| Step::Done(token.0, TxOutcome::Sent));
        let no_power = self.master.deadline().is_none() && self.in_flight.is_empty();
        let steps = [done, no_power.then_some(Step::Link(LinkEvent::Up))].into_iter().flatten();
        let others = [Step::Answer(Answer::Good), Step::Deadline];
        steps.chain(others).find_map(|step| self.step(step))
    }
}

/// What slave 63 answers.
fn response_to(request: &Frame, answer: Answer) -> Option<Frame> {
    let (&header, body) = request.data().split_first()?;
    if request.raw_id() == 0x784 {
        return None;
    }
    let number = |good: u8, high| [if answer == Answer::Other { 0x77 } else { good }, high];
    let value: Vec<u8> = match body {
        [0x4B, ..] => [0].into(),
        [0x0E, 1, 1, 1] => number(0xE7, 0x03).into(),
        [0x0E, 5, 2, 7] => number(2, 0).into(),
        [0x0E, 5, 2, 8] => number(1, 0).into(),
        [0x10, 5, 2, 9, rate @ ..] => rate.into(),
        [0x0E, ..] => [0, 0].into(),
        _ => Vec::new(),
    };
    let data = [&[header, body[0] | 0x80][..], &value].concat();
    Frame::new(link_core::frame::standard_id(0x5FB), &data)
}

/// No order of inputs breaks an assertion, and from everywhere a slave that answers is brought up again.
#[test]
fn no_order_of_inputs_leads_astray() {
    let seen = machine_laws::reachable(World::new(), STEPS, World::step, 20_000);
    let mut leads_up = HashSet::new();
    for world in &seen {
        let mut way = std::vec![world.clone()];
        while let Some(last) = way.last() {
            let up = last.master.state(mac(63)) == Some(SlaveState::Running) && last.matched;
            if up || leads_up.contains(last) {
                break;
            }
            assert!(way.len() < 200, "never up: {world:?}");
            let next = last.good_step().unwrap_or_else(|| panic!("stuck: {last:?}"));
            way.push(next);
        }
        leads_up.extend(way);
    }
}

const WAIT: Duration = Duration::from_secs(1);
