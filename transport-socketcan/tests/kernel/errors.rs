//! Error frames. A virtual interface makes none of its own, but delivers those that are written to it.

use link_core::{BitRate, BusErrorKind, Input, LinkCommand, LinkEvent, Mode, Port, TxToken};
use transport_socketcan::SocketCanPort;

use crate::rig::{Interface, dropped, frame, input, run, sent, silent};

fn inject(port: &mut SocketCanPort, error_frame: &str) {
    run("cansend", &[port.interface().name(), error_frame]);
}

#[test]
#[ignore = "needs vcan"]
fn error_frames_are_link_events() {
    let bus = Interface::new("vcan20");
    let mut port = bus.port();
    inject(&mut port, "20000204#0010000000008000");
    assert_eq!(input(&mut port), Input::Link(LinkEvent::Counters { tec: 128, rec: 0 }));
    assert_eq!(input(&mut port), Input::Link(LinkEvent::ErrorPassive));
    inject(&mut port, "20000020#0000000000000000");
    assert_eq!(input(&mut port), Input::Link(LinkEvent::BusError(BusErrorKind::Ack)));
    inject(&mut port, "20000088#0000040000000000");
    assert_eq!(input(&mut port), Input::Link(LinkEvent::BusError(BusErrorKind::Stuff)));
    silent(&mut port);
}

#[test]
#[ignore = "needs vcan"]
fn bus_off_drops_what_is_in_flight_until_a_reset() {
    let bus = Interface::new("vcan21");
    let mut port = bus.port();
    inject(&mut port, "20000040#0000000000000000");
    assert_eq!(input(&mut port), Input::Link(LinkEvent::BusOff));
    port.transmit(TxToken(1), frame(0x100, &[])).unwrap();
    silent(&mut port);
    port.command(LinkCommand::Reset).unwrap();
    assert_eq!(input(&mut port), dropped(1), "a controller that begins anew has nothing to send");
    assert_eq!(input(&mut port), Input::Link(LinkEvent::Up));
    port.transmit(TxToken(2), frame(0x100, &[])).unwrap();
    assert_eq!(input(&mut port), sent(2));
}

#[test]
#[ignore = "needs vcan"]
fn a_controller_that_restarts_by_itself_is_up() {
    let bus = Interface::new("vcan22");
    let mut port = bus.port();
    inject(&mut port, "20000040#0000000000000000");
    assert_eq!(input(&mut port), Input::Link(LinkEvent::BusOff));
    inject(&mut port, "20000100#0000000000000000");
    assert_eq!(input(&mut port), Input::Link(LinkEvent::Up));
}

/// Told in one go: the frame in flight was dropped by the bus-off, not by the restart.
#[test]
#[ignore = "needs vcan"]
fn what_bus_off_drops_is_told_before_the_restart() {
    let bus = Interface::new("vcan24");
    let mut port = bus.port();
    let mode = Mode { bit_rate: BitRate::K125, listen_only: true };
    port.command(LinkCommand::SetMode(mode)).unwrap();
    assert_eq!(input(&mut port), Input::Link(LinkEvent::ModeSet(mode)));
    port.transmit(TxToken(1), frame(0x100, &[])).unwrap();
    inject(&mut port, "20000040#0000000000000000");
    inject(&mut port, "20000100#0000000000000000");
    assert_eq!(input(&mut port), Input::Link(LinkEvent::BusOff));
    assert_eq!(input(&mut port), dropped(1));
    assert_eq!(input(&mut port), Input::Link(LinkEvent::Up));
}

/// More than the receive buffer holds: what is lost is told, and nothing else is.
#[test]
#[ignore = "needs vcan"]
fn lost_frames_are_counted() {
    let bus = Interface::new("vcan23");
    let (mut deaf, mut other) = (bus.port(), bus.port());
    let total = 4000_u32;
    for _ in 0..total {
        other.transmit(TxToken(0), frame(0x100, &[])).unwrap();
        assert_eq!(input(&mut other), sent(0));
    }
    let (mut received, mut lost) = (0, 0);
    // The count comes with the first frame that was queued after a loss.
    while received < total - 1 && lost == 0 {
        match crate::rig::wait(&mut deaf, std::time::Duration::from_millis(50)).1 {
            Input::Frame(_) => received += 1,
            Input::Link(LinkEvent::Overrun { lost: frames }) => lost += frames,
            Input::Tick => {
                other.transmit(TxToken(0), frame(0x100, &[])).unwrap();
                assert_eq!(input(&mut other), sent(0));
            }
            unexpected => panic!("{unexpected:?}"),
        }
    }
    assert!(lost > 0);
    assert_eq!(received + lost, total);
}
