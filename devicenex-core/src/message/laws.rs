//! The laws of every wire type, and golden bytes from the paper.
#![expect(clippy::unusual_byte_groupings, reason = "grouped by field")]

use cip_core::code::{AdditionalCode, GeneralStatus, InstanceId, VendorId};
use cip_core::connection::WatchdogAction;
use cip_core::fragment::{AckStatus, FragmentByte, FragmentKind};
use link_core::frame::extended_id;
use link_core::{frame_laws, samples};
use proptest::prelude::*;
use std::string::ToString;
use std::vec::Vec;

use super::*;
use crate::id::{Direction, MessageId, OperationalAddress};

fn rest_of_identity() -> impl Strategy<Value = RestOfIdentity> {
    (any::<u16>(), any::<u16>(), any::<u16>(), any::<u8>()).prop_map(
        |(serial_high, vendor, product_code, major_revision)| RestOfIdentity {
            serial_high,
            vendor: VendorId(vendor),
            product_code,
            major_revision,
        },
    )
}

fn device() -> impl Strategy<Value = DeviceIdentity> {
    (any::<u16>(), rest_of_identity()).prop_map(|(low, rest)| DeviceIdentity::of_halves(low, rest))
}

fn address() -> impl Strategy<Value = OperationalAddress> {
    (0_u8..128).prop_map(OperationalAddress::from_low_bits)
}

fn message_id() -> impl Strategy<Value = MessageId> {
    (0_u8..16).prop_map(MessageId::from_low_bits)
}

fn group() -> impl Strategy<Value = GroupSelect> {
    (0_u8..8).prop_map(|number| GroupSelect::new(number).unwrap())
}

fn target() -> impl Strategy<Value = Target> {
    (any::<u16>(), any::<u16>(), any::<u8>()).prop_map(|(instance, expected_packet_rate, action)| Target {
        instance: InstanceId(instance),
        expected_packet_rate,
        watchdog_action: WatchdogAction(action),
    })
}

fn granted() -> impl Strategy<Value = Granted> {
    prop_oneof![
        any::<u16>().prop_map(|expected_packet_rate| Granted::Predefined { expected_packet_rate }),
        any::<u16>().prop_map(|instance| Granted::Dynamic { instance: InstanceId(instance) }),
    ]
}

fn fragment() -> impl Strategy<Value = FragmentByte> {
    (prop::sample::select(&[FragmentKind::First, FragmentKind::Middle, FragmentKind::Last]), 0_u8..64)
        .prop_map(|(kind, count)| FragmentByte::new(kind, count))
}

fn free(len: core::ops::RangeInclusive<usize>) -> impl Strategy<Value = &'static [u8]> {
    prop::collection::vec(any::<u8>(), len).prop_map(|bytes| &*bytes.leak())
}

samples! {
    HelloData = (rest_of_identity(), any::<u8>())
        .prop_map(|(device, port)| Self { device, port: PortByte(port) });
    RoamData = (rest_of_identity(), address()).prop_map(|(target, requested)| Self { target, requested });
    ConnectionRequest = (any::<bool>(), group(), message_id(), prop::option::of(target()))
        .prop_map(|(predefined, group, source_message, target)| Self { predefined, group, source_message, target });
    ConnectionResponse = (group(), message_id(), any::<u8>(), granted()).prop_map(
        |(group, source_message, format, granted)| {
            Self { group, source_message, body_format: FormatByte(format), granted }
        });
    ErrorResponse = (any::<u8>(), any::<u8>()).prop_map(|(general, additional)| {
        Self { general: GeneralStatus(general), additional: AdditionalCode(additional) }
    });
    ConnectionlessRequest = any::<[u8; 3]>()
        .prop_map(|[class, instance, attribute]| Self { class, instance, attribute });
    ConnectionlessResponse<'static> = free(0..=7).prop_map(|value| Self { value });
    ExplicitMessage<'static> = free(1..=8).prop_map(|body| Self { body });
    FirstFragment = (any::<u8>(), any::<[u8; 7]>()).prop_map(|(transaction, body)| Self { transaction, body });
    NextFragment<'static> = free(1..=8).prop_map(|body| Self { body });
    FragmentAcknowledge = any::<u8>().prop_map(|status| Self { status: AckStatus::from(status) });
    ImplicitFragment<'static> = (fragment(), free(0..=7)).prop_map(|(fragment, data)| Self { fragment, data });
}

