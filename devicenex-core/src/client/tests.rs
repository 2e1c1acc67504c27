//! Transactions over each port, and what goes wrong with them.

use std::string::{String, ToString};
use std::vec::Vec;

use cip_core::code::{AttributeId, ClassId, GeneralStatus, InstanceId};
use cip_core::message::{AttributeRequest, BodyFormat, Response};
use link_core::frame::extended_id;
use link_core::{Frame, TxOutcome};

use super::*;
use crate::id::{MessageId, OperationalAddress};
use crate::message::{ConnectionRequest, Granted, GroupSelect};

type Client = Conversation<32>;

fn oa(number: u8) -> OperationalAddress {
    OperationalAddress::new(number).unwrap()
}

fn message(number: u8) -> MessageId {
    MessageId::new(number).unwrap()
}

/// `1C860200: 0E 01 01 01`
#[track_caller]
fn frame(text: &str) -> Frame {
    let (id, data) = text.split_once(':').unwrap();
    let data: Vec<u8> = data.split_whitespace().map(|byte| u8::from_str_radix(byte, 16).unwrap()).collect();
    Frame::new(extended_id(u32::from_str_radix(id, 16).unwrap()), &data).unwrap()
}

#[track_caller]
fn sends(client: &mut Client, expected: &str) {
    let sent = client.poll().expect(expected);
    assert_eq!(sent, frame(expected), "{sent}");
    client.tx_done(TxOutcome::Sent);
}

fn result(progress: Progress<'_>) -> String {
    match progress {
        Progress::Response(response) => response.to_string(),
        other => std::format!("{other:?}"),
    }
}

#[track_caller]
fn hears(client: &mut Client, heard: &str, expected: &str) {
    assert_eq!(result(client.frame(&frame(heard))), expected, "{heard}");
}

/// Of OA 1 to OA 67.
fn connectionless() -> Client {
    Client::new(Route::connectionless(oa(1), oa(67)), Waits::UNCONNECTED)
}

fn explicit() -> Client {
    let route = Route::explicit(oa(1), oa(67), message(6), message(5), BodyFormat::Class8Instance8);
    Client::new(route.unwrap(), Waits::CONNECTED)
}

/// Class 11100: `11100 1000011 0 0000001 0` and the transaction; back `11100 0000001 1 1000011 0` and the same.
#[test]
fn a_connectionless_get() {
    let mut client = connectionless();
    let vendor = AttributeRequest::get(ClassId::IDENTITY, InstanceId(1), AttributeId(1));
    client.start_attribute(&vendor, 2).unwrap();
    sends(&mut client, "1C860200: 0E 01 01 01");
    assert_eq!(client.take_timer(), TimerChange::Set(Waits::UNCONNECTED.response));
    for (other, why) in [
        ("1C038800: 8E 34 12", "of OA 68"),
        ("1C058600: 8E 34 12", "to OA 2"),
        ("1C028600: 0E 01 01 01", "a request"),
        ("1D038600: 4B C0 00 64 00", "of the connection port"),
        ("16038600: 8E 34 12", "on a connection"),
    ] {
        assert_eq!(result(client.frame(&frame(other))), "NotMine", "{why}");
    }
    hears(&mut client, "1C038600: 8E 34 12", "Get_Attribute_Single ok, data 34 12");
    assert_eq!(client.take_timer(), TimerChange::Clear);
    // The next has the next transaction ID; after 255 comes 0.
    for transaction in (1..=255).chain([0]) {
        client.start_attribute(&vendor, 2).unwrap();
        sends(&mut client, &std::format!("1C8602{transaction:02X}: 0E 01 01 01"));
        hears(
            &mut client,
            &std::format!("1C0386{transaction:02X}: 94 08 FF"),
            "error 0x08 Service not supported",
        );
    }
}

#[test]
fn what_is_not_the_answer_is_ignored() {
    let mut client = connectionless();
    hears(&mut client, "1C038600: 8E 34 12", "Ignored(Unexpected)");
    client.start_body(&[0x0E, 1, 1, 1], 2).unwrap();
    hears(&mut client, "1C038600: 8E 34 12", "Ignored(Unexpected)");
    sends(&mut client, "1C860200: 0E 01 01 01");
    hears(&mut client, "1C0386FF: 8E 34 12", "Ignored(Stale)");
    hears(&mut client, "1C038600: 90", "Ignored(OtherService)");
    hears(&mut client, "1C038600: 0E 34 12", "Ignored(Malformed)");
    hears(&mut client, "1C038600:", "Ignored(Malformed)");
    hears(&mut client, "1C038741: 34 12", "Ignored(OutOfSequence)");
    hears(&mut client, "1C0387C0: 00", "Ignored(Unexpected)");
    let remote = Frame::remote(extended_id(0x1C03_8600), 8).unwrap();
    assert_eq!(client.frame(&remote), Progress::NotMine);
    assert!(client.is_busy());
}

