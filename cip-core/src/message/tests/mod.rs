//! Requests and responses.

mod golden;
mod lists;
mod properties;

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
fn a_request_has_a_service_code_of_seven_bits() {
    let request = Request::new(ServiceCode(0x8E), ClassId::IDENTITY, InstanceId(1), &[7]);
    let mut buffer = [0; 8];
    let mut out = Writer::new(&mut buffer);
    assert_eq!(request.emit(FORMAT_8_8, &mut out), Err(EmitError::Service(ServiceCode(0x8E))));
    assert!(out.is_empty());
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
