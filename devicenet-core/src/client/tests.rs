//! The transactions of the specification's examples and of recordings, and what goes wrong with them.

use std::string::{String, ToString};
use std::vec::Vec;

use cip_core::code::{ClassId, GeneralStatus, InstanceId, ServiceCode};
use cip_core::message::{BodyFormat, Request, Response};
use link_core::{Frame, TxOutcome};

use super::*;
use crate::id::{Identifier, MacId};
use crate::message::{FormatByte, GroupSelect, MessageId, OpenRequest, OpenResponse};

type Client = Conversation<32>;

fn mac(number: u8) -> MacId {
    MacId::new(number).unwrap()
}

/// `5FC: 04 0E 01 01 01`, as the specification prints frames.
#[track_caller]
fn frame(text: &str) -> Frame {
    let (id, data) = text.split_once(':').unwrap();
    let data: Vec<u8> = data.split_whitespace().map(|byte| u8::from_str_radix(byte, 16).unwrap()).collect();
    Identifier::new(u16::from_str_radix(id, 16).unwrap()).unwrap().frame(&data).unwrap()
}

/// What the client sends next, which is on the bus at once.
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

fn predefined(client: u8, server: u8) -> Client {
    let route = Route::predefined(mac(client), mac(server), BodyFormat::Class8Instance8);
    Client::new(route, Waits::CONNECTED)
}

#[track_caller]
fn start(client: &mut Client, body: &[u8]) {
    client.start_body(body, 2).unwrap();
}

/// The worked trace of master 4 and slave 63: the transaction ID alternates.
#[test]
fn requests_of_one_frame() {
    let mut client = predefined(4, 63);
    let request =
        |data| Request::new(ServiceCode::GET_ATTRIBUTE_SINGLE, ClassId::IDENTITY, InstanceId(1), data);
    client.start(&request(&[1]), 2).unwrap();
    assert_eq!(client.start(&request(&[1]), 2), Err(StartError::Busy));
    sends(&mut client, "5FC: 04 0E 01 01 01");
    assert_eq!(client.take_timer(), TimerChange::Set(Waits::CONNECTED.response));
    hears(&mut client, "5FB: 04 8E E7 03", "Get_Attribute_Single ok, data E7 03");
    assert_eq!(client.take_timer(), TimerChange::Clear);
    client.start(&request(&[2]), 2).unwrap();
    sends(&mut client, "5FC: 44 0E 01 01 02");
    hears(&mut client, "5FB: 44 8E 07 00", "Get_Attribute_Single ok, data 07 00");
    assert!(!client.is_busy());
}

/// The specification's example of a Set of six bytes: two fragments, each acknowledged.
#[test]
fn a_long_request_is_cut() {
    let mut client = predefined(4, 63);
    start(&mut client, &[0x10, 0x04, 0x66, 0x03, 1, 2, 3, 4, 5, 6]);
    sends(&mut client, "5FC: 84 00 10 04 66 03 01 02");
    assert_eq!(client.take_timer(), TimerChange::Set(Waits::CONNECTED.acknowledge));
    hears(&mut client, "5FB: 84 C0 00", "Pending");
    sends(&mut client, "5FC: 84 81 03 04 05 06");
    hears(&mut client, "5FB: 84 C1 00", "Pending");
    assert_eq!(client.take_timer(), TimerChange::Set(Waits::CONNECTED.response));
    hears(&mut client, "5FB: 04 90", "Set_Attribute_Single ok");
}

/// Konvolucio.DeviceNet unit-test logs: the product name of an Omron GRT1-DRT at MAC ID 2, read by master 0.
#[test]
fn a_long_response_is_put_together() {
    let mut client = predefined(0, 2);
    start(&mut client, &[0x0E, 0x01, 0x01, 0x07]);
    sends(&mut client, "414: 00 0E 01 01 07");
    hears(&mut client, "413: 80 00 8E 08 47 52 54 31", "Pending");
    sends(&mut client, "414: 80 C0 00");
    assert_eq!(client.take_timer(), TimerChange::Set(Waits::CONNECTED.next_fragment));
    let last = frame("413: 80 81 2D 44 52 54");
    let Progress::Response(Response::Success { data, .. }) = client.frame(&last) else { panic!() };
    assert_eq!(data, b"\x08GRT1-DRT");
    sends(&mut client, "414: 80 C1 00");
    // The acknowledge is lost, so the slave repeats the last fragment: acknowledged again, for one second.
    hears(&mut client, "413: 80 81 2D 44 52 54", "Pending");
    sends(&mut client, "414: 80 C1 00");
    assert_eq!(client.timer_expired(), None);
    hears(&mut client, "413: 80 81 2D 44 52 54", "Ignored(Unexpected)");
    assert_eq!(client.poll(), None);
}

