//! Implicit messages of all kinds, with 11 and 29 bits.

use std::string::String;
use std::vec::Vec;

use cip_core::code::InstanceId;
use link_core::TxOutcome;

use super::bus::Bus;
use crate::device::NotProducing;

const NOTHING: [&str; 0] = [];

/// With one connection of the manager, and what goes out then.
fn connected(request: &[u8], response: &[u8]) -> Bus {
    let mut bus = Bus::new();
    bus.connects(request, response);
    bus.told();
    bus
}

#[test]
fn polled() {
    // 29 bits, Message ID 2; 11 bits, Group 1 Message ID 3: (command, answer).
    for (request, command, answer) in [
        ([0x4B, 0xC2, 3, 0, 100, 0, 0], 0x0202_C303, 0x0286_0003),
        ([0x4B, 0x83, 2, 0, 100, 0, 0], 0x181, 0x1C3),
        ([0x4B, 0x93, 2, 0, 100, 0, 0], 0x581, 0x5C3),
        ([0x4B, 0xB2, 2, 0, 100, 0, 0], 0x701, 0x743),
    ] {
        let mut bus = connected(&request, &[0x4B, request[1], 0, 100, 0]);
        // A server says nothing by itself.
        bus.wait(9_000);
        bus.is_silent();
        bus.hears(command, &[0x77]);
        bus.sends(answer, &[0x34, 0x12]);
        assert_eq!(bus.node.application().outputs, [0x77]);
        let name = if request[2] == 3 { "polled, 29 bits" } else { "polled, 11 bits" };
        assert_eq!(bus.told(), [std::format!("{name}: run"), std::format!("{name}: data received")]);
        // An empty command is idle: the outputs are at rest, the answer has data.
        bus.hears(command, &[]);
        bus.sends(answer, &[0x34, 0x12]);
        assert_eq!(
            (bus.told(), &bus.node.application().outputs[..]),
            (std::vec![std::format!("{name}: idle")], &[0][..])
        );
        // One of another length is none.
        bus.hears(command, &[1, 2]);
        bus.is_silent();
        assert_eq!(bus.told(), [std::format!("{} ignored: wrong length", super::bus::id(command))]);
        // From another node, or another instance.
        bus.hears(command + 1, &[1]);
        bus.is_silent();
        bus.wait(400);
        assert_eq!((bus.state(request[2].into()), bus.told().len()), (4, 2));
        bus.hears(command, &[1]);
        bus.is_silent();
    }
}

#[test]
fn commands_that_come_before_the_answer_is_sent_share_it() {
    let mut bus = connected(&[0x4B, 0xC2, 3, 0, 0, 0, 0], &[0x4B, 0xC2, 0, 0, 0]);
    bus.stuck = true;
    for data in 1..=3 {
        bus.hears(0x0202_C303, &[data]);
    }
    // One with the controller, one for the other two.
    assert_eq!((bus.held.len(), bus.node.counters().merged), (1, 1));
    bus.node.application_mut().inputs = std::vec![9, 9];
    bus.unstick();
    bus.sends(0x0286_0003, &[0x34, 0x12]);
    bus.sends(0x0286_0003, &[9, 9]);
    bus.is_silent();
}

#[test]
fn multicast_and_broadcast_produce_by_change_and_by_time() {
    for (request, id, number) in [
        ([0x4B, 0xC1, 5, 0, 100, 0, 0], 0x0186_0005, 5),
        ([0x4B, 0xC1, 7, 0, 100, 0, 0], 0x0186_0007, 7),
        ([0x4B, 0x81, 4, 0, 100, 0, 0], 0xC3, 4),
        ([0x4B, 0x91, 6, 0, 100, 0, 0], 0x4C3, 6),
    ] {
        let mut bus = connected(&request, &[0x4B, request[1], 0, 100, 0]);
        bus.sends(id, &[0x34, 0x12]);
        bus.wait(50);
        bus.node.application_mut().inputs = std::vec![1, 2];
        bus.node.produce(bus.now, InstanceId(number)).unwrap();
        bus.drain();
        bus.sends(id, &[1, 2]);
        // The rate counts from the last message.
        bus.wait(99);
        bus.is_silent();
        bus.wait(1);
        bus.sends(id, &[1, 2]);
        // Nobody acknowledges it, nothing is consumed, it never times out.
        bus.wait(60_000);
        assert_eq!((bus.sent.len(), bus.state(number)), (600, 3));
        assert_eq!(bus.told(), NOTHING);
        assert_eq!(bus.node.produce(bus.now, InstanceId(9)), Err(NotProducing(InstanceId(9))));
    }
}

