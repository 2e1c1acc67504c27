//! What is known of a node.

mod access;
mod record;

use cip_core::code::DeviceType;
use cip_core::monitor::{Seen, Traffic};
use link_core::Instant;

use crate::id::OperationalAddress;
use crate::message::DeviceIdentity;

pub use access::AccessState;
pub(super) use access::SECOND_HELLO_WITHIN;
pub use record::{NAME_CAPACITY, NodeRecord, Roles};

/// All that is known of a node: of an address, or of a device that has none.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Node {
    pub(super) address: OperationalAddress,
    pub(super) access: AccessState,
    pub(super) access_since: Instant,
    pub(super) roles: Roles,
    pub(super) device: Option<DeviceIdentity>,
    pub(super) port: Option<u8>,
    pub(super) device_type: Option<DeviceType>,
    pub(super) minor_revision: Option<u8>,
    pub(super) name: heapless::Vec<u8, NAME_CAPACITY>,
    /// The Hello request that a Hello response answers.
    pub(super) hello: Option<Seen>,
    /// The device that has sent it, if it is not the one known by this address.
    pub(super) rival: Option<DeviceIdentity>,
    /// The ROAM that the device has got, and the address in it.
    pub(super) roam: Option<(Seen, OperationalAddress)>,
    pub(super) traffic: Traffic,
}

impl Node {
    pub(super) const fn new(address: OperationalAddress) -> Self {
        Self {
            address,
            access: AccessState::Unknown,
            access_since: Instant::ZERO,
            roles: Roles::empty(),
            device: None,
            port: None,
            device_type: None,
            minor_revision: None,
            name: heapless::Vec::new(),
            hello: None,
            rival: None,
            roam: None,
            traffic: Traffic::NONE,
        }
    }

    /// Keeps as much of a product name as there is room for.
    pub(super) fn set_name(&mut self, name: &[u8]) {
        self.name.clear();
        self.name.extend(name.iter().copied().take(NAME_CAPACITY));
    }

    /// Another device has the address from now on.
    pub(super) fn becomes(&mut self, device: DeviceIdentity) {
        if self.device != Some(device) {
            self.device = Some(device);
            self.port = None;
            self.device_type = None;
            self.minor_revision = None;
            self.name.clear();
        }
        self.rival = None;
    }

    /// The device has gone to another address.
    pub(super) fn leaves(&mut self, at: Instant) {
        self.device = None;
        self.name.clear();
        self.hello = None;
        self.rival = None;
        self.enter(AccessState::OffLine, at);
    }
}
