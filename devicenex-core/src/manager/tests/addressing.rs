//! From nobody to a device with its address: what is sent, when, and what is told.

use super::bus::*;
use crate::id::Direction;
use crate::manager::{Config, DeviceState, IdentityPattern, PlannedDevice};
use crate::message::DeviceIdentity;

/// The Mini-who of this manager: `11111 1111111 0`, and its serial number's low byte first.
const MINI_WHO: &str = "1FFE0001 [8] remote";

/// The example of section 5, for one device: Mini-who, Hello, ROAM, two Hellos, connection request.
#[test]
fn a_device_gets_its_address_and_its_connection() {
    let mut bus = Bus::on_line(config(), [producer()]);
    bus.sends(&["1C860200 [4] 0E 01 01 01"]);
    bus.tells();
    bus.wait(500);
    assert_eq!(bus.tells(), ["OA 67: Probing -> Missing: no response"]);
    bus.sends(&[MINI_WHO]);
    // It stands by: it answers. The ROAM names it, and the address.
    bus.hello(127, Direction::Request, PLANNED);
    bus.sends(&["1EFE4433 [8] 22 11 34 12 07 00 01 43"]);
    bus.hello(67, Direction::Request, PLANNED);
    bus.wait(1000);
    bus.hello(67, Direction::Request, PLANNED);
    bus.wait(1019);
    assert_eq!(bus.acknowledges().iter().filter(|frame| frame.starts_with("1D")).count(), 0);
    bus.wait(1);
    // Multicast producer, 100 ms, Message ID 0, group 4.
    bus.sends(&["1D860201 [7] 4B C0 07 00 64 00 00"]);
    bus.hears("1D038601: 4B C0 00 64 00");
    let device = "vendor 4660, product 7, revision 1, serial 0x11223344";
    assert_eq!(
        bus.tells(),
        [
            "OA 67: Missing -> Found: Hello without address".to_owned(),
            std::format!("OA 67: found: {device}"),
            "OA 67: Found -> Assigned: ROAM sent".to_owned(),
            "OA 67: Assigned -> Joining: Hello request".to_owned(),
            "OA 67: Joining -> Connecting: wait over".to_owned(),
            std::format!("OA 67: on line: {device}"),
            "OA 67: connection 7 established, 100 ms, produces on 00860007".to_owned(),
            "OA 67: Connecting -> Running: connected".to_owned(),
        ]
    );
}

/// A device that joins would refuse a ROAM: it is waited for, from its last Hello on.
#[test]
fn a_device_that_joins_is_sent_its_address_when_it_stands_by() {
    let mut bus = Bus::missing();
    bus.hello(127, Direction::Request, PLANNED);
    bus.wait(500);
    bus.hello(127, Direction::Request, PLANNED);
    bus.acknowledges();
    bus.wait(1019);
    assert!(!bus.acknowledges().iter().any(|frame| frame.starts_with("1E")));
    bus.wait(1);
    assert!(bus.acknowledges().iter().any(|frame| frame.starts_with("1EFE4433")));
    // One that obeys at once is not waited for.
    let mut bus = Bus::on_line(Config { early_roam: true, ..config() }, [producer()]);
    bus.wait_on_the_bus(1500);
    bus.hello(127, Direction::Request, PLANNED);
    bus.sends(&["1EFE4433 [8] 22 11 34 12 07 00 01 43"]);
}

#[test]
fn a_roam_is_sent_three_times() {
    let mut bus = Bus::missing();
    bus.tells();
    bus.hello(127, Direction::Request, PLANNED);
    let sent = bus.wait_on_the_bus(1020 + 3 * 500);
    assert_eq!(sent.iter().filter(|frame| frame.starts_with("1EFE4433")).count(), 3);
    bus.is(67, DeviceState::Missing);
    let told = bus.tells();
    assert!(told.iter().any(|line| line.starts_with("OA 67: does not take the address")), "{told:#?}");
    assert_eq!(bus.manager.counters().roams, 3);
}

/// Every two seconds while somebody is missing, every ten when nobody is.
#[test]
fn how_often_it_asks() {
    let mut bus = Bus::missing();
    let asked = |sent: &[String]| sent.iter().filter(|frame| *frame == MINI_WHO).count();
    assert_eq!(asked(&bus.wait_on_the_bus(10_000)), 5);
    let mut bus = Bus::adopted(0);
    let mut sent = Vec::new();
    for _ in 0..30 {
        bus.wait(1000);
        sent.extend(bus.acknowledges());
        let request = sent.iter().rev().find(|frame| frame.starts_with("1C86")).unwrap().clone();
        bus.hears(&std::format!("1C0386{}: 8E 03", &request[6..8]));
    }
    bus.is(67, DeviceState::Running);
    assert_eq!(asked(&sent), 3);
    // Or never.
    let mut bus = Bus::on_line(Config { idle_mini_who_interval: 0, ..config() }, []);
    assert_eq!(asked(&bus.wait_on_the_bus(60_000)), 0);
}

