//! Where blocks, sections and records begin and end.

use devicenet_cli::recording::{Recording, RecordingError};

use super::{CAN, PACKET, block, interface, packet, read, read_bytes, section};

#[test]
fn what_hides_the_next_block_ends_the_file() {
    let with = |at: usize, value: u32| {
        let mut second = packet(0, 1, PACKET);
        let at = if at == usize::MAX { second.len() - 4 } else { at };
        second[at..at + 4].copy_from_slice(&value.to_le_bytes());
        let read = read(&[interface(CAN, &[]), packet(0, 0, PACKET), second]);
        assert!(read.entries[0].is_ok());
        read.fatal()
    };
    let damaged = |what: &str| format!("the file is damaged after frame 1: {what}");
    assert_eq!(with(4, 0x7FFF_FFFC), damaged("a block says that it has 2147483644 bytes"));
    assert_eq!(with(4, 45), damaged("a block says that it has 45 bytes"));
    assert_eq!(with(4, 8), damaged("a block says that it has 8 bytes"));
    assert_eq!(
        with(usize::MAX, 40),
        damaged("a block says at its beginning that it has 44 bytes, at its end 40")
    );
    let cut_off = "the file is cut off, or a length in it is wrong: it ends within the record after frame 1";
    assert_eq!(with(4, 400), cut_off);
    assert_eq!(with(4, 400_000), cut_off);
    assert_eq!(with(0, 0x0A0D_0D0A), damaged("a section without its magic number"));
    let other_version = block(0x0A0D_0D0A, &[0x4D, 0x3C, 0x2B, 0x1A, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(
        read(&[interface(CAN, &[]), packet(0, 0, PACKET), other_version]).fatal(),
        damaged("a section of another version than 1")
    );
}

/// Each section has a byte order of its own.
#[test]
fn sections_of_either_byte_order_follow_each_other() {
    let swap =
        |bytes: &[u8]| -> Vec<u8> { bytes.chunks(4).flat_map(|word| word.iter().rev().copied()).collect() };
    let mut header = swap(&section());
    // Versions are of 16 bits.
    header[12..16].copy_from_slice(&[0, 1, 0, 0]);
    let mut description = swap(&interface(CAN, &[]));
    description[8..12].copy_from_slice(&[0, 227, 0, 0]);
    let mut frame = swap(&packet(0, 7, PACKET));
    frame[28..37].copy_from_slice(PACKET);
    let little = [interface(CAN, &[]), packet(0, 1, PACKET)].concat();
    let read = read(&[little.clone(), header, description, frame, section(), little]);
    assert_eq!(read.frames(), [("if0", 1000), ("if0", 7000), ("if0", 1000)]);
}

#[test]
fn a_pcap_record_with_a_wrong_length_ends_the_file() {
    let file = |length: u32| {
        let header = [0xA1B2_C3D4, 0x0004_0002, 0, 0, 65_535, 227];
        let fields = [1, 500, 9, 9, 2, 500, length, 9];
        let record = |fields: &[u32]| {
            [&fields.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<_>>(), PACKET].concat()
        };
        [header.map(u32::to_le_bytes).concat(), record(&fields[..4]), record(&fields[4..])].concat()
    };
    assert_eq!(read_bytes(file(9)).frames(), [("", 1_000_500_000), ("", 2_000_500_000)]);
    let fatal = |length| read_bytes(file(length)).fatal();
    assert_eq!(
        fatal(0x0900_0000),
        "the file is damaged after frame 1: a record says that it has 150994944 bytes"
    );
    assert!(fatal(10).starts_with("the file is cut off, or a length in it is wrong"));
    let mut cut = file(9);
    cut.truncate(24 + 25 + 15);
    assert!(read_bytes(cut).fatal().ends_with("it ends within the record after frame 1"));
    assert_eq!(read_bytes(file(9)[..24].to_vec()).entries.len(), 0);
    let header = Recording::from_reader(std::io::Cursor::new(file(9)[..23].to_vec()));
    assert!(matches!(header, Err(RecordingError::Truncated { after: 0 })));
}
