//! Explicit messages: pairing, headers, fragments, body formats.

use super::*;

#[test]
fn a_response_answers_the_request_with_its_transaction_and_service() {
    let mut bus = Bus::with_slave(10, 0x01);
    let asked = bus.group2(10, 4, &[0x41, 0x0E, 1, 1, 1]).n;
    let heard = bus.group2(10, 3, &[0x01, 0x8E, 0x34, 0x12]);
    assert_eq!((heard.problem, heard.answers()), (Some(Problem::Flaw(Flaw::TransactionMismatch)), None));
    let heard = bus.group2(10, 3, &[0x41, 0x90]);
    let expected = cip_core::code::ServiceCode::GET_ATTRIBUTE_SINGLE;
    assert_eq!(heard.problem, Some(Problem::Flaw(Flaw::ServiceMismatch { expected })));
    let heard = bus.group2(10, 3, &[0x42, 0x8E, 0x34, 0x12]);
    assert_eq!(heard.problem, Some(Problem::WrongRequester { expected: mac(1) }));
    let heard = bus.group2(10, 3, &[0x41, 0x8E, 0x34, 0x12]);
    assert_eq!((heard.problem, heard.answers()), (None, Some(asked)));
    assert_eq!(heard.request.unwrap().latency, core::time::Duration::from_millis(4));
    let heard = bus.group2(10, 3, &[0x41, 0x8E, 0x34, 0x12]);
    assert_eq!(heard.problem, Some(Problem::Flaw(Flaw::UnexpectedResponse)));
    assert_eq!(bus.node(10).traffic.last_latency, Some(core::time::Duration::from_millis(4)));
}

/// Both answer on the identifier of explicit responses.
#[test]
fn the_unconnected_port_and_the_connection_are_told_apart() {
    let mut bus = Bus::with_slave(10, 0x01);
    let connected = bus.group2(10, 4, &[0x01, 0x0E, 1, 1, 1]).n;
    let unconnected = bus.group2(10, 6, &[0x02, 0x4B, 3, 1, 1, 2]).n;
    let heard = bus.group2(10, 3, &[0x02, 0x94, 0x0C, 0x01]);
    assert_eq!((heard.kind, heard.answers()), (Kind::UnconnectedResponse, Some(unconnected)));
    assert_eq!(
        heard.text,
        "10 -> 2  Allocate: error 0x0C Object state conflict, another master owns the connection set  ! refused: \
         0x0C Object state conflict, another master owns the connection set"
    );
    let heard = bus.group2(10, 3, &[0x01, 0x8E, 0x34, 0x12]);
    assert_eq!((heard.kind, heard.answers()), (Kind::ExplicitResponse, Some(connected)));
    assert_eq!(bus.node(10).traffic.error_responses, 1);
}

#[test]
fn the_rules_of_the_header_and_of_the_identifier() {
    for (message, data, code) in [
        (4, &[0x0A, 0x0E, 1, 1, 1][..], "header_repeats_identifier"),
        (4, &[0x02, 0x0E, 1, 1, 1], "not_owner"),
        (4, &[0x01, 0x8E, 1, 1, 1], "response_bit_on_request"),
        (4, &[0x01], "too_short"),
        (4, &[], "too_short"),
        (4, &[0x01, 0x0E, 1], "too_short"),
        (4, &[0x01, 0x0E, 1, 1], "too_short"),
        (4, &[0x81], "too_short"),
        (4, &[0x81, 0x00], "too_short"),
        (4, &[0x81, 0x01, 1, 2, 3, 4, 5, 6], "first_fragment_not_zero"),
        (4, &[0x81, 0xC0, 0x02], "reserved_value"),
        (3, &[0x01, 0x0E, 1, 1, 1], "request_bit_on_response"),
        (3, &[0x01, 0x94, 0x08], "too_short"),
        (3, &[0x01, 0x94, 0x08, 0xFF, 0x00], "length"),
        (6, &[0x01, 0x0E, 1, 1, 1], "unexpected_service"),
        (6, &[0x81, 0x00, 0x4B, 3, 1, 1, 1], "fragment_not_allowed"),
        (6, &[0x01, 0xCB, 3, 1, 1, 1], "response_bit_on_request"),
        (6, &[0x01, 0x4B, 3, 1, 1], "too_short"),
        (6, &[0x01, 0x4B, 3, 1, 1, 1, 0], "length"),
        (6, &[0x01, 0x4B, 3, 1, 0x81, 1], "reserved_bits"),
        (6, &[0x01, 0x4B, 3, 1, 1, 0x41], "reserved_bits"),
        (6, &[0x01, 0x4C, 3, 1, 0x80], "reserved_bits"),
    ] {
        let mut bus = Bus::with_slave(10, 0x01);
        let heard = bus.group2(10, message, data);
        assert_eq!(heard.problem.map(|problem| problem.code()), Some(code), "{data:02X?}: {}", heard.text);
    }
}

