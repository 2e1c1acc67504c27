//! From power-up to the first Hello: not a word at a rate that is not known.

use link_core::link::LinkCommandKind;
use link_core::{BitRate, Filter, Input, LinkEvent};

use super::super::{AccessEvent, Fault, ModeRefused, StateKind};
use super::bus::*;

#[test]
fn a_device_listens_to_everything_until_two_frames_in_a_row_were_valid() {
    let mut bus = Bus::power_up(config());
    bus.is(StateKind::DetectingBitRate);
    let everything = [Filter::ALL_STANDARD, Filter::ALL_EXTENDED];
    assert_eq!(bus.node.filter().as_slice(), everything);
    bus.sets_mode(listen_only(BitRate::K500));
    bus.error();
    bus.sets_mode(listen_only(BitRate::K250));
    bus.hears_any();
    bus.error();
    bus.sets_mode(listen_only(BitRate::K125));
    bus.hears_any();
    bus.sends_nothing();
    bus.hears_any();
    bus.tells(AccessEvent::BitRateLocked(Some(BitRate::K125)));
    bus.is(StateKind::Hello1);
    bus.sends_nothing();
    bus.sets_mode(active(BitRate::K125));
    bus.sends(HELLO_127);
    assert_eq!(bus.node.counters().detection_errors, 2);
    assert_eq!(bus.node.bit_rate(), Some(BitRate::K125));
}

#[test]
fn on_a_silent_bus_it_goes_round_and_says_nothing() {
    let mut bus = Bus::power_up(config());
    for rate in [BitRate::K500, BitRate::K250, BitRate::K125].into_iter().cycle().take(30) {
        bus.sets_mode(listen_only(rate));
        bus.wait(2999);
        assert_eq!(bus.node.state().kind(), StateKind::DetectingBitRate);
        bus.wait(1);
    }
    bus.sends_nothing();
}

/// A Mini-who comes every two seconds: each starts the dwell time anew.
#[test]
fn a_frame_starts_the_dwell_time_anew() {
    let mut bus = Bus::listening(config());
    bus.wait(2900);
    bus.hears_any();
    bus.wait(2900);
    bus.hears_any();
    bus.asks_for_mode(active(BitRate::K500));
}

#[test]
fn a_mode_that_was_not_asked_for_starts_nothing() {
    let mut bus = Bus::listening(config());
    bus.hears_any();
    bus.hears_any();
    bus.link(LinkEvent::ModeSet(active(BitRate::K250)));
    bus.sends_nothing();
    bus.link(LinkEvent::ModeSet(listen_only(BitRate::K500)));
    bus.sends_nothing();
    bus.link(LinkEvent::ModeSet(active(BitRate::K500)));
    bus.sends(HELLO_127);
}

#[test]
fn a_manager_sets_the_rate_and_begins_with_its_address() {
    let mut bus = Bus::power_up(manager());
    bus.is(StateKind::Hello1);
    bus.sends_nothing();
    bus.sets_mode(active(BitRate::K250));
    bus.says_both(HELLO_67);
    bus.is(StateKind::Online);
    assert_eq!(bus.node.bit_rate(), Some(BitRate::K250));
}

#[test]
fn a_controller_that_takes_no_mode_faults_the_node() {
    for config in [config(), manager()] {
        let mut bus = Bus::power_up(config);
        bus.link(LinkEvent::Refused(LinkCommandKind::SetMode));
        assert_eq!(bus.node.fault(), Some(Fault::Mode));
        bus.tells(AccessEvent::LinkRefused(LinkCommandKind::SetMode));
        bus.hears_any();
        bus.sends_nothing();
        assert_eq!(bus.node.counters().discarded, 1);
    }
}

#[test]
fn or_it_takes_the_rate_of_the_link_after_two_frames() {
    let mut config = config();
    config.mode_refused = ModeRefused::TakeRateOfLink;
    let mut bus = Bus::power_up(config);
    bus.link(LinkEvent::Refused(LinkCommandKind::SetMode));
    bus.hears_any();
    bus.error();
    bus.hears_any();
    bus.wait(10_000);
    bus.hears_any();
    bus.sends_nothing();
    bus.hears_any();
    bus.tells(AccessEvent::BitRateLocked(None));
    bus.sends(HELLO_127);

    let mut config = manager();
    config.mode_refused = ModeRefused::TakeRateOfLink;
    let mut bus = Bus::power_up(config);
    bus.link(LinkEvent::Refused(LinkCommandKind::SetMode));
    bus.sends(HELLO_67);
}

/// It could listen, and cannot speak: it would wait for ever for what it hands out.
#[test]
fn a_device_that_cannot_leave_listen_only_mode_is_faulted() {
    let mut config = config();
    config.mode_refused = ModeRefused::TakeRateOfLink;
    let mut bus = Bus::listening(config);
    bus.hears_any();
    bus.hears_any();
    bus.link(LinkEvent::Refused(LinkCommandKind::SetMode));
    assert_eq!(bus.node.fault(), Some(Fault::Mode));
    bus.sends_nothing();
}

#[test]
fn an_early_tick_changes_nothing() {
    let mut bus = Bus::listening(config());
    let before = bus.node.clone();
    bus.input(Input::Tick);
    bus.input(Input::Tick);
    assert_eq!(bus.node, before);
}
