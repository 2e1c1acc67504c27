//! Connections that are there before the manager: compared with the plan, told where they differ, made what they should be.

use std::string::String;
use std::vec::Vec;

use super::bus::*;
use crate::id::Direction;
use crate::manager::{DatabaseError, DeviceState, Manager, PlannedConnection};
use crate::message::{IdentifierLength, Predefined, Production};

/// 67 runs, 5 has just announced itself.
fn with_consumer(connection: PlannedConnection) -> Bus {
    let mut five = consumer(0);
    five.connections[0] = connection;
    let mut bus = Bus::on_line(config(), [producer(), five]);
    bus.wait_on_the_bus(1500);
    bus.hello(67, Direction::Response, PLANNED);
    answers(&mut bus, 67, &[("0E 05 07 01", "94 05 FF"), ("4B C0 07 00 64 00 00", "4B C0 00 64 00")]);
    bus.is(67, DeviceState::Running);
    bus.hello(5, Direction::Response, CONSUMER);
    bus.tells();
    bus
}

fn multicast(rate: u16) -> PlannedConnection {
    consumer(rate).connections[0]
}

fn dynamic(rate: u16) -> PlannedConnection {
    PlannedConnection { instance: None, ..multicast(rate) }
}

/// A node answers as long as there is something for it to answer; the requests, in their order.
#[track_caller]
fn answers(bus: &mut Bus, node: u8, script: &[(&str, &str)]) -> Vec<String> {
    let mut asked = Vec::new();
    let mut sent = bus.acknowledges();
    while !sent.is_empty() {
        for frame in core::mem::take(&mut sent) {
            let to_node = std::format!("{:02X}02", node << 1);
            if frame[2..6] != to_node {
                continue;
            }
            let request = frame.split("] ").last().unwrap_or_default();
            asked.push(request.into());
            let Some((_, answer)) = script.iter().find(|(asked, _)| *asked == request) else { continue };
            bus.hears(&std::format!("{}03{:02X}{}: {answer}", &frame[..2], node << 1, &frame[6..8]));
        }
        sent = bus.acknowledges();
    }
    asked
}

const OPENS: (&str, &str) = ("4B D6 01 00 C4 09 01", "4B D6 00 C4 09");

/// Another packet rate, another watchdog action: both are told, and set.
#[test]
fn what_differs_is_told_and_set() {
    let mut bus = with_consumer(multicast(500));
    let asked = answers(
        &mut bus,
        5,
        &[
            ("0E 05 0D 01", "8E 03"),
            ("0E 05 0D 05", "8E 07 00 86 80"),
            ("0E 05 0D 0C", "8E 01"),
            ("0E 05 0D 09", "8E 64 00"),
            OPENS,
            ("10 05 0D 0C 00", "90"),
            ("10 05 0D 09 F4 01", "90 F4 01"),
        ],
    );
    assert_eq!(asked.last().map(String::as_str), Some("10 05 0D 09 F4 01"), "{asked:#?}");
    let told = bus.tells();
    assert_eq!(
        told[..2],
        [
            "OA 5: connection 13 is not as planned: watchdog action Auto delete, planned Transition to timed out",
            "OA 5: connection 13 is not as planned: packet rate 100 ms, planned 500 ms",
        ]
    );
    bus.is(5, DeviceState::Running);
}

/// A device that measures in steps of 10 ms keeps 510 for 505: that is as planned when it is looked at again.
#[test]
fn what_a_device_keeps_of_the_plan_is_no_difference() {
    let mut bus = with_consumer(multicast(505));
    answers(
        &mut bus,
        5,
        &[
            ("0E 05 0D 01", "94 05 FF"),
            OPENS,
            ("4B C0 0D 00 F9 01 00", "4B C0 00 FE 01"),
            ("10 05 0D 05 07 00 86 80", "90"),
        ],
    );
    bus.is(5, DeviceState::Running);
    bus.tells();
    // It announces that it is on line: nothing. It does not answer for a while: its connection is looked at.
    bus.wait_on_the_bus(1500);
    bus.is(5, DeviceState::Retrying);
    let kept = [
        ("0E 05 0D 01", "8E 03"),
        ("0E 05 0D 05", "8E 07 00 86 80"),
        ("0E 05 0D 0C", "8E 00"),
        ("0E 05 0D 09", "8E FE 01"),
        ("0E 03 01 01", "8E 05"),
    ];
    let asked = answers(&mut bus, 5, &kept);
    bus.wait(500);
    let asked = [asked, answers(&mut bus, 5, &kept)].concat();
    bus.is(5, DeviceState::Running);
    assert!(asked.iter().all(|request| request.starts_with("0E")), "{asked:#?}");
    assert!(!bus.tells().iter().any(|line| line.contains("not as planned")));
}

