//! Two masters that want the same slave.

use cip_core::code::{AttributeId, ClassId, InstanceId};
use cip_core::message::AttributeRequest;
use link_core::{BusErrorKind, Input, LinkEvent, TxOutcome, TxToken};

use super::super::*;
use super::bus::{Bus, config, mac};

/// A poll command names no master. So this one stops when it hears that the slave let another allocate it, and asks for
/// it again after pauses.
#[test]
fn a_slave_that_lets_another_master_allocate_it_is_given_up() {
    for allocated in ["5FB: 05 CB 00", "5FB: 45 CB 01"] {
        let mut bus = Bus::running(config());
        bus.command(|master, _| master.set_run(true));
        bus.hears(allocated);
        bus.tells("slave 63: Running -> Waiting: owned by another master");
        bus.is(63, SlaveState::Waiting, ScannerStatus::INITIALISATION_REFUSED);
        assert_eq!(bus.withdrawn, [TxToken(0x1002)], "the poll that was on its way");
        bus.takes();
        bus.input(Input::TxDone(TxToken(0x1002), TxOutcome::Withdrawn));
        bus.hears("3FF: 34 12");
        assert_eq!(bus.master.input_data(mac(63), IoInstance::Poll), None, "it is for the other");
        assert_eq!(bus.master.slave_counters(mac(63)).unwrap().timeouts, 1);
        for pause in [1000, 2000, 4000] {
            bus.wait(pause - 1);
            bus.sends_nothing();
            bus.wait(1);
            let xid = if pause == 2000 { "04" } else { "44" };
            bus.sends(&std::format!("5FE: {xid} 4B 03 01 01 04"));
            bus.hears(&std::format!("5FB: {xid} 94 0C 01"));
            bus.is(63, SlaveState::Waiting, ScannerStatus::INITIALISATION_REFUSED);
        }
    }
}

/// The same while it is configured; nothing is released, for it would be the other's.
#[test]
fn a_slave_that_is_configured_and_taken_by_another_is_not_released() {
    let mut bus = Bus::online(config(), &[super::bus::polled()]);
    bus.sends("5FE: 04 4B 03 01 01 04");
    bus.hears("5FB: 04 CB 00");
    bus.sends("5FC: 44 10 05 01 0C 03");
    bus.hears("5FB: 05 CB 00");
    bus.is(63, SlaveState::Waiting, ScannerStatus::INITIALISATION_REFUSED);
    bus.wait(999);
    bus.sends_nothing();
}

/// What is no allocation of another changes nothing: a refusal, a release, the master's own late answer, a heartbeat.
#[test]
fn other_answers_to_other_masters_are_nothing() {
    let mut bus = Bus::running(config());
    for other in ["5FB: 05 94 0C 01", "5FB: 05 CC", "5FB: 04 CB 00", "5FB: 85 CB 00", "5FB: 05 8E 00"] {
        bus.hears(other);
        bus.is(63, SlaveState::Running, ScannerStatus::NORMAL);
    }
}

/// Somebody else polls slave 63, and this master did not hear why.
#[track_caller]
fn verifying() -> Bus {
    let mut bus = Bus::running(Config { interscan_delay: core::time::Duration::from_secs(60), ..config() });
    bus.sends("5FD:");
    bus.hears("3FF: 34 12");
    bus.hears("5FD: 77");
    bus.sends("5FE: 44 4B 03 01 01 04");
    bus
}

/// It was taken by another while the master was deaf.
#[test]
fn a_slave_that_another_polls_is_asked_whose_it_is() {
    let mut bus = verifying();
    bus.hears("5FB: 44 94 0C 01");
    bus.tells("slave 63: Running -> Waiting: owned by another master");
    bus.is(63, SlaveState::Waiting, ScannerStatus::INITIALISATION_REFUSED);
}

/// The other has not heard that it lost the slave: nothing changes, and the explicit connection works.
#[test]
fn a_slave_that_another_polls_and_that_is_this_masters_runs_on() {
    for answer in ["94 0B 02", "CB 00", "94 0B FF"] {
        let mut bus = verifying();
        bus.hears(&std::format!("5FB: 44 {answer}"));
        bus.is(63, SlaveState::Running, ScannerStatus::NORMAL);
        let vendor = AttributeRequest::get(ClassId::IDENTITY, InstanceId(1), AttributeId(1));
        bus.command(|master, now| master.request_attribute(now, mac(63), &vendor, 1)).unwrap();
        bus.sends("5FC: 04 0E 01 01 01");
        bus.hears("5FB: 04 8E E7 03");
        bus.tells("slave 63: response");
    }
}

