//! The Acknowledge Handler object.

use super::{ask, ask_effects};
use crate::code::InstanceId;
use crate::object::laws::agrees_with_names;
use crate::object::{
    AcknowledgeHandler, AcknowledgeLists, AcknowledgePath, AcknowledgeSettings, Effect, Effects,
};
use proptest::prelude::*;
use std::vec;

const ALLOWED: [InstanceId; 2] = [InstanceId(4), InstanceId(16)];

#[test]
fn defaults() {
    let mut settings = AcknowledgeSettings::default();
    let mut set = (AcknowledgeHandler::new(&mut settings),);
    for (body, expected) in [
        (&[0x0E, 0x2B, 1, 1][..], &[0x8E, 16, 0][..]),
        (&[0x0E, 0x2B, 1, 2], &[0x8E, 1]),
        (&[0x0E, 0x2B, 1, 3], &[0x8E, 4, 0]),
        (&[0x0E, 0x2B, 1, 4], &[0x94, 0x14, 0xFF]),
        (&[0x0E, 0x2B, 1, 7], &[0x94, 0x14, 0xFF]),
        (&[0x0E, 0x2B, 0, 1], &[0x8E, 1, 0]),
        (&[0x0E, 0x2B, 2, 1], &[0x94, 0x16, 0xFF]),
        (&[0x4B, 0x2B, 1, 4, 0], &[0x94, 0x08, 0xFF]),
        (&[0x4C, 0x2B, 1, 4, 0], &[0x94, 0x08, 0xFF]),
    ] {
        assert_eq!(ask(&mut set, body), expected, "{body:02X?}");
    }
}

#[test]
fn optional_lists() {
    let mut settings = AcknowledgeSettings::default();
    let handler = AcknowledgeHandler::new(&mut settings);
    agrees_with_names(&handler, &[1]);
    let mut set = (AcknowledgeLists { handler, acknowledges: &ALLOWED, data_paths: None },);
    assert_eq!(ask(&mut set, &[0x0E, 0x2B, 1, 4]), [0x8E, 2]);
    assert_eq!(ask(&mut set, &[0x0E, 0x2B, 1, 5]), [0x8E, 2, 4, 0, 16, 0]);
    assert_eq!(ask(&mut set, &[0x0E, 0x2B, 1, 6]), [0x94, 0x14, 0xFF]);
    let paths = [AcknowledgePath { connection: InstanceId(4), path: &[0x20, 0x04, 0x24, 0x65] }];
    set.0.data_paths = Some(&paths);
    assert_eq!(ask(&mut set, &[0x0E, 0x2B, 1, 6]), [0x8E, 1]);
    assert_eq!(ask(&mut set, &[0x0E, 0x2B, 1, 7]), [0x8E, 1, 4, 0, 4, 0x20, 0x04, 0x24, 0x65]);
    for attribute in 4..=7 {
        assert_eq!(ask(&mut set, &[0x10, 0x2B, 1, attribute, 0]), [0x94, 0x0E, 0xFF]);
    }
    agrees_with_names(&set.0, &[1]);
    assert_eq!(ask(&mut set, &[0x10, 0x2B, 1, 1, 20, 0]), [0x90, 20, 0]);
    assert_eq!(ask(&mut set, &[0x0E, 0x2B, 1, 1]), [0x8E, 20, 0]);
}

#[test]
fn timer_is_rounded_up_and_never_zero() {
    for (resolution, value, used) in [
        (1, 1_u16, 1_u16),
        (1, 65_535, 65_535),
        (0, 3, 3),
        (10, 1, 10),
        (10, 10, 10),
        (10, 11, 20),
        (10, 65_535, 65_530),
        (65_535, 1, 65_535),
    ] {
        let mut settings = AcknowledgeSettings::default();
        let mut set = (AcknowledgeHandler { resolution, ..AcknowledgeHandler::new(&mut settings) },);
        let answer = ask(&mut set, &[&[0x10, 0x2B, 1, 1][..], &value.to_le_bytes()].concat());
        assert_eq!(answer, [&[0x90][..], &used.to_le_bytes()].concat());
        assert_eq!(settings.timer, used);
    }
    let mut settings = AcknowledgeSettings::default();
    let mut set = (AcknowledgeHandler::new(&mut settings),);
    for (data, status) in [(&[0, 0][..], 0x09), (&[1], 0x13), (&[1, 0, 0], 0x15)] {
        let answer = ask_effects(&mut set, &[&[0x10, 0x2B, 1, 1], data].concat());
        assert_eq!(answer, (vec![0x94, status, 0xFF], Effects::NONE));
    }
    set.0.timer_in_response = false;
    let (answer, effects) = ask_effects(&mut set, &[0x10, 0x2B, 1, 1, 5, 0]);
    assert_eq!((answer, settings.timer), (vec![0x90], 5));
    assert_eq!(effects, (Effect::ACKNOWLEDGE | Effect::ATTRIBUTE_SET).into());
}

#[test]
fn retry_limit_is_any_byte() {
    let mut settings = AcknowledgeSettings::default();
    assert_eq!(ask(&mut (AcknowledgeHandler::new(&mut settings),), &[0x10, 0x2B, 1, 2, 255]), [0x90]);
    assert_eq!(settings.retry_limit, 255);
}

/// The value is judged before the state.
#[test]
fn the_producer_is_set_while_it_is_not_established() {
    let mut settings = AcknowledgeSettings::default();
    let mut set = (AcknowledgeHandler { producers: &ALLOWED, ..AcknowledgeHandler::new(&mut settings) },);
    assert_eq!(ask(&mut set, &[0x10, 0x2B, 1, 3, 16, 0]), [0x90]);
    assert_eq!(ask(&mut set, &[0x10, 0x2B, 1, 3, 5, 0]), [0x94, 0x09, 0xFF]);
    set.0.established = true;
    assert_eq!(ask(&mut set, &[0x10, 0x2B, 1, 3, 4, 0]), [0x94, 0x0C, 0xFF]);
    assert_eq!(ask(&mut set, &[0x10, 0x2B, 1, 3, 5, 0]), [0x94, 0x09, 0xFF]);
    assert_eq!(ask(&mut set, &[0x10, 0x2B, 1, 3, 4]), [0x94, 0x13, 0xFF]);
    assert_eq!(settings.producer, InstanceId(16));
}

proptest! {
    #[test]
    fn the_timer_used_is_the_least_multiple_not_below(value in 1..=u16::MAX, resolution in 1..=u16::MAX) {
        let mut settings = AcknowledgeSettings::default();
        let mut set = (AcknowledgeHandler { resolution, ..AcknowledgeHandler::new(&mut settings) },);
        ask(&mut set, &[&[0x10, 0x2B, 1, 1][..], &value.to_le_bytes()].concat());
        let used = settings.timer;
        prop_assert!(used > 0 && used.is_multiple_of(resolution));
        let none_above = used.checked_add(resolution).is_none();
        let least = if used < value { none_above } else { used.abs_diff(value) < resolution };
        prop_assert!(least, "{} of {} in steps of {}", used, value, resolution);
    }
}
