//! What a summary says of a node.

use core::fmt;

use cip_core::code::{DeviceType, VendorId};
use cip_core::message::AllocationChoice;
use cip_core::monitor::Traffic;
use cip_core::text::write_joined;
use link_core::Instant;

use super::Node;
use super::access::AccessState;
use crate::id::MacId;

bitflags::bitflags! {
    /// What a node was seen to be.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
    pub struct Roles: u8 {
        /// It answers on the predefined connection set.
        const SLAVE = 0x01;
        /// It uses the predefined connection set of others.
        const MASTER = 0x02;
        /// It opens connections by UCMM.
        const UCMM_CLIENT = 0x04;
        /// It answers UCMM requests.
        const UCMM_SERVER = 0x08;
        /// It uses the offline connection set.
        const TOOL = 0x10;
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
    /// The MAC ID.
    pub mac: MacId,
    /// What it was seen to be.
    pub roles: Roles,
    /// Its access to the network at the time of the last frame observed.
    pub access: AccessState,
    /// Vendor, from a duplicate MAC ID check or the Identity object.
    pub vendor: Option<VendorId>,
    /// Serial number, from the same.
    pub serial: Option<u32>,
    /// Identity object, attribute 2.
    pub device_type: Option<DeviceType>,
    /// Identity object, attribute 3.
    pub product: Option<u16>,
    /// Identity object, attribute 4: major, minor.
    pub revision: Option<(u8, u8)>,
    /// Identity object, attribute 7: ISO 8859-1 characters.
    pub product_name: heapless::Vec<u8, NAME_CAPACITY>,
    /// The allocation choice, if an allocation was seen: the bits whose connections have neither ended nor timed out.
    pub choice: Option<AllocationChoice>,
    /// The master that owns its predefined connection set: of the allocation as long as one of its connections lasts, or
    /// else the one that it answers.
    pub master: Option<MacId>,
    /// What it has sent.
    pub traffic: Traffic,
}

impl NodeRecord {
    pub(in crate::monitor) fn of(mac: MacId, node: &Node, now: Instant) -> Option<Self> {
        let known =
            node.traffic.first_seen().is_some() || !node.roles.is_empty() || node.allocation.is_some();
        known.then(|| Self {
            mac,
            roles: node.roles,
            access: node.access_at(now),
            vendor: node.identity.vendor,
            serial: node.identity.serial,
            device_type: node.identity.device_type,
            product: node.identity.product,
            revision: node.identity.revision,
            product_name: node.name.clone(),
            choice: node.told_owner().map(|_| node.live_choice()),
            master: node.owner(),
            traffic: node.traffic,
        })
    }
}

/// The longest product name that is kept.
pub const NAME_CAPACITY: usize = 32;
const ROLES: [(Roles, &str); 5] = [
    (Roles::SLAVE, "slave"),
    (Roles::MASTER, "master"),
    (Roles::UCMM_CLIENT, "UCMM client"),
    (Roles::UCMM_SERVER, "UCMM server"),
    (Roles::TOOL, "tool"),
];
