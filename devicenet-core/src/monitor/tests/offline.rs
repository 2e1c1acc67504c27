//! The offline connection set, and identifiers that are not DeviceNet's.

use super::*;
use link_core::{Frame, frame::extended_id};

#[test]
fn a_tool_finds_and_repairs_a_faulted_node() {
    let mut bus = Bus::new();
    bus.group2(10, 7, &[0x00, 0x06, 0x00, 0x08, 0x07, 0x06, 0x05]);
    let heard = bus.frame(0x7EF, &[0x01, 0x4B, 0x24, 0x00, 0x01, 0x00, 0x00, 0x00]);
    assert_eq!(heard.text, "offline ownership request  tool 1  vendor 36 serial 0x00000001");
    let asked = heard.n;
    let heard = bus.frame(0x7EE, &[0x02, 0xCB, 0x24, 0x00, 0x02, 0x00, 0x00, 0x00]);
    assert_eq!(heard.answers(), Some(asked));
    let who = bus.frame(0x7ED, &[0x3F, 0x4B, 0x03]);
    assert_eq!(who.text, "offline Who  all nodes, delay by byte 3");
    let heard = bus.wait(80).frame(0x7EC, &[0x00, 0x06, 0x00, 0x08, 0x07, 0x06, 0x05]);
    assert_eq!(heard.text, "offline Who response  vendor 6 serial 0x05060708");
    assert_eq!((heard.src, heard.answers()), (Some(10), Some(who.n)), "its check has told the MAC ID");
    assert_eq!(bus.node(10).access, AccessState::Faulted);
    let heard = bus.frame(0x7ED, &[0x4A, 0x4C]);
    assert_eq!(heard.text, "offline Identify  MAC ID 10");
    assert_eq!((who.dst, heard.dst), (None, Some(10)), "all nodes, and one");
    let answer = bus.frame(0x7EC, &[0x4A, 0xCC]);
    assert_eq!((answer.answers(), answer.src), (Some(heard.n), Some(10)));
    let heard = bus.frame(0x7ED, &[0x03, 0x4D, 0x06, 0x00, 0x08, 0x07, 0x06, 0x05]);
    assert_eq!(heard.text, "offline Change_MAC_ID  to 3  vendor 6 serial 0x05060708");
    assert_eq!((heard.problem, heard.dst), (None, Some(10)));
    assert!(bus.node(1).roles.contains(Roles::TOOL));
}

#[test]
fn what_a_faulted_node_ignores_is_wrong() {
    let mut bus = Bus::new();
    for (id, data, code) in [
        (0x7ED, &[0x3F, 0x4B, 0x07][..], "reserved_value"),
        (0x7ED, &[0xBF, 0x4B, 0x03], "reserved_value"),
        (0x7ED, &[0x3F, 0x4B], "too_short"),
        (0x7ED, &[0x3F, 0x4B, 0x03, 0x00], "length"),
        (0x7ED, &[0x3F, 0x4E], "reserved_value"),
        (0x7ED, &[0x3F, 0xCC], "response_bit_on_request"),
        (0x7EF, &[0x01, 0xCB, 0, 0, 0, 0, 0, 0], "response_bit_on_request"),
        (0x7EE, &[0x01, 0x4B, 0, 0, 0, 0, 0, 0], "request_bit_on_response"),
        (0x7EF, &[0x41, 0x4B, 0, 0, 0, 0, 0, 0], "reserved_value"),
        (0x7EC, &[0x80, 0, 0, 0, 0, 0, 0], "reserved_value"),
        (0x7C0, &[], "reserved_identifier"),
        (0x7F0, &[], "invalid_identifier"),
        (0x7FF, &[], "invalid_identifier"),
    ] {
        assert_eq!(
            bus.frame(id, data).problem.map(|problem| problem.code()),
            Some(code),
            "{id:03X} {data:02X?}"
        );
    }
}

#[test]
fn a_frame_with_29_bits_is_foreign() {
    let mut monitor = Box::new(Monitor::new(MonitorConfig::default()));
    let frame = Frame::new(extended_id(0x123), &[1]).unwrap();
    let reading = monitor.observe(Instant::ZERO, 1, &frame);
    assert_eq!((reading.kind, reading.group), (Kind::Foreign, None));
    assert_eq!(reading.problem, Some(Problem::ExtendedIdentifier));
    assert_eq!(monitor.nodes().count(), 0);
}

#[test]
fn a_faulted_node_is_known_by_the_mac_id_that_it_had_last() {
    const DEVICE: [u8; 7] = [0x00, 0x06, 0x00, 0x08, 0x07, 0x06, 0x05];
    let mut bus = Bus::new();
    bus.group2(10, 7, &DEVICE);
    bus.wait(5000).group2(20, 7, &DEVICE);
    assert_eq!(bus.frame(0x7EC, &DEVICE).src, Some(20));
    assert_eq!(bus.node(10).access, AccessState::OffLine);
}

/// The newcomer has lost its MAC ID to the node that has answered: that one is on line.
#[test]
fn a_twin_that_answers_to_who_is_not_the_node_that_has_the_mac_id() {
    const TWIN: [u8; 7] = [0x00, 0x77, 0x00, 0x04, 0x03, 0x02, 0x01];
    let mut bus = Bus::with_slave(10, 0x01);
    bus.group2(10, 7, &[0x00, 0x34, 0x12, 0x45, 0x23, 0x00, 0x00]);
    bus.group2(10, 7, &TWIN);
    bus.group2(10, 7, &[0x80, 0x34, 0x12, 0x45, 0x23, 0x00, 0x00]);
    assert_eq!(bus.frame(0x7EC, &TWIN).src, Some(10));
    assert_eq!(bus.node(10).access, AccessState::OnLine);
    assert_eq!(bus.node(10).serial, Some(0x2345));
}

#[test]
fn a_data_length_code_above_eight_is_eight_bytes_with_a_problem() {
    let mut monitor = Box::new(Monitor::new(MonitorConfig::default()));
    let id = link_core::frame::standard_id(0x455);
    let reading = monitor.observe(Instant::ZERO, 1, &Frame::with_dlc(id, 9, [7; 8]).unwrap());
    assert_eq!(reading.problem, Some(Problem::Flaw(Flaw::DataLengthCode { dlc: 9 })));
    assert_eq!(reading.value(), Some(&[7; 8][..]));
    assert_eq!(monitor.observe(Instant::ZERO, 2, &Frame::new(id, &[7; 8]).unwrap()).problem, None);
}
