//! Defending the MAC ID.

use link_core::{LinkEvent, Machine, TxOutcome};

use super::super::{AccessEvent, NetworkStatus, Outgoing, StateKind};
use super::bus::*;
use crate::message::{DuplicateMacCheck, Wire};

/// Duplicate MAC ID summary, 2a.
#[test]
fn every_request_is_answered_by_one_response() {
    let mut bus = Bus::online(config());
    for _ in 0..5 {
        bus.hears(CHECK, &TWIN_REQUEST);
        bus.sends(CHECK, &RESPONSE);
        bus.acknowledges();
        bus.sends_nothing();
        bus.wait(1000);
    }
    bus.is(StateKind::OnLine);
    bus.tells(AccessEvent::Challenged { other: DuplicateMacCheck::parse(&TWIN_REQUEST).ok() });
    assert_eq!((bus.node.counters().challenges, bus.node.counters().responses), (5, 5));
}

#[test]
fn requests_during_an_answer_are_answered_by_one_more() {
    let mut bus = Bus::online(config());
    bus.hears(CHECK, &TWIN_REQUEST);
    bus.sends(CHECK, &RESPONSE);
    for _ in 0..100 {
        bus.hears(CHECK, &TWIN_REQUEST);
    }
    bus.sends_nothing();
    bus.acknowledges();
    bus.sends(CHECK, &RESPONSE);
    bus.acknowledges();
    bus.sends_nothing();
    assert_eq!(bus.node.counters().requests_merged, 99);
}

#[test]
fn checks_of_other_mac_ids_are_not_answered() {
    let mut bus = Bus::online(config());
    for other in (0..64).filter(|&number| number != 37) {
        bus.hears(0x407 + 8 * other, &TWIN_REQUEST);
        bus.hears(0x407 + 8 * other, &TWIN_RESPONSE);
    }
    bus.is(StateKind::OnLine);
    bus.sends_nothing();
}

/// Without the answer the newcomer would get on line too: its second request is its last.
#[test]
fn an_answer_given_back_is_reported_and_handed_out_again_after_a_pause() {
    let mut bus = Bus::online(config());
    bus.hears(CHECK, &TWIN_REQUEST);
    bus.sends(CHECK, &RESPONSE);
    bus.done(TxOutcome::Dropped);
    bus.tells(AccessEvent::NotSent { what: Outgoing::CheckResponse, outcome: TxOutcome::Dropped });
    bus.wait(99);
    bus.sends_nothing();
    bus.wait(1);
    bus.sends(CHECK, &RESPONSE);
    bus.acknowledges();
    bus.wait(10_000);
    bus.sends_nothing();
    assert_eq!((bus.node.counters().responses, bus.node.counters().requests_merged), (1, 0));
}

#[test]
fn a_request_during_the_pause_shares_the_answer_and_does_not_shorten_it() {
    let mut bus = Bus::online(config());
    bus.hears(CHECK, &TWIN_REQUEST);
    bus.sends(CHECK, &RESPONSE);
    bus.done(TxOutcome::Dropped);
    bus.wait(50);
    bus.hears(CHECK, &TWIN_REQUEST);
    bus.wait(49);
    bus.sends_nothing();
    bus.wait(1);
    bus.sends(CHECK, &RESPONSE);
    bus.acknowledges();
    bus.sends_nothing();
    assert_eq!(bus.node.counters().requests_merged, 1);
}

#[test]
fn a_link_that_is_up_again_or_a_mode_that_is_set_ends_the_pause() {
    let mode = link_core::Mode { bit_rate: link_core::BitRate::K250, listen_only: false };
    for ready in [LinkEvent::Up, LinkEvent::ModeSet(mode)] {
        let mut bus = Bus::online(config());
        bus.hears(CHECK, &TWIN_REQUEST);
        bus.sends(CHECK, &RESPONSE);
        bus.done(TxOutcome::Dropped);
        bus.sends_nothing();
        bus.link(ready);
        bus.sends(CHECK, &RESPONSE);
    }
}

/// A port that refuses everything costs one attempt for each pause.
#[test]
fn a_port_that_refuses_every_frame_does_not_make_the_node_spin() {
    let mut bus = Bus::online(config());
    bus.hears(CHECK, &TWIN_REQUEST);
    for _ in 0..100 {
        bus.sends(CHECK, &RESPONSE);
        bus.done(TxOutcome::Dropped);
        bus.sends_nothing();
        bus.wait(100);
    }
    bus.hears(CHECK, &TWIN_RESPONSE);
    bus.is(StateKind::CommFault);
    bus.withdraws();
    bus.done(TxOutcome::Withdrawn);
    assert_eq!(bus.node.deadline(), None);
}

#[test]
fn lost_frames_are_reported() {
    let mut bus = Bus::online(config());
    bus.link(LinkEvent::Overrun { lost: 3 });
    bus.link(LinkEvent::Overrun { lost: 0 });
    bus.tells(AccessEvent::FramesLost { count: 3 });
    assert_eq!(bus.node.counters().frames_lost, 4, "one at least, where the controller does not count");
}

#[test]
fn without_connections_the_indicator_flashes_green() {
    assert_eq!(Bus::online(config()).node.network_status(), NetworkStatus::FlashingGreen);
}