/// A spare of a role that is filled, and a device that nobody planned: told once, and left alone.
#[test]
fn who_has_no_place_stands_by() {
    let mut bus = Bus::adopted(100);
    bus.tells();
    for _ in 0..3 {
        bus.hello(127, Direction::Request, SPARE);
        bus.hello(127, Direction::Request, STRANGER);
    }
    assert_eq!(
        bus.tells(),
        [
            "spare stands by: vendor 4660, product 7, revision 1, serial 0x11223345",
            "unknown device without an address: vendor 4660, product 8, revision 1, serial 0x11223346",
        ]
    );
    assert_eq!(bus.manager.standing_by().count(), 2);
    // One of them is unplugged, and does not answer any more.
    for _ in 0..300 {
        bus.wait(50);
        for frame in bus.acknowledges() {
            if frame == MINI_WHO {
                bus.hello(127, Direction::Request, STRANGER);
            }
        }
        bus.hears("00860007: 00 00");
    }
    assert_eq!(bus.tells(), ["no longer stands by: vendor 4660, product 7, revision 1, serial 0x11223345"]);
}

/// A device that leaves its address is not unknown; neither is one with a cloned identity. Told once for each address.
#[test]
fn a_planned_device_at_another_address_is_misplaced() {
    let mut bus = Bus::adopted(0);
    bus.tells();
    for direction in [Direction::Request, Direction::Request, Direction::Response] {
        bus.hello(9, direction, PLANNED);
    }
    assert_eq!(bus.tells(), ["at OA 9 instead of 67: vendor 4660, product 7, revision 1, serial 0x11223344"]);
    bus.is(67, DeviceState::Running);
    assert!(bus.acknowledges().iter().all(|frame| !frame.starts_with("1D")), "it is not missing");
}

/// Of roles for a product, a device gets the one that it had; then the one that is for it alone; then the first.
#[test]
fn a_device_gets_the_place_that_fits_it_best() {
    let another = DeviceIdentity { serial: 0x55, ..PLANNED };
    let any = |address| PlannedDevice::new(oa(address), IdentityPattern::product_of(PLANNED));
    let exact = PlannedDevice::new(oa(30), IdentityPattern::exact(PLANNED));
    let mut bus = Bus::on_line(config(), [any(20), any(21), exact]);
    bus.wait_on_the_bus(800);
    for (device, address) in [(PLANNED, 30), (another, 20), (SPARE, 21)] {
        bus.hello(127, Direction::Request, device);
        assert_eq!(bus.manager.device(oa(address)).unwrap().device, Some(device));
    }
    bus.acknowledges();
    // It restarts.
    bus.hello(21, Direction::Request, SPARE);
    bus.hello(127, Direction::Request, SPARE);
    assert_eq!(bus.manager.device(oa(21)).unwrap().state, DeviceState::Found);
}

#[test]
fn learning() {
    let mut bus = Bus::on_line(Config { learning: true, ..config() }, [producer()]);
    bus.wait_on_the_bus(1200);
    bus.tells();
    // Without an address: the lowest that is free. 0 is; 1 is the manager's.
    bus.hello(127, Direction::Request, STRANGER);
    let another = DeviceIdentity { serial: 0x99, ..STRANGER };
    bus.hello(40, Direction::Response, another);
    let told = bus.tells();
    assert!(
        told.contains(&"OA 0: learned: vendor 4660, product 8, revision 1, serial 0x11223346".to_owned())
    );
    assert!(
        told.contains(&"OA 40: learned: vendor 4660, product 8, revision 1, serial 0x00000099".to_owned())
    );
    bus.is(0, DeviceState::Found);
    assert_eq!(bus.manager.devices().count(), 3);
    // The database has room for one more.
    bus.hello(41, Direction::Response, DeviceIdentity { serial: 0x9A, ..STRANGER });
    bus.tells();
    bus.hello(42, Direction::Response, DeviceIdentity { serial: 0x9B, ..STRANGER });
    assert_eq!(
        bus.tells(),
        ["unknown device at OA 42: vendor 4660, product 8, revision 1, serial 0x0000009B"]
    );
}

#[test]
fn a_stranger_at_a_planned_address_is_told_and_looked_at_again() {
    let mut bus = Bus::probing();
    bus.tells();
    bus.identifies(STRANGER);
    bus.is(67, DeviceState::Conflict);
    let told = bus.tells();
    assert_eq!(
        told[1],
        "OA 67: the address is taken by vendor 4660, product 8, revision 1, serial 0x11223346"
    );
    // Its own device is not sent into that.
    bus.hello(127, Direction::Request, PLANNED);
    bus.wait(10_000);
    bus.is(67, DeviceState::Probing);
}

#[test]
fn frames_that_cannot_be_read_are_told() {
    let mut bus = Bus::missing();
    bus.tells();
    bus.hears("1FFE4433: 22 11");
    bus.hears("1EFE4433: 22 11 34 12 07 00 01 C3");
    let told = bus.tells();
    assert_eq!(told.len(), 2);
    assert!(told.iter().all(|line| line.starts_with("bad frame")), "{told:#?}");
    assert_eq!(bus.manager.counters().bad_frames, 2);
}

use std::borrow::ToOwned;
use std::string::String;
use std::vec::Vec;
