//! The Parameter object.

use super::{ask, ask_effects};
use crate::code::{GeneralStatus, InstanceId};
use crate::codec::Writer;
use crate::data_type::DataType;
use crate::object::laws::agrees_with_names;
use crate::object::{
    CommonServices, Effect, Effects, Failure, FullParameter, International, Parameter, ParameterDescriptor,
    ParameterObject, ParameterStorage, Parameters, Scaling, ScalingLinks,
};
use proptest::prelude::*;
use std::vec;
use std::vec::Vec;

/// A speed with limits and scaling, a direction with names, a temperature to watch, a label, a switch, a gain.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Drive {
    values: [Vec<u8>; 6],
    busy: bool,
}

impl Parameters for Drive {
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::new(DataType::Int, &[0x20, 0x2A, 0x24, 0x01, 0x30, 0x08]).full(&FullParameter {
            minimum: &(-300_i16).to_le_bytes(),
            maximum: &300_i16.to_le_bytes(),
            default: &[0x0A, 0x00],
            scaling: Scaling { multiplier: 2, divisor: 3, base: 4, offset: -5, precision: 1 },
            links: ScalingLinks { multiplier: 0, divisor: 6, base: 0, offset: 0 },
            ..FullParameter::new(b"Speed", b"rpm", b"Of the shaft")
        }),
        Parameter::new(DataType::Usint, &[]).named_values(&[b"Left", b"Right"]),
        Parameter::new(DataType::Sint, &[]).monitor().full(&FullParameter {
            international: Some(International { name: &[1], units: &[2], help: &[3] }),
            ..FullParameter::new(b"Temperature", b"\xB0C", b"")
        }),
        Parameter::new(DataType::ShortString, &[]).sized(4),
        Parameter::new(DataType::Bool, &[]).full(&FullParameter::new(b"Enable", b"", b"")),
        Parameter::new(DataType::Real, &[]).full(&FullParameter {
            minimum: &0.5_f32.to_le_bytes(),
            ..FullParameter::new(b"Gain", b"", b"")
        }),
    ];

    fn value(&self, parameter: InstanceId, out: &mut Writer<'_>) -> Result<(), Failure> {
        Ok(out.bytes(&self.values[usize::from(parameter.0).wrapping_sub(1)])?)
    }

    fn set_value(&mut self, parameter: InstanceId, value: &[u8]) -> Result<(), Failure> {
        if self.busy {
            return Err(GeneralStatus::DEVICE_STATE_CONFLICT.into());
        }
        self.values[usize::from(parameter.0).wrapping_sub(1)] = value.to_vec();
        Ok(())
    }
}

fn drive() -> (ParameterObject<Drive>,) {
    let gain = 1.5_f32.to_le_bytes().to_vec();
    let values = [vec![0x34, 0x00], vec![1], vec![25], b"\x02ab".to_vec(), vec![1], gain];
    (ParameterObject::new(Drive { values, busy: false }),)
}

#[test]
fn stub_attributes() {
    for (attribute, expected) in [
        (1, &[0x8E, 0x34, 0x00][..]),
        (2, &[0x8E, 6]),
        (3, &[0x8E, 0x20, 0x2A, 0x24, 0x01, 0x30, 0x08]),
        (4, &[0x8E, 0x4C, 0x00]),
        (5, &[0x8E, 0xC3]),
        (6, &[0x8E, 2]),
    ] {
        assert_eq!(ask(&mut drive(), &[0x0E, 0x0F, 1, attribute]), expected, "attribute {attribute}");
    }
    assert_eq!(ask(&mut drive(), &[0x0E, 0x0F, 2, 2]), [0x8E, 0]);
    assert_eq!(ask(&mut drive(), &[0x0E, 0x0F, 2, 3]), [0x8E]);
    assert_eq!(ask(&mut drive(), &[0x0E, 0x0F, 2, 7]), [0x94, 0x14, 0xFF], "no full parameter");
    assert_eq!(ask(&mut drive(), &[0x0E, 0x0F, 4, 6]), [0x8E, 4]);
    assert_eq!(ask(&mut drive(), &[0x0E, 0x0F, 7, 1]), [0x94, 0x16, 0xFF]);
}