#[test]
fn with_a_rate_of_0_only_changes_are_produced() {
    let mut bus = connected(&[0x4B, 0xC0, 7, 0, 0, 0, 0], &[0x4B, 0xC0, 0, 0, 0]);
    bus.sends(0x0086_0007, &[0x34, 0x12]);
    bus.wait(3_600_000);
    bus.is_silent();
    bus.node.inputs_changed(bus.now);
    bus.drain();
    bus.sends(0x0086_0007, &[0x34, 0x12]);
}

/// Attribute 17: how long changes wait after a message.
#[test]
fn the_inhibit_time_holds_changes_back() {
    let mut bus = Bus::explicit();
    bus.connects(&[0x4B, 0xC0, 7, 0, 100, 0, 0], &[0x4B, 0xC0, 0, 100, 0]);
    bus.asks(&[0x10, 5, 7, 17, 101, 0], &[0x94, 0x09, 0xFF]);
    bus.asks(&[0x10, 5, 7, 17, 40, 0], &[0x90]);
    bus.wait(100);
    bus.forget();
    for _ in 0..3 {
        bus.wait(10);
        bus.node.inputs_changed(bus.now);
        bus.drain();
        bus.is_silent();
    }
    bus.wait(9);
    bus.is_silent();
    bus.wait(1);
    bus.sends(0x0086_0007, &[0x34, 0x12]);
    // What changed is in it.
    bus.wait(99);
    bus.is_silent();
}

/// Change of state and cyclic, 29 and 11 bits: (request, data, acknowledge).
const ACKNOWLEDGED: [([u8; 7], u32, u32); 4] = [
    ([0x4B, 0xC2, 9, 0, 100, 0, 0], 0x0286_0009, 0x0203_C309),
    ([0x4B, 0xC2, 11, 0, 100, 0, 0], 0x0286_000B, 0x0203_C30B),
    ([0x4B, 0x82, 8, 0, 100, 0, 0], 0x143, 0x101),
    ([0x4B, 0x82, 10, 0, 100, 0, 0], 0x143, 0x101),
];

#[test]
fn change_of_state_and_cyclic_are_acknowledged() {
    for (request, id, acknowledge) in ACKNOWLEDGED {
        let mut bus = connected(&request, &[0x4B, request[1], 0, 100, 0]);
        bus.sends(id, &[0x34, 0x12]);
        bus.hears(acknowledge, &[]);
        for _ in 0..1000 {
            bus.wait(99);
            bus.is_silent();
            bus.wait(1);
            bus.sends(id, &[0x34, 0x12]);
            bus.hears(acknowledge, &[]);
        }
        assert_eq!((bus.state(request[2].into()), bus.told()), (3, Vec::<String>::new()));
        assert_eq!(bus.node.counters().consumed, 1001);
        // A change is for change of state only.
        let by_change = request[2] <= 9;
        bus.node.inputs_changed(bus.now);
        bus.drain();
        assert_eq!(bus.sent.len(), usize::from(by_change));
        assert_eq!(bus.node.produce(bus.now, InstanceId(request[2].into())).is_ok(), by_change);
    }
}

/// Once after 16 ms; then it is told. Without acknowledges the connection times out: 10 s, then 400 ms.
#[test]
fn without_acknowledge_a_message_is_sent_again() {
    for (request, id, acknowledge) in ACKNOWLEDGED {
        let mut bus = connected(&request, &[0x4B, request[1], 0, 100, 0]);
        bus.sends(id, &[0x34, 0x12]);
        bus.wait(16);
        bus.sends(id, &[0x34, 0x12]);
        assert!(bus.told().is_empty());
        bus.wait(16);
        bus.is_silent();
        assert!(bus.told()[0].ends_with("not acknowledged"));
        // The rate goes on from the first of them.
        bus.wait(68);
        bus.sends(id, &[0x34, 0x12]);
        bus.hears(acknowledge, &[]);
        bus.forget();
        bus.wait(399);
        assert_eq!(bus.state(request[2].into()), 3);
        bus.wait(1);
        assert_eq!(bus.state(request[2].into()), 4);
        bus.forget();
        bus.wait(1000);
        bus.is_silent();
    }
}

