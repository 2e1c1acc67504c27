//! The Assembly object.

use super::{ask, ask_effects};
use crate::code::{GeneralStatus, InstanceId};
use crate::object::laws::agrees_with_names;
use crate::object::{Assemblies, Assembly, AssemblyObject, CommonServices, Effect, Effects, Failure, Member};
use proptest::prelude::*;
use std::vec;

/// Sensors of two bytes and an EPATH for each, a coil of one byte that must not be 0xEE, three bytes of settings.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
struct Block {
    inputs: [u8; 2],
    outputs: [u8; 1],
    settings: [u8; 3],
    broken_storage: bool,
}

const SENSOR: InstanceId = InstanceId(100);
const COIL: InstanceId = InstanceId(150);

impl Assemblies for Block {
    const ASSEMBLIES: &'static [Assembly] = &[
        Assembly::output(150, 1),
        Assembly::input(100, 2).with_members(&[
            Member { bits: 8, path: &[0x20, 0x08, 0x24, 0x01, 0x30, 0x03] },
            Member { bits: 8, path: &[] },
        ]),
        Assembly::configuration(300, 3),
    ];

    fn data(&self, instance: InstanceId) -> &[u8] {
        match instance {
            SENSOR => &self.inputs,
            COIL => &self.outputs,
            _ => &self.settings,
        }
    }

    fn check(&self, _: InstanceId, data: &[u8]) -> Result<(), Failure> {
        if data == [0xEE] { Err(GeneralStatus::INVALID_ATTRIBUTE_VALUE.into()) } else { Ok(()) }
    }

    fn write(&mut self, instance: InstanceId, data: &[u8]) -> Result<(), Failure> {
        if self.broken_storage {
            return Err(GeneralStatus::STORE_OPERATION_FAILURE.into());
        }
        match instance {
            COIL => self.outputs = data.try_into().unwrap(),
            _ => self.settings = data.try_into().unwrap(),
        }
        Ok(())
    }
}

fn object(block: &mut Block) -> (AssemblyObject<'static, &mut Block>,) {
    (AssemblyObject { assemblies: block, owned_by_io: &[] },)
}

#[test]
fn attributes_one_by_one() {
    let mut block = Block { inputs: [0x34, 0x12], outputs: [0x56], ..Block::default() };
    for (body, expected) in [
        (&[0x0E, 4, 100, 3][..], &[0x8E, 0x34, 0x12][..]),
        (&[0x0E, 4, 100, 4], &[0x8E, 2, 0]),
        (&[0x0E, 4, 100, 1], &[0x8E, 2, 0]),
        (
            &[0x0E, 4, 100, 2],
            &[
                0x8E, 8, 0, 6, 0, 0x20, 0x08, 0x24, 0x01, 0x30, 0x03, // 8 bits, a path of 6 bytes
                8, 0, 0, 0, // 8 bits of padding
            ],
        ),
        (&[0x0E, 4, 150, 3], &[0x8E, 0x56]),
        (&[0x0E, 4, 150, 1], &[0x94, 0x14, 0xFF]),
        (&[0x0E, 4, 150, 2], &[0x94, 0x14, 0xFF]),
        (&[0x0E, 4, 151, 3], &[0x94, 0x16, 0xFF]),
        (&[0x0E, 4, 0, 1], &[0x8E, 2, 0]),
        (&[0x0E, 4, 0, 2], &[0x8E, 0x2C, 1]),
        (&[0x0E, 4, 0, 3], &[0x8E, 3, 0]),
        (&[0x10, 4, 0, 1, 0, 0], &[0x94, 0x08, 0xFF]),
        (&[0x01, 4, 100], &[0x94, 0x08, 0xFF]),
    ] {
        assert_eq!(ask(&mut object(&mut block), body), expected, "{body:02X?}");
    }
    let found = ask(&mut (CommonServices(object(&mut block).0),), &[0x11, 4, 0, 9]);
    assert_eq!(found, [0x91, 3, 100, 0, 150, 0, 0x2C, 1], "in ascending order");
}

#[test]
fn set_demands_the_exact_length() {
    for (data, status) in [(&[][..], 0x13), (&[1, 2], 0x15), (&[0xEE, 0xEE], 0x15)] {
        let mut block = Block::default();
        let answer = ask(&mut object(&mut block), &[&[0x10, 4, 150, 3], data].concat());
        assert_eq!((answer, block), (vec![0x94, status, 0xFF], Block::default()));
    }
}

#[test]
fn set_of_outputs_reaches_the_application() {
    let mut block = Block::default();
    let (answer, effects) = ask_effects(&mut object(&mut block), &[0x10, 4, 150, 3, 0x5A]);
    assert_eq!((answer, block.outputs), (vec![0x90], [0x5A]));
    assert_eq!(effects, (Effect::ASSEMBLY_DATA | Effect::ATTRIBUTE_SET).into());
}

#[test]
fn set_of_inputs_is_not_settable() {
    let mut block = Block::default();
    for body in
        [&[0x10, 4, 100, 3, 1, 2][..], &[0x10, 4, 100, 3], &[0x10, 4, 100, 4, 0, 0], &[0x10, 4, 150, 4, 0, 0]]
    {
        assert_eq!(ask(&mut object(&mut block), body), [0x94, 0x0E, 0xFF], "{body:02X?}");
    }
}

/// The value is judged before the state, the state before the storage.
#[test]
fn outputs_that_an_io_connection_owns_are_a_state_conflict() {
    let mut block = Block { broken_storage: true, ..Block::default() };
    let mut set = (AssemblyObject { assemblies: &mut block, owned_by_io: &[SENSOR, COIL] },);
    for (data, status) in [(0x5A, 0x0C), (0xEE, 0x09)] {
        let answer = ask_effects(&mut set, &[0x10, 4, 150, 3, data]);
        assert_eq!(answer, (vec![0x94, status, 0xFF], Effects::NONE));
    }
    set.0.owned_by_io = &[SENSOR];
    assert_eq!(ask(&mut set, &[0x10, 4, 150, 3, 0x5A]), [0x94, 0x19, 0xFF]);
    assert_eq!(ask(&mut set, &[0x0E, 4, 150, 3]), [0x8E, 0], "reading is always possible");
}

#[test]
fn tables_agree_with_the_names() {
    agrees_with_names(&object(&mut Block::default()).0, &[100, 150, 300]);
}

proptest! {
    #[test]
    fn what_was_set_is_read(data: [u8; 3]) {
        let mut block = Block::default();
        // 300 does not fit the format 8/8.
        let mut set = object(&mut block);
        let format = crate::message::BodyFormat::Class8Instance16;
        let options = crate::object::FailureOptions::default();
        let written = super::answer(&mut set, format, options, &[&[0x10, 4, 0x2C, 1, 3], &data[..]].concat());
        prop_assert_eq!(written.0, [0x90]);
        let read = super::answer(&mut set, format, options, &[0x0E, 4, 0x2C, 1, 3]);
        prop_assert_eq!(&read.0[1..], data);
    }
}
