//! Which error answers which defect, and which of two defects answers. The row numbers are those of the order of
//! checks: 1 short body, 2 response bit, 3 class, 4 instance, 5 path, 6 service, 7 attribute missing, 8 attribute
//! unknown, 9 read-only, 10 short data, 11 long data, 12 value, 13 object state, 14 device state, 15 parameter,
//! 16 reply too large, 17 storage, 18 general failure of a small server.
//!
//! Which comes first of rows 12 to 17 is the object's business, and tested with each: value, state, storage in
//! `assembly`, value and state in `acknowledge_handler`, length, state, parameter of a Reset in `identity`.

use super::answer;
use crate::code::{AttributeId, ClassId, GeneralStatus, InstanceId, ServiceCode};
use crate::codec::Writer;
use crate::message::{BodyFormat, Request};
use crate::object::{AttributeRule, Call, Effects, Failure, FailureOptions, Object, Size, exact};

/// Class 0x64 with the instance 1, which keeps a UINT of up to 1000 in attribute 2 unless it is `busy`.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Probe {
    pub(super) value: u16,
    /// What a Set finds beyond the value.
    pub(super) busy: Option<GeneralStatus>,
}

impl Object for Probe {
    const CLASS: ClassId = ClassId(0x64);
    const REVISION: u16 = 3;

    fn attributes(&self, instance: InstanceId) -> Option<&'static [AttributeRule]> {
        const RULES: &[AttributeRule] = &[
            AttributeRule::get(1, 2),
            AttributeRule::get_set(2, 2),
            AttributeRule::get(3, 80),
            AttributeRule::get_set(4, 0).sized(Size::ShortString),
        ];
        match instance.0 {
            1 => Some(RULES),
            2 => Some(&RULES[..1]),
            3 => Some(&[]),
            _ => None,
        }
    }

    fn get(
        &self,
        _instance: InstanceId,
        attribute: AttributeId,
        out: &mut Writer<'_>,
    ) -> Result<(), Failure> {
        match attribute.0 {
            3 => Ok(out.bytes(&[0; 80])?),
            4 => Ok(out.bytes(b"\x02ok")?),
            _ => Ok(out.u16(self.value)?),
        }
    }

    fn set(
        &mut self,
        _instance: InstanceId,
        attribute: AttributeId,
        value: &[u8],
        _out: &mut Writer<'_>,
    ) -> Result<Effects, Failure> {
        if attribute.0 == 4 {
            return Ok(Effects::NONE);
        }
        let value = u16::from_le_bytes(exact(value)?);
        if value > 1000 {
            return Err(GeneralStatus::INVALID_ATTRIBUTE_VALUE.into());
        }
        if let Some(status) = self.busy {
            return Err(status.into());
        }
        self.value = value;
        Ok(Effects::NONE)
    }

    fn service(&mut self, call: &Call<'_>, out: &mut Writer<'_>) -> Result<Effects, Failure> {
        match call.service {
            ServiceCode::RESET => match exact(call.data)? {
                [0] => Ok(Effects::NONE),
                [_] => Err(GeneralStatus::INVALID_PARAMETER.into()),
            },
            // Writes more than there is room for, after something that fits.
            ServiceCode::NO_OPERATION => {
                out.u32(1)?;
                out.bytes(&[0; 80])?;
                Ok(Effects::NONE)
            }
            _ => Err(GeneralStatus::SERVICE_NOT_SUPPORTED.into()),
        }
    }
}

pub(super) fn probe() -> Probe {
    Probe { value: 0x1234, busy: None }
}

macro_rules! answers {
    ($($name:ident: $format:ident $body:expr => $response:expr;)*) => {$(
        #[test]
        fn $name() {
            let mut objects = (probe(),);
            let (response, _) =
                answer(&mut objects, BodyFormat::$format, FailureOptions::default(), &$body);
            assert_eq!(response, $response);
            assert_eq!(objects.0, probe(), "a request that is refused, or reads, changes nothing");
        }
    )*};
}