/// The identifier of the request is the same, so a late answer to the first try is an answer.
#[test]
fn a_request_is_repeated_and_then_given_up() {
    let mut client = connectionless();
    client.start_body(&[0x0E, 1, 1, 1], 3).unwrap();
    for _ in 0..2 {
        sends(&mut client, "1C860200: 0E 01 01 01");
        assert_eq!(client.timer_expired(), None);
    }
    sends(&mut client, "1C860200: 0E 01 01 01");
    assert_eq!(client.timer_expired(), Some(Failure::NoResponse));
    hears(&mut client, "1C038600: 8E 34 12", "Ignored(Unexpected)");
}

/// Class 11101. The response has the service of the request, and R tells it apart.
#[test]
fn connections_are_asked_for() {
    let mut client = Client::new(Route::connection(oa(1), oa(67)), Waits::UNCONNECTED);
    let asked = explicit_request(message(6), 2500);
    client.start_message(&asked, 1).unwrap();
    sends(&mut client, "1D860200: 4B D6 01 00 C4 09 01");
    hears(&mut client, "1D038601: 4B D5 00 C4 09", "Ignored(Stale)");
    let answer = frame("1D038600: 4B D5 00 C4 09");
    let Progress::Response(response) = client.frame(&answer) else { panic!() };
    let granted = connection_response(&asked, &response).unwrap();
    assert_eq!(granted.granted, Granted::Predefined { expected_packet_rate: 2500 });
    let route = Route::opened(oa(1), oa(67), &asked, &granted).unwrap();
    assert_eq!(
        Some(route),
        Route::explicit(oa(1), oa(67), message(6), message(5), BodyFormat::Class8Instance8)
    );

    client.start_message(&asked, 1).unwrap();
    sends(&mut client, "1D860201: 4B D6 01 00 C4 09 01");
    let refused = frame("1D038601: 94 02 FF");
    let Progress::Response(response) = client.frame(&refused) else { panic!() };
    assert!(matches!(response, Response::Error { status: GeneralStatus::RESOURCE_UNAVAILABLE, .. }));
    assert_eq!(connection_response(&asked, &response), None);
}

#[test]
fn an_answer_must_go_with_its_request() {
    let asked = explicit_request(message(6), 2500);
    let answer = |data| connection_response(&asked, &Response::Success { service: asked_service(), data });
    assert!(answer(&[0xD5, 0x00, 0xC4, 0x09]).is_some());
    assert_eq!(answer(&[0x55, 0x00, 0x80, 0x00]), None, "a dynamic connection");
    assert_eq!(answer(&[0xD5, 0x00, 0xC4]), None, "short");
    assert_eq!(answer(&[0xD5, 0x00, 0xC4, 0x09, 0x00]), None, "long");
    let opened = |data| Route::opened(oa(1), oa(67), &asked, &answer(data).unwrap());
    assert_eq!(opened(&[0xC5, 0x00, 0xC4, 0x09]), None, "implicit");
    assert_eq!(opened(&[0xD8, 0x00, 0xC4, 0x09]), None, "there is no explicit message 8");
    assert_eq!(opened(&[0xD5, 0x0F, 0xC4, 0x09]), None, "a reserved body format");
    let implicit = ConnectionRequest { group: GroupSelect::IMPLICIT_29, ..asked };
    let granted = answer(&[0xD5, 0x00, 0xC4, 0x09]).unwrap();
    assert_eq!(Route::opened(oa(1), oa(67), &implicit, &granted), None);
}

fn asked_service() -> cip_core::code::ServiceCode {
    cip_core::code::ServiceCode::ALLOCATE
}

