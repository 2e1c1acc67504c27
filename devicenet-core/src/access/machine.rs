//! The network access machine.
//!
//! ```text
//!                  power-up (1)
//!  +-------------+     |       +---------------+   request sent (2)    +---------------+
//!  | NonExistent |-----+------>| SendingDupMac |---------------------->| WaitingDupMac |
//!  +-------------+             | not acked (3) |<----------------------| others (8)    |
//!         ^                    +---------------+  1 s over, first (4)  +---------------+
//!         | network power lost    ^    |    |                           |    |
//!         | from every state (15) |    |    | Quick Connect (2)         |    | 1 s over,
//!         |                       |    |    +------------------+        |    | second (5)
//!                                 |    |                       v        |    v
//!     bus-off with BOI = 1 (12),  |    | duplicate (6)    +------------------------+
//!     reset, MAC ID set (1)       +----|------------------|         OnLine         |
//!                                 |    | bus-off (7)      | defends its MAC ID (9) |
//!                                 |    v                  +------------------------+
//!                                +-----------+                |
//!     Change_MAC_ID (13),        | CommFault |<---------------+
//!     reset (14): upwards        | silent    |  duplicate response (10),
//!                                +-----------+  bus-off with BOI = 0 (11)
//! ```
//!
//! What is to be sent follows from the state alone; there is no queue. At most one frame is in flight.

use core::time::Duration;

use heapless::Vec;
use link_core::link::LinkCommandKind;
use link_core::timers::TimerKey;
use link_core::{
    Action, BusErrorKind, Deadline, FilterSet, Frame, Input, Instant, LinkCommand, LinkEvent, Machine,
    Timers, TxOutcome, TxToken,
};

use super::config::{BusOffWhileChecking, Config};
use super::event::{AccessEvent, Counters, Outgoing};
use super::state::{Cause, CheckRequest, EDGES, Fault, SecondRequest, SendStage, State, WhoAnswer};
use crate::id::{self, Identifier, MacId};
use crate::message::{self, Direction, DuplicateMacCheck, IdentifyResponse, WhoResponse, Wire};

/// The network access machine of one node; see the [module](super) text.
///
/// It sends with the token [`Access::TOKEN`] and keeps one frame in flight at most. Frames that are not its business go
/// to the other parts of the node: while it is not [on line](Self::is_online) they are to be discarded.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Access {
    pub(super) config: Config,
    pub(super) state: State,
    pub(super) mac_id: MacId,
    pub(super) bus_off_interrupt: bool,
    pub(super) bus_off_counter: u8,
    /// Attribute 10 as stored, and as it was at the last power-up or reset.
    pub(super) quick_connect: QuickConnect,
    pub(super) counters: Counters,
    pub(super) timers: Timers<Timer, 4>,
    in_flight: Option<InFlight>,
    /// The filter that the port was told.
    told: Option<Listening>,
    events: Vec<AccessEvent, EVENTS>,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) struct QuickConnect {
    pub(super) stored: bool,
    pub(super) active: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
struct InFlight {
    what: Outgoing,
    fate: Fate,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
enum Fate {
    /// Its `TxDone` is being waited for.
    Wanted,
    /// It must be withdrawn.
    Unwanted,
    /// It has been withdrawn, or the controller drops it by itself.
    Abandoned,
}

/// What the node must hear.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
enum Listening {
    Nothing,
    Check(MacId),
    OfflineSet,
}

/// The waits.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Timer {
    /// T_dup, one second after a check request was on the bus.
    DupMac,
    /// Before the controller is restarted, or a request is handed out again.
    BackOff,
    /// Before a Who response.
    Who,
    /// Until the indicator ceases to flash red and green.
    Identify,
}

impl TimerKey<4> for Timer {
    const ALL: [Self; 4] = [Self::DupMac, Self::BackOff, Self::Who, Self::Identify];

    fn index(self) -> usize {
        match self {
            Self::DupMac => 0,
            Self::BackOff => 1,
            Self::Who => 2,
            Self::Identify => 3,
        }
    }

    fn why(self) -> &'static str {
        match self {
            Self::DupMac => "duplicate MAC ID wait",
            Self::BackOff => "bus-off back-off",
            Self::Who => "Who response delay",
            Self::Identify => "identify indication",
        }
    }
}

impl Machine for Access {
    type Event = AccessEvent;

    fn input(&mut self, now: Instant, input: Input) {
        let now = self.timers.advance(now);
        // A wait that ended before this moment ended before this input; one that ends now ends after it.
        self.expire(now.saturating_sub(Duration::from_nanos(1)));
        match input {
            Input::Frame(frame) => self.frame(&frame),
            Input::TxDone(token, outcome) => self.tx_done(token, outcome),
            Input::Link(event) => self.link(event),
            Input::Tick => {}
        }
        self.expire(now);
    }