/// Its number is not known: of the connections of the device the one is taken that consumes what is planned.
#[test]
fn a_dynamic_connection_is_found_again() {
    let mut bus = with_consumer(dynamic(0));
    let asked = answers(
        &mut bus,
        5,
        &[
            ("0E 03 01 05", "8E 04 01 80 81 0D"),
            ("0E 05 80 01", "8E 03"),
            ("0E 05 80 05", "8E 09 00 86 80"),
            ("0E 05 81 01", "8E 03"),
            ("0E 05 81 05", "8E 07 00 86 80"),
            ("0E 05 81 09", "8E 00 00"),
        ],
    );
    assert!(asked.iter().all(|request| request.starts_with("0E")), "{asked:#?}");
    bus.is(5, DeviceState::Running);
    assert!(bus.tells().contains(&"OA 5: connection 129 established, 0 ms".into()));
}

/// What is established takes no other producer: it is deleted, and made anew.
#[test]
fn a_dynamic_consumer_is_made_anew_when_its_producer_changes() {
    let mut bus = with_consumer(dynamic(0));
    answers(
        &mut bus,
        5,
        &[
            ("0E 03 01 05", "8E 01 80"),
            ("0E 05 80 01", "8E 03"),
            ("0E 05 80 05", "8E 07 00 86 80"),
            ("0E 05 80 09", "8E 00 00"),
        ],
    );
    bus.is(5, DeviceState::Running);
    // The producer is another one, which has taken another Message ID.
    bus.hello(67, Direction::Response, SPARE);
    let grants = [("0E 05 07 01", "94 05 FF"), ("4B C0 07 00 64 00 00", "4B C3 00 64 00")];
    answers(&mut bus, 67, &grants);
    let mut asked = Vec::new();
    let script = [
        OPENS,
        ("09 05 80", "89"),
        ("4B 40", "4B 40 00 81 00"),
        ("10 05 81 05 07 00 86 83", "90"),
        ("10 05 81 0C 00", "90"),
        ("10 05 81 09 00 00", "90 00 00"),
    ];
    for _ in 0..9 {
        bus.hears("03860007: 00 00");
        asked.extend(answers(&mut bus, 5, &script));
        bus.wait(100);
    }
    let deleted = asked.iter().position(|request| request == "09 05 80");
    let asked_for = asked.iter().position(|request| request == "4B 40");
    assert!(deleted.is_some() && deleted < asked_for, "{asked:#?}");
    bus.is(5, DeviceState::Running);
}

/// It produces with another Message ID than planned: told, and left so.
#[test]
fn another_identifier_is_told_and_left() {
    let mut bus = Bus::on_line(config(), [producer()]);
    bus.identifies(PLANNED);
    bus.tells();
    bus.answers_get(&[3]);
    bus.answers_get(&0x8386_0007_u32.to_le_bytes());
    bus.answers_get(&[100, 0]);
    bus.is(67, DeviceState::Running);
    let told = bus.tells();
    assert_eq!(told[0], "OA 67: connection 7 is not as planned: produces on 03860007, planned 00860007");
}

#[test]
fn a_plan_that_cannot_be_made_is_refused() {
    let add = |plan| Manager::<4, 4>::new(config()).add_device(link_core::Instant::ZERO, plan);
    let message = |last: u8| Err(DatabaseError::Message { connection: 0, message: last + 1, last });
    let standard = |production, message| {
        let mut plan = producer();
        plan.connections[0].instance = Some(Predefined::Implicit(production, IdentifierLength::Standard));
        plan.connections[0].message = crate::id::MessageId::from_low_bits(message);
        plan
    };
    assert_eq!(add(standard(Production::Cyclic, 8)), message(7));
    assert_eq!(add(standard(Production::Broadcast, 4)), message(3));
    for attribute in [(0x100, 1, 1), (1, 0x100, 1), (1, 1, 0x100)] {
        let (class, instance, attribute) = attribute;
        let read = crate::manager::Attribute {
            class: cip_core::code::ClassId(class),
            instance: cip_core::code::InstanceId(instance),
            attribute: cip_core::code::AttributeId(attribute),
        };
        let mut plan = producer();
        plan.reads.push(read).unwrap();
        assert_eq!(add(plan), Err(DatabaseError::Read(read)));
    }
    assert_eq!(add(standard(Production::Broadcast, 3)), Ok(()));
}

/// As in `devicenet simulate`, and a small one. The most of it is what it keeps of each device.
#[test]
fn the_size_of_a_manager_is_known() {
    let none = size_of::<Manager<0, 0>>();
    let device = size_of::<Manager<1, 0>>() - none;
    let connection = size_of::<Manager<1, 1>>() - none - device;
    assert_eq!((none, device, connection), (4768, 544, 64));
}
