//! Interface descriptions: their clocks, names and number, and what statistics say of them.

use devicenet_cli::recording::{Notes, Place, RecordingError};

use super::{CAN, ETHERNET, PACKET, block, interface, option, packet, read, read_bytes, section};

/// Option 9 is the resolution: a power of ten, with bit 7 a power of two. Option 14 is signed.
#[test]
fn every_clock() {
    let cases: [(&[Vec<u8>], u64, u64); 7] = [
        (&[], 1_500_000, 1_500_000_000),
        (&[option(9, &[9])], 1_500_000_000, 1_500_000_000),
        (&[option(9, &[0x80 | 10])], 1536, 1_500_000_000),
        (&[option(9, &[0x80 | 64])], 3 << 62, 750_000_000),
        (&[option(9, &[20])], 3 << 62, 138_350_580),
        (&[option(9, &[39])], u64::MAX, 0),
        (&[option(14, &(-1i64).to_le_bytes())], 1_500_000, 500_000_000),
    ];
    for (options, units, nanos) in cases {
        let read = read(&[interface(CAN, options), packet(0, units, PACKET)]);
        assert_eq!(read.frames(), [("if0", nanos)], "{options:?}");
    }
}

#[test]
fn a_time_that_cannot_be_is_a_bad_record() {
    for offset in [-2i64, i64::MIN, i64::MAX] {
        let blocks = [
            interface(CAN, &[option(14, &offset.to_le_bytes())]),
            interface(CAN, &[]),
            packet(0, 1_500_000, PACKET),
            packet(1, 0, PACKET),
        ];
        let place = Place::Record { record: 1, byte: 5 };
        assert_eq!(read(&blocks).bad(0), (place, "a time from 1970 to 2554"), "{offset}");
    }
}

/// The draft: an end mark is not needed; what is not known is skipped (10 is the time zone, 0x8003 a private option).
#[test]
fn a_list_of_options_may_end_with_its_block() {
    let options = [option(10, &[0; 4]), option(0x8003, &[1, 2, 3]), option(2, b"can0")];
    let read = read(&[interface(CAN, &options), packet(0, 0, PACKET)]);
    assert_eq!(read.frames(), [("can0", 0)]);
}

#[test]
fn interfaces_without_a_name_stay_apart() {
    let blocks = [
        interface(CAN, &[]),
        interface(CAN, &[option(2, b"can0"), option(0, b"")]),
        interface(CAN, &[option(2, b"")]),
        packet(2, 0, PACKET),
        packet(1, 1, PACKET),
        packet(0, 2, PACKET),
    ];
    assert_eq!(read(&blocks).frames(), [("if2", 0), ("can0", 1000), ("if0", 2000)]);
}

#[test]
fn more_interfaces_than_can_be_told_apart_are_not_mixed() {
    let mut blocks: Vec<_> = (0..256).map(|_| interface(CAN, &[])).collect();
    blocks.extend([packet(255, 0, PACKET), packet(254, 0, PACKET)]);
    let read = read(&blocks);
    let limit = "at most 255 interfaces, with names of at most 255 bytes of text";
    assert_eq!(read.bad(0), (Place::Record { record: 1, byte: 1 }, limit));
    assert_eq!(read.entries[1].as_ref().unwrap().0, "if254");
}

/// They need no packet, so that a file of descriptions alone would fill the memory.
#[test]
fn more_interfaces_than_anybody_has_end_the_reading() {
    let mut blocks: Vec<_> = (0..4096).map(|_| interface(ETHERNET, &[])).collect();
    blocks[0] = interface(CAN, &[]);
    blocks.push(packet(0, 0, PACKET));
    let read_all = read(&blocks);
    assert_eq!(read_all.frames(), [("if0", 0)]);
    blocks.extend([interface(ETHERNET, &[]), packet(0, 0, PACKET)]);
    let entries = read(&blocks).entries;
    assert_eq!(entries.len(), 2);
    assert!(matches!(&entries[1], Err(RecordingError::Damaged { after: 1, .. })), "{:?}", entries[1]);
    // A new section begins anew.
    let file = [section(), blocks[..4096].concat(), section(), blocks[..4097].concat()].concat();
    assert_eq!(read_bytes(file).frames(), [("if0", 0)]);
}

#[test]
fn a_name_that_is_too_long_or_no_text_makes_its_packets_bad() {
    for name in [&[b'x'; 256][..], &[0xFF, 0xFE]] {
        let blocks = [
            interface(CAN, &[option(2, name)]),
            interface(CAN, &[]),
            packet(0, 0, PACKET),
            packet(1, 0, PACKET),
        ];
        assert!(read(&blocks).bad(0).1.starts_with("at most 255 interfaces"));
    }
}

#[test]
fn a_description_that_cannot_be_read_makes_its_packets_bad() {
    for options in [option(9, &[6, 0]), option(14, &[0; 4]), vec![2, 0, 99, 0, b'c']] {
        let blocks =
            [interface(CAN, &[]), interface(CAN, &[options]), packet(1, 0, PACKET), packet(0, 0, PACKET)];
        assert_eq!(read(&blocks).bad(0).1, "an interface whose description can be read");
    }
}

/// Statistics: interface, time, options 5 (lost by the interface) and 7 (by the operating system), from the start on.
#[test]
fn packets_that_were_lost_are_counted() {
    let statistics = |interface: u32, by_interface: u64, by_system: u64| {
        let options = [option(5, &by_interface.to_le_bytes()), option(7, &by_system.to_le_bytes())].concat();
        block(5, &[&interface.to_le_bytes()[..], &[0; 8], &options].concat())
    };
    let blocks = [
        interface(CAN, &[]),
        interface(ETHERNET, &[]),
        statistics(0, 1, 2),
        packet(0, 0, PACKET),
        statistics(0, 1, 4),
        statistics(1, 9, 0),
        statistics(2, 9, 0),
    ];
    assert_eq!(read(&blocks).notes, Notes { dropped: 5, foreign: 0 });
}
