//! A duplicate MAC ID: how it is found, what follows, and the ways out.

use link_core::{LinkEvent, Machine, TxOutcome};

use super::super::{Access, AccessEvent, Fault, NetworkStatus, StateKind};
use super::bus::*;
use crate::message::{Direction, DuplicateMacCheck, Wire};

/// Duplicate MAC ID summary, 1a.
#[test]
fn a_request_or_response_in_either_wait_faults() {
    for second in [false, true] {
        for (twin, direction) in [(TWIN_REQUEST, Direction::Request), (TWIN_RESPONSE, Direction::Response)] {
            let mut bus = Bus::waiting(config());
            if second {
                bus.wait(1000);
                bus.sends(CHECK, &REQUEST);
                bus.acknowledges();
            }
            bus.wait(500);
            bus.hears(CHECK, &twin);
            assert_eq!(bus.node.fault(), Some(Fault::DuplicateMacId));
            assert_eq!(bus.node.network_status(), NetworkStatus::SolidRed);
            let other = DuplicateMacCheck::parse(&twin).ok();
            bus.tells(AccessEvent::Duplicate { direction, other });
            bus.sends_nothing();
        }
    }
}

/// Two twins that start together both fall silent. That is intended.
#[test]
fn a_request_while_the_own_one_is_queued_faults_and_withdraws_it() {
    let mut bus = Bus::power_up(config());
    bus.sends(CHECK, &REQUEST);
    bus.hears(CHECK, &TWIN_REQUEST);
    bus.is(StateKind::CommFault);
    bus.withdraws();
    bus.done(TxOutcome::Withdrawn);
    bus.wait(10_000);
    bus.sends_nothing();
}

/// The withdrawal came too late: the request went out, and changes nothing any more.
#[test]
fn a_request_sent_in_spite_of_its_withdrawal_does_not_start_the_wait() {
    let mut bus = Bus::power_up(config());
    bus.sends(CHECK, &REQUEST);
    bus.hears(CHECK, &TWIN_REQUEST);
    bus.withdraws();
    bus.done(TxOutcome::Sent);
    bus.is(StateKind::CommFault);
    assert_eq!(bus.node.deadline(), None);
}

#[test]
fn a_faulted_node_is_silent() {
    let mut silent = config();
    silent.offline_set = false;
    for config in [config(), silent] {
        let mut bus = Bus::faulted(config);
        for _ in 0..100 {
            bus.hears(CHECK, &TWIN_REQUEST);
            bus.hears(CHECK, &TWIN_RESPONSE);
            bus.hears(0x52E, &[0x0A, 0x4B, 0x03, 0x01, 0x03, 0x0A]);
            bus.hears(0x52C, &[0x0A, 0x0E, 0x01, 0x01, 0x01]);
            bus.hears(0x52D, &[0x00]);
            bus.hears(0x7EF, &[0x01, 0x4B, 0x34, 0x12, 0x01, 0x00, 0x00, 0x00]);
            bus.wait(1000);
        }
        bus.is(StateKind::CommFault);
        bus.sends_nothing();
        assert_eq!(bus.events, []);
        assert_eq!(bus.node.counters().discarded, 600);
    }
}

/// Duplicate MAC ID summary, 2b: two segments are powered up and then joined.
#[test]
fn a_response_on_line_faults() {
    let mut bus = Bus::online(config());
    bus.hears(CHECK, &TWIN_RESPONSE);
    assert_eq!(bus.node.fault(), Some(Fault::DuplicateMacId));
    bus.wait(10_000);
    bus.sends_nothing();
}

#[test]
fn an_answer_in_flight_is_withdrawn_by_the_fault() {
    let mut bus = Bus::online(config());
    bus.hears(CHECK, &TWIN_REQUEST);
    bus.sends(CHECK, &RESPONSE);
    bus.hears(CHECK, &TWIN_RESPONSE);
    bus.withdraws();
    bus.done(TxOutcome::Withdrawn);
    bus.sends_nothing();
    assert_eq!(bus.node.counters().responses, 0);
}

