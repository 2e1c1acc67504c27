//! A segment of the bus, and the cheap path: a frame that nothing can go wrong with takes two steps, its beginning and
//! its end.

use link_core::wire::{INTERMISSION_BITS, bits};
use link_core::{Frame, Instant, TxOutcome};

use super::attempt::{Attempt, Sender, SenderOutcome};
use super::counters::ErrorState;
use super::engine::{JOINING_RUN, Phase, SUSPEND_BITS};
use super::{Bus, NodeSet, after, span};
use crate::NodeId;
use crate::record::Interest;

/// How the present moment is simulated.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Activity {
    /// Nobody sends.
    Quiet,
    /// One frame, whose outcome is certain. Nothing changes before its end, so that it can be simulated from its
    /// beginning when the unexpected happens.
    Quick { start: Instant, end: Instant, bit: u64, sender: usize, frame: Frame },
    /// Bit by bit, all stations in step. `begun`: the bit that begins at `bit_start` has begun.
    Exact { bit_start: Instant, begun: bool },
    /// Each station at its own bit rate.
    Timed { next: Instant },
}

impl Activity {
    /// The beginning of the present bit.
    pub(super) const fn bit_start(&self) -> Option<Instant> {
        match self {
            Self::Exact { bit_start, .. } => Some(*bit_start),
            Self::Timed { next } => Some(*next),
            Self::Quiet | Self::Quick { .. } => None,
        }
    }
}

/// Stations that see the same wire.
#[derive(Clone, Debug)]
pub(crate) struct Segment {
    /// Attached stations, in order.
    pub(super) members: Vec<usize>,
    /// Those that take part: all but the bus-off ones and those that wait for a free bus.
    pub(super) joined: NodeSet,
    /// Those of them that acknowledge.
    acknowledging: usize,
    /// On the exact path: members that are simulated, and those that are in the same state as one of them, by its place.
    pub(super) leaders: Vec<usize>,
    pub(super) followers: Vec<(usize, usize)>,
    /// Members that wait for a free bus.
    joining: Vec<usize>,
    /// Members with mail.
    pub(super) waiting: Vec<usize>,
    /// Members with REC > 0.
    blamed: Vec<usize>,
    /// The length of a bit, if all members agree.
    pub(super) bit: Option<u64>,
    pub(super) activity: Activity,
    /// The end of the intermission: nobody begins before.
    pub(super) free_at: Instant,
    /// Who sent the last frame on the cheap path: a transmitter until its intermission is over.
    last_sender: Option<usize>,
    /// When the next frame begins, while the segment is quiet.
    next_start: Instant,
    /// When the first of `joining` has joined, while the segment is quiet.
    next_join: Instant,
    /// The attempt that is under way, if it is open.
    pub(super) attempt: Attempt,
}

impl Segment {
    pub(super) fn new() -> Self {
        Self {
            members: Vec::new(),
            joined: NodeSet::default(),
            acknowledging: 0,
            leaders: Vec::new(),
            followers: Vec::new(),
            joining: Vec::new(),
            waiting: Vec::new(),
            blamed: Vec::new(),
            bit: None,
            activity: Activity::Quiet,
            free_at: Instant::ZERO,
            last_sender: None,
            next_start: Instant::MAX,
            next_join: Instant::MAX,
            attempt: Attempt::new(),
        }
    }

    /// When something happens here next, and whether it is a beginning.
    pub(super) fn next(&self, disturbed: Instant, now: Instant) -> Option<(Instant, bool)> {
        match self.activity {
            Activity::Quick { end, .. } => Some((end, false)),
            Activity::Exact { bit_start, begun: false } => Some((bit_start, true)),
            Activity::Exact { bit_start, begun: true } => Some((after(bit_start, self.bit?), false)),
            Activity::Timed { next } => Some((next, false)),
            Activity::Quiet => {
                let mut at = self.next_start;
                if disturbed != Instant::MAX && !self.members.is_empty() {
                    // The bits of another segment may lie otherwise: what began before now is too late.
                    at = at.min(self.bit_of(disturbed.max(self.free_at)).max(self.align(now)));
                }
                if self.next_join <= at {
                    return (self.next_join != Instant::MAX).then_some((self.next_join, false));
                }
                (at != Instant::MAX).then_some((at, true))
            }
        }
    }

