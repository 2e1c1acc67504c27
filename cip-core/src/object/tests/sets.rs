//! Sets of objects, and what is left to do after a service.

use super::{answer, ask, ask_effects};
use crate::code::{AttributeId, ClassId, DeviceType, GeneralStatus, InstanceId, ServiceCode, VendorId};
use crate::codec::Writer;
use crate::identity::{DeviceIdentity, ProductName, Revision};
use crate::message::{BodyFormat, ResetType};
use crate::object::{
    AcknowledgeHandler, AcknowledgeSettings, AttributeRule, Call, Chain, CommonServices, Effect, Effects,
    Failure, FailureOptions, Identity, Object, ObjectSet, Router, Size, respond,
};
use proptest::{collection::vec, prelude::*};
use std::vec::Vec;

/// A class whose only attribute is its own byte.
struct Byte<const CLASS: u16>(u8);

impl<const CLASS: u16> Object for Byte<CLASS> {
    const CLASS: ClassId = ClassId(CLASS);

    fn attributes(&self, instance: InstanceId) -> Option<&'static [AttributeRule]> {
        (instance.0 == 1).then_some(const { &[AttributeRule::get_set(1, 1)] })
    }

    fn get(&self, _: InstanceId, _: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure> {
        Ok(out.u8(self.0)?)
    }

    fn set(
        &mut self,
        _: InstanceId,
        _: AttributeId,
        value: &[u8],
        out: &mut Writer<'_>,
    ) -> Result<Effects, Failure> {
        out.bytes(value)?;
        self.0 = value[0];
        Ok(Effects::NONE)
    }
}

#[test]
fn a_request_reaches_the_object_of_its_class() {
    let mut set = Chain((Byte::<0x64>(4), Byte::<0x65>(5)), Chain((), (Byte::<0x66>(6), Byte::<0x64>(0))));
    for class in [0x64, 0x65, 0x66] {
        assert_eq!(ask(&mut set, &[0x0E, class, 1, 1]), [0x8E, class - 0x60]);
    }
    assert_eq!(ask(&mut set, &[0x0E, 0x67, 1, 1]), [0x94, 0x16, 0xFF]);
    let classes: Vec<_> = set.classes().collect();
    assert_eq!(classes, [ClassId(0x64), ClassId(0x65), ClassId(0x66), ClassId(0x64)]);
    assert!(set.contains(ClassId(0x66)) && !set.contains(ClassId(0x67)));
}

#[test]
fn borrowed_objects_and_sets_are_served() {
    let (mut object, mut set) = (Byte::<0x64>(4), (Byte::<0x65>(5),));
    assert_eq!(ask(&mut Chain((&mut object,), &mut set), &[0x10, 0x64, 1, 1, 9]), [0x90, 9]);
    assert_eq!(ask(&mut Chain((&mut object,), &mut set), &[0x10, 0x65, 1, 1, 8]), [0x90, 8]);
    assert_eq!((object.0, set.0.0), (9, 8));
}

#[test]
fn a_set_is_told() {
    let mut set = (Byte::<0x64>(4),);
    assert_eq!(ask_effects(&mut set, &[0x10, 0x64, 1, 1, 9]).1, Effect::ATTRIBUTE_SET.into());
    assert_eq!(ask_effects(&mut set, &[0x0E, 0x64, 1, 1]).1, Effects::NONE);
}

#[test]
fn effects_add_up() {
    let both = Effects::reset(ResetType::POWER_CYCLE).then(Effect::HEARTBEAT_INTERVAL.into());
    assert_eq!(both, Effects::reset(ResetType::POWER_CYCLE).then(Effect::HEARTBEAT_INTERVAL.into()));
    assert_eq!(both.then(Effects::reset(ResetType::OUT_OF_BOX)).reset_type(), Some(ResetType::OUT_OF_BOX));
    assert!(Effects::NONE.is_none() && !both.is_none());
}

#[test]
fn a_response_without_room_is_a_failure_and_leaves_nothing_but_the_refusal() {
    let call = Call::new(ServiceCode::GET_ATTRIBUTE_SINGLE, ClassId(0x64), InstanceId(1), &[1]);
    let too_large = Failure::new(GeneralStatus::REPLY_DATA_TOO_LARGE);
    for (room, expected) in [(0, &[][..]), (1, &[]), (2, &[0x8E, 4])] {
        let mut buffer = [0xA5; 4];
        let mut out = Writer::new(&mut buffer[..room]);
        let result = respond(&mut (Byte::<0x64>(4),), &call, FailureOptions::default(), &mut out);
        assert_eq!(out.written(), expected);
        assert_eq!(result, if room < 2 { Err(too_large) } else { Ok(Effects::NONE) });
    }
}

/// What a small device has most of, and what every service returns.
#[test]
fn tables_and_results_are_small() {
    assert_eq!(size_of::<AttributeRule>(), 4);
    // One and two registers of a small processor.
    assert_eq!(size_of::<Result<(), Failure>>(), 4);
    assert_eq!(size_of::<Result<Effects, Failure>>(), 8);
}

#[test]
fn sizes_survive_their_packing() {
    for size in [Size::Bytes(0), Size::Bytes(34), Size::Bytes(0x7FFD), Size::ShortString, Size::Any] {
        for rule in [AttributeRule::get(7, 1), AttributeRule::get_set(7, 1)] {
            let sized = rule.sized(size);
            assert_eq!((sized.id(), sized.access(), sized.size()), (rule.id(), rule.access(), size));
        }
    }
    assert_eq!(AttributeRule::get(7, 0xFFFF).size(), Size::Bytes(0x7FFD));
}

proptest! {
    /// Whatever the bytes and the format, a device with everything answers once: with the service, or with an error.
    #[test]
    fn any_request_has_one_answer(
        format in prop::sample::select(&BodyFormat::ALL),
        head in (0..0x20_u8, prop::sample::select(&[1_u8, 2, 4, 0x2B, 0x64, 0x66]), 0..3_u8),
        data in vec(prop_oneof![0..8_u8, any::<u8>()], 0..16),
    ) {
        let (service, class, instance) = head;
        let target = match format {
            BodyFormat::Class8Instance8 => std::vec![class, instance],
            BodyFormat::Class8Instance16 => std::vec![class, instance, 0],
            BodyFormat::Class16Instance16 => std::vec![class, 0, instance, 0],
            BodyFormat::Class16Instance8 => std::vec![class, 0, instance],
            BodyFormat::CipPath => std::vec![2, 0x20, class, 0x24, instance],
        };
        let device = DeviceIdentity {
            vendor: VendorId(1),
            device_type: DeviceType::GENERIC,
            product_code: 1,
            revision: Revision { major: 1, minor: 1 },
            serial: 1,
            name: ProductName::default(),
        };
        let mut acknowledge = AcknowledgeSettings::default();
        let objects = (
            CommonServices(Identity { heartbeat_interval: Some(0), ..Identity::new(&device) }),
            CommonServices(AcknowledgeHandler::new(&mut acknowledge)),
            CommonServices(Byte::<0x64>(0)),
        );
        let body = [&[service][..], &target, &data].concat();
        let mut router = Router::new(objects, format);
        let (answer, effects) = answer(&mut router, format, FailureOptions::default(), &body);
        match answer[..] {
            [0x94, _, additional] => prop_assert!(additional == 0xFF && effects.is_none()),
            _ => prop_assert_eq!(answer[0], service | 0x80),
        }
    }
}
