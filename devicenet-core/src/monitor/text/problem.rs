//! Problems in words.

use core::fmt;

use cip_core::text::{write_decimal, write_prefixed_hex};

use super::explicit::write_status;
use crate::monitor::problem::Problem;

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
                f.write_str(", which is not waited for")
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
                and_more(f, count)
            }
            Self::MulticastPollUnanswered { mac, count } => {
                number(f, "no response to the multicast poll before from ", u8::from(mac).into())?;
                and_more(f, count)
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

/// How many others of `count`, after the first.
fn and_more(f: &mut fmt::Formatter<'_>, count: u8) -> fmt::Result {
    match count.saturating_sub(1) {
        0 => Ok(()),
        more => {
            number(f, " and ", more.into())?;
            f.write_str(" more")
        }
    }
}

fn bytes(count: u16) -> &'static str {
    if count == 1 { " byte" } else { " bytes" }
}
