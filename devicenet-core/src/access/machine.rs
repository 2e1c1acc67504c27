//! The network access machine.
//!
//! ```text
//!                 power-up (1)
//! +-------------+             +---------------+   request sent (2)   +---------------+
//! | NonExistent |------------>| SendingDupMac |--------------------->| WaitingDupMac |
//! +-------------+             | stays: (3)(8) |<---------------------| stays: (8)    |
//!        ^                    +---------------+  1 s over, first (4) +---------------+
//!        |                      |   ^   |                              |          |
//!   network power lost,         |   |   | request sent,                |          | 1 s over,
//!   from every state (15)       |   |   | Quick Connect (2)            |          | second (5)
//!                               |   |   |                duplicate (6) |          |
//!                               |   |   |                bus-off (7)   |          v
//!            duplicate (6)      |   |   +------------------------------|-->+------------+
//!            bus-off (7)        |   +----------------------------------|---|   OnLine   |
//!                               |    bus-off with BOI = 1 (12),        |   | stays: (9) |
//!                               |    reset, MAC ID set (1)             |   +------------+
//!                               v                                      v          |
//!                             +------------------------------------------+        |
//!                             |                CommFault                 |<-------+
//!                             +------------------------------------------+  duplicate response (10),
//!                                   |                                       bus-off with BOI = 0 (11)
//!                                   +--> SendingDupMac: Change_MAC_ID (13), reset (14)
//! ```
//!
//! The numbers are the rows of the transition table, [`EDGES`].
//!
//! What is to be sent follows from the state alone; there is no queue. At most one frame is in flight. This file has the
//! machine and its one door between states, `input` what it does with what it hears, `output` what it sends.

use link_core::timers::TimerKey;
use link_core::{Action, Deadline, FilterSet, Input, Instant, Machine, Timers, TxToken};

use super::config::Config;
use super::event::{AccessEvent, Counters, Outgoing};
use super::extent::{Complete, Extent};
use super::pending::{Events, Pending};
use super::state::{Cause, CheckRequest, EDGES, Fault, SecondRequest, SendStage, State, StateKind};
use crate::id::{self, MacId};

/// The network access machine of one node; see the [module](super) text.
///
/// It sends with the token [`Access::TOKEN`] and keeps one frame in flight at most. Frames that are not its business go
/// to the other parts of the node: while it is not [on line](Self::is_online) they are to be discarded.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
// What is asked most comes first: a Cortex-M0 reaches the first 32 bytes from a pointer in one short instruction.
#[repr(C)]
pub struct Access {
    pub(super) state: State,
    pub(super) mac_id: MacId,
    pub(super) bus_off_interrupt: bool,
    pub(super) bus_off_counter: u8,
    pub(super) in_flight: Option<InFlight>,
    /// The filter that the port was told.
    pub(super) told: Option<Listening>,
    /// Attribute 10 as stored, and as it was at the last power-up or reset.
    pub(super) quick_connect: QuickConnect,
    pub(super) config: Config,
    pub(super) events: Events,
    pub(super) timers: Timers<Timer, 2>,
    pub(super) counters: Counters,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) struct QuickConnect {
    pub(super) stored: bool,
    pub(super) active: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) struct InFlight {
    pub(super) what: Outgoing,
    pub(super) fate: Fate,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Fate {
    /// Its `TxDone` is being waited for.
    Wanted,
    /// It must be withdrawn.
    Unwanted,
    /// It has been withdrawn, or the controller drops it by itself.
    Abandoned,
}

/// What the node must hear.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Listening {
    Nothing,
    Check(MacId),
    OfflineSet,
}

/// The waits. A faulted node has two of its own, and none of the others.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Timer {
    /// T_dup, one second after a check request was on the bus. Faulted: before a Who response.
    DupMacOrWho,
    /// Before the controller is restarted, or a frame that it gave back is handed out again. Faulted: until the indicator
    /// ceases to flash red and green.
    BackOffOrIdentify,
}

impl TimerKey<2> for Timer {
    const ALL: [Self; 2] = [Self::DupMacOrWho, Self::BackOffOrIdentify];
    const WHY: [&'static str; 2] =
        ["duplicate MAC ID wait, or Who response delay", "bus-off back-off, or identify indication"];

    fn index(self) -> usize {
        match self {
            Self::DupMacOrWho => 0,
            Self::BackOffOrIdentify => 1,
        }
    }
}

impl Machine for Access {
    type Event = AccessEvent;