#[test]
fn the_rules_of_ucmm() {
    for (message, data, code) in [
        (6, &[20, 0x0E, 1, 1, 1][..], "unexpected_service"),
        (6, &[20, 0xCB, 0, 0x31], "response_bit_on_request"),
        (6, &[20, 0x4B, 0], "too_short"),
        (6, &[20, 0x4B, 0, 0x31, 0], "length"),
        (6, &[20, 0x4B, 0xF0, 0x31], "reserved_bits"),
        (6, &[20, 0x4B, 0, 0x20], "reserved_value"),
        (6, &[20, 0x4B, 0, 0x35], "reserved_value"),
        (6, &[20, 0x4C, 7], "too_short"),
        (6, &[0x80 | 20, 0x4B, 0, 0x31], "fragment_not_allowed"),
        (6, &[2, 0x4B, 0, 0x31], "header_repeats_identifier"),
        (5, &[20, 0x94, 0x02, 0xFF], "open_refused"),
        (5, &[20, 0xCB, 0, 0, 0], "too_short"),
        (5, &[20, 0xCC, 0], "length"),
    ] {
        let mut bus = Bus::new();
        let heard = bus.group3(message, 2, data);
        assert_eq!(heard.problem.map(|problem| problem.code()), Some(code), "{data:02X?}: {}", heard.text);
    }
}

#[test]
fn a_node_ping_opens_nothing() {
    let mut bus = Bus::new();
    assert_eq!(bus.group3(6, 2, &[20, 0x4B, 0, 0xF0]).text, "2 -> 20  Open node ping");
    assert_eq!(bus.group3(5, 20, &[2, 0xCB, 0, 0, 0, 0]).problem, None);
    assert_eq!(bus.monitor.connections().count(), 0);
}

/// The body format in the response binds, whatever was asked for.
#[test]
fn every_body_format_is_read() {
    for (format, request) in [
        (0, &[20, 0x0E, 0x04, 0x65, 0x03][..]),
        (1, &[20, 0x0E, 0x04, 0x65, 0x00, 0x03]),
        (2, &[20, 0x0E, 0x04, 0x00, 0x65, 0x00, 0x03]),
        (3, &[20, 0x0E, 0x04, 0x00, 0x65, 0x03]),
        (4, &[20, 0x0E, 0x02, 0x20, 0x04, 0x24, 0x65, 0x03]),
    ] {
        let mut bus = Bus::new();
        bus.group3(6, 2, &[20, 0x4B, 0x02, 0x31]);
        bus.group3(5, 20, &[2, 0xCB, format, 0x02, 6, 0]);
        let heard = bus.group3(1, 2, request);
        assert_eq!(heard.text, "2 -> 20  Get_Attribute_Single Assembly 101 Data", "format {format}");
    }
}

/// Without the opening, the length of a Get_Attribute_Single suggests the format.
#[test]
fn a_body_format_that_was_not_seen_is_assumed() {
    let mut bus = Bus::new();
    let heard = bus.group3(1, 2, &[20, 0x0E, 0x04, 0x00, 0x65, 0x00, 0x03]);
    assert_eq!(heard.text, "2 -> 20  Get_Attribute_Single Assembly 101 Data (assumed)");
    let heard = bus.group3(2, 20, &[2, 0x8E, 1]);
    assert_eq!((heard.src, heard.dst, heard.problem), (Some(20), Some(2), None));
    assert_eq!(heard.text, "20 -> 2  Get_Attribute_Single: Data 01 (assumed)");
}

