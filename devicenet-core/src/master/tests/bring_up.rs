//! From the first contact to established connections, and every way in which that can end.

use std::string::ToString;

use cip_core::identity::Revision;

use super::super::*;
use super::bus::{Bus, config, mac, polled};

#[test]
fn the_worked_trace() {
    let mut bus = Bus::online(config(), &[polled()]);
    bus.is(63, SlaveState::Contacting, ScannerStatus::INITIALISING);
    bus.brings_up_63();
    bus.is(63, SlaveState::Running, ScannerStatus::NORMAL);
    bus.tells("slave 63: Contacting -> Configuring: explicit connection");
    bus.tells("slave 63: Configuring -> Running: connections established");
    bus.command(|master, _| {
        master.set_run(true);
        master.set_output(mac(63), &[0x03]).unwrap();
    });
    // The first scan began idle, before the application said run.
    bus.sends("5FD:");
    bus.hears("3FF: 34 12");
    assert_eq!(bus.master.input_data(mac(63), IoInstance::Poll), Some(&[0x34, 0x12][..]));
    bus.wait(10);
    bus.sends("5FD: 03");
    bus.hears("3FF: 34 12");
    bus.command(|master, _| master.set_run(false));
    bus.wait(10);
    bus.sends("5FD:");
    bus.hears("3FF: 34 12");
    bus.is(63, SlaveState::Running, ScannerStatus::NORMAL);
}

#[test]
fn a_slave_that_answers_on_neither_door_is_not_found() {
    let mut bus = Bus::online(config(), &[polled()]);
    bus.sends("5FE: 04 4B 03 01 01 04");
    bus.wait(1000);
    bus.sends("5FE: 04 4B 03 01 01 04");
    bus.wait(1000);
    bus.sends("784: 7F 4B 02 34");
    bus.wait(1000);
    bus.sends("784: 7F 4B 02 34");
    bus.wait(999);
    bus.is(63, SlaveState::Contacting, ScannerStatus::INITIALISING);
    bus.wait(1);
    bus.is(63, SlaveState::Waiting, ScannerStatus::NOT_FOUND);
    bus.sends_nothing();
}

/// The pauses double up to the longest; a duplicate MAC ID check of the slave ends them.
#[test]
fn pauses_grow_until_the_slave_is_heard() {
    let mut bus = Bus::online(config(), &[polled()]);
    let mut pauses = std::vec::Vec::new();
    for _ in 0..7 {
        for _ in 0..2 {
            bus.sends("5FE: 04 4B 03 01 01 04");
            bus.wait(1000);
        }
        for _ in 0..2 {
            bus.sends("784: 7F 4B 02 34");
            bus.wait(1000);
        }
        bus.is(63, SlaveState::Waiting, ScannerStatus::NOT_FOUND);
        let began = bus.now;
        while bus.master.state(mac(63)) == Some(SlaveState::Waiting) {
            bus.wait(100);
        }
        pauses.push(bus.now.saturating_since(began).as_secs());
    }
    assert_eq!(pauses, [1, 2, 4, 8, 16, 16, 16]);
}

#[test]
fn a_check_that_was_heard_ends_the_pause() {
    let mut bus = Bus::online(config(), &[polled()]);
    for request in ["5FE: 04 4B 03 01 01 04", "784: 7F 4B 02 34"] {
        for _ in 0..2 {
            bus.sends(request);
            bus.wait(1000);
        }
    }
    bus.wait(500);
    bus.hears("5FF: 00 E7 03 44 33 22 11");
    bus.tells("slave 63: Waiting -> Waiting: duplicate MAC ID check heard");
    bus.wait(1004);
    bus.sends_nothing();
    bus.wait(1);
    bus.sends("5FE: 04 4B 03 01 01 04");
}

/// Slaves that come up together with the master are asked when they are on line, not before.
#[test]
fn a_check_heard_while_the_master_checks_itself_is_waited_for() {
    let mut bus = Bus::checking(config(), &[polled()]);
    bus.sends("427: 00 34 12 45 23 00 00");
    bus.wait(1000);
    bus.sends("427: 00 34 12 45 23 00 00");
    bus.wait(50);
    bus.hears("5FF: 00 E7 03 44 33 22 11");
    bus.wait(950);
    assert!(bus.master.access().is_online());
    bus.is(63, SlaveState::Waiting, ScannerStatus::INITIALISING);
    bus.sends_nothing();
    bus.wait(55);
    bus.sends("5FE: 04 4B 03 01 01 04");
}