#[test]
fn without_acknowledges_nothing_is_awaited() {
    for (instance, trigger) in [(9, 0x10), (11, 0x00)] {
        // By the device's choice.
        let mut bus = Bus::with(|config| config.acknowledged = false, |_| {});
        bus.opens_explicit();
        bus.connects(&[0x4B, 0xC2, instance, 0, 100, 0, 0], &[0x4B, 0xC2, 0, 100, 0]);
        bus.asks(&[0x0E, 5, instance, 3], &[0x8E, trigger]);
        bus.asks(&[0x0E, 5, instance, 5], &[0x8E, 0xFF, 0xFF, 0xFF, 0xFF]);
        bus.forget();
        bus.wait(60_000);
        assert_eq!((bus.sent.len(), bus.state(instance.into())), (600, 3));
        assert_eq!(bus.told(), NOTHING);
        // By the manager's: with, and without again.
        bus.asks(&[0x10, 5, instance, 3, trigger | 2], &[0x90]);
        bus.wait(9_999);
        assert_eq!(bus.state(instance.into()), 3);
        bus.asks(&[0x10, 5, instance, 3, trigger], &[0x90]);
        bus.forget();
        bus.wait(60_000);
        assert_eq!((bus.sent.len(), bus.state(instance.into())), (600, 3));
        bus.asks(&[0x10, 5, instance, 3, 0x82], &[0x94, 0x09, 0xFF]);
    }
}

#[test]
fn consumers_time_out_as_they_are_told() {
    // Four times 100 ms; but 10 s before the first message.
    for (action, state) in [(0, 4), (1, 0), (2, 3)] {
        let mut bus = connected(&[0x4B, 0xC0, 13, 0, 100, 0, action], &[0x4B, 0xC0, 0, 100, 0]);
        bus.wait(9_999);
        assert_eq!(bus.state(13), 3);
        bus.hears(0x0002_0007, &[7]);
        bus.told();
        bus.wait(399);
        assert_eq!((bus.state(13), &bus.node.application().outputs[..]), (3, &[7][..]));
        bus.wait(1);
        assert_eq!((bus.state(13), &bus.node.application().outputs[..]), (state, &[0][..]));
        let told = bus.told();
        let fault = "multicast, consuming, 29 bits: fault";
        let moved = match action {
            0 => Some("multicast, consuming, 29 bits: Established -> Timed out: time-out"),
            1 => Some("multicast, consuming, 29 bits: Established -> Non-existent: time-out"),
            _ => None,
        };
        let expected: Vec<_> = moved.into_iter().chain([fault]).collect();
        assert_eq!(told, expected);
        bus.hears(0x0002_0007, &[8]);
        assert_eq!(bus.node.application().outputs, [if action == 2 { 8 } else { 0 }]);
    }
}

/// Attribute 5 while it is established: the new producer has ten seconds.
#[test]
fn whoever_is_to_be_consumed_has_time_for_its_first_message() {
    let mut bus = Bus::explicit();
    bus.connects(&[0x4B, 0xC0, 13, 0, 100, 0, 0], &[0x4B, 0xC0, 0, 100, 0]);
    bus.hears(0x0002_0007, &[7]);
    bus.asks(&[0x10, 5, 13, 5, 7, 0, 0x0A, 0x80], &[0x90]);
    bus.wait(9_999);
    bus.hears(0x0002_0007, &[9]);
    assert_eq!((bus.state(13), &bus.node.application().outputs[..]), (3, &[7][..]));
    bus.wait(1);
    assert_eq!(bus.state(13), 4);
}

#[test]
fn consumers_of_11_bits() {
    let mut bus = Bus::explicit();
    bus.connects(&[0x4B, 0x95, 12, 0, 0, 0, 0], &[0x94, 0x20, 0xFF]);
    bus.connects(&[0x4B, 0x82, 12, 0, 0, 0, 0], &[0x4B, 0x82, 0, 0, 0]);
    // Group 1 Message ID 2 of the requester; then of OA 5.
    bus.asks(&[0x0E, 5, 12, 5], &[0x8E, 0x01, 0x01, 0, 0]);
    bus.hears(0x101, &[1]);
    bus.asks(&[0x10, 5, 12, 5, 0x05, 0x01, 0, 0], &[0x90]);
    bus.hears(0x105, &[2]);
    assert_eq!((&bus.node.application().outputs[..], bus.node.counters().consumed), (&[2][..], 2));
}

