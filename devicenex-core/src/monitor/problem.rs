//! What can be wrong with a frame.

use core::fmt;

use cip_core::code::{AdditionalCode, GeneralStatus};
use cip_core::monitor::Flaw;
use cip_core::monitor::text::write_status;

use crate::connection::ConnectionId;
use crate::id::OperationalAddress;

/// Why a frame is wrong or suspicious.
///
/// A problem is something that the profile does not allow, or that costs data or an address: it concerns the bus, not the
/// application. An error response to a Get or Set is not a problem; a refused connection is one. A frame that cannot be
/// judged, because the recording starts in the middle, has none.
///
/// `Display` gives the words, [`code`](Self::code) a stable name for filters and counters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Problem {
    /// Wrong in any network of CIP on CAN.
    Flaw(Flaw),
    /// An 11-bit identifier that DeviceNeX does not use: 0x780-0x7FF. DeviceNet has UCMM and its offline connection set there.
    StandardIdentifier,
    /// A remote frame that is no Mini-who.
    RemoteFrame,
    /// Classes 11000 to 11011, a fragment of class 11101, a ROAM with bit 16 set.
    ReservedIdentifier,
    /// A message from or to OA 127 that only nodes with an address can exchange.
    NoAddress,
    /// A ROAM to a device that has an address.
    RoamToAddress {
        /// The address in the identifier.
        destination: OperationalAddress,
    },
    /// A Hello response: the address is taken, the node that has asked starts over without one.
    AddressTaken {
        /// The address.
        address: OperationalAddress,
    },
    /// A Hello response for OA 127, which everybody can have.
    ResponseWithoutAddress,
    /// Two nodes want or have one address, and the network manager has not told either of them to take it from the other.
    TwoIdentities {
        /// The address.
        address: OperationalAddress,
    },
    /// Two devices without an address share the low half of their serial number: their Hellos have one identifier with
    /// different data.
    SharedSerialHalf {
        /// The low half.
        serial_low: u16,
    },
    /// The ROAM before this one to the same device had no effect: no Hello with the address has followed.
    RoamWithoutEffect {
        /// Frame number of that ROAM.
        n: u64,
    },
    /// Another node than the one before sends Mini-who or opens connections as a network manager does.
    SecondManager {
        /// The low half of the serial number of the first.
        first: u16,
    },
    /// A connection refused.
    Refused {
        /// General status.
        status: GeneralStatus,
        /// Additional code.
        additional: AdditionalCode,
    },
    /// A connection response that does not fit its request.
    NotAsAsked {
        /// In what.
        field: &'static str,
    },
    /// A connection that names an identifier which is not its own.
    WrongConnectionId {
        /// That by the profile.
        expected: ConnectionId,
        /// That which the device names.
        found: ConnectionId,
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
            Self::StandardIdentifier => "standard_identifier",
            Self::RemoteFrame => "remote_frame",
            Self::ReservedIdentifier => "reserved_identifier",
            Self::NoAddress => "no_address",
            Self::RoamToAddress { .. } => "roam_to_address",
            Self::AddressTaken { .. } => "address_taken",
            Self::ResponseWithoutAddress => "response_without_address",
            Self::TwoIdentities { .. } => "two_identities",
            Self::SharedSerialHalf { .. } => "shared_serial_half",
            Self::RoamWithoutEffect { .. } => "roam_without_effect",
            Self::SecondManager { .. } => "second_manager",
            Self::Refused { .. } => "connection_refused",
            Self::NotAsAsked { .. } => "not_as_asked",
            Self::WrongConnectionId { .. } => "wrong_connection_id",
        }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Flaw(flaw) => fmt::Display::fmt(&flaw, f),
            Self::StandardIdentifier => f.write_str("11-bit identifier that DeviceNeX does not use"),
            Self::RemoteFrame => f.write_str("remote frame"),
            Self::ReservedIdentifier => f.write_str("reserved identifier"),
            Self::NoAddress => f.write_str("OA 127 is no address for this message"),
            Self::RoamToAddress { destination } => {
                write!(f, "ROAM to OA {destination}, which only a device without an address takes")
            }
            Self::AddressTaken { address } => write!(f, "OA {address} is taken"),
            Self::ResponseWithoutAddress => f.write_str("OA 127 is not answered for"),
            Self::TwoIdentities { address } => write!(f, "two nodes claim OA {address}"),
            Self::SharedSerialHalf { serial_low } => {
                write!(
                    f,
                    "two devices without an address share the identifier, serial ending in 0x{serial_low:04X}"
                )
            }
            Self::RoamWithoutEffect { n } => write!(f, "no Hello after the ROAM before, frame {n}"),
            Self::SecondManager { first } => {
                write!(f, "a second network manager, the first has a serial ending in 0x{first:04X}")
            }
            Self::Refused { status, additional } => {
                f.write_str("refused: ")?;
                write_status(f, status, additional, None)
            }
            Self::NotAsAsked { field } => write!(f, "{field} is not what was asked for"),
            Self::WrongConnectionId { expected, found } => {
                write!(f, "identifier {found}, the profile says {expected}")
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
