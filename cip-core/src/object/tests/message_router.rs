//! The Message Router object and Multiple_Service_Packet.

use super::order::{Probe, probe};
use super::{answer, ask, ask_effects};
use crate::codec::{Wire, Writer};
use crate::message::{BodyFormat, MultipleServicePacket, ResetType, emit_packets};
use crate::object::laws::agrees_with_names;
use crate::object::{Effect, Effects, FailureOptions, Identity, MessageRouter, Router, RouterConnections};
use proptest::{collection::vec as any_vec, prelude::*};
use std::vec::Vec;

fn router() -> Router<'static, (Probe,)> {
    Router::new((probe(),), BodyFormat::Class8Instance8)
}

/// A packet for the router's instance 1.
fn packet(requests: &[&[u8]]) -> Vec<u8> {
    let mut buffer = [0; 256];
    let mut out = Writer::new(&mut buffer);
    emit_packets(requests, &mut out).unwrap();
    [&[0x0A, 2, 1], out.written()].concat()
}

#[test]
fn without_attributes_the_class_still_exists() {
    let mut set = (MessageRouter,);
    assert_eq!(ask(&mut set, &[0x0E, 2, 1, 1]), [0x94, 0x14, 0xFF]);
    assert_eq!(ask(&mut set, &[0x10, 2, 1, 1, 0]), [0x94, 0x08, 0xFF]);
    assert_eq!(ask(&mut set, &[0x0A, 2, 1, 0, 0]), [0x94, 0x08, 0xFF]);
    assert_eq!(ask(&mut set, &[0x0E, 2, 2, 1]), [0x94, 0x16, 0xFF]);
    assert_eq!(ask(&mut set, &[0x0E, 2, 0, 1]), [0x8E, 1, 0]);
    agrees_with_names(&set.0, &[1]);
}

#[test]
fn attributes_one_by_one() {
    let mut router = router();
    assert_eq!(ask(&mut router, &[0x0E, 2, 1, 1]), [0x8E, 2, 0, 2, 0, 0x64, 0]);
    assert_eq!(ask(&mut router, &[0x0E, 2, 1, 2]), [0x94, 0x14, 0xFF]);
    router.connections = Some(RouterConnections { available: 5, active: &[1, 0x0203] });
    assert_eq!(ask(&mut router, &[0x0E, 2, 1, 2]), [0x8E, 5, 0]);
    assert_eq!(ask(&mut router, &[0x0E, 2, 1, 3]), [0x8E, 2, 0]);
    assert_eq!(ask(&mut router, &[0x0E, 2, 1, 4]), [0x8E, 1, 0, 3, 2]);
    assert_eq!(ask(&mut router, &[0x0E, 2, 0, 1]), [0x8E, 1, 0]);
    assert_eq!(ask(&mut router, &[0x10, 2, 1, 2, 0, 0]), [0x94, 0x08, 0xFF]);
    assert_eq!(ask(&mut router, &[0x0E, 0x64, 1, 1]), [0x8E, 0x34, 0x12], "the objects behind");
    assert_eq!(ask(&mut router, &[0x0E, 0x65, 1, 1]), [0x94, 0x16, 0xFF]);
    let front = super::super::message_router::Front { classes: &(probe(),), connections: router.connections };
    agrees_with_names(&front, &[1]);
}

#[test]
fn a_router_behind_a_router_is_not_listed_twice() {
    let mut router = Router::new((MessageRouter, probe()), BodyFormat::Class8Instance8);
    assert_eq!(ask(&mut router, &[0x0E, 2, 1, 1]), [0x8E, 2, 0, 2, 0, 0x64, 0]);
}

#[test]
fn a_packet_is_answered_in_order() {
    let mut router = router();
    let requests = packet(&[
        &[0x10, 0x64, 1, 2, 0x00, 0x01], // a Set that the Get behind it sees
        &[0x0E, 0x64, 1, 1],
        &[0x0E, 0x65, 1, 1], // no such class
        &[0x0E, 2, 1, 1],    // the router itself
    ]);
    let (response, effects) = ask_effects(&mut router, &requests);
    let expected = [
        0x8A, 4, 0, // four responses
        10, 0, 11, 0, 14, 0, 17, 0,    // where they are
        0x90, // Set
        0x8E, 0x00, 0x01, // Get
        0x94, 0x16, 0xFF, // refused
        0x8E, 2, 0, 2, 0, 0x64, 0, // the object list
    ];
    assert_eq!((response, effects), (expected.to_vec(), Effect::ATTRIBUTE_SET.into()));
}

#[test]
fn the_format_of_the_connection_is_that_of_the_requests() {
    let mut router = Router::new((probe(),), BodyFormat::CipPath);
    let requests = packet(&[&[0x0E, 3, 0x20, 0x64, 0x24, 1, 0x30, 1], &[0x0E, 2, 0x24, 1, 0x30, 1]]);
    let by_path = [&[0x0A, 2, 0x20, 2, 0x24, 1], &requests[3..]].concat();
    let options = FailureOptions::default();
    let (response, _) = answer(&mut router, BodyFormat::CipPath, options, &by_path);
    assert_eq!(response, [0x8A, 2, 0, 6, 0, 9, 0, 0x8E, 0x34, 0x12, 0x94, 0x04, 0xFF]);
}

