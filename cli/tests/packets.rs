//! pcap and pcapng files with everything that the formats allow, and with what they do not. The layouts are those of the
//! IETF drafts (draft-ietf-opsawg-pcapng, draft-ietf-opsawg-pcap) and of tcpdump.org, `LINKTYPE_CAN_SOCKETCAN`.
#![allow(
    clippy::arithmetic_side_effects,
    clippy::as_conversions,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test may panic"
)]

use devicenet_cli::recording::{Bad, Content, Network, Notes, Opened, Place, Recording, RecordingError};
use link_core::Frame;
use link_core::frame::standard_id;

/// Identifier 0x455 with the data 0x4B.
const PACKET: &[u8] = &[0, 0, 4, 0x55, 1, 0, 0, 0, 0x4B];
const CAN: u16 = 227;
const ETHERNET: u16 = 1;

/// A block, little-endian: type, length, body on a 32-bit boundary, length.
fn block(kind: u32, body: &[u8]) -> Vec<u8> {
    let padding = body.len().next_multiple_of(4) - body.len();
    let length = (12 + body.len() + padding) as u32;
    [&kind.to_le_bytes()[..], &length.to_le_bytes(), body, &[0; 3][..padding], &length.to_le_bytes()].concat()
}

/// Section header: magic number, version 1.0, length of the section unknown.
fn section() -> Vec<u8> {
    block(0x0A0D_0D0A, &[0x4D, 0x3C, 0x2B, 0x1A, 1, 0, 0, 0, 255, 255, 255, 255, 255, 255, 255, 255])
}

fn option(code: u16, value: &[u8]) -> Vec<u8> {
    let padding = value.len().next_multiple_of(4) - value.len();
    [&code.to_le_bytes()[..], &(value.len() as u16).to_le_bytes(), value, &[0; 3][..padding]].concat()
}

/// Interface description: link type, reserved, snapshot length, options.
fn interface(link_type: u16, options: &[Vec<u8>]) -> Vec<u8> {
    block(1, &[&link_type.to_le_bytes()[..], &[0; 6], &options.concat()].concat())
}

/// Enhanced packet: interface, time, length in the file, length on the wire, packet.
fn packet(interface: u32, units: u64, data: &[u8]) -> Vec<u8> {
    let fields = [interface, (units >> 32) as u32, units as u32, data.len() as u32, data.len() as u32];
    block(6, &[&fields.map(u32::to_le_bytes).concat(), data].concat())
}

/// What a file holds: channel and time in nanoseconds of each frame, or the error.
struct Read {
    entries: Vec<Result<(String, u64), RecordingError>>,
    notes: Notes,
}

fn read(blocks: &[Vec<u8>]) -> Read {
    read_bytes([section(), blocks.concat()].concat())
}

fn read_bytes(bytes: Vec<u8>) -> Read {
    let mut recording = Recording::from_reader(std::io::Cursor::new(bytes)).unwrap();
    let mut entries = Vec::new();
    while let Some(entry) = recording.next() {
        entries.push(entry.map(|frame| {
            let expected = Frame::new(standard_id(0x455), &[0x4B]).unwrap();
            assert_eq!(frame.content, Content::Classic(expected));
            let name = frame.channel.map_or("", |channel| recording.channels().name(channel));
            (name.to_owned(), frame.at.as_nanos())
        }));
    }
    Read { entries, notes: recording.notes() }
}

impl Read {
    #[track_caller]
    fn frames(&self) -> Vec<(&str, u64)> {
        let frames =
            self.entries.iter().map(|entry| entry.as_ref().unwrap_or_else(|error| panic!("{error}")));
        frames.map(|(name, at)| (&**name, *at)).collect()
    }

    /// The bad record at a place in the file, and that it is not the end of it.
    #[track_caller]
    fn bad(&self, index: usize) -> (Place, &'static str) {
        assert!(self.entries[index + 1].is_ok(), "the rest is read");
        match &self.entries[index] {
            Err(RecordingError::Bad(bad)) => {
                let Bad { place, expected, .. } = **bad;
                (place, expected)
            }
            other => panic!("{other:?}"),
        }
    }

    /// The error that ends the file.
    #[track_caller]
    fn fatal(&self) -> String {
        let error = self.entries.last().unwrap().as_ref().unwrap_err();
        assert!(error.is_fatal());
        error.to_string()
    }
}

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
fn other_networks_are_skipped_and_counted() {
    let huge = packet(0, 0, &vec![0; 300_000]);
    let blocks = [
        interface(ETHERNET, &[]),
        packet(0, 0, b"an Ethernet frame"),
        interface(CAN, &[]),
        packet(1, 1, PACKET),
        huge,
        packet(1, 2, PACKET),
    ];
    let read = read(&blocks);
    assert_eq!(read.frames(), [("if1", 1000), ("if1", 2000)]);
    assert_eq!(read.notes, Notes { foreign: 2, dropped: 0 });
}

