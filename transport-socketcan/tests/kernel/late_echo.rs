//! Interfaces that echo a frame when it was sent, as those with a controller do. A slow queue takes the place of a busy bus.

use std::time::Duration;

use link_core::{Filter, FilterSet, Input, LinkCommand, LinkEvent, Port, StandardId, TxOutcome, TxToken};
use transport_socketcan::{SocketCanPort, Unconfirmed};

use crate::rig::{Interface, dropped, frame, input, run, sent, silent, wait};

/// An interface on which a frame takes its time.
fn slow(name: &'static str, time: &str) -> (Interface, SocketCanPort) {
    let bus = Interface::new(name);
    run("tc", &["qdisc", "add", "dev", name, "root", "netem", "delay", time]);
    let port = bus.port();
    (bus, port)
}

fn inject(port: &SocketCanPort, error_frame: &str) {
    // Past the queue, as a controller does.
    run("tc", &["qdisc", "del", "dev", port.interface().name(), "root"]);
    run("cansend", &[port.interface().name(), error_frame]);
}

#[test]
#[ignore = "needs vcan"]
fn a_frame_is_sent_when_it_has_left_the_queue() {
    let (_bus, mut port) = slow("vcan60", "100ms");
    let before = port.now();
    port.transmit(TxToken(1), frame(0x100, &[])).unwrap();
    silent(&mut port);
    let (at, done) = wait(&mut port, Duration::from_secs(5));
    assert_eq!(done, sent(1));
    assert!(at >= before + Duration::from_millis(100), "{before} {at}");
}

/// A driver has lost a frame without a word. The port goes on, and says that it does not know; a late echo is nobody's.
#[test]
#[ignore = "needs vcan"]
fn a_frame_of_which_nothing_is_heard_does_not_stop_the_port() {
    let (_bus, mut port) = slow("vcan68", "8s");
    let before = port.now();
    port.transmit(TxToken(1), frame(0x100, &[1])).unwrap();
    port.transmit(TxToken(2), frame(0x200, &[2])).unwrap();
    let (at, done) = wait(&mut port, Duration::from_secs(20));
    assert_eq!(done, Input::TxDone(TxToken(1), TxOutcome::Unknown));
    assert_eq!(port.unconfirmed(), Some(Unconfirmed::Silence));
    assert!(at >= before + Duration::from_secs(3), "{before} {at}");
    // The second is with the kernel since then, for six seconds. The echo of the first, at eight, is not its own, and says that the bus
    // is alive.
    let (at, done) = wait(&mut port, Duration::from_secs(20));
    assert_eq!(done, Input::TxDone(TxToken(2), TxOutcome::Unknown));
    assert_eq!(port.unconfirmed(), Some(Unconfirmed::Unheard));
    assert!(at >= before + Duration::from_secs(9), "{before} {at}");
    port.transmit(TxToken(3), frame(0x300, &[3])).unwrap();
    let (_, done) = wait(&mut port, Duration::from_secs(20));
    assert_eq!(done, Input::TxDone(TxToken(3), TxOutcome::Unknown));
    assert!(port.now() < at + Duration::from_secs(6), "{at}");
}

/// An application that has not waited for anything for a while has its frame waited for no less.
#[test]
#[ignore = "needs vcan"]
fn a_port_that_was_idle_is_as_patient() {
    let (_bus, mut port) = slow("vcan53", "300ms");
    run("sleep", &["3.5"]);
    port.transmit(TxToken(1), frame(0x100, &[])).unwrap();
    assert_eq!(input(&mut port), sent(1));
}

/// Nobody acknowledges: the controller sends its frame again and again, and it is not lost.
#[test]
#[ignore = "needs vcan"]
fn a_frame_of_a_controller_in_trouble_is_waited_for() {
    let bus = Interface::new("vcan69");
    let mut port = bus.port();
    run("cansend", &["vcan69", "20000004#0020000000000000"]);
    assert_eq!(input(&mut port), Input::Link(LinkEvent::ErrorPassive));
    run("tc", &["qdisc", "add", "dev", "vcan69", "root", "netem", "delay", "4s"]);
    port.transmit(TxToken(1), frame(0x100, &[])).unwrap();
    assert_eq!(input(&mut port), sent(1));
}

