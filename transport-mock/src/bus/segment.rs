//! A segment of the bus: who is on it, what is going on, and what comes next.

use link_core::wire::INTERMISSION_BITS;
use link_core::{Frame, Instant};

use super::attempt::Attempt;
use super::phase::Phase;
use super::{Bus, NodeSet, after};

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
    pub(super) acknowledging: usize,
    /// On the exact path: members that are simulated, and those that are in the same state as one of them, by its place.
    pub(super) leaders: Vec<usize>,
    pub(super) followers: Vec<(usize, usize)>,
    /// Members that wait for a free bus.
    pub(super) joining: Vec<usize>,
    /// Members with mail.
    pub(super) waiting: Vec<usize>,
    /// Members with REC > 0.
    pub(super) blamed: Vec<usize>,
    /// The length of a bit, if all members agree.
    pub(super) bit: Option<u64>,
    pub(super) activity: Activity,
    /// The end of the intermission: nobody begins before.
    pub(super) free_at: Instant,
    /// Who sent the last frame on the cheap path: a transmitter until its intermission is over.
    pub(super) last_sender: Option<usize>,
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
        if self.segments[index].members.is_empty() {
            // Nobody is left to end what was begun.
            self.close_attempt(index, now);
        }
        let segment = &mut self.segments[index];
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
}
