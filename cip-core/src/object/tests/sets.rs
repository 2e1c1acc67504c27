//! Sets of objects, and what is left to do after a service.

use super::{ask, ask_effects};
use crate::code::{AttributeId, ClassId, GeneralStatus, InstanceId, ServiceCode};
use crate::codec::Writer;
use crate::message::ResetType;
use crate::object::{
    AttributeRule, Call, Chain, Effect, Effects, Failure, FailureOptions, Object, ObjectSet, respond,
};
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
    assert_eq!(both, Effects { reset: Some(ResetType::POWER_CYCLE), of: Effect::HEARTBEAT_INTERVAL });
    assert_eq!(both.then(Effects::reset(ResetType::OUT_OF_BOX)).reset, Some(ResetType::OUT_OF_BOX));
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
