//! On line: defending the address, telling it, losing it.

use link_core::frame::extended_id;
use link_core::{Frame, TxOutcome};

use super::super::{Access, AccessEvent, StateKind};
use super::bus::*;

#[test]
fn who_wants_the_address_is_told_that_it_is_taken() {
    for other in [LOWER, HIGHER] {
        let mut bus = Bus::online(config());
        bus.request(other, 67);
        bus.tells(AccessEvent::Defended { against: other });
        bus.sends(RESPONSE_67);
        bus.acknowledges();
        bus.is(StateKind::Online);
        assert_eq!((bus.node.counters().challenges, bus.node.counters().responses), (1, 1));
    }
}

/// One more follows for those that arrive while it is on its way, since it may have been sent before them.
#[test]
fn requests_share_an_answer_that_was_not_handed_out() {
    let mut bus = Bus::online(config());
    for _ in 0..3 {
        bus.request(HIGHER, 67);
    }
    bus.sends(RESPONSE_67);
    bus.sends_nothing();
    bus.acknowledges();
    bus.sends(RESPONSE_67);
    bus.acknowledges();
    bus.sends_nothing();
    assert_eq!(bus.node.counters().merged, 1);
}

#[test]
fn an_answer_that_is_given_back_is_repeated() {
    let mut bus = Bus::online(config());
    bus.request(HIGHER, 67);
    bus.sends(RESPONSE_67);
    bus.done(TxOutcome::Dropped);
    bus.wait(100);
    bus.sends(RESPONSE_67);
}

#[test]
fn joined_segments_leave_the_address_to_the_one_that_speaks_first() {
    let mut bus = Bus::online(config());
    bus.response(HIGHER, 67);
    bus.tells(AccessEvent::AddressTaken { address: oa(67), by: HIGHER });
    bus.is(StateKind::Hello1);
    bus.says_both(HELLO_127);
    bus.is(StateKind::Standby);
}

#[test]
fn the_address_is_told_from_time_to_time() {
    let mut telling = config();
    telling.announcement = 10_000;
    let mut bus = Bus::online(telling);
    bus.wait(9999);
    bus.sends_nothing();
    bus.wait(1);
    bus.sends(RESPONSE_67);
    bus.wait(5000);
    bus.acknowledges();
    bus.wait(9000);
    bus.request(HIGHER, 67);
    bus.sends(RESPONSE_67);
    bus.acknowledges();
    // A defence tells it as well.
    bus.wait(9999);
    bus.sends_nothing();
    bus.wait(1);
    bus.sends(RESPONSE_67);
    bus.is(StateKind::Online);
}

#[test]
fn what_is_for_other_parts_of_the_node_is_left_to_them() {
    let mut bus = Bus::online(config());
    bus.hears(Frame::new(extended_id(0x1C86_0200), &[0x0E, 1, 1, 1]).unwrap());
    bus.hears_any();
    bus.hears(Frame::new(link_core::frame::standard_id(0x2C3), &[1]).unwrap());
    assert_eq!(bus.node.counters().discarded, 0);
    assert_eq!(bus.events, []);
    let mut bus = Bus::standby(config());
    let before = bus.node.counters().discarded;
    bus.hears_any();
    assert_eq!(bus.node.counters().discarded, before + 1);
}

#[test]
fn a_hello_that_cannot_be_read_is_ignored_counted_and_told() {
    let mut bus = Bus::online(config());
    for len in 0..8 {
        let frame = Frame::new(extended_id(0x1F86_0000), &DATA[..len]).unwrap();
        bus.hears(frame);
        bus.tells(AccessEvent::BadFrame(frame));
    }
    assert_eq!(bus.node.counters().bad_frames, 8);
    bus.is(StateKind::Online);
    bus.sends_nothing();
}

#[test]
fn the_application_gives_another_address() {
    let mut bus = Bus::online(config());
    bus.command(|node, now| node.set_address(now, oa(5)));
    bus.is(StateKind::Hello1);
    bus.says_both(0x1F0A_4433);
    bus.is(StateKind::Online);
    bus.command(|node, now| node.set_address(now, oa(127)));
    bus.says_both(HELLO_127);
    bus.is(StateKind::Standby);
}

#[test]
fn an_address_that_is_set_before_the_node_takes_part_is_used_when_it_does() {
    let mut bus = Bus::listening(config());
    bus.command(|node, now| node.set_address(now, oa(67)));
    bus.hears_any();
    bus.hears_any();
    bus.sets_mode(active(link_core::BitRate::K500));
    bus.sends(HELLO_67);
}

#[test]
fn a_reset_forgets_the_address_and_detects_again() {
    let mut bus = Bus::online(config());
    bus.command(Access::reset);
    bus.is(StateKind::DetectingBitRate);
    assert!(bus.node.address().is_none());
    assert_eq!(bus.node.bit_rate(), None);
}
