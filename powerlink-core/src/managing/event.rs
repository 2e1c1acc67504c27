//! What the managing node tells the application, and what it counts.

use core::fmt;

use link_core::text::ByteCount;

use super::state::{MnCause, MnState, NodeCause, NodePhase};
use crate::dictionary::ObjectAddress;
use crate::wire::{AbortCode, ErrorCode, NmtCommandId, ParseError};
use crate::{MacAddress, NodeId};

/// What happened.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MnEvent {
    /// Another state of the managing node.
    StateChanged {
        /// The state that was left.
        from: MnState,
        /// The state that was entered.
        to: MnState,
        /// Why.
        cause: MnCause,
    },
    /// A node is further, or less far.
    NodeChanged {
        /// Which.
        node: NodeId,
        /// The phase that was left.
        from: NodePhase,
        /// The phase that was entered.
        to: NodePhase,
        /// Why.
        cause: NodeCause,
    },
    /// A node is lost. It is told NMTResetNode, unless it has begun anew by itself.
    NodeLost {
        /// Which.
        node: NodeId,
        /// Why.
        reason: ErrorCode,
    },
    /// A node is not the one of the plan, or does not take its configuration.
    NodeRefused {
        /// Which.
        node: NodeId,
        /// What does not fit.
        reason: ErrorCode,
    },
    /// A node refused to have an object written.
    ConfigurationAborted {
        /// Which.
        node: NodeId,
        /// The object.
        at: ObjectAddress,
        /// Why.
        code: AbortCode,
    },
    /// Process data of a node: [`inputs`](super::ManagingNode::inputs). That there are no valid ones any more is told once: a PRes
    /// was lost, had no RD, was too long or showed another state than `Operational`, or the node left it.
    Inputs {
        /// Which.
        node: NodeId,
        /// Whether they count.
        is_valid: bool,
    },
    /// A PRes did not come in time.
    PresLost {
        /// Of which node.
        node: NodeId,
    },
    /// A PRes came when nobody waited for it, late or unasked. It is not used.
    PresLate {
        /// Of which node.
        node: NodeId,
    },
    /// One SoC or more were not sent when they should have been: the cycle before was not over, or the managing node was called too late.
    CycleExceeded,
    /// A node reports an error.
    NodeError {
        /// Which.
        node: NodeId,
        /// What.
        code: ErrorCode,
    },
    /// A node asks for an NMT command. It is carried out where [`Config`](super::Config) says so.
    NmtRequested {
        /// Who asks.
        from: NodeId,
        /// What for.
        command: NmtCommandId,
        /// For whom.
        target: NodeId,
    },
    /// An object was read; its value is in [`sdo_data`](super::ManagingNode::sdo_data).
    ObjectRead {
        /// Of which node.
        node: NodeId,
        /// Which.
        at: ObjectAddress,
        /// The length of the value.
        len: usize,
    },
    /// An object was written.
    ObjectWritten {
        /// Of which node.
        node: NodeId,
        /// Which.
        at: ObjectAddress,
    },
    /// An object that the application asked for could not be read or written.
    SdoFailed {
        /// Of which node.
        node: NodeId,
        /// Which.
        at: ObjectAddress,
        /// Why; [`AbortCode::TIME_OUT`] if the node does not answer.
        code: AbortCode,
    },
    /// There is another managing node.
    OtherManagingNode(MacAddress),
    /// Two nodes have one node ID: a PRes or ASnd of another than the one that was identified, which was ignored.
    AddressConflict {
        /// The node ID.
        node: NodeId,
        /// The MAC address of the other one.
        source: MacAddress,
    },
    /// A node that is in no plan answers.
    UnknownNode(NodeId),
    /// A frame could not be read, and was dropped.
    BadFrame(ParseError),
    /// The buffer of the caller is too short for a frame, which was not sent.
    BufferTooShort,
}

/// What the managing node counted. Every counter stays at its maximum.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct MnCounters {
    /// Cycles that were begun.
    pub cycles: u32,
    /// SoCs that were left out, because the cycle before was not over, or the managing node was called too late.
    pub cycles_exceeded: u32,
    /// PRes that did not come in time.
    pub lost_pres: u32,
    /// PRes that came when nobody waited for them, late or unasked.
    pub late_pres: u32,
    /// Process data longer than there is room for.
    pub pres_too_long: u32,
    /// Invitations that nobody answered, IdentRequests apart.
    pub unanswered: u32,
    /// Asynchronous frames without an invitation, or after its time.
    pub uninvited: u32,
    /// PRes and ASnd of another node than the one that was identified under the node ID.
    pub address_conflicts: u32,
    /// Frames of nodes in no plan.
    pub unknown_nodes: u32,
    /// Frames that could not be read.
    pub bad_frames: u32,
    /// Own frames that came back.
    pub echoes: u32,
    /// SDO frames out of order or of no connection.
    pub sdo_ignored: u32,
    /// Frames with a wrong checksum.
    pub crc_errors: u32,
    /// Collisions.
    pub collisions: u32,
    /// Times that the link was gone.
    pub links_lost: u32,
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
impl fmt::Display for MnEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::StateChanged { from, to, cause } => write!(f, "{from} -> {to}: {cause}"),
            Self::NodeChanged { node, from, to, cause } => write!(f, "{node}: {from} -> {to}: {cause}"),
            Self::NodeLost { node, reason } => write!(f, "{node} is lost: {reason}"),
            Self::NodeRefused { node, reason } => write!(f, "{node} is refused: {reason}"),
            Self::ConfigurationAborted { node, at, code } => write!(f, "{node} does not take {at}: {code}"),
            Self::Inputs { node, is_valid: true } => write!(f, "inputs of {node}"),
            Self::Inputs { node, is_valid: false } => write!(f, "no inputs of {node}"),
            Self::PresLost { node } => write!(f, "PRes of {node} lost"),
            Self::PresLate { node } => write!(f, "PRes of {node} late or unasked"),
            Self::CycleExceeded => f.write_str("SoC left out"),
            Self::NodeError { node, code } => write!(f, "{node} reports an error: {code}"),
            Self::NmtRequested { from, command, target } => {
                write!(f, "{from} asks for {command} for {target}")
            }
            Self::ObjectRead { node, at, len } => write!(f, "{at} of {node} read, {}", ByteCount(*len)),
            Self::ObjectWritten { node, at } => write!(f, "{at} of {node} written"),
            Self::SdoFailed { node, at, code } => write!(f, "{at} of {node} failed: {code}"),
            Self::OtherManagingNode(mac) => write!(f, "another managing node: {mac}"),
            Self::AddressConflict { node, source } => {
                write!(f, "another node has the node ID of {node}: {source}")
            }
            Self::UnknownNode(node) => write!(f, "{node} is in no plan"),
            Self::BadFrame(error) => write!(f, "bad frame: {error}"),
            Self::BufferTooShort => f.write_str("frame not sent: the buffer is too short"),
        }
    }
}