answers! {
    no_defect_get: Class8Instance8 [0x0E, 0x64, 1, 1] => [0x8E, 0x34, 0x12];
    no_defect_set_short_string: Class8Instance8 [0x10, 0x64, 1, 4, 2, b'o', b'k'] => [0x90];
    no_defect_class_attribute: Class8Instance8 [0x0E, 0x64, 0, 1] => [0x8E, 3, 0];
    no_defect_8_16: Class8Instance16 [0x0E, 0x64, 1, 0, 1] => [0x8E, 0x34, 0x12];
    no_defect_16_16: Class16Instance16 [0x0E, 0x64, 0, 1, 0, 1] => [0x8E, 0x34, 0x12];
    no_defect_16_8: Class16Instance8 [0x0E, 0x64, 0, 1, 1] => [0x8E, 0x34, 0x12];
    no_defect_path: CipPath [0x0E, 3, 0x20, 0x64, 0x24, 1, 0x30, 1] => [0x8E, 0x34, 0x12];
    no_defect_path_attribute_in_data: CipPath [0x0E, 2, 0x20, 0x64, 0x24, 1, 1] => [0x8E, 0x34, 0x12];
    no_defect_path_of_the_class: CipPath [0x0E, 1, 0x20, 0x64, 1] => [0x8E, 3, 0];

    row_3_class: Class8Instance8 [0x0E, 0x63, 1, 1] => [0x94, 0x16, 0xFF];
    row_3_class_of_16_bits: Class16Instance16 [0x0E, 0x64, 1, 1, 0, 1] => [0x94, 0x16, 0xFF];
    row_4_instance: Class8Instance8 [0x0E, 0x64, 9, 1] => [0x94, 0x16, 0xFF];
    row_4_instance_of_16_bits: Class16Instance16 [0x0E, 0x64, 0, 1, 1, 1] => [0x94, 0x16, 0xFF];
    row_5_segment: CipPath [0x0E, 3, 0x20, 0x64, 0x24, 1, 0xFF, 1] => [0x94, 0x04, 0xFF];
    row_5_cut_segment: CipPath [0x0E, 3, 0x20, 0x64, 0x24, 1, 0x32, 0] => [0x94, 0x04, 0xFF];
    row_5_attribute_of_32_bits: CipPath [0x0E, 4, 0x20, 0x64, 0x24, 1, 0x26, 0, 0, 1] => [0x94, 0x04, 0xFF];
    row_5_no_class: CipPath [0x0E, 1, 0x24, 1, 1] => [0x94, 0x04, 0xFF];
    row_5_empty_path: CipPath [0x0E, 0, 1] => [0x94, 0x04, 0xFF];
    row_6_service: Class8Instance8 [0x32, 0x64, 1] => [0x94, 0x08, 0xFF];
    row_6_set_of_an_instance_without_settable_attributes: Class8Instance8 [0x10, 0x64, 2, 1, 0, 0] => [0x94, 0x08, 0xFF];
    row_6_set_of_the_class: Class8Instance8 [0x10, 0x64, 0, 1, 0, 0] => [0x94, 0x08, 0xFF];
    row_7_get: Class8Instance8 [0x0E, 0x64, 1] => [0x94, 0x13, 0xFF];
    row_7_set: Class8Instance8 [0x10, 0x64, 1] => [0x94, 0x13, 0xFF];
    row_8_get: Class8Instance8 [0x0E, 0x64, 1, 99] => [0x94, 0x14, 0xFF];
    row_8_set: Class8Instance8 [0x10, 0x64, 1, 99, 0, 0] => [0x94, 0x14, 0xFF];
    row_8_attribute_of_16_bits: CipPath [0x0E, 4, 0x20, 0x64, 0x25, 1, 0, 0x31, 1, 1] => [0x94, 0x14, 0xFF];
    row_8_instance_without_attributes: Class8Instance8 [0x0E, 0x64, 3, 1] => [0x94, 0x14, 0xFF];
    row_9_read_only: Class8Instance8 [0x10, 0x64, 1, 1, 0, 0] => [0x94, 0x0E, 0xFF];
    row_10_short: Class8Instance8 [0x10, 0x64, 1, 2, 0] => [0x94, 0x13, 0xFF];
    row_10_nothing: Class8Instance8 [0x10, 0x64, 1, 2] => [0x94, 0x13, 0xFF];
    row_10_short_string: Class8Instance8 [0x10, 0x64, 1, 4, 2, b'o'] => [0x94, 0x13, 0xFF];
    row_10_no_string: Class8Instance8 [0x10, 0x64, 1, 4] => [0x94, 0x13, 0xFF];
    row_11_long: Class8Instance8 [0x10, 0x64, 1, 2, 0, 0, 0] => [0x94, 0x15, 0xFF];
    row_11_long_string: Class8Instance8 [0x10, 0x64, 1, 4, 1, b'o', b'k'] => [0x94, 0x15, 0xFF];
    row_11_get_with_data: Class8Instance8 [0x0E, 0x64, 1, 1, 0] => [0x94, 0x15, 0xFF];
    row_12_value: Class8Instance8 [0x10, 0x64, 1, 2, 0xE9, 0x03] => [0x94, 0x09, 0xFF];
    row_15_parameter: Class8Instance8 [0x05, 0x64, 1, 3] => [0x94, 0x20, 0xFF];
    row_16_get: Class8Instance8 [0x0E, 0x64, 1, 3] => [0x94, 0x11, 0xFF];
    row_16_service_leaves_no_half_of_a_reply: Class8Instance8 [0x17, 0x64, 1] => [0x94, 0x11, 0xFF];

    rows_3_4_class_before_instance: Class8Instance8 [0x0E, 0x63, 9, 1] => [0x94, 0x16, 0xFF];
    rows_3_5_class_before_path: CipPath [0x0E, 3, 0x20, 0x63, 0x24, 1, 0xFF, 1] => [0x94, 0x16, 0xFF];
    rows_4_5_instance_before_path: CipPath [0x0E, 3, 0x20, 0x64, 0x24, 9, 0xFF, 1] => [0x94, 0x16, 0xFF];
    rows_4_6_instance_before_service: Class8Instance8 [0x32, 0x64, 9] => [0x94, 0x16, 0xFF];
    rows_5_6_path_before_service: CipPath [0x32, 3, 0x20, 0x64, 0x24, 1, 0xFF, 1] => [0x94, 0x04, 0xFF];
    rows_5_7_path_before_missing_attribute: CipPath [0x0E, 3, 0x20, 0x64, 0x24, 1, 0xFF, 1] => [0x94, 0x04, 0xFF];
    rows_5_8_path_before_unknown_attribute: CipPath [0x0E, 4, 0x20, 0x64, 0x24, 1, 0x30, 99, 0xFF, 1] => [0x94, 0x04, 0xFF];
    rows_5_11_path_before_long: CipPath [0x0E, 4, 0x20, 0x64, 0x24, 1, 0x30, 1, 0xFF, 1, 0] => [0x94, 0x04, 0xFF];
    rows_6_7_service_before_missing_attribute: Class8Instance8 [0x10, 0x64, 2] => [0x94, 0x08, 0xFF];
    rows_6_8_service_before_unknown_attribute: Class8Instance8 [0x10, 0x64, 2, 99, 0] => [0x94, 0x08, 0xFF];
    rows_6_9_service_before_read_only: Class8Instance8 [0x10, 0x64, 2, 1, 0, 0] => [0x94, 0x08, 0xFF];
    rows_7_10_missing_attribute_and_value: Class8Instance8 [0x10, 0x64, 1] => [0x94, 0x13, 0xFF];
    rows_8_9_unknown_before_read_only: Class8Instance8 [0x10, 0x64, 1, 0, 0, 0] => [0x94, 0x14, 0xFF];
    rows_8_11_unknown_before_long: Class8Instance8 [0x0E, 0x64, 1, 99, 0] => [0x94, 0x14, 0xFF];
    rows_9_10_read_only_before_short: Class8Instance8 [0x10, 0x64, 1, 1, 0] => [0x94, 0x0E, 0xFF];
    rows_9_11_read_only_before_long: Class8Instance8 [0x10, 0x64, 1, 1, 0, 0, 0] => [0x94, 0x0E, 0xFF];
    rows_10_12_short_before_value: Class8Instance8 [0x10, 0x64, 1, 2, 0xFF] => [0x94, 0x13, 0xFF];
    rows_11_12_long_before_value: Class8Instance8 [0x10, 0x64, 1, 2, 0xFF, 0xFF, 0] => [0x94, 0x15, 0xFF];
    rows_11_15_long_before_parameter: Class8Instance8 [0x05, 0x64, 1, 3, 0] => [0x94, 0x15, 0xFF];
    rows_11_16_long_before_large_reply: Class8Instance8 [0x0E, 0x64, 1, 3, 0] => [0x94, 0x15, 0xFF];
}