#[test]
fn fragments_out_of_order_lose_the_message() {
    let mut bus = Bus::with_slave(10, 0x01);
    bus.group2(10, 4, &[0x81, 0x00, 0x10, 4, 0x66, 3, 1, 2]);
    bus.group2(10, 3, &[0x81, 0xC0, 0]);
    let heard = bus.group2(10, 4, &[0x81, 0x42, 1, 2, 3, 4, 5, 6]);
    assert_eq!(heard.problem, Some(Problem::Flaw(Flaw::OutOfSequence { after: 0, found: 2 })));
    assert!(heard.text.ends_with("! fragment 2 after 0"), "{}", heard.text);
    let heard = bus.group2(10, 4, &[0x81, 0x83, 1]);
    assert_eq!(heard.message, None);
}

#[test]
fn a_fragment_that_goes_on_without_an_acknowledge() {
    let mut bus = Bus::with_slave(10, 0x01);
    bus.group2(10, 4, &[0x81, 0x00, 0x10, 4, 0x66, 3, 1, 2]);
    let heard = bus.group2(10, 4, &[0x81, 0x81, 3]);
    assert_eq!(heard.problem, Some(Problem::Flaw(Flaw::FragmentUnacknowledged { count: 0 })));
    assert_eq!(heard.message.as_deref(), Some(&[0x10, 4, 0x66, 3, 1, 2, 3][..]));
}

#[test]
fn the_identity_of_a_node_is_learned_from_its_answers() {
    let mut bus = Bus::with_slave(10, 0x01);
    for (attribute, value) in [
        (1, &[0x34, 0x12][..]),
        (2, &[0x07, 0x00]),
        (3, &[0x2A, 0x00]),
        (4, &[0x01, 0x02]),
        (6, &[0x45, 0x23, 0x00, 0x00]),
        (7, &[0x03, b'a', b'b', b'c']),
    ] {
        bus.group2(10, 4, &[0x01, 0x0E, 1, 1, attribute]);
        bus.group2(10, 3, &[&[0x01, 0x8E], value].concat());
    }
    let node = bus.node(10);
    assert_eq!(node.vendor.map(u16::from), Some(0x1234));
    assert_eq!((node.serial, node.product, node.revision), (Some(0x2345), Some(42), Some((1, 2))));
    assert_eq!(node.product_name, b"abc");
    assert_eq!(node.traffic.responses, 7);
}

/// A slave ignores a master that does not own it, and so does its watchdog.
#[test]
fn a_second_master_does_not_disturb_the_owner() {
    let mut bus = Bus::with_slave(10, 0x01);
    let asked = bus.group2(10, 4, &[0x01, 0x0E, 1, 1, 1]).n;
    let heard = bus.group2(10, 4, &[0x02, 0x0E, 1, 1, 2]);
    assert_eq!(heard.problem, Some(Problem::NotOwner { owner: mac(1) }));
    let heard = bus.group2(10, 3, &[0x01, 0x8E, 0x34, 0x12]);
    assert_eq!((heard.problem, heard.answers()), (None, Some(asked)));
    // The same between fragments.
    bus.group2(10, 4, &[0x81, 0x00, 0x10, 4, 0x66, 3, 1, 2]);
    bus.group2(10, 3, &[0x81, 0xC0, 0]);
    bus.group2(10, 4, &[0x82, 0x00, 0x10, 4, 0x66, 3, 1, 2]);
    let heard = bus.group2(10, 4, &[0x81, 0x81, 3]);
    assert_eq!((heard.problem, heard.message.is_some()), (None, true));
    assert_eq!(bus.group2(10, 3, &[0x81, 0xC1, 0]).problem, None);
    bus.wait(9_000).group2(10, 4, &[0x02, 0x0E, 1, 1, 2]);
    bus.wait(2_000);
    bus.group2(11, 4, &[0x01, 0x0E, 1, 1, 2]);
    assert_eq!(bus.state(10, Predefined::Explicit), ConnectionState::NonExistent);
}