/// What attribute 3 makes of a dynamic connection.
#[test]
fn dynamic_connections_do_what_they_are_told() {
    for (trigger, produced, consumed) in [
        (0x82, 0x0086_0080, Some(0x0002_C380)),
        (0x80, 0xFFFF_FFFF, Some(0x0002_C380)),
        (0x92, 0x0087_0080, Some(0x0002_C380)),
        (0x00, 0x0086_0080, None),
        (0x10, 0x0086_0080, None),
        (0x02, 0x0086_0080, Some(0x0003_C380)),
        (0x12, 0x0086_0080, Some(0x0003_C380)),
    ] {
        let mut bus = Bus::explicit();
        bus.connects(&[0x4B, 0x40], &[0x4B, 0x40, 0, 128, 0]);
        bus.asks(&[0x10, 5, 128, 3, trigger], &[0x90]);
        let ids = |id: Option<u32>| id.map_or(u32::MAX, |id| id | 1 << 31).to_le_bytes();
        let [a, b, c, d] = ids((produced != u32::MAX).then_some(produced));
        bus.asks(&[0x0E, 5, 128, 4], &[0x8E, a, b, c, d]);
        let [a, b, c, d] = ids(consumed);
        bus.asks(&[0x0E, 5, 128, 5], &[0x8E, a, b, c, d]);
        bus.is_silent();
        bus.asks(&[0x10, 5, 128, 9, 100, 0], &[0x90, 100, 0]);
        assert_eq!(bus.state(128), 3);
        if trigger < 0x80 {
            bus.sends(produced, &[0x34, 0x12]);
            bus.forget();
            continue;
        }
        bus.is_silent();
        bus.hears(consumed.unwrap(), &[0x66]);
        assert_eq!(bus.node.application().outputs, [0x66]);
        match trigger {
            0x82 => bus.sends(produced, &[0x34, 0x12]),
            0x92 => bus.sends(produced, &[]),
            _ => {}
        }
        bus.is_silent();
    }
}

/// A change-of-state producer and its acknowledging consumer, neither of which is the manager.
#[test]
fn a_device_acknowledges_another() {
    let mut consumer = Bus::explicit();
    consumer.connects(&[0x4B, 0x40], &[0x4B, 0x40, 0, 128, 0]);
    consumer.asks(&[0x10, 5, 128, 3, 0x92], &[0x90]);
    // Connection 9 of OA 5, Message ID 0.
    consumer.asks(&[0x10, 5, 128, 5, 9, 0, 0x0A, 0x80], &[0x90]);
    consumer.asks(&[0x0D, 5, 128], &[0x8D]);
    consumer.hears(0x000A_0009, &[0x44]);
    consumer.sends(0x0087_0080, &[]);

    let mut producer = Bus::explicit();
    producer.connects(&[0x4B, 0x40], &[0x4B, 0x40, 0, 128, 0]);
    producer.asks(&[0x10, 5, 128, 3, 0x12], &[0x90]);
    // The acknowledges of connection 128 of OA 5.
    producer.asks(&[0x10, 5, 128, 5, 0x80, 0, 0x0B, 0x80], &[0x90]);
    producer.asks(&[0x10, 5, 128, 9, 100, 0], &[0x90, 100, 0]);
    producer.sends(0x0086_0080, &[0x34, 0x12]);
    producer.hears(0x000B_0080, &[]);
    producer.wait(99);
    producer.is_silent();
    producer.wait(1);
    producer.sends(0x0086_0080, &[0x34, 0x12]);
}

/// A producer goes on although one of its frames was lost.
#[test]
fn a_frame_that_is_given_back_is_lost() {
    let mut bus = connected(&[0x4B, 0xC0, 7, 0, 100, 0, 0], &[0x4B, 0xC0, 0, 100, 0]);
    bus.forget();
    bus.outcome = TxOutcome::Dropped;
    bus.wait(100);
    assert_eq!(bus.told(), ["00860007 not sent: Dropped"]);
    bus.outcome = TxOutcome::Sent;
    bus.wait(100);
    bus.sends(0x0086_0007, &[0x34, 0x12]);
}

/// Two connections may consume the same.
#[test]
fn one_message_for_two_connections() {
    let mut bus = Bus::explicit();
    bus.connects(&[0x4B, 0xC0, 13, 0, 0, 0, 0], &[0x4B, 0xC0, 0, 0, 0]);
    bus.connects(&[0x4B, 0x40], &[0x4B, 0x40, 0, 128, 0]);
    bus.asks(&[0x10, 5, 128, 3, 0x80], &[0x90]);
    bus.asks(&[0x10, 5, 128, 5, 7, 0, 2, 0x80], &[0x90]);
    bus.asks(&[0x0D, 5, 128], &[0x8D]);
    bus.told();
    bus.hears(0x0002_0007, &[1]);
    assert_eq!(bus.node.counters().consumed, 2);
}
