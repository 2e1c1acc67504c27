//! The Identity object. Values of an Omron GRT1-DRT as it answers them in the Konvolucio.DeviceNet logs (vendor 47,
//! product code 0x056C, name GRT1-DRT); revision and serial number are made up.

use super::{ask, ask_effects};
use crate::code::{DeviceType, GeneralStatus, VendorId};
use crate::codec::Wire;
use crate::identity::{
    DeviceIdentity, DeviceState, ExtendedStatus, IdentityAttributes, IdentityStatus, OptionalAttributes,
    ProductName, Revision,
};
use crate::message::ResetType;
use crate::object::laws::agrees_with_names;
use crate::object::{CommonServices, Effect, Effects, Failure, Identity, Object, Resets};
use proptest::prelude::*;

fn device() -> DeviceIdentity {
    DeviceIdentity {
        vendor: VendorId::OMRON,
        device_type: DeviceType::COMMUNICATIONS_ADAPTER,
        product_code: 0x056C,
        revision: Revision::new(1, 2).unwrap(),
        serial: 0x0102_0304,
        name: ProductName::new("GRT1-DRT").unwrap(),
    }
}

fn full(device: &DeviceIdentity) -> Identity<'_> {
    Identity {
        state: Some(DeviceState::OPERATIONAL),
        configuration_consistency: Some(0x1234),
        heartbeat_interval: Some(5),
        ..Identity::new(device)
    }
}

#[test]
fn attributes_one_by_one() {
    let device = device();
    for (attribute, value) in [
        (1, &[0x2F, 0x00][..]),
        (2, &[0x0C, 0x00]),
        (3, &[0x6C, 0x05]),
        (4, &[1, 2]),
        (5, &[0x00, 0x00]),
        (6, &[0x04, 0x03, 0x02, 0x01]),
        (7, b"\x08GRT1-DRT"),
        (8, &[3]),
        (9, &[0x34, 0x12]),
        (10, &[5]),
    ] {
        let answer = ask(&mut (full(&device),), &[0x0E, 1, 1, attribute]);
        assert_eq!(answer, [&[0x8E], value].concat(), "attribute {attribute}");
    }
    assert_eq!(ask(&mut (full(&device),), &[0x0E, 1, 0, 1]), [0x8E, 1, 0], "class revision");
    assert_eq!(ask(&mut (full(&device),), &[0x0E, 1, 0, 2]), [0x94, 0x14, 0xFF]);
    assert_eq!(ask(&mut (full(&device),), &[0x0E, 1, 2, 1]), [0x94, 0x16, 0xFF]);
}

#[test]
fn status_word() {
    let device = device();
    let status = IdentityStatus::OWNED
        | IdentityStatus::CONFIGURED
        | IdentityStatus::MINOR_RECOVERABLE_FAULT
        | IdentityStatus::MAJOR_UNRECOVERABLE_FAULT;
    for (status, low, high) in [
        (IdentityStatus::OWNED, 0x01, 0x00),
        (status.with_extended(ExtendedStatus::RUN), 0x65, 0x09),
        (status.with_extended(ExtendedStatus::MAJOR_FAULT), 0x55, 0x09),
    ] {
        let answer = ask(&mut (Identity { status, ..full(&device) },), &[0x0E, 1, 1, 5]);
        assert_eq!(answer, [0x8E, low, high]);
    }
}

/// Each combination of the optional attributes: the table has exactly those, and so has Get_Attributes_All, with the
/// defaults of CIP Vol. 1 for what is missing in between.
#[test]
fn optional_attributes() {
    let device = device();
    for bits in 0..8_u8 {
        let [state, consistency, heartbeat] = [bits & 1 != 0, bits & 2 != 0, bits & 4 != 0];
        let mut set = (Identity {
            state: state.then_some(DeviceState::STANDBY),
            configuration_consistency: consistency.then_some(7),
            heartbeat_interval: heartbeat.then_some(9),
            ..Identity::new(&device)
        },);
        for (attribute, there) in [(7, true), (8, state), (9, consistency), (10, heartbeat), (11, false)] {
            let answer = ask(&mut set, &[0x0E, 1, 1, attribute]);
            assert_eq!(answer[0], if there { 0x8E } else { 0x94 }, "{bits:03b}, attribute {attribute}");
        }
        let shown = DeviceState(if state { 2 } else { 255 });
        let optional = match bits {
            0 => OptionalAttributes::None,
            1 => OptionalAttributes::State(shown),
            2 | 3 => OptionalAttributes::Consistency(shown, 7),
            _ => OptionalAttributes::Heartbeat(shown, if consistency { 7 } else { 0 }, 9),
        };
        let all = IdentityAttributes { identity: device.clone(), status: IdentityStatus::empty(), optional };
        assert_eq!(IdentityAttributes::parse(&ask(&mut set, &[0x01, 1, 1])[1..]), Ok(all));
    }
}

