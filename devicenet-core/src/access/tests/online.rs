//! Defending the MAC ID.

use link_core::{LinkEvent, TxOutcome};

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

#[test]
fn an_answer_given_back_is_reported_and_not_repeated() {
    let mut bus = Bus::online(config());
    bus.hears(CHECK, &TWIN_REQUEST);
    bus.sends(CHECK, &RESPONSE);
    bus.done(TxOutcome::Dropped);
    bus.tells(AccessEvent::NotSent { what: Outgoing::CheckResponse, outcome: TxOutcome::Dropped });
    bus.wait(10_000);
    bus.sends_nothing();
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