/// The application need not know of it; and without an answer the watchdog judges.
#[test]
fn the_application_goes_before_the_question_whose_a_slave_is() {
    let mut bus = verifying();
    let vendor = AttributeRequest::get(ClassId::IDENTITY, InstanceId(1), AttributeId(1));
    bus.command(|master, now| master.request_attribute(now, mac(63), &vendor, 1)).unwrap();
    bus.sends("5FC: 04 0E 01 01 01");
    bus.hears("5FB: 44 94 0C 01");
    bus.is(63, SlaveState::Running, ScannerStatus::NORMAL);
    bus.hears("5FB: 04 8E E7 03");
    bus.tells("slave 63: response");

    let mut bus = verifying();
    bus.wait(320);
    bus.tells("slave 63: Running -> Waiting: timed out");
}

/// Slave 63 was reached through the UCMM and runs; somebody else polls it.
#[track_caller]
fn verifying_by_ucmm() -> Bus {
    let config = Config {
        first_contact: FirstContact::Ucmm,
        interscan_delay: core::time::Duration::from_secs(60),
        ..config()
    };
    let mut bus = Bus::online(config, &[super::bus::polled()]);
    for (request, response) in [
        ("784: 3F 4B 02 34", "77F: 04 CB 00 04 06 00"),
        ("704: 7F 0E 01 01 01", "73F: 44 8E E7 03"),
        ("704: 3F 0E 01 01 02", "73F: 04 8E 07 00"),
        ("704: 7F 0E 01 01 03", "73F: 44 8E 2A 00"),
        ("704: 3F 4B 03 01 02 04", "73F: 04 CB 00"),
        ("704: 7F 0E 05 02 07", "73F: 44 8E 02 00"),
        ("704: 3F 0E 05 02 08", "73F: 04 8E 01 00"),
        ("704: 7F 10 05 02 09 4B 00", "73F: 44 90 50 00"),
        ("784: 3F 4C 06 00", "77F: 04 CC"),
    ] {
        bus.sends(request);
        bus.hears(response);
    }
    bus.is(63, SlaveState::Running, ScannerStatus::NORMAL);
    bus.events.clear();
    bus.sends("5FD:");
    bus.hears("3FF: 34 12");
    bus.hears("5FD: 77");
    bus.sends("784: 7F 4B 02 34");
    bus
}

/// It may have no unconnected port; and the allocation of another over its connection was not heard.
#[test]
fn a_slave_behind_the_ucmm_that_another_polls_is_asked_whose_it_is() {
    let mut bus = verifying_by_ucmm();
    bus.hears("77F: 44 CB 00 04 07 00");
    bus.sends("704: 3F 0E 03 01 05");
    bus.hears("73F: 04 8E 02 05");
    bus.tells("slave 63: Running -> Waiting: owned by another master");
    bus.is(63, SlaveState::Waiting, ScannerStatus::INITIALISATION_REFUSED);
    bus.sends("784: 7F 4C 07 00");
    bus.hears("77F: 44 CC");
    bus.wait(900);
    bus.sends_nothing();
    bus.wait(100);
    bus.sends("784: 3F 4B 02 34");
}

/// Nobody's is left to the watchdog. What the slave does not tell is no reason to give it up.
#[test]
fn a_slave_behind_the_ucmm_that_is_this_masters_runs_on() {
    for answer in ["8E 02 04", "8E 00 FF", "8E 05", "94 14 FF"] {
        let mut bus = verifying_by_ucmm();
        bus.hears("77F: 44 CB 00 04 07 00");
        bus.sends("704: 3F 0E 03 01 05");
        bus.hears(&std::format!("73F: 04 {answer}"));
        bus.sends("784: 7F 4C 07 00");
        bus.hears("77F: 44 CC");
        bus.is(63, SlaveState::Running, ScannerStatus::NORMAL);
        // The next poll of the other is another reason to ask.
        bus.hears("5FD: 77");
        bus.sends("784: 3F 4B 02 34");
        // It has no connection left.
        bus.hears("77F: 04 94 02 FF");
        bus.is(63, SlaveState::Running, ScannerStatus::NORMAL);
        bus.sends_nothing();
    }
}

