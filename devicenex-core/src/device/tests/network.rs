//! Leaving the network, coming back, and what the controller is told.

use std::string::ToString;
use std::vec::Vec;

use cip_core::message::ResetType;
use link_core::{Filter, Input, LinkEvent, Machine, TxOutcome, TxToken};

use super::bus::{Bus, frame};
use crate::access::StateKind;
use crate::device::DeviceEvent;

/// An explicit connection, a consumer that runs, a producer.
fn busy() -> Bus {
    let mut bus = Bus::explicit();
    bus.connects(&[0x4B, 0xC0, 13, 0, 100, 0, 0], &[0x4B, 0xC0, 0, 100, 0]);
    bus.connects(&[0x4B, 0xC0, 7, 0, 100, 0, 0], &[0x4B, 0xC0, 0, 100, 0]);
    bus.hears(0x0002_0007, &[9]);
    bus.forget();
    bus
}

#[track_caller]
fn has_lost_everything(bus: &Bus) {
    assert_eq!(bus.node.connections().count(), 0);
    assert_eq!(bus.node.application().outputs, [0]);
    assert_eq!(bus.node.application().rests.len(), 1);
    let lost = bus.events.iter().filter(|event| event.to_string().ends_with("network lost"));
    assert_eq!(lost.count(), 3, "{:?}", bus.events);
}

#[test]
fn connections_end_with_the_network() {
    for event in [LinkEvent::Down, LinkEvent::BusOff] {
        let mut bus = busy();
        bus.link(event);
        has_lost_everything(&bus);
        bus.forget();
        bus.wait(60_000);
        bus.is_silent();
    }
}

/// Another node with the address is already there.
#[test]
fn connections_end_with_the_address() {
    let mut bus = busy();
    bus.hears(0x1F87_0001, &[0, 0, 1, 0, 1, 0, 1, 0]);
    has_lost_everything(&bus);
    // Hello without an address; what was on its way is not answered any more.
    bus.sends(0x1FFE_4433, &[0x22, 0x11, 0xE7, 0x03, 0x2A, 0, 1, 0]);
    bus.hears(0x1086_0205, &[0x0E, 3, 1, 1]);
    bus.hears(0x1C86_0205, &[0x0E, 3, 1, 1]);
    bus.hears(0x1CFE_0205, &[0x0E, 3, 1, 1]);
    bus.hears(0x1DFE_0205, &[0x4B, 0xC0, 7, 0, 0, 0, 0]);
    bus.is_silent();
}

/// The response goes out under the old address, then Hello with the new one.
#[test]
fn another_address() {
    let mut bus = busy();
    bus.hears(0x1086_0205, &[0x10, 3, 1, 1, 68]);
    bus.sends(0x1003_8605, &[0x90]);
    bus.sends(0x1F88_4433, &[0x22, 0x11, 0xE7, 0x03, 0x2A, 0, 1, 0]);
    has_lost_everything(&bus);
    bus.forget();
    bus.wait(2000);
    assert!(bus.node.access().is_online());
    bus.hears(0x1C88_0205, &[0x0E, 3, 1, 1]);
    bus.sends_besides(0x1C03_8805, &[0x8E, 68]);
}

#[test]
fn an_address_is_given_up() {
    let mut bus = busy();
    bus.hears(0x1086_0205, &[0x10, 3, 1, 1, 127]);
    bus.wait(2000);
    assert_eq!(bus.node.access().state().kind(), StateKind::Standby);
}

#[test]
fn a_node_that_leaves_serves_nobody() {
    let mut bus = busy();
    bus.stuck = true;
    bus.hears(0x1086_0205, &[0x10, 3, 1, 1, 68]);
    bus.told();
    bus.hears(0x1086_0206, &[0x10, 3, 1, 1, 69]);
    bus.hears(0x1C86_0206, &[0x0E, 3, 1, 1]);
    bus.hears(0x1D86_0206, &[0x4B, 0xC0, 3, 0, 0, 0, 0]);
    assert_eq!(
        bus.told(),
        [
            "10860206 ignored: leaving its address",
            "1C860206 ignored: leaving its address",
            "1D860206 ignored: leaving its address"
        ]
    );
    // Its data go on until it has left.
    bus.hears(0x0002_0007, &[5]);
    assert_eq!(bus.node.application().outputs, [5]);
    bus.unstick();
    assert_eq!(bus.node.access().address().number(), 68);
}

