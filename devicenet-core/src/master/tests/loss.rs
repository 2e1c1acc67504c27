//! Slaves that are lost or removed while frames to them are on their way, and masters that lose their place.

use core::time::Duration;

use link_core::{BusErrorKind, Input, LinkEvent, TxOutcome, TxToken};

use super::super::*;
use super::bus::{Bus, config, frame, mac, polled};
use super::io::{cos, entry, running};

fn polled_every(number: u8, expected_packet_rate: u16) -> ScanEntry {
    let poll = PollConnection { produce: 1, consume: 1, expected_packet_rate };
    ScanEntry { poll: Some(poll), ..ScanEntry::explicit_only(mac(number)) }
}

/// Slaves 10 and 20, both running.
#[track_caller]
fn two_running(rates: [u16; 2]) -> Bus {
    let entries = [polled_every(10, rates[0]), polled_every(20, rates[1])];
    let config = Config { deferred_delete: false, interscan_delay: Duration::from_secs(60), ..config() };
    let mut bus = Bus::online(config, &entries);
    bus.answers_everything(&entries);
    bus
}

/// The turn of a slave comes at the very moment at which it is lost: it gets no outputs.
#[test]
fn a_slave_that_is_lost_is_passed_over() {
    let mut bus = Bus::online(
        Config { deferred_delete: false, ..config() },
        &[polled_every(10, 0), polled_every(20, 75)],
    );
    bus.answers_everything(&[polled_every(10, 0), polled_every(20, 75)]);
    while bus.try_sends("455:") || bus.try_sends("4A5:") {}
    bus.wait(10);
    let began = bus.now;
    // The poll of slave 10 waits for the bus until slave 20 is lost.
    bus.now = began + Duration::from_millis(300);
    bus.sends("455:");
    assert_eq!(bus.master.state(mac(20)), Some(SlaveState::Contacting));
    assert_eq!(bus.in_flight_ids(), [0x4A6], "contacted, not polled");
}

/// A poll that waits for the bus when its slave is lost is taken back.
#[test]
fn outputs_on_their_way_to_a_lost_slave_are_withdrawn() {
    let mut bus = Bus::running(config());
    bus.wait(320);
    assert_eq!(bus.master.state(mac(63)), Some(SlaveState::Contacting));
    assert_eq!(bus.withdrawn, [TxToken(0x1002)]);
    bus.input(Input::TxDone(TxToken(0x1002), TxOutcome::Withdrawn));
    assert_eq!(bus.master.counters().not_sent, 1);
    assert_eq!(bus.withdrawn.len(), 1, "told once");
}

/// The same for output data outside of the scan; the first message after the slave is back begins with its first
/// fragment, though the withdrawn one may still be in the controller.
#[test]
fn a_stale_fragment_does_not_tear_the_next_message() {
    let mut entry = ScanEntry { change_of_state: Some(cos(true, 9)), ..entry() };
    entry.key = ElectronicKey::default();
    let mut bus = running(entry);
    bus.sends("455:");
    bus.command(|master, _| master.set_run(true));
    bus.sends("455: 00 00 00 00 00 00 00 00");
    bus.command(|master, now| master.restart_slave(now, mac(10))).unwrap();
    assert_eq!(bus.withdrawn, [TxToken(0x1001)]);
    let (stale, _) = bus.takes();
    bus.wait(0);
    bus.answers_everything(&[entry]);
    bus.sends_nothing();
    bus.input(Input::TxDone(stale, TxOutcome::Sent));
    bus.sends("455: 00 00 00 00 00 00 00 00");
    bus.sends("455: 81 00 00");
}

