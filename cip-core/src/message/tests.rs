use super::*;
use crate::code::{AdditionalCode, AttributeId, ClassId, GeneralStatus, InstanceId, ServiceCode};
use crate::codec::{Full, ParseErrorKind, Tail, Wire, Writer, laws};
use crate::epath::Epath;
use proptest::{collection::vec, prelude::*};
use std::string::ToString;
use std::vec::Vec;

const FORMAT_8_8: BodyFormat = BodyFormat::Class8Instance8;
const FORMAT_16_16: BodyFormat = BodyFormat::Class16Instance16;

/// Emits `request` and checks every law on the way.
#[track_caller]
fn emitted(request: &Request<'_>, format: BodyFormat) -> Vec<u8> {
    let mut buffer = [0; 80];
    let mut out = Writer::new(&mut buffer);
    request.emit(format, &mut out).unwrap();
    assert_eq!(out.len(), request.wire_len(format));
    out.written().to_vec()
}

/// Parses `body`, which is printed in a manual or stands in a capture, and checks that it is emitted again.
#[track_caller]
fn golden(format: BodyFormat, body: &[u8]) -> Request<'_> {
    let request = Request::parse(format, body).unwrap();
    assert_eq!(emitted(&request, format), body);
    request
}

/// ICP DAS CAN-8124/8224/8424 User Manual v2.0, p. 112: explicit, poll and bit-strobe for master 10.
#[test]
fn allocate_as_printed_by_icp_das() {
    let request = golden(FORMAT_8_8, &[0x4B, 0x03, 0x01, 0x07, 0x0A]);
    assert_eq!(
        request,
        Request::new(ServiceCode::ALLOCATE, ClassId::DEVICENET, InstanceId(1), &[0x07, 0x0A])
    );
    let allocate = AllocateRequest::parse(request.data).unwrap();
    let choice = AllocationChoice::EXPLICIT | AllocationChoice::POLL | AllocationChoice::BIT_STROBE;
    assert_eq!(allocate, AllocateRequest { choice, allocator: 10 });
    assert_eq!(allocate.choice.to_string(), "explicit + poll + bit-strobe");
}

/// ICP DAS I-7242D User Manual v1.1, p. 83: EPR of instance 4 to 3594 ms.
#[test]
fn set_epr_as_printed_by_icp_das() {
    let request = golden(FORMAT_8_8, &[0x10, 0x05, 0x04, 0x09, 0x0A, 0x0E]);
    assert_eq!(request.target.class(), Some(ClassId::CONNECTION));
    let access = request.attribute_access().unwrap();
    assert_eq!(access, AttributeAccess { attribute: AttributeId(9), value: &3594_u16.to_le_bytes() });
}

/// ICP DAS CAN-8124/8224/8424 User Manual v2.0, p. 113: the value used is 3600 ms.
#[test]
fn set_epr_response_carries_the_value_used() {
    let response = Response::parse(&[0x90, 0x10, 0x0E]).unwrap();
    let data = &3600_u16.to_le_bytes();
    assert_eq!(response, Response::Success { service: ServiceCode::SET_ATTRIBUTE_SINGLE, data });
}

/// BEI Ideacod / POSITAL UME-OCD-D2, p. 10: a Release with bit 6, which is reserved there.
#[test]
fn release_with_bit_6_is_kept() {
    let request = golden(FORMAT_8_8, &[0x4C, 0x03, 0x01, 0x51]);
    let release = ReleaseRequest::parse(request.data).unwrap();
    assert_eq!(release.choice.bits(), 0x51);
    assert_eq!(release.choice.to_string(), "explicit + change of state + acknowledge suppression");
}

/// Capture of an IAI controller: Get Vendor ID with 16-bit class and instance.
#[test]
fn sixteen_bit_addressing_of_an_iai_controller() {
    let request = golden(FORMAT_16_16, &[0x0E, 0x01, 0x00, 0x01, 0x00, 0x01]);
    assert_eq!(request.target, Target::Object { class: ClassId::IDENTITY, instance: InstanceId(1) });
    assert_eq!(request.attribute_access().unwrap().attribute, AttributeId(1));
    assert_eq!(AllocateResponse::parse(&[2]).unwrap().body_format(), Some(FORMAT_16_16));
}