#[test]
fn a_reset() {
    let mut bus = busy();
    bus.hears(0x1086_0205, &[0x05, 1, 1]);
    bus.sends(0x1003_8605, &[0x85]);
    has_lost_everything(&bus);
    assert!(bus.events.contains(&DeviceEvent::Reset(ResetType::POWER_CYCLE)));
    // It begins with the bit rate, and has no address.
    assert_eq!(bus.node.access().state().kind(), StateKind::DetectingBitRate);
    assert!(bus.node.access().address().is_none());
}

/// What was accepted is carried out all the same.
#[test]
fn a_reset_whose_response_is_lost() {
    let mut bus = busy();
    bus.stuck = true;
    bus.hears(0x1086_0205, &[0x05, 1, 1]);
    bus.link(LinkEvent::BusOff);
    assert!(bus.events.contains(&DeviceEvent::Reset(ResetType::POWER_CYCLE)));
    // The controller has dropped what it had.
    for (token, _) in core::mem::take(&mut bus.held) {
        bus.input(Input::TxDone(token, TxOutcome::Dropped));
    }
    assert_eq!((bus.node.counters().not_sent, bus.node.counters().stray_tx_done), (0, 0));
}

#[test]
fn operators_commands() {
    let mut bus = busy();
    bus.node.reset(bus.now);
    bus.drain();
    has_lost_everything(&bus);
    assert_eq!(bus.node.access().state().kind(), StateKind::DetectingBitRate);
    let mut bus = busy();
    bus.node.set_address(bus.now, crate::OperationalAddress::MIN);
    bus.drain();
    has_lost_everything(&bus);
    bus.wait(2000);
    assert_eq!(bus.node.access().address().number(), 0);
}

#[test]
fn what_is_with_the_controller_is_withdrawn() {
    let mut bus = busy();
    bus.stuck = true;
    // Data, a response, an answer, a fragment of another.
    bus.wait(100);
    bus.hears(0x1086_0205, &[0x0E, 3, 1, 1]);
    bus.hears(0x1C86_0405, &[0x0E, 3, 1, 1]);
    bus.hears(0x1C86_0605, &[0x0E, 1, 1, 7]);
    assert_eq!(bus.held.len(), 4);
    bus.hears(0x1F87_0001, &[0, 0, 1, 0, 1, 0, 1, 0]);
    let left: Vec<_> = bus.held.iter().map(|(_, frame)| frame.to_string()).collect();
    assert_eq!(left, ["1FFE4433 [8] 22 11 E7 03 2A 00 01 00"]);
    assert_eq!(bus.node.counters().not_sent, 0);
}

/// A frame of a connection that has ended since is nobody's; the place may have another connection.
#[test]
fn the_frame_of_an_earlier_connection() {
    let mut bus = Bus::explicit();
    bus.connects(&[0x4B, 0xC0, 7, 0, 100, 0, 0], &[0x4B, 0xC0, 0, 100, 0]);
    bus.forget();
    bus.stuck = true;
    bus.wait(100);
    assert_eq!(bus.held.len(), 1);
    bus.stuck = false;
    let (token, _) = bus.held[0];
    bus.hears(0x1D86_0209, &[0x4B, 0xC1, 7, 0, 50, 0, 0]);
    assert!(bus.held.is_empty(), "withdrawn");
    bus.sends_besides(0x0186_0007, &[0x34, 0x12]);
    assert_eq!(bus.node.counters().stray_tx_done, 0);
    bus.input(Input::TxDone(token, TxOutcome::Sent));
    bus.input(Input::TxDone(TxToken(1), TxOutcome::Sent));
    bus.input(Input::TxDone(TxToken(2), TxOutcome::Sent));
    bus.input(Input::TxDone(TxToken(999), TxOutcome::Sent));
    assert_eq!(bus.node.counters().stray_tx_done, 4);
}