/// Removing or adding others leaves the scan where it is; the response of a removed slave is not waited for.
#[test]
fn the_scan_survives_changes_of_the_list() {
    let mut bus = two_running([0, 0]);
    while bus.try_sends("455:") || bus.try_sends("4A5:") {}
    bus.wait(60_000);
    bus.command(|master, now| master.add_slave(now, ScanEntry::explicit_only(mac(5)))).unwrap();
    bus.sends("455:");
    bus.wait(0);
    bus.sends("4A5:");
    bus.sends("42E: 04 4B 03 01 01 04");
    assert_eq!(bus.master.slave_counters(mac(20)).unwrap().commands, 2);
    // A poll of slave 10 is in flight while it is removed: it is taken back, and slave 20 is polled.
    bus.wait(60_000);
    bus.command(|master, _| master.remove_slave(mac(10))).unwrap();
    assert!(bus.withdrawn.contains(&TxToken(0x1002)));
    bus.input(Input::TxDone(TxToken(0x1002), TxOutcome::Withdrawn));
    assert!(bus.in_flight_ids().contains(&0x4A5));
}

/// Slave 63 joins the list while the device at MAC ID 63 is looked at, and leaves it again: the answer of the port goes
/// to who handed the frame out.
#[test]
fn the_look_at_63_is_not_taken_for_slave_63() {
    let key = ElectronicKey { vendor: Some(1.into()), product_code: Some(1), ..ElectronicKey::default() };
    let missing = ScanEntry { key, replaceable: true, ..ScanEntry::explicit_only(mac(10)) };
    let mut bus = Bus::online(Config { replacement: ReplacementMode::On, ..config() }, &[missing]);
    for request in ["456: 04 4B 03 01 01 04", "784: 4A 4B 02 34"] {
        for _ in 0..2 {
            bus.sends(request);
            bus.wait(1000);
        }
    }
    let (token, look) = bus.takes();
    assert_eq!(look, frame("5FE: 04 4B 03 01 01 04"));
    bus.command(|master, now| master.add_slave(now, polled())).unwrap();
    bus.input(Input::TxDone(token, TxOutcome::Sent));
    bus.wait(0);
    // Now slave 63 itself is contacted; when it is removed, the look goes on.
    bus.sends("5FE: 04 4B 03 01 01 04");
    bus.command(|master, _| master.remove_slave(mac(63))).unwrap();
    for _ in 0..200 {
        bus.try_sends("456: 44 4B 03 01 01 04");
        if bus.try_sends("5FE: 44 4B 03 01 01 04") {
            return;
        }
        bus.try_sends("456: 04 4B 03 01 01 04");
        bus.try_sends("784: 4A 4B 02 34");
        bus.try_sends("784: 0A 4B 02 34");
        bus.wait(100);
    }
    panic!("nobody looks any more");
}

/// With an expected packet rate of 0 silence proves nothing; a check that nobody objects to does.
#[test]
fn a_slave_without_time_out_that_starts_anew_is_noticed() {
    let check = "457: 00 E7 03 44 33 22 11";
    let make = || running(polled_every(10, 0));
    let mut bus = make();
    bus.hears(check);
    bus.wait(1000);
    bus.hears(check);
    bus.wait(1004);
    bus.is(10, SlaveState::Running, ScannerStatus::NORMAL);
    bus.wait(1);
    bus.tells("slave 10: Running -> Waiting: duplicate MAC ID check heard");

    // It was a newcomer's: the slave objects, or goes on sending.
    for objection in ["457: 80 E7 03 45 33 22 11", "3CA: 01"] {
        let mut bus = make();
        bus.hears(check);
        bus.hears(objection);
        bus.wait(60_000);
        bus.is(10, SlaveState::Running, ScannerStatus::NORMAL);
    }
}

/// A slave that comes up while an attempt is under way would answer neither this nor the next request of it. It is
/// contacted when it is on line, and is not punished for the attempts before.
#[test]
fn a_check_heard_while_the_slave_is_contacted_ends_the_attempt() {
    let mut bus = Bus::online(config(), &[polled()]);
    for _ in 0..4 {
        for request in ["5FE: 04 4B 03 01 01 04", "784: 7F 4B 02 34"] {
            for _ in 0..2 {
                bus.sends(request);
                bus.wait(1000);
            }
        }
        while bus.master.state(mac(63)) == Some(SlaveState::Waiting) {
            bus.wait(100);
        }
    }
    bus.sends("5FE: 04 4B 03 01 01 04");
    for _ in 0..2 {
        bus.hears("5FF: 00 E7 03 44 33 22 11");
        bus.is(63, SlaveState::Waiting, ScannerStatus::NOT_FOUND);
        bus.wait(1000);
        bus.sends_nothing();
    }
    bus.wait(5);
    bus.sends("5FE: 44 4B 03 01 01 04");
    // Somebody objects, so somebody is on line: it may answer.
    bus.hears("5FF: 80 E7 03 45 33 22 11");
    bus.hears("5FB: 44 CB 00");
    bus.is(63, SlaveState::Configuring, ScannerStatus::INITIALISING);
}