    fn poll(&mut self, now: Instant) -> Option<Action<AccessEvent>> {
        self.timers.advance(now);
        self.withdraw().or_else(|| self.restart_controller()).or_else(|| self.set_filter()).or_else(|| {
            if self.events.is_empty() { self.transmit() } else { Some(Action::Event(self.events.remove(0))) }
        })
    }

    fn deadline(&self) -> Option<Deadline> {
        if self.has_output() { Some(Deadline::now(self.timers.now())) } else { self.timers.next() }
    }

    fn max_in_flight(&self) -> usize {
        1
    }
}

impl Access {
    /// The token of every frame that it sends. A machine that contains it uses others for its own.
    pub const TOKEN: TxToken = TxToken(0);

    /// A node without power: the first [`LinkEvent::Up`] starts it.
    #[must_use]
    pub fn new(config: Config) -> Self {
        Self {
            state: State::NonExistent,
            mac_id: config.mac_id,
            bus_off_interrupt: config.bus_off_interrupt,
            bus_off_counter: 0,
            quick_connect: QuickConnect { stored: config.quick_connect, active: false },
            counters: Counters::default(),
            timers: Timers::new(),
            in_flight: None,
            told: None,
            events: Vec::new(),
            config,
        }
    }

    /// What the node must hear in its present state: what the port was told, or will be at the next `poll`. On line the
    /// other parts of the node add to it.
    #[must_use]
    pub fn filter(&self) -> FilterSet {
        match self.listening() {
            Listening::Nothing => FilterSet::none(),
            Listening::Check(mac) => id::duplicate_mac_check(mac),
            Listening::OfflineSet => id::communication_faulted(),
        }
    }

    /// Starts anew with the first request, by way of a restart of the controller if it is off the bus.
    pub(super) fn restart(&mut self, cause: Cause) {
        let next = if self.state.is_off_the_bus() {
            let stage = SendStage::Restarting { commanded: false };
            State::SendingDupMac { request: CheckRequest::First, stage }
        } else {
            State::queued(CheckRequest::First)
        };
        self.enter(next, cause);
    }

    /// The one door between states.
    pub(super) fn enter(&mut self, next: State, cause: Cause) {
        let (from, to) = (self.state.kind(), next.kind());
        check_edge(from, cause, to);
        if let Some(in_flight) = &mut self.in_flight {
            // A controller that left the bus drops what it had by itself.
            in_flight.fate = match cause {
                Cause::BusOff | Cause::BusOffRestart | Cause::LinkDown => Fate::Abandoned,
                _ if in_flight.fate == Fate::Abandoned => Fate::Abandoned,
                _ => Fate::Unwanted,
            };
        }
        self.timers.clear_all();
        match next {
            State::WaitingDupMac { .. } | State::OnLine { second_request: SecondRequest::Waiting, .. } => {
                self.timers.set_after(Timer::DupMac, T_DUP);
            }
            State::SendingDupMac { stage: SendStage::BackOff, .. } => {
                self.timers.set_after(Timer::BackOff, self.config.bus_off_back_off);
            }
            State::NonExistent
            | State::SendingDupMac { .. }
            | State::OnLine { .. }
            | State::CommFault { .. } => {}
        }
        self.state = next;
        self.raise(AccessEvent::StateChanged { from, to, cause });
    }

    pub(super) fn raise(&mut self, event: AccessEvent) {
        if self.events.push(event).is_err() {
            count(&mut self.counters.events_lost);
        }
    }

    /// Something that the table lists and that leaves the state as it is.
    fn stay(&self, cause: Cause) {
        check_edge(self.state.kind(), cause, self.state.kind());
    }

    fn frame(&mut self, frame: &Frame) {
        let Some(id) = Identifier::of_frame(frame) else {
            self.counters.foreign_frames = self.counters.foreign_frames.saturating_add(1);
            return;
        };
        match (self.state, self.listening()) {
            (State::NonExistent, _) => self.discard(),
            (_, Listening::Check(mac)) if id == Identifier::duplicate_mac_check(mac) => {
                self.check(id, frame.data())
            }
            (_, Listening::OfflineSet) if id == Identifier::COMMUNICATION_FAULTED_REQUEST => {
                self.communication_faulted(frame.data());
            }
            // Other frames are the business of other parts of the node.
            (State::OnLine { .. }, _) => {}
            (State::CommFault { .. }, _) => self.discard(),
            (State::SendingDupMac { .. } | State::WaitingDupMac { .. }, _) => {
                self.stay(Cause::OtherMessage);
                self.discard();
            }
        }
    }

