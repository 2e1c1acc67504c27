//! Frames there and back, and whose they are.

use std::time::Duration;

use link_core::machine::Deadline;
use link_core::{
    ExtendedId, Filter, FilterSet, Frame, Input, LinkCommand, LinkEvent, Port, StandardId, TxToken,
};

use crate::rig::{Interface, extended, frame, input, sent, silent, timed_input, wait};

#[test]
#[ignore = "needs vcan"]
fn a_frame_is_sent_when_its_echo_comes_and_others_receive_it() {
    let bus = Interface::new("vcan10");
    let (mut one, mut other) = (bus.port(), bus.port());
    let before = one.now();
    one.transmit(TxToken(7), frame(0x52F, &[0, 0x34, 0x12])).unwrap();
    let (at, done) = timed_input(&mut one);
    assert_eq!(done, sent(7));
    assert!(at >= before && at <= one.now());
    assert_eq!(input(&mut other), Input::Frame(frame(0x52F, &[0, 0x34, 0x12])));
    silent(&mut one);
}

#[test]
#[ignore = "needs vcan"]
fn long_identifiers_and_remote_frames() {
    let bus = Interface::new("vcan12");
    let (mut one, mut other) = (bus.port(), bus.port());
    let frames = [
        extended(0x1FFE_4433, &[1, 2, 3, 4, 5, 6, 7, 8]),
        extended(0x52F, &[]),
        Frame::remote(StandardId::new(0x52F).unwrap(), 7).unwrap(),
        Frame::remote(ExtendedId::new(0x1000_0000).unwrap(), 0).unwrap(),
    ];
    for frame in frames {
        one.transmit(TxToken(0), frame).unwrap();
        assert_eq!(input(&mut one), sent(0));
        assert_eq!(input(&mut other), Input::Frame(frame));
    }
}

#[test]
#[ignore = "needs vcan"]
fn a_length_code_above_eight_is_sent_as_eight() {
    let bus = Interface::new("vcan17");
    let (mut one, mut other) = (bus.port(), bus.port());
    let long = Frame::with_dlc(StandardId::new(0x100).unwrap(), 15, [1; 8]).unwrap();
    let remote = Frame::remote(StandardId::new(0x100).unwrap(), 9).unwrap();
    for long in [long, remote] {
        one.transmit(TxToken(0), long).unwrap();
        assert_eq!(input(&mut one), sent(0));
        assert!(matches!(input(&mut other), Input::Frame(frame) if frame.dlc() == 8));
    }
}

#[test]
#[ignore = "needs vcan"]
fn the_kernel_filters_and_own_frames_are_confirmed_all_the_same() {
    let bus = Interface::new("vcan14");
    let (mut one, mut other) = (bus.port(), bus.port());
    let wanted: FilterSet = [
        Filter::standard(StandardId::new(0x780).unwrap(), 0x7C0),
        Filter::exact(ExtendedId::new(0x123).unwrap()),
    ]
    .into_iter()
    .collect();
    one.command(LinkCommand::SetFilter(wanted)).unwrap();
    assert_eq!(input(&mut one), Input::Link(LinkEvent::FilterSet));
    let remote = Frame::remote(StandardId::new(0x7BF).unwrap(), 1).unwrap();
    for frame in [frame(0x123, &[]), frame(0x7C0, &[]), extended(0x780, &[]), remote, extended(0x123, &[9])] {
        other.transmit(TxToken(0), frame).unwrap();
        assert_eq!(input(&mut other), sent(0));
    }
    assert_eq!(input(&mut one), Input::Frame(remote));
    assert_eq!(input(&mut one), Input::Frame(extended(0x123, &[9])));
    silent(&mut one);
    // The kernel's own tables of receivers: the two filters, which say nothing of remote frames, and the other port's for everything.
    assert_eq!(receivers("fil", bus.0), ["780 800007c0", "80000123 9fffffff"]);
    assert_eq!(receivers("all", bus.0).len(), 1);
    one.transmit(TxToken(5), frame(0x3F0, &[1])).unwrap();
    assert_eq!(input(&mut one), sent(5), "its echo passes, though the filter has no room for it");
}

/// What the kernel delivers from an interface: identifier and mask of each entry of a table.
fn receivers(table: &str, bus: &str) -> Vec<String> {
    let table = std::fs::read_to_string(format!("/proc/net/can/rcvlist_{table}")).unwrap();
    let columns = table.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
    let mut receivers: Vec<String> = columns
        .filter(|columns| columns.first() == Some(&bus))
        .map(|columns| columns[1..3].join(" "))
        .collect();
    receivers.sort();
    receivers
}

#[test]
#[ignore = "needs vcan"]
fn a_port_that_only_listens_sends_nothing() {
    let bus = Interface::new("vcan15");
    let mut quiet = transport_socketcan::SocketCanPort::open_listen_only("vcan15").unwrap();
    let mut other = bus.port();
    assert_eq!(input(&mut quiet), Input::Link(LinkEvent::Up));
    quiet.transmit(TxToken(0), frame(0x100, &[])).unwrap();
    other.transmit(TxToken(0), frame(0x200, &[])).unwrap();
    assert_eq!(input(&mut quiet), Input::Frame(frame(0x200, &[])));
    assert_eq!(input(&mut other), sent(0));
    silent(&mut other);
    quiet.withdraw(TxToken(0)).unwrap();
    assert_eq!(input(&mut quiet), Input::TxDone(TxToken(0), link_core::TxOutcome::Withdrawn));
}

#[test]
#[ignore = "needs vcan"]
fn a_deadline_is_kept_and_frames_come_before_it() {
    let bus = Interface::new("vcan16");
    let (mut one, mut other) = (bus.port(), bus.port());
    let at = one.now() + Duration::from_millis(30);
    let (now, tick) = one.wait(Some(Deadline { at, why: "the test" })).unwrap();
    assert_eq!(tick, Input::Tick);
    assert!(now >= at, "never early");
    other.transmit(TxToken(0), frame(0x100, &[])).unwrap();
    let late = Deadline { at, why: "long over" };
    assert_eq!(one.wait(Some(late)).unwrap().1, Input::Frame(frame(0x100, &[])));
    assert_eq!(one.wait(Some(late)).unwrap().1, Input::Tick);
    assert_eq!(wait(&mut other, Duration::ZERO).1, sent(0));
}