/// Nine bytes: seven behind the transaction ID, two in the last. Eight need no fragments.
#[test]
fn a_long_request_is_cut() {
    let mut client = explicit();
    client.start_body(&[0x10, 5, 13, 5, 0x78, 0x56, 0x34, 0x92], 1).unwrap();
    sends(&mut client, "16860200: 10 05 0D 05 78 56 34 92");
    hears(&mut client, "15038600: 90", "Set_Attribute_Single ok");

    client.start_body(&[0x10, 5, 13, 0, 5, 0x78, 0x56, 0x34, 0x92], 1).unwrap();
    sends(&mut client, "16860300: 01 10 05 0D 00 05 78 56");
    assert_eq!(client.take_timer(), TimerChange::Set(Waits::CONNECTED.acknowledge));
    hears(&mut client, "150387C1: 00", "Ignored(OtherAcknowledge)");
    hears(&mut client, "150387C0: 00", "Pending");
    sends(&mut client, "16860381: 34 92");
    hears(&mut client, "150387C1: 00", "Pending");
    assert_eq!(client.take_timer(), TimerChange::Set(Waits::CONNECTED.response));
    hears(&mut client, "15038601: 90", "Set_Attribute_Single ok");

    // Too much for the server.
    client.start_body(&[0; 20], 1).unwrap();
    sends(&mut client, "16860300: 02 00 00 00 00 00 00 00");
    hears(&mut client, "150387C0: 01", "Failed(RequestTooLong)");
    // A fragment that nobody acknowledges is repeated once.
    client.start_body(&[0; 20], 1).unwrap();
    for _ in 0..2 {
        sends(&mut client, "16860300: 03 00 00 00 00 00 00 00");
        let last = client.timer_expired();
        assert!(last.is_none() || last == Some(Failure::NotAcknowledged));
    }
    assert!(!client.is_busy());
}

#[test]
fn a_long_response_is_put_together() {
    let mut client = connectionless();
    client.start_body(&[0x0E, 1, 1, 7], 1).unwrap();
    sends(&mut client, "1C860200: 0E 01 01 07");
    // Of an earlier transaction.
    hears(&mut client, "1C038700: FF 8E 10 45 78 61 6D 70", "Ignored(Stale)");
    hears(&mut client, "1C038700: 00 8E 10 45 78 61 6D 70", "Pending");
    sends(&mut client, "1C8603C0: 00");
    assert_eq!(client.take_timer(), TimerChange::Set(Waits::UNCONNECTED.next_fragment));
    hears(&mut client, "1C038741: 6C 65 20 64 65 76 69 63", "Pending");
    sends(&mut client, "1C8603C1: 00");
    // The acknowledge was lost.
    hears(&mut client, "1C038741: 6C 65 20 64 65 76 69 63", "Pending");
    sends(&mut client, "1C8603C1: 00");
    hears(
        &mut client,
        "1C038782: 65 73",
        "Get_Attribute_Single ok, data 10 45 78 61 6D 70 6C 65 20 64 65 76 69 63 65 73",
    );
    sends(&mut client, "1C8603C2: 00");
    hears(&mut client, "1C038782: 65 73", "Pending");
    sends(&mut client, "1C8603C2: 00");

    // More than the client can hold: it says so.
    client.start_body(&[0x0E, 1, 1, 7], 1).unwrap();
    sends(&mut client, "1C860201: 0E 01 01 07");
    hears(&mut client, "1C038700: 01 8E 01 02 03 04 05 06", "Pending");
    sends(&mut client, "1C8603C0: 00");
    for count in 1..=3 {
        hears(&mut client, &std::format!("1C0387{:02X}: 01 02 03 04 05 06 07 08", 0x40 | count), "Pending");
        sends(&mut client, &std::format!("1C8603{:02X}: 00", 0xC0 | count));
    }
    hears(&mut client, "1C038784: 01 02 03 04", "Failed(ResponseTooLong)");
    sends(&mut client, "1C8603C4: 01");
}

/// A message is cut into frames that put it together again: two conversations would say the same.
#[test]
fn every_length_is_cut_without_a_gap() {
    use cip_core::client::Channel;
    let body: Vec<u8> = (0..=255).collect();
    for len in 8..=body.len() {
        let body = &body[..len];
        let parts: Vec<_> = (0..).map_while(|index| Route::cut(body, index)).collect();
        assert_eq!(parts.iter().flat_map(|part| part.data).copied().collect::<Vec<_>>(), body);
        assert_eq!(Route::is_fragmented(body), len > 8);
    }
}
