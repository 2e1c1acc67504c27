//! Connection requests: every answer of the table in `connect`.

use std::string::ToString;

use super::bus::Bus;
use crate::device::{DeviceEvent, Ignored, Offer};

/// What the request is refused with, by a device that has no connections.
fn refusal(bus: &mut Bus, request: &[u8]) -> u8 {
    bus.hears(0x1D86_0209, request);
    let frame = bus.sent.pop_back().expect("an answer");
    assert_eq!(frame.to_string().get(..8), Some("1D038609"));
    let &[0x94, status, 0xFF] = frame.data() else { panic!("{frame}") };
    bus.is_silent();
    let told = bus.events.pop();
    assert!(matches!(told, Some(DeviceEvent::Refused { status: told, .. }) if told.0 == status), "{told:?}");
    assert!(bus.events.is_empty());
    assert_eq!(bus.node.connections().count(), 0, "{request:02X?}");
    status
}

/// The worked example of section 5 of the paper, as far as one device sees it.
#[test]
fn a_producer_is_set_up_by_one_request() {
    let mut bus = Bus::new();
    // P, 29-bit implicit, Message ID 0; instance 7, EPR 500 ms, action 0.
    bus.hears(0x1D86_0209, &[0x4B, 0xC0, 7, 0, 0xF4, 1, 0]);
    bus.sends(0x0086_0007, &[0x34, 0x12]);
    bus.sends(0x1D03_8609, &[0x4B, 0xC0, 0, 0xF4, 1]);
    assert_eq!(bus.told(), ["multicast, producing, 29 bits: Non-existent -> Established: Allocate"]);
    bus.wait(499);
    bus.is_silent();
    bus.wait(1);
    bus.sends(0x0086_0007, &[0x34, 0x12]);
}

#[test]
fn a_consumer_consumes_what_attribute_5_says() {
    let mut bus = Bus::explicit();
    // Instance 13, EPR 0, action 0.
    bus.connects(&[0x4B, 0xC0, 13, 0, 0, 0, 0], &[0x4B, 0xC0, 0, 0, 0]);
    // Until it is told: instance 7 of the requester.
    bus.asks(&[0x0E, 5, 13, 5], &[0x8E, 7, 0, 2, 0x80]);
    // OA 5, Message ID 2, instance 7.
    bus.asks(&[0x10, 5, 13, 5, 7, 0, 0x0A, 0x82], &[0x90]);
    bus.asks(&[0x0E, 5, 13, 5], &[0x8E, 7, 0, 0x0A, 0x82]);
    bus.hears(0x020A_0007, &[0x55]);
    assert_eq!(bus.node.application().outputs, [0x55]);
    bus.wait(3_600_000);
    assert_eq!(bus.state(13), 3);
}

/// Section 5, 1-8: the producer is replaced, and a consumer whose EPR is 0 goes on without being touched.
#[test]
fn a_consumer_does_not_notice_that_the_producer_is_replaced() {
    let mut bus = Bus::explicit();
    bus.connects(&[0x4B, 0xC0, 13, 0, 0, 0, 0], &[0x4B, 0xC0, 0, 0, 0]);
    bus.asks(&[0x10, 5, 13, 5, 7, 0, 0x0A, 0x80], &[0x90]);
    bus.hears(0x000A_0007, &[1]);
    bus.forget();
    // The producer is gone for ten minutes; then another node has its address, and the manager has set it up.
    bus.wait(600_000);
    assert_eq!((bus.told(), bus.state(13)), (std::vec![], 3));
    bus.hears(0x000A_0007, &[2]);
    assert_eq!(bus.told(), ["multicast, consuming, 29 bits: data received"]);
    assert_eq!(bus.node.application().outputs, [2]);
}

#[test]
fn lengths_and_services() {
    let mut bus = Bus::new();
    for len in [0, 1, 3, 4, 5, 6] {
        assert_eq!(refusal(&mut bus, &[0x4B, 0xC0, 7, 0, 0, 0][..len]), 0x13, "{len}");
    }
    assert_eq!(refusal(&mut bus, &[0x4B, 0xC0, 7, 0, 0, 0, 0, 0]), 0x15);
    for service in [0x4C, 0x0E, 0xCB, 0x00] {
        assert_eq!(refusal(&mut bus, &[service, 0xC0, 7, 0, 0, 0, 0]), 0x08);
    }
    assert_eq!(bus.node.counters().connections_refused, 11);
}

