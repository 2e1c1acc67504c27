//! What an identifier is for.

use core::fmt;

use super::{Identifier, MessageGroup};

/// The use that DeviceNet assigns to an identifier. The table of them is in the [module](super) text.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Purpose {
    /// Assigned when a connection is opened: Group 1 Message IDs 0-11, Group 3 Message IDs 0-4.
    Dynamic,
    /// Group 1 Message ID 12: a slave answers a multicast poll.
    MulticastPollResponse,
    /// Group 1 Message ID 13: a slave's change-of-state or cyclic message.
    ChangeOfState,
    /// Group 1 Message ID 14: a slave answers a bit-strobe.
    BitStrobeResponse,
    /// Group 1 Message ID 15: a slave answers a poll, or acknowledges its master's COS/cyclic message.
    PollResponse,
    /// Group 2 Message ID 0: a master strobes its slaves.
    BitStrobeCommand,
    /// Group 2 Message ID 1: a master polls a group of slaves.
    MulticastPollCommand,
    /// Group 2 Message ID 2: a master acknowledges a slave's COS/cyclic message.
    ChangeOfStateAcknowledge,
    /// Group 2 Message ID 3: a slave answers an explicit request, connected or not; heartbeat and shutdown of a Group 2
    /// Only server.
    ExplicitResponse,
    /// Group 2 Message ID 4: a master's connected explicit request.
    ExplicitRequest,
    /// Group 2 Message ID 5: a master polls a slave, or sends it a COS/cyclic message.
    PollCommand,
    /// Group 2 Message ID 6: Allocate and Release without a connection. Never assigned dynamically.
    Group2UnconnectedRequest,
    /// Group 2 Message ID 7: duplicate MAC ID check, request and response.
    DuplicateMacCheck,
    /// Group 3 Message ID 5: UCMM response; heartbeat and shutdown of a UCMM-capable node.
    UnconnectedResponse,
    /// Group 3 Message ID 6: UCMM request.
    UnconnectedRequest,
    /// Group 4 Message ID 0x2C: a faulted node answers.
    CommunicationFaultedResponse,
    /// Group 4 Message ID 0x2D: a tool asks faulted nodes.
    CommunicationFaultedRequest,
    /// Group 4 Message ID 0x2E: the owner defends the offline connection set.
    OfflineOwnershipResponse,
    /// Group 4 Message ID 0x2F: a tool asks for the offline connection set.
    OfflineOwnershipRequest,
    /// Group 4 Message IDs 0x00-0x2B.
    Reserved,
    /// 0x7F0-0x7FF.
    Invalid,
}

/// Whose MAC ID an identifier carries.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum MacIdRole {
    /// The sender's.
    Source,
    /// The receiver's.
    Destination,
    /// That of a group of receivers.
    Multicast,
    /// The one that is being checked: that of the sender, and of every node that should not be there.
    Checked,
}

impl Identifier {
    /// What the identifier is for.
    #[must_use]
    pub const fn purpose(self) -> Purpose {
        match (self.group(), self.message_id()) {
            (MessageGroup::Group1, 0xC) => Purpose::MulticastPollResponse,
            (MessageGroup::Group1, 0xD) => Purpose::ChangeOfState,
            (MessageGroup::Group1, 0xE) => Purpose::BitStrobeResponse,
            (MessageGroup::Group1, 0xF) => Purpose::PollResponse,
            (MessageGroup::Group2, 0) => Purpose::BitStrobeCommand,
            (MessageGroup::Group2, 1) => Purpose::MulticastPollCommand,
            (MessageGroup::Group2, 2) => Purpose::ChangeOfStateAcknowledge,
            (MessageGroup::Group2, 3) => Purpose::ExplicitResponse,
            (MessageGroup::Group2, 4) => Purpose::ExplicitRequest,
            (MessageGroup::Group2, 5) => Purpose::PollCommand,
            (MessageGroup::Group2, 6) => Purpose::Group2UnconnectedRequest,
            // Three bits: this is Message ID 7.
            (MessageGroup::Group2, _) => Purpose::DuplicateMacCheck,
            (MessageGroup::Group3, 5) => Purpose::UnconnectedResponse,
            (MessageGroup::Group3, 6) => Purpose::UnconnectedRequest,
            (MessageGroup::Group1 | MessageGroup::Group3, _) => Purpose::Dynamic,
            (MessageGroup::Group4, 0x2C) => Purpose::CommunicationFaultedResponse,
            (MessageGroup::Group4, 0x2D) => Purpose::CommunicationFaultedRequest,
            (MessageGroup::Group4, 0x2E) => Purpose::OfflineOwnershipResponse,
            (MessageGroup::Group4, 0x2F) => Purpose::OfflineOwnershipRequest,
            (MessageGroup::Group4, _) => Purpose::Reserved,
            (MessageGroup::Invalid, _) => Purpose::Invalid,
        }
    }
}

