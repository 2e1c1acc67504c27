//! The common services for several attributes and instances. Layouts: CIP Vol. 1, appendix A.

use super::order::{Probe, probe};
use super::{ask, ask_effects};
use crate::code::{AttributeId, ClassId, GeneralStatus, InstanceId};
use crate::codec::{Wire, Writer};
use crate::message::{AttributeReplies, AttributeSettings};
use crate::object::{AttributeRule, CommonServices, Effect, Effects, Failure, Object, class_attribute};
use proptest::{collection::vec, prelude::*};

/// A class with the instances 1, 4 and 300, and all class attributes that follow from the tables.
struct Sparse;

impl Object for Sparse {
    const CLASS: ClassId = ClassId(0x64);
    const REVISION: u16 = 5;

    fn class_attributes(&self) -> &'static [AttributeRule] {
        const {
            &[
                AttributeRule::get(1, 2),
                AttributeRule::get(2, 2),
                AttributeRule::get(3, 2),
                AttributeRule::get(6, 2),
                AttributeRule::get(7, 2),
            ]
        }
    }

    fn attributes(&self, instance: InstanceId) -> Option<&'static [AttributeRule]> {
        const RULES: &[AttributeRule] = &[AttributeRule::get(9, 1), AttributeRule::get(3, 1)];
        matches!(instance.0, 1 | 4 | 300).then_some(RULES)
    }

    fn next_instance(&self, instance: InstanceId) -> Option<InstanceId> {
        [1, 4, 300].into_iter().find(|&next| next > instance.0).map(InstanceId)
    }

    fn get(&self, instance: InstanceId, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure> {
        if instance.is_class() {
            return class_attribute(self, attribute, out);
        }
        Ok(out.u16(attribute.0)?)
    }
}

fn common() -> (CommonServices<Probe>,) {
    (CommonServices(probe()),)
}

#[test]
fn without_the_wrapper_the_services_do_not_exist() {
    for service in [0x01, 0x03, 0x04, 0x11] {
        assert_eq!(ask(&mut (probe(),), &[service, 0x64, 1, 0, 0]), [0x94, 0x08, 0xFF]);
    }
}

#[test]
fn the_wrapped_object_keeps_its_own() {
    assert_eq!(ask(&mut common(), &[0x0E, 0x64, 0, 1]), [0x8E, 3, 0]);
    assert_eq!(ask(&mut common(), &[0x10, 0x64, 1, 2, 0, 0]), [0x90]);
    assert_eq!(ask(&mut common(), &[0x05, 0x64, 1, 3]), [0x94, 0x20, 0xFF]);
    assert_eq!(ask(&mut common(), &[0x32, 0x64, 1]), [0x94, 0x08, 0xFF]);
    assert_eq!(ask(&mut common(), &[0x04, 0x64, 2, 0, 0]), [0x94, 0x08, 0xFF], "nothing can be set there");
}

#[test]
fn get_attributes_all_is_in_the_order_of_the_table() {
    let mut set = (CommonServices(Sparse),);
    assert_eq!(ask(&mut set, &[0x01, 0x64, 1]), [0x81, 9, 0, 3, 0]);
    assert_eq!(ask(&mut set, &[0x01, 0x64, 0]), [0x81, 5, 0, 0x2C, 1, 3, 0, 7, 0, 9, 0]);
    assert_eq!(ask(&mut set, &[0x01, 0x64, 1, 0]), [0x94, 0x15, 0xFF]);
    assert_eq!(ask(&mut common(), &[0x01, 0x64, 1]), [0x94, 0x11, 0xFF]);
    assert_eq!(ask(&mut common(), &[0x01, 0x64, 3]), [0x94, 0x08, 0xFF], "there are no attributes");
}

