//! The standard objects: every line can be read, and what a managing node writes is kept.

use std::vec::Vec;

use link_core::codec::Writer;

use super::*;
use crate::nmt::Cause;
use crate::wire::Identity;

#[derive(Clone, PartialEq, Eq, Hash, Debug, Default)]
struct Io {
    input: u8,
    output: u16,
}

impl ObjectSet for Io {
    const ENTRIES: &'static [Entry] = &[
        Entry::new(0x6000, 1, "input", ObjectType::Unsigned(1), Access::ReadOnly).mapped(Mappable::Transmit),
        Entry::new(0x6200, 1, "output", ObjectType::Unsigned(2), Access::ReadWrite).mapped(Mappable::Receive),
        Entry::new(0x6201, 0, "secret", ObjectType::Unsigned(1), Access::WriteOnly),
        Entry::new(0x6400, 1, "constant", ObjectType::Unsigned(1), Access::Constant).mapped(Mappable::Both),
        Entry::new(0x6400, 2, "read", ObjectType::Unsigned(1), Access::ReadOnly).mapped(Mappable::Both),
        Entry::new(0x6400, 3, "both", ObjectType::Unsigned(1), Access::ReadWrite).mapped(Mappable::Both),
        Entry::new(0x6400, 4, "written", ObjectType::Unsigned(1), Access::WriteOnly).mapped(Mappable::Both),
    ];

    fn read(&self, at: ObjectAddress, out: &mut Writer<'_>) -> Result<(), AbortCode> {
        match at.index {
            0x6000 => out.u8(self.input),
            _ => out.u16(self.output),
        }
        .map_err(|_| AbortCode::OUT_OF_MEMORY)
    }

    fn write(&mut self, _: ObjectAddress, data: &[u8]) -> Result<(), AbortCode> {
        self.output = u16::from_le_bytes(*data.first_chunk().ok_or(AbortCode::LENGTH)?);
        Ok(())
    }

    fn restore(&mut self) {}
}

fn dictionary() -> Dictionary {
    let identity = Identity { vendor_id: 0x0123, product_code: 7, revision: 0x0001_0000, serial_number: 42 };
    let device = Device { name: "fictitious", ..Device::new(identity) };
    Dictionary::new(device, NodeId(1), MacAddress([2, 0, 0, 0, 0, 1]), Values::default(), Mappings::new(), 36)
}

fn read(dictionary: &mut Dictionary, index: u16, sub: u8) -> Result<Vec<u8>, AbortCode> {
    let mut buffer = [0; 80];
    let mut out = Writer::new(&mut buffer);
    let objects = Objects { standard: dictionary, application: &mut Io { input: 0x5A, output: 0x1234 } };
    objects.read(ObjectAddress::new(index, sub), &mut out)?;
    Ok(out.written().to_vec())
}

fn write(dictionary: &mut Dictionary, index: u16, sub: u8, data: &[u8]) -> Result<Effect, AbortCode> {
    Objects { standard: dictionary, application: &mut Io::default() }
        .write(ObjectAddress::new(index, sub), data)
}

#[test]
fn every_line_can_be_read_with_the_length_of_its_type() {
    let mut dictionary = dictionary();
    dictionary.log(ErrorEntry::default());
    let mut last = None;
    for entry in STANDARD_ENTRIES {
        let order = (entry.indices.0, entry.subs.0);
        assert!(last.is_none_or(|last| last < order), "{entry:?}");
        last = Some(order);
        for index in entry.indices.0..=entry.indices.1 {
            for sub in entry.subs.0..=entry.subs.1 {
                match read(&mut dictionary, index, sub) {
                    Ok(value) => assert_eq!(entry.object_type.check_len(value.len()), Ok(()), "{entry:?}"),
                    // One error is in the history.
                    Err(code) => assert_eq!((index, sub > 1, code), (0x1003, true, AbortCode::NO_SUB_INDEX)),
                }
            }
        }
    }
}

/// A number that differs from the present one is taken and read back, or the line says that it cannot be.
#[test]
fn what_can_be_written_is_read_back() {
    for entry in STANDARD_ENTRIES.iter().filter(|entry| entry.access == Access::ReadWrite) {
        let (index, sub) = (entry.indices.0, entry.subs.0);
        if matches!((index, sub), (0x1003 | 0x1600 | 0x1800 | 0x1A00, 0..=1) | (0x1F9A | 0x1F9E, _)) {
            continue;
        }
        let mut dictionary = dictionary();
        let len = entry.object_type.fixed_len().unwrap();
        let value = if index == 0x1F98 && sub == 5 { 36 } else { entry.range.1.min(100).max(entry.range.0) };
        let bytes = &u64::from(value).to_le_bytes()[..len];
        assert_eq!(write(&mut dictionary, index, sub, bytes), Ok(Effect::None), "{entry:?}");
        assert_eq!(read(&mut dictionary, index, sub).as_deref(), Ok(bytes), "{entry:?}");
    }
}

