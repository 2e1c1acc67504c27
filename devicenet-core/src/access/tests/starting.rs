//! From power-up to on line.

use link_core::{Frame, Input, Instant, LinkEvent, Machine, TxOutcome, TxToken, frame::extended_id};
use proptest::prelude::*;

use super::super::{Access, AccessEvent, Fault, NetworkStatus, StateKind};
use super::bus::*;

/// Duplicate MAC ID summary, "Power-up": request, 1 s, request, 1 s, on line.
#[test]
fn two_requests_one_second_apart_then_on_line_after_two_seconds() {
    let mut bus = Bus::power_up(config());
    bus.sends(CHECK, &REQUEST);
    bus.acknowledges();
    bus.is(StateKind::WaitingDupMac);

    bus.wait(999);
    bus.sends_nothing();
    bus.wait(1);
    assert_eq!(bus.now, Instant::from_millis(1000));
    bus.sends(CHECK, &REQUEST);
    bus.acknowledges();

    bus.wait(999);
    bus.is(StateKind::WaitingDupMac);
    bus.wait(1);
    assert_eq!(bus.now, Instant::from_millis(2000));
    bus.is(StateKind::OnLine);
    bus.sends_nothing();
    assert!(bus.node.is_online());
}

#[test]
fn the_waits_begin_when_the_request_was_on_the_bus() {
    let mut bus = Bus::power_up(config());
    bus.wait(10_000);
    bus.sends(CHECK, &REQUEST);
    bus.acknowledges();
    bus.wait(999);
    bus.is(StateKind::WaitingDupMac);
    bus.wait(1);
    bus.is(StateKind::SendingDupMac);
}

/// The controller repeats a frame that nobody acknowledges; the node does not hand it out again.
#[test]
fn alone_on_the_bus_a_node_waits_for_ever_with_one_request() {
    let mut bus = Bus::power_up(config());
    bus.sends(CHECK, &REQUEST);
    for _ in 0..3600 {
        bus.wait(1000);
        bus.link(LinkEvent::BusError(link_core::BusErrorKind::Ack));
    }
    bus.link(LinkEvent::ErrorPassive);
    bus.is(StateKind::SendingDupMac);
    bus.sends_nothing();
    bus.withdraws_nothing();
    assert_eq!(bus.node.network_status(), NetworkStatus::Off);
    assert_eq!(bus.node.deadline(), None, "there is nothing to wait for but the bus");
    let told = bus.events.iter().filter(|event| **event == AccessEvent::NotAcknowledged).count();
    assert_eq!(told, 1, "once, not once for each attempt");
    assert_eq!(bus.node.counters().unacknowledged, 3600);

    bus.acknowledges();
    bus.is(StateKind::WaitingDupMac);
}

#[test]
fn while_checking_every_other_message_is_discarded() {
    let mut bus = Bus::power_up(config());
    bus.sends(CHECK, &REQUEST);
    for kind in [StateKind::SendingDupMac, StateKind::WaitingDupMac] {
        bus.is(kind);
        bus.hears(0x52E, &[0x0A, 0x4B, 0x03, 0x01, 0x03, 0x0A]);
        bus.hears(0x537, &TWIN_REQUEST);
        bus.hears(0x7ED, &[0x3F, 0x4C]);
        bus.is(kind);
        bus.sends_nothing();
        if kind == StateKind::SendingDupMac {
            bus.acknowledges();
        }
    }
    assert_eq!(bus.node.counters().discarded, 6);
}

#[test]
fn remote_frames_and_29_bit_identifiers_are_no_duplicates() {
    let mut bus = Bus::waiting(config());
    let id = link_core::frame::standard_id(CHECK);
    bus.input(Input::Frame(Frame::remote(id, 7).unwrap()));
    bus.input(Input::Frame(Frame::new(extended_id(u32::from(CHECK)), &TWIN_REQUEST).unwrap()));
    bus.is(StateKind::WaitingDupMac);
    assert_eq!(bus.node.counters().foreign_frames, 2);
}

#[test]
fn a_node_without_power_hears_and_says_nothing() {
    let mut bus = Bus::dark(config());
    bus.wait(10_000);
    bus.hears(CHECK, &TWIN_REQUEST);
    bus.link(LinkEvent::BusOff);
    bus.is(StateKind::NonExistent);
    bus.sends_nothing();
    assert_eq!(bus.events, []);
    assert_eq!(bus.node.network_status(), NetworkStatus::Off);
    assert_eq!(bus.node.bus_off_counter(), 0);
}

