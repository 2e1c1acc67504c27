//! Which connection a frame belongs to.

use devicenet_core::Identifier;
use devicenet_core::id::{MessageGroup, Purpose};
use devicenet_core::monitor::{ConnectionName, Kind, Predefined, Reading};

/// A connection of a node, or another exchange that belongs together.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) struct ConnectionKey {
    /// The slave of a master/slave connection, the node that a check or a broadcast is about, the sender on a connection
    /// opened by UCMM; none for a command to all.
    pub(super) node: Option<u8>,
    pub(super) name: &'static str,
}

impl ConnectionKey {
    /// `None` for a frame that is not DeviceNet's.
    pub(super) fn of(reading: &Reading<'_>) -> Option<Self> {
        let identifier = Identifier::of_frame(&reading.frame)?;
        let name = match (reading.kind, identifier.purpose()) {
            (Kind::Heartbeat, _) => "heartbeat",
            (Kind::Shutdown, _) => "shutdown",
            (_, Purpose::Dynamic) => dynamic(identifier.group().number()),
            (_, Purpose::MulticastPollResponse | Purpose::MulticastPollCommand) => {
                Predefined::MulticastPoll.name()
            }
            (_, Purpose::ChangeOfState | Purpose::ChangeOfStateAcknowledge) => Predefined::CosCyclic.name(),
            (_, Purpose::BitStrobeResponse | Purpose::BitStrobeCommand) => Predefined::BitStrobe.name(),
            (_, Purpose::PollResponse | Purpose::PollCommand) => Predefined::Poll.name(),
            (_, Purpose::Group2UnconnectedRequest) => UNCONNECTED_PORT,
            (Kind::UnconnectedResponse, Purpose::ExplicitResponse) => UNCONNECTED_PORT,
            (_, Purpose::ExplicitResponse | Purpose::ExplicitRequest) => Predefined::Explicit.name(),
            (_, Purpose::DuplicateMacCheck) => "duplicate MAC ID check",
            (_, Purpose::UnconnectedResponse | Purpose::UnconnectedRequest) => "UCMM",
            (
                _,
                Purpose::CommunicationFaultedResponse
                | Purpose::CommunicationFaultedRequest
                | Purpose::OfflineOwnershipResponse
                | Purpose::OfflineOwnershipRequest,
            ) => "offline connection set",
            (_, Purpose::Reserved | Purpose::Invalid) => "reserved identifiers",
        };
        let is_to_all = matches!(reading.kind, Kind::BitStrobeCommand | Kind::MulticastPollCommand);
        let node = match identifier.group() {
            _ if is_to_all => None,
            // The MAC ID of the predefined set is the slave's in both directions.
            MessageGroup::Group1 | MessageGroup::Group2 => identifier.mac_id(),
            MessageGroup::Group3 if reading.kind == Kind::UnconnectedRequest => reading.dst,
            MessageGroup::Group3 => reading.src,
            MessageGroup::Group4 | MessageGroup::Invalid => None,
        };
        Some(Self { node: node.map(u8::from), name })
    }
}

/// The name under which the frames of a connection are counted.
pub(super) fn name(connection: ConnectionName) -> &'static str {
    match connection {
        ConnectionName::Predefined(predefined) => predefined.name(),
        ConnectionName::Dynamic { group, .. } => dynamic(Some(group)),
    }
}

fn dynamic(group: Option<u8>) -> &'static str {
    match group {
        Some(1) => "opened in group 1",
        Some(2) => "opened in group 2",
        Some(3) => "opened in group 3",
        _ => "opened",
    }
}

/// Of a Group 2 Only server.
const UNCONNECTED_PORT: &str = "unconnected port";
