//! Races: a frame that cannot be taken back, and what happens while it is in flight.

use core::time::Duration;

use link_core::{LinkEvent, Machine, TxOutcome};

use super::super::{Access, AccessEvent, Config, Fault, StateKind};
use super::bus::*;

fn quick() -> Config {
    let mut config = config();
    config.quick_connect = true;
    config
}

/// A port without a way to withdraw, on a bus where nobody acknowledges for an hour.
#[test]
fn a_request_for_the_old_mac_id_that_goes_out_an_hour_late_says_nothing_about_the_new_one() {
    let mut bus = Bus::power_up(config());
    bus.sends(CHECK, &REQUEST);
    bus.command(|node, now| node.set_mac_id(now, mac(5))).unwrap();
    bus.withdraws();
    assert_eq!(bus.listens_to(), [0x42F]);
    bus.wait(3_600_000);
    bus.sends_nothing();

    bus.done(TxOutcome::Sent);
    bus.sends(0x42F, &REQUEST);
    // Who owns the old MAC ID defends it.
    bus.hears(CHECK, &TWIN_RESPONSE);
    bus.is(StateKind::SendingDupMac);
    bus.acknowledges();
    bus.wait(999);
    bus.is(StateKind::WaitingDupMac);
    bus.wait(1);
    bus.sends(0x42F, &REQUEST);
}

#[test]
fn the_same_mac_id_again_does_not_count_the_request_from_before() {
    let mut bus = Bus::power_up(config());
    bus.sends(CHECK, &REQUEST);
    bus.command(Access::reset);
    bus.withdraws();
    bus.done(TxOutcome::Sent);
    bus.is(StateKind::SendingDupMac);
    bus.sends(CHECK, &REQUEST);
    // And its answer, which comes late, still means that somebody has the MAC ID.
    bus.hears(CHECK, &TWIN_RESPONSE);
    assert_eq!(bus.node.fault(), Some(Fault::DuplicateMacId));
}

#[test]
fn a_mac_id_set_on_line_withdraws_the_defence_of_the_old_one() {
    for outcome in [TxOutcome::Withdrawn, TxOutcome::Sent, TxOutcome::Dropped] {
        let mut bus = Bus::online(config());
        bus.hears(CHECK, &TWIN_REQUEST);
        bus.sends(CHECK, &RESPONSE);
        bus.hears(CHECK, &TWIN_REQUEST);
        bus.command(|node, now| node.set_mac_id(now, mac(5))).unwrap();
        bus.withdraws();
        bus.sends_nothing();
        bus.done(outcome);
        bus.sends(0x42F, &REQUEST);
        bus.acknowledges();
        bus.sends_nothing();
        assert_eq!((bus.node.counters().responses, bus.node.counters().not_sent), (0, 0));
    }
}

/// A withdrawal that was not asked for yet is not asked for any more when the answer comes first.
#[test]
fn an_answer_that_comes_before_the_withdrawal_makes_it_needless() {
    let mut bus = Bus::power_up(config());
    bus.sends(CHECK, &REQUEST);
    bus.node.reset(bus.now);
    bus.done(TxOutcome::Sent);
    bus.withdraws_nothing();
    bus.sends(CHECK, &REQUEST);
}

