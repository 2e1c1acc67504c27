//! Which connection a frame belongs to.

use core::fmt;

use devicenet_core::id::{MessageGroup, Purpose};
use devicenet_core::monitor::{ConnectionName, ConnectionRecord, Kind, Predefined, Reading};
use devicenet_core::{Identifier, MacId};
use devicenex_core::OperationalAddress;
use devicenex_core::message::ConnectionInstance;
use devicenex_core::monitor as nex;

/// A connection of a node, or another exchange that belongs together.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) struct ConnectionKey {
    pub(super) node: Node,
    pub(super) name: Name,
}

/// Whose it is.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) enum Node {
    /// Of all nodes: commands to many, and the offline connection set.
    All,
    /// Of none that is known.
    Unknown,
    /// The slave of a master/slave connection, the server of one opened by UCMM, the node that a check or a broadcast is
    /// about.
    Mac(u8),
}

/// What it is at its node.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) enum Name {
    /// There is one of it.
    Single(&'static str),
    /// Opened by UCMM, or made by Create.
    Dynamic {
        group: u8,
        /// `None` if the response to Open was not seen.
        instance: Option<u16>,
        client: u8,
    },
    /// On an identifier that UCMM assigns, but nothing tells the connection: the node is the sender.
    Unassigned { group: u8 },
    /// Of DeviceNeX: the connection with this instance.
    Instance(u16),
    /// Of DeviceNeX: what is produced on an 11-bit identifier, without more of the connection being known.
    Standard { group: u8, message: u8 },
    /// Dynamic connections beyond those that are kept apart.
    Others,
}

impl ConnectionKey {
    /// `None` for a frame that is not DeviceNet's.
    pub(super) fn of(reading: &Reading<'_>) -> Option<Self> {
        let identifier = Identifier::of_frame(&reading.frame)?;
        if let Some(dynamic) = &reading.dynamic {
            let name = Name::Dynamic {
                group: dynamic.group,
                instance: dynamic.instance.map(u16::from),
                client: dynamic.client.number(),
            };
            return Some(Self { node: Node::Mac(dynamic.server.number()), name });
        }
        let name = match (reading.kind, identifier.purpose()) {
            (Kind::Heartbeat, _) => "heartbeat",
            (Kind::Shutdown, _) => "shutdown",
            (_, Purpose::Dynamic) => {
                let name = Name::Unassigned { group: identifier.group().number()? };
                return Some(Self { node: Node::of(reading.src), name });
            }
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
            _ if is_to_all => Node::All,
            // The MAC ID of the predefined set is the slave's in both directions.
            MessageGroup::Group1 | MessageGroup::Group2 => Node::of(identifier.mac_id()),
            MessageGroup::Group3 if reading.kind == Kind::UnconnectedRequest => Node::of(reading.dst),
            MessageGroup::Group3 => Node::of(reading.src),
            MessageGroup::Group4 if reading.kind != Kind::Reserved => Node::All,
            MessageGroup::Group4 | MessageGroup::Invalid => Node::Unknown,
        };
        Some(Self { node, name: Name::Single(name) })
    }

    /// The same of DeviceNeX. What is for all nodes, and how they get their addresses, is one exchange.
    pub(super) fn of_nex(reading: &nex::Reading<'_>) -> Option<Self> {
        if let Some(on) = reading.connection {
            return Some(Self { node: Node::Mac(on.server.number()), name: Name::of_nex(on.name) });
        }
        let server = if reading.kind.is_answer() { reading.src } else { reading.dst };
        let (node, name) = match reading.kind {
            nex::Kind::HelloRequest | nex::Kind::HelloResponse | nex::Kind::MiniWho | nex::Kind::Roam => {
                (Node::All, "network access")
            }
            nex::Kind::ConnectionRequest | nex::Kind::ConnectionResponse => {
                (Node::of_address(server), "connection requests")
            }
            nex::Kind::ConnectionlessRequest
            | nex::Kind::ConnectionlessResponse
            | nex::Kind::Fragment
            | nex::Kind::FragmentAck => (Node::of_address(reading.connectionless_server()), "connectionless"),
            nex::Kind::ExplicitRequest | nex::Kind::ExplicitResponse => {
                (Node::of_address(server), "explicit")
            }
            nex::Kind::Implicit | nex::Kind::ImplicitAck => (Node::of_address(reading.src), "implicit"),
            nex::Kind::Reserved => (Node::Unknown, "reserved identifiers"),
            nex::Kind::Foreign => return None,
        };
        Some(Self { node, name: Name::Single(name) })
    }

    /// The key under which the frames of a connection of DeviceNeX are counted.
    pub(super) fn of_nex_record(record: &nex::ConnectionRecord) -> Self {
        Self { node: Node::Mac(record.server.number()), name: Name::of_nex(record.name) }
    }

    /// Where what has no room of its own is counted.
    pub(super) const OTHERS: Self = Self { node: Node::Unknown, name: Name::Others };

    /// The key under which the frames of a connection that the monitor knows are counted.
    pub(super) fn of_record(record: &ConnectionRecord) -> Option<Self> {
        let name = match record.name {
            ConnectionName::Predefined(predefined) => Name::Single(predefined.name()),
            ConnectionName::Dynamic { instance, group } => {
                Name::Dynamic { group, instance: instance.map(u16::from), client: record.client?.number() }
            }
        };
        Some(Self { node: Node::Mac(record.server.number()), name })
    }
}

impl Node {
    fn of(mac: Option<MacId>) -> Self {
        mac.map_or(Self::Unknown, |mac| Self::Mac(mac.number()))
    }

    fn of_address(address: Option<OperationalAddress>) -> Self {
        address.map_or(Self::Unknown, |address| Self::Mac(address.number()))
    }

    pub(super) fn mac(self) -> Option<u8> {
        match self {
            Self::Mac(mac) => Some(mac),
            Self::All | Self::Unknown => None,
        }
    }
}

/// As in a table.
impl fmt::Display for Node {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::All => f.write_str("all"),
            Self::Unknown => f.write_str("-"),
            Self::Mac(mac) => mac.fmt(f),
        }
    }
}

impl Name {
    fn of_nex(name: nex::ConnectionName) -> Self {
        match name {
            nex::ConnectionName::Instance(instance) => Self::Instance(instance.0),
            nex::ConnectionName::Explicit => Self::Single("explicit"),
            nex::ConnectionName::Standard { group, message } => {
                Self::Standard { group: group.number(), message: message.number() }
            }
        }
    }

    /// The client, where connections of several clients can bear the same name.
    pub(super) fn client(self) -> Option<u8> {
        match self {
            Self::Dynamic { client, .. } => Some(client),
            Self::Single(_)
            | Self::Unassigned { .. }
            | Self::Instance(_)
            | Self::Standard { .. }
            | Self::Others => None,
        }
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Single(name) => f.write_str(name),
            Self::Dynamic { group, instance, .. } => {
                ConnectionName::Dynamic { instance: instance.map(Into::into), group }.fmt(f)
            }
            Self::Unassigned { group } => write!(f, "group {group}, connection unknown"),
            Self::Instance(instance) => ConnectionInstance::of(instance.into()).fmt(f),
            Self::Standard { group, message } => write!(f, "group {group} message {message}"),
            Self::Others => f.write_str("further dynamic connections"),
        }
    }
}

/// Of a Group 2 Only server.
const UNCONNECTED_PORT: &str = "unconnected port";
