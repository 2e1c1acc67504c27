//! The controller leaves the bus.

use link_core::link::LinkCommandKind;
use link_core::{BitRate, LinkEvent, TxOutcome};

use super::super::{Access, Fault, StateKind};
use super::bus::*;

fn with_interrupt() -> super::super::Config {
    let mut config = config();
    config.bus_off_interrupt = true;
    config
}

#[test]
fn without_boi_the_node_stays_off_the_bus() {
    let mut bus = Bus::online(config());
    bus.link(LinkEvent::BusOff);
    bus.is(StateKind::BusOff);
    bus.wait(1_000_000);
    bus.request(HIGHER, 67);
    bus.link(LinkEvent::Up);
    bus.link(LinkEvent::BusOff);
    bus.is(StateKind::BusOff);
    bus.sends_nothing();
    assert_eq!((bus.controller_restarts(), bus.node.bus_off_counter()), (0, 1));
}

/// It detects the bit rate again: a wrong one may have been the cause.
#[test]
fn with_boi_it_comes_back_once_with_its_address() {
    let mut bus = Bus::online(with_interrupt());
    bus.link(LinkEvent::BusOff);
    bus.wait(99);
    assert_eq!(bus.controller_restarts(), 0);
    bus.wait(1);
    assert_eq!(bus.controller_restarts(), 1);
    bus.link(LinkEvent::Up);
    bus.sets_mode(listen_only(BitRate::K500));
    bus.hears_any();
    bus.hears_any();
    bus.sets_mode(active(BitRate::K500));
    bus.says_both(HELLO_67);
    bus.is(StateKind::Online);
    bus.link(LinkEvent::BusOff);
    bus.wait(1_000_000);
    assert_eq!((bus.controller_restarts(), bus.node.bus_off_counter()), (0, 2));
    bus.is(StateKind::BusOff);
}

#[test]
fn what_was_with_the_controller_is_dropped_by_it() {
    let mut bus = Bus::online(config());
    bus.request(HIGHER, 67);
    bus.sends(RESPONSE_67);
    bus.link(LinkEvent::BusOff);
    bus.done(TxOutcome::Dropped);
    assert_eq!(bus.node.counters().not_sent, 0);
}

#[test]
fn a_reset_leads_out_of_it_by_way_of_the_controller() {
    let mut bus = Bus::online(config());
    bus.link(LinkEvent::BusOff);
    bus.command(Access::reset);
    assert_eq!(bus.controller_restarts(), 1);
    bus.is(StateKind::BusOff);
    bus.link(LinkEvent::Up);
    bus.is(StateKind::DetectingBitRate);
    assert!(bus.node.address().is_none());
    assert_eq!(bus.node.bus_off_counter(), 0);
}

#[test]
fn a_controller_that_does_not_restart_faults_the_node() {
    let mut bus = Bus::online(with_interrupt());
    bus.link(LinkEvent::BusOff);
    bus.wait(100);
    bus.link(LinkEvent::Refused(LinkCommandKind::Reset));
    assert_eq!(bus.node.fault(), Some(Fault::Restart));
    bus.link(LinkEvent::BusOff);
    assert_eq!(bus.node.fault(), Some(Fault::Restart));
    bus.controller_restarts();
    bus.command(Access::reset);
    assert_eq!(bus.controller_restarts(), 1);
}

/// Cut off, replaced, plugged in again: it asks for its old address (paper 1-8).
#[test]
fn after_the_loss_of_the_link_it_asks_for_its_old_address() {
    let mut bus = Bus::online(config());
    bus.link(LinkEvent::Down);
    bus.is(StateKind::NonExistent);
    bus.link(LinkEvent::Up);
    bus.sets_mode(listen_only(BitRate::K500));
    bus.hears_any();
    bus.hears_any();
    bus.sets_mode(active(BitRate::K500));
    bus.sends(HELLO_67);

    let mut forgetful = config();
    forgetful.keep_address = false;
    let mut bus = Bus::online(forgetful);
    bus.link(LinkEvent::Down);
    assert!(bus.node.address().is_none());
}
