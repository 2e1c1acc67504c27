//! The tool machine.

use core::time::Duration;

use heapless::Vec;
use link_core::timers::TimerKey;
use link_core::{Action, Deadline, FilterSet, Input, Instant, Machine, Timers};

use super::config::Config;
use super::event::{Counters, ToolEvent};
use super::output::TOKEN;
use super::state::{Cause, EDGES, Sending, State, Task};
use crate::access::Access;
use crate::id;

/// A tool that finds and repairs faulted nodes; see the [module](super) text.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct OfflineTool {
    pub(super) config: Config,
    pub(super) access: Access,
    pub(super) on_line: bool,
    pub(super) state: State,
    /// Another tool asked, and is to be answered.
    pub(super) response_due: bool,
    pub(super) in_flight: Option<Outgoing>,
    pub(super) withdraw: bool,
    pub(super) filter_due: bool,
    pub(super) found: u16,
    pub(super) timers: Timers<Timer, 1>,
    pub(super) counters: Counters,
    pub(super) events: Vec<ToolEvent, EVENTS>,
    pub(super) events_lost: u16,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Outgoing {
    OwnershipResponse,
    Message,
    /// The message, taken back after a collision: unless it turns out to have been sent, it is sent again.
    BackedOff,
    /// What is not wanted any more.
    Abandoned,
}

/// The one wait of a tool: it does one thing at a time.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Timer {
    Answers,
}

impl TimerKey<1> for Timer {
    const ALL: [Self; 1] = [Self::Answers];
    const WHY: [&'static str; 1] = ["answers of faulted nodes or of the owner"];

    fn index(self) -> usize {
        0
    }
}

impl Machine for OfflineTool {
    type Event = ToolEvent;

    fn input(&mut self, now: Instant, input: Input) {
        let now = self.timers.advance(now);
        // A wait that ended before this moment ended before this input; one that ends now ends after it.
        self.expire(now.saturating_sub(Duration::from_nanos(1)));
        match input {
            Input::TxDone(TOKEN, outcome) => {
                self.access.input(now, Input::Tick);
                self.tx_done(outcome);
            }
            Input::Frame(frame) => {
                self.access.input(now, input);
                self.follow_access();
                self.frame(&frame);
            }
            Input::Link(event) => {
                self.access.input(now, input);
                self.link(event);
            }
            Input::TxDone(..) | Input::Tick => self.access.input(now, input),
        }
        self.follow_access();
        self.expire(now);
    }

    fn poll(&mut self, now: Instant) -> Option<Action<ToolEvent>> {
        self.timers.advance(now);
        if core::mem::take(&mut self.withdraw) {
            return Some(Action::Withdraw(TOKEN));
        }
        self.poll_access(now)
            .or_else(|| self.set_filter())
            .or_else(|| self.event())
            .or_else(|| self.transmit())
    }

    fn deadline(&self) -> Option<Deadline> {
        let output = self.withdraw
            || self.filter_due
            || self.events_lost != 0
            || !self.events.is_empty()
            || self.wanted().is_some();
        if output {
            return Some(Deadline::now(self.timers.now()));
        }
        let access = self.access.deadline();
        self.timers.next().into_iter().chain(access).min_by_key(|deadline| deadline.at)
    }

    fn max_in_flight(&self) -> usize {
        Self::MAX_IN_FLIGHT
    }
}

impl OfflineTool {
    /// What [`max_in_flight`](link_core::Machine::max_in_flight) returns, for the size of a port.
    pub const MAX_IN_FLIGHT: usize = Access::MAX_IN_FLIGHT.saturating_add(1);

    /// A tool without power: the first [`LinkEvent::Up`](link_core::LinkEvent::Up) starts it.
    #[must_use]
    pub fn new(config: Config) -> Self {
        Self {
            access: Access::new(config.access.clone()),
            on_line: false,
            state: State::Idle,
            response_due: false,
            in_flight: None,
            withdraw: false,
            filter_due: false,
            found: 0,
            timers: Timers::new(),
            counters: Counters::default(),
            events: Vec::new(),
            events_lost: 0,
            config,
        }
    }

    /// What it must hear: duplicate MAC ID checks of everybody, the answers of faulted nodes, and other tools.
    #[must_use]
    pub fn filter(&self) -> FilterSet {
        let mut filters = id::offline_owner();
        filters.add(id::duplicate_mac_checks());
        // A tool that is faulted itself can be repaired by another.
        filters.extend(self.access.filter().as_slice().iter().copied());
        filters
    }

    /// The one door between states.
    pub(super) fn enter(&mut self, next: State, cause: Cause) {
        let (from, to) = (self.state.kind(), next.kind());
        debug_assert!(
            EDGES.iter().any(|edge| (edge.from, edge.cause, edge.to) == (from, cause, to)),
            "{from} -> {to}: {cause} is not in the table"
        );
        #[cfg(test)]
        super::tests::edges::record(from, cause, to);
        self.timers.clear_all();
        if next == State::Idle {
            self.response_due = false;
            self.abandon();
        }
        self.state = next;
        self.raise(ToolEvent::StateChanged { from, to, cause });
    }

    /// The owner turns to something else.
    pub(super) fn turn_to(&mut self, task: Task) {
        self.timers.clear_all();
        self.found = 0;
        self.state = State::Owner { task, sending: Sending::Due };
        // Another tool is answered all the same.
        if self.in_flight != Some(Outgoing::OwnershipResponse) {
            self.abandon();
        }
    }

    fn abandon(&mut self) {
        match self.in_flight {
            Some(Outgoing::OwnershipResponse | Outgoing::Message) => self.withdraw = true,
            Some(Outgoing::BackedOff) => {}
            Some(Outgoing::Abandoned) | None => return,
        }
        self.in_flight = Some(Outgoing::Abandoned);
    }

    pub(super) fn follow_access(&mut self) {
        let on_line = self.access.is_online();
        if on_line == self.on_line {
            return;
        }
        self.on_line = on_line;
        self.filter_due |= on_line;
        if !on_line && self.state != State::Idle {
            self.enter(State::Idle, Cause::OffLine);
        }
    }

    pub(super) fn raise(&mut self, event: ToolEvent) {
        if self.events.push(event).is_err() {
            self.events_lost = self.events_lost.saturating_add(1);
            self.counters.events_lost = self.counters.events_lost.saturating_add(1);
        }
    }
}

const EVENTS: usize = 8;
