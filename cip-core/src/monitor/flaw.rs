//! What can be wrong with a message in any network of CIP on CAN.

use core::fmt;

use crate::code::ServiceCode;
use crate::text::{ByteCount, write_decimal, write_prefixed_hex};

/// Why a message is wrong or suspicious, as far as no network has rules of its own for it.
///
/// `Display` gives the words, [`code`](Self::code) a stable name for filters and counters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Flaw {
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
    /// A response, and nobody has asked.
    UnexpectedResponse,
    /// A response to another service than the one requested.
    ServiceMismatch {
        /// The service requested.
        expected: ServiceCode,
    },
    /// A response or acknowledge with another transaction ID than the request or fragment.
    TransactionMismatch,
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
    /// The poll command before this one was not answered.
    PollUnanswered {
        /// Frame number of that command.
        n: u64,
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
}

impl Flaw {
    /// A stable machine-readable name: lower case with underscores.
    #[must_use]
    pub const fn code(&self) -> &'static str {
        match self {
            Self::DataLengthCode { .. } => "data_length_code",
            Self::Length { .. } => "length",
            Self::TooShort { .. } => "too_short",
            Self::ReservedBits { .. } => "reserved_bits",
            Self::ReservedValue { .. } => "reserved_value",
            Self::UnexpectedService { .. } => "unexpected_service",
            Self::ResponseBitOnRequest => "response_bit_on_request",
            Self::RequestBitOnResponse => "request_bit_on_response",
            Self::UnexpectedResponse => "unexpected_response",
            Self::ServiceMismatch { .. } => "service_mismatch",
            Self::TransactionMismatch => "transaction_mismatch",
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
            Self::PollUnanswered { .. } => "poll_unanswered",
            Self::Unacknowledged { .. } => "cos_unacknowledged",
            Self::UnexpectedIoResponse => "unexpected_io_response",
            Self::IoLength { .. } => "io_length",
        }
    }
}

impl fmt::Display for Flaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::DataLengthCode { dlc } => number(f, "data length code ", dlc.into()),
            Self::Length { expected, found } | Self::IoLength { expected, found } => {
                ByteCount(expected.into()).fmt(f)?;
                number(f, " expected, ", found.into())?;
                f.write_str(" found")
            }
            Self::TooShort { at_least, found } => {
                f.write_str("at least ")?;
                ByteCount(at_least.into()).fmt(f)?;
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
            Self::UnexpectedResponse => f.write_str("response without a request"),
            Self::ServiceMismatch { expected } => {
                f.write_str("the request was for service ")?;
                write_prefixed_hex(f, expected.0.into())
            }
            Self::TransactionMismatch => f.write_str("transaction ID does not match"),
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
                f.write_str("longer than the connection size of ")?;
                ByteCount(limit.into()).fmt(f)
            }
            Self::FragmentUnacknowledged { count } => {
                number(f, "fragment ", count.into())?;
                f.write_str(" was not acknowledged")
            }
            Self::UnknownAcknowledge { count } => {
                number(f, "acknowledge of fragment ", count.into())?;
                f.write_str(", which is not waited for")
            }
            Self::LateAcknowledge { count } => {
                number(f, "acknowledge of fragment ", count.into())?;
                f.write_str(" after more than a second")
            }
            Self::FragmentRefused => f.write_str("message refused: too much data"),
            Self::PollUnanswered { n } => number(f, "no response to the poll before, frame ", n),
            Self::Unacknowledged { n } => number(f, "no acknowledge of the message before, frame ", n),
            Self::UnexpectedIoResponse => f.write_str("I/O response without a command"),
        }
    }
}

fn number(f: &mut fmt::Formatter<'_>, words: &str, value: u64) -> fmt::Result {
    f.write_str(words)?;
    write_decimal(f, value)
}