#[test]
fn network_power_lost_and_back_starts_anew_from_every_state() {
    for make in [Bus::power_up, Bus::waiting, Bus::online, Bus::faulted] {
        let mut bus = make(config());
        let in_flight = bus.node.state().kind() == StateKind::SendingDupMac;
        if in_flight {
            bus.sends(CHECK, &REQUEST);
        }
        bus.link(LinkEvent::Down);
        bus.is(StateKind::NonExistent);
        bus.withdraws_nothing();
        if in_flight {
            bus.done(TxOutcome::Dropped);
        }
        bus.wait(5000);
        bus.sends_nothing();
        bus.link(LinkEvent::Down);
        bus.is(StateKind::NonExistent);
        bus.link(LinkEvent::Up);
        bus.sends(CHECK, &REQUEST);
        assert_eq!(bus.listens_to(), [CHECK]);
    }
}

#[test]
fn a_second_up_changes_nothing() {
    for make in [Bus::power_up, Bus::waiting, Bus::online, Bus::faulted] {
        let mut bus = make(config());
        let before = bus.node.state();
        let filter = bus.listens_to();
        bus.link(LinkEvent::Up);
        assert_eq!(bus.node.state(), before);
        bus.withdraws_nothing();
        assert_eq!(bus.listens_to(), filter, "told again: the controller may have forgotten it");
    }
}

/// A port gives a frame back, for example because the application changed the bit rate.
#[test]
fn a_request_given_back_unsent_is_handed_out_again_after_a_pause() {
    let mut bus = Bus::power_up(config());
    bus.sends(CHECK, &REQUEST);
    bus.done(TxOutcome::Dropped);
    bus.is(StateKind::SendingDupMac);
    bus.wait(99);
    bus.sends_nothing();
    bus.wait(1);
    bus.sends(CHECK, &REQUEST);
    assert_eq!(bus.node.counters().not_sent, 1);

    // Nobody knows whether it was sent, so it is sent again.
    bus.done(TxOutcome::Unknown);
    bus.wait(100);
    bus.sends(CHECK, &REQUEST);
    assert_eq!(bus.node.counters().not_sent, 2);

    bus.done(TxOutcome::Dropped);
    let mode = link_core::Mode { bit_rate: link_core::BitRate::K250, listen_only: false };
    bus.link(LinkEvent::ModeSet(mode));
    bus.sends(CHECK, &REQUEST);
}

#[test]
fn an_answer_to_a_transmission_that_is_not_under_way_changes_nothing() {
    let mut bus = Bus::power_up(config());
    bus.sends(CHECK, &REQUEST);
    bus.input(Input::TxDone(TxToken(7), TxOutcome::Sent));
    bus.is(StateKind::SendingDupMac);
    bus.acknowledges();
    bus.input(Input::TxDone(Access::TOKEN, TxOutcome::Sent));
    bus.is(StateKind::WaitingDupMac);
    assert_eq!(bus.node.counters().stray_tx_done, 2);
}

/// At the same moment the frame counts first; a wait that ended earlier counts before it, however late the tick comes.
#[test]
fn a_duplicate_at_the_end_of_the_wait_is_still_in_time() {
    let mut bus = Bus::waiting(config());
    bus.now = Instant::from_millis(1000);
    bus.hears(CHECK, &TWIN_RESPONSE);
    assert_eq!(bus.node.fault(), Some(Fault::DuplicateMacId));

    let mut bus = Bus::waiting(config());
    bus.wait(1000);
    bus.sends(CHECK, &REQUEST);
    bus.acknowledges();
    bus.now = Instant::from_millis(2001);
    bus.hears(CHECK, &TWIN_REQUEST);
    bus.is(StateKind::OnLine);
    bus.sends(CHECK, &RESPONSE);
}

#[test]
fn time_that_runs_backwards_is_the_latest_time() {
    let mut bus = Bus::waiting(config());
    bus.wait(600);
    bus.input(Input::Tick);
    bus.now = Instant::from_millis(10);
    bus.input(Input::Tick);
    bus.is(StateKind::WaitingDupMac);
    assert_eq!(bus.node.deadline().unwrap().at, Instant::from_millis(1000));
}