/// Test fixture of AnlangA/devicenet-identifier-analyzer: an invalid service on the unconnected port.
#[test]
fn error_on_the_unconnected_port() {
    let response = Response::parse(&[0x94, 0x02, 0x03]).unwrap();
    let status = GeneralStatus::RESOURCE_UNAVAILABLE;
    assert_eq!(response, Response::Error { status, additional: AdditionalCode::INVALID_UNCONNECTED_SERVICE });
    assert_eq!(response.to_string(), "error 0x02 Resource unavailable, additional 0x03");
}

#[test]
fn an_error_response_has_exactly_three_bytes() {
    assert!(Response::parse(&[0x94]).unwrap_err().is_short());
    assert!(Response::parse(&[0x94, 0x08]).unwrap_err().is_short());
    let error = Response::parse(&[0x94, 0x08, 0xFF, 0x00]).unwrap_err();
    assert_eq!(error.kind, ParseErrorKind::Trailing { found: 1 });
}

#[test]
fn direction_is_part_of_the_service_byte() {
    assert_eq!(Request::parse(FORMAT_8_8, &[0x8E, 1, 1]).unwrap_err().field, "service");
    assert_eq!(Response::parse(&[0x0E]).unwrap_err().field, "service");
}

#[test]
fn the_path_of_format_4_may_name_the_attribute() {
    let with = golden(BodyFormat::CipPath, &[0x0E, 0x03, 0x20, 0x04, 0x24, 0x65, 0x30, 0x03]);
    assert_eq!(with.attribute_access(), Ok(AttributeAccess { attribute: AttributeId(3), value: &[] }));
    assert_eq!(with.target.instance(), Some(InstanceId(101)));
    assert_eq!(with.to_string(), "Get_Attribute_Single class 4 instance 101 attribute 3, Data");

    let without = golden(BodyFormat::CipPath, &[0x10, 0x02, 0x20, 0x04, 0x24, 0x65, 0x03, 0x07]);
    assert_eq!(without.attribute_access(), Ok(AttributeAccess { attribute: AttributeId(3), value: &[7] }));
}

#[test]
fn requests_that_a_format_cannot_address() {
    let wide = Request::new(ServiceCode::RESET, ClassId(0x300), InstanceId(0x101), &[]);
    let mut buffer = [0; 16];
    for format in BodyFormat::ALL {
        let mut out = Writer::new(&mut buffer);
        let expected = if format.can_address(ClassId(0x300), InstanceId(0x101)) {
            Ok(())
        } else {
            Err(EmitError::NotAddressable(format))
        };
        assert_eq!(wide.emit(format, &mut out), expected, "{format}");
        assert_eq!(out.is_empty(), expected.is_err());
    }
    let path = Target::Path(Epath::packed(&[0x20, 0x01, 0x24]));
    let odd = Request { service: ServiceCode::RESET, target: path, data: &[] };
    let error = odd.emit(BodyFormat::CipPath, &mut Writer::new(&mut buffer));
    assert_eq!(error, Err(EmitError::NotAddressable(BodyFormat::CipPath)));
}

#[test]
fn an_attribute_request_puts_the_attribute_where_the_format_wants_it() {
    let request = AttributeRequest::set(ClassId(0x300), InstanceId(5), AttributeId(3), &[0xAA]);
    let mut buffer = [0; 16];
    let mut out = Writer::new(&mut buffer);
    request.emit(BodyFormat::CipPath, &mut out).unwrap();
    let read = Request::parse(BodyFormat::CipPath, out.written()).unwrap();
    assert_eq!(read.target.class(), Some(ClassId(0x300)));
    assert_eq!(read.attribute_access(), Ok(AttributeAccess { attribute: AttributeId(3), value: &[0xAA] }));

    let wide = AttributeRequest { attribute: AttributeId(256), ..request };
    let error = wide.emit(FORMAT_16_16, &mut Writer::new(&mut [0; 16]));
    assert_eq!(error, Err(EmitError::NotAddressable(FORMAT_16_16)));
    assert_eq!(request.emit(FORMAT_16_16, &mut Writer::new(&mut [0; 6])), Err(EmitError::Full(Full)));
}

#[test]
fn unknown_bits_of_a_choice_survive() {
    for bits in 0..=u8::MAX {
        let choice = AllocationChoice::from_bits_retain(bits);
        assert_eq!(choice.bits(), bits);
        laws::round_trip(&AllocateRequest { choice, allocator: bits }, &mut [0; 3]);
        laws::round_trip(&ReleaseRequest { choice }, &mut [0; 2]);
    }
    assert_eq!(AllocationChoice::from_bits_retain(0x81).to_string(), "explicit + reserved 0x80");
    assert_eq!(AllocationChoice::empty().to_string(), "nothing");
}

