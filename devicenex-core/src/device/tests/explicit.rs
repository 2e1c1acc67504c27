//! Explicit messages on connections, in one frame and in fragments.

use std::vec::Vec;

use cip_core::message::BodyFormat;
use link_core::TxOutcome;

use super::bus::Bus;

/// Message ID 0 of OA 1 to OA 67, transaction 5; and the answer.
const REQUEST: u32 = 0x1086_0205;
const RESPONSE: u32 = 0x1003_8605;

#[test]
fn a_request_and_its_response() {
    let mut bus = Bus::explicit();
    bus.hears(REQUEST, &[0x0E, 1, 1, 1]);
    bus.sends(RESPONSE, &[0x8E, 0xE7, 0x03]);
    // Eight bytes fit into a frame.
    bus.hears(0x1086_02FF, &[0x10, 5, 1, 9, 100, 0, 0, 0]);
    bus.sends(0x1003_86FF, &[0x94, 0x15, 0xFF]);
    assert_eq!(bus.told(), Vec::<std::string::String>::new());
}

#[test]
fn the_requester_chooses_the_message_id() {
    let mut bus = Bus::new();
    bus.connects(&[0x4B, 0xD6, 1, 0, 0, 0, 1], &[0x4B, 0xD6, 0, 0, 0]);
    bus.hears(0x1686_0200, &[0x0E, 3, 1, 1]);
    bus.sends(0x1603_8600, &[0x8E, 67]);
    bus.forget();
    bus.hears(REQUEST, &[0x0E, 3, 1, 1]);
    bus.is_silent();
    assert_eq!(bus.told(), ["10860205 ignored: no such connection"]);
}

#[test]
fn a_request_belongs_to_the_connection_of_its_sender() {
    let mut bus = Bus::explicit();
    bus.hears(0x1086_0405, &[0x0E, 3, 1, 1]);
    bus.is_silent();
    assert_eq!(bus.told(), ["10860405 ignored: no such connection"]);
    // OA 2 opens one of its own, with the same Message ID.
    bus.hears(0x1D86_0400, &[0x4B, 0x50]);
    bus.sends(0x1D05_8600, &[0x4B, 0x50, 0, 128, 0]);
    bus.hears(0x1086_0405, &[0x0E, 3, 1, 5]);
    bus.sends(0x1005_8605, &[0x8E, 2, 1, 128]);
}

/// Nothing can tell two connections with the same identifiers apart: the later one takes the place of the earlier one.
#[test]
fn a_connection_with_the_identifiers_of_another_takes_its_place() {
    let mut bus = Bus::explicit();
    bus.connects(&[0x4B, 0x50], &[0x4B, 0x50, 0, 128, 0]);
    assert_eq!([bus.state(1), bus.state(128)], [0, 3]);
    assert_eq!(
        bus.told(),
        [
            "explicit: Established -> Non-existent: Release, Delete or Close",
            "dynamic 128: Non-existent -> Established: Allocate or Open"
        ]
        .map(std::string::String::from)
    );
    bus.asks(&[0x0E, 3, 1, 5], &[0x8E, 1, 128]);
}

#[test]
fn what_is_not_a_request() {
    let mut bus = Bus::explicit();
    for (id, data, why) in [
        (REQUEST, &[][..], "too short"),
        (REQUEST, &[0x8E, 1], "a response"),
        (0x1086_0300, &[5, 0x10, 1, 1, 1, 0, 0], "too short"),
        (0x1086_0341, &[0; 8], "fragment out of order"),
        (0x1086_0341, &[0; 7], "too short"),
        (0x1086_0381, &[0], "fragment out of order"),
        (0x1086_0381, &[], "too short"),
        (0x1086_0302, &[0; 8], "fragment out of order"),
        (0x1086_03C0, &[0], "acknowledge of nothing"),
        (0x1086_03C0, &[], "too short"),
    ] {
        bus.hears(id, data);
        assert_eq!(bus.told(), [std::format!("{id:08X} ignored: {why}")]);
        bus.is_silent();
    }
    // One that ends before it names an object.
    for len in 1..3 {
        bus.asks(&[0x0E, 1, 1][..len], &[0x94, 0x13, 0xFF]);
    }
    bus.asks(&[0x0E, 1, 1], &[0x94, 0x13, 0xFF]);
    // Frames to others, and responses, are nobody's.
    bus.hears(0x1088_0205, &[0x0E, 1, 1, 1]);
    bus.hears(0x1087_0205, &[0x8E, 1]);
    bus.is_silent();
    assert_eq!(bus.node.counters().foreign, 2);
}

