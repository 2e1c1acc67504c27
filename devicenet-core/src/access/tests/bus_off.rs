//! Bus-off, BOI, and the bus-off counter.

use link_core::{LinkEvent, TxOutcome, link::LinkCommandKind};

use super::super::{Access, AccessEvent, BusOffWhileChecking, Config, Fault, NetworkStatus, StateKind};
use super::bus::*;

fn restarting() -> Config {
    let mut config = config();
    config.bus_off_interrupt = true;
    config
}

#[test]
fn without_boi_the_controller_is_held_off_the_bus() {
    let mut bus = Bus::online(config());
    bus.controller_restarts();
    bus.link(LinkEvent::BusOff);
    assert_eq!(bus.node.fault(), Some(Fault::BusOff));
    assert_eq!(bus.node.network_status(), NetworkStatus::SolidRed);
    assert_eq!(bus.node.bus_off_counter(), 1);
    bus.wait(100_000);
    bus.link(LinkEvent::Up);
    bus.hears(0x7ED, &[37, 0x4D, 0x34, 0x12, 0x45, 0x23, 0x00, 0x00]);
    bus.is(StateKind::CommFault);
    bus.sends_nothing();
    assert_eq!(bus.controller_restarts(), 0);
}

#[test]
fn with_boi_the_controller_is_restarted_after_the_back_off_and_the_check_begins_anew() {
    let mut bus = Bus::online(restarting());
    bus.controller_restarts();
    bus.link(LinkEvent::BusOff);
    bus.is(StateKind::SendingDupMac);
    bus.wait(99);
    assert_eq!(bus.controller_restarts(), 0);
    bus.wait(1);
    assert_eq!(bus.controller_restarts(), 1);
    bus.wait(1000);
    bus.sends_nothing();
    bus.link(LinkEvent::Up);
    bus.sends(CHECK, &REQUEST);
    bus.acknowledges();
    bus.wait(1000);
    bus.sends(CHECK, &REQUEST);
    bus.acknowledges();
    bus.wait(1000);
    bus.is(StateKind::OnLine);
    assert_eq!(bus.node.bus_off_counter(), 1);
}

/// The restart timer of a driver, for example.
#[test]
fn a_controller_that_comes_back_by_itself_does_not_shorten_the_back_off() {
    let mut bus = Bus::online(restarting());
    bus.controller_restarts();
    bus.link(LinkEvent::BusOff);
    bus.wait(50);
    bus.link(LinkEvent::Up);
    bus.sends_nothing();
    bus.wait(50);
    assert_eq!(bus.controller_restarts(), 1);
    bus.link(LinkEvent::Up);
    bus.sends(CHECK, &REQUEST);
}

#[test]
fn what_was_in_flight_at_bus_off_is_dropped_by_the_controller() {
    for dropped_first in [false, true] {
        let mut bus = Bus::online(restarting());
        bus.hears(CHECK, &TWIN_REQUEST);
        bus.sends(CHECK, &RESPONSE);
        if dropped_first {
            bus.done(TxOutcome::Dropped);
        }
        bus.link(LinkEvent::BusOff);
        bus.withdraws_nothing();
        if !dropped_first {
            bus.done(TxOutcome::Dropped);
        }
        bus.wait(100);
        bus.link(LinkEvent::Up);
        bus.sends(CHECK, &REQUEST);
    }
}

/// The receive queue of a driver may still hold what was received before bus-off. To be faulted by it, as by a duplicate,
/// would hide from a later reset that the controller is off the bus.
#[test]
fn frames_delivered_after_bus_off_change_nothing() {
    for twin in [TWIN_REQUEST, TWIN_RESPONSE] {
        let mut bus = Bus::online(restarting());
        bus.controller_restarts();
        bus.link(LinkEvent::BusOff);
        bus.hears(CHECK, &twin);
        bus.is(StateKind::SendingDupMac);
        bus.wait(100);
        assert_eq!(bus.controller_restarts(), 1);
        bus.hears(CHECK, &twin);
        bus.is(StateKind::SendingDupMac);
        assert_eq!(bus.node.counters().discarded, 2);

        bus.link(LinkEvent::Up);
        bus.hears(CHECK, &twin);
        assert_eq!(bus.node.fault(), Some(Fault::DuplicateMacId), "back on the bus it counts");
    }
}

/// Row 7 of the table knows no BOI.
#[test]
fn bus_off_while_checking_faults_whatever_boi_says() {
    for make in [Bus::power_up, Bus::waiting] {
        let mut bus = make(restarting());
        bus.link(LinkEvent::BusOff);
        assert_eq!(bus.node.fault(), Some(Fault::BusOff));
    }
}