#[test]
fn packets_that_are_refused() {
    for (body, status) in [
        (packet(&[&[0x0E, 0x65, 1, 1], &[0x32, 0x64, 1]]), 0x1E), // nothing succeeds
        (packet(&[&packet(&[])]), 0x1E),                          // a packet in a packet
        ([0x0A, 2, 1].to_vec(), 0x13),
        ([0x0A, 2, 1, 1].to_vec(), 0x13),
        ([0x0A, 2, 1, 2, 0, 6, 0].to_vec(), 0x13),
        ([0x0A, 2, 1, 1, 0, 5, 0, 0x0E, 0x64, 1, 1].to_vec(), 0x20), // not behind the offsets
        ([0x0A, 2, 1, 1, 0, 99, 0, 0x0E, 0x64, 1, 1].to_vec(), 0x20), // not in the packet
        ([0x0A, 2, 1, 0, 0, 1].to_vec(), 0x15),
        ([0x0A, 2, 0, 0, 0].to_vec(), 0x08), // of the class
        ([0x0A, 2, 2, 0, 0].to_vec(), 0x16),
    ] {
        let mut router = router();
        assert_eq!(ask(&mut router, &body), [0x94, status, 0xFF], "{body:02X?}");
        assert_eq!(router, self::router());
    }
    assert_eq!(ask(&mut router(), &packet(&[])), [0x8A, 0, 0]);
}

#[test]
fn requests_in_a_packet_that_are_none() {
    let answer = ask(&mut router(), &packet(&[&[0x0E, 0x64], &[0x8E, 0x64, 1], &[0x0E, 0x64, 1, 1]]));
    assert_eq!(answer[9..], [0x94, 0x13, 0xFF, 0x94, 0x20, 0xFF, 0x8E, 0x34, 0x12]);
}

/// 64 bytes are room for twelve refusals with their offsets: 1 + 2 + 12 * 5.
#[test]
fn a_packet_without_room_for_its_refusals_does_nothing() {
    let set = &[0x10, 0x64, 1, 2, 0x00, 0x01][..];
    let mut router = router();
    assert_eq!(ask(&mut router, &packet(&[set; 13])), [0x94, 0x11, 0xFF]);
    assert_eq!(router, self::router());
    assert_eq!(ask(&mut router, &packet(&[set; 12]))[..3], [0x8A, 12, 0]);
}

#[test]
fn a_response_without_room_gives_way_to_those_behind() {
    let get = &[0x0E, 2, 1, 1][..];
    let answer = ask(&mut router(), &packet(&[get; 10]));
    let responses: Vec<_> = MultipleServicePacket::parse(&answer[1..]).unwrap().services().collect();
    let full = &[0x8E, 2, 0, 2, 0, 0x64, 0][..];
    let none = &[0x94, 0x11, 0xFF][..];
    assert_eq!(responses, [full, full, none, none, none, none, none, none, none, none]);
}

#[test]
fn effects_of_a_packet_add_up() {
    use crate::code::{DeviceType, VendorId};
    use crate::identity::{DeviceIdentity, ProductName, Revision};
    let device = DeviceIdentity {
        vendor: VendorId(1),
        device_type: DeviceType::GENERIC,
        product_code: 1,
        revision: Revision { major: 1, minor: 1 },
        serial: 1,
        name: ProductName::default(),
    };
    let identity = Identity { heartbeat_interval: Some(0), ..Identity::new(&device) };
    let mut router = Router::new((identity,), BodyFormat::Class8Instance8);
    let (_, effects) =
        ask_effects(&mut router, &packet(&[&[0x05, 1, 1], &[0x10, 1, 1, 10, 5], &[0x05, 1, 1, 9]]));
    let of = Effect::HEARTBEAT_INTERVAL | Effect::ATTRIBUTE_SET;
    assert_eq!(effects, Effects::reset(ResetType::POWER_CYCLE).then(of.into()));
}

proptest! {
    /// Whatever the bytes, there is one answer of bounded length, and a packet's is a packet.
    #[test]
    fn any_packet_is_answered(requests in any_vec(any_vec(any::<u8>(), 0..8), 0..14)) {
        let requests: Vec<_> = requests.iter().map(Vec::as_slice).collect();
        let answer = ask(&mut router(), &packet(&requests));
        match answer[0] {
            0x8A => {
                let responses = MultipleServicePacket::parse(&answer[1..]).unwrap();
                prop_assert_eq!(responses.services().count(), requests.len());
                prop_assert!(responses.services().all(|response| response[0] >= 0x80));
            }
            _ => prop_assert_eq!(answer.len(), 3),
        }
    }
}
