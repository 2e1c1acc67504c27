//! What can be wrong with a frame.

use cip_core::code::{AdditionalCode, GeneralStatus, ServiceCode};

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
    /// A 29-bit identifier.
    ExtendedIdentifier,
    /// A remote frame.
    RemoteFrame,
    /// 0x7F0-0x7FF.
    InvalidIdentifier,
    /// Group 4, Message ID 0x00-0x2B.
    ReservedIdentifier,
    /// A data length code of 9-15.
    DataLengthCode {
        /// The code found.
        dlc: u8,
    },
    /// The message has a fixed length.
    Length {
        /// Bytes that it should have.
        expected: u16,
        /// Bytes that it has.
        found: u16,
    },
    /// The message is too short for its header.
    TooShort {
        /// Bytes that it should have at least.
        at_least: u16,
        /// Bytes that it has.
        found: u16,
    },
    /// A byte or bits that must be zero are not.
    ReservedBits {
        /// Which.
        field: &'static str,
    },
    /// A reserved value.
    ReservedValue {
        /// Of which field.
        field: &'static str,
        /// The value.
        found: u16,
    },
    /// A service that the identifier does not carry.
    UnexpectedService {
        /// The service.
        service: ServiceCode,
    },
    /// The R/R bit says response, the identifier carries requests.
    ResponseBitOnRequest,
    /// The R/R bit says request, the identifier carries responses.
    RequestBitOnResponse,
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
    /// A response, and nobody has asked.
    UnexpectedResponse,
    /// A response to another service than the one requested.
    ServiceMismatch {
        /// The service requested.
        expected: ServiceCode,
    },
    /// A response or acknowledge with another transaction ID than the request or fragment.
    TransactionMismatch,
    /// A response addressed to a node that has not asked.
    WrongRequester {
        /// The node that has asked.
        expected: MacId,
    },
    /// A fragment out of sequence: the message is lost.
    OutOfSequence {
        /// The fragment before.
        after: u8,
        /// The count found.
        found: u8,
    },
    /// A middle or last fragment of a message whose first fragment does not exist.
    NoFirstFragment {
        /// The count found.
        found: u8,
    },
    /// A first fragment with a count other than 0.
    FirstNotZero {
        /// The count found.
        found: u8,
    },
    /// A fragment on an identifier whose messages are never fragmented.
    FragmentNotAllowed,
    /// Fragments of one message with different transaction IDs.
    TransactionChanged,
    /// The message exceeds the connection size.
    TooLong {
        /// The connection size.
        limit: u16,
    },
    /// The sender of a fragment went on, or repeated it, without an acknowledge.
    FragmentUnacknowledged {
        /// The count of the fragment.
        count: u8,
    },
    /// The acknowledge of a fragment that nobody waits for: it was not sent, or its message was abandoned.
    UnknownAcknowledge {
        /// The count acknowledged.
        count: u8,
    },
    /// An acknowledge that came after the sender's wait of one second.
    LateAcknowledge {
        /// The count acknowledged.
        count: u8,
    },
    /// The receiver has dropped the message: it is too long for it.
    FragmentRefused,
    /// Bytes that are a poll response by their place in the exchange, on the identifier of explicit responses.
    MisplacedPollResponse,
    /// The poll command before this one was not answered.
    PollUnanswered {
        /// Frame number of that command.
        n: u64,
    },
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
    /// The COS or cyclic message before this one was not acknowledged.
    Unacknowledged {
        /// Frame number of that message.
        n: u64,
    },
    /// An I/O response or acknowledge without a command.
    UnexpectedIoResponse,
    /// I/O data of another length than the connection size.
    IoLength {
        /// The connection size.
        expected: u16,
        /// Bytes found.
        found: u16,
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

impl Problem {
    /// A stable machine-readable name: lower case with underscores.
    #[must_use]
    pub const fn code(&self) -> &'static str {
        match self {
            Self::ExtendedIdentifier => "extended_identifier",
            Self::RemoteFrame => "remote_frame",
            Self::InvalidIdentifier => "invalid_identifier",
            Self::ReservedIdentifier => "reserved_identifier",
            Self::DataLengthCode { .. } => "data_length_code",
            Self::Length { .. } => "length",
            Self::TooShort { .. } => "too_short",
            Self::ReservedBits { .. } => "reserved_bits",
            Self::ReservedValue { .. } => "reserved_value",
            Self::UnexpectedService { .. } => "unexpected_service",
            Self::ResponseBitOnRequest => "response_bit_on_request",
            Self::RequestBitOnResponse => "request_bit_on_response",
            Self::HeaderRepeatsIdentifier { .. } => "header_repeats_identifier",
            Self::HeaderNotSender { .. } => "header_not_sender",
            Self::DuplicateMacId { .. } => "duplicate_mac_id",
            Self::TwoIdentities { .. } => "two_identities",
            Self::NotOwner { .. } => "not_owner",
            Self::Refused { .. } => "allocation_refused",
            Self::OpenRefused { .. } => "open_refused",
            Self::UnexpectedResponse => "unexpected_response",
            Self::ServiceMismatch { .. } => "service_mismatch",
            Self::TransactionMismatch => "transaction_mismatch",
            Self::WrongRequester { .. } => "wrong_requester",
            Self::OutOfSequence { .. } => "fragment_out_of_sequence",
            Self::NoFirstFragment { .. } => "no_first_fragment",
            Self::FirstNotZero { .. } => "first_fragment_not_zero",
            Self::FragmentNotAllowed => "fragment_not_allowed",
            Self::TransactionChanged => "transaction_changed",
            Self::TooLong { .. } => "too_long",
            Self::FragmentUnacknowledged { .. } => "fragment_unacknowledged",
            Self::UnknownAcknowledge { .. } => "unknown_acknowledge",
            Self::LateAcknowledge { .. } => "late_acknowledge",
            Self::FragmentRefused => "fragment_refused",
            Self::MisplacedPollResponse => "misplaced_poll_response",
            Self::PollUnanswered { .. } => "poll_unanswered",
            Self::StrobeUnanswered { .. } => "strobe_unanswered",
            Self::MulticastPollUnanswered { .. } => "multicast_poll_unanswered",
            Self::Unacknowledged { .. } => "cos_unacknowledged",
            Self::UnexpectedIoResponse => "unexpected_io_response",
            Self::IoLength { .. } => "io_length",
            Self::HeartbeatEvent => "heartbeat_event",
            Self::HeartbeatMissing { .. } => "heartbeat_missing",
            Self::WrongConnectionId { .. } => "wrong_connection_id",
        }
    }
}
