//! Explicit messages: on a connection and without one, complete and in fragments.

use super::*;
use cip_core::code::ServiceCode;

/// Message ID 0, as in the tables of [`crate::id`]: `10 000`, destination 67, R, source 1, F, X.
#[test]
fn a_request_and_its_response() {
    let mut bus = Bus::new();
    bus.connect(1, 67, &[0x4B, 0xD0, 1, 0, 0xC4, 0x09, 1], &[0x4B, 0xD0, 0x00, 0xC4, 0x09]);
    let asked = bus.extended(0x1086_0205, &[0x0E, 1, 1, 1]);
    assert_eq!((asked.kind, asked.problem, asked.assumed), (Kind::ExplicitRequest, None, false));
    assert_eq!(asked.text, "1 -> 67  Get_Attribute_Single Identity 1 Vendor ID");
    let heard = bus.extended(0x1003_8605, &[0x8E, 0x34, 0x12]);
    assert_eq!((heard.kind, heard.answers()), (Kind::ExplicitResponse, Some(asked.n)));
    assert_eq!(heard.text, "67 -> 1  Get_Attribute_Single: Vendor 4660");
    assert_eq!(bus.held(67, 1).last_latency, Some(core::time::Duration::from_millis(1)));
    assert_eq!(bus.node(67).traffic.last_latency, Some(core::time::Duration::from_millis(1)));
    bus.extended(0x1086_0206, &[0x10, 1, 1, 7, 0]);
    let heard = bus.extended(0x1003_8606, &[0x94, 0x0E, 0xFF]);
    assert_eq!(heard.text, "67 -> 1  Set_Attribute_Single: error 0x0E Attribute not settable");
    assert_eq!((heard.problem, bus.node(67).traffic.error_responses), (None, 1));
}

#[test]
fn without_a_connection_only_get_attribute_single_is_allowed() {
    let mut bus = Bus::new();
    let framing = Framing::Complete { transaction: 3 };
    let asked = bus.connectionless(1, 67, Direction::Request, framing, &[0x0E, 1, 1, 3]);
    assert_eq!(asked.text, "1 -> 67  connectionless Get_Attribute_Single Identity 1 Product code");
    assert_eq!((asked.kind, asked.assumed), (Kind::ConnectionlessRequest, false));
    let heard = bus.connectionless(1, 67, Direction::Response, framing, &[0x8E, 0x56, 0x04]);
    assert_eq!(heard.text, "67 -> 1  connectionless Get_Attribute_Single: Product code 1110");
    assert_eq!((heard.kind, heard.answers()), (Kind::ConnectionlessResponse, Some(asked.n)));
    let heard = bus.connectionless(1, 67, Direction::Request, framing, &[0x10, 1, 1, 3, 0]);
    let service = ServiceCode::SET_ATTRIBUTE_SINGLE;
    assert_eq!(heard.problem, Some(Flaw::UnexpectedService { service }.into()));
    let heard = bus.connectionless(1, 67, Direction::Response, framing, &[0x94, 0x08, 0xFF]);
    assert_eq!(heard.text, "67 -> 1  connectionless Set_Attribute_Single: error 0x08 Service not supported");
}

#[test]
fn a_long_value_comes_in_acknowledged_fragments() {
    let mut bus = Bus::new();
    let complete = Framing::Complete { transaction: 5 };
    let asked = bus.connectionless(1, 67, Direction::Request, complete, &[0x0E, 1, 1, 7]).n;
    // Type first, count 0; the transaction ID is the first byte.
    let first = Framing::Fragment(0x00.into());
    let heard =
        bus.connectionless(1, 67, Direction::Response, first, &[5, 0x8E, 8, b'G', b'R', b'T', b'1', b'-']);
    assert_eq!((heard.kind, heard.message, heard.assumed), (Kind::Fragment, None, false));
    assert_eq!(heard.text, "67 -> 1  first fragment 0  05 8E 08 47 52 54 31 2D");
    let ack = bus.connectionless(1, 67, Direction::Request, Framing::Fragment(0xC0.into()), &[0]);
    assert_eq!((ack.kind, ack.answers()), (Kind::FragmentAck, Some(heard.n)));
    assert_eq!(ack.text, "1 -> 67  acknowledge of fragment 0");
    let last = Framing::Fragment(0x81.into());
    let heard = bus.connectionless(1, 67, Direction::Response, last, b"DRT");
    assert_eq!(
        heard.text,
        "67 -> 1  last fragment 1 completes connectionless Get_Attribute_Single: Product name \"GRT1-DRT\""
    );
    assert_eq!((heard.problem, heard.answers()), (None, Some(asked)));
    assert_eq!(heard.message.as_deref(), Some(&b"\x8E\x08GRT1-DRT"[..]));
    assert_eq!(&bus.node(67).product_name[..], b"GRT1-DRT");
    let ack = bus.connectionless(1, 67, Direction::Request, Framing::Fragment(0xC1.into()), &[0]);
    assert_eq!(ack.answers(), Some(heard.n));
}