#[test]
fn connections_of_an_earlier_life_are_released() {
    let mut bus = Bus::online(config(), &[polled()]);
    bus.sends("5FE: 04 4B 03 01 01 04");
    bus.hears("5FB: 04 94 0B 02");
    bus.sends("5FE: 44 4C 03 01 03");
    bus.hears("5FB: 44 CC");
    bus.sends("5FE: 04 4B 03 01 01 04");
    bus.hears("5FB: 04 CB 00");
    bus.is(63, SlaveState::Configuring, ScannerStatus::INITIALISING);
}

#[test]
fn a_release_that_is_refused_is_done_bit_by_bit() {
    let mut bus = Bus::online(config(), &[polled()]);
    bus.sends("5FE: 04 4B 03 01 01 04");
    bus.hears("5FB: 04 94 0B 02");
    bus.sends("5FE: 44 4C 03 01 03");
    bus.hears("5FB: 44 94 0B 02");
    bus.sends("5FE: 04 4C 03 01 01");
    bus.hears("5FB: 04 CC");
    bus.sends("5FE: 44 4C 03 01 02");
    bus.hears("5FB: 44 94 0B 02");
    bus.sends("5FE: 04 4B 03 01 01 04");
    bus.hears("5FB: 04 94 0B 02");
    bus.is(63, SlaveState::Waiting, ScannerStatus::INITIALISATION_REFUSED);
}

#[test]
fn a_slave_of_another_master_is_left_alone() {
    let mut bus = Bus::online(config(), &[polled()]);
    bus.sends("5FE: 04 4B 03 01 01 04");
    bus.hears("5FB: 04 94 0C 01");
    bus.tells("slave 63: Contacting -> Waiting: owned by another master");
    bus.is(63, SlaveState::Waiting, ScannerStatus::INITIALISATION_REFUSED);
    bus.sends_nothing();
}

/// No outputs for the wrong device: it is released, of the connections those that there are, and the poll is never sent.
#[test]
fn a_slave_that_does_not_match_the_key() {
    for (steps, response, told, cause) in [
        (2, "8E E8 03", "not as expected: vendor 1000, the scan list says 999", "electronic key mismatch"),
        (3, "8E 08 00", "not as expected: device type 8, the scan list says 7", "electronic key mismatch"),
        (4, "8E 2B 00", "not as expected: product code 43, the scan list says 42", "electronic key mismatch"),
        (2, "8E E7", "not as expected: vendor not told, the scan list says 999", "electronic key mismatch"),
        (5, "8E 02 02", "not as expected: revision 2.2, the scan list says 1.2", "electronic key mismatch"),
        (5, "8E 01 01", "not as expected: revision 1.1, the scan list says 1.2", "electronic key mismatch"),
        (2, "94 14 FF", "refused: error 0x14 Attribute not supported", "refused"),
    ] {
        let revision = (steps == 5).then_some(Revision { major: 1, minor: 2 });
        let key = ElectronicKey { revision, ..polled().key };
        let mut bus = Bus::online(config(), &[ScanEntry { key, ..polled() }]);
        let script = [
            ("5FE: 04 4B 03 01 01 04", "CB 00"),
            ("5FC: 44 10 05 01 0C 03", "90"),
            ("5FC: 04 0E 01 01 01", "8E E7 03"),
            ("5FC: 44 0E 01 01 02", "8E 07 00"),
            ("5FC: 04 0E 01 01 03", "8E 2A 00"),
            ("5FC: 44 0E 01 01 04", "8E 01 02"),
        ];
        for (place, (request, answer)) in script.iter().enumerate().take(steps + 1) {
            bus.sends(request);
            let answer = if place == steps { response } else { answer };
            bus.hears(&std::format!("5FB: {} {answer}", &request[5..7]));
        }
        bus.tells(&std::format!("slave 63: {told}"));
        bus.tells(&std::format!("slave 63: Configuring -> Waiting: {cause}"));
        let status = if cause == "refused" {
            ScannerStatus::INITIALISATION_REFUSED
        } else {
            ScannerStatus::WRONG_DEVICE
        };
        bus.is(63, SlaveState::Waiting, status);
        let xid = if steps % 2 == 0 { "44" } else { "04" };
        bus.sends(&std::format!("5FE: {xid} 4C 03 01 01"));
        bus.hears(&std::format!("5FB: {xid} CC"));
        bus.command(|master, _| master.set_run(true));
        bus.wait(900);
        bus.sends_nothing();
    }
}