#[test]
fn reset_types() {
    laws::round_trip(&ResetRequest { kind: None }, &mut [0; 2]);
    laws::round_trip(&ResetRequest { kind: Some(ResetType::OUT_OF_BOX) }, &mut [0; 2]);
    assert!(ResetRequest::parse(&[0, 0]).is_err());
    assert!(ResetType(100).is_vendor_specific() && !ResetType(99).is_vendor_specific());
}

#[test]
fn replies_of_get_attribute_list() {
    let bytes = [3, 0, 1, 0, 0, 0, 0x2F, 0x00, 9, 0, 0x14, 0, 7, 0, 0, 0, 2, b'D', b'N'];
    let replies = AttributeReplies::parse(&bytes).unwrap();
    let len = |id: AttributeId, data: &[u8]| match id.0 {
        1 => Some(2),
        7 => Some(usize::from(*data.first()?) + 1),
        _ => None,
    };
    let found: Vec<_> = replies.iter(len).map(|reply| reply.unwrap().value).collect();
    assert_eq!(found, [Ok(&[0x2F, 0x00][..]), Err(GeneralStatus::ATTRIBUTE_NOT_SUPPORTED), Ok(b"\x02DN")]);
    assert_eq!(replies.iter(|_, _| None).count(), 1);

    let impossible = AttributeReplies::parse(&[1, 0, 9, 0, 0x00, 0x01]).unwrap();
    assert_eq!(impossible.iter(|_, _| Some(0)).next().unwrap().unwrap_err().field, "status");
}

#[test]
fn settings_of_set_attribute_list() {
    let settings = AttributeSettings::parse(&[2, 0, 9, 0, 0x4B, 0x00, 12, 0, 1]).unwrap();
    let len = |id: AttributeId, _: &[u8]| Some(if id.0 == 9 { 2 } else { 1 });
    let found: Vec<_> = settings.iter(len).map(Result::unwrap).collect();
    assert_eq!(found, [(AttributeId(9), &[0x4B, 0x00][..]), (AttributeId(12), &[1])]);

    let longer = AttributeSettings::parse(&[1, 0, 12, 0, 1, 0xFF]).unwrap();
    assert_eq!(longer.iter(len).last().unwrap().unwrap_err().kind, ParseErrorKind::Trailing { found: 1 });
    let shorter = AttributeSettings::parse(&[3, 0, 12, 0]).unwrap();
    assert!(shorter.iter(len).map(|entry| entry.unwrap_err().field).eq(["value"]));
}

/// A list that its reader could not take apart is not written, not even in part.
#[test]
fn lists_that_cannot_be_read_are_refused() {
    let mut buffer = std::vec![0; 200_000];
    let mut out = Writer::new(&mut buffer);
    let absent = AttributeReply { attribute: AttributeId(7), value: Err(GeneralStatus::SUCCESS) };
    let present = AttributeReply { attribute: AttributeId(1), value: Ok(&[1, 2]) };
    let error = AttributeReplies::emit_replies(&[present, absent], &mut out).unwrap_err();
    assert_eq!(error, ListError::NoValue(AttributeId(7)));
    assert_eq!(error.to_string(), "attribute 7: a reply without a value needs a status other than success");
    assert_eq!(InstanceList::emit_instances(&[InstanceId(1); 256], &mut out), Err(ListError::TooLong));
    assert_eq!(UintList::emit_numbers(&[0; 0x1_0000], &mut out), Err(ListError::TooLong));
    let long = [0; 0xFFFF];
    assert_eq!(emit_packets(&[&long, &[]], &mut out), Err(ListError::TooLong));
    assert!(out.is_empty());
    let mut short = [0; 5];
    let mut out = Writer::new(&mut short);
    assert_eq!(UintList::emit_numbers(&[1, 2], &mut out), Err(ListError::Full(Full)));
    assert!(out.is_empty());
}

#[test]
fn a_request_has_a_service_code_of_seven_bits() {
    let request = Request::new(ServiceCode(0x8E), ClassId::IDENTITY, InstanceId(1), &[7]);
    let mut buffer = [0; 8];
    let mut out = Writer::new(&mut buffer);
    assert_eq!(request.emit(FORMAT_8_8, &mut out), Err(EmitError::Service(ServiceCode(0x8E))));
    assert!(out.is_empty());
}

