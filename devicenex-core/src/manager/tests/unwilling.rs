//! Devices that do not take their address, and others that have it: told, passed over, looked at again.

use std::string::String;
use std::vec::Vec;

use super::bus::*;
use crate::id::Direction;
use crate::manager::{Config, DeviceState, IdentityPattern, PlannedDevice};
use crate::message::DeviceIdentity;

/// Time passes; these answer every Mini-who, in this order, and otherwise do nothing.
fn answer_only(bus: &mut Bus, millis: u64, who: &[DeviceIdentity]) -> Vec<String> {
    let mut sent = Vec::new();
    for _ in 0..millis / 50 {
        for frame in bus.wait_on_the_bus(50) {
            if frame == "1FFE0001 [8] remote" {
                who.iter().for_each(|device| bus.hello(127, Direction::Request, *device));
            }
            sent.push(frame);
        }
    }
    sent
}

fn roams(sent: &[String], low: &str) -> usize {
    sent.iter().filter(|frame| frame.starts_with(&std::format!("1EFE{low}"))).count()
}

/// It answers first every time, and takes no address. The spare has its turn when that shows, not after fifteen seconds.
#[test]
fn a_device_that_never_obeys_does_not_keep_the_spare_from_its_role() {
    let mut bus = Bus::missing();
    bus.tells();
    let sent = answer_only(&mut bus, 6000, &[PLANNED, SPARE]);
    assert_eq!((roams(&sent, "4433"), roams(&sent, "4533") > 0), (3, true), "{sent:#?}");
    let told = bus.tells();
    let device = "vendor 4660, product 7, revision 1, serial 0x11223344";
    assert!(told.contains(&std::format!("OA 67: does not take the address: {device}")), "{told:#?}");
    assert!(told.iter().any(|line| line == "OA 67: Missing -> Lost: not taken"), "{told:#?}");
    bus.hello(67, Direction::Request, SPARE);
    bus.wait_on_the_bus(2020);
    bus.is(67, DeviceState::Connecting);
}

/// Of two devices of one product the other one gets the address.
#[test]
fn a_device_that_never_obeys_is_passed_over() {
    let mut bus = Bus::on_line(config(), [PlannedDevice::new(oa(67), IdentityPattern::product_of(PLANNED))]);
    let sent = answer_only(&mut bus, 8000, &[PLANNED, SPARE]);
    assert_eq!((roams(&sent, "4433"), roams(&sent, "4533")), (3, 3), "{sent:#?}");
}

/// Alone it has another chance, after ten seconds; and when nobody else is there, that is told.
#[test]
fn a_device_that_never_obeys_is_tried_again() {
    let mut bus = Bus::missing();
    bus.tells();
    let sent = answer_only(&mut bus, 9000, &[PLANNED]);
    assert_eq!(roams(&sent, "4433"), 3);
    assert!(bus.tells().contains(&"OA 67: nobody can stand in".into()));
    assert!(roams(&answer_only(&mut bus, 6000, &[PLANNED]), "4433") > 0);
}

/// It takes the address each time, and gives it up at once.
#[test]
fn a_device_that_does_not_keep_its_address_does_not_take_it() {
    let mut bus = Bus::missing();
    let mut roams = 0;
    for _ in 0..60 {
        for frame in bus.wait_on_the_bus(100) {
            if frame.starts_with("1EFE4433") {
                roams += 1;
                bus.hello(67, Direction::Request, PLANNED);
                bus.hello(127, Direction::Request, PLANNED);
            } else if frame == "1FFE0001 [8] remote" {
                bus.hello(127, Direction::Request, PLANNED);
            }
        }
    }
    assert_eq!(roams, 3);
    assert!(bus.tells().iter().any(|line| line.starts_with("OA 67: does not take the address")));
}

