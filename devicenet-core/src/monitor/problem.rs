//! What can be wrong with a frame.

use cip_core::code::{AdditionalCode, GeneralStatus};
use cip_core::monitor::Flaw;

use crate::id::MacId;

/// Why a frame is wrong or suspicious.
///
/// A problem is something that the rules of the network do not allow, or that costs data: it concerns the bus, not the
/// application. An error response to a Get or Set is not a problem (it says what a client asked in vain); a refused
/// allocation is one, because the master stays without its slave. A frame that cannot be judged, because the recording
/// starts in the middle, has none.
///
/// `Display` gives the words, [`code`](Self::code) a stable name for filters and counters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Problem {
    /// Wrong in any network of CIP on CAN.
    Flaw(Flaw),
    /// A 29-bit identifier.
    ExtendedIdentifier,
    /// A remote frame.
    RemoteFrame,
    /// 0x7F0-0x7FF.
    InvalidIdentifier,
    /// Group 4, Message ID 0x00-0x2B.
    ReservedIdentifier,
    /// The MAC ID in the header is the one in the identifier, though the message is neither Heartbeat nor Shutdown.
    HeaderRepeatsIdentifier {
        /// The MAC ID.
        mac: MacId,
    },
    /// A Heartbeat or Shutdown whose header does not carry the sender's own MAC ID.
    HeaderNotSender {
        /// The MAC ID in the header.
        found: MacId,
    },
    /// A duplicate MAC ID check response: the MAC ID is taken, the node that asked goes off-line.
    DuplicateMacId {
        /// The MAC ID.
        mac: MacId,
    },
    /// Two nodes check the same MAC ID.
    TwoIdentities {
        /// The MAC ID.
        mac: MacId,
    },
    /// A request on a connection that another master owns; the slave ignores it.
    NotOwner {
        /// The owner.
        owner: MacId,
    },
    /// Allocation or release refused.
    Refused {
        /// General status.
        status: GeneralStatus,
        /// Additional code.
        additional: AdditionalCode,
    },
    /// A UCMM request refused.
    OpenRefused {
        /// General status.
        status: GeneralStatus,
        /// Additional code.
        additional: AdditionalCode,
    },
    /// A response addressed to a node that has not asked.
    WrongRequester {
        /// The node that has asked.
        expected: MacId,
    },
    /// Bytes that are a poll response by their place in the exchange, on the identifier of explicit responses.
    MisplacedPollResponse,
    /// Slaves did not answer the bit-strobe command before this one.
    StrobeUnanswered {
        /// The first of them.
        mac: MacId,
        /// How many.
        count: u8,
    },
    /// Slaves did not answer the multicast poll command to this group before this one.
    MulticastPollUnanswered {
        /// The first of them.
        mac: MacId,
        /// How many.
        count: u8,
    },
    /// The EV bit is set in a heartbeat.
    HeartbeatEvent,
    /// At least one heartbeat before this one is missing.
    HeartbeatMissing {
        /// Seconds since the last.
        after: u16,
        /// Seconds expected.
        interval: u16,
    },
    /// A predefined connection that names an identifier which is not its own.
    WrongConnectionId {
        /// The identifier by the predefined set.
        expected: u16,
        /// The identifier that the device names.
        found: u16,
    },
}

impl From<Flaw> for Problem {
    fn from(flaw: Flaw) -> Self {
        Self::Flaw(flaw)
    }
}

impl Problem {
    /// A stable machine-readable name: lower case with underscores.
    #[must_use]
    pub const fn code(&self) -> &'static str {
        match self {
            Self::Flaw(flaw) => flaw.code(),
            Self::ExtendedIdentifier => "extended_identifier",
            Self::RemoteFrame => "remote_frame",
            Self::InvalidIdentifier => "invalid_identifier",
            Self::ReservedIdentifier => "reserved_identifier",
            Self::HeaderRepeatsIdentifier { .. } => "header_repeats_identifier",
            Self::HeaderNotSender { .. } => "header_not_sender",
            Self::DuplicateMacId { .. } => "duplicate_mac_id",
            Self::TwoIdentities { .. } => "two_identities",
            Self::NotOwner { .. } => "not_owner",
            Self::Refused { .. } => "allocation_refused",
            Self::OpenRefused { .. } => "open_refused",
            Self::WrongRequester { .. } => "wrong_requester",
            Self::MisplacedPollResponse => "misplaced_poll_response",
            Self::StrobeUnanswered { .. } => "strobe_unanswered",
            Self::MulticastPollUnanswered { .. } => "multicast_poll_unanswered",
            Self::HeartbeatEvent => "heartbeat_event",
            Self::HeartbeatMissing { .. } => "heartbeat_missing",
            Self::WrongConnectionId { .. } => "wrong_connection_id",
        }
    }
}