/// Bytes that are often accepted: a service byte of a known message in its place, otherwise anything.
fn near_messages() -> impl Strategy<Value = Vec<u8>> {
    let services = prop_oneof![any::<u8>(), prop::sample::select(&[0x4B, 0x94, 0x0E, 0x8E])];
    (services, any::<[u8; 6]>(), prop_oneof![any::<u8>(), 0_u8..0x80], any::<u8>(), 0_usize..=9).prop_map(
        |(service, middle, address, last, len)| {
            let mut bytes: Vec<u8> = [service].into_iter().chain(middle).chain([address, last]).collect();
            bytes.truncate(len);
            bytes
        },
    )
}

crate::for_each_wire_type!(frame_laws);

proptest! {
    /// What is told in identifier and data comes back from the frame, and the frame from it.
    #[test]
    fn frames_with_two_parts_are_read_as_they_were_written(
        device in device(),
        address in address(),
        response in any::<bool>(),
        port in any::<u8>(),
    ) {
        let hello = Hello { source: address, direction: Direction::of(response), device, port: PortByte(port) };
        prop_assert_eq!(Hello::of_frame(&hello.frame().unwrap()), Some(Ok(hello)));
        let roam = Roam { target: device, requested: address };
        prop_assert_eq!(Roam::of_frame(&roam.frame().unwrap()), Some(Ok(roam)));
        let mini_who = MiniWho { serial_low: device.serial_low() };
        prop_assert_eq!(MiniWho::of_frame(&mini_who.frame().unwrap()), Some(mini_who));
        prop_assert_eq!(Hello::of_frame(&mini_who.frame().unwrap()), None);
        prop_assert_eq!(MiniWho::of_frame(&hello.frame().unwrap()), None);
        prop_assert_eq!(Roam::of_frame(&hello.frame().unwrap()), None);
    }
}

/// The example of the profile for figure 3: serial 0x11223344, vendor 0x0123, product 0x0456, revision 2, port 0.
fn device_of_the_example() -> DeviceIdentity {
    DeviceIdentity { vendor: VendorId(0x0123), product_code: 0x0456, major_revision: 2, serial: 0x1122_3344 }
}

#[test]
fn the_messages_of_the_paper() {
    let device = device_of_the_example();
    let hello = Hello {
        source: OperationalAddress::NONE,
        direction: Direction::Request,
        device,
        port: PortByte::ZERO,
    };
    let expected = [
        0x22, 0x11, // serial number bytes 2 and 3
        0x23, 0x01, // vendor ID
        0x56, 0x04, // product code
        0x02, // major revision
        0x00, // port 0
    ];
    assert_eq!(hello.frame(), Frame::new(extended_id(0x1FFE_4433), &expected));
    assert_eq!(
        hello.to_string(),
        "Hello request of OA 127: vendor 291, product 1110, revision 2, serial 0x11223344"
    );
    let mini_who = MiniWho { serial_low: device.serial_low() };
    assert_eq!(mini_who.frame(), Frame::remote(extended_id(0x1FFE_4433), 8));
    let roam = Roam { target: device, requested: OperationalAddress::new(67).unwrap() };
    let expected = [0x22, 0x11, 0x23, 0x01, 0x56, 0x04, 0x02, 0x43];
    assert_eq!(roam.frame(), Frame::new(extended_id(0x1EFE_4433), &expected));
    assert_eq!(roam.to_string(), "ROAM to OA 67: vendor 291, product 1110, revision 2, serial 0x11223344");
}

#[test]
fn a_mini_who_of_any_length_is_one() {
    for dlc in 0..=Frame::MAX_DLC {
        let frame = Frame::remote(extended_id(0x1FFE_4433), dlc).unwrap();
        assert_eq!(MiniWho::of_frame(&frame), Some(MiniWho { serial_low: 0x3344 }), "DLC {dlc}");
    }
    for other in [0x1FFF_4433, 0x1F0A_4433, 0x1EFE_4433] {
        assert_eq!(MiniWho::of_frame(&Frame::remote(extended_id(other), 8).unwrap()), None);
    }
}

#[test]
fn a_roam_with_bit_7_set_or_to_a_device_with_an_address_is_none() {
    let mut data = [0x22, 0x11, 0x23, 0x01, 0x56, 0x04, 0x02, 0xC3];
    let error = Roam::of_frame(&Frame::new(extended_id(0x1EFE_4433), &data).unwrap()).unwrap().unwrap_err();
    assert_eq!(error, ParseError::value("requested OA", 7, 0xC3));
    data[7] = 0x43;
    assert_eq!(Roam::of_frame(&Frame::new(extended_id(0x1E0A_4433), &data).unwrap()), None);
    assert_eq!(Roam::of_frame(&Frame::remote(extended_id(0x1EFE_4433), 8).unwrap()), None);
}