#[test]
fn get_attributes_all_in_bytes() {
    let device = device();
    let mut set = (Identity { status: IdentityStatus::OWNED, ..Identity::new(&device) },);
    let expected = b"\x81\x2F\x00\x0C\x00\x6C\x05\x01\x02\x01\x00\x04\x03\x02\x01\x08GRT1-DRT";
    assert_eq!(ask(&mut set, &[0x01, 1, 1]), expected);
    assert_eq!(ask(&mut set, &[0x01, 1, 1, 0]), [0x94, 0x15, 0xFF]);
    assert_eq!(ask(&mut set, &[0x01, 1, 0]), [0x94, 0x08, 0xFF]);
    let wrapped = ask(&mut (CommonServices(set.0),), &[0x01, 1, 1]);
    assert_eq!(wrapped, expected, "the object's own comes first");
}

#[test]
fn heartbeat_interval_is_set_and_told() {
    let device = device();
    let mut set = (full(&device),);
    let (answer, effects) = ask_effects(&mut set, &[0x10, 1, 1, 10, 200]);
    assert_eq!((answer, set.0.heartbeat_interval), (std::vec![0x90], Some(200)));
    assert!(effects.of().contains(Effect::HEARTBEAT_INTERVAL | Effect::ATTRIBUTE_SET));
    for (body, status) in [
        (&[0x10, 1, 1, 10][..], 0x13),
        (&[0x10, 1, 1, 10, 1, 1], 0x15),
        (&[0x10, 1, 1, 1, 1, 1], 0x0E),
        (&[0x10, 1, 1, 11, 1], 0x14),
        (&[0x10, 1, 0, 1, 1, 1], 0x08),
    ] {
        assert_eq!(ask(&mut set, body), [0x94, status, 0xFF], "{body:02X?}");
    }
    let without = ask(&mut (Identity::new(&device),), &[0x10, 1, 1, 1, 1, 1]);
    assert_eq!(without, [0x94, 0x08, 0xFF], "Set is a service of devices with attribute 10");
}

/// The logs have `00 85` for `00 05 01 01` (header, service, class, instance).
#[test]
fn reset_types() {
    let device = device();
    let all = Resets::all();
    for (resets, data, expected) in [
        (Resets::empty(), &[][..], Ok(ResetType::POWER_CYCLE)),
        (Resets::empty(), &[0], Ok(ResetType::POWER_CYCLE)),
        (Resets::empty(), &[1], Err(0x20)),
        (Resets::OUT_OF_BOX, &[1], Ok(ResetType::OUT_OF_BOX)),
        (Resets::OUT_OF_BOX, &[2], Err(0x20)),
        (Resets::KEEP_COMMUNICATION, &[2], Ok(ResetType::OUT_OF_BOX_KEEP_COMMUNICATION)),
        (Resets::KEEP_COMMUNICATION, &[1], Err(0x20)),
        (all, &[3], Err(0x20)),
        (all, &[99], Err(0x20)),
        (all, &[100], Ok(ResetType(100))),
        (all, &[199], Ok(ResetType(199))),
        (all, &[200], Err(0x20)),
        (all, &[255], Err(0x20)),
        (Resets::OUT_OF_BOX | Resets::KEEP_COMMUNICATION, &[100], Err(0x20)),
        (all, &[0, 0], Err(0x15)),
    ] {
        let mut set = (Identity { resets, ..Identity::new(&device) },);
        let answer = ask_effects(&mut set, &[&[0x05, 1, 1], data].concat());
        let expected = match expected {
            Ok(kind) => (std::vec![0x85], Effects::reset(kind)),
            Err(status) => (std::vec![0x94, status, 0xFF], Effects::NONE),
        };
        assert_eq!(answer, expected, "{resets:?} {data:?}");
    }
    assert_eq!(ask(&mut (full(&device),), &[0x05, 1, 0]), [0x94, 0x08, 0xFF], "of the class");
}

/// The state comes before the parameter, and the length before both.
#[test]
fn a_reset_that_is_impossible_now() {
    let device = device();
    for status in [GeneralStatus::DEVICE_STATE_CONFLICT, GeneralStatus::OBJECT_STATE_CONFLICT] {
        let refused = Some(Failure::new(status));
        let mut set = (Identity { reset_refused: refused, ..Identity::new(&device) },);
        assert_eq!(ask_effects(&mut set, &[0x05, 1, 1]).0, [0x94, status.0, 0xFF]);
        assert_eq!(ask_effects(&mut set, &[0x05, 1, 1, 3]).0, [0x94, status.0, 0xFF]);
        assert_eq!(ask(&mut set, &[0x05, 1, 1, 0, 0]), [0x94, 0x15, 0xFF]);
    }
}

#[test]
fn tables_agree_with_the_names() {
    let device = device();
    agrees_with_names(&full(&device), &[1]);
    agrees_with_names(&Identity { configuration_consistency: None, ..full(&device) }, &[1]);
    assert_eq!(full(&device).next_instance(crate::code::InstanceId::CLASS).unwrap().0, 1);
}

proptest! {
    #[test]
    fn any_request_is_answered(service in 1..0x33_u8, data in proptest::collection::vec(0..12_u8, 1..8)) {
        let device = device();
        let answer = ask(&mut (full(&device),), &[&[service, 1][..], &data].concat());
        prop_assert!(matches!(answer[..], [0x94, _, 0xFF]) || answer[0] == service | 0x80);
    }
}
