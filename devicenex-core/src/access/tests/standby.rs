//! Without an address: Mini-who and ROAM.

use link_core::frame::extended_id;
use link_core::{Frame, TxOutcome};

use super::super::{AccessEvent, RoamRefusal, StateKind};
use super::bus::*;
use crate::message::DeviceIdentity;

#[test]
fn only_what_is_for_such_devices_wakes_it() {
    let bus = Bus::standby(config());
    assert_eq!(bus.filter(), crate::id::standby());
    assert_eq!(bus.node.filter(), crate::id::standby());
}

#[test]
fn each_mini_who_is_answered_by_one_hello() {
    let mut bus = Bus::standby(config());
    bus.mini_who();
    bus.sends(HELLO_127);
    bus.mini_who();
    bus.mini_who();
    bus.sends_nothing();
    bus.acknowledges();
    bus.sends(HELLO_127);
    bus.acknowledges();
    bus.sends_nothing();
    assert_eq!((bus.node.counters().mini_whos, bus.node.counters().merged), (3, 1));
    bus.is(StateKind::Standby);
}

#[test]
fn an_answer_that_is_given_back_is_repeated() {
    let mut bus = Bus::standby(config());
    bus.mini_who();
    bus.sends(HELLO_127);
    bus.done(TxOutcome::Dropped);
    bus.sends_nothing();
    bus.wait(100);
    bus.sends(HELLO_127);
}

#[test]
fn nobody_else_answers_a_mini_who() {
    let makes: [Make; 4] = [Bus::listening, Bus::greeting, Bus::roamed, Bus::online];
    for make in makes {
        let mut bus = make(config());
        let before = bus.node.state().kind();
        bus.answer(TxOutcome::Sent);
        bus.mini_who();
        bus.is(before);
        assert_eq!(bus.node.counters().mini_whos, 0);
    }
}

#[test]
fn a_roam_for_this_device_gives_it_the_address() {
    let mut bus = Bus::standby(config());
    bus.roam(OWN, 67);
    bus.tells(AccessEvent::AddressAssigned { address: oa(67) });
    bus.is(StateKind::Hello1);
    bus.sends(HELLO_67);
    assert_eq!(bus.node.counters().roams, 1);
}

/// The answer to a Mini-who is still with the controller: it would tell the old address.
#[test]
fn a_roam_withdraws_the_hello_without_an_address() {
    let mut bus = Bus::standby(config());
    bus.mini_who();
    bus.sends(HELLO_127);
    bus.roam(OWN, 67);
    bus.withdraws();
    bus.sends_nothing();
    bus.done(TxOutcome::Withdrawn);
    bus.sends(HELLO_67);
}

/// One bit of the identity that differs is enough: in each byte of the data, and in the identifier.
#[test]
fn a_roam_for_another_device_is_ignored_and_counted() {
    let frame = |id, data: &[u8]| Frame::new(extended_id(id), data).unwrap();
    let mut data = DATA;
    data[7] = 67;
    let mut bus = Bus::standby(config());
    let mut others = 0;
    for byte in 0..7 {
        for bit in 0..8 {
            let mut other = data;
            other[byte] ^= 1 << bit;
            bus.hears(frame(0x1EFE_4433, &other));
            others += 1;
        }
    }
    for bit in 0..16 {
        bus.hears(frame(0x1EFE_4433 ^ 1 << bit, &data));
        others += 1;
    }
    assert_eq!(bus.node.counters().roams_for_others, others);
    bus.is(StateKind::Standby);
    assert_eq!(bus.events, []);
    bus.hears(frame(0x1EFE_4433, &data));
    bus.is(StateKind::Hello1);
}

#[test]
fn a_roam_that_cannot_be_is_ignored_counted_and_told() {
    let mut bus = Bus::standby(config());
    let mut data = DATA;
    data[7] = 0x80 | 67;
    let mut frames: std::vec::Vec<_> =
        (0..8).map(|len| Frame::new(extended_id(0x1EFE_4433), &DATA[..len]).unwrap()).collect();
    frames.push(Frame::new(extended_id(0x1EFE_4433), &data).unwrap());
    for frame in frames {
        bus.hears(frame);
        bus.tells(AccessEvent::BadFrame(frame));
        assert!(AccessEvent::BadFrame(frame).error().is_some());
    }
    assert_eq!(bus.node.counters().bad_frames, 9);
    bus.roam(OWN, 127);
    bus.tells(AccessEvent::RoamRefused { requested: oa(127), why: RoamRefusal::NoAddress });
    bus.is(StateKind::Standby);
    // To another address, with bit 16 set, or as a remote frame: nobody defines that.
    let discarded = bus.node.counters().discarded;
    data[7] = 67;
    bus.hears(Frame::new(extended_id(0x1E86_4433), &data).unwrap());
    bus.hears(Frame::new(extended_id(0x1EFF_4433), &data).unwrap());
    bus.hears(Frame::remote(extended_id(0x1EFE_4433), 8).unwrap());
    assert_eq!(bus.node.counters().discarded, discarded + 3);
    bus.is(StateKind::Standby);
}

#[test]
fn a_device_that_has_an_address_or_still_says_hello_refuses_a_roam() {
    let makes: [Make; 3] = [Bus::greeting, Bus::roamed, Bus::online];
    for make in makes {
        let mut bus = make(config());
        let before = bus.node.state().clone();
        bus.roam(OWN, 5);
        bus.tells(AccessEvent::RoamRefused { requested: oa(5), why: RoamRefusal::NotInStandby });
        assert_eq!((bus.node.state(), bus.node.counters().roams_refused), (&before, 1));
    }
}

#[test]
fn early_roam_is_obeyed_between_the_hellos_but_not_with_an_address() {
    let mut early = config();
    early.early_roam = true;
    let mut bus = Bus::greeting(early.clone());
    bus.sends(HELLO_127);
    bus.roam(OWN, 67);
    bus.withdraws();
    bus.done(TxOutcome::Sent);
    bus.sends(HELLO_67);
    bus.roam(OWN, 5);
    bus.tells(AccessEvent::RoamRefused { requested: oa(5), why: RoamRefusal::NotInStandby });
    assert_eq!(bus.node.address(), oa(67));
}

#[test]
fn hellos_of_other_devices_without_an_address_change_nothing() {
    let mut bus = Bus::standby(config());
    for serial in 0..100 {
        bus.request(DeviceIdentity { serial, ..OWN }, 127);
    }
    bus.sends_nothing();
    assert_eq!(bus.events, []);
}
