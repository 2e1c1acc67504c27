//! Problems in words.

use core::fmt;

use cip_core::code::ClassId;
use cip_core::monitor::text::write_status;
use cip_core::names::additional_code_name;
use cip_core::text::{write_decimal, write_prefixed_hex};

use crate::monitor::problem::Problem;

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Flaw(flaw) => fmt::Display::fmt(&flaw, f),
            Self::ExtendedIdentifier => f.write_str("29-bit identifier"),
            Self::RemoteFrame => f.write_str("remote frame"),
            Self::InvalidIdentifier => f.write_str("identifier that must not be used"),
            Self::ReservedIdentifier => f.write_str("reserved identifier"),
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
                write_status(f, status, additional, additional_code_name(ClassId::DEVICENET, additional))
            }
            Self::OpenRefused { status, additional } => {
                f.write_str("refused: ")?;
                write_status(f, status, additional, None)
            }
            Self::WrongRequester { expected } => {
                number(f, "the request came from MAC ID ", u8::from(expected).into())
            }
            Self::MisplacedPollResponse => {
                f.write_str("poll response on the identifier of explicit responses")
            }
            Self::StrobeUnanswered { mac, count } => {
                number(f, "no response to the bit-strobe before from ", u8::from(mac).into())?;
                and_more(f, count)
            }
            Self::MulticastPollUnanswered { mac, count } => {
                number(f, "no response to the multicast poll before from ", u8::from(mac).into())?;
                and_more(f, count)
            }
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