#[test]
fn no_defect_set_keeps_the_value() {
    for (format, body) in [
        (BodyFormat::Class8Instance8, &[0x10, 0x64, 1, 2, 0x34, 0x02][..]),
        (BodyFormat::CipPath, &[0x10, 3, 0x20, 0x64, 0x24, 1, 0x30, 2, 0x34, 0x02]),
        (BodyFormat::CipPath, &[0x10, 2, 0x20, 0x64, 0x24, 1, 2, 0x34, 0x02]),
    ] {
        let mut objects = (probe(),);
        let (response, _) = answer(&mut objects, format, FailureOptions::default(), body);
        assert_eq!((response, objects.0.value), (std::vec![0x90], 0x0234), "{format}");
    }
}

/// Rows 1 and 2 are before any object: there is no request, and so no answer.
#[test]
fn row_1_short_body_is_no_request() {
    for (format, shortest) in [
        (BodyFormat::Class8Instance8, 3),
        (BodyFormat::Class8Instance16, 4),
        (BodyFormat::Class16Instance16, 5),
        (BodyFormat::Class16Instance8, 4),
        (BodyFormat::CipPath, 2),
    ] {
        let body = [0x0E, 0, 0, 0, 0];
        assert!(Request::parse(format, &body[..shortest]).is_ok(), "{format}");
        for len in 0..shortest {
            assert!(Request::parse(format, &body[..len]).unwrap_err().is_short(), "{format} {len}");
        }
    }
}