/// The connection that was opened for the question is that of the application's request, and closed after it, even if the
/// request cannot be sent.
#[test]
fn the_application_goes_before_the_question_whose_a_slave_behind_the_ucmm_is() {
    let vendor = AttributeRequest::get(ClassId::IDENTITY, InstanceId(1), AttributeId(1));
    let mut bus = verifying_by_ucmm();
    bus.hears("77F: 44 CB 00 04 07 00");
    bus.sends("704: 3F 0E 03 01 05");
    bus.command(|master, now| master.request_attribute(now, mac(63), &vendor, 1)).unwrap();
    bus.sends("704: 7F 0E 01 01 01");
    bus.hears("73F: 04 8E 02 05");
    bus.is(63, SlaveState::Running, ScannerStatus::NORMAL);
    bus.hears("73F: 44 8E E7 03");
    bus.tells("slave 63: response");
    bus.sends("784: 3F 4C 07 00");

    let mut bus = verifying_by_ucmm();
    bus.hears("77F: 44 CB 00 04 07 00");
    bus.sends("704: 3F 0E 03 01 05");
    let long = AttributeRequest::set(ClassId::IDENTITY, InstanceId(1), AttributeId(1), &[0; 40]);
    bus.command(|master, now| master.request_attribute(now, mac(63), &long, 1)).unwrap_err();
    bus.sends("784: 7F 4C 07 00");

    // Before it is open, the request has one of its own.
    let mut bus = verifying_by_ucmm();
    bus.command(|master, now| master.request_attribute(now, mac(63), &vendor, 1)).unwrap();
    bus.sends("784: 3F 4B 02 34");
}

/// Without an answer the watchdog judges, and the connection is closed.
#[test]
fn a_slave_behind_the_ucmm_that_does_not_say_whose_it_is() {
    let mut bus = verifying_by_ucmm();
    bus.hears("77F: 44 CB 00 04 07 00");
    for _ in 0..2 {
        bus.sends("704: 3F 0E 03 01 05");
        for _ in 0..25 {
            bus.hears("3FF: 34 12");
            bus.wait(100);
        }
    }
    bus.sends("784: 7F 4C 07 00");
    bus.is(63, SlaveState::Running, ScannerStatus::NORMAL);
    bus.wait(320);
    bus.tells("slave 63: Running -> Waiting: timed out");
}

/// Its polls are answered, and nobody is at the door through which it was brought up: it may be another device, with another door.
#[test]
fn a_slave_whose_door_stays_closed_is_brought_up_anew() {
    let mut bus = verifying_by_ucmm();
    for tries in 1..=2 {
        for _ in 0..10 {
            bus.hears("3FF: 34 12");
            bus.is(63, SlaveState::Running, ScannerStatus::NORMAL);
            bus.wait(100);
        }
        if tries == 1 {
            bus.sends("784: 7F 4B 02 34");
        }
    }
    bus.tells("slave 63: Running -> Waiting: timed out");
}

/// Two masters ask the same slave in the same bit: their requests would destroy each other until both are off the bus.
#[test]
fn a_request_that_collides_with_another_masters_is_sent_later() {
    let mut bus = Bus::online(config(), &[super::bus::polled()]);
    bus.input(Input::Link(LinkEvent::BusError(BusErrorKind::Ack)));
    assert_eq!(bus.withdrawn, [], "a missing acknowledge is no collision");
    // 10 ms, and ten times its MAC ID; then three times as much of that.
    for pause in [50, 130] {
        bus.input(Input::Link(LinkEvent::BusError(BusErrorKind::Bit)));
        bus.input(Input::Link(LinkEvent::BusError(BusErrorKind::Bit)));
        assert_eq!(bus.withdrawn.split_off(0), [TxToken(0x1003)], "once");
        bus.takes();
        bus.input(Input::TxDone(TxToken(0x1003), TxOutcome::Withdrawn));
        bus.wait(pause - 1);
        bus.sends_nothing();
        bus.wait(1);
    }
    // It was on the bus before it could be taken back: what follows from it does.
    bus.input(Input::Link(LinkEvent::BusError(BusErrorKind::Bit)));
    bus.sends("5FE: 04 4B 03 01 01 04");
    bus.hears("5FB: 04 CB 00");
    bus.sends("5FC: 44 10 05 01 0C 03");
    assert_eq!(bus.master.counters().collisions, 3);
    // What only this master sends is left to the controller, which repeats it.
    bus.withdrawn.clear();
    bus.hears("5FB: 44 90");
    bus.input(Input::Link(LinkEvent::BusError(BusErrorKind::Bit)));
    assert_eq!(bus.withdrawn, []);
    bus.sends("5FC: 04 0E 01 01 01");
}
