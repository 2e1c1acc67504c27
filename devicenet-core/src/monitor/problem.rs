//! What can be wrong with a frame.

use core::fmt;

use cip_core::code::{AdditionalCode, GeneralStatus, ServiceCode};
use cip_core::text::{write_decimal, write_prefixed_hex};

use super::write_status;
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
    /// The acknowledge of a fragment that was not sent.
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
            Self::Unacknowledged { .. } => "cos_unacknowledged",
            Self::UnexpectedIoResponse => "unexpected_io_response",
            Self::IoLength { .. } => "io_length",
            Self::HeartbeatEvent => "heartbeat_event",
            Self::HeartbeatMissing { .. } => "heartbeat_missing",
            Self::WrongConnectionId { .. } => "wrong_connection_id",
        }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::ExtendedIdentifier => f.write_str("29-bit identifier"),
            Self::RemoteFrame => f.write_str("remote frame"),
            Self::InvalidIdentifier => f.write_str("identifier that must not be used"),
            Self::ReservedIdentifier => f.write_str("reserved identifier"),
            Self::DataLengthCode { dlc } => number(f, "data length code ", dlc.into()),
            Self::Length { expected, found } | Self::IoLength { expected, found } => {
                write_decimal(f, expected.into())?;
                f.write_str(bytes(expected))?;
                number(f, " expected, ", found.into())?;
                f.write_str(" found")
            }
            Self::TooShort { at_least, found } => {
                number(f, "at least ", at_least.into())?;
                f.write_str(bytes(at_least))?;
                number(f, " expected, ", found.into())?;
                f.write_str(" found")
            }
            Self::ReservedBits { field } => {
                f.write_str("reserved bits set in the ")?;
                f.write_str(field)
            }
            Self::ReservedValue { field, found } => {
                f.write_str("reserved ")?;
                f.write_str(field)?;
                f.write_str(" ")?;
                write_prefixed_hex(f, found.into())
            }
            Self::UnexpectedService { service } => {
                f.write_str("service ")?;
                write_prefixed_hex(f, service.0.into())?;
                f.write_str(" does not belong on this identifier")
            }
            Self::ResponseBitOnRequest => f.write_str("response bit on a request identifier"),
            Self::RequestBitOnResponse => f.write_str("request bit on a response identifier"),
            Self::HeaderRepeatsIdentifier { mac } => {
                number(f, "the header repeats MAC ID ", u8::from(mac).into())?;
                f.write_str(" of the identifier")
            }
            Self::HeaderNotSender { found } => {
                number(f, "MAC ID ", u8::from(found).into())?;
                f.write_str(" in the header is not the sender's")
            }
            Self::DuplicateMacId { mac } => number(f, "duplicate MAC ID ", u8::from(mac).into()),
            Self::TwoIdentities { mac } => number(f, "two nodes check MAC ID ", u8::from(mac).into()),
            Self::NotOwner { owner } => {
                number(f, "the connection belongs to master ", u8::from(owner).into())
            }
            Self::Refused { status, additional } => {
                f.write_str("refused: ")?;
                write_status(f, status, additional, true)
            }
            Self::OpenRefused { status, additional } => {
                f.write_str("refused: ")?;
                write_status(f, status, additional, false)
            }
            Self::UnexpectedResponse => f.write_str("response without a request"),
            Self::ServiceMismatch { expected } => {
                f.write_str("the request was for service ")?;
                write_prefixed_hex(f, expected.0.into())
            }
            Self::TransactionMismatch => f.write_str("transaction ID does not match"),
            Self::WrongRequester { expected } => {
                number(f, "the request came from MAC ID ", u8::from(expected).into())
            }
            Self::OutOfSequence { after, found } => {
                number(f, "fragment ", found.into())?;
                number(f, " after ", after.into())
            }
            Self::NoFirstFragment { found } => {
                number(f, "fragment ", found.into())?;
                f.write_str(" without a first")
            }
            Self::FirstNotZero { found } => number(f, "first fragment with count ", found.into()),
            Self::FragmentNotAllowed => f.write_str("fragment of a message that is never fragmented"),
            Self::TransactionChanged => f.write_str("transaction ID changed within the message"),
            Self::TooLong { limit } => {
                number(f, "longer than the connection size of ", limit.into())?;
                f.write_str(bytes(limit))
            }
            Self::FragmentUnacknowledged { count } => {
                number(f, "fragment ", count.into())?;
                f.write_str(" was not acknowledged")
            }
            Self::UnknownAcknowledge { count } => {
                number(f, "acknowledge of fragment ", count.into())?;
                f.write_str(", which was not sent")
            }
            Self::LateAcknowledge { count } => {
                number(f, "acknowledge of fragment ", count.into())?;
                f.write_str(" after more than a second")
            }
            Self::FragmentRefused => f.write_str("message refused: too much data"),
            Self::MisplacedPollResponse => {
                f.write_str("poll response on the identifier of explicit responses")
            }
            Self::PollUnanswered { n } => number(f, "no response to the poll before, frame ", n),
            Self::StrobeUnanswered { mac, count } => {
                number(f, "no response to the bit-strobe before from ", u8::from(mac).into())?;
                match count.saturating_sub(1) {
                    0 => Ok(()),
                    more => {
                        number(f, " and ", more.into())?;
                        f.write_str(" more")
                    }
                }
            }
            Self::Unacknowledged { n } => number(f, "no acknowledge of the message before, frame ", n),
            Self::UnexpectedIoResponse => f.write_str("I/O response without a command"),
            Self::HeartbeatEvent => f.write_str("event bit set in a heartbeat"),
            Self::HeartbeatMissing { after, interval } => {
                number(f, "heartbeat after ", after.into())?;
                number(f, " s, expected every ", interval.into())?;
                f.write_str(" s")
            }
            Self::WrongConnectionId { expected, found } => {
                f.write_str("identifier ")?;
                write_prefixed_hex(f, found.into())?;
                f.write_str(", the predefined set says ")?;
                write_prefixed_hex(f, expected.into())
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

fn number(f: &mut fmt::Formatter<'_>, words: &str, value: u64) -> fmt::Result {
    f.write_str(words)?;
    write_decimal(f, value)
}

fn bytes(count: u16) -> &'static str {
    if count == 1 { " byte" } else { " bytes" }
}
