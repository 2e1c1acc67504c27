//! Connectionless requests: every row of the table in `connectionless`.

use std::vec::Vec;

use link_core::{Input, TxOutcome};

use super::bus::Bus;
use crate::device::DeviceEvent;

/// OA 1 asks OA 67, transaction 5.
const REQUEST: u32 = 0x1C86_0205;
const RESPONSE: u32 = 0x1C03_8605;

#[test]
fn attributes_can_be_read() {
    let mut bus = Bus::new();
    for (request, response) in [
        (&[0x0E, 1, 1, 1][..], &[0x8E, 0xE7, 0x03][..]),
        (&[0x0E, 1, 1, 6], &[0x8E, 0x44, 0x33, 0x22, 0x11]),
        (&[0x0E, 3, 1, 1], &[0x8E, 67]),
        (&[0x0E, 2, 0, 1], &[0x8E, 1, 0]),
        (&[0x0E, 5, 1, 1], &[0x94, 0x16, 0xFF]),
        (&[0x0E, 1, 1, 99], &[0x94, 0x14, 0xFF]),
        (&[0x0E, 99, 1, 1], &[0x94, 0x16, 0xFF]),
        (&[0x0E], &[0x94, 0x13, 0xFF]),
        (&[0x0E, 1], &[0x94, 0x13, 0xFF]),
        (&[0x0E, 1, 1], &[0x94, 0x13, 0xFF]),
        (&[0x0E, 1, 1, 1, 0], &[0x94, 0x15, 0xFF]),
    ] {
        bus.hears(REQUEST, request);
        bus.sends(RESPONSE, response);
    }
    assert_eq!((bus.node.counters().connectionless, bus.node.counters().refused), (11, 7));
    assert!(bus.told().is_empty());
}

/// Whatever is asked, nothing changes.
#[test]
fn no_other_service_is_carried_out() {
    let mut bus = Bus::explicit();
    let before = bus.node.application().clone();
    for service in (0..0x80).filter(|&service| service != 0x0E) {
        for body in [
            &[service][..],
            &[service, 1, 1],
            &[service, 3, 1, 1, 5],
            &[service, 5, 1, 9, 0, 0],
            &[service, 5, 0],
        ] {
            bus.hears(REQUEST, body);
            bus.sends(RESPONSE, &[0x94, 0x08, 0xFF]);
        }
    }
    assert_eq!((bus.node.application(), bus.state(1)), (&before, 3));
    assert_eq!(bus.node.access().address().number(), 67);
}

#[test]
fn what_is_not_answered() {
    let mut bus = Bus::new();
    for (id, data, why) in [
        (0x1C86_FE05, &[0x0E, 1, 1, 1][..], "from an address that no other node has"),
        (0x1C86_8605, &[0x0E, 1, 1, 1], "from an address that no other node has"),
        (REQUEST, &[], "too short"),
        (REQUEST, &[0x8E, 1], "a response"),
        // Fragments: first, middle, last; the acknowledge of nothing.
        (0x1C86_0300, &[5, 0x0E, 1, 1, 1, 0, 0, 0], "a fragment"),
        (0x1C86_0341, &[1; 8], "a fragment"),
        (0x1C86_0381, &[1], "a fragment"),
        (0x1C86_03C0, &[0], "acknowledge of nothing"),
    ] {
        bus.hears(id, data);
        assert_eq!(bus.told(), [std::format!("{id:08X} ignored: {why}")]);
        bus.is_silent();
    }
    // To OA 127, and a response to this node.
    bus.hears(0x1CFE_0205, &[0x0E, 1, 1, 1]);
    bus.hears(0x1C87_0205, &[0x8E, 1]);
    // A remote frame is nobody's.
    bus.input(Input::Frame(link_core::Frame::remote(link_core::frame::extended_id(REQUEST), 4).unwrap()));
    bus.is_silent();
    assert_eq!(bus.told(), Vec::<std::string::String>::new());
    assert_eq!(bus.node.counters().foreign, 2);
}

/// "Example Block 2I1O": 20 bytes with service and length, in fragments of 7, 8 and 5.
#[test]
fn a_long_value_comes_in_fragments() {
    let mut bus = Bus::new();
    bus.hears(REQUEST, &[0x0E, 1, 1, 7]);
    bus.sends(0x1C03_8700, b"\x05\x8E\x12Examp");
    bus.hears(0x1C86_03C0, &[0]);
    bus.sends(0x1C03_8741, b"le Block");
    bus.is_silent();
    // Acknowledged by another node, or for another fragment: that counts for nothing.
    bus.hears(0x1C86_05C1, &[0]);
    bus.hears(0x1C86_03C0, &[0]);
    bus.is_silent();
    bus.hears(0x1C86_03C1, &[0]);
    bus.sends(0x1C03_8782, b" 2I1O");
    bus.hears(0x1C86_03C2, &[0]);
    bus.wait(5000);
    bus.is_silent();
}

#[test]
fn a_fragment_is_sent_twice_and_given_up() {
    let mut bus = Bus::new();
    bus.hears(REQUEST, &[0x0E, 1, 1, 7]);
    bus.sends(0x1C03_8700, b"\x05\x8E\x12Examp");
    bus.wait(999);
    bus.is_silent();
    bus.wait(1);
    bus.sends(0x1C03_8700, b"\x05\x8E\x12Examp");
    assert!(bus.told().is_empty());
    bus.wait(1000);
    bus.is_silent();
    assert_eq!(bus.told(), ["response to OA 1 given up, not acknowledged"]);
}

#[test]
fn one_long_response_at_a_time() {
    let mut bus = Bus::new();
    bus.hears(REQUEST, &[0x0E, 1, 1, 7]);
    bus.sends(0x1C03_8700, b"\x05\x8E\x12Examp");
    // OA 2 has to ask again; short ones are answered.
    bus.hears(0x1C86_0405, &[0x0E, 1, 1, 7]);
    assert_eq!(bus.told(), ["1C860405 ignored: too many requests at once"]);
    bus.hears(0x1C86_0405, &[0x0E, 1, 1, 1]);
    bus.sends(0x1C05_8605, &[0x8E, 0xE7, 0x03]);
    // OA 1 asks again, and gives up its first one.
    bus.hears(0x1C86_0206, &[0x0E, 1, 1, 7]);
    bus.sends(0x1C03_8700, b"\x06\x8E\x12Examp");
    bus.hears(0x1C86_03C0, &[1]);
    // "Too much data": the client does not want it. Now OA 2 can.
    bus.hears(0x1C86_0405, &[0x0E, 1, 1, 7]);
    bus.sends(0x1C05_8700, b"\x05\x8E\x12Examp");
}

#[test]
fn answers_that_are_given_back_are_lost_and_told() {
    let mut bus = Bus::new();
    bus.outcome = TxOutcome::Dropped;
    bus.hears(REQUEST, &[0x0E, 1, 1, 1]);
    bus.hears(REQUEST, &[0x0E, 1, 1, 7]);
    let lost = bus.events.iter().filter(|event| matches!(event, DeviceEvent::NotSent { .. })).count();
    assert_eq!((lost, bus.node.counters().not_sent), (2, 2));
    // The fragment is sent again in its time.
    bus.outcome = TxOutcome::Sent;
    bus.wait(1000);
    bus.sends(0x1C03_8700, b"\x05\x8E\x12Examp");
}