/// A controller begins anew with its interface, and tells of no trouble any more.
#[test]
#[ignore = "needs vcan"]
fn trouble_does_not_outlast_the_interface() {
    let bus = Interface::new("vcan59");
    let mut port = bus.port();
    run("cansend", &["vcan59", "20000004#0020000000000000"]);
    assert_eq!(input(&mut port), Input::Link(LinkEvent::ErrorPassive));
    bus.set("down");
    assert_eq!(input(&mut port), Input::Link(LinkEvent::Down));
    bus.set("up");
    assert_eq!(input(&mut port), Input::Link(LinkEvent::Up));
    run("tc", &["qdisc", "add", "dev", "vcan59", "root", "netem", "delay", "10s"]);
    port.transmit(TxToken(1), frame(0x100, &[])).unwrap();
    assert_eq!(input(&mut port), Input::TxDone(TxToken(1), TxOutcome::Unknown));
}

/// Two nodes with one MAC ID send the same duplicate MAC ID check: neither may take the other's for its own.
#[test]
#[ignore = "needs vcan"]
fn a_twins_identical_frame_is_not_the_echo() {
    let bus = Interface::new("vcan65");
    let (mut one, mut twin) = (bus.port(), bus.port());
    let check = frame(0x52F, &[0, 0x34, 0x12, 0x45, 0x23, 0, 0]);
    twin.transmit(TxToken(1), check).unwrap();
    one.transmit(TxToken(2), check).unwrap();
    assert_eq!(input(&mut one), Input::Frame(check), "the twin's, which was first");
    assert_eq!(input(&mut one), sent(2));
    assert_eq!(input(&mut twin), sent(1));
    assert_eq!(input(&mut twin), Input::Frame(check));
}

/// The first of three is with the kernel before the others come; of these, the more urgent goes first.
#[test]
#[ignore = "needs vcan"]
fn the_most_urgent_frame_goes_first() {
    let bus = Interface::new("vcan66");
    let (mut one, mut other) = (bus.port(), bus.port());
    for (token, id) in [(1, 0x600), (2, 0x500), (3, 0x100)] {
        one.transmit(TxToken(token), frame(id, &[])).unwrap();
    }
    let order: Vec<Input> = (0..3).map(|_| input(&mut one)).collect();
    assert_eq!(order, [sent(1), sent(3), sent(2)]);
    let ids: Vec<Input> = (0..3).map(|_| input(&mut other)).collect();
    assert_eq!(ids, [0x600, 0x100, 0x500].map(|id| Input::Frame(frame(id, &[]))));
}

#[test]
#[ignore = "needs vcan"]
fn what_was_received_before_the_interface_went_down_is_told_before_that() {
    let bus = Interface::new("vcan67");
    let (mut port, mut other) = (bus.port(), bus.port());
    other.transmit(TxToken(1), frame(0x200, &[])).unwrap();
    port.transmit(TxToken(2), frame(0x100, &[])).unwrap();
    bus.set("down");
    assert_eq!(input(&mut port), Input::Frame(frame(0x200, &[])));
    assert_eq!(input(&mut port), sent(2));
    assert_eq!(input(&mut port), Input::Link(LinkEvent::Down));
}

/// A node changes its filter when it goes on line, or when a connection comes; a frame may be on its way then.
#[test]
#[ignore = "needs vcan"]
fn a_new_filter_lets_the_echo_of_the_frame_in_flight_pass() {
    let (_bus, mut port) = slow("vcan61", "100ms");
    let only: FilterSet = [Filter::exact(StandardId::new(0x100).unwrap())].into_iter().collect();
    port.command(LinkCommand::SetFilter(only.clone())).unwrap();
    port.transmit(TxToken(1), frame(0x200, &[])).unwrap();
    port.command(LinkCommand::SetFilter(only)).unwrap();
    assert_eq!(input(&mut port), Input::Link(LinkEvent::FilterSet));
    assert_eq!(input(&mut port), Input::Link(LinkEvent::FilterSet));
    assert_eq!(input(&mut port), sent(1));
}