/// The network is that of the interfaces before the first packet: CAN, if there is one, unless the user says another.
#[test]
fn the_network_is_that_of_the_first_interfaces() {
    let frame = &b"an Ethernet frame"[..];
    let open = |blocks: &[Vec<u8>], network| {
        let bytes = [section(), blocks.concat()].concat();
        match Opened::from_reader(std::io::Cursor::new(bytes), network).unwrap() {
            Opened::Can(recording) => ("CAN", recording.count()),
            Opened::Ethernet(capture) => {
                let frames = capture.map(|entry| entry.unwrap().content);
                (
                    "Ethernet",
                    frames.filter(|content| &*content.bytes == frame && content.length == 17).count(),
                )
            }
        }
    };
    let (ethernet, can) = (interface(ETHERNET, &[]), interface(CAN, &[]));
    let both =
        [ethernet.clone(), can.clone(), packet(0, 0, frame), packet(1, 1, PACKET), packet(0, 2, frame)];
    assert_eq!(open(&both, None), ("CAN", 1));
    assert_eq!(open(&both, Some(Network::Ethernet)), ("Ethernet", 2));
    let late = [ethernet.clone(), packet(0, 0, frame), can, packet(1, 1, PACKET)];
    assert_eq!(open(&late, None), ("Ethernet", 1));
    assert_eq!(open(&late, Some(Network::Can)), ("CAN", 1));
    assert_eq!(open(&[interface(113, &[])], None).0, "CAN");
    assert_eq!(open(&[ethernet], None), ("Ethernet", 0));
}

/// A packet that the capture cut tells how long it was.
#[test]
fn a_cut_packet_has_its_length() {
    let fields = [0, 0, 0, 3, 60_u32].map(u32::to_le_bytes).concat();
    let cut = block(6, &[&fields[..], &[1, 2, 3]].concat());
    let bytes = [section(), interface(ETHERNET, &[]), cut].concat();
    let Ok(Opened::Ethernet(mut capture)) = Opened::from_reader(std::io::Cursor::new(bytes), None) else {
        panic!("a capture of Ethernet")
    };
    let content = capture.next().unwrap().unwrap().content;
    assert_eq!((&*content.bytes, content.length), (&[1, 2, 3][..], 60));
}

/// Files may be joined: what comes first does not tell what follows.
#[test]
fn a_file_without_any_can_interface_is_no_recording() {
    let ethernet = [interface(ETHERNET, &[]), packet(0, 0, b"an Ethernet frame")];
    let alone = read(&ethernet);
    assert_eq!(alone.entries.len(), 1);
    assert!(alone.fatal().starts_with("link type 1 (Ethernet) instead of 227 (CAN_SOCKETCAN)"));
    let can = [section(), interface(CAN, &[]), packet(0, 5, PACKET)];
    assert_eq!(read(&[&ethernet[..], &can].concat()).frames(), [("if0", 5000)]);
}

#[test]
fn what_is_wrong_within_a_block_is_a_bad_record() {
    let short = |bytes: usize| block(6, &packet(0, 0, PACKET)[8..8 + bytes]);
    let mut long = packet(0, 0, PACKET);
    long[8 + 12] = 13;
    let cases = [
        (short(0), 1, "a packet block with all its fields"),
        (short(16), 17, "a packet block with all its fields"),
        (long, 13, "a length that fits into the block"),
        (packet(7, 0, PACKET), 1, "an interface that was described before"),
        (packet(0, 0, &PACKET[..7]), 8, "a header of 8 bytes"),
        // Simple packet: length on the wire, packet.
        (
            block(3, &[&9u32.to_le_bytes(), PACKET].concat()),
            1,
            "a packet with a time, an Enhanced Packet Block",
        ),
    ];
    for (block, byte, expected) in cases {
        let read = read(&[interface(CAN, &[]), packet(0, 0, PACKET), block, packet(0, 0, PACKET)]);
        assert_eq!(read.bad(1), (Place::Record { record: 2, byte }, expected));
        assert_eq!(read.entries.len(), 3);
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

/// Obsolete packet: interface and packets lost in 16 bits each, then like the enhanced one.
#[test]
fn an_obsolete_packet_has_all_that_is_needed() {
    let enhanced = packet(1, 1, PACKET);
    let obsolete = block(2, &enhanced[8..enhanced.len() - 4]);
    let read = read(&[interface(CAN, &[]), interface(CAN, &[]), obsolete, packet(0, 2, PACKET)]);
    assert_eq!(read.frames(), [("if1", 1000), ("if0", 2000)]);
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

/// A packet of a kernel that does not set the flag: `struct canfd_frame` has 72 bytes.
#[test]
fn a_can_fd_frame_without_its_flag_is_known_by_its_size() {
    let fd = [&[0, 0, 4, 0x53, 2, 1, 0, 0, 1, 2][..], &[0; 62]].concat();
    let file = [section(), interface(CAN, &[]), packet(0, 0, &fd)].concat();
    let frame = Recording::from_reader(std::io::Cursor::new(file)).unwrap().next().unwrap().unwrap();
    let Content::Fd(frame) = frame.content else { panic!("{frame:?}") };
    assert_eq!((frame.data(), frame.bit_rate_switch), (&[1, 2][..], true));
}

#[test]
fn a_remote_frame_has_no_more_than_8_bytes() {
    let remote = [0x40, 0, 4, 0x55, 9, 0, 0, 0];
    let read = read(&[interface(CAN, &[]), packet(0, 0, &remote), packet(0, 0, PACKET)]);
    assert_eq!(read.bad(0), (Place::Record { record: 1, byte: 5 }, "a length of at most 8"));
}

/// Class 4 with the details 00 04.
#[test]
fn an_error_frame_has_the_bytes_that_its_length_says() {
    let error = [0x20, 0, 0, 4, 8, 0, 0, 0, 0, 4, 0, 0, 0, 0, 0, 0];
    let file = |error: &[u8]| read(&[interface(CAN, &[]), packet(0, 0, error), packet(0, 0, PACKET)]);
    let place = |byte| Place::Record { record: 1, byte };
    assert_eq!(file(&error[..12]).bad(0), (place(13), "as many bytes as the length says"));
    let mut long = [0; 20];
    long[..16].copy_from_slice(&error);
    long[4] = 9;
    assert_eq!(file(&long).bad(0), (place(5), "a length of at most 8"));
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