#[test]
fn instances() {
    let mut bus = Bus::new();
    // Two bytes with P.
    assert_eq!(refusal(&mut bus, &[0x4B, 0xC0]), 0x20);
    for (low, high) in [(0, 0), (14, 0), (127, 0), (0, 1), (7, 1), (0xFF, 0xFF)] {
        for predefined in [0xC0, 0x40] {
            assert_eq!(refusal(&mut bus, &[0x4B, predefined, low, high, 0, 0, 0]), 0x05, "{low} {high}");
        }
    }
    // P does not fit the instance.
    for request in [
        [0x4B, 0xC0, 128, 0, 0, 0, 0],
        [0x4B, 0xC0, 255, 0, 0, 0, 0],
        [0x4B, 0x50, 1, 0, 0, 0, 1],
        [0x4B, 0x40, 13, 0, 0, 0, 0],
    ] {
        assert_eq!(refusal(&mut bus, &request), 0x20, "{request:02X?}");
    }
}

#[test]
fn groups_and_messages() {
    let mut bus = Bus::new();
    let cases = [
        (0x80, 7), // 11 bits for an instance with 29
        (0xD0, 7), // explicit for an implicit one
        (0xC0, 6), // 29 bits for an instance with 11
        (0xC0, 1), // implicit for the explicit one
        (0xD8, 1), // explicit Message ID 8
        (0xA0, 6), // Group Select 2
        (0xE0, 7), // Group Select 6
        (0xF0, 7), // Group Select 7
        (0x88, 6), // Group 1 Message ID 8
        (0x94, 6), // Group 2 Message ID 4
        (0xB3, 6), // Group 3 Message ID 3
    ];
    for (byte, instance) in cases {
        let action = u8::from(instance == 1);
        assert_eq!(
            refusal(&mut bus, &[0x4B, byte, instance, 0, 0, 0, action]),
            0x20,
            "{byte:02X} {instance}"
        );
    }
    for byte in [0x20, 0x60, 0x70, 0x5F, 0x33] {
        assert_eq!(refusal(&mut bus, &[0x4B, byte]), 0x20, "{byte:02X}");
    }
}

#[test]
fn rates_and_actions() {
    let mut bus = Bus::new();
    for action in [3, 4, 255] {
        assert_eq!(refusal(&mut bus, &[0x4B, 0xC0, 7, 0, 0, 0, action]), 0x20);
    }
    for action in [0, 2, 4, 255] {
        assert_eq!(refusal(&mut bus, &[0x4B, 0xD0, 1, 0, 0, 0, action]), 0x20);
    }
    // 65 535 ms cannot be rounded up to a multiple of 10.
    assert_eq!(refusal(&mut bus, &[0x4B, 0xC0, 3, 0, 0xFF, 0xFF, 0]), 0x20);
    // 75 can, to 80.
    bus.connects(&[0x4B, 0xC0, 3, 0, 75, 0, 0], &[0x4B, 0xC0, 0, 80, 0]);
}

#[test]
fn what_is_not_offered() {
    let mut bus = Bus::with(|_| {}, |station| station.offer = Offer::EXTENDED.difference(Offer::DYNAMIC));
    assert_eq!(refusal(&mut bus, &[0x4B, 0x80, 6, 0, 0, 0, 0]), 0x05);
    // Dynamic ones for I/O, of any length.
    for request in [0x40, 0x00] {
        assert_eq!(refusal(&mut bus, &[0x4B, request]), 0x05);
    }
    // Every node has explicit connections.
    bus.connects(&[0x4B, 0x50], &[0x4B, 0x50, 0, 128, 0]);
}

