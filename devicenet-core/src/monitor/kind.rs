//! What a frame is.

use core::fmt;

/// The kind of a frame: what its identifier, its header and the learned state make of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Kind {
    /// Duplicate MAC ID check request (Group 2, Message ID 7).
    DupMacRequest,
    /// Duplicate MAC ID check response: the MAC ID is taken.
    DupMacResponse,
    /// Request on an explicit messaging connection.
    ExplicitRequest,
    /// Response on an explicit messaging connection.
    ExplicitResponse,
    /// UCMM request (Group 3, Message ID 6).
    UnconnectedRequest,
    /// UCMM response (Group 3, Message ID 5), or the response to a request on the Group 2 Only unconnected port.
    UnconnectedResponse,
    /// Request on the Group 2 Only unconnected port (Group 2, Message ID 6).
    Group2UnconnectedRequest,
    /// Fragment of an explicit message.
    Fragment,
    /// Acknowledge of such a fragment.
    FragmentAck,
    /// I/O poll command.
    PollCommand,
    /// I/O poll response.
    PollResponse,
    /// I/O multicast poll command.
    MulticastPollCommand,
    /// I/O multicast poll response.
    MulticastPollResponse,
    /// I/O bit-strobe command.
    BitStrobeCommand,
    /// I/O bit-strobe response.
    BitStrobeResponse,
    /// Change-of-state or cyclic I/O message, of the slave or of the master.
    CosCyclic,
    /// Its acknowledge.
    CosCyclicAck,
    /// Message of an I/O connection with an identifier of its own.
    Io,
    /// Device Heartbeat.
    Heartbeat,
    /// Device Shutdown.
    Shutdown,
    /// Request to nodes with a communication fault: Who, Identify, Change MAC ID.
    OfflineFaultRequest,
    /// Answer of a node with a communication fault.
    OfflineFaultResponse,
    /// Offline Ownership request.
    OfflineOwnershipRequest,
    /// Offline Ownership response: another tool owns the offline connection set.
    OfflineOwnershipResponse,
    /// An identifier of Group 4 without a use.
    Reserved,
    /// An identifier that must not be used (0x7F0-0x7FF).
    Invalid,
    /// Not a DeviceNet frame: a 29-bit identifier or a remote frame.
    Foreign,
}

impl Kind {
    /// All kinds, in the order of the table of names.
    pub const ALL: [Self; 27] = [
        Self::DupMacRequest,
        Self::DupMacResponse,
        Self::ExplicitRequest,
        Self::ExplicitResponse,
        Self::UnconnectedRequest,
        Self::UnconnectedResponse,
        Self::Group2UnconnectedRequest,
        Self::Fragment,
        Self::FragmentAck,
        Self::PollCommand,
        Self::PollResponse,
        Self::MulticastPollCommand,
        Self::MulticastPollResponse,
        Self::BitStrobeCommand,
        Self::BitStrobeResponse,
        Self::CosCyclic,
        Self::CosCyclicAck,
        Self::Io,
        Self::Heartbeat,
        Self::Shutdown,
        Self::OfflineFaultRequest,
        Self::OfflineFaultResponse,
        Self::OfflineOwnershipRequest,
        Self::OfflineOwnershipResponse,
        Self::Reserved,
        Self::Invalid,
        Self::Foreign,
    ];

    /// The machine-readable name: lower case with underscores.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::DupMacRequest => "dup_mac_request",
            Self::DupMacResponse => "dup_mac_response",
            Self::ExplicitRequest => "explicit_request",
            Self::ExplicitResponse => "explicit_response",
            Self::UnconnectedRequest => "unconnected_request",
            Self::UnconnectedResponse => "unconnected_response",
            Self::Group2UnconnectedRequest => "group2_unconnected_request",
            Self::Fragment => "fragment",
            Self::FragmentAck => "fragment_ack",
            Self::PollCommand => "poll_command",
            Self::PollResponse => "poll_response",
            Self::MulticastPollCommand => "multicast_poll_command",
            Self::MulticastPollResponse => "multicast_poll_response",
            Self::BitStrobeCommand => "bit_strobe_command",
            Self::BitStrobeResponse => "bit_strobe_response",
            Self::CosCyclic => "cos_cyclic",
            Self::CosCyclicAck => "cos_cyclic_ack",
            Self::Io => "io",
            Self::Heartbeat => "heartbeat",
            Self::Shutdown => "shutdown",
            Self::OfflineFaultRequest => "offline_fault_request",
            Self::OfflineFaultResponse => "offline_fault_response",
            Self::OfflineOwnershipRequest => "offline_ownership_request",
            Self::OfflineOwnershipResponse => "offline_ownership_response",
            Self::Reserved => "reserved",
            Self::Invalid => "invalid",
            Self::Foreign => "foreign",
        }
    }

    /// True for the kinds that carry I/O data or acknowledge it.
    #[must_use]
    pub const fn is_io(self) -> bool {
        matches!(
            self,
            Self::PollCommand
                | Self::PollResponse
                | Self::MulticastPollCommand
                | Self::MulticastPollResponse
                | Self::BitStrobeCommand
                | Self::BitStrobeResponse
                | Self::CosCyclic
                | Self::CosCyclicAck
                | Self::Io
        )
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(feature = "serde")]
impl serde::Serialize for Kind {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}
