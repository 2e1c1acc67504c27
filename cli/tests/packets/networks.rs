//! Interfaces of other networks.

use devicenet_cli::recording::{Network, Notes, Opened};

use super::{CAN, ETHERNET, PACKET, interface, packet, read, section};

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
