//! What a packet is, and what is wrong with it that does not hide the next one.

use devicenet_cli::recording::{Content, Opened, Place, Recording};

use super::{CAN, ETHERNET, PACKET, block, interface, packet, read, section};

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

/// Obsolete packet: interface and packets lost in 16 bits each, then like the enhanced one.
#[test]
fn an_obsolete_packet_has_all_that_is_needed() {
    let enhanced = packet(1, 1, PACKET);
    let obsolete = block(2, &enhanced[8..enhanced.len() - 4]);
    let read = read(&[interface(CAN, &[]), interface(CAN, &[]), obsolete, packet(0, 2, PACKET)]);
    assert_eq!(read.frames(), [("if1", 1000), ("if0", 2000)]);
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