/// What was allocated is gone with a restart; a slave that objects to a newcomer's check, or answers, has not restarted.
#[test]
fn a_slave_that_restarts_while_it_is_configured_is_contacted_anew() {
    let check = "5FF: 00 E7 03 44 33 22 11";
    let configuring = || {
        let mut bus = Bus::online(config(), &[polled()]);
        bus.sends("5FE: 04 4B 03 01 01 04");
        bus.hears("5FB: 04 CB 00");
        bus.sends("5FC: 44 10 05 01 0C 03");
        bus
    };
    let mut bus = configuring();
    for _ in 0..2 {
        bus.hears(check);
        bus.wait(1000);
        bus.sends_nothing();
    }
    bus.wait(5);
    bus.tells("slave 63: Configuring -> Waiting: duplicate MAC ID check heard");
    bus.sends("5FE: 04 4B 03 01 01 04");

    for alive in ["5FF: 80 E7 03 45 33 22 11", "5FB: 44 90"] {
        let mut bus = configuring();
        bus.hears(check);
        bus.hears(alive);
        bus.wait(1005);
        bus.is(63, SlaveState::Configuring, ScannerStatus::INITIALISING);
    }
}

/// The master's own MAC ID changes: everything that names it does.
#[test]
fn another_mac_id_of_its_own() {
    let mut bus = Bus::running(config());
    let refused = bus.command(|master, now| master.set_mac_id(now, mac(63)));
    assert_eq!(refused, Err(CommandError::ScanList(ScanListError::AlreadyListed(mac(63)))));
    bus.command(|master, now| master.set_mac_id(now, mac(5))).unwrap();
    bus.tells("slave 63: Running -> Offline: master off line");
    bus.input(Input::TxDone(TxToken(0x1002), TxOutcome::Withdrawn));
    for _ in 0..2 {
        bus.sends("42F: 00 34 12 45 23 00 00");
        bus.wait(1000);
    }
    bus.sends("5FE: 45 4B 03 01 01 05");
    bus.hears("5FB: 45 CB 00");
    bus.is(63, SlaveState::Configuring, ScannerStatus::INITIALISING);
    assert!(bus.master.filter().accepts(&frame("42F: 00 34 12 45 23 00 00")));
}

/// A tool repairs a faulted master, and gives it the MAC ID of a slave: that one is left out.
#[test]
fn a_faulted_master_is_repaired_by_a_tool() {
    let mut bus = Bus::online(config(), &[polled(), polled_every(10, 75)]);
    bus.hears("427: 80 34 12 99 99 00 00");
    assert_eq!(bus.master.own_status(), ScannerStatus::DUPLICATE_MAC_ID);
    assert!(bus.master.filter().accepts(&frame("7ED: 3F 4B 03")));
    let (token, _) = bus.takes();
    bus.input(Input::TxDone(token, TxOutcome::Withdrawn));
    bus.hears("7ED: 0A 4D 34 12 45 23 00 00");
    for _ in 0..2 {
        bus.sends("457: 00 34 12 45 23 00 00");
        bus.wait(1000);
    }
    bus.is(10, SlaveState::Offline, ScannerStatus::ILLEGAL_SCAN_LIST);
    bus.is(63, SlaveState::Contacting, ScannerStatus::INITIALISING);
    bus.command(|master, now| master.reset(now));
    bus.is(63, SlaveState::Offline, ScannerStatus::INITIALISING);
}

