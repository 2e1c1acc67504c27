//! A transmit queue that is full, on an interface with a bit rate.

use link_core::{Port, TxToken};

use crate::rig::{Interface, frame, input, run, sent};

/// The queue of the interface holds two frames and lets a frame pass each millisecond; another program keeps it full.
#[test]
#[ignore = "needs vcan"]
fn a_frame_that_finds_no_room_is_sent_later() {
    let bus = Interface::new("vcan40");
    run("tc", &["qdisc", "add", "dev", "vcan40", "root", "netem", "rate", "128kbit", "limit", "2"]);
    let mut crowd: Vec<_> = (0..6).map(|_| bus.port()).collect();
    for (token, port) in (0_u16..).zip(&mut crowd) {
        port.transmit(TxToken(token), frame(0x100 + token, &[0; 8])).unwrap();
    }
    for (token, port) in (0_u16..).zip(&mut crowd) {
        while input(port) != sent(token) {}
    }
}
