//! What is known about the frame that is on the bus, or was last.

use link_core::wire::Field;
use link_core::{BusErrorKind, Frame, Instant};

use super::acceptance::NodeSet;
use super::phase::Flag;
use super::{Bus, span};
use crate::NodeId;

/// An error that one controller detected.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct BusError {
    /// The end of the bit in which it was detected.
    pub at: Instant,
    /// On which segment, 0 unless the bus is split.
    pub segment: usize,
    /// Who detected it.
    pub node: NodeId,
    /// What was wrong.
    pub kind: BusErrorKind,
    /// The bit, 0 being the start of frame and stuff bits counted, and its field; `None` in an error flag or a
    /// delimiter.
    pub place: Option<(u32, Field)>,
    /// It was the sender of the frame.
    pub sender: bool,
    /// How it tells the others.
    pub flag: Flag,
}

/// A node that began to send.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Sender {
    /// Who.
    pub node: NodeId,
    /// What it wanted to send.
    pub frame: Frame,
    /// What came of it.
    pub outcome: SenderOutcome,
}

/// What came of an attempt to send.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum SenderOutcome {
    /// Sent and acknowledged.
    Sent,
    /// Another frame had priority, seen in this bit (0 is the start of frame, stuff bits count).
    LostArbitration {
        /// The bit that was sent recessive and seen dominant.
        bit: u32,
    },
    /// It met an error.
    Error(BusErrorKind),
    /// The controller was switched off, cut off or reset while it sent.
    Abandoned,
}

/// An attempt to send a frame, by one or more nodes that began in the same bit.
#[derive(Clone, Debug)]
pub(crate) struct Attempt {
    pub(crate) number: u64,
    pub(crate) segment: usize,
    pub(crate) open: bool,
    pub(crate) start: Instant,
    pub(crate) end: Instant,
    /// What is on the bus, as far as it can be told: the frame that was sent, or else that of the last sender.
    pub(crate) frame: Option<Frame>,
    pub(crate) senders: Vec<Sender>,
    pub(crate) receivers: NodeSet,
    /// The first error.
    pub(crate) error: Option<BusError>,
    pub(crate) sent: bool,
    /// The end of the bit after which nobody was occupied with it any more, where the stations are not in step.
    pub(crate) over: Option<Instant>,
    /// When the outcome of a sender was known last.
    pub(crate) settled: Instant,
    /// Receivers for which its end is spoilt.
    pub(crate) spoilt: Vec<NodeId>,
}

impl Attempt {
    pub(crate) fn new() -> Self {
        Self {
            number: 0,
            segment: 0,
            open: false,
            start: Instant::ZERO,
            end: Instant::ZERO,
            frame: None,
            senders: Vec::new(),
            receivers: NodeSet::default(),
            error: None,
            sent: false,
            over: None,
            settled: Instant::ZERO,
            spoilt: Vec::new(),
        }
    }

    pub(crate) fn begin(&mut self, number: u64, at: Instant) {
        self.number = number;
        self.open = true;
        self.start = at;
        self.senders.clear();
        self.receivers.clear();
        self.error = None;
        self.sent = false;
        self.over = None;
    }

    pub(crate) fn received(&mut self, node: usize) {
        if self.open {
            self.receivers.insert(node);
        }
    }

    pub(crate) fn failed(&mut self, error: &BusError) {
        if !self.open {
            return;
        }
        self.error.get_or_insert(*error);
        if error.sender {
            self.outcome(error.node.index(), SenderOutcome::Error(error.kind), error.at);
        }
    }

    /// Settles what became of a sender, once.
    pub(crate) fn outcome(&mut self, node: usize, outcome: SenderOutcome, now: Instant) {
        let undecided =
            |sender: &&mut Sender| sender.node.index() == node && sender.outcome == SenderOutcome::Abandoned;
        if let Some(sender) = self.senders.iter_mut().find(undecided) {
            sender.outcome = outcome;
            self.settled = now;
            self.sent |= outcome == SenderOutcome::Sent;
            if !matches!(outcome, SenderOutcome::LostArbitration { .. }) {
                self.frame = Some(sender.frame);
            }
        }
    }
}

/// Attempts that are over and not recorded yet. Their memory is used again.
#[derive(Clone, Debug, Default)]
pub(crate) struct Finished {
    attempts: Vec<Attempt>,
    len: usize,
}

impl Finished {
    /// Takes the attempt, and leaves an older one in its place.
    fn push(&mut self, attempt: &mut Attempt) {
        if self.len == self.attempts.len() {
            self.attempts.push(Attempt::new());
        }
        std::mem::swap(attempt, &mut self.attempts[self.len]);
        self.len += 1;
    }

    pub(crate) fn as_slice(&self) -> &[Attempt] {
        &self.attempts[..self.len]
    }

    pub(crate) const fn is_empty(&self) -> bool {
        self.len == 0
    }

    pub(crate) const fn clear(&mut self) {
        self.len = 0;
    }
}

impl Bus {
    /// A frame begins at `at`; of those that begin together, `first` has priority. Returns whether a fault strikes it.
    pub(super) fn open_attempt(&mut self, segment: usize, at: Instant, bit: u64, first: &Frame) -> bool {
        self.close_attempt(segment, at);
        self.attempts += 1;
        let attempt = &mut self.segments[segment].attempt;
        attempt.begin(self.attempts, at);
        let key = first.arbitration_key();
        let hears = |node: NodeId| {
            self.stations.get(node.index()).is_some_and(|station| {
                let sends = station.queue.head(at).is_some_and(|mail| mail.key == key);
                station.segment == segment && station.has_joined() && !sends
            })
        };
        self.faults.frame_starts(segment, at, bit, first, hears, &mut attempt.spoilt)
    }

    /// A node begins to send in the bit that begins at `at`.
    pub(super) fn attempt_sender(&mut self, segment: usize, node: usize, frame: Frame, at: Instant) {
        let attempt = &self.segments[segment].attempt;
        let bit = self.stations[node].bit();
        // Controllers that are not in step may begin less than a bit apart.
        if !attempt.open || span(attempt.start, at) >= bit {
            self.open_attempt(segment, at, bit, &frame);
            self.spoil(segment);
        }
        let attempt = &mut self.segments[segment].attempt;
        attempt.frame = Some(frame);
        attempt.senders.push(Sender { node: NodeId::new(node), frame, outcome: SenderOutcome::Abandoned });
    }

    /// The attempt is over, if there is one.
    pub(super) fn close_attempt(&mut self, segment: usize, at: Instant) {
        let attempt = &mut self.segments[segment].attempt;
        if !std::mem::take(&mut attempt.open) || self.interest.is_empty() {
            return;
        }
        attempt.end = if attempt.sent { attempt.settled } else { at };
        attempt.segment = segment;
        self.finished.push(attempt);
    }

    /// Tells the receivers for which the end of the frame is spoilt.
    pub(super) fn spoil(&mut self, segment: usize) {
        for index in 0..self.segments[segment].members.len() {
            let node = self.segments[segment].members[index];
            self.stations[node].engine.spoil_end =
                self.segments[segment].attempt.spoilt.contains(&NodeId::new(node));
        }
    }
}