#[test]
fn the_scanners_own_status() {
    let mut bus = Bus::checking(config(), &[]);
    assert_eq!(bus.master.own_status(), ScannerStatus::INITIALISING);
    bus.input(Input::Link(LinkEvent::BusError(BusErrorKind::Ack)));
    assert_eq!(bus.master.own_status(), ScannerStatus::TRANSMIT_FAILED);
    bus.input(Input::Link(LinkEvent::Down));
    assert_eq!(bus.master.own_status(), ScannerStatus::NO_NETWORK_POWER);
    let mut bus = Bus::online(config(), &[]);
    assert_eq!(bus.master.own_status(), ScannerStatus::NO_TRAFFIC);
    bus.hears("3C5: 01");
    assert_eq!(bus.master.own_status(), ScannerStatus::NO_DIRECT_TRAFFIC);
    bus.command(|master, now| master.add_slave(now, polled())).unwrap();
    assert_eq!(bus.master.own_status(), ScannerStatus::SCANNER_IDLE);
    bus.command(|master, _| master.set_run(true));
    assert_eq!(bus.master.own_status(), ScannerStatus::NORMAL);
    bus.input(Input::Link(LinkEvent::BusOff));
    assert_eq!(bus.master.own_status(), ScannerStatus::BUS_OFF);
}

/// It is over ten seconds after the last loss, and goes before idle and normal.
#[test]
fn frames_that_the_controller_lost_are_a_status_for_a_while() {
    let mut bus = Bus::checking(config(), &[polled()]);
    let lost = Input::Link(LinkEvent::Overrun { lost: 3 });
    bus.input(lost);
    assert_eq!(bus.master.own_status(), ScannerStatus::INITIALISING);
    let mut bus = Bus::running(config());
    bus.input(lost);
    assert_eq!(bus.master.own_status(), ScannerStatus::DATA_OVERRUN);
    bus.is(63, SlaveState::Running, ScannerStatus::NORMAL);
    assert_eq!(bus.master.access().counters().frames_lost, 3);
    bus.command(|master, _| master.set_run(true));
    bus.wait(6000);
    bus.input(Input::Link(LinkEvent::Overrun { lost: 0 }));
    bus.wait(9999);
    assert_eq!(bus.master.own_status(), ScannerStatus::DATA_OVERRUN);
    bus.wait(1);
    assert_eq!(bus.master.own_status(), ScannerStatus::NORMAL);
    bus.input(lost);
    bus.input(Input::Link(LinkEvent::Down));
    assert_eq!(bus.master.own_status(), ScannerStatus::NO_NETWORK_POWER);
    bus.input(Input::Link(LinkEvent::Up));
    assert_eq!(bus.master.own_status(), ScannerStatus::INITIALISING);
    for _ in 0..2 {
        while !bus.try_sends("427: 00 34 12 45 23 00 00") {
            bus.takes();
        }
        bus.wait(1000);
    }
    assert_eq!(bus.master.own_status(), ScannerStatus::NORMAL);
}

/// A controller that gives everything back makes no storm, even of a scan without pauses.
#[test]
fn a_controller_that_gives_everything_back() {
    let quick = Config {
        deferred_delete: false,
        interscan_delay: Duration::ZERO,
        response_wait: Duration::ZERO,
        ..config()
    };
    let mut bus = Bus::online(quick, &[polled_every(10, 0)]);
    bus.answers_everything(&[polled_every(10, 0)]);
    let began = bus.now;
    for _ in 0..20 {
        while bus.in_flight_ids().is_empty() {
            bus.wait(1);
        }
        bus.drops("455:");
        bus.sends_nothing();
    }
    assert!(bus.now.saturating_since(began) >= Duration::from_millis(19));
    let counters = bus.master.slave_counters(mac(10)).unwrap();
    assert_eq!((counters.commands, counters.missed), (0, 0));
}

/// A clock that steps back, and one that comes late, are borne.
#[test]
fn clocks_that_step_back_or_come_late() {
    let mut bus = Bus::running(config());
    bus.sends("5FD:");
    bus.hears("3FF: 34 12");
    let now = bus.now;
    bus.now = now.saturating_sub(Duration::from_secs(1));
    bus.input(Input::Tick);
    bus.now = now + Duration::from_secs(3600);
    bus.input(Input::Tick);
    bus.tells("slave 63: Running -> Waiting: timed out");
    assert!(bus.in_flight_ids().contains(&0x5FE));
}