/// Set_Attribute_Single with a value of ten bytes, 14 in all: 7 and 7. Identity has no such service.
#[test]
fn a_request_comes_in_fragments() {
    let mut bus = Bus::explicit();
    bus.hears(0x1086_0300, &[9, 0x10, 1, 1, 7, 1, 2, 3]);
    bus.sends(0x1003_87C0, &[0]);
    bus.hears(0x1086_0381, &[4, 5, 6, 7, 8, 9, 10]);
    bus.sends(0x1003_87C1, &[0]);
    // The transaction of the first fragment.
    bus.sends(0x1003_8609, &[0x94, 0x08, 0xFF]);
    // Its last fragment again is acknowledged for one second, and not carried out again.
    bus.hears(0x1086_0381, &[4, 5, 6, 7, 8, 9, 10]);
    bus.sends(0x1003_87C1, &[0]);
    bus.is_silent();
    bus.wait(1000);
    bus.hears(0x1086_0381, &[4, 5, 6, 7, 8, 9, 10]);
    bus.is_silent();
    assert_eq!(bus.told(), ["10860381 ignored: fragment out of order"]);
}

#[test]
fn a_middle_fragment_again_is_acknowledged_again() {
    let mut bus = Bus::explicit();
    bus.hears(0x1086_0300, &[9, 0x10, 1, 1, 7, 1, 2, 3]);
    bus.sends(0x1003_87C0, &[0]);
    for _ in 0..2 {
        bus.hears(0x1086_0341, &[4, 5, 6, 7, 8, 9, 10, 11]);
        bus.sends(0x1003_87C1, &[0]);
    }
    bus.hears(0x1086_0382, &[12]);
    bus.sends(0x1003_87C2, &[0]);
    bus.sends(0x1003_8609, &[0x94, 0x08, 0xFF]);
}

/// 40 bytes is what the device has room for.
#[test]
fn a_request_that_is_too_long_is_refused_with_its_acknowledge() {
    let mut bus = Bus::explicit();
    bus.hears(0x1086_0300, &[9, 0x10, 1, 1, 7, 1, 2, 3]);
    for count in 1..=4 {
        bus.hears(0x1086_0340 + count, &[0; 8]);
    }
    bus.forget();
    // 7 + 4 * 8 are 39; two more are too many.
    bus.hears(0x1086_0385, &[1, 2]);
    bus.sends(0x1003_87C5, &[1]);
    bus.is_silent();
    bus.asks(&[0x0E, 3, 1, 1], &[0x8E, 67]);
}

#[test]
fn a_request_that_is_not_continued_is_dropped() {
    let mut bus = Bus::explicit();
    bus.hears(0x1086_0300, &[9, 0x10, 1, 1, 7, 1, 2, 3]);
    bus.sends(0x1003_87C0, &[0]);
    bus.wait(2000);
    bus.hears(0x1086_0381, &[4]);
    bus.is_silent();
    // A whole request drops it as well.
    bus.hears(0x1086_0300, &[9, 0x10, 1, 1, 7, 1, 2, 3]);
    bus.sends(0x1003_87C0, &[0]);
    bus.asks(&[0x0E, 3, 1, 1], &[0x8E, 67]);
    bus.hears(0x1086_0381, &[4]);
    bus.is_silent();
}

#[test]
fn a_response_goes_out_in_fragments() {
    let mut bus = Bus::explicit();
    bus.hears(REQUEST, &[0x0E, 1, 1, 7]);
    bus.sends(0x1003_8700, b"\x05\x8E\x12Examp");
    bus.hears(0x1086_03C0, &[0]);
    bus.sends(0x1003_8741, b"le Block");
    // Not acknowledged: once more, and that is acknowledged.
    bus.wait(1000);
    bus.sends(0x1003_8741, b"le Block");
    bus.hears(0x1086_03C1, &[0]);
    bus.sends(0x1003_8782, b" 2I1O");
    bus.hears(0x1086_03C2, &[0]);
    bus.wait(5000);
    bus.is_silent();
    assert!(bus.told().is_empty());
}