/// Abort codes as openPOWERLINK 2.7.2 gives them.
#[test]
fn what_is_refused_and_why() {
    let mut dictionary = dictionary();
    let mut refused = |index, sub, data: &[u8]| write(&mut dictionary, index, sub, data).unwrap_err();
    assert_eq!(refused(0x2FFF, 0, &[0]), AbortCode::NO_OBJECT);
    assert_eq!(refused(0x1010, 1, b"save"), AbortCode::NO_OBJECT);
    assert_eq!(refused(0x1018, 9, &[0]), AbortCode::NO_SUB_INDEX);
    assert_eq!(refused(0x1018, 1, &[0; 4]), AbortCode::READ_ONLY);
    assert_eq!(refused(0x1F99, 0, &[0; 2]), AbortCode::LENGTH);
    assert_eq!(refused(0x1006, 0, &26_u32.to_le_bytes()), AbortCode::VALUE_TOO_LOW);
    assert_eq!(refused(0x1F98, 4, &[35, 0]), AbortCode::VALUE_TOO_LOW);
    assert_eq!(refused(0x1F98, 4, &1491_u16.to_le_bytes()), AbortCode::VALUE_TOO_HIGH);
    assert_eq!(refused(0x1F98, 5, &[37, 0]), AbortCode::VALUE_TOO_HIGH, "more than the node can send");
    assert_eq!(refused(0x1F9A, 0, b"under_score"), AbortCode::VALUE);
    assert_eq!(refused(0x1F9E, 0, &[0x21]), AbortCode::VALUE);
    for cycle in [27, 0, u32::MAX] {
        assert_eq!(write(&mut dictionary, 0x1006, 0, &cycle.to_le_bytes()), Ok(Effect::None));
        assert_eq!(read(&mut dictionary, 0x1006, 0), Ok(cycle.to_le_bytes().to_vec()));
    }
    assert_eq!(read(&mut dictionary, 0x6201, 0), Err(AbortCode::WRITE_ONLY));
    assert_eq!(write(&mut dictionary, 0x1F9E, 0, &[0x28]), Ok(Effect::Reset(Cause::ResetNode)));
}

#[test]
fn a_mapping_is_checked_when_it_is_put_into_use() {
    let mut dictionary = dictionary();
    let entry = |index: u16, sub: u8, offset: u16, length: u16| {
        crate::pdo::MappingEntry { object: ObjectAddress::new(index, sub), offset, length }
            .number()
            .to_le_bytes()
    };
    let cases = [
        (entry(0x6200, 1, 0, 16), Ok(Effect::None)),
        (entry(0x6200, 1, 20 * 8, 16), Ok(Effect::None)),
        (entry(0x6200, 1, 34 * 8, 16), Ok(Effect::None)),
        (entry(0x6200, 1, 35 * 8, 16), Err(AbortCode::PDO_LENGTH)),
        (entry(0x6200, 1, 0, 8), Err(AbortCode::NOT_MAPPABLE)),
        (entry(0x6000, 1, 0, 8), Err(AbortCode::NOT_MAPPABLE)),
        (entry(0x6300, 1, 0, 8), Err(AbortCode::NO_OBJECT)),
        (entry(0x6200, 2, 0, 8), Err(AbortCode::NO_SUB_INDEX)),
    ];
    for (number, expected) in cases {
        assert_eq!(write(&mut dictionary, 0x1600, 0, &[0]), Ok(Effect::None));
        assert_eq!(write(&mut dictionary, 0x1600, 1, &number), Ok(Effect::None));
        assert_eq!(write(&mut dictionary, 0x1600, 0, &[1]), expected, "{number:02X?}");
    }
    assert_eq!(write(&mut dictionary, 0x1600, 1, &entry(0x6200, 1, 0, 16)), Ok(Effect::None));
    // Its granularity is eight bits: offset and length.
    for (offset, length) in [(1, 16), (4, 16), (7, 8), (0, 1), (0, 15), (8, 17), (u16::MAX, 16)] {
        let refused = write(&mut dictionary, 0x1600, 1, &entry(0x6200, 1, offset, length));
        assert_eq!(refused, Err(AbortCode::NOT_MAPPABLE), "offset {offset}, length {length}");
    }
    assert_eq!(read(&mut dictionary, 0x1600, 1).unwrap(), entry(0x6200, 1, 0, 16), "the entry stays");
    assert_eq!(write(&mut dictionary, 0x1600, 0, &[1]), Ok(Effect::None));
    assert_eq!(
        write(&mut dictionary, 0x1600, 1, &entry(0x6200, 1, 0, 16)),
        Err(AbortCode::UNSUPPORTED_ACCESS),
        "in use"
    );
}

