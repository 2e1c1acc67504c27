//! The nodes that speak DeviceNeX.

mod application;
mod device;
mod manager;

pub(crate) use device::DeviceMachine;
pub(crate) use manager::ManagerMachine;

use devicenex_core::access::{Config, Role};
use devicenex_core::message::PortByte;

use crate::scenario::NexNode;

/// The network access of a node.
fn access_config(node: &NexNode, role: Role) -> Config {
    Config {
        hello_wait: node.hello_wait,
        announcement: node.announcement,
        bus_off_interrupt: node.boi,
        ..Config::new(node.on_the_wire(), PortByte(node.port), role)
    }
}
