//! What a node tells the application, and what it counts.

use core::fmt;

use crate::dictionary::ObjectAddress;
use crate::indicator::StatusLed;
use crate::nmt::{Cause, NmtState};
use crate::wire::{AbortCode, ErrorCode, MessageType, NmtCommandId, ParseError, SdoCommandId};
use crate::{MacAddress, NodeId};

/// What happened.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum NodeEvent {
    /// Another state.
    StateChanged {
        /// The state that was left.
        from: NmtState,
        /// The state that was entered.
        to: NmtState,
        /// Why.
        cause: Cause,
    },
    /// The status indicator shines otherwise.
    StatusLed(StatusLed),
    /// The error indicator was switched.
    ErrorLed(bool),
    /// The managing node resets the node, and tells why.
    ResetReason {
        /// The command.
        command: NmtCommandId,
        /// Why.
        reason: ErrorCode,
    },
    /// The objects have new values from process data.
    ProcessData {
        /// The channel: 0 for 0x1600.
        channel: u8,
        /// They count: the node is in `Operational`.
        is_valid: bool,
    },
    /// An object did not take its value from process data that their sender calls valid (RD); the others did.
    ValueRefused {
        /// The channel: 0 for 0x1600.
        channel: u8,
        /// The first that did not.
        object: ObjectAddress,
        /// Why.
        code: AbortCode,
    },
    /// An object could not be read for the PRes, which says that its data are not valid.
    ValueUnreadable {
        /// The first that could not.
        object: ObjectAddress,
        /// Why.
        code: AbortCode,
    },
    /// A client wrote an object.
    ObjectWritten(ObjectAddress),
    /// A client's command failed.
    SdoAborted {
        /// The command.
        command: SdoCommandId,
        /// Why.
        code: AbortCode,
    },
    /// A client opened a connection.
    SdoOpened {
        /// Who.
        client: NodeId,
    },
    /// An open connection is closed: by its client, which may open another one, by time, or with a reset of the node.
    SdoClosed {
        /// Whose.
        client: NodeId,
        /// Nothing was heard of the client for too long, or it does not acknowledge.
        by_timeout: bool,
    },
    /// There is no room for another client.
    SdoRefused {
        /// Who.
        client: NodeId,
    },
    /// An error was put into the history, and is told to the managing node.
    Error(ErrorCode),
    /// A node that is not the managing node sent what only that sends: a SoC, a SoA, a PReq to this node, or an NMT command for it
    /// (an ASnd). It was ignored.
    ForeignFrame {
        /// What it sent.
        message: MessageType,
        /// Who.
        from: NodeId,
    },
    /// Another node has this node's ID: a PRes or ASnd under it that the node did not send.
    AddressConflict {
        /// The MAC address of the other one.
        source: MacAddress,
    },
    /// A frame could not be read, and was dropped.
    BadFrame(ParseError),
    /// The buffer of the caller is too short for a frame, which was not sent.
    BufferTooShort,
}

/// What a node counted. Every counter stays at its maximum.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct NodeCounters {
    /// Frames of the network that could not be read.
    pub bad_frames: u32,
    /// Frames with a destination MAC address that is not the node's.
    pub other_destinations: u32,
    /// SoC and SoA, PReq and NMT commands for the node, that are not of the managing node.
    pub foreign_frames: u32,
    /// PRes and ASnd of another node with this node's ID.
    pub address_conflicts: u32,
    /// Own frames that came back.
    pub echoes: u32,
    /// Messages of a type or service that a controlled node does not know.
    pub unknown: u32,
    /// NMT commands that were not followed in the state, or that no controlled node follows.
    pub commands_ignored: u32,
    /// SDO frames out of order or of no connection.
    pub sdo_ignored: u32,
    /// SDO clients for which there was no room.
    pub sdo_refused: u32,
    /// Process data that did not fit the mapping, of which an object did not take its value, or for which one could not be read.
    /// Of those that are received, data without RD do not count.
    pub pdo_errors: u32,
    /// Errors that were not told to the managing node, because too many wait already.
    pub errors_untold: u32,
    /// Frames lost before they could be looked at.
    pub frames_lost: u32,
    /// Frames that were not sent.
    pub not_sent: u32,
    /// Events that were lost because nobody fetched them.
    pub events_lost: u32,
}

/// One more. A counter stays at its maximum.
pub(super) const fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}

/// One line, in the words of a trace.
impl fmt::Display for NodeEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::StateChanged { from, to, cause } => write!(f, "{from} -> {to}: {cause}"),
            Self::StatusLed(led) => write!(f, "status LED {led}"),
            Self::ErrorLed(is_on) => write!(f, "error LED {}", if *is_on { "on" } else { "off" }),
            Self::ResetReason { command, reason } => write!(f, "{command}, reason: {reason}"),
            Self::ProcessData { channel, is_valid } => {
                write!(f, "process data of channel {channel}{}", if *is_valid { "" } else { ", not valid" })
            }
            Self::ValueRefused { channel, object, code } => {
                write!(f, "{object} did not take its value of channel {channel}: {code}")
            }
            Self::ValueUnreadable { object, code } => {
                write!(f, "{object} could not be read for the PRes: {code}")
            }
            Self::ObjectWritten(at) => write!(f, "{at} written"),
            Self::SdoAborted { command, code } => write!(f, "{command} failed: {code}"),
            Self::SdoOpened { client } => write!(f, "SDO connection of {client} open"),
            Self::SdoClosed { client, by_timeout } => {
                let why = if *by_timeout { ": nothing was heard of it" } else { "" };
                write!(f, "SDO connection of {client} closed{why}")
            }
            Self::SdoRefused { client } => write!(f, "SDO connection of {client} refused: there is no room"),
            Self::Error(code) => write!(f, "error: {code}"),
            Self::ForeignFrame { message, from } => {
                write!(f, "{message} of {from} ignored: it is not the managing node")
            }
            Self::AddressConflict { source } => write!(f, "another node has the same node ID: {source}"),
            Self::BadFrame(error) => write!(f, "bad frame: {error}"),
            Self::BufferTooShort => f.write_str("frame not sent: the buffer is too short"),
        }
    }
}
