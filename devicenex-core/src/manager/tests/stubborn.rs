//! Devices that answer wrongly, late or not at all, and producers that change while their consumers are set up: the
//! manager gets on, and never asks without a pause.

use std::string::{String, ToString};
use std::vec::Vec;

use link_core::{Input, TxOutcome};

use super::bus::*;
use crate::id::Direction;
use crate::manager::{
    DeviceState, IdentityPattern, ManagerEvent, PlannedConnection, PlannedDevice, PlannedEvent,
};

/// Answers the request that was sent last to the node: `class` are the first two digits of the identifier.
#[track_caller]
fn answers(bus: &mut Bus, sent: &[String], class: &str, node: u8, data: &str) {
    let to = std::format!("{class}{:02X}02", node << 1);
    let request =
        sent.iter().rev().find(|frame| frame.starts_with(&to)).unwrap_or_else(|| panic!("{sent:?}"));
    bus.hears(&std::format!("{class}03{:02X}{}: {data}", node << 1, &request[6..8]));
}

/// Answers the request that it sends next to the node, and returns what it sent.
#[track_caller]
fn answers_next(bus: &mut Bus, class: &str, node: u8, data: &str) -> Vec<String> {
    let sent = bus.acknowledges();
    answers(bus, &sent, class, node, data);
    sent
}

fn asked(sent: &[String], start: &str) -> usize {
    sent.iter().filter(|frame| frame.starts_with(start)).count()
}

/// A response without P to a request with it is not one that can be read: the device is there, and asked again after ten
/// seconds, not at once.
#[test]
fn an_answer_that_cannot_be_read_is_no_reason_to_ask_at_once() {
    let mut bus = Bus::retrying();
    answers_next(&mut bus, "1D", 67, "4B 40 00 64 00");
    bus.is(67, DeviceState::Connecting);
    assert_eq!(asked(&bus.acknowledges(), "1D8602"), 0);
    assert_eq!(bus.manager.counters().refused, 1);
}

/// The same while it is only asked whether it is there: a response that is too long for the manager.
#[test]
fn an_answer_that_is_too_long_says_that_the_device_is_there() {
    let mut plan = PlannedDevice::new(oa(67), IdentityPattern::exact(PLANNED));
    plan.connections.push(PlannedConnection { trigger: None, ..PlannedConnection::producer(0) }).unwrap();
    let mut bus = Bus::on_line(config(), [plan]);
    bus.identifies(PLANNED);
    bus.answers_get(&[3]);
    bus.answers_get(&0x8086_0007_u32.to_le_bytes());
    bus.answers_get(&[0, 0]);
    bus.is(67, DeviceState::Running);
    bus.wait_on_the_bus(1000);
    bus.wait(500);
    bus.is(67, DeviceState::Retrying);
    let sent = bus.acknowledges();
    let request = sent.iter().rev().find(|frame| frame.starts_with("1C8602")).unwrap();
    let transaction = &request[6..8];
    bus.hears(&std::format!("1C038700: {transaction} 8E 01 02 03 04 05 06"));
    for count in 1..3 {
        bus.acknowledges();
        bus.hears(&std::format!("1C0387{:02X}: 01 02 03 04 05 06 07 08", 0x40 + count));
    }
    bus.is(67, DeviceState::Connecting);
}

/// A device that measures in seconds takes 1000 ms for 100: four of those are to be waited for.
#[test]
fn a_dynamic_producer_is_watched_at_the_rate_that_it_keeps() {
    let mut plan = PlannedDevice::new(oa(67), IdentityPattern::exact(PLANNED));
    plan.connections.push(PlannedConnection { instance: None, ..PlannedConnection::producer(100) }).unwrap();
    let mut bus = Bus::on_line(config(), [plan]);
    bus.identifies(PLANNED);
    bus.answers_get(&[0]);
    answers_next(&mut bus, "1D", 67, "4B D6 00 C4 09");
    answers_next(&mut bus, "1D", 67, "4B 40 00 80 00");
    // Watchdog action, then expected packet rate.
    answers_next(&mut bus, "16", 67, "90");
    let sent = bus.acknowledges();
    assert!(sent[0].ends_with("10 05 80 09 64 00"), "{sent:?}");
    answers(&mut bus, &sent, "16", 67, "90 E8 03");
    bus.is(67, DeviceState::Running);
    let rate = bus.events.iter().find_map(|event| match event {
        ManagerEvent::Planned(_, PlannedEvent::Connected { expected_packet_rate, .. }) => {
            Some(*expected_packet_rate)
        }
        _ => None,
    });
    assert_eq!(rate, Some(1000));
    bus.wait(3990);
    bus.is(67, DeviceState::Running);
    bus.wait(10);
    bus.is(67, DeviceState::Retrying);
}

/// 67 produces dynamically; 5 consumes it on connection 13, and has just been asked to.
fn consumer_is_being_told() -> (Bus, Vec<String>) {
    let mut plan = PlannedDevice::new(oa(67), IdentityPattern::exact(PLANNED));
    plan.spares.push(IdentityPattern::exact(SPARE)).unwrap();
    plan.connections.push(PlannedConnection { instance: None, ..PlannedConnection::producer(0) }).unwrap();
    let mut bus = Bus::on_line(config(), [plan, consumer(0)]);
    bus.acknowledges();
    bus.hello(67, Direction::Response, PLANNED);
    bus.answers_get(&[0]);
    grants_dynamic(&mut bus, "80");
    bus.is(67, DeviceState::Running);
    bus.hello(5, Direction::Response, CONSUMER);
    answers_next(&mut bus, "1C", 5, "94 05 FF");
    answers_next(&mut bus, "1D", 5, "4B D6 00 C4 09");
    answers_next(&mut bus, "1D", 5, "4B C0 00 00 00");
    let sent = bus.acknowledges();
    assert!(sent[0].ends_with("10 05 0D 05 80 00 86 80"), "{sent:?}");
    (bus, sent)
}

