//! The nodes that speak DeviceNeX.

use cip_core::identity::DeviceIdentity;
use devicenex_core::message;

/// What every DeviceNeX node has.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct NexNode {
    /// The operational address that it begins with; 127 is none.
    pub oa: u8,
    /// Who it is.
    pub device: DeviceIdentity,
    /// Physical port number, 0 to 127.
    pub port: u8,
    /// Bus-off interrupt: after bus-off reset the controller and begin anew.
    pub boi: bool,
    /// How long others have to object after each Hello, in ms.
    pub hello_wait: u16,
    /// How often it tells its address when it is on line, in ms; 0: never.
    pub announcement: u32,
}

impl NexNode {
    /// What a Hello shows of it.
    #[must_use]
    pub const fn on_the_wire(&self) -> message::DeviceIdentity {
        message::DeviceIdentity {
            vendor: self.device.vendor,
            product_code: self.device.product_code,
            major_revision: self.device.revision.major,
            serial: self.device.serial,
        }
    }
}

/// A node with `role = "device"`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct DeviceNode {
    /// Its place on the network.
    pub node: NexNode,
}

/// A node with `role = "manager"`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ManagerNode {
    /// Its place on the network.
    pub node: NexNode,
}