#[test]
fn multiple_service_packets_survive() {
    let services: [&[u8]; 3] = [&[0x0E, 1, 1, 1], &[], &[0x05, 1, 1]];
    let mut buffer = [0; 40];
    let mut out = Writer::new(&mut buffer);
    emit_packets(&services, &mut out).unwrap();
    let packet = MultipleServicePacket::parse(out.written()).unwrap();
    assert!(packet.services().eq(services));

    for bad in [&[1, 0, 3, 0][..], &[1, 0, 5, 0, 0], &[2, 0, 6, 0, 5, 0], &[2, 0, 6, 0, 7, 0], &[0, 0, 1]] {
        assert!(MultipleServicePacket::parse(bad).is_err(), "{bad:02X?}");
    }
    assert_eq!(MultipleServicePacket::parse(&[0, 0]).unwrap().services().count(), 0);
}

/// The bytes are those of the manuals and captures named above, and of Rockwell 1760-UM003A-EN-P, p. 4-11.
#[test]
fn requests_and_answers_in_words() {
    let cases: [(&[u8], &str, &[u8], &str); 7] = [
        (
            &[0x4B, 0x03, 0x01, 0x07, 0x0A],
            "Allocate_Master/Slave_Connection_Set DeviceNet instance 1, explicit + poll + bit-strobe, master 10",
            &[0xCB, 0x00],
            "Allocate_Master/Slave_Connection_Set ok, body format 8/8",
        ),
        (
            &[0x4B, 0x03, 0x01, 0x02, 0x01],
            "Allocate_Master/Slave_Connection_Set DeviceNet instance 1, poll, master 1",
            &[0x94, 0x0B, 0x02],
            "error 0x0B Already in requested mode/state, additional 0x02 invalid allocation/release choice",
        ),
        (
            &[0x4C, 0x03, 0x01, 0x01],
            "Release_Master/Slave_Connection_Set DeviceNet instance 1, explicit",
            &[0xCC],
            "Release_Master/Slave_Connection_Set ok",
        ),
        (
            &[0x0E, 0x01, 0x01, 0x01],
            "Get_Attribute_Single Identity instance 1, Vendor ID",
            &[0x8E, 0x6C, 0x00],
            "Get_Attribute_Single ok, Vendor ID 108 (Beckhoff)",
        ),
        (
            &[0x10, 0x65, 0x01, 0x01, 0x01, 0x46, 0x00],
            "Set_Attribute_Single class 0x65 instance 1, attribute 1 01 46 00",
            &[0x90],
            "Set_Attribute_Single ok",
        ),
        (
            &[0x05, 0x01, 0x01, 0x01],
            "Reset Identity instance 1, out-of-box configuration",
            &[0x85],
            "Reset ok",
        ),
        (
            &[0x32, 0x64, 0x01, 0x93, 0x05, 0x00],
            "service 0x32 class 0x64 instance 1, data 93 05 00",
            &[0xB2, 0xC2],
            "service 0x32 ok, data C2",
        ),
    ];
    for (request, request_text, response, answer_text) in cases {
        let request = Request::parse(FORMAT_8_8, request).unwrap();
        assert_eq!(request.to_string(), request_text);
        let answer = Answer { subject: request.subject(), response: Response::parse(response).unwrap() };
        assert_eq!(answer.to_string(), answer_text);
    }
}

fn formats() -> impl Strategy<Value = BodyFormat> {
    prop::sample::select(&BodyFormat::ALL[..])
}