#[test]
fn a_response_is_given_up() {
    let mut bus = Bus::explicit();
    bus.hears(REQUEST, &[0x0E, 1, 1, 7]);
    bus.wait(2000);
    assert_eq!(bus.told(), ["response to OA 1 given up, not acknowledged"]);
    assert_eq!(bus.sent.len(), 2);
    bus.forget();
    // By another request; by "too much data"; by the first fragment of another.
    bus.hears(REQUEST, &[0x0E, 1, 1, 7]);
    bus.forget();
    bus.asks(&[0x0E, 3, 1, 1], &[0x8E, 67]);
    bus.hears(REQUEST, &[0x0E, 1, 1, 7]);
    bus.hears(0x1086_03C0, &[1]);
    bus.hears(REQUEST, &[0x0E, 1, 1, 7]);
    bus.forget();
    bus.hears(0x1086_0300, &[9, 0x10, 1, 1, 7, 1, 2, 3]);
    bus.sends(0x1003_87C0, &[0]);
    bus.wait(1999);
    bus.is_silent();
}

#[test]
fn a_fragment_that_is_given_back_is_sent_again() {
    let mut bus = Bus::explicit();
    bus.outcome = TxOutcome::Dropped;
    bus.hears(REQUEST, &[0x0E, 1, 1, 7]);
    bus.outcome = TxOutcome::Sent;
    bus.is_silent();
    bus.wait(1000);
    bus.sends(0x1003_8700, b"\x05\x8E\x12Examp");
    assert_eq!(bus.told(), ["10038600 not sent: Dropped"]);
}

/// The device tells in its connection response how it wants objects to be named.
#[test]
fn the_body_format_is_the_devices() {
    for (format, code, request, response) in [
        (BodyFormat::Class8Instance16, 1, &[0x0E, 3, 1, 0, 1][..], &[0x8E, 67][..]),
        (BodyFormat::Class16Instance16, 2, &[0x0E, 3, 0, 1, 0, 1], &[0x8E, 67]),
        (BodyFormat::Class16Instance8, 3, &[0x0E, 3, 0, 1, 1], &[0x8E, 67]),
        (BodyFormat::Class16Instance16, 2, &[0x0E, 3, 0, 1], &[0x94, 0x13, 0xFF]),
    ] {
        let mut bus = Bus::with(|config| config.body_format = format, |_| {});
        bus.connects(&[0x4B, 0xD0, 1, 0, 0, 0, 1], &[0x4B, 0xD0, code, 0, 0]);
        bus.asks(request, response);
    }
}

/// It is there for ten seconds after its last message: an EPR of 2500 ms, times four.
#[test]
fn a_connection_that_is_not_used_ends() {
    let mut bus = Bus::new();
    bus.connects(&[0x4B, 0x50], &[0x4B, 0x50, 0, 128, 0]);
    bus.wait(9_999);
    bus.asks(&[0x0E, 3, 1, 1], &[0x8E, 67]);
    bus.wait(9_999);
    assert_eq!(bus.state(128), 3);
    bus.wait(1);
    assert_eq!(bus.state(128), 0);
    assert_eq!(
        bus.told().last().map(|line| line.as_str()),
        Some("dynamic 128: Established -> Non-existent: time-out, no I/O established")
    );
    assert_eq!(bus.node.counters().timed_out, 1);
}

/// Delete of the connection that carries it: the response still goes out, nothing else is answered.
#[test]
fn a_connection_deletes_itself() {
    let mut bus = Bus::explicit();
    bus.stuck = true;
    bus.hears(REQUEST, &[0x09, 5, 1]);
    assert_eq!(bus.state(1), 0);
    bus.hears(0x1086_0206, &[0x0E, 3, 1, 1]);
    bus.unstick();
    bus.sends(RESPONSE, &[0x89]);
    bus.is_silent();
    // Its place is free again.
    for _ in 0..6 {
        bus.opens_explicit();
        bus.asks(&[0x09, 5, 1], &[0x89]);
    }
}
