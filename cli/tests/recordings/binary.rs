//! pcap and pcapng, whole and damaged.

use devicenet_cli::recording::{Content, Place, RecordingError};
use link_core::Frame;
use link_core::frame::standard_id;

use super::{capture, read_bytes};

#[test]
fn every_byte_order_and_resolution_of_pcap() {
    let packet: &[u8] = &[0, 0, 4, 0x55, 2, 0, 0, 0, 0xAB, 0xCD];
    let build = |magic: u32, number: fn(u32) -> [u8; 4]| {
        let mut file = number(magic).to_vec();
        // Version 2.4 as two half words, swapped like the rest.
        let [a, b, c, d] = number(0x0002_0004);
        file.extend(if number(1) == [0, 0, 0, 1] { [a, b, c, d] } else { [c, d, a, b] });
        for field in [0, 0, 65_535, 227, 1, 500, packet.len() as u32, packet.len() as u32] {
            file.extend(number(field));
        }
        file.extend(packet);
        file
    };
    let files = [
        (build(0xA1B2_C3D4, u32::to_le_bytes), 1_000_500_000, 6),
        (build(0xA1B2_C3D4, u32::to_be_bytes), 1_000_500_000, 6),
        (build(0xA1B2_3C4D, u32::to_le_bytes), 1_000_000_500, 9),
        (build(0xA1B2_3C4D, u32::to_be_bytes), 1_000_000_500, 9),
    ];
    for (file, nanos, digits) in files {
        let frame = read_bytes(&file).unwrap().remove(0).unwrap();
        assert_eq!((frame.at.as_nanos(), frame.digits), (nanos, digits));
        assert_eq!(frame.content, Content::Classic(Frame::new(standard_id(0x455), &[0xAB, 0xCD]).unwrap()));
    }
}

#[test]
fn a_file_that_is_cut_off_gives_its_frames_and_then_says_so() {
    for name in ["socketcan-le-usec.pcap", "socketcan.pcapng"] {
        let bytes = std::fs::read(capture(name)).unwrap();
        let mut entries = read_bytes(&bytes[..bytes.len() - 3]).unwrap();
        assert!(matches!(entries.pop(), Some(Err(RecordingError::Truncated { after: 23 }))), "{name}");
        assert_eq!(entries.len(), 23, "{name}");
    }
}

#[test]
fn another_link_type_is_named() {
    let mut bytes = std::fs::read(capture("socketcan-le-usec.pcap")).unwrap();
    bytes[20] = 1;
    let Err(error) = read_bytes(&bytes) else { panic!("Ethernet is read as CAN") };
    assert!(matches!(error, RecordingError::LinkType { number: 1, name: "Ethernet", .. }));
}

#[test]
fn a_broken_record_in_a_binary_file_is_a_bad_record() {
    let mut bytes = std::fs::read(capture("socketcan-le-usec.pcap")).unwrap();
    // The length of the first packet, which starts at 24 + 16.
    bytes[44] = 99;
    let entries = read_bytes(&bytes).unwrap();
    let Some(Err(RecordingError::Bad(bad))) = entries.first() else { panic!("{:?}", entries.first()) };
    assert_eq!(bad.place, Place::Record { record: 1, byte: 16 });
    assert_eq!(entries.len(), 24, "the rest is read");
}

/// Anything at all, and anything behind a valid beginning, is read without a panic and comes to an end.
#[test]
fn damaged_files_end_in_an_error_and_never_in_a_panic() {
    for name in ["socketcan-le-usec.pcap", "socketcan.pcapng", "candump-ta.txt", "candump-L-mixed.log"] {
        let whole = std::fs::read(capture(name)).unwrap();
        for at in 0..whole.len() {
            for value in [0x00, 0x7F, 0xFF, whole[at] ^ 0x01] {
                let mut bytes = whole.clone();
                bytes[at] = value;
                let _ = read_bytes(&bytes);
            }
        }
    }
}