/// Figure 7 in both lengths, figure 8 in both meanings; service, then P, group, Source Message ID.
#[test]
fn a_connection_is_asked_for_and_granted() {
    let dynamic = ConnectionRequest {
        predefined: false,
        group: GroupSelect::EXPLICIT_29,
        source_message: MessageId::new(3).unwrap(),
        target: None,
    };
    assert_eq!(ConnectionRequest::parse(&[0x4B, 0b0_101_0011]), Ok(dynamic));
    let response = ConnectionResponse {
        group: GroupSelect::EXPLICIT_29,
        source_message: MessageId::new(2).unwrap(),
        body_format: FormatByte(2),
        granted: Granted::Dynamic { instance: InstanceId(128) },
    };
    assert_eq!(ConnectionResponse::parse(&[0x4B, 0b0_101_0010, 0x02, 0x80, 0x00]), Ok(response));

    let predefined = ConnectionRequest {
        predefined: true,
        group: GroupSelect::GROUP_1,
        source_message: MessageId::new(15).unwrap(),
        target: Some(Target {
            instance: InstanceId(8),
            expected_packet_rate: 1000,
            watchdog_action: WatchdogAction::AUTO_DELETE,
        }),
    };
    let bytes = [0x4B, 0b1_000_1111, 0x08, 0x00, 0xE8, 0x03, 0x01];
    assert_eq!(ConnectionRequest::parse(&bytes), Ok(predefined));
    let response = ConnectionResponse::parse(&[0x4B, 0b1_000_0001, 0x00, 0xD0, 0x07]).unwrap();
    assert_eq!(response.granted, Granted::Predefined { expected_packet_rate: 2000 });
}

#[test]
fn requests_of_other_lengths_are_answered_by_an_error() {
    let bytes = [0x4B, 0x80, 0x07, 0x00, 0xE8, 0x03, 0x01, 0x00];
    let status = |len: usize| {
        ConnectionRequest::parse(&bytes[..len]).map_err(|error| ConnectionRequest::status_of(&error).0)
    };
    for short in [0, 1, 3, 4, 5, 6] {
        assert_eq!(status(short), Err(0x13), "{short} bytes");
    }
    assert!(status(2).is_ok() && status(7).is_ok());
    assert_eq!(status(8), Err(0x15));
    let error = ConnectionRequest::parse(&[0x4C, 0x00]).unwrap_err();
    assert_eq!(ConnectionRequest::status_of(&error), GeneralStatus::SERVICE_NOT_SUPPORTED);
}

#[test]
fn requests_that_no_target_grants() {
    let status = |byte, instance: Option<u16>| {
        let mut bytes = std::vec![0x4B, byte];
        if let Some(instance) = instance {
            bytes.extend(instance.to_le_bytes());
            bytes.extend([0, 0, 0]);
        }
        ConnectionRequest::parse(&bytes).unwrap().refusal().map(|status| status.0)
    };
    assert_eq!(status(0x00, None), None);
    assert_eq!(status(0x80, None), Some(0x20), "no instance is named");
    assert_eq!(status(0x80, Some(13)), None);
    assert_eq!(status(0x00, Some(13)), Some(0x20));
    assert_eq!(status(0x00, Some(128)), None);
    assert_eq!(status(0x80, Some(255)), Some(0x20));
    for reserved in [0, 14, 127, 256, 65535] {
        assert_eq!(status(0x80, Some(reserved)), Some(0x05), "{reserved}");
    }
}

#[test]
fn connectionless_requests_and_their_answers() {
    // Vendor ID: Identity object, instance 1, attribute 1.
    let request = ConnectionlessRequest { class: 1, instance: 1, attribute: 1 };
    assert_eq!(ConnectionlessRequest::parse(&[0x0E, 0x01, 0x01, 0x01]), Ok(request));
    let response = ConnectionlessResponse { value: &[0x23, 0x01] };
    assert_eq!(ConnectionlessResponse::parse(&[0x8E, 0x23, 0x01]), Ok(response));
    assert_eq!(ErrorResponse::parse(&[0x94, 0x08, 0xFF]), Ok(ErrorResponse::SERVICE_NOT_SUPPORTED));
    assert!(ConnectionlessRequest::parse(&[0x10, 0x01, 0x01, 0x01]).is_err(), "Set_Attribute_Single");
}
