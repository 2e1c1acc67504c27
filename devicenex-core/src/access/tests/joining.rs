//! The two Hellos, and who keeps the address.

use link_core::{BusErrorKind, LinkEvent, TxOutcome};

use super::super::{AccessEvent, Outgoing, StateKind};
use super::bus::*;
use crate::message::{DeviceIdentity, Hello, PortByte};

#[test]
fn a_device_says_hello_twice_and_stands_by() {
    let mut bus = Bus::greeting(config());
    bus.sends(HELLO_127);
    bus.wait(5000);
    bus.is(StateKind::Hello1);
    bus.acknowledges();
    bus.wait(999);
    bus.sends_nothing();
    bus.wait(1);
    bus.is(StateKind::Hello2);
    bus.sends(HELLO_127);
    bus.wait(5000);
    bus.acknowledges();
    bus.wait(1000);
    bus.is(StateKind::Standby);
    bus.wait(100_000);
    bus.sends_nothing();
}

#[test]
fn with_the_address_of_a_roam_it_gets_on_line() {
    let mut bus = Bus::roamed(config());
    bus.says_both(HELLO_67);
    assert!(bus.node.is_online());
    assert_eq!(bus.node.address(), oa(67));
    assert_eq!(bus.filter(), crate::id::hello(oa(67)));
}

/// A Hello response in the first wait, in the second, and while a Hello is with the controller.
#[test]
fn who_is_told_that_its_address_is_taken_starts_anew_without_one() {
    for moment in 0..4 {
        let mut bus = Bus::roamed(config());
        bus.sends(HELLO_67);
        for half in 0..moment {
            if half % 2 == 0 {
                bus.acknowledges();
            } else {
                bus.wait(1000);
                bus.sends(HELLO_67);
            }
        }
        bus.response(HIGHER, 67);
        bus.tells(AccessEvent::AddressTaken { address: oa(67), by: HIGHER });
        bus.is(StateKind::Hello1);
        assert!(bus.node.address().is_none());
        if moment % 2 == 0 {
            bus.withdraws();
            bus.done(TxOutcome::Withdrawn);
        }
        bus.says_both(HELLO_127);
        bus.is(StateKind::Standby);
        assert_eq!(bus.node.counters().addresses_lost, 1);
    }
}

#[test]
fn of_two_that_join_the_higher_identity_gives_way() {
    let mut bus = Bus::roamed(config());
    bus.sends(HELLO_67);
    bus.request(LOWER, 67);
    bus.withdraws();
    bus.tells(AccessEvent::AddressTaken { address: oa(67), by: LOWER });
    bus.done(TxOutcome::Sent);
    bus.sends(HELLO_127);
    bus.is(StateKind::Hello1);
}

/// It says Hello once more, and not a response: a third node may be on line with that address. It does so even if its Hello
/// was with the controller when the other asked, for that one may be lost.
#[test]
fn of_two_that_join_the_lower_identity_keeps_the_address() {
    let mut bus = Bus::roamed(config());
    bus.sends(HELLO_67);
    bus.request(HIGHER, 67);
    bus.tells(AccessEvent::Defended { against: HIGHER });
    bus.sends_nothing();
    bus.acknowledges();
    bus.sends(HELLO_67);
    bus.acknowledges();
    bus.sends_nothing();
    bus.wait(300);
    bus.request(HIGHER, 67);
    bus.sends(HELLO_67);
    bus.acknowledges();
    bus.wait(700);
    bus.sends(HELLO_67);
    bus.acknowledges();
    bus.wait(1000);
    bus.is(StateKind::Online);
    assert_eq!(bus.node.counters().challenges, 2);
}

/// Vendor, product, revision, serial number, in this order.
#[test]
fn identities_are_compared_field_by_field() {
    let steps: [fn(&mut DeviceIdentity); 4] = [
        |device| device.vendor.0 -= 1,
        |device| device.product_code -= 1,
        |device| device.major_revision -= 1,
        |device| device.serial -= 1,
    ];
    for (place, step) in steps.into_iter().enumerate() {
        let mut lower = DeviceIdentity {
            vendor: OWN.vendor,
            product_code: if place < 1 { 0xFFFF } else { OWN.product_code },
            major_revision: if place < 2 { 0xFF } else { OWN.major_revision },
            serial: if place < 3 { 0xFFFF_FFFF } else { OWN.serial },
        };
        step(&mut lower);
        let mut bus = Bus::roamed(config());
        bus.request(lower, 67);
        assert!(bus.node.address().is_none(), "{lower}");
    }
}