#[test]
fn bus_off_while_checking_can_follow_boi() {
    let mut config = restarting();
    config.bus_off_while_checking = BusOffWhileChecking::FollowInterrupt;
    let mut bus = Bus::waiting(config);
    bus.link(LinkEvent::BusOff);
    bus.is(StateKind::SendingDupMac);
    bus.wait(100);
    bus.link(LinkEvent::Up);
    bus.sends(CHECK, &REQUEST);
}

#[test]
fn the_counter_stays_at_255() {
    let mut bus = Bus::online(restarting());
    for _ in 0..300 {
        bus.link(LinkEvent::BusOff);
        bus.link(LinkEvent::BusOff);
        bus.wait(100);
        bus.link(LinkEvent::Up);
        bus.sends(CHECK, &REQUEST);
        bus.acknowledges();
        bus.wait(1000);
        bus.sends(CHECK, &REQUEST);
        bus.acknowledges();
        bus.wait(1000);
    }
    assert_eq!(bus.node.bus_off_counter(), 255);
    bus.command(|node, _| node.clear_bus_off_counter());
    assert_eq!(bus.node.bus_off_counter(), 0);
}

#[test]
fn a_bus_off_told_twice_counts_once() {
    let mut bus = Bus::online(config());
    bus.link(LinkEvent::BusOff);
    bus.link(LinkEvent::BusOff);
    assert_eq!(bus.node.bus_off_counter(), 1);
}

#[test]
fn a_reset_leads_out_of_bus_off_by_restarting_the_controller() {
    let mut bus = Bus::online(config());
    bus.link(LinkEvent::BusOff);
    bus.controller_restarts();
    bus.command(Access::reset);
    bus.is(StateKind::SendingDupMac);
    assert_eq!(bus.controller_restarts(), 1);
    bus.sends_nothing();
    bus.link(LinkEvent::Up);
    bus.sends(CHECK, &REQUEST);
    assert_eq!(bus.node.bus_off_counter(), 0, "as after power-up");
}

#[test]
fn a_refused_restart_is_a_fault_and_not_an_endless_wait() {
    let mut bus = Bus::online(restarting());
    bus.link(LinkEvent::BusOff);
    bus.wait(100);
    bus.link(LinkEvent::Refused(LinkCommandKind::Reset));
    assert_eq!(bus.node.fault(), Some(Fault::BusOff));
    bus.tells(AccessEvent::LinkRefused(LinkCommandKind::Reset));
    assert_eq!(bus.node.counters().refused, 1);
}

#[test]
fn a_refused_filter_or_mode_is_only_reported() {
    for kind in [LinkCommandKind::SetFilter, LinkCommandKind::SetMode] {
        let mut bus = Bus::waiting(config());
        bus.link(LinkEvent::Refused(kind));
        bus.tells(AccessEvent::LinkRefused(kind));
        bus.is(StateKind::WaitingDupMac);

        let mut bus = Bus::online(restarting());
        bus.link(LinkEvent::BusOff);
        bus.wait(100);
        bus.link(LinkEvent::Refused(kind));
        bus.is(StateKind::SendingDupMac);
    }
}

/// Neither a new MAC ID nor the loss of network power is a power cycle of the device.
#[test]
fn the_counter_outlives_everything_but_a_reset() {
    let mut bus = Bus::online(restarting());
    bus.link(LinkEvent::BusOff);
    bus.wait(100);
    bus.link(LinkEvent::Up);
    bus.command(|node, now| node.set_mac_id(now, mac(5))).unwrap();
    bus.hears(0x42F, &TWIN_RESPONSE);
    bus.hears(0x7ED, &[0x06, 0x4D, 0x34, 0x12, 0x45, 0x23, 0x00, 0x00]);
    assert_eq!(bus.node.mac_id(), mac(6));
    bus.link(LinkEvent::Down);
    bus.link(LinkEvent::Up);
    assert_eq!(bus.node.bus_off_counter(), 1);
    bus.command(Access::reset);
    assert_eq!(bus.node.bus_off_counter(), 0);
}

#[test]
fn a_node_faulted_by_a_duplicate_that_goes_off_the_bus_stays_faulted() {
    let mut bus = Bus::faulted(restarting());
    bus.link(LinkEvent::BusOff);
    assert_eq!(bus.node.fault(), Some(Fault::BusOff));
    bus.hears(0x7ED, &[37, 0x4D, 0x34, 0x12, 0x45, 0x23, 0x00, 0x00]);
    bus.is(StateKind::CommFault);
}