    /// The bit that `at` is in.
    fn bit_of(&self, at: Instant) -> Instant {
        let nanos = at.as_nanos();
        Instant::from_nanos(nanos - self.bit.map_or(0, |bit| nanos % bit))
    }

    /// The first bit that begins at `at` or later.
    fn align(&self, at: Instant) -> Instant {
        match self.bit {
            Some(bit) if at != Instant::MAX => Instant::from_nanos(at.as_nanos().next_multiple_of(bit)),
            Some(_) | None => at,
        }
    }
}

impl Bus {
    /// Takes stock of the members of a segment after any change that is not part of the cheap path.
    pub(super) fn survey(&mut self, index: usize, now: Instant) {
        self.dissolve(index);
        let segment = &mut self.segments[index];
        segment.joined.clear();
        segment.joining.clear();
        segment.waiting.clear();
        segment.blamed.clear();
        segment.acknowledging = 0;
        let mut bit = None;
        let mut uniform = true;
        for &node in &segment.members {
            let station = &self.stations[node];
            let own = station.bit();
            uniform &= *bit.get_or_insert(own) == own;
            if station.has_joined() {
                segment.joined.insert(node);
                segment.acknowledging += usize::from(!station.mode.listen_only);
            } else if matches!(station.engine.phase, Phase::Joining { .. }) {
                segment.joining.push(node);
            }
            if !station.queue.is_empty() {
                segment.waiting.push(node);
            }
            if station.engine.counters.rec > 0 {
                segment.blamed.push(node);
            }
        }
        let bit = bit.filter(|_| uniform);
        let timing_changed = segment.bit != bit;
        segment.bit = bit;
        match segment.activity {
            Activity::Exact { .. } | Activity::Timed { .. } if segment.members.is_empty() => {
                segment.activity = Activity::Quiet;
                segment.free_at = now;
            }
            Activity::Exact { bit_start, begun } if timing_changed => {
                self.go_timed(index, bit_start, begun, now)
            }
            Activity::Quiet | Activity::Quick { .. } | Activity::Exact { .. } | Activity::Timed { .. } => {}
        }
        self.plan(index);
    }

    /// Finds out when the next frame begins and the next station joins.
    pub(super) fn plan(&mut self, index: usize) {
        let segment = &self.segments[index];
        let next_join = segment
            .joining
            .iter()
            .filter_map(|&node| self.stations[node].joins_at())
            .min()
            .unwrap_or(Instant::MAX)
            .max(segment.free_at);
        let next_start = segment
            .waiting
            .iter()
            .filter_map(|&node| self.begins_at(index, node))
            .min()
            .unwrap_or(Instant::MAX);
        let segment = &mut self.segments[index];
        segment.next_join = next_join;
        segment.next_start = next_start;
    }

    /// The plan after a node got one more frame to send.
    pub(super) fn plan_for(&mut self, index: usize, node: usize, ready: Instant) {
        let (segment, station) = (&self.segments[index], &self.stations[node]);
        if station.has_joined() {
            let at = segment.align(ready.max(segment.free_at).max(station.suspend_until));
            self.segments[index].next_start = segment.next_start.min(at);
        }
    }

    /// When a station may begin its next frame.
    fn begins_at(&self, index: usize, node: usize) -> Option<Instant> {
        let (segment, station) = (&self.segments[index], &self.stations[node]);
        let ready = station.queue.earliest().filter(|_| station.has_joined())?;
        Some(segment.align(ready.max(segment.free_at).max(station.suspend_until)))
    }

