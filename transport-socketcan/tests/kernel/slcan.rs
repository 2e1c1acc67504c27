//! An adapter at a serial line, which has a bit rate.

use std::time::Duration;

use link_core::{BitRate, Input, LinkCommand, LinkEvent, Mode, Port, TxOutcome, TxToken};
use transport_socketcan::{Kind, SocketCanPort};

use crate::adapter::Adapter;
use crate::rig::{frame, input, run, sent, timed_input, wait};

#[test]
#[ignore = "needs slcan"]
fn a_bit_rate_that_another_program_has_set_is_not_confirmed_but_set() {
    // As kernels before 6.0 needed it: the daemon sets the bit rate and opens the channel, past the driver.
    let mut adapter = Adapter::attach("slcan80", &["-o", "-s4"]);
    adapter.hears("S4\r");
    adapter.hears("O\r");
    run("ip", &["link", "set", "slcan80", "up"]);
    let mut port = SocketCanPort::open("slcan80").unwrap();
    assert_eq!(input(&mut port), Input::Link(LinkEvent::Up));
    let kind = |port: &SocketCanPort| port.interface().kind().unwrap();
    assert_eq!(kind(&port), Kind::Controller { bit_rate: None, listen_only: false });

    let mode = Mode { bit_rate: BitRate::K250, listen_only: false };
    port.command(LinkCommand::SetMode(mode)).unwrap();
    assert_eq!(input(&mut port), Input::Link(LinkEvent::ModeSet(mode)));
    assert_eq!(kind(&port), Kind::Controller { bit_rate: Some(BitRate::K250), listen_only: false });
    adapter.hears("S5\r");
    adapter.hears("O\r");

    assert!(!port.interface().has_echo(), "nobody tells whether the adapter has sent it");
    port.transmit(TxToken(1), frame(0x123, &[0xAB, 0xCD])).unwrap();
    assert_eq!(input(&mut port), sent(1));
    adapter.hears("t1232ABCD\r");
    adapter.says("t4561EF\r");
    assert_eq!(timed_input(&mut port).1, Input::Frame(frame(0x456, &[0xEF])));
}

#[test]
#[ignore = "needs slcan"]
fn the_bit_rate_and_the_mode_are_set_by_netlink() {
    let mut adapter = Adapter::attach("slcan81", &[]);
    adapter.set_up(&["bitrate", "125000"]);
    let mut port = SocketCanPort::open("slcan81").unwrap();
    assert_eq!(input(&mut port), Input::Link(LinkEvent::Up));
    let kind = |bit_rate, listen_only| Kind::Controller { bit_rate: Some(bit_rate), listen_only };
    assert_eq!(port.interface().kind().unwrap(), kind(BitRate::K125, false));
    let mode = Mode { bit_rate: BitRate::K250, listen_only: true };
    port.command(LinkCommand::SetMode(mode)).unwrap();
    assert_eq!(input(&mut port), Input::Link(LinkEvent::ModeSet(mode)));
    assert_eq!(port.interface().kind().unwrap(), kind(BitRate::K250, true));
    assert!(port.interface().is_up(), "as it was before");
    adapter.hears("S5\r");
    adapter.hears("L\r");
    adapter.says("t12320102\r");
    assert_eq!(timed_input(&mut port).1, Input::Frame(frame(0x123, &[1, 2])));
}

/// Of a long transmit queue a socket may fill only a part; beyond that the kernel would make the sender wait.
#[test]
#[ignore = "needs slcan"]
fn an_adapter_that_takes_nothing_does_not_hold_a_machine_up() {
    let adapter = Adapter::attach("slcan82", &[]);
    adapter.set_up(&["bitrate", "125000"]);
    run("ip", &["link", "set", adapter.name, "txqueuelen", "5000"]);
    let mut port = SocketCanPort::open(adapter.name).unwrap();
    assert_eq!(input(&mut port), Input::Link(LinkEvent::Up));
    for token in 0..MANY {
        port.transmit(TxToken(token), frame(0x100, &[0; 8])).unwrap();
    }
    let mut taken = 0;
    while wait(&mut port, Duration::from_millis(50)).1 == sent(taken) {
        taken += 1;
    }
    assert!((10..MANY).contains(&taken), "{taken}");
    port.withdraw(TxToken(taken)).unwrap();
    assert_eq!(input(&mut port), Input::TxDone(TxToken(taken), TxOutcome::Withdrawn));
}

const MANY: u16 = 2000;