/// 67 gets its connection, of that instance.
#[track_caller]
fn grants_dynamic(bus: &mut Bus, instance: &str) {
    answers_next(bus, "1D", 67, "4B D6 00 C4 09");
    answers_next(bus, "1D", 67, &std::format!("4B 40 00 {instance} 00"));
    for response in ["90", "90 00 00"] {
        answers_next(bus, "16", 67, response);
    }
}

#[test]
fn a_consumer_whose_producer_changes_while_it_is_told_is_told_again() {
    let (mut bus, told) = consumer_is_being_told();
    // The spare of 67 is on line, and produces on another instance, before 5 has answered.
    bus.hello(67, Direction::Response, SPARE);
    answers_next(&mut bus, "1C", 67, "94 05 FF");
    grants_dynamic(&mut bus, "81");
    bus.is(67, DeviceState::Running);
    answers(&mut bus, &told, "16", 5, "90");
    let sent = bus.acknowledges();
    assert!(sent[0].ends_with("10 05 0D 05 81 00 86 80"), "{sent:?}");
    answers(&mut bus, &sent, "16", 5, "90");
    bus.is(5, DeviceState::Running);
}

/// Its producer is lost before the consumer can be told: nothing can be made now, and it is seen to that it is there.
#[test]
fn a_consumer_that_waits_for_its_producer_is_watched() {
    let mut bus = Bus::on_line(config(), [producer(), consumer(0)]);
    bus.acknowledges();
    bus.hello(67, Direction::Response, PLANNED);
    answers_next(&mut bus, "1C", 67, "94 05 FF");
    bus.answers_connection();
    bus.hello(5, Direction::Response, CONSUMER);
    answers_next(&mut bus, "1C", 5, "94 05 FF");
    answers_next(&mut bus, "1D", 5, "4B D6 00 C4 09");
    let sent = bus.acknowledges();
    assert!(sent[0].ends_with("4B C0 0D 00 00 00 00"), "{sent:?}");
    bus.hello(67, Direction::Response, STRANGER);
    bus.is(67, DeviceState::Conflict);
    answers(&mut bus, &sent, "1D", 5, "4B C0 00 00 00");
    let sent = bus.wait_on_the_bus(1000);
    assert_eq!(asked(&sent, "1C0A02"), 1, "{sent:?}");
}

/// Settings that nobody answers cost the explicit connection: the next attempt opens one again.
#[test]
fn the_next_attempt_has_an_explicit_connection_of_its_own() {
    let (mut bus, told) = consumer_is_being_told();
    assert_eq!(asked(&told, "160A02"), 1);
    let mut opened = Vec::new();
    let mut set = 0;
    for _ in 0..400 {
        let sent = bus.wait_on_the_bus(100);
        for frame in &sent {
            let transaction = &frame[6..8];
            match frame.split("] ").last().unwrap() {
                "4B D6 01 00 C4 09 01" => {
                    opened.push(bus.now);
                    bus.hears(&std::format!("1D030A{transaction}: 4B D6 00 C4 09"));
                }
                "4B C0 0D 00 00 00 00" => bus.hears(&std::format!("1D030A{transaction}: 4B C0 00 00 00")),
                // It is there.
                "0E 03 01 01" => bus.hears(&std::format!("1C030A{transaction}: 8E 05")),
                "0E 05 0D 01" => bus.hears(&std::format!("1C030A{transaction}: 8E 03")),
                "0E 05 80 01" => bus.hears(&std::format!("1C0386{transaction}: 8E 03")),
                text if text.starts_with("10 05 0D 05") && opened.len() > 1 => {
                    set += 1;
                    bus.hears(&std::format!("16030A{transaction}: 90"));
                }
                _ => {}
            }
        }
    }
    assert_eq!((opened.len(), set), (2, 1), "{opened:?}");
    bus.is(5, DeviceState::Running);
}

/// Of what the controller gives back, requests are counted as well as Mini-whos.
#[test]
fn a_request_that_is_given_back_unsent_is_counted_and_sent_again() {
    let mut bus = Bus::connecting();
    let at = bus.in_flight.iter().position(|(_, frame)| frame.to_string().starts_with("1D8602")).unwrap();
    let (token, _) = bus.in_flight.remove(at);
    let before = bus.manager.counters().not_sent;
    bus.input(Input::TxDone(token, TxOutcome::Unknown));
    assert_eq!(bus.manager.counters().not_sent, before + 1);
    assert_eq!(asked(&bus.wait_on_the_bus(500), "1D8602"), 1);
}

/// A device is restarted, and gone before it has its address again: it was there, so a device that takes its place is told
/// as such.
#[test]
fn a_device_that_does_not_come_back_from_a_restart_is_lost() {
    let mut bus = Bus::running();
    bus.hello(127, Direction::Request, PLANNED);
    bus.wait_on_the_bus(1020 + 3 * 500);
    bus.is(67, DeviceState::Missing);
    bus.tells();
    bus.wait_on_the_bus(15_000);
    bus.is(67, DeviceState::Lost);
    let gone = "OA 67: lost: vendor 4660, product 7, revision 1, serial 0x11223344";
    let told = bus.tells();
    assert!(told.iter().any(|line| line == gone), "{told:#?}");
    assert_eq!(bus.manager.counters().lost, 1);
    bus.hello(127, Direction::Request, SPARE);
    bus.wait_on_the_bus(1100);
    bus.hello(67, Direction::Request, SPARE);
    bus.wait_on_the_bus(2100);
    assert_eq!(bus.manager.counters().replaced, 1);
}