#[test]
fn a_connection_belongs_to_whoever_asked_for_it() {
    let mut bus = Bus::new();
    bus.connects(&[0x4B, 0xC0, 3, 0, 100, 0, 0], &[0x4B, 0xC0, 0, 100, 0]);
    bus.connects(&[0x4B, 0xD0, 1, 0, 100, 0, 1], &[0x4B, 0xD0, 0, 100, 0]);
    bus.forget();
    // OA 2.
    bus.hears(0x1D86_0409, &[0x4B, 0xC0, 3, 0, 50, 0, 0]);
    bus.sends(0x1D05_8609, &[0x94, 0x0C, 0xFF]);
    bus.hears(0x1D86_0409, &[0x4B, 0xD0, 1, 0, 50, 0, 1]);
    bus.sends(0x1D05_8609, &[0x94, 0x0C, 0xFF]);
    assert_eq!(
        bus.told(),
        [
            "connection refused to OA 2, polled, 29 bits: Object state conflict",
            "connection refused to OA 2, explicit: Object state conflict"
        ]
    );
    // The manager asks again, and it begins anew.
    bus.connects(&[0x4B, 0xC1, 3, 0, 50, 0, 2], &[0x4B, 0xC1, 0, 50, 0]);
    assert_eq!(bus.told(), ["polled, 29 bits: Established -> Established: Allocate"]);
    // It times out after 10 s without a poll, and with action 2 it goes on; after that it may be another's.
    bus.connects(&[0x4B, 0xC1, 3, 0, 50, 0, 0], &[0x4B, 0xC1, 0, 50, 0]);
    bus.wait(10_000);
    assert_eq!(bus.state(3), 4);
    bus.hears(0x1D86_0409, &[0x4B, 0xC0, 3, 0, 50, 0, 0]);
    bus.sends(0x1D05_8609, &[0x4B, 0xC0, 0, 50, 0]);
    assert_eq!(bus.state(3), 3);
}

/// Whoever wants the data of a producer for many is told where and how often it produces.
#[test]
fn a_producer_for_many_is_shared() {
    for (instance, group) in [(5, 0xC2), (7, 0xC2), (4, 0x82), (6, 0x82)] {
        let mut bus = Bus::new();
        bus.connects(&[0x4B, group, instance, 0, 100, 0, 0], &[0x4B, group, 0, 100, 0]);
        bus.forget();
        let before = bus.node.connections().next();
        bus.hears(0x1D86_0409, &[0x4B, group & 0xF0, instance, 0, 50, 0, 2]);
        bus.sends(0x1D05_8609, &[0x4B, group, 0, 100, 0]);
        assert_eq!(bus.node.connections().next(), before);
        assert!(bus.told().is_empty());
    }
}

#[test]
fn room_for_six() {
    let mut bus = Bus::new();
    for instance in [3, 5, 7, 9, 11, 13] {
        bus.connects(&[0x4B, 0xC0, instance, 0, 0, 0, 0], &[0x4B, 0xC0, 0, 0, 0]);
    }
    for request in [&[0x4B, 0x50][..], &[0x4B, 0xD0, 1, 0, 0, 0, 1], &[0x4B, 0x40]] {
        bus.connects(request, &[0x94, 0x02, 0xFF]);
    }
    assert_eq!(bus.node.connections().count(), 6);
}

/// With 11 bits the Message IDs of a node are few, and each can be used once.
#[test]
fn messages_of_11_bits_are_used_once() {
    let mut bus = Bus::new();
    // Group 3 has three: polled, broadcast, multicast.
    bus.connects(&[0x4B, 0xB1, 2, 0, 0, 0, 0], &[0x4B, 0xB1, 0, 0, 0]);
    bus.connects(&[0x4B, 0xB1, 4, 0, 0, 0, 0], &[0x4B, 0xB0, 0, 0, 0]);
    bus.connects(&[0x4B, 0xB1, 6, 0, 0, 0, 0], &[0x4B, 0xB2, 0, 0, 0]);
    bus.connects(&[0x4B, 0xB1, 8, 0, 0, 0, 0], &[0x94, 0x02, 0xFF]);
    // What only consumes needs none; another group has others.
    bus.connects(&[0x4B, 0xB1, 12, 0, 0, 0, 0], &[0x4B, 0xB1, 0, 0, 0]);
    bus.connects(&[0x4B, 0x91, 8, 0, 0, 0, 0], &[0x4B, 0x91, 0, 0, 0]);
    // Asked for anew, a connection keeps the one that it has.
    bus.connects(&[0x4B, 0xB0, 4, 0, 0, 0, 0], &[0x4B, 0xB0, 0, 0, 0]);
}