    /// A frame on the identifier of the own check.
    fn check(&mut self, id: Identifier, data: &[u8]) {
        let other = match DuplicateMacCheck::parse(data) {
            Ok(check) => Some(check),
            Err(error) => {
                self.bad_frame(id, error);
                None
            }
        };
        if other.is_none() && !self.config.accept_bad_dlc {
            return;
        }
        // Without a first byte it is taken for a request, which is answered on line instead of obeyed.
        let direction = data.first().map_or(Direction::Request, |&byte| Direction::of(byte));
        let cause = match direction {
            Direction::Request => Cause::DuplicateRequest,
            Direction::Response => Cause::DuplicateResponse,
        };
        if let State::OnLine { response_due, .. } = &mut self.state
            && direction == Direction::Request
        {
            if *response_due {
                count(&mut self.counters.requests_merged);
            }
            *response_due = true;
            count(&mut self.counters.challenges);
            self.stay(cause);
            self.raise(AccessEvent::Challenged { other });
            return;
        }
        count(&mut self.counters.duplicates);
        self.raise(AccessEvent::Duplicate { direction, other });
        self.enter(State::faulted(Fault::DuplicateMacId), cause);
    }

    fn tx_done(&mut self, token: TxToken, outcome: TxOutcome) {
        let Some(InFlight { what, fate }) = self.in_flight.filter(|_| token == Self::TOKEN) else {
            count(&mut self.counters.stray_tx_done);
            return;
        };
        self.in_flight = None;
        match (fate, outcome) {
            (Fate::Unwanted | Fate::Abandoned, _) => {}
            (Fate::Wanted, TxOutcome::Sent) => self.sent(what),
            (Fate::Wanted, TxOutcome::Withdrawn | TxOutcome::Dropped) => self.given_back(what, outcome),
        }
    }

    fn sent(&mut self, what: Outgoing) {
        match (what, &mut self.state) {
            (Outgoing::CheckRequest, State::SendingDupMac { request: CheckRequest::First, .. })
                if self.quick_connect.active =>
            {
                self.enter(State::on_line(SecondRequest::Waiting), Cause::QuickConnect);
            }
            (Outgoing::CheckRequest, State::SendingDupMac { request, .. }) => {
                let request = *request;
                self.enter(State::WaitingDupMac { request }, Cause::RequestSent);
            }
            (Outgoing::CheckRequest, State::OnLine { second_request, .. }) => {
                *second_request = SecondRequest::Done;
                self.stay(Cause::RequestSent);
            }
            (Outgoing::CheckResponse, _) => count(&mut self.counters.responses),
            (Outgoing::CheckRequest | Outgoing::WhoResponse | Outgoing::IdentifyResponse, _) => {}
        }
    }

    fn given_back(&mut self, what: Outgoing, outcome: TxOutcome) {
        count(&mut self.counters.not_sent);
        self.raise(AccessEvent::NotSent { what, outcome });
        match (what, &mut self.state) {
            (Outgoing::CheckRequest, State::SendingDupMac { stage, .. }) => *stage = SendStage::GivenBack,
            (Outgoing::CheckRequest, State::OnLine { second_request, .. }) => {
                *second_request = SecondRequest::Waiting;
            }
            // An answer is not repeated: who asked repeats its question.
            _ => return,
        }
        self.timers.set_after(Timer::BackOff, self.config.bus_off_back_off);
    }

    fn link(&mut self, event: LinkEvent) {
        match event {
            LinkEvent::Up => self.up(),
            LinkEvent::Down => {
                self.told = None;
                if self.state != State::NonExistent {
                    self.enter(State::NonExistent, Cause::LinkDown);
                }
            }
            LinkEvent::BusOff => self.bus_off(),
            LinkEvent::ModeSet(_) => self.queue_again(),
            LinkEvent::BusError(BusErrorKind::Ack) => self.not_acknowledged(),
            LinkEvent::Overrun { lost } => {
                self.counters.frames_lost = self.counters.frames_lost.saturating_add(lost.max(1));
                self.raise(AccessEvent::FramesLost { count: lost });
            }
            LinkEvent::Refused(kind) => self.refused(kind),
            _ => {}
        }
    }

    fn up(&mut self) {
        self.told = None;
        match &mut self.state {
            State::NonExistent => {
                self.quick_connect.active = self.quick_connect.stored;
                self.restart(Cause::LinkUp);
            }
            State::SendingDupMac { stage: stage @ SendStage::Restarting { .. }, .. } => {
                *stage = SendStage::Queued { unacknowledged: false };
            }
            State::SendingDupMac { .. } => self.queue_again(),
            State::WaitingDupMac { .. } | State::OnLine { .. } | State::CommFault { .. } => {}
        }
    }