impl Purpose {
    /// Whose MAC ID the identifier carries; `None` where it carries none.
    #[must_use]
    pub const fn mac_id_role(self) -> Option<MacIdRole> {
        match self {
            Self::Dynamic
            | Self::MulticastPollResponse
            | Self::ChangeOfState
            | Self::BitStrobeResponse
            | Self::PollResponse
            | Self::BitStrobeCommand
            | Self::ExplicitResponse
            | Self::UnconnectedResponse
            | Self::UnconnectedRequest => Some(MacIdRole::Source),
            Self::ChangeOfStateAcknowledge
            | Self::ExplicitRequest
            | Self::PollCommand
            | Self::Group2UnconnectedRequest => Some(MacIdRole::Destination),
            Self::MulticastPollCommand => Some(MacIdRole::Multicast),
            Self::DuplicateMacCheck => Some(MacIdRole::Checked),
            Self::CommunicationFaultedResponse
            | Self::CommunicationFaultedRequest
            | Self::OfflineOwnershipResponse
            | Self::OfflineOwnershipRequest
            | Self::Reserved
            | Self::Invalid => None,
        }
    }

    /// The name, as a reader of a trace knows it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Dynamic => "dynamic connection",
            Self::MulticastPollResponse => "multicast poll response",
            Self::ChangeOfState => "COS/cyclic message",
            Self::BitStrobeResponse => "bit-strobe response",
            Self::PollResponse => "poll response",
            Self::BitStrobeCommand => "bit-strobe command",
            Self::MulticastPollCommand => "multicast poll command",
            Self::ChangeOfStateAcknowledge => "COS/cyclic acknowledge",
            Self::ExplicitResponse => "explicit response",
            Self::ExplicitRequest => "explicit request",
            Self::PollCommand => "poll command",
            Self::Group2UnconnectedRequest => "Group 2 unconnected request",
            Self::DuplicateMacCheck => "duplicate MAC ID check",
            Self::UnconnectedResponse => "unconnected response",
            Self::UnconnectedRequest => "unconnected request",
            Self::CommunicationFaultedResponse => "Communication Faulted response",
            Self::CommunicationFaultedRequest => "Communication Faulted request",
            Self::OfflineOwnershipResponse => "Offline Ownership response",
            Self::OfflineOwnershipRequest => "Offline Ownership request",
            Self::Reserved => "reserved Group 4 message",
            Self::Invalid => "invalid identifier",
        }
    }
}

impl fmt::Display for Purpose {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The ranges of the table in the module text, as (first, last, purpose) for whole ranges of one Message ID.
    #[test]
    fn the_table_holds_for_all_2048_identifiers() {
        for raw in 0..=0x7FF_u16 {
            let expected = match raw {
                0x000..=0x2FF | 0x600..=0x73F => Purpose::Dynamic,
                0x300..=0x33F => Purpose::MulticastPollResponse,
                0x340..=0x37F => Purpose::ChangeOfState,
                0x380..=0x3BF => Purpose::BitStrobeResponse,
                0x3C0..=0x3FF => Purpose::PollResponse,
                0x400..=0x5FF => [
                    Purpose::BitStrobeCommand,
                    Purpose::MulticastPollCommand,
                    Purpose::ChangeOfStateAcknowledge,
                    Purpose::ExplicitResponse,
                    Purpose::ExplicitRequest,
                    Purpose::PollCommand,
                    Purpose::Group2UnconnectedRequest,
                    Purpose::DuplicateMacCheck,
                ][usize::from(raw % 8)],
                0x740..=0x77F => Purpose::UnconnectedResponse,
                0x780..=0x7BF => Purpose::UnconnectedRequest,
                0x7C0..=0x7EB => Purpose::Reserved,
                0x7EC => Purpose::CommunicationFaultedResponse,
                0x7ED => Purpose::CommunicationFaultedRequest,
                0x7EE => Purpose::OfflineOwnershipResponse,
                0x7EF => Purpose::OfflineOwnershipRequest,
                _ => Purpose::Invalid,
            };
            let id = Identifier::new(raw).unwrap();
            assert_eq!(id.purpose(), expected, "{id:?}");
            assert_eq!(id.mac_id().is_some(), expected.mac_id_role().is_some(), "{id:?}");
        }
    }
}
