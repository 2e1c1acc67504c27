//! The network access machine.
//!
//! ```text
//!                link up                bit rate locked
//! +-------------+  (1)  +------------------+  (2)  +--------+  wait over (3)  +--------+
//! | NonExistent |------>| DetectingBitRate |------>| Hello1 |---------------->| Hello2 |
//! +-------------+       +------------------+       +--------+                 +--------+
//!        |   ^                                       ^    ^                    |      |
//!        |   | link down,                            |    |  taken (6)(7)      |      |
//!        |   | from every state (17)                 |    +--------------------+      |
//!        |                                           |                         |      |
//!        +-------------------------------------------+     wait over, OA 127 (4)      | wait over,
//!          link up, network manager (1)              |                         |      | other OA (5)
//!                                                    |                         v      v
//!                                                    |      ROAM (9)   +---------+  +--------+
//!                                                    +-----------------| Standby |  | Online |
//!                                                    |                 +---------+  +--------+
//!                                                    |                                  |
//!                                                    +----------------------------------+
//!                                                              OA is taken (11)
//! ```
//!
//! `BusOff` is reached from every state in which the controller is used (12), and left once, if BOI says so (13).
//! `Faulted` is where a controller leads to that cannot be set to a rate, or does not restart (14). The numbers are the rows
//! of [`EDGES`].
//!
//! What is to be sent follows from the state alone; there is no queue. At most one frame is in flight. This file has the
//! machine and its one door between states, `input` what it does with what it hears, `output` what it sends.

use link_core::timers::TimerKey;
use link_core::{
    Action, BitRate, Deadline, FilterSet, Input, Instant, Machine, Mode, Queue, Timers, TxToken,
};

use super::config::{Config, ModeRefused, Role};
use super::event::{AccessEvent, Counters, Outgoing};
use super::state::{Cause, EDGES, HelloNumber, HelloStage, Restart, State, StateKind};
use crate::bit_rate::{Detector, Step};
use crate::counter::count;
use crate::id::{self, OperationalAddress};

/// The network access machine of one node; see the [module](super) text.
///
/// It sends with the token [`Access::TOKEN`] and keeps one frame in flight at most. Frames that are not its business go
/// to the other parts of the node: while it is not [on line](Self::is_online) they are to be discarded.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Access {
    pub(super) config: Config,
    pub(super) state: State,
    pub(super) address: OperationalAddress,
    /// That of the bus, once it is known; `None` if it is that of the link.
    pub(super) bit_rate: Option<BitRate>,
    pub(super) hello_wait: u16,
    pub(super) bus_off_interrupt: bool,
    pub(super) bus_off_counter: u8,
    pub(super) restarts_left: u8,
    pub(super) counters: Counters,
    pub(super) timers: Timers<Timer, 2>,
    pub(super) in_flight: Option<InFlight>,
    /// The filter that the port was told.
    pub(super) told: Option<Listening>,
    pub(super) events: Queue<AccessEvent, EVENTS>,
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
    Everything,
    Address(OperationalAddress),
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Timer {
    /// After a Hello; while detecting, without a frame; on line, until the address is told again.
    Wait,
    /// Before the controller is restarted, or a frame that it gave back is handed out again.
    BackOff,
}

impl TimerKey<2> for Timer {
    const ALL: [Self; 2] = [Self::Wait, Self::BackOff];
    const WHY: [&'static str; 2] =
        ["Hello wait, bit rate dwell, or address announcement", "bus-off back-off"];

    fn index(self) -> usize {
        match self {
            Self::Wait => 0,
            Self::BackOff => 1,
        }
    }
}

impl Machine for Access {
    type Event = AccessEvent;

    fn input(&mut self, now: Instant, input: Input) {
        let now = self.timers.advance(now);
        // A wait that ended before this moment ended before this input; one that ends now ends after it.
        self.expire(now.preceding());
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
        self.poll_except_transmit().or_else(|| self.transmit())
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
            address: config.first_address(),
            bit_rate: None,
            hello_wait: config.hello_wait,
            bus_off_interrupt: config.bus_off_interrupt,
            bus_off_counter: 0,
            restarts_left: config.bus_off_restarts,
            counters: Counters::default(),
            timers: Timers::new(),
            in_flight: None,
            told: None,
            events: Queue::new(),
            config,
        }
    }

    /// What the node must hear in its present state: what the port was told, or will be at the next `poll`. On line the
    /// other parts of the node add to it.
    #[must_use]
    pub fn filter(&self) -> FilterSet {
        match self.listening() {
            Listening::Nothing => FilterSet::none(),
            Listening::Everything => FilterSet::all(),
            Listening::Address(address) if address.is_none() => id::standby(),
            Listening::Address(address) => id::hello(address),
        }
    }

    /// Starts anew: a device by detecting the bit rate, a network manager by setting it.
    pub(super) fn start(&mut self, cause: Cause) {
        match self.config.role {
            Role::Device => {
                self.bit_rate = None;
                let detector = Detector::new(self.config.candidates.clone(), self.config.lock_after);
                self.enter(State::DetectingBitRate { detector, commanded: false }, cause);
            }
            Role::NetworkManager { bit_rate, .. } => {
                self.bit_rate = Some(bit_rate);
                self.join(cause);
            }
        }
    }

    /// Says the first Hello, after the controller is at the rate of the bus and no longer only listens.
    pub(super) fn join(&mut self, cause: Cause) {
        let stage = match self.bit_rate {
            Some(_) => HelloStage::SettingMode { commanded: false },
            None => HelloStage::Queued { unacknowledged: false },
        };
        self.enter(State::Hello { number: HelloNumber::First, stage, answer_due: false }, cause);
    }