proptest! {
    #[test]
    fn requests_survive(format in formats(), service in 0..0x80_u8, class: u16, instance: u16, data in vec(any::<u8>(), 0..40)) {
        prop_assume!(format.can_address(ClassId(class), InstanceId(instance)));
        let request = Request::new(ServiceCode(service), ClassId(class), InstanceId(instance), &data);
        let body = emitted(&request, format);
        let read = Request::parse(format, &body).unwrap();
        prop_assert_eq!((read.service, read.data), (request.service, request.data));
        prop_assert_eq!((read.target.class(), read.target.instance()), (Some(ClassId(class)), Some(InstanceId(instance))));
        let mut buffer = [0; 64];
        laws::round_trip_by(
            &read,
            Tail::Open,
            &mut buffer,
            |bytes| Request::parse(format, bytes),
            |request, out| request.emit(format, out),
            |request| request.wire_len(format),
        );
    }

    #[test]
    fn accepted_requests_are_emitted_again(format in formats(), body in vec(any::<u8>(), 0..40)) {
        if let Ok(request) = Request::parse(format, &body) {
            let _ = request.to_string();
            let _ = request.attribute_access();
            prop_assert_eq!(emitted(&request, format), body);
        }
    }

    #[test]
    fn fixed_bodies_keep_the_laws(byte: u8, number: u16, numbers in vec(any::<u16>(), 0..8), data in vec(any::<u8>(), 0..8)) {
        match AllocateResponse::from_code(byte) {
            Some(response) => { laws::round_trip(&response, &mut [0; 2]); }
            None => prop_assert!(byte > 0x0F),
        }
        laws::round_trip(&FindNextRequest { max: byte }, &mut [0; 2]);
        laws::round_trip(&MemberId(number), &mut [0; 3]);
        laws::round_trip(&MemberRequest { attribute: byte, member: number, value: &data }, &mut [0; 16]);
        laws::round_trip(&CreateResponse { instance: InstanceId(number), data: &data }, &mut [0; 16]);

        let items: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        let count = u8::try_from(numbers.len()).unwrap();
        let instances = [&[count], &items[..]].concat();
        laws::round_trip(&InstanceList::parse(&instances).unwrap(), &mut [0; 32]);
        let statuses = [&[count / 2, 0], &items[..usize::from(count / 2) * 4]].concat();
        laws::round_trip(&AttributeStatusList::parse(&statuses).unwrap(), &mut [0; 32]);
    }

    #[test]
    fn any_response_can_be_told(bytes in vec(any::<u8>(), 1..12), class in prop::sample::select(ClassId::NAMED), attribute in proptest::option::of(0..20_u16)) {
        let subject = Some(Subject { class, instance: InstanceId(1), attribute: attribute.map(AttributeId) });
        if let Ok(response) = Response::parse(&bytes) {
            let text = Answer { subject, response }.to_string();
            prop_assert_eq!(text.starts_with("error"), matches!(response, Response::Error { .. }));
        }
    }

    /// What is written is read as the same entries, and nothing of it fits into less room.
    #[test]
    fn lists_that_are_written_are_read(ids in vec((any::<u16>(), 1..=u8::MAX), 0..8), value in vec(any::<u8>(), 0..4)) {
        let mut buffer = [0; 80];
        let len = |_: AttributeId, _: &[u8]| Some(value.len());

        let instances: Vec<InstanceId> = ids.iter().map(|&(id, _)| InstanceId(id)).collect();
        let mut out = Writer::new(&mut buffer);
        InstanceList::emit_instances(&instances, &mut out).unwrap();
        prop_assert!(InstanceList::parse(out.written()).unwrap().iter().eq(instances.iter().copied()));

        let statuses: Vec<_> = ids.iter().map(|&(id, status)| (AttributeId(id), GeneralStatus(status))).collect();
        let mut out = Writer::new(&mut buffer);
        AttributeStatusList::emit_statuses(&statuses, &mut out).unwrap();
        let expected = statuses.iter().map(|&(id, status)| (id, u16::from(status.0)));
        prop_assert!(AttributeStatusList::parse(out.written()).unwrap().iter().eq(expected));

        let settings: Vec<_> = ids.iter().map(|&(id, _)| (AttributeId(id), &value[..])).collect();
        let mut out = Writer::new(&mut buffer);
        AttributeSettings::emit_settings(&settings, &mut out).unwrap();
        let read = AttributeSettings::parse(out.written()).unwrap();
        prop_assert!(read.iter(len).map(Result::unwrap).eq(settings.iter().copied()));

        let replies: Vec<_> = statuses.iter().map(|&(attribute, status)| AttributeReply {
            attribute,
            value: if status.0 % 2 == 0 { Ok(&value[..]) } else { Err(status) },
        }).collect();
        let mut out = Writer::new(&mut buffer);
        AttributeReplies::emit_replies(&replies, &mut out).unwrap();
        let last = out.len().saturating_sub(1);
        let read = AttributeReplies::parse(out.written()).unwrap();
        prop_assert!(read.iter(len).map(Result::unwrap).eq(replies.iter().copied()));
        let short = AttributeReplies::emit_replies(&replies, &mut Writer::new(&mut [0; 80][..last]));
        prop_assert_eq!(short, Err(ListError::Full(Full)));
    }

    #[test]
    fn lists_keep_the_laws(numbers in vec(any::<u16>(), 0..20)) {
        let mut buffer = [0; 64];
        let mut out = Writer::new(&mut buffer);
        UintList::emit_numbers(&numbers, &mut out).unwrap();
        let list = UintList::parse(out.written()).unwrap();
        prop_assert!(list.iter().eq(numbers.iter().copied()));
        laws::round_trip(&list, &mut [0; 64]);
    }
}
