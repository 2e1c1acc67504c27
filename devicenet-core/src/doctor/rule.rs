//! The rules: their names, their codes on scanner displays, and what to do about a finding.

use core::fmt;

use cip_core::monitor::Flaw;

use crate::master::ScannerStatus;
use crate::monitor::Problem;

/// How bad a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Severity {
    /// Worth knowing; nothing is wrong.
    Info,
    /// It works, but it will not forever, or not for everybody.
    Warning,
    /// Something does not work.
    Error,
}

impl Severity {
    /// The name, the same for programs and for people.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Info => "info",
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }
}

impl Severity {
    /// What a problem of a single frame says of the network.
    ///
    /// [`Info`](Self::Info) where a rule judges what becomes of it, or where somebody was late or asked for too much, as happens on a
    /// network in order. [`Warning`](Self::Warning) where a device breaks the protocol, which none in order does.
    #[must_use]
    pub const fn of(problem: &Problem) -> Self {
        match problem {
            Problem::Flaw(flaw) => Self::of_flaw(flaw),
            // Rules judge them.
            Problem::ExtendedIdentifier
            | Problem::RemoteFrame
            | Problem::InvalidIdentifier
            | Problem::ReservedIdentifier
            | Problem::DuplicateMacId { .. }
            | Problem::TwoIdentities { .. }
            | Problem::NotOwner { .. }
            | Problem::Refused { .. }
            | Problem::StrobeUnanswered { .. }
            | Problem::MulticastPollUnanswered { .. } => Self::Info,
            // A late frame, or a client that asks for too much.
            Problem::OpenRefused { .. }
            | Problem::WrongRequester { .. }
            | Problem::HeartbeatEvent
            | Problem::HeartbeatMissing { .. } => Self::Info,
            Problem::HeaderRepeatsIdentifier { .. }
            | Problem::HeaderNotSender { .. }
            | Problem::MisplacedPollResponse
            | Problem::WrongConnectionId { .. } => Self::Warning,
        }
    }