#[test]
fn row_2_response_bit_is_no_request() {
    assert!(Request::parse(BodyFormat::Class8Instance8, &[0x8E, 0x64, 1, 1]).is_err());
}

#[test]
fn rows_2_3_response_bit_before_unknown_class() {
    assert!(Request::parse(BodyFormat::Class8Instance8, &[0x8E, 0x63, 1, 1]).is_err());
}

#[test]
fn rows_1_2_short_body_with_response_bit_is_no_request() {
    assert!(Request::parse(BodyFormat::Class8Instance8, &[0x8E, 0x64]).is_err());
}

/// Rows 12, 13, 14 and 17 are the object's: its status is the answer, and it judges the value first.
#[test]
fn rows_12_13_14_17_are_answered_as_the_object_says() {
    for (busy, status) in [
        (GeneralStatus::OBJECT_STATE_CONFLICT, 0x0C),
        (GeneralStatus::DEVICE_STATE_CONFLICT, 0x10),
        (GeneralStatus::STORE_OPERATION_FAILURE, 0x19),
    ] {
        let mut objects = (Probe { value: 7, busy: Some(busy) },);
        assert_eq!(super::ask(&mut objects, &[0x10, 0x64, 1, 2, 0, 0]), [0x94, status, 0xFF]);
        assert_eq!(super::ask(&mut objects, &[0x10, 0x64, 1, 2, 0, 0, 0]), [0x94, 0x15, 0xFF]);
        assert_eq!(super::ask(&mut objects, &[0x10, 0x64, 1, 2, 0xFF, 0xFF]), [0x94, 0x09, 0xFF]);
        assert_eq!(objects.0.value, 7);
    }
}

#[test]
fn row_18_a_small_server_answers_a_general_failure() {
    let options = FailureOptions { group_2_only_failure: true, ..FailureOptions::default() };
    for (body, status) in [
        (&[0x32, 0x64, 1][..], 0x2A),
        (&[0x0E, 0x64, 1, 99], 0x2A),
        (&[0x10, 0x64, 1, 1, 0, 0], 0x2A),
        (&[0x0E, 0x63, 1, 1], 0x16),
        (&[0x0E, 0x64, 1], 0x13),
        (&[0x10, 0x64, 1, 2, 0, 0, 0], 0x15),
        (&[0x10, 0x64, 1, 2, 0xFF, 0xFF], 0x09),
    ] {
        let (response, _) = answer(&mut (probe(),), BodyFormat::Class8Instance8, options, body);
        assert_eq!(response, [0x94, status, 0xFF], "{body:02X?}");
    }
}

#[test]
fn row_3_of_a_path_by_option() {
    let options = FailureOptions { path_destination_unknown: true, ..FailureOptions::default() };
    for (format, body, status) in [
        (BodyFormat::CipPath, &[0x0E, 2, 0x20, 0x63, 0x24, 1, 1][..], 0x05),
        (BodyFormat::CipPath, &[0x0E, 2, 0x20, 0x64, 0x24, 9, 1], 0x05),
        (BodyFormat::CipPath, &[0x0E, 2, 0x20, 0x64, 0x24, 1, 99], 0x14),
        (BodyFormat::Class8Instance8, &[0x0E, 0x63, 1, 1], 0x16),
    ] {
        let (response, _) = answer(&mut (probe(),), format, options, body);
        assert_eq!(response, [0x94, status, 0xFF], "{body:02X?}");
    }
}
