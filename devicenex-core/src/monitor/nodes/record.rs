//! What a summary says of a node.

use core::fmt;

use cip_core::code::DeviceType;
use cip_core::monitor::Traffic;
use cip_core::text::write_joined;
use link_core::Instant;

use super::Node;
use super::access::AccessState;
use crate::id::OperationalAddress;
use crate::message::DeviceIdentity;

bitflags::bitflags! {
    /// What a node was seen to be.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
    pub struct Roles: u8 {
        /// It sends Mini-who.
        const MANAGER = 0x01;
        /// It asks others for connections, or for attributes.
        const CLIENT = 0x02;
        /// It answers them.
        const SERVER = 0x04;
        /// It produces implicit messages.
        const PRODUCER = 0x08;
        /// It consumes them.
        const CONSUMER = 0x10;
    }
}

impl fmt::Display for Roles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let own = ROLES.into_iter().filter(|&(role, _)| self.contains(role));
        write_joined(f, ", ", own.map(|(_, name)| name))
    }
}

/// What is known of a node: a copy for a summary.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct NodeRecord {
    /// The operational address; 127 of a device that has none, of which there can be several.
    pub address: OperationalAddress,
    /// What it was seen to be.
    pub roles: Roles,
    /// Its access to the network at the time of the last frame observed.
    pub access: AccessState,
    /// Who it is, from its Hello.
    pub device: Option<DeviceIdentity>,
    /// The physical port in its Hello.
    pub port: Option<u8>,
    /// Identity object, attribute 2.
    pub device_type: Option<DeviceType>,
    /// Identity object, attribute 4, second byte.
    pub minor_revision: Option<u8>,
    /// Identity object, attribute 7: ISO 8859-1 characters.
    pub product_name: heapless::Vec<u8, NAME_CAPACITY>,
    /// What it has sent.
    pub traffic: Traffic,
}

impl NodeRecord {
    pub(in crate::monitor) fn of(node: &Node, now: Instant) -> Option<Self> {
        let is_known = node.traffic.first_seen().is_some() || !node.roles.is_empty() || node.device.is_some();
        is_known.then(|| Self {
            address: node.address,
            roles: node.roles,
            access: node.access_at(now),
            device: node.device,
            port: node.port,
            device_type: node.device_type,
            minor_revision: node.minor_revision,
            product_name: node.name.clone(),
            traffic: node.traffic,
        })
    }
}

/// The longest product name that is kept.
pub const NAME_CAPACITY: usize = 32;
const ROLES: [(Roles, &str); 5] = [
    (Roles::MANAGER, "manager"),
    (Roles::CLIENT, "client"),
    (Roles::SERVER, "server"),
    (Roles::PRODUCER, "producer"),
    (Roles::CONSUMER, "consumer"),
];