#[test]
fn find_next_starts_after_the_instance_addressed() {
    let mut set = (CommonServices(Sparse),);
    assert_eq!(ask(&mut set, &[0x11, 0x64, 0, 9]), [0x91, 3, 1, 0, 4, 0, 0x2C, 1]);
    assert_eq!(ask(&mut set, &[0x11, 0x64, 0, 2]), [0x91, 2, 1, 0, 4, 0]);
    assert_eq!(ask(&mut set, &[0x11, 0x64, 1, 1]), [0x91, 1, 4, 0]);
    assert_eq!(ask(&mut set, &[0x11, 0x64, 0, 0]), [0x91, 0]);
    assert_eq!(ask(&mut set, &[0x11, 0x64, 2, 1]), [0x94, 0x16, 0xFF]);
    assert_eq!(ask(&mut set, &[0x11, 0x64, 0]), [0x94, 0x13, 0xFF]);
    assert_eq!(ask(&mut set, &[0x11, 0x64, 0, 1, 1]), [0x94, 0x15, 0xFF]);
}

#[test]
fn one_instance_is_found_without_being_listed() {
    assert_eq!(ask(&mut common(), &[0x11, 0x64, 0, 9]), [0x91, 1, 1, 0]);
    assert_eq!(ask(&mut common(), &[0x11, 0x64, 1, 9]), [0x91, 0]);
}

#[test]
fn get_list_has_a_status_for_each_attribute() {
    let answer = ask(&mut common(), &[0x03, 0x64, 1, 3, 0, 1, 0, 99, 0, 4, 0]);
    let expected = [
        0x83, 3, 0, // three entries
        1, 0, 0x00, 0, 0x34, 0x12, // attribute 1
        99, 0, 0x14, 0, // not supported
        4, 0, 0x00, 0, 2, b'o', b'k', // attribute 4
    ];
    assert_eq!(answer, expected);
    assert_eq!(ask(&mut common(), &[0x03, 0x64, 0, 1, 0, 1, 0]), [0x83, 1, 0, 1, 0, 0, 0, 3, 0]);
}

#[test]
fn get_list_with_a_value_too_large_goes_on() {
    let answer = ask(&mut common(), &[0x03, 0x64, 1, 2, 0, 3, 0, 1, 0]);
    assert_eq!(answer, [0x83, 2, 0, 3, 0, 0x11, 0, 1, 0, 0, 0, 0x34, 0x12]);
}

#[test]
fn get_list_of_which_nothing_succeeds_is_an_attribute_list_error() {
    assert_eq!(ask(&mut common(), &[0x03, 0x64, 1, 2, 0, 99, 0, 98, 0]), [0x94, 0x0A, 0xFF]);
    assert_eq!(ask(&mut common(), &[0x03, 0x64, 1, 0, 0]), [0x83, 0, 0]);
}

#[test]
fn get_list_of_a_wrong_length() {
    for (body, status) in [
        (&[0x03, 0x64, 1][..], 0x13),
        (&[0x03, 0x64, 1, 1], 0x13),
        (&[0x03, 0x64, 1, 1, 0, 1], 0x13),
        (&[0x03, 0x64, 1, 0xFF, 0xFF, 1, 0], 0x13),
        (&[0x03, 0x64, 1, 1, 0, 1, 0, 0], 0x15),
        (&[0x03, 0x64, 1, 0, 0, 1, 0], 0x15),
    ] {
        assert_eq!(ask(&mut common(), body), [0x94, status, 0xFF], "{body:02X?}");
    }
    let many = [&[0x03, 0x64, 1, 20, 0][..], &[1, 0].repeat(20)].concat();
    assert_eq!(ask(&mut common(), &many), [0x94, 0x11, 0xFF], "20 entries of 6 bytes");
}

#[test]
fn set_list_has_a_status_for_each_attribute() {
    let mut set = common();
    let body = [0x04, 0x64, 1, 3, 0, 1, 0, 9, 9, 2, 0, 0x00, 0x01, 4, 0, 1, b'x'];
    let (answer, effects) = ask_effects(&mut set, &body);
    assert_eq!(answer, [0x84, 3, 0, 1, 0, 0x0E, 0, 2, 0, 0, 0, 4, 0, 0, 0]);
    assert_eq!((set.0.0.value, effects), (0x0100, Effect::ATTRIBUTE_SET.into()));
}

