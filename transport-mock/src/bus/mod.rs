//! The wire and the controllers on it. It knows frames and bits, and no machine.

mod acceptance;
mod attempt;
mod counters;
mod decoder;
mod engine;
mod exact;
mod fault;
mod segment;
mod station;
mod timed;

pub use acceptance::NodeSet;
pub use attempt::{BusError, Sender, SenderOutcome};
pub use counters::{Counters, ErrorState};
pub use engine::Flag;
pub use fault::{Fault, FaultId, Scope, Which};

pub(crate) use attempt::{Attempt, Finished};
pub(crate) use station::{after, span};

use link_core::link::LinkCommandKind;
use link_core::{FilterSet, Frame, Input, Instant, LinkEvent, Mode, TxOutcome, TxToken};

use crate::NodeId;
use crate::record::Interest;
use acceptance::Acceptance;
use engine::{Effect, Phase, RECOVERY_SEQUENCES};
use fault::Faults;
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
            let Some((at, begins)) = state.next(self.faults.next()) else { continue };
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
        let first = self.stations[node].queue.is_empty();
        self.stations[node].queue.push(token, frame, ready);
        let segment = self.stations[node].segment;
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

    pub(crate) fn set_mode(&mut self, now: Instant, node: usize, mode: Mode) -> Result<(), LinkCommandKind> {
        let possible = mode.bit_rate.bit_time_nanos().is_some_and(|bit| bit > 0);
        if !possible {
            return Err(LinkCommandKind::SetMode);
        }
        self.leave(now, node);
        self.drop_all(node);
        self.stations[node].mode = mode;
        self.rejoin(now, node);
        Ok(())
    }

    pub(crate) fn mode(&self, node: usize) -> Mode {
        self.stations[node].mode
    }

    /// The mode at power-up.
    pub(crate) fn reset_mode(&mut self, node: usize) {
        self.stations[node].mode = self.stations[node].mode_at_power_up;
        self.acceptance.set(node, self.stations[node].filter_at_power_up.clone());
    }

    pub(crate) fn set_clock(&mut self, now: Instant, node: usize, ppm: i32) {
        self.leave(now, node);
        self.stations[node].clock_ppm = ppm;
        self.rejoin(now, node);
    }

    pub(crate) fn set_filter(&mut self, node: usize, filter: FilterSet) {
        self.acceptance.set(node, filter);
    }

    /// Restarts a controller. [`LinkEvent::Up`] follows: at once, or after the recovery sequence if it was bus-off.
    pub(crate) fn reset(&mut self, now: Instant, node: usize) -> Result<(), LinkCommandKind> {
        if !self.stations[node].attached {
            return Err(LinkCommandKind::Reset);
        }
        self.leave(now, node);
        self.drop_all(node);
        let station = &mut self.stations[node];
        station.engine.counters = Counters::default();
        if station.bus_off {
            station.announce = true;
            station.engine.enter(Phase::Joining { left: RECOVERY_SEQUENCES, run: 0 });
        } else {
            self.tell(node, LinkEvent::Up);
        }
        self.note_counters(now, node);
        self.rejoin(now, node);
        Ok(())
    }

    /// Power or cable come: the controller starts anew.
    pub(crate) fn attach(&mut self, now: Instant, node: usize) {
        let station = &mut self.stations[node];
        if station.attached {
            return;
        }
        station.attached = true;
        station.bus_off = false;
        station.announce = false;
        station.engine.counters = Counters::default();
        station.known = Counters::default();
        station.suspend_until = now;
        let segment = &mut self.segments[station.segment];
        if segment.members.is_empty() {
            // Nobody has watched the wire until now.
            let next_bit = Instant::from_nanos(now.as_nanos().next_multiple_of(station.bit()));
            segment.free_at = segment.free_at.max(next_bit);
        }
        let place = segment.members.partition_point(|&member| member < node);
        segment.members.insert(place, node);
        self.tell(node, LinkEvent::Up);
        self.rejoin(now, node);
    }

    /// Power or cable go. Returns whether they were there. Frames that waited are answered if `tell`.
    pub(crate) fn detach(&mut self, now: Instant, node: usize, tell: bool) -> bool {
        if !self.stations[node].attached {
            return false;
        }
        self.leave(now, node);
        if tell {
            self.tell(node, LinkEvent::Down);
        }
        let before = self.outbox.len();
        self.drop_all(node);
        if !tell {
            self.outbox.truncate(before);
        }
        let station = &mut self.stations[node];
        station.attached = false;
        station.bus_off = false;
        station.announce = false;
        station.engine.enter(Phase::Off);
        station.engine.counters = Counters::default();
        self.note_counters(now, node);
        let segment = self.stations[node].segment;
        self.segments[segment].members.retain(|&member| member != node);
        self.survey(segment, now);
        true
    }

    /// Moves nodes to a segment of their own. Whoever is in the middle of a frame goes on with it, on either side.
    pub(crate) fn split(&mut self, now: Instant, apart: &[NodeId]) {
        let fresh = self.segments.len();
        let apart: Vec<usize> =
            apart.iter().map(|node| node.index()).filter(|&node| node < self.stations.len()).collect();
        self.regroup(now, |node, segment| if apart.contains(&node) { fresh } else { segment });
    }

    /// Makes one segment of all.
    pub(crate) fn join(&mut self, now: Instant) {
        self.regroup(now, |_, _| 0);
    }

    /// Puts every station on the segment that `place` says, by the station and its segment of now.
    fn regroup(&mut self, now: Instant, place: impl Fn(usize, usize) -> usize) {
        for segment in 0..self.segments.len() {
            self.go_exact(segment, now);
        }
        let old = std::mem::take(&mut self.segments);
        let mut sleeping = Vec::new();
        for node in 0..self.stations.len() {
            let from = self.stations[node].segment;
            let to = place(node, from);
            while self.segments.len() <= to {
                self.segments.push(Segment::new());
            }
            self.stations[node].segment = to;
            let segment = &mut self.segments[to];
            if !self.stations[node].attached {
                continue;
            }
            segment.members.push(node);
            if old[from].activity == Activity::Quiet {
                sleeping.push(node);
            }
            segment.free_at = segment.free_at.max(old[from].free_at);
            segment.bit = segment.bit.or(old[from].bit);
            if segment.activity == Activity::Quiet && old[from].activity != Activity::Quiet {
                segment.activity = old[from].activity;
                segment.attempt = old[from].attempt.clone();
                segment.attempt.open = false;
            }
            // The attempt goes where a sender is.
            let sends =
                |sender: &Sender| sender.node.index() == node && sender.outcome == SenderOutcome::Abandoned;
            if old[from].attempt.open && old[from].attempt.senders.iter().any(sends) {
                segment.attempt = old[from].attempt.clone();
            }
        }
        // Where others are in the middle of something, everybody is simulated bit by bit.
        for node in sleeping {
            if let Some(bit_start) = self.segments[self.stations[node].segment].activity.bit_start() {
                self.wake(node, bit_start);
            }
        }
        for segment in 0..self.segments.len() {
            self.survey(segment, now);
        }
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

    /// A station is about to change in a way that the others may see in the middle of a frame.
    fn leave(&mut self, now: Instant, node: usize) {
        let segment = self.stations[node].segment;
        self.go_exact(segment, now);
        self.segments[segment].attempt.outcome(node, SenderOutcome::Abandoned, now);
    }

    /// A station begins to listen for a free bus, unless it is off or already does.
    fn rejoin(&mut self, now: Instant, node: usize) {
        let station = &mut self.stations[node];
        let recovering = station.bus_off && matches!(station.engine.phase, Phase::Joining { .. });
        if station.attached && !recovering {
            let phase = if station.bus_off { Phase::Off } else { Phase::Joining { left: 1, run: 0 } };
            station.engine.enter(phase);
        }
        station.engine.listen_only = station.mode.listen_only;
        let bit = station.bit();
        station.heard_from = Instant::from_nanos(now.as_nanos().next_multiple_of(bit));
        station.bit_clock.sample_at = station.heard_from;
        station.bit_clock.ends_at = station.heard_from;
        station.bit_clock.sampled = true;
        let segment = station.segment;
        self.survey(segment, now);
    }

    /// Everything that waits will never be sent.
    fn drop_all(&mut self, node: usize) {
        while let Some(mail) = self.stations[node].queue.pop() {
            self.done(node, mail.token, TxOutcome::Dropped);
        }
        self.forget_if_empty(node);
    }

    fn forget_if_empty(&mut self, node: usize) {
        let station = &self.stations[node];
        if station.queue.is_empty() {
            self.segments[station.segment].waiting.retain(|&other| other != node);
        }
    }

    fn done(&mut self, node: usize, token: TxToken, outcome: TxOutcome) {
        self.outbox.push((node, Input::TxDone(token, outcome)));
    }

    fn tell(&mut self, node: usize, event: LinkEvent) {
        self.outbox.push((node, Input::Link(event)));
    }

    /// Hands a frame to a node that wants it.
    fn deliver(&mut self, node: usize, frame: &Frame) {
        if self.faults.overruns(node, frame) {
            self.tell(node, LinkEvent::Overrun { lost: 1 });
        } else {
            self.outbox.push((node, Input::Frame(*frame)));
        }
    }

    /// What a station made of a bit that ended at `now` and began at `began`.
    fn carry_out(&mut self, segment: usize, node: usize, effect: Effect, began: Instant, now: Instant) {
        match effect {
            Effect::None => {}
            Effect::StartOfFrame { may_join } => {
                let station = &mut self.stations[node];
                if may_join && let Some(frame) = station.queue.send(began) {
                    station.engine.join(&frame);
                    self.attempt_sender(segment, node, frame, began);
                }
            }
            Effect::Received(frame) => {
                self.segments[segment].attempt.received(node);
                if self.acceptance.accepts(node, &frame) {
                    self.deliver(node, &frame);
                }
            }
            Effect::Sent => {
                if let Some(mail) = self.stations[node].queue.take_sent() {
                    self.done(node, mail.token, TxOutcome::Sent);
                }
                self.segments[segment].attempt.outcome(node, SenderOutcome::Sent, now);
                self.forget_if_empty(node);
            }
            Effect::LostArbitration { bit } => {
                self.segments[segment].attempt.outcome(node, SenderOutcome::LostArbitration { bit }, now);
                self.gave_up(node);
            }
            Effect::Error(detected) => {
                let error = BusError {
                    at: now,
                    segment,
                    node: NodeId::new(node),
                    kind: detected.kind,
                    place: detected.place,
                    sender: detected.sender,
                    flag: detected.flag,
                };
                self.segments[segment].attempt.failed(&error);
                self.notes.push(Note::Error(error));
                self.tell(node, LinkEvent::BusError(detected.kind));
                self.gave_up(node);
            }
            Effect::Joined => self.joined(node),
        }
    }

    fn joined(&mut self, node: usize) {
        let station = &mut self.stations[node];
        station.bus_off = false;
        if std::mem::take(&mut station.announce) {
            self.tell(node, LinkEvent::Up);
        }
    }

    /// The attempt of a sender has failed: it tries again, unless the frame was withdrawn.
    fn gave_up(&mut self, node: usize) {
        if let Some(mail) = self.stations[node].queue.give_up() {
            self.done(node, mail.token, TxOutcome::Withdrawn);
            self.forget_if_empty(node);
        }
    }

    /// Tells a node and the trace when its counters have changed.
    fn report_counters(&mut self, node: usize, now: Instant) {
        let station = &mut self.stations[node];
        let (before, counters) = (station.known, station.engine.counters);
        if before == counters {
            return;
        }
        self.note_counters(now, node);
        let left = counters.state() == ErrorState::BusOff;
        if counters.warning() && !before.warning() && !left {
            self.tell(node, LinkEvent::ErrorWarning);
        }
        match (before.state(), counters.state()) {
            (ErrorState::Active, ErrorState::Passive) => self.tell(node, LinkEvent::ErrorPassive),
            (ErrorState::Passive, ErrorState::Active) => self.tell(node, LinkEvent::ErrorActive),
            (_, ErrorState::BusOff) => {
                self.stations[node].bus_off = true;
                self.tell(node, LinkEvent::BusOff);
                self.drop_all(node);
            }
            (ErrorState::Active, ErrorState::Active)
            | (ErrorState::Passive, ErrorState::Passive)
            | (ErrorState::BusOff, ErrorState::Active | ErrorState::Passive) => {}
        }
    }

    fn note_counters(&mut self, at: Instant, node: usize) {
        let station = &mut self.stations[node];
        let counters = station.engine.counters;
        if station.known != counters {
            station.known = counters;
            self.notes.push(Note::Counters { at, node: NodeId::new(node), counters });
        }
    }
}