/// IAI controller capture: master 0, slave 63, the connection opened with Message IDs 4 on both sides, format 16/16.
#[test]
fn a_connection_that_the_ucmm_opened() {
    let asked = OpenRequest {
        xid: false,
        server: mac(63),
        body_format: FormatByte(2),
        group: GroupSelect::GROUP_3,
        source_message: MessageId::new(4).unwrap(),
    };
    let answer = OpenResponse {
        xid: false,
        client: mac(0),
        body_format: FormatByte(2),
        destination_message: MessageId::new(0).unwrap(),
        source_message: MessageId::new(4).unwrap(),
        connection: InstanceId(6),
    };
    let route = Route::opened(mac(0), &asked, &answer).unwrap();
    let mut client = Client::new(route, Waits::CONNECTED);
    let request = Request::new(ServiceCode::GET_ATTRIBUTE_SINGLE, ClassId::IDENTITY, InstanceId(1), &[1]);
    client.start(&request, 1).unwrap();
    sends(&mut client, "700: 3F 0E 01 00 01 00 01");
    hears(&mut client, "73F: 00 8E BB 02", "Get_Attribute_Single ok, data BB 02");
    // The same capture: EPR := 75 ms, in fragments whose headers name the server; the acknowledge names the client.
    start(&mut client, &[0x10, 0x05, 0x00, 0x02, 0x00, 0x09, 0x4B, 0x00]);
    sends(&mut client, "700: FF 00 10 05 00 02 00 09");
    hears(&mut client, "73F: C0 C0 00", "Pending");
    sends(&mut client, "700: FF 81 4B 00");
}

/// The worked example of the UCMM: client 2, server 20, Group 3, Message IDs 1 and 2.
#[test]
fn the_ucmm_itself() {
    let mut client = Client::new(Route::ucmm(mac(2), mac(20)), Waits::UNCONNECTED);
    start(&mut client, &[0x4B, 0x00, 0x31]);
    sends(&mut client, "782: 14 4B 00 31");
    hears(&mut client, "754: 02 CB 00 02 07 00", "service 0x4B ok, data 00 02 07 00");
}

#[test]
fn reserved_answers_open_no_route() {
    let asked = |group, source| OpenRequest {
        xid: false,
        server: mac(20),
        body_format: FormatByte(0),
        group,
        source_message: MessageId::new(source).unwrap(),
    };
    let answer = |format, destination, source| OpenResponse {
        xid: false,
        client: mac(2),
        body_format: FormatByte(format),
        destination_message: MessageId::new(destination).unwrap(),
        source_message: MessageId::new(source).unwrap(),
        connection: InstanceId(6),
    };
    let route = |asked, answer| Route::opened(mac(2), &asked, &answer);
    let in_group_2 = route(asked(GroupSelect::GROUP_2, 0), answer(0, 1, 2)).unwrap();
    assert_eq!((in_group_2.request().raw(), in_group_2.response().raw()), (0x4A1, 0x4A2));
    assert_eq!(route(asked(GroupSelect::GROUP_2, 0), answer(0, 2, 2)), None, "the same Message ID twice");
    assert_eq!(route(asked(GroupSelect::GROUP_2, 0), answer(0, 6, 2)), None, "the unconnected port");
    assert_eq!(route(asked(GroupSelect::GROUP_3, 5), answer(0, 0, 2)), None, "the UCMM");
    assert_eq!(route(asked(GroupSelect::GROUP_1, 1), answer(0, 0, 0xC)), None, "a predefined connection");
    assert_eq!(route(asked(GroupSelect::GROUP_3, 1), answer(7, 0, 2)), None, "a reserved body format");
    assert_eq!(route(asked(GroupSelect::NODE_PING, 0), answer(0, 0, 0)), None, "nothing was opened");
}

