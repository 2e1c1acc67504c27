//! DeviceNet: the duplicate MAC ID check.
//!
//! Two requests for one MAC ID in the same bit time destroy each other; that is for the simulated bus
//! (`tests/tests/devicenet/access.rs`). Here one frame follows the other.

use std::time::Duration;

use devicenet_core::access::{Access, Config, StateKind};
use devicenet_core::id::Purpose;
use devicenet_core::message::{DeviceIdentity, Direction, DuplicateMacCheck, PortNumber, Wire};
use devicenet_core::{Identifier, MacId};
use link_core::Frame;

use super::model::{Bus, ONE_OWNER, Protocol};

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct DeviceNet;

impl Protocol for DeviceNet {
    type Access = Access;

    fn access(place: u32, address: u8, _: u32) -> Access {
        let device = DeviceIdentity { vendor: 0x1234.into(), serial: place };
        Access::new(Config::new(device, PortNumber::ZERO, MacId::new(address).unwrap()))
    }

    fn address_on_line(access: &Access) -> Option<u8> {
        access.is_online().then(|| access.mac_id().number())
    }

    /// A duplicate leads to the communication fault, and out of it only a tool or a reset.
    fn is_settled(access: &Access) -> bool {
        matches!(access.state().kind(), StateKind::OnLine | StateKind::CommFault)
    }

    fn is_challenge(frame: &Frame) -> bool {
        let is_check =
            Identifier::of_frame(frame).is_some_and(|id| id.purpose() == Purpose::DuplicateMacCheck);
        let check = DuplicateMacCheck::parse(frame.data());
        is_check && check.is_ok_and(|check| check.direction == Direction::Request)
    }

    fn forget_time_and_counts(access: &mut Access, span: Duration) {
        access.shift_time(span);
        access.clear_counters();
    }
}

fn bus(addresses: &[u8]) -> Bus<DeviceNet> {
    Bus::of(addresses)
}

#[test]
fn two_nodes_with_one_mac_id() {
    bus(&[37, 37]).check("DeviceNet, two nodes, one MAC ID");
}

#[test]
fn two_nodes_with_different_mac_ids() {
    bus(&[37, 38]).check("DeviceNet, two nodes, two MAC IDs");
}

#[test]
fn three_nodes_of_which_two_or_three_have_one_mac_id() {
    for addresses in [[37, 37, 37], [37, 38, 37]] {
        let bus = Bus { steps: 2, ..bus(&addresses) };
        bus.check(&format!("DeviceNet, three nodes, MAC IDs {addresses:?}"));
    }
}

#[test]
fn a_node_that_does_not_defend_its_mac_id_is_found() {
    let found = Bus { deaf_on_line: true, ..bus(&[37, 37]) }.finds(ONE_OWNER);
    println!("two owners after {} steps: {found:?}", found.len());
}