    /// The controller is ready again for the request that it gave back.
    fn queue_again(&mut self) {
        if let State::SendingDupMac { stage: stage @ SendStage::GivenBack, .. } = &mut self.state {
            *stage = SendStage::Queued { unacknowledged: false };
            self.timers.clear(Timer::BackOff);
        }
    }

    fn bus_off(&mut self) {
        // Told twice, or told of a controller that the node does not use.
        if self.state.is_off_the_bus() || self.state == State::NonExistent {
            return;
        }
        self.bus_off_counter = self.bus_off_counter.saturating_add(1);
        let restarts = self.bus_off_interrupt
            && match self.state {
                State::OnLine { .. } => true,
                State::SendingDupMac { .. } | State::WaitingDupMac { .. } => {
                    self.config.bus_off_while_checking == BusOffWhileChecking::FollowInterrupt
                }
                State::NonExistent | State::CommFault { .. } => false,
            };
        if restarts {
            let next = State::SendingDupMac { request: CheckRequest::First, stage: SendStage::BackOff };
            self.enter(next, Cause::BusOffRestart);
        } else {
            self.enter(State::faulted(Fault::BusOff), Cause::BusOff);
        }
    }

    fn not_acknowledged(&mut self) {
        if let State::SendingDupMac { stage: SendStage::Queued { unacknowledged }, .. } = &mut self.state {
            self.counters.unacknowledged = self.counters.unacknowledged.saturating_add(1);
            let first = !core::mem::replace(unacknowledged, true);
            self.stay(Cause::NotAcknowledged);
            if first {
                self.raise(AccessEvent::NotAcknowledged);
            }
        }
    }

    fn refused(&mut self, kind: LinkCommandKind) {
        count(&mut self.counters.refused);
        self.raise(AccessEvent::LinkRefused(kind));
        let restarting =
            matches!(self.state, State::SendingDupMac { stage: SendStage::Restarting { .. }, .. });
        if restarting && kind == LinkCommandKind::Reset {
            self.enter(State::faulted(Fault::BusOff), Cause::BusOff);
        }
    }

    /// Serves every wait that is over at `until`. None of them starts another that is over too.
    fn expire(&mut self, until: Instant) {
        while let Some(timer) = self.timers.take_expired(until) {
            match timer {
                Timer::DupMac => self.wait_over(),
                Timer::BackOff => self.back_off_over(),
                Timer::Who => self.who_delay_over(),
                Timer::Identify => self.end_identify(),
            }
        }
    }

    fn wait_over(&mut self) {
        match &mut self.state {
            State::WaitingDupMac { request: CheckRequest::First } => {
                self.enter(State::queued(CheckRequest::Second), Cause::WaitOver);
            }
            State::WaitingDupMac { request: CheckRequest::Second } => {
                self.enter(State::on_line(SecondRequest::Done), Cause::WaitOver);
            }
            State::OnLine { second_request, .. } => {
                *second_request = SecondRequest::Queued;
                self.stay(Cause::WaitOver);
            }
            State::NonExistent | State::SendingDupMac { .. } | State::CommFault { .. } => {}
        }
    }

    fn back_off_over(&mut self) {
        match &mut self.state {
            State::SendingDupMac { stage: stage @ SendStage::BackOff, .. } => {
                *stage = SendStage::Restarting { commanded: false };
            }
            State::SendingDupMac { .. } => self.queue_again(),
            State::OnLine { second_request, .. } => *second_request = SecondRequest::Queued,
            State::NonExistent | State::WaitingDupMac { .. } | State::CommFault { .. } => {}
        }
    }

    fn discard(&mut self) {
        self.counters.discarded = self.counters.discarded.saturating_add(1);
    }

    pub(super) fn bad_frame(&mut self, id: Identifier, error: message::ParseError) {
        count(&mut self.counters.bad_frames);
        self.raise(AccessEvent::BadFrame { id, error });
    }

    const fn listening(&self) -> Listening {
        match self.state {
            State::NonExistent => Listening::Nothing,
            State::SendingDupMac { .. } | State::WaitingDupMac { .. } | State::OnLine { .. } => {
                Listening::Check(self.mac_id)
            }
            State::CommFault { fault: Fault::DuplicateMacId, .. } if self.config.offline_set => {
                Listening::OfflineSet
            }
            State::CommFault { .. } => Listening::Nothing,
        }
    }