    /// The quiet is over: somebody has joined, the wire is disturbed, or a frame begins.
    pub(super) fn begin(&mut self, index: usize, at: Instant) {
        if self.segments[index].next_join <= at {
            self.complete_joining(index, at);
            self.plan(index);
            return;
        }
        if self.segments[index].next_start > at {
            self.enter_exact(index, at);
            return;
        }
        let Some((sender, frame, unique)) = self.contest(index, at) else {
            self.plan(index);
            return;
        };
        let bit = self.segments[index].bit.unwrap_or(self.stations[sender].bit());
        let struck = self.open_attempt(index, at, bit, &frame);
        let segment = &self.segments[index];
        let len = u64::from(frame.bit_len());
        let free_again = after(at, (len + u64::from(INTERMISSION_BITS)) * bit);
        let certain = unique
            && !struck
            && !self.force_exact
            && segment.bit.is_some()
            && segment.acknowledging >= 2
            && self.faults.next() >= free_again;
        if !certain {
            self.enter_exact(index, at);
            self.spoil(index);
            return;
        }
        self.segments[index].activity =
            Activity::Quick { start: at, end: after(at, len * bit), bit, sender, frame };
    }

    /// Who wins arbitration among those that begin at `at`, and whether its first place is its own.
    fn contest(&self, index: usize, at: Instant) -> Option<(usize, Frame, bool)> {
        let mut best: Option<(u32, usize, &Frame)> = None;
        let mut unique = true;
        for &node in &self.segments[index].waiting {
            let station = &self.stations[node];
            if station.suspend_until > at || !station.has_joined() {
                continue;
            }
            let Some(mail) = station.queue.head(at) else { continue };
            match best {
                Some((key, ..)) if mail.key > key => {}
                Some((key, ..)) if mail.key == key => unique = false,
                Some(_) | None => {
                    best = Some((mail.key, node, &mail.frame));
                    unique = true;
                }
            }
        }
        best.map(|(_, node, frame)| (node, *frame, unique))
    }

    /// The end of a frame on the cheap path.
    pub(super) fn finish_quick(&mut self, index: usize) {
        let Activity::Quick { start, end, bit, sender, frame } = self.segments[index].activity else {
            return;
        };
        if self.interest.contains(Interest::LOSERS) {
            self.record_contenders(index, start, sender, &frame);
        } else if !self.interest.is_empty() {
            let attempt = &mut self.segments[index].attempt;
            attempt.senders.push(Sender { node: NodeId::new(sender), frame, outcome: SenderOutcome::Sent });
        }
        let segment = &mut self.segments[index];
        segment.activity = Activity::Quiet;
        segment.last_sender = Some(sender);
        segment.free_at = after(end, u64::from(INTERMISSION_BITS) * bit);
        let attempt = &mut segment.attempt;
        attempt.frame = Some(frame);
        (attempt.sent, attempt.settled) = (true, end);
        if self.interest.contains(Interest::RECEIVERS) {
            attempt.receivers.copy_from(&segment.joined);
            attempt.receivers.remove(sender);
        }

        self.stations[sender].queue.send(start);
        let token = self.stations[sender].queue.take_sent().map(|mail| mail.token);
        if self.stations[sender].queue.is_empty() {
            self.segments[index].waiting.retain(|&node| node != sender);
        }
        // Out of the way while the stations are told.
        let acceptance = std::mem::replace(&mut self.acceptance, super::Acceptance::new());
        let joined = std::mem::take(&mut self.segments[index].joined);
        acceptance.for_each(&frame, &joined, sender, |node| {
            if node != sender {
                self.deliver(node, &frame);
            } else if let Some(token) = token {
                self.done(sender, token, TxOutcome::Sent);
            }
        });
        self.acceptance = acceptance;
        self.segments[index].joined = joined;
        self.close_attempt(index, end);
        self.settle_counters(index, sender, bit, end);
        self.break_joining(index, start, end, bit);
        self.plan(index);
    }

    /// The counters after a frame that all have received.
    fn settle_counters(&mut self, index: usize, sender: usize, bit: u64, end: Instant) {
        // In the order of the nodes, as on the exact path.
        let mut blamed = std::mem::take(&mut self.segments[index].blamed);
        let mut before = true;
        blamed.retain(|&node| {
            if before && node >= sender {
                before = false;
                self.settle_sender(sender, bit, end);
            }
            let station = &mut self.stations[node];
            if node != sender && station.has_joined() && !station.mode.listen_only {
                station.engine.counters.received();
                self.report_counters(node, end);
            }
            self.stations[node].engine.counters.rec > 0
        });
        self.segments[index].blamed = blamed;
        if before {
            self.settle_sender(sender, bit, end);
        }
    }

