//! Connections: in which order, with what, and what is done when they are lost.

use std::string::String;
use std::vec::Vec;

use super::bus::*;
use crate::id::Direction;
use crate::manager::{DeviceState, PlannedConnection, PlannedDevice};
use crate::message::DeviceIdentity;

/// 67 and 5 are on line; nothing was asked yet.
fn both_on_line(consumer_rate: u16) -> Bus {
    let mut bus = Bus::on_line(config(), [consumer(consumer_rate), producer()]);
    bus.wait_on_the_bus(600);
    bus.hello(5, Direction::Response, DeviceIdentity { product_code: 3, serial: 0xA, ..PLANNED });
    bus
}

/// The answer of 5 to the last request of a class.
#[track_caller]
fn five_answers(bus: &mut Bus, class: &str, data: &str) {
    let sent = bus.acknowledges();
    answer_to(bus, &sent, class, data);
}

#[track_caller]
fn answer_to(bus: &mut Bus, sent: &[String], class: &str, data: &str) {
    let request = sent.iter().rev().find(|frame| frame.starts_with(class)).expect(data);
    let prefix = match class {
        "1C" => "1C030A",
        "1D" => "1D030A",
        _ => "16030A",
    };
    bus.hears(&std::format!("{prefix}{}: {data}", &request[6..8]));
}

/// First the producer, then the consumer: explicit connection, connection 13, and whose data it consumes.
#[test]
fn a_consumer_is_told_the_connection_id_of_its_producer() {
    let mut bus = both_on_line(0);
    // Its connection is not there, and what it shall consume is not there either.
    five_answers(&mut bus, "1C", "94 05 FF");
    bus.sends(&[]);
    bus.hello(67, Direction::Response, PLANNED);
    let looked = bus.acknowledges();
    assert!(looked.iter().any(|frame| frame == "1C860201 [4] 0E 05 07 01"), "{looked:?}");
    bus.hears("1C038601: 94 05 FF");
    bus.answers_connection();
    bus.is(67, DeviceState::Running);
    // The explicit connection of 5: Message ID 6, 2500 ms, deleted when it is not used.
    let sent = bus.acknowledges();
    assert!(sent[0].starts_with("1D0A02") && sent[0].ends_with("[7] 4B D6 01 00 C4 09 01"), "{sent:?}");
    answer_to(&mut bus, &sent, "1D", "4B D6 00 C4 09");
    let sent = bus.acknowledges();
    assert!(sent[0].ends_with("[7] 4B C0 0D 00 00 00 00"), "{sent:?}");
    answer_to(&mut bus, &sent, "1D", "4B C0 00 00 00");
    let sent = bus.acknowledges();
    // Set_Attribute_Single, Connection 13, attribute 5: 0x80860007.
    assert!(sent[0].starts_with("160A02") && sent[0].ends_with("[8] 10 05 0D 05 07 00 86 80"), "{sent:?}");
    answer_to(&mut bus, &sent, "16", "90");
    bus.is(5, DeviceState::Running);
}

/// What is there already is read, and left as it is; what consumes something else is told anew.
#[test]
fn a_consumer_that_is_there_is_left_alone() {
    for (consumes, left_alone) in [("07 00 86 80", true), ("09 00 86 80", false)] {
        let mut bus = Bus::on_line(config(), [consumer(0), producer()]);
        let sent = bus.acknowledges();
        assert_eq!(sent.len(), 2);
        answer_to(&mut bus, &sent, "1C0A", "8E");
        // 5 cannot be identified so: let it announce itself instead.
        bus.hello(67, Direction::Response, PLANNED);
        bus.hello(5, Direction::Response, DeviceIdentity { product_code: 3, serial: 0xA, ..PLANNED });
        let mut sent = bus.acknowledges();
        let mut changed = Vec::new();
        while !sent.is_empty() {
            for frame in core::mem::take(&mut sent) {
                let transaction = &frame[6..8];
                let value = match frame.split("] ").last().unwrap() {
                    "0E 05 07 01" | "0E 05 0D 01" => "03",
                    "0E 05 07 04" => "07 00 86 80",
                    "0E 05 07 09" => "64 00",
                    "0E 05 0D 05" => consumes,
                    "0E 05 0D 09" => "00 00",
                    _ => {
                        changed.push(frame.clone());
                        continue;
                    }
                };
                let from = if frame.starts_with("1C86") { "1C0386" } else { "1C030A" };
                bus.hears(&std::format!("{from}{transaction}: 8E {value}"));
            }
            sent = bus.acknowledges();
        }
        bus.is(67, DeviceState::Running);
        assert_eq!(changed.is_empty(), left_alone, "{changed:?}");
        bus.is(5, if left_alone { DeviceState::Running } else { DeviceState::Connecting });
    }
}

