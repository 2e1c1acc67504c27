//! Network access on the simulated bus: bit rates, collisions, segments.

use std::collections::HashSet;
use std::time::Duration;

use devicenex_core::OperationalAddress;
use devicenex_core::access::StateKind;
use devicenex_core::message::{MiniWho, Roam};
use link_core::{BitRate, Instant};
use transport_mock::nodes::Replay;
use transport_mock::{Change, NodeConfig, NodeId};

use super::plant::*;

/// A manager that is alone with detectors is acknowledged by nobody. After sixteen attempts it is error-passive, its error
/// flags no longer spoil its frames, and the detectors lock. None of them has disturbed the bus, or sent an error flag.
#[test]
fn detectors_find_the_rate_of_a_lone_manager_without_a_word() {
    for rate in [BitRate::K125, BitRate::K250, BitRate::K500] {
        let mut plant = Plant::at(rate);
        let manager = plant.manager(1, 1, 0);
        let devices: Vec<_> = (0..5).map(|n| plant.device(0x100 + n, 0)).collect();
        plant.run(7000);
        for &device in &devices {
            assert_eq!(plant.access(device).bit_rate(), Some(rate), "{rate}");
            assert_eq!(plant.network.counters(device).tec, 0);
        }
        plant.run(10_000);
        assert_eq!(plant.kind(manager), StateKind::Online);
        assert!(devices.iter().all(|&device| plant.kind(device) == StateKind::Standby));
    }
}

#[test]
fn a_network_of_detectors_alone_stays_silent() {
    let mut plant = Plant::new();
    let devices: Vec<_> = (0..3).map(|n| plant.device(n, u64::from(n))).collect();
    plant.run(60_000);
    assert_eq!(plant.trace, []);
    assert_eq!(plant.spoilt, []);
    assert!(devices.iter().all(|&device| plant.kind(device) == StateKind::DetectingBitRate));
}

/// Out of the box, all at once: the case in which DeviceNet's nodes destroy each other's messages. Every Hello is its
/// sender's own, so arbitration puts them in order. The errors are those of the manager while it was alone.
#[test]
fn a_storm_of_126_hellos_in_one_bit_time_costs_no_error() {
    let mut plant = Plant::new();
    plant.manager(1, 1, 0);
    plant.run(10);
    let devices: Vec<_> = (0..126).map(|n| plant.device(FIRST + n, 10)).collect();
    plant.run(20_000);
    assert!(devices.iter().all(|&device| plant.kind(device) == StateKind::Standby));
    let hellos: Vec<_> = plant.trace.iter().filter(|(_, id)| id.starts_with("1FFE")).collect();
    assert_eq!(hellos.len(), 2 * 126);
    let (first, last) = (hellos[0].0, hellos[125].0);
    let burst = last.saturating_since(first);
    assert!(burst < Duration::from_millis(100), "126 Hellos in {burst:?}");
    let different: HashSet<_> = hellos[..126].iter().map(|(_, id)| id).collect();
    assert_eq!(different.len(), 126, "the first of each");
    assert_eq!(plant.spoilt_since(first), 0);
    for &device in &devices {
        assert_eq!(plant.network.counters(device).tec, 0);
        assert_eq!(plant.access(device).bus_off_counter(), 0);
    }
}

/// All 127 addresses: a Mini-who finds 126 devices at once, and a ROAM each gives them what is left beside the manager's.
#[test]
fn a_full_network_of_127_nodes_gets_on_line() {
    let mut plant = Plant::new();
    let manager = plant.manager(1, 1, 0);
    let devices: Vec<_> = (0..126).map(|n| plant.device(FIRST + n, 0)).collect();
    let at = |millis| Instant::from_millis(START + millis);
    let addresses = || OperationalAddress::all().filter(|address| address.number() != 1);
    let mut frames = vec![(at(0), MiniWho { serial_low: 1 }.frame().unwrap())];
    frames.extend(addresses().enumerate().map(|(place, requested)| {
        let place = u32::try_from(place).unwrap();
        let roam = Roam { target: device(FIRST + place), requested };
        (at(1000 + u64::from(place) * 5), roam.frame().unwrap())
    }));
    // It comes late, so that the devices find the rate of the lone manager first.
    let config = NodeConfig { power_up: Some(at(0)), ..NodeConfig::named("script") };
    plant.network.add_silent(config, Replay::new(frames));
    plant.run(START + 1000);
    let answers = plant.trace.iter().filter(|(end, id)| *end > at(0) && id.starts_with("1FFE"));
    // The Mini-who has such an identifier too.
    assert_eq!(answers.count(), 1 + 126);
    for &device in &devices {
        assert_eq!((plant.access(device).counters().mini_whos, plant.kind(device)), (1, StateKind::Standby));
    }
    plant.run(START + 5000);
    assert!(plant.access(manager).is_online());
    for (&device, address) in devices.iter().zip(addresses()) {
        assert!(plant.access(device).is_online(), "{address}");
        assert_eq!(plant.access(device).address(), address);
        assert_eq!(plant.access(device).counters().roams, 1);
    }
    assert_eq!(plant.spoilt_since(at(0)), 0);
}

