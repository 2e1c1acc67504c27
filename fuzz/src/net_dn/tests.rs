//! The operations do what they say, and the oracle sees it.

use super::*;

fn after(bytes: &[u8]) -> Network {
    run(bytes);
    let mut network = Network::new(bytes[0]);
    for op in bytes[1..].chunks(2) {
        network.apply(op[0], op[1]);
    }
    network
}

#[test]
fn every_slave_has_one_of_the_masters() {
    let network = after(&[2, 0, 0xC5, 5, 7, 5, 0x87, 0, 0xC5]);
    for at in [2, 3] {
        assert!(network.referee.owner(at).is_some_and(|owner| MASTERS.contains(&owner)));
    }
}

#[test]
fn of_two_nodes_with_one_mac_id_one_is_on_line_at_most() {
    let network = after(&[0, 0, 0xC5]);
    let online = [2, 4].map(|at| network.referee.is_online(at, network.now));
    assert_ne!(online, [true, true]);
}

/// With its unconnected port and without: the masters know both doors.
#[test]
fn a_ucmm_capable_slave_has_one_of_the_masters() {
    for plan in [0x13, 0x53] {
        let network = after(&[plan, 0, 0xC8]);
        assert!(network.referee.owner(5).is_some_and(|owner| MASTERS.contains(&owner)), "{plan:02X}");
    }
}

/// The twins at 10 have faulted each other; one of them gets 13, and is on line.
#[test]
fn a_tool_repairs_a_twin() {
    let change = 13_u8;
    let argument = 5 | 2 << 3 | 3 << 5;
    let network = after(&[0x10, 0, 0xC5, 0xF0, 0, 0, 0xC3, 0xF0, argument, 0, 0xC4]);
    assert_eq!(network.referee.mac(4), change);
    assert!(network.referee.is_online(4, network.now));
}

#[test]
fn with_the_bus_off_interrupt_a_node_comes_back_and_without_it_stays_away() {
    for (plan, comes_back) in [(0x33, true), (0x13, false)] {
        let network = after(&[plan, 0, 0xC5, 0xF8, 2, 0xF8, 6, 0, 0xC5]);
        for at in [2, 6] {
            assert_eq!(network.referee.is_online(at, network.now), comes_back, "{plan:02X}");
        }
    }
}