#[test]
fn the_filter_follows_the_state() {
    let mut bus = Bus::power_up(config());
    assert_eq!(bus.listens_to(), [0x52F]);
    bus.acknowledges();
    bus.hears(CHECK, &TWIN_RESPONSE);
    assert_eq!(bus.listens_to(), [0x7ED]);

    let mut without = config();
    without.offline_set = false;
    assert_eq!(Bus::faulted(without).listens_to(), []);
}

/// With Quick Connect the node is on line after the first request; the second follows one second later.
#[test]
fn quick_connect_is_on_line_after_the_first_request() {
    let mut quick = config();
    quick.quick_connect = true;
    let mut bus = Bus::power_up(quick);
    bus.sends(CHECK, &REQUEST);
    bus.acknowledges();
    bus.is(StateKind::OnLine);
    bus.wait(999);
    bus.sends_nothing();
    bus.wait(1);
    bus.sends(CHECK, &REQUEST);
    bus.is(StateKind::OnLine);
    bus.acknowledges();
    bus.wait(10_000);
    bus.sends_nothing();
    bus.is(StateKind::OnLine);
}

#[test]
fn quick_connect_faults_on_a_late_response_and_answers_before_it_asks_again() {
    let mut quick = config();
    quick.quick_connect = true;
    let mut bus = Bus::power_up(quick.clone());
    bus.sends(CHECK, &REQUEST);
    bus.acknowledges();
    bus.wait(400);
    bus.hears(CHECK, &TWIN_RESPONSE);
    bus.is(StateKind::CommFault);
    bus.wait(10_000);
    bus.sends_nothing();

    let mut bus = Bus::power_up(quick);
    bus.sends(CHECK, &REQUEST);
    bus.acknowledges();
    bus.now = Instant::from_millis(1000);
    bus.hears(CHECK, &TWIN_REQUEST);
    bus.sends(CHECK, &RESPONSE);
    bus.sends_nothing();
    bus.acknowledges();
    bus.sends(CHECK, &REQUEST);
    bus.done(TxOutcome::Dropped);
    bus.wait(100);
    bus.sends(CHECK, &REQUEST);
}

#[test]
fn quick_connect_takes_effect_at_the_next_start() {
    let mut bus = Bus::online(config());
    bus.command(|node, _| node.set_quick_connect(true));
    assert!(bus.node.quick_connect());
    bus.command(Access::reset);
    bus.sends(CHECK, &REQUEST);
    bus.acknowledges();
    bus.is(StateKind::OnLine);
}

proptest! {
    /// Whatever happens: no panic, no transition outside the table, one frame in flight, and no frame that the state does
    /// not allow: before it is on line a node sends requests only, and while faulted only Group 4.
    #[test]
    fn nothing_breaks_it(steps in prop::collection::vec((0_u8..16, any::<u8>(), any::<[u8; 8]>()), 0..200)) {
        let mut bus = Bus::dark(config());
        for (step, number, data) in steps {
            let len = usize::from(number % 9);
            match step {
                0 | 1 => bus.link(LinkEvent::Up),
                2 => bus.link(LinkEvent::Down),
                3 => bus.link(LinkEvent::BusOff),
                4 => bus.hears(CHECK, &data[..len]),
                5 => bus.hears(CHECK, if number < 128 { &TWIN_REQUEST } else { &TWIN_RESPONSE }),
                6 => bus.hears(0x7ED, &data[..len]),
                7 => bus.hears(0x7ED, &[number & 0x3F, 0x4D, 0x34, 0x12, 0x45, 0x23, 0x00, 0x00]),
                8 => bus.hears(0x7ED, &[0x3F, 0x4B, number % 7]),
                9 => bus.command(Access::reset),
                10 => { bus.command(|node, now| node.set_mac_id(now, mac(number & 0x3F))).unwrap(); }
                11 => bus.command(|node, _| node.set_bus_off_interrupt(number < 128)),
                12 => bus.link(LinkEvent::Refused(link_core::link::LinkCommandKind::Reset)),
                13 => bus.wait(u64::from(number) * 10),
                _ => bus.answer(match number % 4 { 0 => TxOutcome::Dropped, 1 => TxOutcome::Withdrawn, _ => TxOutcome::Sent }),
            }
            prop_assert_eq!(bus.node.counters().stray_tx_done, 0);
            prop_assert_eq!(bus.node.counters().events_lost, 0);
        }
    }
}