/// A manager and devices in Standby.
fn standing_by(serials: &[u32]) -> (Plant, Vec<NodeId>) {
    let mut plant = Plant::new();
    plant.manager(1, 1, 0);
    let devices = serials.iter().map(|&serial| plant.device(serial, 0)).collect();
    plant.run(START);
    for &device in &devices {
        assert_eq!(plant.kind(device), StateKind::Standby);
    }
    (plant, devices)
}

/// At the same moment, and with every distance up to more than both waits.
#[test]
fn of_two_with_one_address_exactly_one_gets_on_line() {
    for distance in [0, 1, 2, 300, 700, 999, 1001, 1500, 1900, 2100, 2600] {
        for swapped in [false, true] {
            let (mut plant, mut pair) = standing_by(&[0x0A0B, 0x0A0C]);
            if swapped {
                pair.swap(0, 1);
            }
            plant.give_address(pair[0], 67);
            plant.run(START + distance);
            plant.give_address(pair[1], 67);
            plant.run(START + 8000);
            let kinds = [plant.kind(pair[0]), plant.kind(pair[1])];
            // Who came first is on line two seconds later; before that, the lower identity wins.
            let first_wins = distance > 2000 || !swapped;
            let expected = if first_wins {
                [StateKind::Online, StateKind::Standby]
            } else {
                [StateKind::Standby, StateKind::Online]
            };
            assert_eq!(kinds, expected, "{distance} ms apart, swapped: {swapped}");
        }
    }
}

/// Two that join at once compare their identities; neither may drive away the third, which has the address.
#[test]
fn a_node_on_line_keeps_its_address_against_two_that_join_at_once() {
    let (mut plant, devices) = standing_by(&[0x0A0C, 0x0A0B, 0x0A0D]);
    plant.give_address(devices[0], 67);
    plant.run(START + 3000);
    plant.give_address(devices[1], 67);
    plant.give_address(devices[2], 67);
    plant.run(START + 8000);
    let kinds = [plant.kind(devices[0]), plant.kind(devices[1]), plant.kind(devices[2])];
    assert_eq!(kinds, [StateKind::Online, StateKind::Standby, StateKind::Standby]);
    assert_eq!(plant.access(devices[0]).counters().addresses_lost, 0);
}

/// Two segments with a node of the same address each. When they are joined, the first that tells its address keeps it.
#[test]
fn joined_segments_are_left_with_one_owner_of_the_address() {
    let (mut plant, devices) = standing_by(&[0x0A0B, 0x0A0C, 0x0A0D, 0x0A0E]);
    let there = vec![devices[2], devices[3]];
    plant.network.schedule(Instant::from_millis(START), Change::Split(there));
    plant.run(START + 1);
    plant.give_address(devices[0], 67);
    plant.give_address(devices[2], 67);
    plant.run(START + 3000);
    for owner in [devices[0], devices[2]] {
        assert_eq!(plant.kind(owner), StateKind::Online);
    }
    plant.network.schedule(Instant::from_millis(START + 3500), Change::Join);
    plant.run(START + 16_000);
    let on_line = [devices[0], devices[2]].iter().filter(|&&node| plant.access(node).is_online()).count();
    assert_eq!(on_line, 1);
    assert!([devices[0], devices[2]].iter().any(|&node| plant.kind(node) == StateKind::Standby));
}

/// The paper's own limit: two bytes of the serial number tell one device without an address from another. Two that share
/// them do collide; the chance is 1 in 65536 for a pair of unrelated devices.
#[test]
fn devices_that_share_half_a_serial_number_collide() {
    let spoilt = |serials: [u32; 2]| {
        let mut plant = Plant::new();
        plant.manager(1, 1, 0);
        let pair = serials.map(|serial| plant.device(serial, 0));
        plant.run(10_000);
        let tec = pair.map(|node| plant.network.counters(node).tec);
        (plant.spoilt.len(), tec)
    };
    let (lone_attempts, tec) = spoilt([0x0001_7777, 0x0002_7778]);
    assert_eq!(tec, [0, 0]);
    let (with_collisions, tec) = spoilt([0x0001_7777, 0x0002_7777]);
    assert!(with_collisions > lone_attempts, "{with_collisions} and {lone_attempts}");
    assert!(tec.iter().all(|&tec| tec > 0), "{tec:?}");
}

/// The serial number of the first of many.
const FIRST: u32 = 0x0102_0300;
/// By then the devices know the rate, and stand by.
const START: u64 = 10_000;
