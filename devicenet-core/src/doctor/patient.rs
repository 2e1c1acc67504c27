//! What the doctor keeps in mind of a node.

use core::time::Duration;

use link_core::{Frame, Instant};

use super::config::ExpectedNode;
use super::rhythm::Rhythm;
use super::setup::{Rejected, Setup};
use crate::id::MacId;
use crate::message::DeviceIdentity;
use crate::monitor::{Predefined, Told};

/// A frame, and when it was.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Seen {
    pub(super) n: u64,
    pub(super) at: Instant,
}

/// One kind of I/O of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Lane {
    /// The first command that is not answered.
    pub(super) since: Option<Seen>,
    /// The last one.
    pub(super) newest: Option<Seen>,
    /// How many.
    pub(super) unanswered: u16,
    /// Commands that others overtook before their answer, up to [`MOST_LATE`]: it may still come.
    late: u16,
    /// The last answer, or what it has produced by itself.
    pub(super) last: Option<Seen>,
    /// Answers in time since the last slow one, up to [`PROMPT_AGAIN`].
    pub(super) prompt: u8,
}

/// Requests to a node that has been silent since the first of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Asked {
    pub(super) first: Seen,
    pub(super) last: Seen,
    pub(super) by: Option<MacId>,
    pub(super) count: u16,
}

/// A duplicate MAC ID check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Check {
    pub(super) seen: Seen,
    pub(super) device: DeviceIdentity,
}

/// A refusal that is part of an orderly start, if the next attempt succeeds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Refused {
    pub(super) seen: Seen,
    pub(super) sign: super::ledger::Sign,
}

/// Answers that nobody has asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Unasked {
    pub(super) first: Seen,
    pub(super) count: u16,
}

/// The last frame of the I/O between a slave and its master.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Sent {
    at: Instant,
    id: u32,
    data: [u8; 8],
    len: u8,
}

/// What the doctor keeps in mind of a node.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Patient {
    lanes: [Lane; 4],
    pub(super) asked: Option<Asked>,
    pub(super) was_heard: bool,
    pub(super) check: Option<Check>,
    pub(super) told: Told,
    pub(super) owner: Option<MacId>,
    pub(super) refused: Option<Refused>,
    pub(super) unasked: Option<Unasked>,
    sent: Option<Sent>,
    /// When the last frame of a command was.
    pub(super) commanded: Option<Instant>,
    /// How many answers came twice of late: more for one that did, less for one that did not.
    pub(super) doubled: u8,
    /// What it has produced by change of state or cyclic.
    pub(super) rhythm: Rhythm,
    pub(super) setup: Option<Setup>,
    pub(super) rejected: Option<Rejected>,
    /// The device that has the MAC ID, once it was on line.
    pub(super) holder: Option<DeviceIdentity>,
    pub(super) expected: Option<ExpectedNode>,
    /// It was heard while the doctor was learning.
    pub(super) is_learned: bool,
    /// Its owner at that time: whoever takes it over later does not become it.
    pub(super) learned_owner: Option<MacId>,
}

impl Lane {
    const NEW: Self =
        Self { since: None, newest: None, unanswered: 0, late: 0, last: None, prompt: PROMPT_AGAIN };

    /// A command that wants an answer.
    pub(super) fn command(&mut self, seen: Seen) {
        self.since.get_or_insert(seen);
        self.newest = Some(seen);
        self.unanswered = self.unanswered.saturating_add(1);
    }

    /// An answer; returns the first command that had none before.
    pub(super) fn answer(&mut self, seen: Seen) -> Option<Seen> {
        self.last = Some(seen);
        self.late = self.late.saturating_add(self.unanswered.saturating_sub(1)).min(MOST_LATE);
        self.unanswered = 0;
        self.since.take()
    }

    /// An answer in time.
    pub(super) fn is_in_time(&mut self) {
        self.prompt = self.prompt.saturating_add(1).min(PROMPT_AGAIN);
    }