/// Somebody else has the address for good: told once, and looked at after 10, 20, 40, 40 seconds.
#[test]
fn a_conflict_that_lasts_is_told_once() {
    let mut bus = Bus::probing();
    bus.identifies(STRANGER);
    bus.tells();
    let mut looked = Vec::new();
    for second in 1..=111 {
        for frame in bus.wait_on_the_bus(1000) {
            if frame.starts_with("1C8602") && frame.ends_with("0E 01 01 01") {
                looked.push(second);
                bus.identifies_from(&frame, STRANGER);
            }
        }
    }
    assert_eq!(looked, [10, 30, 70, 110]);
    let told = bus.tells();
    assert!(!told.iter().any(|line| line.contains("the address is taken")), "{told:#?}");
    // Another one is news.
    bus.wait(40_000);
    bus.identifies(SPARE_OF_NOBODY);
    assert!(bus.tells().iter().any(|line| line.contains("the address is taken")));
}

const SPARE_OF_NOBODY: DeviceIdentity = DeviceIdentity { serial: 0x77, ..STRANGER };

/// Whoever has the address is missing at another one: it is told that.
#[test]
fn a_conflict_with_a_planned_device_is_resolved() {
    let its_own = PlannedDevice::new(oa(9), IdentityPattern::exact(STRANGER));
    let mut bus = Bus::on_line(config(), [producer(), its_own]);
    bus.wait_on_the_bus(1500);
    bus.is(9, DeviceState::Missing);
    bus.tells();
    bus.hello(67, Direction::Response, STRANGER);
    let told = bus.tells();
    assert!(told.iter().any(|line| line.starts_with("at OA 67 instead of 9")), "{told:#?}");
    let sent = bus.acknowledges();
    let open = sent.iter().find(|frame| frame.starts_with("1D8602")).expect("an explicit connection");
    bus.hears(&std::format!("1D0386{}: 4B D6 00 C4 09", &open[6..8]));
    let sent = bus.acknowledges();
    let set = sent.iter().find(|frame| frame.ends_with("10 03 01 01 09")).expect("another address");
    bus.hears(&std::format!("160386{}: 90", &set[6..8]));
    bus.is(67, DeviceState::Probing);
}

/// 0: once at the start, and when somebody is lost.
#[test]
fn without_an_interval_it_asks_only_when_there_is_a_reason() {
    let asked = |sent: Vec<String>| sent.iter().filter(|frame| *frame == "1FFE0001 [8] remote").count();
    let mut bus = Bus::on_line(Config { mini_who_interval: 0, ..config() }, [producer()]);
    // Nobody has the address; and once more when spares may come in.
    assert_eq!(asked(bus.wait_on_the_bus(10_000)), 1);
    assert_eq!(asked(bus.wait_on_the_bus(60_000)), 1);
}

/// A device that nobody planned is told once for as long as it is there, and its address is free when it is gone.
#[test]
fn a_stranger_that_comes_back_is_told_again() {
    let mut config = config();
    config.node.access.announcement = 10_000;
    let mut bus = Bus::on_line(config, [producer()]);
    bus.wait_on_the_bus(1500);
    let unknown = |bus: &mut Bus| bus.tells().iter().filter(|line| line.starts_with("unknown")).count();
    for told in [1, 0, 0, 0, 0, 0, 0] {
        bus.hello(0, Direction::Response, STRANGER);
        assert_eq!(unknown(&mut bus), told);
        bus.wait_on_the_bus(10_000);
    }
    bus.wait_on_the_bus(60_000);
    bus.hello(0, Direction::Response, STRANGER);
    assert_eq!(unknown(&mut bus), 1);
    // While it is there nobody learns its address; later the lowest is free again.
    bus.manager.set_learning(true);
    bus.hello(127, Direction::Request, SPARE_OF_NOBODY);
    assert!(bus.manager.device(oa(2)).is_some());
    bus.wait_on_the_bus(60_000);
    bus.hello(127, Direction::Request, DeviceIdentity { serial: 0x78, ..STRANGER });
    assert!(bus.manager.device(oa(0)).is_some());
}