/// What is mapped and the limit of its frame, in either order; what other nodes send has no such limit.
#[test]
fn what_is_mapped_stays_within_its_limit() {
    let long = |offset| crate::pdo::MappingEntry { object: ObjectAddress::new(0x6400, 3), offset, length: 8 };
    for (mapping, limit) in [(0x1600, 4), (0x1A00, 5)] {
        let mut dictionary = Dictionary { max_pres_payload: 64, ..dictionary() };
        let mut writes = |index, sub, data: &[u8]| write(&mut dictionary, index, sub, data).map(|_| ());
        // The 40th byte.
        assert_eq!(writes(mapping, 1, &long(39 * 8).number().to_le_bytes()), Ok(()));
        assert_eq!(writes(mapping, 0, &[1]), Err(AbortCode::PDO_LENGTH));
        assert_eq!(writes(0x1F98, limit, &[50, 0]), Ok(()));
        assert_eq!(writes(mapping, 0, &[1]), Ok(()));
        assert_eq!(writes(0x1F98, limit, &[39, 0]), Err(AbortCode::PDO_LENGTH));
        assert_eq!(writes(0x1F98, limit, &[40, 0]), Ok(()), "it just fits");
        assert_eq!(writes(mapping, 0, &[0]), Ok(()));
        assert_eq!(writes(0x1F98, limit, &[36, 0]), Ok(()), "nothing is mapped");
        assert_eq!(writes(mapping, 0, &[1]), Err(AbortCode::PDO_LENGTH));
    }
    let mut dictionary = dictionary();
    for (index, sub, data) in [
        (0x1400, 1, &[2][..]),
        (0x1600, 1, &long(1489 * 8).number().to_le_bytes()),
        (0x1600, 0, &[1]),
        (0x1F98, 4, &[36, 0]),
        (0x1600, 0, &[0]),
        (0x1600, 1, &long(1490 * 8).number().to_le_bytes()),
    ] {
        assert_eq!(write(&mut dictionary, index, sub, data), Ok(Effect::None), "0x{index:04X}/{sub}");
    }
    assert_eq!(write(&mut dictionary, 0x1600, 0, &[1]), Err(AbortCode::PDO_LENGTH));
}

/// Whatever the lines of the application say: what is received is written, what is sent is read.
#[test]
fn what_is_mapped_is_accessible() {
    let mut dictionary = dictionary();
    for (sub, access, receive, transmit) in [
        (1, Access::Constant, false, true),
        (2, Access::ReadOnly, false, true),
        (3, Access::ReadWrite, true, true),
        (4, Access::WriteOnly, true, false),
    ] {
        let object = ObjectAddress::new(0x6400, sub);
        let entry = crate::pdo::MappingEntry { object, offset: 0, length: 8 };
        for (mapping, is_possible) in [(0x1600, receive), (0x1A00, transmit)] {
            assert_eq!(write(&mut dictionary, mapping, 0, &[0]), Ok(Effect::None));
            assert_eq!(write(&mut dictionary, mapping, 1, &entry.number().to_le_bytes()), Ok(Effect::None));
            let expected = if is_possible { Ok(Effect::None) } else { Err(AbortCode::NOT_MAPPABLE) };
            assert_eq!(write(&mut dictionary, mapping, 0, &[1]), expected, "{access:?} in 0x{mapping:04X}");
        }
        // Those of the manufacturer too.
        let given = |transmit| crate::pdo::Mapping::with::<Io>(&[entry], transmit, 36).is_ok();
        assert_eq!((given(false), given(true)), (receive, transmit), "{access:?}");
    }
}

#[test]
fn the_history_shows_the_newest_first_and_forgets_the_oldest() {
    let mut dictionary = dictionary();
    for code in 1..=10 {
        dictionary.log(ErrorEntry { code: crate::wire::ErrorCode(code), ..ErrorEntry::default() });
    }
    let codes: Vec<_> = dictionary.history().map(|entry| entry.code.0).collect();
    assert_eq!(codes, [10, 9, 8, 7, 6, 5, 4, 3]);
    assert_eq!(read(&mut dictionary, 0x1003, 1).unwrap()[2..4], [10, 0]);
    write(&mut dictionary, 0x1003, 0, &[0]).unwrap();
    assert_eq!(read(&mut dictionary, 0x1003, 0), Ok(std::vec![0]));
}