#[test]
fn full_attributes() {
    for (attribute, expected) in [
        (7, &b"\x8E\x05Speed"[..]),
        (8, b"\x8E\x03rpm"),
        (9, b"\x8E\x0COf the shaft"),
        (10, &[0x8E, 0xD4, 0xFE]),
        (11, &[0x8E, 0x2C, 0x01]),
        (12, &[0x8E, 0x0A, 0x00]),
        (13, &[0x8E, 2, 0]),
        (14, &[0x8E, 3, 0]),
        (15, &[0x8E, 4, 0]),
        (16, &[0x8E, 0xFB, 0xFF]),
        (17, &[0x8E, 0, 0]),
        (18, &[0x8E, 6, 0]),
        (19, &[0x8E, 0, 0]),
        (20, &[0x8E, 0, 0]),
        (21, &[0x8E, 1]),
        (22, &[0x94, 0x14, 0xFF]),
    ] {
        assert_eq!(ask(&mut drive(), &[0x0E, 0x0F, 1, attribute]), expected, "attribute {attribute}");
    }
    for (attribute, expected) in [(13, &[0x8E, 1, 0][..]), (22, &[0x8E, 1]), (24, &[0x8E, 3])] {
        assert_eq!(ask(&mut drive(), &[0x0E, 0x0F, 3, attribute]), expected, "attribute {attribute}");
    }
}

/// Limits that are not told are those of the type.
#[test]
fn limits_of_the_type() {
    for (parameter, attribute, expected) in [
        (3, 10, &[0x80][..]),
        (3, 11, &[0x7F]),
        (3, 12, &[0x00]),
        (5, 10, &[0]),
        (5, 11, &[1]),
        (6, 11, &f32::MAX.to_le_bytes()),
        (6, 12, &[0, 0, 0, 0]),
    ] {
        let answer = ask(&mut drive(), &[0x0E, 0x0F, parameter, attribute]);
        assert_eq!(answer[1..], *expected, "parameter {parameter}, attribute {attribute}");
    }
}

#[test]
fn descriptors() {
    let descriptor = |index: usize| Drive::PARAMETERS[index].descriptor();
    assert_eq!(descriptor(1), ParameterDescriptor::NAMED_VALUES);
    assert_eq!(descriptor(2), ParameterDescriptor::READ_ONLY | ParameterDescriptor::MONITOR);
    assert_eq!(descriptor(3), ParameterDescriptor::empty());
    let scaled = ParameterDescriptor::SCALING
        | ParameterDescriptor::SCALING_LINKS
        | ParameterDescriptor::EXTENDED_PRECISION;
    assert_eq!(descriptor(0), scaled);
}

#[test]
fn class_attributes() {
    let mut set = drive();
    for (attribute, expected) in [
        (1, &[0x8E, 1, 0][..]),
        (2, &[0x8E, 6, 0]),
        (3, &[0x94, 0x14, 0xFF]),
        (8, &[0x8E, 0x01, 0]),
        (9, &[0x8E, 0, 0]),
        (10, &[0x8E, 1]),
    ] {
        assert_eq!(ask(&mut set, &[0x0E, 0x0F, 0, attribute]), expected, "attribute {attribute}");
    }
    set.0.storage = ParameterStorage::SAVE | ParameterStorage::NON_VOLATILE;
    set.0.configuration_assembly = InstanceId(0x0102);
    assert_eq!(ask(&mut set, &[0x0E, 0x0F, 0, 8]), [0x8E, 0x0D, 0]);
    assert_eq!(ask(&mut set, &[0x0E, 0x0F, 0, 9]), [0x8E, 0x02, 0x01]);
    let found = ask(&mut (CommonServices(set.0),), &[0x11, 0x0F, 4, 9]);
    assert_eq!(found, [0x91, 2, 5, 0, 6, 0]);
}

#[test]
fn set_judges_length_then_limits_then_state() {
    for (parameter, data, status) in [
        (1, &[0x2C, 0x01][..], 0x00),
        (1, &[0x2D, 0x01], 0x09),
        (1, &[0xD4, 0xFE], 0x00),
        (1, &[0xD3, 0xFE], 0x09),
        (1, &[0xD3], 0x13),
        (1, &[0xD3, 0xFE, 0], 0x15),
        (2, &[0xFF], 0x00),
        (3, &[0], 0x08),
        (4, b"\x03abc", 0x00),
        (4, b"\x03ab", 0x13),
        (4, b"\x03abcd", 0x15),
        (4, b"\x04abcd", 0x15),
        (4, b"", 0x13),
        (5, &[1], 0x00),
        (5, &[2], 0x09),
        (6, &0.25_f32.to_le_bytes(), 0x09),
        (6, &f32::NAN.to_le_bytes(), 0x09),
        (6, &1e30_f32.to_le_bytes(), 0x00),
    ] {
        let request = [&[0x10, 0x0F, parameter, 1], data].concat();
        for busy in [false, true] {
            let mut set = drive();
            set.0.parameters.busy = busy;
            let answer = ask_effects(&mut set, &request);
            let expected = match (status, busy) {
                (0, false) => (vec![0x90], (Effect::PARAMETER_VALUE | Effect::ATTRIBUTE_SET).into()),
                (0, true) => (vec![0x94, 0x10, 0xFF], Effects::NONE),
                _ => (vec![0x94, status, 0xFF], Effects::NONE),
            };
            assert_eq!(answer, expected, "parameter {parameter} {data:02X?}");
            let index = usize::from(parameter).wrapping_sub(1);
            let kept = if status == 0 && !busy { data } else { &drive().0.parameters.values[index] };
            assert_eq!(set.0.parameters.values[index], kept);
        }
    }
    assert_eq!(ask(&mut drive(), &[0x10, 0x0F, 1, 2, 0]), [0x94, 0x0E, 0xFF]);
    assert_eq!(ask(&mut drive(), &[0x10, 0x0F, 0, 10, 1]), [0x94, 0x08, 0xFF]);
}