    fn input(&mut self, now: Instant, input: Input) {
        // A wait that ended before this moment ended before this input; one that ends now ends after it.
        let now = self.timers.advance(now);
        self.expire::<Complete>(now.preceding());
        self.take_input::<Complete>(now, &input);
    }

    fn poll(&mut self, now: Instant) -> Option<Action<AccessEvent>> {
        self.timers.advance(now);
        let told = self.poll_except_transmit::<Complete, _>(core::convert::identity);
        told.or_else(|| self.transmit::<Complete, _>())
    }

    fn deadline(&self) -> Option<Deadline> {
        if self.has_output() { Some(Deadline::now(self.timers.now())) } else { self.timers.next() }
    }

    fn max_in_flight(&self) -> usize {
        Self::MAX_IN_FLIGHT
    }
}

impl Access {
    /// What [`max_in_flight`](link_core::Machine::max_in_flight) returns, for the size of a port.
    pub const MAX_IN_FLIGHT: usize = 1;

    /// The token of every frame that it sends. A machine that contains it uses others for its own.
    pub const TOKEN: TxToken = TxToken(0);

    /// A node without power: the first [`LinkEvent::Up`](link_core::LinkEvent::Up) starts it.
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
            events: Events::new(),
            config,
        }
    }

    /// What [`input`](Machine::input) does, for a machine that sees to it that no wait ended before `now`.
    pub(crate) fn take_input<P: Extent>(&mut self, now: Instant, input: &Input) {
        let now = self.timers.advance(now);
        match input {
            Input::Frame(frame) => self.frame::<P>(frame),
            Input::TxDone(token, outcome) => self.tx_done::<P>(*token, *outcome),
            Input::Link(event) => self.link::<P>(*event),
            Input::Tick => {}
        }
        self.expire::<P>(now);
    }

    /// The same for no input but the time.
    pub(crate) fn serve_waits<P: Extent>(&mut self, now: Instant) {
        let now = self.timers.advance(now);
        self.expire::<P>(now);
    }

    /// When it must be called next if there is nothing to send or tell.
    pub(crate) fn next_wait(&self) -> Option<Deadline> {
        self.timers.next()
    }

    /// Whether a wait may be over at `now`.
    pub(crate) fn may_be_due(&self, now: Instant) -> bool {
        self.timers.may_be_due(now)
    }

    /// Whether the controller takes no part in the bus, so that it dropped by itself what it had to send.
    pub(crate) fn is_off_the_bus(&self) -> bool {
        self.state == State::NonExistent || self.state.is_off_the_bus()
    }

    /// What the node must hear in its present state: what the port was told, or will be at the next `poll`. On line the
    /// other parts of the node add to it.
    #[must_use]
    pub fn filter(&self) -> FilterSet {
        self.filter_within::<Complete>()
    }

    /// The same for a node with so much of network access.
    pub(crate) fn filter_within<P: Extent>(&self) -> FilterSet {
        match self.listening::<P>() {
            Listening::Nothing => FilterSet::none(),
            Listening::Check(mac) => id::duplicate_mac_check(mac),
            Listening::OfflineSet => id::communication_faulted(),
        }
    }

    /// Starts anew with the first request, by way of a restart of the controller if it is off the bus.
    pub(super) fn restart<P: Extent>(&mut self, cause: Cause) {
        let next = if self.state.is_off_the_bus() {
            let stage = SendStage::Restarting { commanded: false };
            State::SendingDupMac { request: CheckRequest::First, stage }
        } else {
            State::queued(CheckRequest::First)
        };
        self.enter::<P>(next, cause);
    }

    /// The one door between states.
    pub(super) fn enter<P: Extent>(&mut self, next: State, cause: Cause) {
        let (from, to) = (self.state.kind(), next.kind());
        check_edge(from, cause, to);
        if let Some(in_flight) = &mut self.in_flight {
            // A controller that left the bus drops what it had by itself.
            let dropped = matches!(cause, Cause::BusOff | Cause::BusOffRestart | Cause::LinkDown);
            in_flight.fate = match in_flight.fate {
                Fate::Wanted | Fate::Unwanted if !dropped => Fate::Unwanted,
                Fate::Wanted | Fate::Unwanted | Fate::Abandoned => Fate::Abandoned,
            };
        }
        if P::OFFLINE_SET {
            self.end_identify::<P>();
        }
        self.timers.clear_all();
        match next {
            State::WaitingDupMac { .. } => {
                self.timers.set_after_millis(Timer::DupMacOrWho, T_DUP_MILLIS);
            }
            State::OnLine { second_request: SecondRequest::Waiting, .. } if P::QUICK_CONNECT => {
                self.timers.set_after_millis(Timer::DupMacOrWho, T_DUP_MILLIS);
            }
            State::SendingDupMac { stage: SendStage::BackOff, .. } => {
                self.timers.set_after_millis(Timer::BackOffOrIdentify, self.config.bus_off_back_off.into());
            }
            State::NonExistent
            | State::SendingDupMac { .. }
            | State::OnLine { .. }
            | State::CommFault { .. } => {}
        }
        self.state = next;
        self.raise::<P>(Pending::StateChanged { from, to, cause });
    }

    pub(super) fn raise<P: Extent>(&mut self, event: Pending) {
        if P::EVENTS && self.events.push(event).is_err() {
            P::count(&mut self.counters.events_lost);
        }
    }

    /// Something that the table lists and that leaves the state as it is.
    pub(super) fn stay(&self, cause: Cause) {
        check_edge(self.state.kind(), cause, self.state.kind());
    }

    /// Serves every wait that is over at `until`. None of them starts another that is over too.
    #[inline(never)]
    fn expire<P: Extent>(&mut self, until: Instant) {
        while let Some(timer) = self.timers.take_expired(until) {
            let is_faulted = matches!(self.state, State::CommFault { .. });
            match timer {
                Timer::DupMacOrWho if P::OFFLINE_SET && is_faulted => self.who_delay_over(),
                Timer::BackOffOrIdentify if P::OFFLINE_SET && is_faulted => self.end_identify::<P>(),
                Timer::DupMacOrWho => self.wait_over::<P>(),
                Timer::BackOffOrIdentify => self.back_off_over(),
            }
        }
    }

    fn wait_over<P: Extent>(&mut self) {
        match &mut self.state {
            State::WaitingDupMac { request: CheckRequest::First } => {
                self.enter::<P>(State::queued(CheckRequest::Second), Cause::WaitOver);
            }
            State::WaitingDupMac { request: CheckRequest::Second } => {
                self.enter::<P>(State::on_line(SecondRequest::Done), Cause::WaitOver);
            }
            State::OnLine { second_request, .. } if P::QUICK_CONNECT => {
                *second_request = SecondRequest::Queued;
                self.stay(Cause::WaitOver);
            }
            State::NonExistent
            | State::SendingDupMac { .. }
            | State::OnLine { .. }
            | State::CommFault { .. } => {}
        }
    }

    fn back_off_over(&mut self) {
        match &mut self.state {
            State::SendingDupMac { stage: stage @ SendStage::BackOff, .. } => {
                *stage = SendStage::Restarting { commanded: false };
            }
            State::SendingDupMac { .. } | State::OnLine { .. } => self.queue_again(),
            State::NonExistent | State::WaitingDupMac { .. } | State::CommFault { .. } => {}
        }
    }

    pub(super) const fn listening<P: Extent>(&self) -> Listening {
        match self.state {
            State::NonExistent => Listening::Nothing,
            State::SendingDupMac { .. } | State::WaitingDupMac { .. } | State::OnLine { .. } => {
                Listening::Check(self.mac_id)
            }
            State::CommFault { fault: Fault::DuplicateMacId, .. }
                if P::OFFLINE_SET && self.config.offline_set =>
            {
                Listening::OfflineSet
            }
            State::CommFault { .. } => Listening::Nothing,
        }
    }
}

/// That the table allows it.
fn check_edge(from: StateKind, cause: Cause, to: StateKind) {
    debug_assert!(
        EDGES.iter().any(|edge| (edge.from, edge.cause, edge.to) == (from, cause, to)),
        "no transition from {from} to {to} by {cause}"
    );
    #[cfg(test)]
    super::tests::edges::record(from, cause, to);
}

/// How long others have to object.
const T_DUP_MILLIS: u32 = 1000;