    /// The same of what is wrong in any network of CIP on CAN.
    #[must_use]
    pub const fn of_flaw(flaw: &Flaw) -> Self {
        match flaw {
            // Rules judge them.
            Flaw::OutOfSequence { .. }
            | Flaw::PollUnanswered { .. }
            | Flaw::Unacknowledged { .. }
            | Flaw::UnexpectedIoResponse
            | Flaw::IoLength { .. } => Self::Info,
            // A late frame, or a message that is too much for its receiver.
            Flaw::UnexpectedResponse
            | Flaw::ServiceMismatch { .. }
            | Flaw::TransactionMismatch
            | Flaw::FragmentUnacknowledged { .. }
            | Flaw::LateAcknowledge { .. }
            | Flaw::FragmentRefused => Self::Info,
            Flaw::DataLengthCode { .. }
            | Flaw::Length { .. }
            | Flaw::TooShort { .. }
            | Flaw::ReservedBits { .. }
            | Flaw::ReservedValue { .. }
            | Flaw::UnexpectedService { .. }
            | Flaw::ResponseBitOnRequest
            | Flaw::RequestBitOnResponse
            | Flaw::NoFirstFragment { .. }
            | Flaw::FirstNotZero { .. }
            | Flaw::FragmentNotAllowed
            | Flaw::TransactionChanged
            | Flaw::TooLong { .. }
            | Flaw::UnknownAcknowledge { .. } => Self::Warning,
        }
    }
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

macro_rules! rules {
    ($($(#[$doc:meta])* $Rule:ident, $code:literal, $status:expr, $advice:literal;)*) => {
        /// What the doctor looks for.
        ///
        /// [`code`](Self::code) is a stable name for programs, [`scanner_status`](Self::scanner_status) what the display of a
        /// scanner shows for the same, [`advice`](Self::advice) what to check next.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        pub enum Rule {
            $($(#[$doc])* $Rule,)*
        }

        impl Rule {
            /// All rules, in the order of the table of the [module](super).
            pub const ALL: &'static [Self] = &[$(Self::$Rule,)*];

            /// A stable machine-readable name: lower case with underscores.
            #[must_use]
            pub const fn code(self) -> &'static str {
                match self {
                    $(Self::$Rule => $code,)*
                }
            }

            /// The code that scanner displays show for it, if there is one.
            #[must_use]
            pub const fn scanner_status(self) -> Option<ScannerStatus> {
                match self {
                    $(Self::$Rule => $status,)*
                }
            }

            /// What to check next; `N` stands for the node, which a [`Finding`](super::Finding) fills in.
            pub(super) const fn advice_pattern(self) -> &'static str {
                match self {
                    $(Self::$Rule => $advice,)*
                }
            }
        }
    };
}

rules! {
    /// A node that has answered, or produced, does so no longer.
    NotAnswering, "not_answering", Some(ScannerStatus::STOPPED_COMMUNICATING),
        "check power, plug and drop cable of {node}, then its indicators: red is a duplicate MAC ID or bus-off, and takes \
         a power cycle";
    /// A node that is asked was never heard.
    NotFound, "not_found", Some(ScannerStatus::NOT_FOUND),
        "check that {node} has power, is plugged in, and that its switches show this MAC ID and the bit rate of the network";
    /// Answers take most of the time after which a peer gives up.
    SlowAnswers, "slow_answers", None,
        "raise the expected packet rate of {node}, or lower the load of the bus; check the cable if there are error frames";
    /// A master no longer serves a slave that answered it.
    MasterSilent, "master_silent", None,
        "check power and operating mode of the scanner {node}, and the code on its display";
    /// Two devices claim one MAC ID.
    DuplicateMacId, "duplicate_mac_id", Some(ScannerStatus::DUPLICATE_MAC_ID),
        "find both devices by their serial numbers, give one of them a free MAC ID, and cycle its power";
    /// A device with a communication fault answers on the offline connection set.
    WaitingForRecovery, "waiting_for_recovery", None,
        "give the device a free MAC ID with `recover`, or set its switches and cycle its power";
    /// A node says of itself that it has a fault.
    Fault, "fault", None,
        "look at the module status indicator and the manual of {node}; a fault that stays after a power cycle needs a \
         replacement";
    /// A device is not the one that is expected.
    KeyMismatch, "key_mismatch", Some(ScannerStatus::WRONG_DEVICE),
        "compare the type plate of {node} with the scan list: fit the right device, or correct the key";
    /// The I/O of a device has another size than its master expects.
    SizeMismatch, "size_mismatch", Some(ScannerStatus::SIZE_MISMATCH),
        "compare the I/O sizes of {node} in the scan list with its data sheet and its assembly settings, and see that all of its \
         modules are plugged in";
    /// Another device has taken over a MAC ID.
    IdentityChanged, "identity_changed", Some(ScannerStatus::WRONG_DEVICE),
        "if nobody has replaced {node}, look for a device with wrong address switches";
    /// A slave has refused its master.
    AllocationRefused, "allocation_refused", Some(ScannerStatus::INITIALISATION_REFUSED),
        "compare the I/O connections of {node} in the scan list with its data sheet; after a restart of the scanner, \
         cycle the power of {node}";
    /// Two masters want one slave.
    TwoMasters, "two_masters", Some(ScannerStatus::INITIALISATION_REFUSED),
        "take {node} out of the scan list of one of the two masters";
    /// A MAC ID that does not belong to the network.
    ForeignMacId, "foreign_mac_id", None,
        "find out who has connected {node}; if it belongs here, add it to the list of expected nodes";
    /// A slave was allocated by a master that is not its own.
    UnexpectedAllocation, "unexpected_allocation", None,
        "find out who has reconfigured the network; if it is right, correct the list of expected nodes";
    /// Two nodes send one identifier.
    IdentifierCollision, "identifier_collision", None,
        "look for a second device, a tool or a gateway that answers in the place of {node}: unplug {node} and see who still does";
    /// A controller has left the bus after too many errors.
    BusOff, "bus_off", Some(ScannerStatus::BUS_OFF),
        "check the bit rate first, then shield, terminators (60 ohm between the data wires without power) and drop lengths; \
         bus-off ends by a restart";
    /// A controller has seen many errors.
    ErrorPassive, "error_passive", None,
        "check terminators, shield and drop lengths near this node; one node alone on the bus is error-passive, too";
    /// Frames are destroyed, more than now and then.
    ErrorFrames, "error_frames", None,
        "unplug nodes one after the other until the errors stop: that node has another bit rate, or a bad drop; else check \
         terminators, shield, 24 V supply and motor cables nearby";
    /// Nobody acknowledges what is sent.
    NotAcknowledged, "not_acknowledged", Some(ScannerStatus::TRANSMIT_FAILED),
        "check that at least two nodes have power and the same bit rate, and that the trunk is not open";
    /// Frames that no DeviceNet node may send.
    ForeignTraffic, "foreign_traffic", None,
        "look for a device or tool of another protocol on this cable (CANopen, J1939, CAN FD)";
    /// The bus is nearly full.
    BusLoad, "bus_load", None,
        "raise the interscan delay, use change of state instead of poll, or a higher bit rate if the cable is short enough";
    /// Frames were lost before they were seen.
    Overrun, "overrun", Some(ScannerStatus::DATA_OVERRUN),
        "what was lost cannot be judged: relieve this computer, or use an adapter with a larger buffer";
    /// I/O data have another length than the connection.
    WrongLength, "wrong_length", Some(ScannerStatus::WRONG_LENGTH),
        "compare the I/O sizes of {node} in the scan list with its data sheet and its assembly settings";
    /// Fragments of I/O data are missing.
    FragmentSequence, "fragment_sequence", Some(ScannerStatus::FRAGMENT_SEQUENCE),
        "look for error frames and for a second node with this MAC ID; if there are none, {node} is faulty";
    /// A node checks its MAC ID anew without having said goodbye.
    Restarted, "restarted", None,
        "if nobody has switched {node} off, measure the 24 V at its plug under load: 11 V are the least";
    /// A node has left the network on purpose.
    Left, "left", None,
        "nothing, if {node} was reset or given another MAC ID on purpose";
}

impl Rule {
    /// Its bit in a set of rules.
    pub(super) fn bit(self) -> u32 {
        u32::try_from(self.index()).ok().and_then(|index| 1_u32.checked_shl(index)).unwrap_or(0)
    }

    /// Its place among all.
    pub(super) fn index(self) -> usize {
        Self::ALL.iter().position(|&rule| rule == self).unwrap_or_default()
    }

    /// A finding of it is over when it has not recurred for a while: nothing else tells its end.
    pub(super) const fn subsides(self) -> bool {
        match self {
            Self::SlowAnswers
            | Self::SizeMismatch
            | Self::IdentityChanged
            | Self::AllocationRefused
            | Self::TwoMasters
            | Self::ForeignMacId
            | Self::UnexpectedAllocation
            | Self::IdentifierCollision
            | Self::ForeignTraffic
            | Self::Overrun
            | Self::WrongLength
            | Self::FragmentSequence
            | Self::Restarted => true,
            Self::NotAnswering
            | Self::NotFound
            | Self::MasterSilent
            | Self::DuplicateMacId
            | Self::WaitingForRecovery
            | Self::Fault
            | Self::KeyMismatch
            | Self::BusOff
            | Self::ErrorPassive
            | Self::ErrorFrames
            | Self::NotAcknowledged
            | Self::BusLoad
            | Self::Left => false,
        }
    }
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.code())
    }
}

#[cfg(feature = "serde")]
impl serde::Serialize for Rule {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.code())
    }
}
