//! The tool machine.

use core::time::Duration;

use heapless::Vec;
use link_core::timers::TimerKey;
use link_core::{
    Action, Deadline, FilterSet, Frame, Input, Instant, LinkCommand, LinkEvent, Machine, Timers, TxOutcome,
    TxToken,
};

use super::config::Config;
use super::event::{Counters, Refusal, ToolEvent};
use super::state::{Cause, EDGES, Request, Sending, State, Task};
use crate::access::Access;
use crate::collision;
use crate::id::{self, Identifier};
use crate::message::{
    self, ChangeMacIdRequest, CommunicationFaultedResponse, DeviceIdentity, Direction, DuplicateMacCheck,
    IdentifyDeviceRequest, IdentifyRequest, NodeSelection, OfflineOwnership, WhoRequest, Wire,
};

/// A tool that finds and repairs faulted nodes; see the [module](super) text.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct OfflineTool {
    pub(super) config: Config,
    pub(super) access: Access,
    on_line: bool,
    pub(super) state: State,
    /// Another tool asked, and is to be answered.
    response_due: bool,
    in_flight: Option<Outgoing>,
    withdraw: bool,
    filter_due: bool,
    pub(super) found: u16,
    pub(super) timers: Timers<Timer, 1>,
    pub(super) counters: Counters,
    events: Vec<ToolEvent, EVENTS>,
    events_lost: u16,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
enum Outgoing {
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

    fn index(self) -> usize {
        0
    }

    fn why(self) -> &'static str {
        "answers of faulted nodes or of the owner"
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
        self.access.max_in_flight().saturating_add(1)
    }
}

impl OfflineTool {
    /// A tool without power: the first [`LinkEvent::Up`] starts it.
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
        for filter in self.access.filter().as_slice() {
            filters.add(*filter);
        }
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

    fn frame(&mut self, frame: &Frame) {
        let Some(id) = Identifier::of_frame(frame) else { return };
        if !self.on_line {
            return;
        }
        match id {
            Identifier::OFFLINE_OWNERSHIP_REQUEST => self.ownership_request(frame.data()),
            Identifier::OFFLINE_OWNERSHIP_RESPONSE => self.ownership_response(),
            Identifier::COMMUNICATION_FAULTED_RESPONSE => self.answer(frame.data()),
            _ => self.check(id, frame.data()),
        }
    }

    /// The owner answers; so does a tool whose own first request was on the bus before: of two that claim at once, the
    /// bus decides.
    fn ownership_request(&mut self, data: &[u8]) {
        let other = OfflineOwnership::parse(data).ok().filter(|other| other.direction == Direction::Request);
        if other.is_none() {
            return self.bad_frame();
        }
        let defends = match self.state {
            State::Idle | State::Claiming { request: Request::First, sending: Sending::Due } => false,
            State::Claiming { request: Request::First, sending } => sending == Sending::Sent,
            State::Claiming { request: Request::Second, .. } | State::Owner { .. } => true,
        };
        if defends {
            self.response_due = true;
            self.counters.defended = self.counters.defended.saturating_add(1);
            self.raise(ToolEvent::Defended { by: other.map(|other| other.device) });
        }
    }

    /// Whatever it says: somebody else thinks that the set is his.
    fn ownership_response(&mut self) {
        match self.state {
            State::Idle => self.ignore(),
            State::Claiming { .. } | State::Owner { .. } => self.enter(State::Idle, Cause::OwnedByAnother),
        }
    }

    fn answer(&mut self, data: &[u8]) {
        let State::Owner { task, .. } = self.state else { return self.ignore() };
        let Ok(answer) = CommunicationFaultedResponse::parse(data) else { return self.bad_frame() };
        match (answer, task) {
            (CommunicationFaultedResponse::Who(answer), Task::Who(_)) => {
                self.found = self.found.saturating_add(1);
                self.counters.answers = self.counters.answers.saturating_add(1);
                self.raise(ToolEvent::Found(answer));
            }
            (CommunicationFaultedResponse::Identify(answer), Task::Identify(_) | Task::IdentifyDevice(_)) => {
                self.found = self.found.saturating_add(1);
                self.counters.answers = self.counters.answers.saturating_add(1);
                self.raise(ToolEvent::Identified(answer.nodes));
            }
            (CommunicationFaultedResponse::Who(_) | CommunicationFaultedResponse::Identify(_), _) => {
                self.ignore()
            }
        }
    }

