//! Everything that can be seen from outside.

use std::fmt;

use bitflags::bitflags;
use link_core::{Frame, Instant, TxOutcome, TxToken};

use crate::bus::{Attempt, BusError, Counters, NodeSet, Sender};
use crate::change::ChangeKind;
use crate::network::NodeId;
use crate::referee::Violation;

/// Something that happened, as a [`Sink`] or a [`Rule`](crate::Rule) sees it.
#[derive(Debug)]
pub enum Record<'a, E> {
    /// An attempt to send a frame is over.
    Frame(FrameRecord<'a>),
    /// A controller has detected an error.
    Error(BusError),
    /// The error counters of a controller have changed.
    Counters {
        /// When.
        at: Instant,
        /// Whose.
        node: NodeId,
        /// What they are now.
        counters: Counters,
    },
    /// A machine wants a frame to be sent.
    Request {
        /// When, on the clock of the network.
        at: Instant,
        /// Which node.
        node: NodeId,
        /// By which name it will be answered.
        token: TxToken,
        /// What.
        frame: Frame,
    },
    /// A machine is told what became of a frame.
    Done {
        /// When, on the clock of the network.
        at: Instant,
        /// Which node.
        node: NodeId,
        /// Which frame.
        token: TxToken,
        /// What became of it.
        outcome: TxOutcome,
    },
    /// A machine has something to tell.
    Event {
        /// When, on the clock of the network.
        at: Instant,
        /// Which node.
        node: NodeId,
        /// What.
        event: &'a E,
    },
    /// Somebody interfered: power, cable, faults.
    Change {
        /// When.
        at: Instant,
        /// What was done.
        change: ChangeKind<'a>,
    },
    /// A rule of the bus was broken.
    Violation(&'a Violation),
}

/// An attempt to send a frame, from the start of frame to the end of frame or error delimiter.
#[derive(Clone, Copy, Debug)]
pub struct FrameRecord<'a> {
    /// Counts the attempts on all segments, from 1.
    pub number: u64,
    /// On which segment, 0 unless the bus is split.
    pub segment: usize,
    /// The begin of the start of frame.
    pub start: Instant,
    /// The end of the end of frame, or of the error delimiter.
    pub end: Instant,
    /// What was on the bus; after an error, what the last sender wanted to send.
    pub frame: &'a Frame,
    /// What came of it.
    pub outcome: Outcome,
    /// Who began to send, in the order of the nodes. Those that lost arbitration are there if
    /// [`Interest::LOSERS`] was asked for, or when the frame was simulated bit by bit.
    pub senders: &'a [Sender],
    /// Whose controllers received the frame without an error, whether their filters wanted it or not; if
    /// [`Interest::RECEIVERS`] was asked for, or when the frame was simulated bit by bit.
    pub receivers: &'a NodeSet,
}

/// What came of an attempt.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Outcome {
    /// A sender has sent it, and another node has acknowledged it.
    Ok,
    /// The first error that destroyed it.
    Error(BusError),
    /// The last sender was switched off, cut off or reset.
    Abandoned,
}

impl<'a> FrameRecord<'a> {
    pub(crate) fn of(attempt: &'a Attempt) -> Option<Self> {
        Some(Self {
            number: attempt.number,
            segment: attempt.segment,
            start: attempt.start,
            end: attempt.end,
            frame: attempt.frame.as_ref()?,
            outcome: match attempt.error {
                _ if attempt.sent => Outcome::Ok,
                Some(error) => Outcome::Error(error),
                None => Outcome::Abandoned,
            },
            senders: &attempt.senders,
            receivers: &attempt.receivers,
        })
    }
}

bitflags! {
    /// What a sink wants to see. What nobody wants to see is not put together.
    #[derive(Clone, Copy, PartialEq, Eq, Debug)]
    pub struct Interest: u16 {
        /// [`Record::Frame`]
        const FRAMES = 1 << 0;
        /// [`FrameRecord::senders`] with those that lost arbitration.
        const LOSERS = 1 << 1;
        /// [`FrameRecord::receivers`]
        const RECEIVERS = 1 << 2;
        /// [`Record::Error`]
        const ERRORS = 1 << 3;
        /// [`Record::Counters`]
        const COUNTERS = 1 << 4;
        /// [`Record::Request`] and [`Record::Done`]
        const REQUESTS = 1 << 5;
        /// [`Record::Event`]
        const EVENTS = 1 << 6;
        /// [`Record::Change`]
        const CHANGES = 1 << 7;
        /// [`Record::Violation`]
        const VIOLATIONS = 1 << 8;
    }
}

/// Takes records. Closures are sinks that want everything, and must name the type of their argument:
/// `|record: &Record<'_, E>|`. [`Ignore`] wants nothing.
pub trait Sink<E> {
    /// What it wants to see.
    fn interest(&self) -> Interest {
        Interest::all()
    }

    /// Takes a record.
    fn record(&mut self, record: &Record<'_, E>);
}

impl<E, F: FnMut(&Record<'_, E>)> Sink<E> for F {
    fn record(&mut self, record: &Record<'_, E>) {
        self(record);
    }
}

/// A sink that wants less than everything.
#[derive(Debug)]
pub struct Only<S>(pub Interest, pub S);

impl<E, S: Sink<E>> Sink<E> for Only<S> {
    fn interest(&self) -> Interest {
        self.0 & self.1.interest()
    }

    fn record(&mut self, record: &Record<'_, E>) {
        self.1.record(record);
    }
}

/// A sink that drops everything.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Ignore;

impl<E> Sink<E> for Ignore {
    fn interest(&self) -> Interest {
        Interest::empty()
    }

    fn record(&mut self, _: &Record<'_, E>) {}
}

/// `0.001234567 #3 100 [2] 01 02 ok from 0`, one line for each record. For tests and bug reports of the bus itself.
impl<E: fmt::Debug> fmt::Display for Record<'_, E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Frame(frame) => write!(f, "{frame}"),
            Self::Error(error) => write!(f, "{error}"),
            Self::Counters { at, node, counters } => {
                write!(f, "{at} {node} TEC {} REC {}", counters.tec, counters.rec)
            }
            Self::Request { at, node, token, frame } => write!(f, "{at} {node} requests {} {frame}", token.0),
            Self::Done { at, node, token, outcome } => write!(f, "{at} {node} done {} {outcome:?}", token.0),
            Self::Event { at, node, event } => write!(f, "{at} {node} {event:?}"),
            Self::Change { at, change } => write!(f, "{at} {change:?}"),
            Self::Violation(violation) => write!(f, "{violation}"),
        }
    }
}

impl fmt::Display for FrameRecord<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} to {} #{} {}", self.start, self.end, self.number, self.frame)?;
        match self.outcome {
            Outcome::Ok => f.write_str(" ok")?,
            Outcome::Error(error) => write!(f, " {}", error.kind)?,
            Outcome::Abandoned => f.write_str(" abandoned")?,
        }
        self.senders.iter().try_for_each(|sender| write!(f, ", {} {:?}", sender.node, sender.outcome))?;
        f.write_str(", received by")?;
        self.receivers.iter().try_for_each(|node| write!(f, " {node}"))
    }
}

impl fmt::Display for BusError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {} {}", self.at, self.node, self.kind)?;
        if let Some((bit, field)) = self.place {
            write!(f, " in bit {bit} ({field:?})")?;
        }
        write!(
            f,
            ", {} flag",
            match self.flag {
                crate::Flag::Active => "active",
                crate::Flag::Passive => "passive",
                crate::Flag::None => "no",
            }
        )
    }
}
