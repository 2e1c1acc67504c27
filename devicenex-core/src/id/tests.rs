//! Taking identifiers apart and building them.
#![expect(clippy::unusual_byte_groupings, reason = "grouped by field")]

use super::*;
use cip_core::code::InstanceId;
use link_core::frame::{extended_id, standard_id};
use link_core::{Frame, Id};
use proptest::prelude::*;
use std::collections::HashSet;
use std::string::ToString;

fn oa(number: u8) -> OperationalAddress {
    OperationalAddress::new(number).unwrap()
}

fn of_extended(raw: u32) -> Identifier {
    Id::Extended(extended_id(raw)).into()
}

fn of_standard(raw: u16) -> Identifier {
    Id::Standard(standard_id(raw)).into()
}

fn addresses() -> impl Strategy<Value = OperationalAddress> + Clone {
    (0_u8..128).prop_map(OperationalAddress::from_low_bits)
}

fn routes() -> impl Strategy<Value = Route> {
    (addresses(), any::<bool>(), addresses()).prop_map(|(destination, bit, source)| Route {
        destination,
        direction: Direction::of(bit),
        source,
    })
}

fn framings() -> impl Strategy<Value = Framing> {
    prop_oneof![
        any::<u8>().prop_map(|transaction| Framing::Complete { transaction }),
        any::<u8>().prop_map(|byte| Framing::Fragment(byte.into())),
    ]
}

fn layouts() -> impl Strategy<Value = Layout> {
    let message = || (0_u8..16).prop_map(MessageId::from_low_bits);
    prop_oneof![
        (addresses(), any::<bool>(), any::<u16>()).prop_map(|(source, bit, serial_low)| Layout::Hello {
            source,
            direction: Direction::of(bit),
            serial_low
        }),
        (addresses(), any::<u16>())
            .prop_map(|(destination, serial_low)| Layout::Roam { destination, serial_low }),
        (routes(), any::<u8>()).prop_map(|(route, transaction)| Layout::Connection { route, transaction }),
        (routes(), framings()).prop_map(|(route, framing)| Layout::Connectionless { route, framing }),
        (message(), routes(), framings()).prop_map(|(message, route, framing)| Layout::Explicit {
            message,
            route,
            framing
        }),
        (message(), addresses(), any::<bool>(), any::<u16>()).prop_map(
            |(message, source, acknowledge, instance)| Layout::Implicit {
                message,
                source,
                acknowledge,
                instance: InstanceId(instance)
            }
        ),
        (prop::sample::select(&[Group::Group1, Group::Group2, Group::Group3]), message(), addresses())
            .prop_map(|(group, message, source)| Layout::Standard { group, message, source }),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4096))]

    #[test]
    fn every_extended_identifier_is_rebuilt_from_its_parts(raw in 0_u32..0x2000_0000) {
        let id = of_extended(raw);
        prop_assert_eq!(id.layout().identifier(), Some(id), "{:?}", id.layout());
    }

    #[test]
    fn every_layout_that_has_an_identifier_is_read_from_it(layout in layouts()) {
        match layout.identifier() {
            Some(id) => prop_assert_eq!(id.layout(), layout),
            None => {
                let limited = matches!(layout, Layout::Explicit { .. } | Layout::Standard { .. });
                prop_assert!(limited);
            }
        }
    }

    /// By its address, or while others may have that address too by half of its serial number as well. Only ROAM tells
    /// nothing of its sender.
    #[test]
    fn an_identifier_tells_its_sender(layout in layouts(), another in addresses()) {
        let Some(id) = layout.identifier() else { return Ok(()) };
        let sender = id.sender();
        prop_assert_eq!(sender.is_none(), matches!(layout, Layout::Roam { .. }));
        let Some(moved) = with_source(layout, another).and_then(Layout::identifier) else { return Ok(()) };
        prop_assert_eq!(moved == id, moved.sender() == sender, "{} and {}", layout, moved.layout());
    }
}

/// The same message of a node with another address.
fn with_source(layout: Layout, source: OperationalAddress) -> Option<Layout> {
    let from = |route: Route| Route { source, ..route };
    Some(match layout {
        Layout::Hello { direction, serial_low, .. } => Layout::Hello { source, direction, serial_low },
        Layout::Connection { route, transaction } => Layout::Connection { route: from(route), transaction },
        Layout::Connectionless { route, framing } => Layout::Connectionless { route: from(route), framing },
        Layout::Explicit { message, route, framing } => {
            Layout::Explicit { message, route: from(route), framing }
        }
        Layout::Implicit { message, acknowledge, instance, .. } => {
            Layout::Implicit { message, source, acknowledge, instance }
        }
        Layout::Standard { group, message, .. } => Layout::Standard { group, message, source },
        Layout::Roam { .. } | Layout::Reserved(_) => return None,
    })
}

/// All 2048, and the whole class byte of 29 bits with every address and flag.
#[test]
fn every_standard_identifier_is_rebuilt_from_its_parts() {
    let mut reserved = 0;
    for raw in 0..=0x7FF {
        let id = of_standard(raw);
        assert_eq!(id.layout().identifier(), Some(id), "{:?}", id.layout());
        match id.layout() {
            Layout::Standard { group, message, source } => {
                assert_eq!(Identifier::standard(group, message, source), Some(id));
                assert!(raw >> 4 != 0x7F, "seven leading recessive bits");
                let first = match group {
                    Group::Group1 => 0x000,
                    Group::Group2 => 0x400,
                    Group::Group3 => 0x600,
                };
                assert_eq!(raw, first | u16::from(message.number()) << 7 | u16::from(source.number()));
            }
            Layout::Reserved(_) => reserved += 1,
            layout => panic!("{layout:?}"),
        }
    }
    assert_eq!(reserved, 128, "Group 3 Message ID 3 of every address");
}