#[test]
fn the_rules_of_fragments() {
    let full = [5, 0x10, 4, 100, 3, 1, 2, 3];
    let run = |steps: &[(u8, bool, &[u8])]| {
        let mut bus = Bus::new();
        bus.connect(1, 67, &[0x4B, 0xD0, 1, 0, 0xC4, 0x09, 1], &[0x4B, 0xD0, 0x00, 0xC4, 0x09]);
        let mut last = None;
        for &(byte, is_ack, data) in steps {
            let direction = if is_ack { Direction::Response } else { Direction::Request };
            let framing = Framing::Fragment(byte.into());
            let id = Identifier::explicit(MessageId::default(), route(1, 67, direction), framing).unwrap();
            last = bus.frame(&id.frame(data).unwrap()).code();
        }
        last
    };
    assert_eq!(run(&[(0x00, false, &full), (0xC0, true, &[0]), (0x81, false, &[4])]), None);
    assert_eq!(run(&[(0x00, false, &full), (0x81, false, &[4])]), Some("fragment_unacknowledged"));
    assert_eq!(
        run(&[(0x00, false, &full), (0xC0, true, &[0]), (0x42, false, &full)]),
        Some("fragment_out_of_sequence")
    );
    assert_eq!(run(&[(0x01, false, &full)]), Some("first_fragment_not_zero"));
    assert_eq!(run(&[(0x00, false, &full), (0xC0, true, &[1])]), Some("fragment_refused"));
    assert_eq!(run(&[(0x00, false, &full), (0xC0, true, &[2])]), Some("reserved_value"));
    assert_eq!(run(&[(0x00, false, &full), (0xC0, true, &[])]), Some("length"));
    assert_eq!(run(&[(0x00, false, &full), (0xC3, true, &[0])]), Some("unknown_acknowledge"));
    // In the middle of a recording nothing of that is known.
    assert_eq!(run(&[(0x42, false, &full)]), None);
    assert_eq!(run(&[(0xC3, true, &[0])]), None);
    let mut bus = Bus::new();
    let heard = bus.connectionless(1, 67, Direction::Request, Framing::Fragment(0.into()), &full);
    assert_eq!(heard.code(), Some("fragment_not_allowed"));
}

#[test]
fn the_rules_of_explicit_messages() {
    for (direction, data, code) in [
        (Direction::Request, &[0x8E, 1, 1, 1][..], "response_bit_on_request"),
        (Direction::Request, &[], "too_short"),
        (Direction::Request, &[0x0E, 1], "too_short"),
        (Direction::Response, &[0x0E, 1, 1, 1], "request_bit_on_response"),
        (Direction::Response, &[], "too_short"),
        (Direction::Response, &[0x94, 8], "too_short"),
    ] {
        let heard = Bus::new().explicit(1, 67, direction, 1, data);
        assert_eq!(heard.code(), Some(code), "{data:02X?}: {}", heard.text);
    }
    let mut bus = Bus::new();
    bus.explicit(1, 67, Direction::Request, 1, &[0x0E, 1, 1, 1]);
    let heard = bus.explicit(1, 67, Direction::Response, 1, &[0x90]);
    assert_eq!(heard.code(), Some("service_mismatch"));
    assert_eq!(bus.explicit(127, 67, Direction::Request, 1, &[0x0E, 1, 1, 1]).code(), Some("no_address"));
}

/// The link object keeps class 3, with attributes of its own.
#[test]
fn the_link_object_has_its_own_words() {
    let mut bus = Bus::new();
    bus.connect(1, 67, &[0x4B, 0xD0, 1, 0, 0xC4, 0x09, 1], &[0x4B, 0xD0, 0x00, 0xC4, 0x09]);
    let heard = bus.explicit(1, 67, Direction::Request, 1, &[0x10, 3, 1, 1, 68]);
    assert_eq!(heard.text, "1 -> 67  Set_Attribute_Single DeviceNeX 1 Operational Address 68");
    bus.explicit(1, 67, Direction::Response, 1, &[0x90]);
    let heard = bus.explicit(1, 67, Direction::Request, 2, &[0x4B, 3, 1, 1]);
    assert_eq!(heard.text, "1 -> 67  service 0x4B DeviceNeX 1  01");
}

#[test]
fn an_explicit_connection_that_times_out_is_told() {
    let mut bus = Bus::new();
    bus.connect(1, 67, &[0x4B, 0xD0, 1, 0, 0x64, 0, 1], &[0x4B, 0xD0, 0x00, 0x64, 0]);
    bus.wait(401);
    let heard = bus.explicit(1, 67, Direction::Request, 1, &[0x0E, 1, 1, 1]);
    assert_eq!(heard.note, Some(Note::NoConnection(ConnectionState::NonExistent)));
    assert!(heard.assumed, "a frame could be missing");
}