#[test]
fn what_is_not_the_answer_is_ignored() {
    let mut client = predefined(4, 63);
    hears(&mut client, "5FB: 04 8E E7 03", "Ignored(Unexpected)");
    start(&mut client, &[0x0E, 0x01, 0x01, 0x01]);
    hears(&mut client, "5FB: 04 8E E7 03", "Ignored(Unexpected)");
    sends(&mut client, "5FC: 04 0E 01 01 01");
    hears(&mut client, "5FB: 05 8E E7 03", "NotMine");
    hears(&mut client, "5F3: 04 8E E7 03", "NotMine");
    hears(&mut client, "5FB: 3F CD 01 00 03 00 00 00", "NotMine");
    hears(&mut client, "5FB:", "NotMine");
    hears(&mut client, "5FB: 04", "Ignored(Malformed)");
    hears(&mut client, "5FB: 84", "Ignored(Malformed)");
    hears(&mut client, "5FB: 04 0E 01 01 01", "Ignored(Malformed)");
    hears(&mut client, "5FB: 44 8E E7 03", "Ignored(Stale)");
    hears(&mut client, "5FB: C4 00 8E 01 02 03 04 05", "Ignored(Stale)");
    hears(&mut client, "5FB: 04 90", "Ignored(OtherService)");
    hears(&mut client, "5FB: 84 C0 00", "Ignored(Unexpected)");
    hears(&mut client, "5FB: 84 41 01", "Ignored(OutOfSequence)");
    hears(&mut client, "5FB: 04 94 16 FF", "error 0x16 Object does not exist");
}

#[test]
fn a_lost_response_is_asked_for_again_with_the_same_transaction_id() {
    let mut client = predefined(4, 63);
    start(&mut client, &[0x0E, 0x01, 0x01, 0x01]);
    sends(&mut client, "5FC: 04 0E 01 01 01");
    assert_eq!(client.timer_expired(), None);
    // The answer to the first attempt arrives before the second is sent.
    hears(&mut client.clone(), "5FB: 04 8E E7 03", "Get_Attribute_Single ok, data E7 03");
    sends(&mut client, "5FC: 04 0E 01 01 01");
    assert_eq!(client.timer_expired(), Some(Failure::NoResponse));
    assert_eq!((client.poll(), client.is_busy()), (None, false));
}

#[test]
fn a_fragment_is_repeated_once() {
    let mut client = predefined(4, 63);
    start(&mut client, &[0x10, 0x04, 0x66, 0x03, 1, 2, 3, 4, 5, 6]);
    sends(&mut client, "5FC: 84 00 10 04 66 03 01 02");
    hears(&mut client, "5FB: 84 C1 00", "Ignored(OtherAcknowledge)");
    hears(&mut client, "5FB: C4 C0 00", "Ignored(Stale)");
    assert_eq!(client.timer_expired(), None);
    // The acknowledge of the first transmission comes late: the repetition is not needed.
    let mut late = client.clone();
    hears(&mut late, "5FB: 84 C0 00", "Pending");
    sends(&mut late, "5FC: 84 81 03 04 05 06");
    // The last acknowledge is lost, the response is not.
    hears(&mut late, "5FB: 04 90", "Set_Attribute_Single ok");
    sends(&mut client, "5FC: 84 00 10 04 66 03 01 02");
    assert_eq!(client.timer_expired(), Some(Failure::NotAcknowledged));
}

#[test]
fn no_response_before_the_last_fragment() {
    let mut client = predefined(4, 63);
    start(&mut client, &[0x10, 0x04, 0x66, 0x03, 1, 2, 3, 4, 5, 6]);
    sends(&mut client, "5FC: 84 00 10 04 66 03 01 02");
    hears(&mut client, "5FB: 04 90", "Ignored(Unexpected)");
}

#[test]
fn too_much_data_either_way() {
    for status in ["01", "02"] {
        let mut client = predefined(4, 63);
        start(&mut client, &[0x10, 0x04, 0x66, 0x03, 1, 2, 3, 4, 5, 6]);
        sends(&mut client, "5FC: 84 00 10 04 66 03 01 02");
        hears(&mut client, &std::format!("5FB: 84 C0 {status}"), "Failed(RequestTooLong)");
        assert!(!client.is_busy());
    }
    let mut client = predefined(4, 63);
    start(&mut client, &[0x0E, 0x01, 0x01, 0x07]);
    sends(&mut client, "5FC: 04 0E 01 01 07");
    hears(&mut client, "5FB: 84 00 8E 30 01 02 03 04", "Pending");
    sends(&mut client, "5FC: 84 C0 00");
    for count in 1..5 {
        hears(&mut client, &std::format!("5FB: 84 {:02X} 01 02 03 04 05 06", 0x40 + count), "Pending");
        sends(&mut client, &std::format!("5FC: 84 {:02X} 00", 0xC0 + count));
    }
    hears(&mut client, "5FB: 84 45 01 02 03 04 05 06", "Failed(ResponseTooLong)");
    sends(&mut client, "5FC: 84 C5 01");
    assert_eq!(client.start_body(&[0; 33], 1), Err(StartError::TooLong { capacity: 32 }));
    assert_eq!(client.start_body(&[], 1), Err(StartError::Empty));
}