#[test]
fn set_list_ends_at_an_unknown_attribute() {
    let mut set = common();
    let answer = ask(&mut set, &[0x04, 0x64, 1, 3, 0, 2, 0, 0, 1, 99, 0, 1, 2, 3, 2, 0, 9, 9]);
    assert_eq!(answer, [0x84, 2, 0, 2, 0, 0, 0, 99, 0, 0x14, 0]);
    assert_eq!(set.0.0.value, 0x0100);
}

#[test]
fn set_list_of_which_nothing_succeeds_is_an_attribute_list_error() {
    for body in [&[0x04, 0x64, 1, 1, 0, 1, 0, 9, 9][..], &[0x04, 0x64, 1, 1, 0, 2, 0, 0xFF, 0xFF]] {
        let mut set = common();
        assert_eq!(ask_effects(&mut set, body), (std::vec![0x94, 0x0A, 0xFF], Effects::NONE));
        assert_eq!(set.0.0, probe());
    }
    assert_eq!(ask(&mut common(), &[0x04, 0x64, 1, 0, 0]), [0x84, 0, 0]);
}

#[test]
fn set_list_of_a_wrong_length_sets_nothing() {
    for (body, status) in [
        (&[0x04, 0x64, 1][..], 0x13),
        (&[0x04, 0x64, 1, 2, 0, 2, 0, 0, 1], 0x13),
        (&[0x04, 0x64, 1, 2, 0, 2, 0, 0, 1, 2, 0, 0], 0x13),
        (&[0x04, 0x64, 1, 1, 0, 2, 0, 0, 1, 0], 0x15),
    ] {
        let mut set = common();
        assert_eq!(ask(&mut set, body), [0x94, status, 0xFF], "{body:02X?}");
        assert_eq!(set.0.0, probe());
    }
}

#[test]
fn set_list_whose_reply_has_no_room_sets_nothing() {
    let mut set = common();
    let many = [&[0x04, 0x64, 1, 16, 0][..], &[2, 0, 0, 1].repeat(16)].concat();
    assert_eq!(ask(&mut set, &many), [0x94, 0x11, 0xFF], "1 + 2 + 16 * 4 bytes");
    assert_eq!(set.0.0, probe());
    let fewer = [&[0x04, 0x64, 1, 15, 0][..], &[2, 0, 0, 1].repeat(15)].concat();
    assert_eq!(ask(&mut set, &fewer).len(), 63);
    assert_eq!(set.0.0.value, 0x0100);
}

#[test]
fn a_list_tells_failures_of_the_object() {
    let mut set = (CommonServices(Probe { value: 0, busy: Some(GeneralStatus::OBJECT_STATE_CONFLICT) }),);
    let answer = ask(&mut set, &[0x04, 0x64, 1, 2, 0, 2, 0, 0, 1, 4, 0, 0]);
    assert_eq!(answer, [0x84, 2, 0, 2, 0, 0x0C, 0, 4, 0, 0, 0]);
}

proptest! {
    /// Whatever the bytes, a list answers, and what it answers is a list.
    #[test]
    fn any_list_is_answered(service in prop_oneof![Just(3_u8), Just(4)], data in vec(0..6_u8, 0..24)) {
        let answer = ask(&mut common(), &[&[service, 0x64, 1][..], &data].concat());
        if answer[0] == 0x94 {
            prop_assert_eq!(answer.len(), 3);
        } else if service == 3 {
            let len = |attribute: AttributeId, _: &[u8]| Some(match attribute.0 { 4 => 3, _ => 2 });
            let replies = AttributeReplies::parse(&answer[1..]).unwrap();
            prop_assert!(replies.iter(len).all(|reply| reply.is_ok()));
        } else {
            let statuses = AttributeSettings::parse(&answer[1..]).unwrap();
            prop_assert!(statuses.iter(|_, _| Some(2)).all(|status| status.is_ok()));
        }
    }
}