#[test]
fn sizes_that_differ_from_the_scan_list() {
    for (steps, answer, told) in [
        (6, "8E 03 00", "bytes produced by poll 3, the scan list says 2"),
        (7, "8E 02 00", "bytes consumed by poll 2, the scan list says 1"),
    ] {
        let mut bus = Bus::online(config(), &[polled()]);
        let script = [
            ("5FE: 04 4B 03 01 01 04", "CB 00"),
            ("5FC: 44 10 05 01 0C 03", "94 09 FF"),
            ("5FC: 04 0E 01 01 01", "8E E7 03"),
            ("5FC: 44 0E 01 01 02", "8E 07 00"),
            ("5FC: 04 0E 01 01 03", "8E 2A 00"),
            ("5FC: 44 4B 03 01 02 04", "CB 00"),
            ("5FC: 04 0E 05 02 07", "8E 02 00"),
            ("5FC: 44 0E 05 02 08", "8E 01 00"),
        ];
        for (place, (request, good)) in script.iter().enumerate().take(steps + 1) {
            bus.sends(request);
            let answer = if place == steps { answer } else { good };
            bus.hears(&std::format!("5FB: {} {answer}", &request[5..7]));
        }
        bus.tells(&std::format!("slave 63: not as expected: {told}"));
        bus.is(63, SlaveState::Waiting, ScannerStatus::SIZE_MISMATCH);
    }
}

/// A Set response without the value that the slave uses: the value that was sent counts.
#[test]
fn a_slave_that_does_not_tell_its_packet_rate() {
    let mut bus = Bus::online(config(), &[polled()]);
    bus.sends("5FE: 04 4B 03 01 01 04");
    bus.hears("5FB: 04 CB 00");
    let answers = ["90", "8E E7 03", "8E 07 00", "8E 2A 00", "CB 00", "94 14 FF", "94 14 FF", "90"];
    let requests = [
        "5FC: 44 10 05 01 0C 03",
        "5FC: 04 0E 01 01 01",
        "5FC: 44 0E 01 01 02",
        "5FC: 04 0E 01 01 03",
        "5FC: 44 4B 03 01 02 04",
        "5FC: 04 0E 05 02 07",
        "5FC: 44 0E 05 02 08",
        "5FC: 04 10 05 02 09 4B 00",
    ];
    for (request, answer) in requests.iter().zip(answers) {
        bus.sends(request);
        bus.hears(&std::format!("5FB: {} {answer}", &request[5..7]));
    }
    bus.is(63, SlaveState::Running, ScannerStatus::NORMAL);
    // Four times 75 ms, from the moment at which it was established.
    bus.wait(299);
    bus.is(63, SlaveState::Running, ScannerStatus::NORMAL);
    bus.wait(1);
    assert_eq!(bus.master.status(mac(63)), Some(ScannerStatus::STOPPED_COMMUNICATING));
}

/// IAI controller capture: the UCMM opens a connection with 16/16 addressing; closed before the I/O starts.
#[test]
fn a_slave_behind_the_ucmm() {
    let mut config = config();
    config.first_contact = FirstContact::Ucmm;
    let entry = ScanEntry { key: ElectronicKey::default(), ..polled() };
    let mut bus = Bus::online(config, &[entry]);
    for (request, response) in [
        ("784: 3F 4B 02 34", "77F: 04 CB 02 04 06 00"),
        ("704: 7F 0E 01 00 01 00 01", "73F: 44 8E BB 02"),
        ("704: 3F 0E 01 00 01 00 02", "73F: 04 8E 00 00"),
        ("704: 7F 0E 01 00 01 00 03", "73F: 44 8E 01 00"),
        ("704: 3F 4B 03 00 01 00 02 04", "73F: 04 CB 02"),
        ("704: 7F 0E 05 00 02 00 07", "73F: 44 8E 02 00"),
        ("704: 3F 0E 05 00 02 00 08", "73F: 04 8E 01 00"),
        ("704: FF 00 10 05 00 02 00 09", "73F: C4 C0 00"),
        ("704: FF 81 4B 00", "73F: C4 C1 00"),
    ] {
        bus.sends(request);
        bus.hears(response);
    }
    bus.hears("73F: 44 90 4B 00");
    bus.sends("784: 3F 4C 06 00");
    bus.hears("77F: 04 CC");
    bus.is(63, SlaveState::Running, ScannerStatus::NORMAL);
}