#[test]
fn a_fragmented_response_must_be_the_answer() {
    let mut client = predefined(4, 63);
    start(&mut client, &[0x0E, 0x01, 0x01, 0x07]);
    sends(&mut client, "5FC: 04 0E 01 01 07");
    hears(&mut client, "5FB: 84 00 90 01 02 03 04 05", "Pending");
    sends(&mut client, "5FC: 84 C0 00");
    hears(&mut client, "5FB: 84 81 06", "Failed(Malformed)");
}

#[test]
fn what_was_cancelled_stays_in_flight_until_it_is_done() {
    let mut client = predefined(4, 63);
    start(&mut client, &[0x0E, 0x01, 0x01, 0x01]);
    assert!(client.poll().is_some());
    client.cancel();
    assert!(client.is_in_flight() && !client.is_busy());
    start(&mut client, &[0x0E, 0x01, 0x01, 0x02]);
    assert_eq!((client.poll(), client.has_output()), (None, false));
    client.tx_done(TxOutcome::Withdrawn);
    assert_eq!(client.take_timer(), TimerChange::Clear, "the withdrawn frame starts no wait");
    sends(&mut client, "5FC: 44 0E 01 01 02");
    hears(&mut client, "5FB: 04 8E E7 03", "Ignored(Stale)");
}

/// A request to a class above 255 needs another body format.
#[test]
fn an_address_that_the_format_cannot_express() {
    let mut client = predefined(4, 63);
    let request = Request::new(ServiceCode::GET_ATTRIBUTE_SINGLE, ClassId(0x300), InstanceId(1), &[1]);
    let error = client.start(&request, 1).unwrap_err();
    assert!(matches!(error, StartError::NotAddressable(_)), "{error}");
    assert!(!client.is_busy());
}

#[test]
fn an_error_is_always_an_answer() {
    let mut client = predefined(4, 63);
    start(&mut client, &[0x4B, 0x03, 0x01, 0x01, 0x04]);
    sends(&mut client, "5FC: 04 4B 03 01 01 04");
    let refused = frame("5FB: 04 94 0C 01");
    let Progress::Response(Response::Error { status, additional }) = client.frame(&refused) else { panic!() };
    assert_eq!((status, additional.0), (GeneralStatus::OBJECT_STATE_CONFLICT, 1));
}

/// The acknowledge of the last fragment goes out first, and is that of its own transaction and connection, whatever
/// begins meanwhile.
#[test]
fn the_last_acknowledge_outlives_its_transaction() {
    for rerouted in [false, true] {
        let mut client = predefined(0, 2);
        start(&mut client, &[0x0E, 0x01, 0x01, 0x07]);
        sends(&mut client, "414: 00 0E 01 01 07");
        hears(&mut client, "413: 80 00 8E 08 47 52 54 31", "Pending");
        sends(&mut client, "414: 80 C0 00");
        assert!(matches!(client.frame(&frame("413: 80 81 2D 44 52 54")), Progress::Response(_)));
        if rerouted {
            client.reroute(Route::ucmm(mac(0), mac(2)), Waits::UNCONNECTED);
        }
        start(&mut client, &[0x4C, 0x06, 0x00]);
        sends(&mut client, "414: 80 C1 00");
        sends(&mut client, if rerouted { "780: 42 4C 06 00" } else { "414: 40 4C 06 00" });
    }
}

/// Fragments that were there already do not prolong the wait, so that a server that begins again and again does not hold
/// the client for ever.
#[test]
fn only_new_fragments_are_waited_for() {
    let mut client = predefined(0, 2);
    start(&mut client, &[0x0E, 0x01, 0x01, 0x07]);
    sends(&mut client, "414: 00 0E 01 01 07");
    let mut waits = Vec::new();
    for fragment in ["00", "41", "41", "00", "41", "42"] {
        let _ = client.take_timer();
        hears(&mut client, &std::format!("413: 80 {fragment} 8E 08 47 52 54 31"), "Pending");
        sends(
            &mut client,
            &std::format!("414: 80 {:02X} 00", 0xC0 | u8::from_str_radix(fragment, 16).unwrap()),
        );
        waits.push(client.take_timer() != TimerChange::Keep);
    }
    assert_eq!(waits, [true, true, false, false, false, true]);
}

/// A change shows here first: a master has one for each slave.
#[test]
#[cfg(target_pointer_width = "64")]
fn the_size_of_a_conversation() {
    assert_eq!([size_of::<Conversation<32>>(), size_of::<Conversation<256>>()], [184, 632]);
}