/// The news of bus-off may be lost, or older than the port. What the controller had is gone, and would be waited for without end.
#[test]
#[ignore = "needs vcan"]
fn a_restart_out_of_the_blue_was_from_bus_off() {
    let (_bus, mut port) = slow("vcan62", "10s");
    port.transmit(TxToken(1), frame(0x100, &[])).unwrap();
    silent(&mut port);
    inject(&port, "20000100#0000000000000000");
    assert_eq!(input(&mut port), Input::Link(LinkEvent::BusOff));
    assert_eq!(input(&mut port), dropped(1));
    assert_eq!(input(&mut port), Input::Link(LinkEvent::Up));
    port.transmit(TxToken(2), frame(0x100, &[])).unwrap();
    assert_eq!(input(&mut port), sent(2));
}

#[test]
#[ignore = "needs vcan"]
fn the_news_of_an_own_restart_is_no_second_one() {
    let (_bus, mut port) = slow("vcan63", "300ms");
    inject(&port, "20000040#0000000000000000");
    assert_eq!(input(&mut port), Input::Link(LinkEvent::BusOff));
    port.command(LinkCommand::Reset).unwrap();
    assert_eq!(input(&mut port), Input::Link(LinkEvent::Up));
    inject_restarted(&mut port);
    port.transmit(TxToken(1), frame(0x100, &[])).unwrap();
    assert_eq!(input(&mut port), sent(1));
}

fn inject_restarted(port: &mut SocketCanPort) {
    run("cansend", &[port.interface().name(), "20000100#0000000000000000"]);
    silent(port);
}

/// One frame of a burst is not told from another: the echo may have been among those that were lost. But only of the frame that
/// was in flight then.
#[test]
#[ignore = "needs vcan"]
fn a_loss_says_nothing_of_later_frames() {
    let bus = Interface::new("vcan64");
    let (mut port, mut other) = (bus.port(), bus.port());
    port.command(LinkCommand::SetFilter(
        [Filter::exact(StandardId::new(0x200).unwrap())].into_iter().collect(),
    ))
    .unwrap();
    assert_eq!(input(&mut port), Input::Link(LinkEvent::FilterSet));
    let mut burst = |count: u32| {
        for _ in 0..count {
            other.transmit(TxToken(0), frame(0x200, &[])).unwrap();
            while input(&mut other) != sent(0) {}
        }
    };
    burst(4000);
    port.transmit(TxToken(1), frame(0x100, &[])).unwrap();
    let mut inputs = Vec::new();
    loop {
        match wait(&mut port, Duration::from_millis(50)).1 {
            Input::Tick if inputs.is_empty() => burst(1),
            Input::Tick => break,
            Input::Frame(_) => {}
            other => inputs.push(other),
        }
    }
    assert!(matches!(inputs[..], [Input::Link(LinkEvent::Overrun { .. })]), "{inputs:?}");
    inject_bus_off_and_restart(&mut port);
    run("tc", &["qdisc", "add", "dev", "vcan64", "root", "netem", "delay", "1500ms"]);
    port.transmit(TxToken(2), frame(0x100, &[])).unwrap();
    assert_eq!(input(&mut port), sent(2), "more than the patience for a lost echo");
}

fn inject_bus_off_and_restart(port: &mut SocketCanPort) {
    run("cansend", &[port.interface().name(), "20000040#0000000000000000"]);
    assert_eq!(input(port), Input::Link(LinkEvent::BusOff));
    assert_eq!(input(port), dropped(1));
    run("cansend", &[port.interface().name(), "20000100#0000000000000000"]);
    assert_eq!(input(port), Input::Link(LinkEvent::Up));
}
