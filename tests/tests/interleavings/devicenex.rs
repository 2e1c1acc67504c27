//! DeviceNeX: Hello, and who keeps an operational address.

use std::time::Duration;

use devicenex_core::OperationalAddress;
use devicenex_core::access::{Access, Config, Role, StateKind};
use devicenex_core::id::Direction;
use devicenex_core::message::{DeviceIdentity, Hello, PortByte};
use link_core::{BitRate, Frame};

use super::model::{Bus, CONFLICT_ENDS, ONE_OWNER, Protocol, WAIT_MILLIS, WAY_FORWARD};

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct DeviceNex;

impl Protocol for DeviceNex {
    type Access = Access;

    /// It begins with an address, as if a ROAM had given it.
    fn access(place: u32, address: u8, announcement: u32) -> Access {
        let vendor = 0x1234.into();
        let device = DeviceIdentity { vendor, product_code: 7, major_revision: 1, serial: place };
        let address = OperationalAddress::new(address).unwrap();
        let role = Role::NetworkManager { address, bit_rate: BitRate::K500 };
        let mut config = Config::new(device, PortByte::ZERO, role);
        config.hello_wait = WAIT_MILLIS;
        config.announcement = announcement;
        Access::new(config)
    }

    fn address_on_line(access: &Access) -> Option<u8> {
        access.is_online().then(|| access.address().number())
    }

    fn is_settled(access: &Access) -> bool {
        matches!(access.state().kind(), StateKind::Online | StateKind::Standby)
    }

    fn is_challenge(frame: &Frame) -> bool {
        matches!(Hello::of_frame(frame), Some(Ok(hello)) if hello.direction == Direction::Request)
    }

    fn forget_time_and_counts(access: &mut Access, span: Duration) {
        access.shift_time(span);
        access.clear_counters();
    }
}

fn bus(addresses: &[u8]) -> Bus<DeviceNex> {
    Bus::of(addresses)
}

#[test]
fn two_nodes_with_one_address() {
    let worlds = bus(&[67, 67]).check("DeviceNeX, two nodes, one address");
    assert!(worlds > 1000, "{worlds}");
}

#[test]
fn two_nodes_with_different_addresses() {
    bus(&[67, 68]).check("DeviceNeX, two nodes, two addresses");
}

#[test]
fn three_nodes_of_which_two_or_three_want_one_address() {
    for addresses in [[67, 67, 67], [67, 68, 67]] {
        let bus = Bus { steps: 2, ..bus(&addresses) };
        bus.check(&format!("DeviceNeX, three nodes, addresses {addresses:?}"));
    }
}

#[test]
fn joined_segments() {
    let bus = Bus { split: true, announcement: 6, prompt: true, ..bus(&[67, 67]) };
    bus.check("DeviceNeX, two joined segments, announcements");
}

/// The checker finds what it should: a copy that does not defend its address.
#[test]
fn a_node_that_does_not_defend_its_address_is_found() {
    let found = Bus { deaf_on_line: true, ..bus(&[67, 67]) }.finds(ONE_OWNER);
    println!("two owners after {} steps: {found:?}", found.len());
}

/// And that the announcement is what ends the conflict of joined segments: without it, nobody speaks.
#[test]
fn without_announcements_joined_segments_keep_two_owners() {
    let silent = Bus { split: true, prompt: true, ..bus(&[67, 67]) };
    silent.clone().finds(CONFLICT_ENDS);
    silent.finds(WAY_FORWARD);
}