    fn settle_sender(&mut self, sender: usize, bit: u64, end: Instant) {
        let station = &mut self.stations[sender];
        station.engine.counters.sent();
        if station.engine.counters.state() == ErrorState::Passive {
            let bits = INTERMISSION_BITS + u32::from(SUSPEND_BITS);
            station.suspend_until = after(end, u64::from(bits) * bit);
        }
        self.report_counters(sender, end);
    }

    /// A frame interrupts the recessive run that joining stations count.
    fn break_joining(&mut self, index: usize, start: Instant, end: Instant, bit: u64) {
        // ACK delimiter and end of frame are eight recessive bits, and the intermission follows.
        let recessive_since = Instant::from_nanos(end.as_nanos().saturating_sub(8 * bit));
        for &node in &self.segments[index].joining {
            let station = &mut self.stations[node];
            let Phase::Joining { left, .. } = station.engine.phase else { continue };
            let sequences = span(station.heard_from, start) / (u64::from(JOINING_RUN) * station.bit());
            let left = left - u16::try_from(sequences).unwrap_or(u16::MAX).min(left);
            station.engine.phase = Phase::Joining { left: left.max(1), run: 0 };
            station.heard_from = station.heard_from.max(recessive_since);
        }
    }

    fn complete_joining(&mut self, index: usize, at: Instant) {
        let joining = std::mem::take(&mut self.segments[index].joining);
        for node in joining {
            if self.stations[node].joins_at().is_some_and(|joins| joins <= at) {
                self.stations[node].engine.phase = Phase::Idle;
                // What waited until now cannot begin in the past.
                self.stations[node].suspend_until = at;
                self.joined(node);
            }
        }
        self.survey(index, at);
    }

    /// Who began together with the winner of a frame on the cheap path, and in which bit they lost.
    fn record_contenders(&mut self, index: usize, start: Instant, winner: usize, frame: &Frame) {
        let segment = &mut self.segments[index];
        for &node in &segment.waiting {
            let station = &self.stations[node];
            if station.suspend_until > start || !station.has_joined() {
                continue;
            }
            let Some(mail) = station.queue.head(start) else { continue };
            let outcome = if node == winner {
                SenderOutcome::Sent
            } else {
                SenderOutcome::LostArbitration { bit: first_difference(&mail.frame, frame) }
            };
            segment.attempt.senders.push(Sender { node: NodeId::new(node), frame: mail.frame, outcome });
        }
        segment.attempt.senders.sort_unstable_by_key(|sender| sender.node);
    }

    /// Simulates a segment bit by bit from now on. What was passed over quickly is made up for: a frame from its
    /// beginning, an intermission from the end of the frame.
    pub(super) fn go_exact(&mut self, index: usize, now: Instant) {
        let segment = &self.segments[index];
        match segment.activity {
            Activity::Quick { start, .. } => {
                self.enter_exact(index, start);
                self.spoil(index);
                self.replay_exact(index, now);
            }
            Activity::Quiet if now < segment.free_at => {
                let Some(bit) = segment.bit else { return };
                let (free_at, intermission) = (segment.free_at, u64::from(INTERMISSION_BITS) * bit);
                let sender = segment.last_sender;
                self.enter_exact(index, Instant::from_nanos(free_at.as_nanos() - intermission));
                for place in 0..self.segments[index].members.len() {
                    let node = self.segments[index].members[place];
                    if self.stations[node].has_joined() {
                        self.stations[node].engine.pause(sender == Some(node));
                    }
                }
                self.replay_exact(index, now);
            }
            Activity::Quiet | Activity::Exact { .. } | Activity::Timed { .. } => {}
        }
    }
}

/// The first bit in which two frames differ.
fn first_difference(one: &Frame, other: &Frame) -> u32 {
    let equal =
        bits(one).zip(bits(other)).take_while(|(one, other)| one.recessive == other.recessive).count();
    u32::try_from(equal).unwrap_or(u32::MAX)
}
