//! Interfaces that go down, vanish and come back.

use link_core::{BitRate, Filter, FilterSet, Input, LinkCommand, LinkEvent, Mode, Port, StandardId, TxToken};
use transport_socketcan::{Error, Kind, SocketCanPort};

use crate::rig::{Interface, dropped, frame, input, sent, silent};

#[test]
#[ignore = "needs vcan"]
fn down_and_up_again_in_the_middle() {
    let bus = Interface::new("vcan30");
    let (mut port, mut other) = (bus.port(), bus.port());
    port.transmit(TxToken(1), frame(0x100, &[])).unwrap();
    assert_eq!(input(&mut port), sent(1));
    bus.set("down");
    assert_eq!(input(&mut port), Input::Link(LinkEvent::Down));
    port.transmit(TxToken(2), frame(0x100, &[])).unwrap();
    silent(&mut port);
    bus.set("up");
    assert_eq!(input(&mut port), Input::Link(LinkEvent::Up));
    assert_eq!(input(&mut port), sent(2), "what a machine sent meanwhile goes out");
    while input(&mut other) != Input::Link(LinkEvent::Up) {}
    port.transmit(TxToken(3), frame(0x200, &[])).unwrap();
    assert_eq!(input(&mut other), Input::Frame(frame(0x200, &[])));
}

#[test]
#[ignore = "needs vcan"]
fn an_adapter_that_is_unplugged_comes_back_with_its_filter() {
    let bus = Interface::new("vcan31");
    let mut port = bus.port();
    let only: FilterSet = [Filter::exact(StandardId::new(0x100).unwrap())].into_iter().collect();
    port.command(LinkCommand::SetFilter(only)).unwrap();
    assert_eq!(input(&mut port), Input::Link(LinkEvent::FilterSet));
    bus.unplug();
    assert_eq!(input(&mut port), Input::Link(LinkEvent::Down));
    silent(&mut port);
    bus.plug();
    assert_eq!(input(&mut port), Input::Link(LinkEvent::Up));
    let mut other = bus.port();
    for id in [0x200, 0x100] {
        other.transmit(TxToken(0), frame(id, &[])).unwrap();
        assert_eq!(input(&mut other), sent(0));
    }
    assert_eq!(input(&mut port), Input::Frame(frame(0x100, &[])), "another index, the same filter");
}

#[test]
#[ignore = "needs vcan"]
fn what_is_in_flight_is_dropped_when_the_interface_goes() {
    let bus = Interface::new("vcan32");
    let mut port = bus.port();
    bus.set("down");
    port.transmit(TxToken(1), frame(0x100, &[])).unwrap();
    let mut inputs = [input(&mut port), input(&mut port)];
    inputs.sort_by_key(|input| matches!(input, Input::TxDone(..)));
    assert_eq!(inputs, [Input::Link(LinkEvent::Down), dropped(1)]);
}

#[test]
#[ignore = "needs vcan"]
fn an_interface_that_is_down_at_first_is_waited_for() {
    let bus = Interface::new("vcan33");
    bus.set("down");
    let mut port = SocketCanPort::open("vcan33").unwrap();
    silent(&mut port);
    bus.set("up");
    assert_eq!(input(&mut port), Input::Link(LinkEvent::Up));
}

#[test]
#[ignore = "needs vcan"]
fn a_virtual_interface_has_every_bit_rate() {
    let bus = Interface::new("vcan34");
    let mut port = bus.port();
    assert_eq!(port.interface().kind().unwrap(), Kind::WithoutBitRate);
    let mode = Mode { bit_rate: BitRate::K250, listen_only: true };
    port.command(LinkCommand::SetMode(mode)).unwrap();
    assert_eq!(input(&mut port), Input::Link(LinkEvent::ModeSet(mode)));
    port.transmit(TxToken(1), frame(0x100, &[])).unwrap();
    silent(&mut port);
    let mode = Mode { bit_rate: BitRate::K125, listen_only: false };
    port.command(LinkCommand::SetMode(mode)).unwrap();
    assert_eq!([input(&mut port), input(&mut port)], [dropped(1), Input::Link(LinkEvent::ModeSet(mode))]);
}

#[test]
#[ignore = "needs vcan"]
fn a_wrong_name_is_answered_with_the_right_ones() {
    let _bus = Interface::new("vcan35");
    let error = SocketCanPort::open("vacn35").unwrap_err();
    assert!(
        matches!(&error, Error::NoInterface { present, .. } if present.contains(&"vcan35".into())),
        "{error}"
    );
    assert!(matches!(SocketCanPort::open("lo"), Err(Error::NotCan { .. })));
}
