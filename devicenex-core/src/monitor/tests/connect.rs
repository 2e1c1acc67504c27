//! Connection requests and responses.

use super::*;

/// Figures 7 and 8: the multicast connection of OA 67, 29 bits, 500 ms, auto reset.
#[test]
fn a_connection_is_made_in_two_steps() {
    let mut bus = Bus::new();
    let asked = bus.extended(0x1D86_0209, &[0x4B, 0xC0, 0x07, 0x00, 0xF4, 0x01, 0x02]);
    assert_eq!((asked.kind, asked.src, asked.dst), (Kind::ConnectionRequest, Some(1), Some(67)));
    let heard = bus.extended(0x1D03_8609, &[0x4B, 0xC2, 0x00, 0xF4, 0x01]);
    assert_eq!((heard.kind, heard.answers(), heard.problem), (Kind::ConnectionResponse, Some(asked.n), None));
    let held = bus.held(67, 7);
    assert_eq!((held.state, held.assumed, held.client), (ConnectionState::Established, false, Some(oa(1))));
    assert_eq!((held.epr, held.watchdog_action), (Some(500), Some(2)));
    // 0 0010 1000011 0 and instance 7.
    assert_eq!(held.produced.unwrap().to_string(), "02860007");
}

#[test]
fn a_short_request_leaves_the_connection_to_be_configured() {
    let mut bus = Bus::new();
    let (asked, answered) = bus.connect(1, 67, &[0x4B, 0x43], &[0x4B, 0x45, 0x00, 0x80, 0x00]);
    assert_eq!(asked.text, "1 -> 67  Connect dynamic, 29-bit implicit, Message ID 3");
    assert_eq!(
        answered.text,
        "67 -> 1  Connect: dynamic 128, 29-bit implicit, Message ID 5, body format 8/8"
    );
    assert_eq!(bus.held(67, 128).state, ConnectionState::Configuring);
    // An explicit connection, with instance 1: Group Select 5.
    let (asked, answered) =
        bus.connect(1, 67, &[0x4B, 0xD0, 1, 0, 0xC4, 0x09, 1], &[0x4B, 0xD1, 0x01, 0xC4, 0x09]);
    assert_eq!(asked.text, "1 -> 67  Connect explicit, EPR 2500 ms, Auto delete, Message ID 0");
    assert_eq!(answered.text, "67 -> 1  Connect: explicit, EPR 2500 ms, Message ID 1, body format 8/16");
    assert_eq!(bus.held(67, 1).state, ConnectionState::Established);
}

#[test]
fn a_refusal_is_told() {
    let mut bus = Bus::new();
    let (asked, answered) = bus.connect(1, 67, &[0x4B, 0xC0, 0x0E, 0x00, 0, 0, 0], &[0x94, 0x05, 0xFF]);
    assert_eq!(
        asked.text,
        "1 -> 67  Connect reserved 14 as predefined, 29-bit implicit, EPR 0 ms, Transition to timed out, Message ID 0"
    );
    assert_eq!(
        answered.text,
        "67 -> 1  Connect: error 0x05 Path destination unknown  ! refused: 0x05 Path destination unknown"
    );
    assert_eq!(answered.code(), Some("connection_refused"));
    assert_eq!(bus.monitor.connections().count(), 0);
    assert_eq!(bus.node(67).traffic.error_responses, 1);
}

#[test]
fn a_response_answers_the_request_with_its_transaction_id() {
    let mut bus = Bus::new();
    let response = [0x4B, 0xC2, 0x00, 0xF4, 0x01];
    assert!(bus.frame(&connection(1, 67, Direction::Response, 9, &response)).assumed);
    let request = [0x4B, 0xC0, 0x07, 0x00, 0xF4, 0x01, 0x02];
    let first = bus.frame(&connection(1, 67, Direction::Request, 9, &request)).n;
    let second = bus.frame(&connection(1, 67, Direction::Request, 10, &request)).n;
    let heard = bus.frame(&connection(1, 67, Direction::Response, 11, &response));
    assert_eq!(heard.code(), Some("transaction_mismatch"));
    assert_eq!(bus.frame(&connection(1, 67, Direction::Response, 10, &response)).answers(), Some(second));
    assert_eq!(bus.frame(&connection(1, 67, Direction::Response, 9, &response)).answers(), Some(first));
    let heard = bus.frame(&connection(1, 67, Direction::Response, 9, &response));
    assert_eq!(heard.code(), Some("unexpected_response"));
}

#[test]
fn the_rules_of_connection_requests_and_responses() {
    let good = [0x4B, 0xC0, 0x07, 0x00, 0xF4, 0x01, 0x02];
    for (request, code) in [
        (&good[..6], "too_short"),
        (&[0x4B], "too_short"),
        (&[], "too_short"),
        (&[0x4B, 0xC0, 7, 0, 0xF4, 1, 2, 0], "length"),
        (&[0x4C, 0xC0], "reserved_value"),
        (&[0x4B, 0xE0, 7, 0, 0xF4, 1, 2], "reserved_value"),
    ] {
        let heard = Bus::new().frame(&connection(1, 67, Direction::Request, 9, request));
        assert_eq!(heard.code(), Some(code), "{request:02X?}: {}", heard.text);
    }
    for (response, code) in [
        (&[0x4B, 0xC2, 0x10, 0xF4, 0x01][..], "reserved_bits"),
        (&[0x4B, 0xC2, 0x05, 0xF4, 0x01], "reserved_value"),
        (&[0x4B, 0x42, 0x00, 0x80, 0x00], "not_as_asked"),
        (&[0x4B, 0x82, 0x00, 0xF4, 0x01], "not_as_asked"),
        (&[0x4B, 0xC2, 0x00, 0xF4], "too_short"),
        (&[0x4B, 0xC2, 0x00, 0xF4, 0x01, 0x00], "length"),
        // The service has no response bit here.
        (&[0xCB, 0xC2, 0x00, 0xF4, 0x01], "reserved_value"),
        (&[0x94, 0x05], "too_short"),
    ] {
        let heard = Bus::new().connect(1, 67, &good, response).1;
        assert_eq!(heard.code(), Some(code), "{response:02X?}: {}", heard.text);
    }
    let heard = Bus::new().connect(127, 67, &good, &[0x4B, 0xC2, 0x00, 0xF4, 0x01]).0;
    assert_eq!(heard.code(), Some("no_address"));
}