    /// Says the first Hello with another address; the controller takes part already.
    pub(super) fn rejoin(&mut self, address: OperationalAddress, cause: Cause) {
        self.address = address;
        self.enter(State::hello(HelloNumber::First, false), cause);
    }

    /// The one door between states.
    pub(super) fn enter(&mut self, next: State, cause: Cause) {
        let (from, to) = (self.state.kind(), next.kind());
        check_edge(from, cause, to);
        if let Some(in_flight) = &mut self.in_flight {
            in_flight.fate = match (cause, in_flight.fate) {
                // The address is the same: what tells it is still right.
                (Cause::WaitOver, fate) => fate,
                // A controller that left the bus drops what it had by itself.
                (Cause::BusOff | Cause::LinkDown, _) | (_, Fate::Abandoned) => Fate::Abandoned,
                (_, Fate::Wanted | Fate::Unwanted) => Fate::Unwanted,
            };
        }
        self.timers.clear_all();
        match next {
            State::Online { .. } => self.begin_announcement_wait(),
            State::BusOff { restart: Restart::BackOff } => {
                self.timers.set_after_millis(Timer::BackOff, self.config.bus_off_back_off.into());
            }
            State::NonExistent
            | State::DetectingBitRate { .. }
            | State::Hello { .. }
            | State::Standby { .. }
            | State::BusOff { .. }
            | State::Faulted { .. } => {}
        }
        self.state = next;
        self.raise(AccessEvent::StateChanged { from, to, cause });
    }

    pub(super) fn begin_announcement_wait(&mut self) {
        match self.config.announcement {
            0 => self.timers.clear(Timer::Wait),
            millis => self.timers.set_after_millis(Timer::Wait, millis),
        }
    }

    /// Does what the detector asks for.
    pub(super) fn obey(&mut self, step: Step) {
        match step {
            Step::None => {}
            Step::SetMode(_) => {
                self.timers.clear(Timer::Wait);
                if let State::DetectingBitRate { commanded, .. } = &mut self.state {
                    *commanded = false;
                }
            }
            Step::Listen => self.timers.set_after_millis(Timer::Wait, self.config.dwell.into()),
            Step::Lock(bit_rate) => {
                self.bit_rate = bit_rate;
                self.raise(AccessEvent::BitRateLocked(bit_rate));
                self.join(Cause::BitRateLocked);
            }
        }
    }

    pub(super) fn raise(&mut self, event: AccessEvent) {
        if self.events.push(event).is_err() {
            count(&mut self.counters.events_lost);
        }
    }

    /// Something that the table lists and that leaves the state as it is.
    pub(super) fn stay(&self, cause: Cause) {
        check_edge(self.state.kind(), cause, self.state.kind());
    }

    /// Serves every wait that is over at `until`. None of them starts another that is over too.
    pub(crate) fn expire(&mut self, until: Instant) {
        while let Some(timer) = self.timers.take_expired(until) {
            match timer {
                Timer::Wait => self.wait_over(),
                Timer::BackOff => self.back_off_over(),
            }
        }
    }

    fn wait_over(&mut self) {
        match &mut self.state {
            State::DetectingBitRate { detector, .. } => {
                let step = detector.dwell_over();
                self.obey(step);
            }
            State::Hello { number: HelloNumber::First, answer_due, .. } => {
                let next = State::hello(HelloNumber::Second, *answer_due);
                self.enter(next, Cause::WaitOver);
            }
            State::Hello { number: HelloNumber::Second, answer_due, .. } => {
                let next = if self.address.is_none() {
                    State::Standby { hello_due: false }
                } else {
                    State::Online { response_due: *answer_due }
                };
                self.enter(next, Cause::WaitOver);
            }
            State::Online { response_due } => {
                if core::mem::replace(response_due, true) {
                    count(&mut self.counters.merged);
                }
                self.stay(Cause::AnnouncementDue);
            }
            State::NonExistent | State::Standby { .. } | State::BusOff { .. } | State::Faulted { .. } => {}
        }
    }

    fn back_off_over(&mut self) {
        match &mut self.state {
            State::BusOff { restart: restart @ Restart::BackOff } => {
                *restart = Restart::Restarting { commanded: false };
            }
            State::Hello { .. } | State::Standby { .. } | State::Online { .. } => self.queue_again(),
            State::NonExistent
            | State::DetectingBitRate { .. }
            | State::BusOff { .. }
            | State::Faulted { .. } => {}
        }
    }

    /// The controller is ready again for what it gave back.
    pub(super) fn queue_again(&mut self) {
        if let State::Hello { stage: stage @ HelloStage::GivenBack, .. } = &mut self.state {
            *stage = HelloStage::Queued { unacknowledged: false };
        }
        if !matches!(self.state, State::BusOff { .. }) {
            self.timers.clear(Timer::BackOff);
        }
    }

    /// The mode in which the controller must be for the node to say Hello.
    pub(super) fn active_mode(&self) -> Option<Mode> {
        self.bit_rate.map(|bit_rate| Mode { bit_rate, listen_only: false })
    }

    pub(super) const fn takes_rate_of_link(&self) -> bool {
        matches!(self.config.mode_refused, ModeRefused::TakeRateOfLink)
    }

    pub(super) const fn listening(&self) -> Listening {
        match self.state {
            State::NonExistent | State::BusOff { .. } | State::Faulted { .. } => Listening::Nothing,
            State::DetectingBitRate { .. } => Listening::Everything,
            State::Hello { .. } | State::Standby { .. } | State::Online { .. } => {
                Listening::Address(self.address)
            }
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

/// One input raises at most five.
const EVENTS: usize = 5;