/// A response to it shows that the set has changed hands unseen.
#[test]
fn a_second_master_that_is_answered_is_the_owner() {
    let mut bus = Bus::with_slave(10, 0x01);
    let asked = bus.group2(10, 4, &[0x02, 0x0E, 1, 1, 1]);
    assert_eq!(asked.problem, Some(Problem::NotOwner { owner: mac(1) }));
    assert_eq!(bus.group2(10, 3, &[0x02, 0x8E, 0x34, 0x12]).answers(), Some(asked.n));
    assert_eq!(bus.group2(10, 4, &[0x02, 0x0E, 1, 1, 1]).problem, None);
    assert_eq!(bus.node(10).master, Some(mac(2)));
}

/// Client 2 asks twice, with a free place before its first request.
#[test]
fn a_request_that_is_repeated_replaces_the_first() {
    let mut bus = Bus::new();
    bus.group2(10, 6, &[0x01, 0x4B, 3, 1, 1, 1]);
    bus.group2(10, 6, &[0x02, 0x4B, 3, 1, 1, 2]);
    bus.group2(10, 3, &[0x01, 0xCB, 0]);
    let repeated = bus.wait(1000).group2(10, 6, &[0x02, 0x4B, 3, 1, 1, 2]).n;
    assert_eq!(bus.group2(10, 3, &[0x02, 0x94, 0x0C, 0x01]).answers(), Some(repeated));
}

#[test]
fn an_acknowledge_that_never_comes_is_told_by_the_next_message() {
    let mut bus = Bus::with_slave(10, 0x01);
    bus.group2(10, 4, &[0x81, 0x00, 0x10, 4, 0x66, 3, 1, 2]);
    assert_eq!(bus.wait(500).group2(10, 4, &[0x01, 0x0E, 1, 1, 1]).problem, None, "given up in time");
    bus.group2(10, 4, &[0x81, 0x00, 0x10, 4, 0x66, 3, 1, 2]);
    let heard = bus.wait(1500).group2(10, 4, &[0x01, 0x0E, 1, 1, 1]);
    assert_eq!(heard.problem, Some(Problem::Flaw(Flaw::FragmentUnacknowledged { count: 0 })));
}

/// Message IDs that belong to others are not taken from them.
#[test]
fn a_ucmm_response_with_message_ids_that_are_not_assigned() {
    for (group, ids, code) in [
        (0x10, 0x65, Some("reserved_value")),
        (0x10, 0x46, Some("reserved_value")),
        (0x10, 0x44, Some("reserved_value")),
        (0x10, 0x45, None),
        (0x31, 0x05, Some("reserved_value")),
        (0x31, 0x12, Some("reserved_value")),
        (0x31, 0x02, None),
    ] {
        let mut bus = Bus::new();
        bus.group3(6, 2, &[20, 0x4B, 0, group]);
        let heard = bus.group3(5, 20, &[2, 0xCB, 0, ids, 6, 0]);
        assert_eq!(heard.problem.map(|problem| problem.code()), code, "{group:02X} {ids:02X}");
        assert_eq!(bus.monitor.connections().count(), usize::from(code.is_none()), "{group:02X} {ids:02X}");
    }
}

/// The master stays without its slave; a Get that asks in vain concerns nobody else.
#[test]
fn a_refused_allocation_is_a_problem_and_a_refused_get_is_none() {
    let mut bus = Bus::with_slave(10, 0x01);
    bus.group2(10, 4, &[0x01, 0x4B, 3, 1, 0x08, 1]);
    let heard = bus.group2(10, 3, &[0x01, 0x94, 0x02, 0x02]);
    assert_eq!(heard.problem.map(|problem| problem.code()), Some("allocation_refused"));
    bus.group2(10, 4, &[0x01, 0x0E, 1, 1, 99]);
    assert_eq!(bus.group2(10, 3, &[0x01, 0x94, 0x14, 0xFF]).problem, None);
}