    /// The device that was given a MAC ID checks it, twice, and is on line a second later; unless somebody objects.
    fn check(&mut self, id: Identifier, data: &[u8]) {
        let State::Owner { task: Task::ChangeMacId { device, mac, checks }, .. } = &mut self.state else {
            return;
        };
        if id != Identifier::duplicate_mac_check(*mac) {
            return;
        }
        let Ok(check) = DuplicateMacCheck::parse(data) else { return };
        let (device, mac) = (*device, *mac);
        match check.direction {
            Direction::Request if check.device == device => {
                *checks = checks.saturating_add(1);
                let request = *checks;
                self.timers.set_after(Timer::Answers, AFTER_CHECK);
                self.raise(ToolEvent::Checking { device, mac, request });
            }
            Direction::Response if check.device != device => {
                self.turn_to(Task::None);
                self.raise(ToolEvent::NotRecovered { device, mac, why: Refusal::Taken });
            }
            Direction::Request | Direction::Response => {}
        }
    }

    fn link(&mut self, event: LinkEvent) {
        match event {
            // The controller repeats a frame by itself; two that repeat the same identifier with other data never end.
            LinkEvent::BusError(_)
                if collision::is_collision(event) && self.in_flight == Some(Outgoing::Message) =>
            {
                self.in_flight = Some(Outgoing::BackedOff);
                self.withdraw = true;
                self.back_off(collision::pause(self.access.mac_id(), self.counters.collisions));
                self.counters.collisions = self.counters.collisions.saturating_add(1);
                self.raise(ToolEvent::Collision);
            }
            LinkEvent::Up => self.filter_due = true,
            LinkEvent::Down
            | LinkEvent::BusOff
            | LinkEvent::ErrorWarning
            | LinkEvent::ErrorPassive
            | LinkEvent::ErrorActive
            | LinkEvent::BusError(_)
            | LinkEvent::Counters { .. }
            | LinkEvent::Overrun { .. }
            | LinkEvent::ModeSet(_)
            | LinkEvent::FilterSet
            | LinkEvent::Refused(_) => {}
        }
    }

    /// The message is due again after `pause`.
    fn back_off(&mut self, pause: Duration) {
        if let Some(sending) = self.state.sending_mut() {
            *sending = Sending::BackingOff;
            self.timers.set_after(Timer::Answers, pause);
        }
    }

    fn tx_done(&mut self, outcome: TxOutcome) {
        let Some(what) = self.in_flight.take() else {
            self.counters.stray_tx_done = self.counters.stray_tx_done.saturating_add(1);
            return;
        };
        self.withdraw = false;
        match (what, outcome) {
            (Outgoing::Abandoned, _) | (Outgoing::OwnershipResponse, TxOutcome::Sent) => {}
            (Outgoing::Message | Outgoing::BackedOff, TxOutcome::Sent) => self.message_sent(),
            (Outgoing::BackedOff, TxOutcome::Withdrawn | TxOutcome::Dropped) => {}
            // A set that nobody was asked for would have two owners.
            (Outgoing::Message, TxOutcome::Withdrawn | TxOutcome::Dropped) => {
                self.counters.not_sent = self.counters.not_sent.saturating_add(1);
                self.back_off(GIVEN_BACK);
            }
            // The other tool asks a second time.
            (Outgoing::OwnershipResponse, TxOutcome::Withdrawn | TxOutcome::Dropped) => {
                self.counters.not_sent = self.counters.not_sent.saturating_add(1);
            }
        }
    }

    fn message_sent(&mut self) {
        let wait = self.wait();
        // Its consequences may have been heard already.
        if let Some(sending @ (Sending::HandedOut | Sending::BackingOff | Sending::Due)) =
            self.state.sending_mut()
        {
            *sending = Sending::Sent;
            self.timers.set_after(Timer::Answers, wait);
        }
    }

    /// How long the consequences of the present message may take.
    fn wait(&self) -> Duration {
        match self.state {
            State::Idle | State::Claiming { .. } => self.config.ownership_wait,
            State::Owner { task, .. } => match task {
                Task::None | Task::Who(_) => self.config.who_wait,
                Task::Identify(_) | Task::IdentifyDevice(_) => self.config.identify_wait,
                Task::ChangeMacId { .. } => self.config.change_wait,
            },
        }
    }

    fn expire(&mut self, until: Instant) {
        while self.timers.take_expired(until).is_some() {
            self.wait_over();
        }
    }

    fn wait_over(&mut self) {
        match self.state {
            State::Idle => {}
            State::Claiming { sending: Sending::Sent, request: Request::First } => {
                let next = State::Claiming { request: Request::Second, sending: Sending::Due };
                self.enter(next, Cause::WaitOver);
            }
            State::Claiming { sending: Sending::Sent, request: Request::Second } => {
                self.enter(State::Owner { task: Task::None, sending: Sending::Sent }, Cause::Unanswered);
            }
            State::Owner { task, sending: Sending::Sent } => self.task_over(task),
            State::Claiming { .. } | State::Owner { .. } => {
                if let Some(sending @ Sending::BackingOff) = self.state.sending_mut() {
                    *sending = Sending::Due;
                }
            }
        }
    }