#[test]
fn power_lost_while_an_answer_is_in_flight_leaves_nothing_behind() {
    let defending = || {
        let mut bus = Bus::online(config());
        bus.hears(CHECK, &TWIN_REQUEST);
        bus.sends(CHECK, &RESPONSE);
        bus.hears(CHECK, &TWIN_REQUEST);
        bus
    };
    let answering = || {
        let mut bus = Bus::faulted(config());
        bus.hears(0x7ED, &[0x3F, 0x4C]);
        bus.sends(0x7EC, &[0x3F, 0xCC]);
        bus.hears(0x7ED, &[0x3F, 0x4B, 0x00]);
        bus
    };
    let withdrawing = || {
        let mut bus = Bus::power_up(config());
        bus.sends(CHECK, &REQUEST);
        bus.hears(CHECK, &TWIN_REQUEST);
        bus.withdraws();
        bus
    };
    for make in [defending, answering, withdrawing] {
        for outcome in [TxOutcome::Dropped, TxOutcome::Sent] {
            let mut bus = make();
            bus.link(LinkEvent::Down);
            bus.link(LinkEvent::Up);
            bus.withdraws_nothing();
            bus.sends_nothing();
            bus.done(outcome);
            bus.sends(CHECK, &REQUEST);
            bus.acknowledges();
            bus.sends_nothing();
            bus.is(StateKind::WaitingDupMac);
        }
    }
}

#[test]
fn a_delayed_who_response_dies_with_the_fault() {
    let mut bus = Bus::faulted(config());
    bus.hears(0x7ED, &[0x3F, 0x4B, 0x03]);
    bus.wait(100);
    bus.hears(0x7ED, &[0x05, 0x4D, 0x34, 0x12, 0x45, 0x23, 0x00, 0x00]);
    bus.sends(0x42F, &REQUEST);
    bus.acknowledges();
    bus.hears(0x42F, &TWIN_RESPONSE);
    bus.is(StateKind::CommFault);
    bus.wait(10_000);
    bus.sends_nothing();
}

/// One nanosecond before the end, and at the end.
#[test]
fn a_duplicate_at_the_very_end_of_the_second_wait_keeps_the_node_off_line() {
    for early in [1, 0] {
        let mut bus = Bus::waiting(config());
        bus.wait(1000);
        bus.sends(CHECK, &REQUEST);
        bus.acknowledges();
        bus.now += Duration::from_nanos(1_000_000_000 - early);
        bus.hears(CHECK, &TWIN_REQUEST);
        assert_eq!(bus.node.fault(), Some(Fault::DuplicateMacId));
        assert!(
            !bus.events
                .iter()
                .any(|event| matches!(event, AccessEvent::StateChanged { to: StateKind::OnLine, .. }))
        );
        bus.wait(10_000);
        bus.sends_nothing();
    }
}

/// The clock of a port jumps back: the wait is not cut short, and the frame counts.
#[test]
fn a_duplicate_told_with_an_older_time_still_counts() {
    let mut bus = Bus::waiting(config());
    bus.wait(900);
    bus.input(link_core::Input::Tick);
    bus.now = link_core::Instant::ZERO;
    bus.hears(CHECK, &TWIN_RESPONSE);
    assert_eq!(bus.node.fault(), Some(Fault::DuplicateMacId));
    assert_eq!(bus.node.deadline(), None);
}

#[test]
fn quick_connect_defends_the_mac_id_after_the_second_request_that_is_in_flight() {
    let mut bus = Bus::power_up(quick());
    bus.sends(CHECK, &REQUEST);
    bus.acknowledges();
    bus.wait(1000);
    bus.sends(CHECK, &REQUEST);
    bus.hears(CHECK, &TWIN_REQUEST);
    bus.sends_nothing();
    bus.withdraws_nothing();
    bus.acknowledges();
    bus.sends(CHECK, &RESPONSE);
    bus.acknowledges();
    bus.wait(10_000);
    bus.sends_nothing();
    bus.is(StateKind::OnLine);
}

#[test]
fn quick_connect_gives_up_while_its_second_request_is_in_flight() {
    let mut bus = Bus::power_up(quick());
    bus.sends(CHECK, &REQUEST);
    bus.acknowledges();
    bus.wait(1000);
    bus.sends(CHECK, &REQUEST);
    bus.hears(CHECK, &TWIN_RESPONSE);
    bus.withdraws();
    bus.done(TxOutcome::Sent);
    assert_eq!(bus.node.fault(), Some(Fault::DuplicateMacId));
    assert_eq!(bus.node.deadline(), None);
}
