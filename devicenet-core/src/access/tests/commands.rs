//! Commands, and what the machine is.

use core::time::Duration;
use std::string::ToString;

use link_core::{Instant, Machine, TxOutcome};

use super::super::{Access, CommandError, CounterSetMode, MacIdSource, StateKind};
use super::bus::*;

#[test]
fn setting_the_mac_id_starts_anew_with_the_new_one() {
    let mut bus = Bus::online(config());
    assert_eq!(bus.command(|node, now| node.set_mac_id(now, mac(5))), Ok(()));
    bus.sends(0x42F, &REQUEST);
    assert_eq!(bus.listens_to(), [0x42F]);
    bus.hears(CHECK, &TWIN_REQUEST);
    bus.is(StateKind::SendingDupMac);
}

/// The request for the old MAC ID is withdrawn; that it was sent all the same does not count for the new one.
#[test]
fn setting_the_mac_id_while_checking_withdraws_the_request() {
    let mut bus = Bus::power_up(config());
    bus.sends(CHECK, &REQUEST);
    bus.command(|node, now| node.set_mac_id(now, mac(5))).unwrap();
    bus.withdraws();
    bus.sends_nothing();
    bus.done(TxOutcome::Sent);
    bus.is(StateKind::SendingDupMac);
    bus.sends(0x42F, &REQUEST);
}

#[test]
fn setting_the_same_mac_id_restarts_unless_configured_otherwise() {
    let mut bus = Bus::online(config());
    bus.command(|node, now| node.set_mac_id(now, mac(37))).unwrap();
    bus.is(StateKind::SendingDupMac);

    let mut lazy = config();
    lazy.same_mac_id_restarts = false;
    let mut bus = Bus::online(lazy);
    bus.command(|node, now| node.set_mac_id(now, mac(37))).unwrap();
    bus.is(StateKind::OnLine);
}

#[test]
fn a_mac_id_from_switches_cannot_be_set() {
    let mut switches = config();
    switches.mac_id_source = MacIdSource::Switches;
    let mut bus = Bus::online(switches);
    let refused = bus.command(|node, now| node.set_mac_id(now, mac(5))).unwrap_err();
    assert_eq!(refused, CommandError::MacIdFromSwitches);
    assert_eq!(
        refused.to_string(),
        "the MAC ID comes from switches: turn them, then call reset_with_switches"
    );
    bus.is(StateKind::OnLine);
}

#[test]
fn a_node_without_power_takes_commands_and_waits() {
    let mut bus = Bus::dark(config());
    bus.command(|node, now| node.set_mac_id(now, mac(5))).unwrap();
    bus.command(Access::reset);
    bus.is(StateKind::NonExistent);
    bus.sends_nothing();
    bus.link(link_core::LinkEvent::Up);
    bus.sends(0x42F, &REQUEST);
}

#[test]
fn the_bus_off_counter_is_cleared_by_writing_it() {
    let mut node = Access::new(config());
    assert_eq!(node.set_bus_off_counter(7), Ok(()));
    let mut strict = config();
    strict.counter_set_mode = CounterSetMode::OnlyZero;
    let mut node = Access::new(strict);
    assert_eq!(node.set_bus_off_counter(7), Err(CommandError::CounterNotZero(7)));
    assert_eq!(node.set_bus_off_counter(0), Ok(()));
}

#[test]
fn a_reset_restores_boi() {
    let mut bus = Bus::online(config());
    bus.command(|node, _| node.set_bus_off_interrupt(true));
    bus.command(Access::reset);
    assert!(!bus.node.bus_off_interrupt());
}

/// Output that nobody fetched stays, and the deadline says so.
#[test]
fn pending_output_is_a_deadline() {
    let mut node = Access::new(config());
    node.input(Instant::from_millis(5), link_core::Input::Link(link_core::LinkEvent::Up));
    assert_eq!(node.deadline().unwrap().at, Instant::from_millis(5));
    drop(node.handle(Instant::from_millis(6), link_core::Input::Tick));
    assert_eq!(node.deadline().unwrap().at, Instant::from_millis(6));
}

/// Events that nobody fetches are dropped and counted; the state is right all the same.
#[test]
fn a_full_event_store_loses_events_and_counts_them() {
    let mut bus = Bus::online(config());
    for _ in 0..20 {
        let frame = link_core::Frame::new(link_core::frame::standard_id(CHECK), &TWIN_REQUEST).unwrap();
        bus.node.input(bus.now, link_core::Input::Frame(frame));
    }
    assert_eq!(bus.node.counters().events_lost, 15);
    assert_eq!(bus.node.counters().challenges, 20);
}

#[test]
fn histories_of_different_age_are_equal_after_a_shift() {
    let young = Bus::online(config());
    let mut old = Bus::dark(config());
    old.wait(5000);
    old.link(link_core::LinkEvent::Up);
    for _ in 0..2 {
        old.acknowledges();
        old.wait(1000);
    }
    assert_ne!(young.node, old.node);
    old.node.shift_time(Duration::from_secs(5));
    assert_eq!(young.node, old.node);
}

#[test]
fn one_frame_in_flight_at_most() {
    assert_eq!(Access::new(config()).max_in_flight(), 1);
}

/// A change shows here first. Half of it is the store of five events.
#[test]
#[cfg(target_pointer_width = "64")]
fn the_size_of_the_machine() {
    assert_eq!(size_of::<Access>(), 160);
}
