//! Messages as manuals print them and captures show them.

use super::*;

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
