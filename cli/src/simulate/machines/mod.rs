//! The machines behind the nodes of a scenario: those of the cores, with what they keep without power, and with events that
//! carry the data that they are about.

mod device;
mod master;
mod nex;
mod slave;
mod tool;

pub(crate) use master::MasterMachine;
pub(super) use master::ScanTimes;
pub(crate) use master::release;
pub(crate) use nex::{DeviceMachine, ManagerMachine};
pub(crate) use slave::SlaveMachine;
pub(super) use tool::{Task, ToolMachine};

use devicenet_core::MacId;
use devicenet_core::access::{Config, MacIdSource};
use devicenet_core::message::PortNumber;

use crate::scenario::AccessNode;

/// The network access of a node.
pub(super) fn access_config(access: &AccessNode) -> Config {
    // Both were checked with the scenario.
    let port = PortNumber::new(access.port).unwrap_or(PortNumber::ZERO);
    let mac = MacId::new(access.mac).unwrap_or(MacId::DEFAULT);
    Config {
        mac_id_source: if access.switches { MacIdSource::Switches } else { MacIdSource::Software },
        bus_off_interrupt: access.boi,
        quick_connect: access.quick_connect,
        offline_set: access.offline_set,
        ..Config::new(access.on_the_wire(), port, mac)
    }
}