    fn task_over(&mut self, task: Task) {
        let found = self.found;
        self.turn_to(Task::None);
        match task {
            Task::None => {}
            Task::Who(_) => self.raise(ToolEvent::WhoDone { found }),
            Task::Identify(_) | Task::IdentifyDevice(_) => {
                self.raise(ToolEvent::IdentifyDone { answered: found != 0 });
            }
            Task::ChangeMacId { device, mac, checks: 2.. } => {
                self.raise(ToolEvent::Recovered { device, mac });
            }
            Task::ChangeMacId { device, mac, .. } => {
                self.raise(ToolEvent::NotRecovered { device, mac, why: Refusal::Silent });
            }
        }
    }

    fn poll_access(&mut self, now: Instant) -> Option<Action<ToolEvent>> {
        let action = self.access.poll(now)?;
        if let Action::Link(LinkCommand::SetFilter(_)) = action {
            return self.take_filter();
        }
        Some(action.map_event(ToolEvent::Access))
    }

    fn set_filter(&mut self) -> Option<Action<ToolEvent>> {
        if self.filter_due { self.take_filter() } else { None }
    }

    fn take_filter(&mut self) -> Option<Action<ToolEvent>> {
        self.filter_due = false;
        Some(Action::Link(LinkCommand::SetFilter(self.filter())))
    }

    fn event(&mut self) -> Option<Action<ToolEvent>> {
        if self.events_lost != 0 {
            let lost = core::mem::take(&mut self.events_lost);
            return Some(Action::Event(ToolEvent::EventsLost(lost)));
        }
        if self.events.is_empty() { None } else { Some(Action::Event(self.events.remove(0))) }
    }

    fn wanted(&self) -> Option<Outgoing> {
        if self.in_flight.is_some() || !self.on_line {
            return None;
        }
        if self.response_due {
            return Some(Outgoing::OwnershipResponse);
        }
        (self.state.sending() == Some(Sending::Due)).then_some(Outgoing::Message)
    }

    fn transmit(&mut self) -> Option<Action<ToolEvent>> {
        let what = self.wanted()?;
        let frame = match what {
            Outgoing::OwnershipResponse => {
                self.response_due = false;
                self.ownership(Direction::Response)?
            }
            Outgoing::Message => {
                if let Some(sending) = self.state.sending_mut() {
                    *sending = Sending::HandedOut;
                }
                self.message()?
            }
            Outgoing::BackedOff | Outgoing::Abandoned => return None,
        };
        self.in_flight = Some(what);
        Some(Action::Transmit(TOKEN, frame))
    }

    fn message(&self) -> Option<Frame> {
        let request = Identifier::COMMUNICATION_FAULTED_REQUEST;
        match self.state {
            State::Idle => None,
            State::Claiming { .. } => self.ownership(Direction::Request),
            State::Owner { task, .. } => match task {
                Task::None => None,
                Task::Who(delay_offset) => {
                    message::frame(request, &WhoRequest { nodes: NodeSelection::ALL, delay_offset })
                }
                Task::Identify(nodes) => message::frame(request, &IdentifyRequest { nodes }),
                Task::IdentifyDevice(device) => message::frame(request, &IdentifyDeviceRequest { device }),
                Task::ChangeMacId { device, mac, .. } => {
                    message::frame(request, &ChangeMacIdRequest { mac, device })
                }
            },
        }
    }

    fn ownership(&self, direction: Direction) -> Option<Frame> {
        let id = match direction {
            Direction::Request => Identifier::OFFLINE_OWNERSHIP_REQUEST,
            Direction::Response => Identifier::OFFLINE_OWNERSHIP_RESPONSE,
        };
        let device: DeviceIdentity = self.config.access.device;
        message::frame(id, &OfflineOwnership { direction, client: self.access.mac_id(), device })
    }

    fn bad_frame(&mut self) {
        self.ignore();
        self.raise(ToolEvent::BadFrame);
    }

    fn ignore(&mut self) {
        self.counters.ignored = self.counters.ignored.saturating_add(1);
    }

    fn raise(&mut self, event: ToolEvent) {
        if self.events.push(event).is_err() {
            self.events_lost = self.events_lost.saturating_add(1);
            self.counters.events_lost = self.counters.events_lost.saturating_add(1);
        }
    }
}

/// The token of every frame of the tool beyond its network access.
const TOKEN: TxToken = TxToken(1);
/// From a check request to the next, or to the moment at which its sender is on line, and a little more.
const AFTER_CHECK: Duration = Duration::from_millis(1500);
/// Before what the controller gave back is handed out again.
const GIVEN_BACK: Duration = Duration::from_millis(100);
const EVENTS: usize = 8;