/// Hello of the address, everything to it, and what connections consume.
#[test]
fn the_filter_follows_the_connections() {
    let passes = |bus: &Bus, id: u32| bus.filter.as_ref().unwrap().accepts(&frame(id, &[]));
    let mut bus = Bus::explicit();
    for id in [0x1F87_0000, 0x1C86_0205, 0x1D86_0205, 0x1086_0205, 0x1786_FFFF] {
        assert!(passes(&bus, id), "{id:08X}");
    }
    for id in [0x1EFE_0000, 0x1C88_0205, 0x0002_0007, 0x0086_0000, 0x105, 0x1FFE_0001] {
        assert!(!passes(&bus, id), "{id:08X}");
    }
    bus.connects(&[0x4B, 0xC0, 13, 0, 0, 0, 0], &[0x4B, 0xC0, 0, 0, 0]);
    bus.connects(&[0x4B, 0x82, 12, 0, 0, 0, 0], &[0x4B, 0x82, 0, 0, 0]);
    assert!(passes(&bus, 0x0002_0007) && passes(&bus, 0x101));
    bus.asks(&[0x10, 5, 13, 5, 7, 0, 0x0A, 0x80], &[0x90]);
    assert!(passes(&bus, 0x000A_0007) && !passes(&bus, 0x0002_0007));
    bus.asks(&[0x09, 5, 13], &[0x89]);
    assert!(!passes(&bus, 0x000A_0007) && passes(&bus, 0x101));
    assert_eq!(
        bus.filter.as_ref().map(|filter| filter.as_slice().contains(&Filter::ALL_STANDARD)),
        Some(false)
    );
    bus.asks(&[0x10, 3, 1, 1, 68], &[0x90]);
    assert!(!passes(&bus, 0x1086_0205) && passes(&bus, 0x1F88_0000));
    bus.wait(2000);
    assert!(passes(&bus, 0x1088_0205) && !passes(&bus, 0x101));
}

#[test]
fn the_frame_of_the_highest_priority_goes_first() {
    let mut bus = busy();
    bus.stuck = true;
    bus.node.inputs_changed(bus.now);
    bus.node.input(bus.now, Input::Frame(frame(0x1C86_0405, &[0x0E, 3, 1, 1])));
    bus.node.input(bus.now, Input::Frame(frame(0x1086_0205, &[0x0E, 3, 1, 1])));
    bus.drain();
    let ids: Vec<_> = bus.held.iter().map(|(_, frame)| frame.arbitration_key()).collect();
    assert_eq!(ids.len(), 3);
    assert!(ids.is_sorted(), "{:?}", bus.held);
}

/// What is not fetched stays, and the deadline says so.
#[test]
fn nothing_is_lost_if_nobody_fetches_it() {
    let mut bus = busy();
    for request in [[0x4B, 0xC0, 13, 0, 0, 0, 0], [0x4B, 0xC0, 7, 0, 0, 0, 0], [0x4B, 0xC0, 9, 0, 0, 0, 0]] {
        bus.node.input(bus.now, Input::Frame(frame(0x1D86_0209, &request)));
        assert_eq!(bus.node.deadline().map(|deadline| deadline.at), Some(bus.now));
    }
    bus.drain();
    assert_eq!(bus.events.len(), 3);
    assert_eq!(bus.node.counters().events_lost, 0);
    // Nine frames that are ignored are one more than there is room for.
    for _ in 0..9 {
        bus.node.input(bus.now, Input::Frame(frame(0x1D86_FE09, &[])));
    }
    assert_eq!(bus.node.counters().events_lost, 1);
}