#[test]
fn attribute_writes_go_before_the_packet_rate() {
    let mut bus = Bus::checking(config(), &[polled()]);
    let long = [0; 30];
    let write = |class: u16, attribute: u16, value| AttributeWrite {
        class: class.into(),
        instance: 1.into(),
        attribute: attribute.into(),
        value,
    };
    bus.command(|master, _| {
        master.set_configuration(mac(63), &[write(0x64, 1, &[7]), write(0x0F, 2, &[1, 2])]).unwrap();
        let refused = master.set_configuration(mac(63), &[write(0x64, 1, &long)]);
        assert_eq!(refused, Err(ScanListError::TooManyWrites(32)));
    });
    bus.sends("427: 00 34 12 45 23 00 00");
    bus.wait(1000);
    bus.sends("427: 00 34 12 45 23 00 00");
    bus.wait(1000);
    for (request, answer) in [
        ("5FE: 04 4B 03 01 01 04", "CB 00"),
        ("5FC: 44 10 05 01 0C 03", "90"),
        ("5FC: 04 0E 01 01 01", "8E E7 03"),
        ("5FC: 44 0E 01 01 02", "8E 07 00"),
        ("5FC: 04 0E 01 01 03", "8E 2A 00"),
        ("5FC: 44 4B 03 01 02 04", "CB 00"),
        ("5FC: 04 0E 05 02 07", "8E 02 00"),
        ("5FC: 44 0E 05 02 08", "8E 01 00"),
        ("5FC: 04 10 64 01 01 07", "90"),
        ("5FC: 44 10 0F 01 02 01 02", "94 09 FF"),
    ] {
        bus.sends(request);
        bus.hears(&std::format!("5FB: {} {answer}", &request[5..7]));
    }
    bus.is(63, SlaveState::Waiting, ScannerStatus::REPLACEMENT_FAILED);
}

#[test]
fn entries_that_cannot_work_are_refused() {
    let mut master = super::bus::Scanner::new(config());
    let now = link_core::Instant::ZERO;
    let own = ScanEntry::explicit_only(mac(4));
    assert_eq!(master.add_slave(now, own), Err(ScanListError::OwnMacId(mac(4))));
    master.add_slave(now, polled()).unwrap();
    assert_eq!(master.add_slave(now, polled()), Err(ScanListError::AlreadyListed(mac(63))));
    for number in 10..13 {
        master.add_slave(now, ScanEntry::explicit_only(mac(number))).unwrap();
    }
    assert_eq!(master.add_slave(now, ScanEntry::explicit_only(mac(20))), Err(ScanListError::Full(4)));
    assert_eq!(master.remove_slave(mac(21)), Err(ScanListError::NotListed(mac(21))));
    master.remove_slave(mac(10)).unwrap();
    let poll = PollConnection { produce: 33, consume: 0, expected_packet_rate: 75 };
    let long = ScanEntry { poll: Some(poll), ..ScanEntry::explicit_only(mac(10)) };
    let refused = master.add_slave(now, long).unwrap_err();
    assert_eq!(refused.to_string(), "poll connection of 33 bytes: at most 32 fit");
    let strobe = BitStrobeConnection { produce: 9, expected_packet_rate: 75 };
    let long = ScanEntry { bit_strobe: Some(strobe), ..ScanEntry::explicit_only(mac(10)) };
    let refused = master.add_slave(now, long).unwrap_err();
    assert_eq!(refused.to_string(), "bit-strobe connection of 9 bytes: at most 8 fit");
    let change = ChangeOfStateConnection {
        cyclic: false,
        acknowledged: true,
        produce: 1,
        consume: 0,
        expected_packet_rate: 100,
        inhibit: 101,
    };
    let slow = ScanEntry { change_of_state: Some(change), ..ScanEntry::explicit_only(mac(10)) };
    assert_eq!(master.add_slave(now, slow), Err(ScanListError::InhibitTooLong { inhibit: 101, rate: 100 }));
    let listed: std::vec::Vec<u8> = master.scan_list().map(|entry| entry.mac_id.number()).collect();
    assert_eq!(listed, [11, 12, 63]);
}

/// The explicit connection is gone, the I/O of an earlier life is not: it is released first, all at once or bit by bit.
#[test]
fn io_of_an_earlier_life_is_released() {
    for one_by_one in [false, true] {
        let mut bus = Bus::online(Config { deferred_delete: false, ..config() }, &[polled()]);
        for (request, response) in [
            ("5FE: 04 4B 03 01 01 04", "5FB: 04 CB 00"),
            ("5FC: 44 0E 01 01 01", "5FB: 44 8E E7 03"),
            ("5FC: 04 0E 01 01 02", "5FB: 04 8E 07 00"),
            ("5FC: 44 0E 01 01 03", "5FB: 44 8E 2A 00"),
            ("5FC: 04 4B 03 01 02 04", "5FB: 04 94 0B 02"),
        ] {
            bus.sends(request);
            bus.hears(response);
        }
        bus.sends("5FC: 44 4C 03 01 02");
        if one_by_one {
            bus.hears("5FB: 44 94 0B 02");
            bus.sends("5FC: 04 4C 03 01 02");
            bus.hears("5FB: 04 CC");
            bus.sends("5FC: 44 4B 03 01 02 04");
        } else {
            bus.hears("5FB: 44 CC");
            bus.sends("5FC: 04 4B 03 01 02 04");
            // Once is enough.
            bus.hears("5FB: 04 94 0B 02");
            bus.is(63, SlaveState::Waiting, ScannerStatus::INITIALISATION_REFUSED);
        }
    }
}