    /// Whether an answer without a command is one to a command that was overtaken.
    fn is_late(&mut self) -> bool {
        let late = self.late.checked_sub(1);
        self.late = late.unwrap_or_default();
        late.is_some()
    }

    /// No command waits.
    pub(super) fn settle(&mut self) {
        (self.since, self.unanswered) = (None, 0);
    }

    /// For how long nothing has been answered, if that is more than a single command.
    pub(super) fn silence(&self, now: Instant) -> Option<Duration> {
        let since = self.since.filter(|_| self.unanswered >= FEWEST_COMMANDS)?;
        Some(now.saturating_since(since.at))
    }
}

impl Patient {
    pub(super) const NEW: Self = Self {
        lanes: [Lane::NEW; 4],
        asked: None,
        was_heard: false,
        check: None,
        told: Told { vendor: None, device_type: None, product: None, revision: None, serial: None },
        owner: None,
        refused: None,
        unasked: None,
        sent: None,
        commanded: None,
        doubled: 0,
        rhythm: Rhythm::NEW,
        setup: None,
        rejected: None,
        holder: None,
        expected: None,
        is_learned: false,
        learned_owner: None,
    };

    /// Its I/O; explicit messages have no lane.
    pub(super) fn lane(&mut self, which: Predefined) -> &mut Lane {
        let [poll, strobe, changes, multicast] = &mut self.lanes;
        match which {
            Predefined::Poll | Predefined::Explicit => poll,
            Predefined::BitStrobe => strobe,
            Predefined::CosCyclic => changes,
            Predefined::MulticastPoll => multicast,
        }
    }

    pub(super) const fn peek(&self, which: Predefined) -> &Lane {
        let [poll, strobe, changes, multicast] = &self.lanes;
        match which {
            Predefined::Poll | Predefined::Explicit => poll,
            Predefined::BitStrobe => strobe,
            Predefined::CosCyclic => changes,
            Predefined::MulticastPoll => multicast,
        }
    }

    /// Takes note of a frame of its I/O. True if it is the one before again, at once: for somebody it was destroyed in its last bit, or
    /// somebody else sends the same.
    pub(super) fn repeats(&mut self, at: Instant, frame: &Frame) -> bool {
        let mut sent = Sent { at, id: frame.raw_id(), data: [0; 8], len: frame.dlc() };
        sent.data.iter_mut().zip(frame.data()).for_each(|(byte, &value)| *byte = value);
        let before = self.sent.replace(sent);
        before.is_some_and(|before| Sent { at, ..before } == sent && at.saturating_since(before.at) <= AGAIN)
    }

    /// Whether an answer without a command is one to a command that was overtaken.
    pub(super) fn is_late(&mut self) -> bool {
        self.lanes.iter_mut().any(Lane::is_late)
    }

    /// No kind of I/O was answered slowly of late.
    pub(super) fn is_prompt(&self) -> bool {
        self.lanes.iter().all(|lane| lane.prompt >= PROMPT_AGAIN)
    }

    /// Nothing was heard for a while: what waited for an answer waits no longer.
    pub(super) fn wait_anew(&mut self) {
        self.begin_anew();
        (self.asked, self.unasked, self.setup, self.sent) = (None, None, None, None);
        self.rhythm = Rhythm::NEW;
    }

    /// Its connections begin anew.
    pub(super) fn begin_anew(&mut self) {
        self.lanes.iter_mut().for_each(|lane| {
            lane.settle();
            (lane.last, lane.prompt) = (None, PROMPT_AGAIN);
        });
    }
}

/// A frame is sent again at once, at the lowest bit rate after a millisecond, and another one can have come in between.
pub(super) const AGAIN: Duration = Duration::from_millis(3);
/// Answers that may be late at a time: a slave has hardly room for more commands.
const MOST_LATE: u16 = 8;
/// So many answers in time end the finding of slow ones.
const PROMPT_AGAIN: u8 = 10;
/// One command can be lost; the slave need not have been.
const FEWEST_COMMANDS: u16 = 2;