/// Somebody sends on this node's identifier, whatever the length.
#[test]
fn a_check_of_a_wrong_length_counts_as_a_duplicate() {
    for data in [&[][..], &[0x00], &TWIN_REQUEST[..6], &[0, 1, 2, 3, 4, 5, 6, 7]] {
        let mut bus = Bus::waiting(config());
        bus.hears(CHECK, data);
        bus.is(StateKind::CommFault);
        bus.tells(AccessEvent::Duplicate { direction: Direction::Request, other: None });
        assert_eq!(bus.node.counters().bad_frames, 1);
        let error = bus.events.iter().find_map(AccessEvent::error).unwrap();
        assert_eq!(Err(error), DuplicateMacCheck::parse(data), "the event says what is wrong");

        let mut bus = Bus::online(config());
        bus.hears(CHECK, data);
        bus.sends(CHECK, &RESPONSE);
    }
    let mut bus = Bus::online(config());
    bus.hears(CHECK, &[0x80]);
    bus.is(StateKind::CommFault);
}

#[test]
fn a_check_of_a_wrong_length_can_be_ignored() {
    let mut strict = config();
    strict.accept_bad_dlc = false;
    for make in [Bus::waiting, Bus::online] {
        let mut bus = make(strict.clone());
        let before = bus.node.state();
        bus.hears(CHECK, &TWIN_RESPONSE[..6]);
        assert_eq!(bus.node.state(), before);
        assert_eq!(bus.node.counters().bad_frames, 1);
    }
}

/// The first way out: manual intervention.
#[test]
fn a_reset_leads_out_of_the_fault() {
    let mut bus = Bus::faulted(config());
    bus.command(Access::reset);
    bus.sends(CHECK, &REQUEST);
    bus.acknowledges();
    bus.is(StateKind::WaitingDupMac);
}

#[test]
fn turned_switches_and_a_reset_lead_out_of_the_fault() {
    let mut bus = Bus::faulted(config());
    bus.command(|node, now| node.reset_with_switches(now, mac(5)));
    bus.sends(0x42F, &REQUEST);
    assert_eq!(bus.listens_to(), [0x42F]);
}

#[test]
fn a_power_cycle_leads_out_of_the_fault() {
    let mut bus = Bus::faulted(config());
    bus.link(LinkEvent::Down);
    assert_eq!(bus.node.network_status(), NetworkStatus::Off);
    bus.link(LinkEvent::Up);
    bus.sends(CHECK, &REQUEST);
}

/// The second way out: the offline connection set.
#[test]
fn a_mac_id_from_the_offline_connection_set_leads_out_of_the_fault() {
    let mut bus = Bus::faulted(config());
    bus.hears(0x7ED, &[0x05, 0x4D, 0x34, 0x12, 0x45, 0x23, 0x00, 0x00]);
    bus.tells(AccessEvent::MacIdAssigned { from: mac(37), to: mac(5) });
    bus.sends(0x42F, &REQUEST);
    bus.acknowledges();
    bus.wait(1000);
    bus.sends(0x42F, &REQUEST);
    bus.acknowledges();
    bus.wait(1000);
    bus.is(StateKind::OnLine);
}

/// "Possibly to the same value".
#[test]
fn the_same_mac_id_assigned_again_leads_out_too() {
    let mut bus = Bus::faulted(config());
    bus.hears(0x7ED, &[37, 0x4D, 0x34, 0x12, 0x45, 0x23, 0x00, 0x00]);
    bus.sends(CHECK, &REQUEST);
}

#[test]
fn there_is_no_third_way_out() {
    let mut bus = Bus::faulted(config());
    bus.wait(1_000_000);
    bus.link(LinkEvent::Up);
    bus.link(LinkEvent::ErrorActive);
    bus.command(|node, _| node.set_bus_off_interrupt(true));
    bus.is(StateKind::CommFault);
    bus.sends_nothing();
}
