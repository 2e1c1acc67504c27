//! A node without a protocol that keeps the contract: it says what it was given to say, when it was to be said, as long
//! as its controller takes part in the bus.

use std::convert::Infallible;

use core::time::Duration;

use link_core::{Action, Deadline, Frame, Input, Instant, LinkCommand, LinkEvent, Machine, TxToken};

/// A frame to be sent, and when it is given up.
#[derive(Clone, Copy, Debug)]
pub(super) struct Planned {
    pub(super) at: Instant,
    pub(super) frame: Frame,
    pub(super) given_up_after: Option<Duration>,
}

#[derive(Clone, Debug)]
pub(super) struct Talker {
    plan: Vec<Planned>,
    next: usize,
    /// For each frame in flight when it is given up; `None` when that was asked for, or will not be.
    in_flight: [Option<Option<Instant>>; MAILBOXES],
    restarts: bool,
    restart_due: bool,
    up: bool,
    now: Instant,
}

impl Talker {
    /// Sends the frames of `plan`, whose times do not decrease; comes back after bus-off if it `restarts`.
    pub(super) fn new(plan: Vec<Planned>, restarts: bool) -> Self {
        let (in_flight, now) = ([None; MAILBOXES], Instant::ZERO);
        Self { plan, next: 0, in_flight, restarts, restart_due: false, up: false, now }
    }

    fn free(&self) -> Option<usize> {
        self.in_flight.iter().position(Option::is_none).filter(|_| self.up)
    }

    fn withdraw(&mut self, now: Instant) -> Option<Action<Infallible>> {
        let over = |mail: &Option<Option<Instant>>| matches!(mail, Some(Some(at)) if *at <= now);
        let token = self.in_flight.iter().position(over)?;
        self.in_flight[token] = Some(None);
        Some(Action::Withdraw(TxToken(token as u16)))
    }

    fn transmit(&mut self, now: Instant) -> Option<Action<Infallible>> {
        let token = self.free()?;
        let planned = self.plan.get(self.next).filter(|planned| planned.at <= now)?;
        self.next += 1;
        self.in_flight[token] = Some(planned.given_up_after.map(|span| now + span));
        Some(Action::Transmit(TxToken(token as u16), planned.frame))
    }
}

impl Machine for Talker {
    type Event = Infallible;

    fn input(&mut self, now: Instant, input: Input) {
        self.now = self.now.max(now);
        match input {
            Input::Link(LinkEvent::Up) => self.up = true,
            Input::Link(LinkEvent::Down) => (self.up, self.restart_due) = (false, false),
            Input::Link(LinkEvent::BusOff) => (self.up, self.restart_due) = (false, self.restarts),
            Input::TxDone(token, _) => {
                let mail = self.in_flight[usize::from(token.0)].take();
                assert!(mail.is_some(), "a frame that was not in flight is done");
            }
            Input::Link(_) | Input::Frame(_) | Input::Tick => {}
        }
    }

    fn poll(&mut self, now: Instant) -> Option<Action<Infallible>> {
        self.now = self.now.max(now);
        if std::mem::take(&mut self.restart_due) {
            return Some(Action::Link(LinkCommand::Reset));
        }
        self.withdraw(now).or_else(|| self.transmit(now))
    }

    fn deadline(&self) -> Option<Deadline> {
        if self.restart_due {
            return Some(Deadline::now(self.now));
        }
        let next = self.free().and_then(|_| self.plan.get(self.next)).map(|planned| planned.at);
        let given_up = self.in_flight.iter().flatten().flatten().copied();
        given_up.chain(next).min().map(|at| Deadline { at, why: "next frame" })
    }

    fn max_in_flight(&self) -> usize {
        MAILBOXES
    }
}

const MAILBOXES: usize = 3;