#[test]
fn every_class_is_rebuilt_from_its_parts() {
    let mut seen = HashSet::new();
    for high in 0..0x2000_u32 {
        for low in [0x0000, 0x0100, 0x80FF, 0xFFFF] {
            let id = of_extended(high << 16 | low);
            assert_eq!(id.layout().identifier(), Some(id));
            let reserved = matches!(id.layout(), Layout::Reserved(_));
            let class = high >> 8;
            let expected = matches!(class, 0b1_1000..=0b1_1011)
                || class == 0b1_1110 && high & 1 == 1
                || class == 0b1_1101 && low & 0x100 != 0;
            assert_eq!(reserved, expected, "{id}");
            seen.insert(core::mem::discriminant(&id.layout()));
        }
    }
    assert_eq!(seen.len(), 7, "all but the layout of 11 bits");
}

#[test]
fn what_has_no_bits_has_no_identifier() {
    let route = Route { destination: oa(1), direction: Direction::Request, source: oa(2) };
    let framing = Framing::Complete { transaction: 0 };
    let message = |number| MessageId::new(number).unwrap();
    assert!(Identifier::explicit(message(7), route, framing).is_some());
    assert_eq!(Identifier::explicit(message(8), route, framing), None);
    for (group, last) in [(Group::Group1, 7), (Group::Group2, 3), (Group::Group3, 2)] {
        assert!(Identifier::standard(group, message(last), oa(126)).is_some());
        assert_eq!(Identifier::standard(group, message(last + 1), oa(0)), None);
    }
    let hello = of_extended(0x1FFE_4433);
    assert_eq!(Layout::Reserved(hello).identifier(), None, "it is a Hello");
}

/// Paper figures 3, 4 and 6: bits 28-24, 23-17, 16, then serial number bytes 0 and 1.
#[test]
fn the_identifiers_of_the_paper() {
    let serial_low = 0x3344;
    let hello = Identifier::hello(OperationalAddress::NONE, Direction::Request, serial_low);
    assert_eq!(hello, of_extended(0b11111_1111111_0_01000100_00110011));
    assert_eq!(hello, of_extended(0x1FFE_4433));
    let response = Identifier::hello(oa(5), Direction::Response, serial_low);
    assert_eq!(response, of_extended(0b11111_0000101_1_01000100_00110011));
    assert_eq!(Identifier::roam(serial_low), of_extended(0b11110_1111111_0_01000100_00110011));
}

/// The profile: class, destination, R, source, F, X; and Message ID, source, A, instance.
#[test]
fn the_identifiers_of_the_profile() {
    let request = Route { destination: oa(67), direction: Direction::Request, source: oa(1) };
    let response = Route { destination: oa(1), direction: Direction::Response, source: oa(67) };
    assert_eq!(Identifier::connection(request, 9), of_extended(0b11101_1000011_0_0000001_0_00001001));
    let last = Framing::Fragment(0x82.into());
    assert_eq!(Identifier::connectionless(response, last), of_extended(0b11100_0000001_1_1000011_1_10000010));
    let message = MessageId::new(5).unwrap();
    let complete = Framing::Complete { transaction: 0xFF };
    assert_eq!(
        Identifier::explicit(message, request, complete),
        Some(of_extended(0b10101_1000011_0_0000001_0_11111111))
    );
    assert_eq!(
        Identifier::implicit(message, oa(67), InstanceId(0x0103)),
        of_extended(0b00101_1000011_0_00000001_00000011)
    );
    assert_eq!(
        Identifier::implicit_acknowledge(message, oa(67), InstanceId(0x0103)),
        of_extended(0b00101_1000011_1_00000001_00000011)
    );
    assert_eq!(Identifier::standard(Group::Group1, message, oa(67)), Some(of_standard(0b0_101_1000011)));
    let message = MessageId::new(2).unwrap();
    assert_eq!(Identifier::standard(Group::Group2, message, oa(67)), Some(of_standard(0b10_10_1000011)));
    assert_eq!(Identifier::standard(Group::Group3, message, oa(67)), Some(of_standard(0b11_10_1000011)));
}

#[test]
fn reads_as_words() {
    let text = |raw| of_extended(raw).layout().to_string();
    assert_eq!(text(0x1FFE_4433), "Hello request of OA 127, serial ending in 0x3344");
    assert_eq!(text(0x1EFE_4433), "ROAM to OA 127, serial ending in 0x3344");
    assert_eq!(text(0x1C03_8782), "connectionless response from OA 67 to OA 1, last fragment 2");
    assert_eq!(text(0x1586_02FF), "explicit request from OA 1 to OA 67, message 5, transaction 255");
    assert_eq!(text(0x0586_0003), "implicit of OA 67, message 5, instance 3");
    assert_eq!(text(0x0587_0003), "implicit acknowledge of OA 67, message 5, instance 3");
    assert_eq!(text(0x1900_0000), "reserved identifier 19000000");
    assert_eq!(of_standard(0x2C3).layout().to_string(), "implicit of OA 67, group 1, message 5");
    assert_eq!(of_standard(0x780).layout().to_string(), "reserved identifier 780");
}

/// I/O goes before explicit messages, and both before Hello.
#[test]
fn the_classes_win_arbitration_in_order() {
    let key = |raw| Frame::new(extended_id(raw), &[]).unwrap().arbitration_key();
    let in_order = [0x0FFF_FFFF, 0x17FF_FFFF, 0x1CFF_FFFF, 0x1DFF_FFFF, 0x1EFE_FFFF, 0x1FFF_FFFF];
    assert!(in_order.map(key).is_sorted());
}