    fn has_output(&self) -> bool {
        !self.events.is_empty()
            || self.must_withdraw()
            || self.must_restart_controller()
            || self.must_set_filter()
            || self.wanted().is_some()
    }

    fn must_withdraw(&self) -> bool {
        self.in_flight.is_some_and(|in_flight| in_flight.fate == Fate::Unwanted)
    }

    fn withdraw(&mut self) -> Option<Action<AccessEvent>> {
        if !self.must_withdraw() {
            return None;
        }
        self.in_flight.as_mut()?.fate = Fate::Abandoned;
        Some(Action::Withdraw(Self::TOKEN))
    }

    const fn must_restart_controller(&self) -> bool {
        matches!(self.state, State::SendingDupMac { stage: SendStage::Restarting { commanded: false }, .. })
    }

    fn restart_controller(&mut self) -> Option<Action<AccessEvent>> {
        let State::SendingDupMac { stage: SendStage::Restarting { commanded: commanded @ false }, .. } =
            &mut self.state
        else {
            return None;
        };
        *commanded = true;
        Some(Action::Link(LinkCommand::Reset))
    }

    fn must_set_filter(&self) -> bool {
        self.state != State::NonExistent && self.told != Some(self.listening())
    }

    fn set_filter(&mut self) -> Option<Action<AccessEvent>> {
        if !self.must_set_filter() {
            return None;
        }
        self.told = Some(self.listening());
        Some(Action::Link(LinkCommand::SetFilter(self.filter())))
    }

    /// The frame to send now. It follows from the state.
    fn wanted(&self) -> Option<Outgoing> {
        if self.in_flight.is_some() {
            return None;
        }
        match self.state {
            State::SendingDupMac { stage: SendStage::Queued { .. }, .. } => Some(Outgoing::CheckRequest),
            State::OnLine { response_due: true, .. } => Some(Outgoing::CheckResponse),
            State::OnLine { second_request: SecondRequest::Queued, .. } => Some(Outgoing::CheckRequest),
            State::CommFault { offline, .. } if offline.identify.is_some() => {
                Some(Outgoing::IdentifyResponse)
            }
            State::CommFault { offline, .. } if offline.who == WhoAnswer::Due => Some(Outgoing::WhoResponse),
            State::NonExistent
            | State::SendingDupMac { .. }
            | State::WaitingDupMac { .. }
            | State::OnLine { .. }
            | State::CommFault { .. } => None,
        }
    }

    fn transmit(&mut self) -> Option<Action<AccessEvent>> {
        let what = self.wanted()?;
        let frame = self.take(what)?;
        self.in_flight = Some(InFlight { what, fate: Fate::Wanted });
        Some(Action::Transmit(Self::TOKEN, frame))
    }

    /// Builds the frame, and notes that it needs not be sent again.
    fn take(&mut self, what: Outgoing) -> Option<Frame> {
        let (port, device) = (self.config.port, self.config.device);
        let own_check = Identifier::duplicate_mac_check(self.mac_id);
        let answers = Identifier::COMMUNICATION_FAULTED_RESPONSE;
        match (what, &mut self.state) {
            (Outgoing::CheckRequest, _) => {
                let direction = Direction::Request;
                message::frame(own_check, &DuplicateMacCheck { direction, port, device })
            }
            (Outgoing::CheckResponse, State::OnLine { response_due, .. }) => {
                *response_due = false;
                let direction = Direction::Response;
                message::frame(own_check, &DuplicateMacCheck { direction, port, device })
            }
            (Outgoing::WhoResponse, State::CommFault { offline, .. }) => {
                offline.who = WhoAnswer::None;
                message::frame(answers, &WhoResponse { port, device })
            }
            (Outgoing::IdentifyResponse, State::CommFault { offline, .. }) => {
                let nodes = offline.identify.take()?;
                message::frame(answers, &IdentifyResponse { nodes })
            }
            (Outgoing::CheckResponse | Outgoing::WhoResponse | Outgoing::IdentifyResponse, _) => None,
        }
    }
}

pub(super) fn count(counter: &mut u16) {
    *counter = counter.saturating_add(1);
}

/// That the table allows it.
fn check_edge(from: super::StateKind, cause: Cause, to: super::StateKind) {
    debug_assert!(
        EDGES.iter().any(|edge| (edge.from, edge.cause, edge.to) == (from, cause, to)),
        "no transition from {from} to {to} by {cause}"
    );
    #[cfg(test)]
    super::tests::edges::record(from, cause, to);
}

/// How long others have to object.
const T_DUP: Duration = Duration::from_millis(1000);
/// One input raises at most five.
const EVENTS: usize = 8;
