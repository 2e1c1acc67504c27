//! What network access tells the application, and what it counts.

use core::fmt;

use link_core::link::LinkCommandKind;
use link_core::{Frame, TxOutcome};

use super::state::{Cause, StateKind};
use crate::id::{Identifier, MacId};
use crate::message::{CommunicationFaultedRequest, Direction, DuplicateMacCheck, ParseError, Wire};

/// What happened.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AccessEvent {
    /// Another state. On line begins, or communication ends: delete all connections when `from` is
    /// [`StateKind::OnLine`].
    StateChanged {
        /// The state that was left.
        from: StateKind,
        /// The state that was entered.
        to: StateKind,
        /// Why.
        cause: Cause,
    },
    /// Another node uses this MAC ID: the node is faulted now.
    Duplicate {
        /// What it sent.
        direction: Direction,
        /// Who it is; `None` if the message had a wrong length. The own identity here means that the port delivers the
        /// node's own frames back, which it must not.
        other: Option<DuplicateMacCheck>,
    },
    /// Another node wants on line with this MAC ID, and is being answered.
    Challenged {
        /// Who it is; `None` if the message had a wrong length.
        other: Option<DuplicateMacCheck>,
    },
    /// Nobody acknowledges the duplicate MAC ID check request: alone on the bus, or the wrong bit rate. Told once for
    /// each request; the controller goes on.
    NotAcknowledged,
    /// A frame was given back unsent although nobody asked for it.
    NotSent {
        /// Which.
        what: Outgoing,
        /// What the controller says.
        outcome: TxOutcome,
    },
    /// A tool gave the node a MAC ID through the offline connection set: store it in non-volatile memory. The node
    /// starts anew.
    MacIdAssigned {
        /// The one that was in use by two.
        from: MacId,
        /// The new one, perhaps the same.
        to: MacId,
    },
    /// A tool wanted to give the node another MAC ID, but it comes from switches. The node starts anew with the one it
    /// has.
    MacIdLocked {
        /// What the tool wanted.
        requested: MacId,
    },
    /// The indicator shall flash red and green, or cease to.
    Identify {
        /// Begin, or end.
        on: bool,
    },
    /// A frame on an identifier of network access is malformed. Whether it counted all the same says
    /// [`Config::accept_bad_dlc`](super::Config::accept_bad_dlc).
    BadFrame {
        /// Where it was.
        id: Identifier,
        /// Its data, and zeros. [`error`](AccessEvent::error) says what is wrong with them.
        data: [u8; Frame::MAX_DATA],
        /// How many bytes it had.
        len: u8,
    },
    /// Frames were lost before they could be looked at: a duplicate may have gone unnoticed.
    FramesLost {
        /// How many, 0 if the controller does not count.
        count: u32,
    },
    /// The port cannot do what it was asked.
    LinkRefused(LinkCommandKind),
}

impl AccessEvent {
    /// What is wrong with a [`BadFrame`](Self::BadFrame).
    #[must_use]
    pub fn error(&self) -> Option<ParseError> {
        let Self::BadFrame { id, data, len } = self else { return None };
        let field = data.get(..usize::from(*len))?;
        if *id == Identifier::COMMUNICATION_FAULTED_REQUEST {
            CommunicationFaultedRequest::parse(field).err()
        } else {
            DuplicateMacCheck::parse(field).err()
        }
    }
}

/// The frames that network access sends.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Outgoing {
    /// Duplicate MAC ID check request.
    CheckRequest,
    /// Duplicate MAC ID check response.
    CheckResponse,
    /// Who response.
    WhoResponse,
    /// Identify response.
    IdentifyResponse,
}

/// What network access counted. Every counter stays at its maximum.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Counters {
    /// Check requests for the own MAC ID that were received on line.
    pub challenges: u16,
    /// Check responses that were sent.
    pub responses: u16,
    /// Requests that were answered by the response to an earlier one.
    pub requests_merged: u16,
    /// Signs of a duplicate that led to the communication fault.
    pub duplicates: u16,
    /// Malformed frames on the identifiers of network access.
    pub bad_frames: u16,
    /// Remote frames and frames with a 29-bit identifier, which DeviceNet never uses.
    pub foreign_frames: u32,
    /// Frames discarded because the node was not on line, or did not listen to them while faulted.
    pub discarded: u32,
    /// Attempts to send a check request that nobody acknowledged, as far as the controller tells.
    pub unacknowledged: u32,
    /// Frames that were given back unsent although nobody asked for it.
    pub not_sent: u16,
    /// Frames lost before they could be looked at.
    pub frames_lost: u32,
    /// Link commands that were refused.
    pub refused: u16,
    /// Answers to transmissions that were not under way: the port breaks the contract.
    pub stray_tx_done: u16,
    /// Events that were lost because nobody fetched them.
    pub events_lost: u16,
}

/// One line, in the words of a trace.
impl fmt::Display for AccessEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::StateChanged { from, to, cause } => write!(f, "{from} -> {to}: {cause}"),
            Self::Duplicate { direction, other } => {
                write!(f, "duplicate MAC ID: {direction} of ")?;
                write_other(f, other)
            }
            Self::Challenged { other } => {
                f.write_str("MAC ID defended against ")?;
                write_other(f, other)
            }
            Self::NotAcknowledged => f.write_str("nobody acknowledges: alone on the bus, or wrong bit rate"),
            Self::NotSent { what, outcome } => write!(f, "{what} not sent: {outcome:?}"),
            Self::MacIdAssigned { from, to } => write!(f, "MAC ID {to} assigned instead of {from}"),
            Self::MacIdLocked { requested } => {
                write!(f, "MAC ID {requested} refused: it comes from switches")
            }
            Self::Identify { on: true } => f.write_str("identify on"),
            Self::Identify { on: false } => f.write_str("identify off"),
            Self::BadFrame { id, .. } => {
                write!(f, "bad frame on {id}")?;
                self.error().map_or(Ok(()), |error| write!(f, ": {error}"))
            }
            Self::FramesLost { count } => write!(f, "{count} frames lost"),
            Self::LinkRefused(kind) => write!(f, "{kind:?} refused"),
        }
    }
}

impl fmt::Display for Outgoing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::CheckRequest => "duplicate MAC ID check request",
            Self::CheckResponse => "duplicate MAC ID check response",
            Self::WhoResponse => "Who response",
            Self::IdentifyResponse => "Identify response",
        })
    }
}

fn write_other(f: &mut fmt::Formatter<'_>, other: &Option<DuplicateMacCheck>) -> fmt::Result {
    match other {
        Some(check) => fmt::Display::fmt(&check.device, f),
        None => f.write_str("an unknown device"),
    }
}