/// Data keep it alive; four packet rates without any do not.
#[test]
fn a_producer_that_falls_silent_is_asked_twice_and_then_lost() {
    let mut bus = Bus::running();
    for _ in 0..50 {
        bus.hears("00860007: 12 34");
        bus.wait(390);
        bus.acknowledges();
    }
    bus.is(67, DeviceState::Running);
    bus.tells();
    bus.wait(9);
    bus.is(67, DeviceState::Running);
    bus.wait(1);
    bus.is(67, DeviceState::Retrying);
    let sent = bus.wait_on_the_bus(999);
    assert_eq!(sent.iter().filter(|frame| frame.starts_with("1D8602")).count(), 2);
    bus.wait_on_the_bus(1);
    bus.is(67, DeviceState::Lost);
    let told = bus.tells();
    assert_eq!(told[0], "OA 67: connection 7 timed out");
    assert_eq!(told[3], "OA 67: lost: vendor 4660, product 7, revision 1, serial 0x11223344");
    // The spare is asked for at once, and gets the address.
    let now = bus.now;
    bus.hello(127, Direction::Request, SPARE);
    let sent = bus.acknowledges();
    assert_eq!(
        (sent.last().map(String::as_str), bus.now),
        (Some("1EFE4533 [8] 22 11 34 12 07 00 01 43"), now)
    );
}

/// The data of others, and what is not data.
#[test]
fn only_its_own_data_show_that_a_producer_is_there() {
    let mut bus = Bus::running();
    for _ in 0..4 {
        for other in ["00880007: 00", "00860009: 00", "01860007: 00", "00870007: 00"] {
            bus.hears(other);
        }
        bus.wait(250);
    }
    bus.is(67, DeviceState::Retrying);
}

#[test]
fn a_connection_that_is_refused_is_asked_for_again_later() {
    let mut bus = Bus::connecting();
    bus.tells();
    let sent = bus.acknowledges();
    let request = sent.iter().find(|frame| frame.starts_with("1D8602")).unwrap();
    bus.hears(&std::format!("1D0386{}: 94 02 FF", &request[6..8]));
    assert_eq!(bus.tells(), ["OA 67: connection 7 refused: Resource unavailable"]);
    bus.is(67, DeviceState::Connecting);
    let mut asked = 0;
    for _ in 0..11 {
        bus.wait(1000);
        let sent = bus.acknowledges();
        asked += sent.iter().filter(|frame| frame.starts_with("1D8602")).count();
        // It is there all the same: it tells its address.
        if let Some(request) = sent.iter().find(|frame| frame.starts_with("1C8602")) {
            bus.hears(&std::format!("1C0386{}: 8E 43", &request[6..8]));
        }
    }
    assert_eq!(asked, 1);
    bus.is(67, DeviceState::Connecting);
}

/// Another client has the explicit connection of the predefined set: a dynamic one is asked for, with two bytes.
#[test]
fn an_explicit_connection_of_its_own() {
    let mut plan = PlannedDevice::new(oa(67), crate::manager::IdentityPattern::exact(PLANNED));
    plan.connections.push(PlannedConnection::change_of_state(500)).unwrap();
    let mut bus = Bus::on_line(config(), [plan]);
    bus.identifies(PLANNED);
    let sent = bus.acknowledges();
    bus.hears(&std::format!("1C0386{}: 94 05 FF", &sent.last().unwrap()[6..8]));
    let transaction = |sent: Vec<String>, end: &str| {
        let request = sent.into_iter().find(|frame| frame.starts_with("1")).unwrap();
        assert!(request.ends_with(end), "{request}");
        request[6..8].to_owned()
    };
    let first = transaction(bus.acknowledges(), "4B D6 01 00 C4 09 01");
    bus.hears(&std::format!("1D0386{first}: 94 0C FF"));
    let second = transaction(bus.acknowledges(), "[2] 4B 56");
    bus.hears(&std::format!("1D0386{second}: 4B 56 00 80 00"));
    // Change of state with 29 bits, instance 9, and then attribute 3: no acknowledges.
    let third = transaction(bus.acknowledges(), "4B C0 09 00 F4 01 00");
    bus.hears(&std::format!("1D0386{third}: 4B C0 00 F4 01"));
    let fourth = transaction(bus.acknowledges(), "[5] 10 05 09 03 10");
    bus.hears(&std::format!("160386{fourth}: 90"));
    bus.is(67, DeviceState::Running);
}

use std::borrow::ToOwned;