#[test]
fn names_of_values() {
    assert_eq!(ask(&mut drive(), &[0x4B, 0x0F, 2, 0]), *b"\xCB\x04Left");
    assert_eq!(ask(&mut drive(), &[0x4B, 0x0F, 2, 1]), *b"\xCB\x05Right");
    for (body, status) in [
        (&[0x4B, 0x0F, 2, 2][..], 0x20),
        (&[0x4B, 0x0F, 2], 0x13),
        (&[0x4B, 0x0F, 2, 0, 0], 0x15),
        (&[0x4B, 0x0F, 1, 0], 0x08),
        (&[0x4B, 0x0F, 0, 0], 0x08),
    ] {
        assert_eq!(ask(&mut drive(), body), [0x94, status, 0xFF], "{body:02X?}");
    }
}

#[test]
fn services_of_the_class_are_effects() {
    for (service, offer, effect) in [
        (0x05, ParameterStorage::RESET, Effect::PARAMETERS_RESET),
        (0x15, ParameterStorage::RESTORE, Effect::PARAMETERS_RESTORE),
        (0x16, ParameterStorage::SAVE, Effect::PARAMETERS_SAVE),
    ] {
        let mut set = drive();
        assert_eq!(ask(&mut set, &[service, 0x0F, 0]), [0x94, 0x08, 0xFF]);
        set.0.storage = offer;
        assert_eq!(ask_effects(&mut set, &[service, 0x0F, 0]), (vec![service | 0x80], effect.into()));
        assert_eq!(ask(&mut set, &[service, 0x0F, 0, 0]), [0x94, 0x15, 0xFF]);
        assert_eq!(ask(&mut set, &[service, 0x0F, 1]), [0x94, 0x08, 0xFF], "of an instance");
    }
}

#[test]
fn get_attributes_all_is_in_order() {
    let full = ask(&mut drive(), &[0x01, 0x0F, 1]);
    let expected = [
        &[0x81, 0x34, 0x00, 6, 0x20, 0x2A, 0x24, 0x01, 0x30, 0x08, 0x4C, 0x00, 0xC3, 2][..],
        b"\x05Speed\x03rpm\x0COf the shaft",
        &[0xD4, 0xFE, 0x2C, 0x01, 0x0A, 0x00, 2, 0, 3, 0, 4, 0, 0xFB, 0xFF, 0, 0, 6, 0, 0, 0, 0, 0, 1],
    ];
    assert_eq!(full, expected.concat());
    assert_eq!(ask(&mut drive(), &[0x01, 0x0F, 2]), [0x81, 1, 0, 2, 0, 0xC6, 1]);
    assert_eq!(ask(&mut drive(), &[0x01, 0x0F, 0]), [0x94, 0x08, 0xFF]);
}

#[test]
fn definitions_are_checked() {
    assert!(Drive::PARAMETERS.iter().all(Parameter::is_valid));
    let limits = |minimum, maximum, default| {
        let full = FullParameter { minimum, maximum, default, ..FullParameter::new(b"x", b"", b"") };
        Parameter::new(DataType::Sint, &[]).full(std::boxed::Box::leak(std::boxed::Box::new(full))).is_valid()
    };
    assert!(limits(&[0xFF], &[1], &[0]));
    assert!(!limits(&[2], &[1], &[]), "minimum above the maximum");
    assert!(!limits(&[0xFF], &[1], &[2]), "default above the maximum");
    assert!(!limits(&[0, 0], &[1], &[1]), "two bytes for one");
    assert!(!Parameter::new(DataType::String, &[]).is_valid(), "no size");
    const LONG: FullParameter = FullParameter::new(b"seventeen letters", b"", b"");
    assert!(!Parameter::new(DataType::Sint, &[]).full(&LONG).is_valid());
}

#[test]
fn tables_agree_with_the_names() {
    agrees_with_names(&drive().0, &[1, 2, 3, 4, 5, 6]);
}

proptest! {
    /// Limits hold for all values of a signed and an unsigned type.
    #[test]
    fn limits_hold(value: i16) {
        let mut set = drive();
        let answer = ask(&mut set, &[&[0x10, 0x0F, 1, 1][..], &value.to_le_bytes()].concat());
        prop_assert_eq!(answer[0] == 0x90, (-300..=300).contains(&value));
    }
}