#[test]
fn the_answer_of_the_lower_identity_survives_the_end_of_the_wait() {
    let mut bus = Bus::roamed(config());
    bus.sends(HELLO_67);
    bus.acknowledges();
    bus.wait(900);
    bus.request(HIGHER, 67);
    bus.sends(HELLO_67);
    bus.wait(100);
    bus.is(StateKind::Hello2);
    bus.sends_nothing();
    bus.acknowledges();
    bus.sends(HELLO_67);
    bus.acknowledges();
    bus.wait(1000);
    bus.is(StateKind::Online);
}

#[test]
fn hellos_of_other_addresses_are_nobodys_business() {
    let mut bus = Bus::roamed(config());
    for (device, address) in [(LOWER, 66), (LOWER, 127), (OWN, 66), (OWN, 127)] {
        bus.request(device, address);
        bus.response(device, address);
    }
    assert_eq!(bus.events, []);
    bus.says_both(HELLO_67);
    bus.is(StateKind::Online);
}

#[test]
fn without_an_address_nobody_gives_way() {
    let mut bus = Bus::greeting(config());
    bus.events.clear();
    bus.request(LOWER, 127);
    bus.response(LOWER, 127);
    assert_eq!(bus.events, []);
    bus.says_both(HELLO_127);
    bus.is(StateKind::Standby);
}

/// An echo, or a cloned serial number.
#[test]
fn its_own_identity_is_told_and_changes_nothing() {
    let makes: [(Make, u8); 4] =
        [(Bus::greeting, 127), (Bus::standby, 127), (Bus::roamed, 67), (Bus::online, 67)];
    for (make, address) in makes {
        let mut bus = make(config());
        let before = bus.node.state().clone();
        for direction in [crate::id::Direction::Request, crate::id::Direction::Response] {
            bus.hello(OWN, address, direction);
            let hello = Hello { source: oa(address), direction, device: OWN, port: PortByte::ZERO };
            bus.tells(AccessEvent::OwnIdentity(hello));
        }
        assert_eq!((bus.node.state(), bus.node.counters().own_identity), (&before, 2));
    }
}

#[test]
fn a_lone_node_is_told_once_and_goes_on() {
    let mut bus = Bus::greeting(config());
    bus.events.clear();
    for _ in 0..3 {
        bus.link(LinkEvent::BusError(BusErrorKind::Ack));
    }
    assert_eq!(bus.events, [AccessEvent::NotAcknowledged]);
    assert_eq!(bus.node.counters().unacknowledged, 3);
    bus.sends(HELLO_127);
    bus.acknowledges();
    bus.wait(1000);
    bus.is(StateKind::Hello2);
}

#[test]
fn a_hello_that_is_given_back_is_handed_out_again_after_the_back_off() {
    let mut bus = Bus::greeting(config());
    bus.sends(HELLO_127);
    bus.done(TxOutcome::Dropped);
    bus.tells(AccessEvent::NotSent { what: Outgoing::Hello, outcome: TxOutcome::Dropped });
    bus.wait(99);
    bus.sends_nothing();
    bus.wait(1);
    bus.sends(HELLO_127);
    bus.done(TxOutcome::Dropped);
    bus.link(LinkEvent::Up);
    bus.sends(HELLO_127);
}

/// The objection that arrives with the end of the wait counts; one that arrives after it meets a node on line.
#[test]
fn an_objection_at_the_end_of_the_wait_counts() {
    for (delay, expected) in [(1000, StateKind::Hello1), (1001, StateKind::Online)] {
        let mut bus = Bus::roamed(config());
        bus.acknowledges();
        bus.wait(1000);
        bus.acknowledges();
        bus.now += core::time::Duration::from_millis(delay);
        bus.request(LOWER, 67);
        bus.is(expected);
    }
}

#[test]
fn the_wait_can_be_set() {
    let mut bus = Bus::greeting(config());
    bus.command(|node, _| node.set_hello_wait(200));
    bus.acknowledges();
    bus.wait(199);
    bus.is(StateKind::Hello1);
    bus.wait(1);
    bus.is(StateKind::Hello2);
    bus.command(super::super::Access::reset);
    assert_eq!(bus.node.hello_wait(), 1000);
}
