//! The wire and the controllers on it. It knows frames and bits, and no machine.

mod acceptance;
mod attempt;
mod counters;
mod decoder;
mod effects;
mod engine;
mod exact;
mod fault;
mod membership;
mod phase;
mod quick;
mod segment;
mod station;
mod timed;

pub use acceptance::NodeSet;
pub use attempt::{BusError, Sender, SenderOutcome};
pub use counters::{Counters, ErrorState};
pub use fault::{Fault, FaultId, Scope, Which};
pub use phase::Flag;

pub(crate) use attempt::{Attempt, Finished};
pub(crate) use station::{after, span};

use link_core::{FilterSet, Frame, Input, Instant, Mode, TxOutcome, TxToken};

use crate::NodeId;
use crate::record::Interest;
use acceptance::Acceptance;
use fault::Faults;
use phase::Effect;
use segment::{Activity, Segment};
use station::Station;

/// Something on the bus that is not a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Note {
    Error(BusError),
    Counters { at: Instant, node: NodeId, counters: Counters },
}

/// The next thing that the bus does by itself.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) struct Next {
    pub(crate) at: Instant,
    /// A beginning comes after everything else at the same moment, because it depends on it.
    pub(crate) begins: bool,
    segment: usize,
}

/// All segments, and the stations on them.
#[derive(Clone, Debug)]
pub(crate) struct Bus {
    stations: Vec<Station>,
    segments: Vec<Segment>,
    acceptance: Acceptance,
    faults: Faults,
    force_exact: bool,
    pub(crate) interest: Interest,
    /// What stations have to tell their nodes, in order.
    pub(crate) outbox: Vec<(usize, Input)>,
    pub(crate) notes: Vec<Note>,
    pub(crate) finished: Finished,
    /// Scratch: nodes that see a bit inverted.
    struck: Vec<usize>,
    /// Scratch: what the leaders made of a bit.
    effects: Vec<Effect>,
    attempts: u64,
    now: Instant,
}

impl Bus {
    pub(crate) fn new(bit: u64, seed: u64, force_exact: bool) -> Self {
        Self {
            stations: Vec::new(),
            segments: vec![Segment::new()],
            acceptance: Acceptance::new(),
            faults: Faults::new(seed, bit),
            force_exact,
            interest: Interest::empty(),
            outbox: Vec::new(),
            notes: Vec::new(),
            finished: Finished::default(),
            struck: Vec::new(),
            effects: Vec::new(),
            attempts: 0,
            now: Instant::ZERO,
        }
    }

    /// Adds a station without power.
    pub(crate) fn add(&mut self, mode: Mode, clock_ppm: i32, filter: FilterSet, mailboxes: usize) {
        self.stations.push(Station::new(mode, clock_ppm, filter.clone(), mailboxes));
        self.acceptance.push(filter);
    }

    /// When the bus must be called next, and in which order.
    pub(crate) fn next(&self) -> Option<Next> {
        let mut next: Option<Next> = None;
        for (segment, state) in self.segments.iter().enumerate() {
            let Some((at, begins)) = state.next(self.faults.next(), self.now) else { continue };
            let candidate = Next { at, begins, segment };
            if next.is_none_or(|next| candidate < next) {
                next = Some(candidate);
            }
        }
        next
    }

    /// Does what [`next`](Self::next) said. It may go on by itself until somebody must be told something, or until
    /// `limit`, before which nothing else happens.
    /// Returns when what it did last happened.
    pub(crate) fn advance(&mut self, next: Next, limit: Instant) -> Instant {
        debug_assert!(next.at >= self.now, "the bus runs backwards: {next:?} at {}", self.now);
        self.now = next.at;
        match self.segments[next.segment].activity {
            Activity::Quiet => self.begin(next.segment, next.at),
            Activity::Quick { .. } => self.finish_quick(next.segment),
            Activity::Exact { .. } => self.run_exact(next.segment, limit),
            Activity::Timed { .. } => self.run_timed(next.segment, limit),
        }
        self.now
    }

    /// Whether somebody must be told something.
    pub(crate) fn has_news(&self) -> bool {
        !(self.outbox.is_empty() && self.notes.is_empty() && self.finished.is_empty())
    }

    /// A node wants a frame to be sent, not before `ready`.
    pub(crate) fn request(&mut self, node: usize, token: TxToken, frame: Frame, ready: Instant) {
        if !self.stations[node].can_send() {
            self.done(node, token, TxOutcome::Dropped);
            return;
        }
        let segment = self.stations[node].segment;
        let first = self.stations[node].queue.is_empty();
        if first && !self.segments[segment].followers.is_empty() {
            // It has something of its own to do from now on.
            self.dissolve(segment);
        }
        self.stations[node].queue.push(token, frame, ready);
        if first {
            self.segments[segment].waiting.push(node);
        }
        self.plan_for(segment, node, ready);
    }

    /// A node wants a frame back.
    pub(crate) fn withdraw(&mut self, now: Instant, node: usize, token: TxToken) {
        let segment = self.stations[node].segment;
        if let Activity::Quick { start, .. } = self.segments[segment].activity
            && self.stations[node].queue.find(token).is_some_and(|mail| mail.ready <= start)
        {
            // It may be in the arbitration that is under way.
            self.go_exact(segment, now);
        }
        let station = &mut self.stations[node];
        let Some(mail) = station.queue.find(token) else { return };
        if mail.sending {
            mail.withdrawn = true;
            return;
        }
        station.queue.remove(token);
        self.done(node, token, TxOutcome::Withdrawn);
        self.forget_if_empty(node);
    }

    /// The number of frames that wait in a node's mailboxes.
    pub(crate) fn in_flight(&self, node: usize) -> usize {
        self.stations[node].queue.len()
    }

    pub(crate) fn has_token(&mut self, node: usize, token: TxToken) -> bool {
        self.stations[node].queue.find(token).is_some()
    }

    pub(crate) fn mode(&self, node: usize) -> Mode {
        self.stations[node].mode
    }

    pub(crate) fn set_filter(&mut self, node: usize, filter: FilterSet) {
        self.acceptance.set(node, filter);
    }

    pub(crate) fn fault_on(&mut self, now: Instant, id: FaultId, fault: Fault) {
        for segment in 0..self.segments.len() {
            self.go_exact(segment, now);
        }
        self.faults.on(now, id, fault);
    }

    pub(crate) fn fault_off(&mut self, id: FaultId) {
        self.faults.off(id);
    }

    pub(crate) fn counters(&self, node: usize) -> Counters {
        self.stations[node].engine.counters
    }

    /// How a node takes part; `None` without power or cable.
    pub(crate) fn error_state(&self, node: usize) -> Option<ErrorState> {
        let station = &self.stations[node];
        if !station.attached {
            return None;
        }
        if station.bus_off {
            return Some(ErrorState::BusOff);
        }
        Some(station.engine.counters.state())
    }
}
