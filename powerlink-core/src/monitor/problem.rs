//! What can be wrong with a frame.

use core::fmt;
use core::time::Duration;

use link_core::codec::ParseError;

use crate::wire::{NmtStateCode, RequestedService};
use crate::{MacAddress, NodeId};

/// Why a frame is wrong or suspicious, or what it shows to be missing before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Problem {
    /// The frame is cut, or a field has a value that cannot be.
    Malformed(ParseError),
    /// It is longer than Ethernet allows, even if the capture has the CRC too.
    TooLong {
        /// Its length without CRC.
        length: usize,
    },
    /// A StatusResponse of fewer than 72 bytes, which the managing node drops.
    StatusResponseShort {
        /// Its length without CRC.
        length: usize,
    },
    /// An IdentResponse of fewer than 176 bytes, which the managing node drops.
    IdentResponseShort {
        /// Its length without CRC.
        length: usize,
    },
    /// More process data than the node said in its IdentResponse that it takes or sends.
    SizeOver {
        /// The node.
        node: NodeId,
        /// What it said.
        limit: u16,
        /// What there is.
        size: usize,
    },
    /// SoC, PReq or SoA of a node that is not the managing node.
    NotManagingNode,
    /// SoC, PRes or SoA to another address than the group that listens to it.
    WrongGroup {
        /// The address of the group.
        expected: MacAddress,
    },
    /// The node sent from another address before.
    TwoSources {
        /// That address.
        before: MacAddress,
    },
    /// The PReq before was not answered.
    PresMissing {
        /// The node that was polled.
        node: NodeId,
    },
    /// A PRes after the managing node has gone on.
    PresLate {
        /// Since the PReq; `None` where the clock of the capture has gone back between.
        after: Option<Duration>,
    },
    /// A second PRes to one PReq, or one without a PReq of a node that is polled.
    PresWithoutPreq,
    /// The invitation before was not answered.
    AnswerMissing {
        /// Who was invited.
        node: NodeId,
        /// To what.
        service: RequestedService,
    },
    /// An ASnd in a slot that was not given to its sender.
    NotInvited,
    /// The node does not follow the ER bit with its EC bit.
    HandshakeNotAnswered {
        /// Responses in a row.
        responses: u8,
    },
    /// SoCs before this one did not come.
    SocMissing {
        /// How many.
        count: u64,
    },
    /// No way leads from the state in which the node was to the one that it reports, with the commands that were sent.
    StateCannotFollow {
        /// The state before.
        before: NmtStateCode,
    },
    /// Frames of an SDO connection are missing.
    SequenceGap {
        /// The number that would be next.
        expected: u8,
        /// The number that came.
        found: u8,
    },
}

impl Problem {
    /// A stable machine-readable name: lower case with underscores.
    #[must_use]
    pub const fn code(&self) -> &'static str {
        match self {
            Self::Malformed(_) => "malformed",
            Self::TooLong { .. } => "too_long",
            Self::StatusResponseShort { .. } => "status_response_short",
            Self::IdentResponseShort { .. } => "ident_response_short",
            Self::SizeOver { .. } => "size_over",
            Self::NotManagingNode => "not_managing_node",
            Self::WrongGroup { .. } => "wrong_group",
            Self::TwoSources { .. } => "two_sources",
            Self::PresMissing { .. } => "pres_missing",
            Self::PresLate { .. } => "pres_late",
            Self::PresWithoutPreq => "pres_without_preq",
            Self::AnswerMissing { .. } => "answer_missing",
            Self::NotInvited => "not_invited",
            Self::HandshakeNotAnswered { .. } => "handshake_not_answered",
            Self::SocMissing { .. } => "soc_missing",
            Self::StateCannotFollow { .. } => "state_cannot_follow",
            Self::SequenceGap { .. } => "sequence_gap",
        }
    }
}

/// `no PRes of node 1 to the PReq before`
impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Malformed(error) => error.fmt(f),
            Self::TooLong { length } => {
                write!(f, "{length} bytes, at most {} expected", crate::ethernet::MAX_FRAME)
            }
            Self::StatusResponseShort { length } => {
                write!(f, "{length} bytes, at least {STATUS_RESPONSE} expected: the managing node drops it")
            }
            Self::IdentResponseShort { length } => {
                write!(f, "{length} bytes, at least {IDENT_RESPONSE} expected: the managing node drops it")
            }
            Self::SizeOver { node, limit, size } => {
                write!(f, "{size} bytes of process data, {node} said at most {limit}")
            }
            Self::NotManagingNode => f.write_str("only the managing node sends it"),
            Self::WrongGroup { expected } => write!(f, "not to {expected}, where the nodes listen"),
            Self::TwoSources { before } => write!(f, "the node ID had the address {before} before"),
            Self::PresMissing { node } => write!(f, "no PRes of {node} to the PReq before"),
            Self::PresLate { after: Some(after) } => {
                write!(f, "too late, {} us after its PReq", after.as_micros())
            }
            Self::PresLate { after: None } => {
                f.write_str("too late; the clock of the capture has gone back since its PReq")
            }
            Self::PresWithoutPreq => f.write_str("no PReq before it"),
            Self::AnswerMissing { node, service } => write!(f, "no answer of {node} to the {service} before"),
            Self::NotInvited => f.write_str("the slot was not given to the sender"),
            Self::HandshakeNotAnswered { responses } => {
                write!(f, "EC does not follow ER in {responses} responses")
            }
            Self::SocMissing { count: 1 } => f.write_str("one SoC before it is missing"),
            Self::SocMissing { count } => write!(f, "{count} SoC before it are missing"),
            Self::StateCannotFollow { before } => write!(f, "nothing that was sent leads here from {before}"),
            Self::SequenceGap { expected, found } => {
                write!(f, "sequence number {expected} expected, {found} found: frames are missing")
            }
        }
    }
}

#[cfg(feature = "serde")]
impl serde::Serialize for Problem {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// The bytes of an IdentResponse without CRC.
pub(super) const IDENT_RESPONSE: usize = 176;
/// The least bytes of a StatusResponse without CRC.
pub(super) const STATUS_RESPONSE: usize = 72;