#[test]
fn dynamic_connections_are_numbered_from_128() {
    let mut bus = Bus::new();
    bus.connects(&[0x4B, 0x40], &[0x4B, 0x40, 0, 128, 0]);
    bus.connects(&[0x4B, 0x57], &[0x4B, 0x57, 0, 129, 0]);
    assert_eq!([bus.state(128), bus.state(129)], [1, 3]);
    // With seven bytes the requester chooses the number, and the connection is established.
    bus.connects(&[0x4B, 0x40, 130, 0, 100, 0, 0], &[0x4B, 0x40, 0, 130, 0]);
    assert_eq!(bus.state(130), 3);
    bus.connects(&[0x4B, 0x02], &[0x4B, 0x02, 0, 131, 0]);
}

#[test]
fn who_may_ask() {
    let mut bus = Bus::new();
    // From OA 127; from OA 67, the device's own.
    for source in [0x1D86_FE09, 0x1D86_8609] {
        bus.hears(source, &[0x4B, 0xC0, 7, 0, 0, 0, 0]);
        assert_eq!(
            bus.told(),
            [std::format!("{source:08X} ignored: from an address that no other node has")]
        );
    }
    // To another node, to OA 127, a response.
    for id in [0x1D88_0209, 0x1DFE_0209, 0x1D87_0209] {
        bus.hears(id, &[0x4B, 0xC0, 7, 0, 0, 0, 0]);
    }
    bus.is_silent();
    assert_eq!(bus.node.counters().foreign, 3);
    assert_eq!(bus.node.connections().count(), 0);
}

#[test]
fn no_request_is_carried_out_whose_answer_would_be_lost() {
    let mut bus = Bus::new();
    bus.stuck = true;
    // One with the controller, four that wait.
    for transaction in 0..5 {
        bus.hears(0x1D86_0200 + transaction, &[0x4B, 0xC0, 13, 0, 0, 0, 0]);
    }
    bus.hears(0x1D86_0205, &[0x4B, 0xC0, 3, 0, 0, 0, 0]);
    assert!(matches!(bus.events.last(), Some(DeviceEvent::Ignored { why: Ignored::Busy, .. })));
    assert_eq!(bus.state(3), 0);
    bus.unstick();
    for transaction in 0..5 {
        bus.sends(0x1D03_8600 + transaction, &[0x4B, 0xC0, 0, 0, 0]);
    }
}

/// A number that was for implicit messages can be asked for again for explicit ones, and the other way round.
#[test]
fn a_dynamic_connection_becomes_one_of_the_other_kind() {
    let mut bus = Bus::explicit();
    bus.connects(&[0x4B, 0x40], &[0x4B, 0x40, 0, 128, 0]);
    bus.told();
    bus.connects(&[0x4B, 0x51, 128, 0, 0, 0, 1], &[0x4B, 0x51, 0, 128, 0]);
    assert_eq!(
        bus.told(),
        [
            "dynamic 128: Configuring -> Non-existent: Release or Delete",
            "dynamic 128: Non-existent -> Established: Allocate or Open"
        ]
    );
    bus.connects(&[0x4B, 0x40, 128, 0, 0, 0, 0], &[0x4B, 0x40, 0, 128, 0]);
    assert_eq!((bus.state(1), bus.state(128), bus.node.connections().count()), (3, 3, 2));
    bus.hears(0x1186_0205, &[0x0E, 3, 1, 1]);
    assert!(bus.told().last().is_some_and(|line| line.ends_with("no such connection")));
}

/// Nothing can tell two connections with the same identifiers apart: not if an earlier one is asked for again, either.
#[test]
fn an_explicit_connection_that_takes_the_identifiers_of_another() {
    let mut bus = Bus::explicit();
    bus.connects(&[0x4B, 0x55], &[0x4B, 0x55, 0, 128, 0]);
    bus.connects(&[0x4B, 0xD5, 1, 0, 0, 0, 1], &[0x4B, 0xD5, 0, 0, 0]);
    assert_eq!([bus.state(1), bus.state(128)], [3, 0]);
}

/// A dynamic connection that only consumes at present may produce later.
#[test]
fn a_dynamic_connection_keeps_its_message_of_11_bits() {
    let mut bus = Bus::explicit();
    bus.connects(&[0x4B, 0x03], &[0x4B, 0x03, 0, 128, 0]);
    bus.asks(&[0x10, 5, 128, 3, 0x80], &[0x90]);
    bus.connects(&[0x4B, 0x83, 2, 0, 0, 0, 0], &[0x4B, 0x80, 0, 0, 0]);
}
