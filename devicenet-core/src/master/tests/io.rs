//! I/O data of every kind, and what is wrong with them.

use super::super::*;
use super::bus::{Bus, config, mac, polled};

/// Brings up slave 10 with whatever I/O it has: each request is answered with what the scan list wants.
#[track_caller]
pub(super) fn running(entry: ScanEntry) -> Bus {
    let mut bus = Bus::online(Config { deferred_delete: false, ..config() }, &[entry]);
    bus.answers_everything(&[entry]);
    bus.is(10, SlaveState::Running, ScannerStatus::NORMAL);
    bus.events.clear();
    bus
}

pub(super) fn entry() -> ScanEntry {
    ScanEntry::explicit_only(mac(10))
}

pub(super) fn cos(acknowledged: bool, consume: u16) -> ChangeOfStateConnection {
    ChangeOfStateConnection {
        cyclic: false,
        acknowledged,
        produce: 1,
        consume,
        expected_packet_rate: 100,
        inhibit: 0,
    }
}

#[test]
fn a_slave_that_falls_silent_is_lost_and_contacted_again() {
    let mut bus = Bus::running(config());
    bus.sends("5FD:");
    bus.hears("3FF: 34 12");
    // The slave said that it uses 80 ms.
    for _ in 0..31 {
        bus.wait(10);
        bus.sends("5FD:");
    }
    bus.wait(9);
    bus.is(63, SlaveState::Running, ScannerStatus::NORMAL);
    bus.wait(1);
    bus.tells("slave 63: Running -> Waiting: timed out");
    assert_eq!(bus.master.status(mac(63)), Some(ScannerStatus::STOPPED_COMMUNICATING));
    assert_eq!(bus.master.input_data(mac(63), IoInstance::Poll), None);
    bus.sends("5FE: 44 4B 03 01 01 04");
    // What it sends now is nobody's input.
    bus.hears("3FF: 34 12");
    assert_eq!(bus.master.counters().unexpected, 1);
}

#[test]
fn wrong_lengths_and_idle_slaves_have_their_status() {
    let mut bus = Bus::running(config());
    bus.command(|master, _| master.set_run(true));
    bus.sends("5FD:");
    bus.hears("3FF: 34 12");
    bus.hears("3FF: 34 12 00");
    bus.is(63, SlaveState::Running, ScannerStatus::WRONG_LENGTH);
    bus.hears("3FF:");
    bus.is(63, SlaveState::Running, ScannerStatus::SLAVE_IDLE);
    assert_eq!(bus.master.input_data(mac(63), IoInstance::Poll), Some(&[0x34, 0x12][..]));
    bus.hears("3FF: 35 12");
    bus.is(63, SlaveState::Running, ScannerStatus::NORMAL);
    let counters = bus.master.slave_counters(mac(63)).unwrap();
    assert_eq!((counters.received, counters.length_errors), (3, 1));
}

/// A message of the wrong length does not keep a slave alive.
#[test]
fn wrong_lengths_do_not_feed_the_watchdog() {
    let mut bus = Bus::running(config());
    for _ in 0..31 {
        bus.sends("5FD:");
        bus.hears("3FF: 34");
        bus.wait(10);
    }
    bus.sends("5FD:");
    bus.wait(10);
    assert_eq!(bus.master.state(mac(63)), Some(SlaveState::Contacting));
}

#[test]
fn long_data_are_fragmented_both_ways() {
    let poll = PollConnection { produce: 9, consume: 9, expected_packet_rate: 75 };
    let mut bus = running(ScanEntry { poll: Some(poll), ..entry() });
    bus.command(|master, _| {
        master.set_run(true);
        master.set_output(mac(10), &[1, 2, 3, 4, 5, 6, 7, 8, 9]).unwrap();
    });
    bus.sends("455:");
    bus.hears("3CA: 00 11 12 13 14 15 16 17");
    assert_eq!(bus.master.input_data(mac(10), IoInstance::Poll), None);
    bus.hears("3CA: 81 18 19");
    let input: Vec<u8> = (0x11..=0x19).collect();
    assert_eq!(bus.master.input_data(mac(10), IoInstance::Poll), Some(&input[..]));
    bus.wait(10);
    bus.sends("455: 00 01 02 03 04 05 06 07");
    // New data do not tear the message that is under way.
    bus.command(|master, _| master.set_output(mac(10), &[0; 9])).unwrap();
    bus.sends("455: 81 08 09");
    bus.hears("3CA: 00 11 12 13 14 15 16 17");
    bus.hears("3CA: 82 18 19");
    bus.is(10, SlaveState::Running, ScannerStatus::FRAGMENT_SEQUENCE);
    bus.wait(10);
    bus.sends("455: 00 00 00 00 00 00 00 00");
    bus.sends("455: 81 00 00");
    assert_eq!(bus.master.slave_counters(mac(10)).unwrap().fragment_errors, 1);
}

#[test]
fn one_strobe_asks_every_slave() {
    let strobe = BitStrobeConnection { produce: 1, expected_packet_rate: 75 };
    let mut bus = running(ScanEntry { bit_strobe: Some(strobe), ..entry() });
    bus.sends("420:");
    bus.hears("38A: 07");
    assert_eq!(bus.master.input_data(mac(10), IoInstance::BitStrobe), Some(&[7][..]));
    bus.command(|master, _| {
        master.set_run(true);
        master.set_strobe_bit(mac(10), true).unwrap();
    });
    bus.wait(10);
    // Bit 10 of the string.
    bus.sends("420: 00 04 00 00 00 00 00 00");
}

#[test]
fn one_multicast_poll_asks_its_group() {
    let poll = PollConnection { produce: 2, consume: 1, expected_packet_rate: 75 };
    let mut bus = running(ScanEntry { multicast_poll: Some(poll), ..entry() });
    bus.sends("421:");
    bus.hears("30A: 07 08");
    assert_eq!(bus.master.input_data(mac(10), IoInstance::MulticastPoll), Some(&[7, 8][..]));
    bus.command(|master, _| {
        master.set_run(true);
        master.set_multicast_output(&[0x55]).unwrap();
    });
    bus.wait(10);
    bus.sends("421: 55");
}

/// All slaves of the group hear one command, so they consume as many bytes of it.
#[test]
fn a_multicast_group_has_one_size() {
    let poll = |consume| PollConnection { produce: 2, consume, expected_packet_rate: 75 };
    let mut bus = Bus::online(config(), &[ScanEntry { multicast_poll: Some(poll(3)), ..entry() }]);
    let other = ScanEntry { multicast_poll: Some(poll(2)), ..ScanEntry::explicit_only(mac(11)) };
    let refused = bus.command(|master, now| master.add_slave(now, other));
    assert_eq!(refused, Err(ScanListError::GroupSize { expected: 3, found: 2 }));
    let refused = bus.command(|master, _| master.set_multicast_output(&[1, 2]));
    assert_eq!(refused, Err(CommandError::OutputLength { expected: 3, found: 2 }));
    bus.command(|master, _| master.set_multicast_output(&[1, 2, 3])).unwrap();
}

/// One instance that is not as it should be is shown until it is, whatever the others are like.
#[test]
fn the_status_is_that_of_the_worst_instance() {
    let strobe = BitStrobeConnection { produce: 1, expected_packet_rate: 75 };
    let poll = PollConnection { produce: 1, consume: 1, expected_packet_rate: 75 };
    let mut bus = running(ScanEntry { bit_strobe: Some(strobe), poll: Some(poll), ..entry() });
    bus.hears("38A: 01 02");
    bus.hears("3CA: 01");
    bus.is(10, SlaveState::Running, ScannerStatus::WRONG_LENGTH);
    bus.hears("38A: 01");
    bus.is(10, SlaveState::Running, ScannerStatus::NORMAL);
    assert_eq!(bus.events.iter().filter(|event| event.contains("status")).count(), 2);
}

/// New data while the first fragment of the old is in flight: the old message is finished, then the new one is sent.
#[test]
fn a_change_during_a_fragmented_message_is_not_lost() {
    let change = ChangeOfStateConnection { expected_packet_rate: 0, ..cos(true, 9) };
    let mut bus = running(ScanEntry { change_of_state: Some(change), ..entry() });
    bus.sends("455:");
    bus.command(|master, _| {
        master.set_run(true);
        master.set_output(mac(10), &[1; 9]).unwrap();
    });
    bus.sends("455: 00 01 01 01 01 01 01 01");
    bus.command(|master, _| master.set_output(mac(10), &[2; 9])).unwrap();
    bus.sends("455: 81 01 01");
    bus.sends("455: 00 02 02 02 02 02 02 02");
    bus.command(|master, _| master.set_output(mac(10), &[3; 9])).unwrap();
    bus.sends("455: 81 02 02");
    bus.sends("455: 00 03 03 03 03 03 03 03");
    bus.command(|master, _| master.set_run(false));
    bus.sends("455: 81 03 03");
    bus.sends("455:");
    bus.sends_nothing();
}

/// Without a packet rate there is no second chance: what the controller gave back is sent again, a little later.
#[test]
fn outputs_that_were_given_back_are_sent_again() {
    let change = ChangeOfStateConnection { expected_packet_rate: 0, ..cos(false, 1) };
    let mut bus = running(ScanEntry { change_of_state: Some(change), ..entry() });
    for _ in 0..3 {
        bus.drops("455:");
        bus.sends_nothing();
        bus.wait(10);
    }
    bus.sends("455:");
    bus.wait(60_000);
    bus.sends_nothing();
}

/// Acknowledges take turns: a slave that sends all the time does not starve those with higher MAC IDs.
#[test]
fn acknowledges_take_turns() {
    let entries = [10, 11].map(|number| ScanEntry {
        change_of_state: Some(cos(true, 0)),
        ..ScanEntry::explicit_only(mac(number))
    });
    let mut bus = Bus::online(Config { deferred_delete: false, ..config() }, &entries);
    bus.answers_everything(&entries);
    while bus.try_sends("455:") || bus.try_sends("45D:") {}
    for _ in 0..3 {
        bus.hears("34A: 01");
        bus.hears("34B: 01");
        bus.hears("34A: 02");
        bus.sends("452:");
        bus.sends("45A:");
        bus.hears("34B: 02");
        bus.hears("34A: 02");
        bus.try_sends("452:");
        bus.try_sends("45A:");
        bus.try_sends("452:");
    }
}

#[test]
fn changes_are_acknowledged_unless_that_is_suppressed() {
    for acknowledged in [true, false] {
        let mut bus = running(ScanEntry { change_of_state: Some(cos(acknowledged, 0)), ..entry() });
        bus.sends("455:");
        bus.hears("34A: 01");
        assert_eq!(bus.master.input_data(mac(10), IoInstance::ChangeOfState), Some(&[1][..]));
        assert_eq!(bus.try_sends("452:"), acknowledged);
        bus.sends_nothing();
    }
}

/// The slave's watchdog of instance 2 is fed by the master's own data, at the expected packet rate and on change.
#[test]
fn outputs_without_poll_are_sent_on_change_and_at_the_packet_rate() {
    let mut bus = running(ScanEntry { change_of_state: Some(cos(true, 1)), ..entry() });
    bus.command(|master, _| master.set_run(true));
    bus.sends("455:");
    bus.sends("455: 00");
    bus.hears("34A: 01");
    bus.sends("452:");
    bus.wait(40);
    bus.command(|master, _| master.set_output(mac(10), &[9])).unwrap();
    bus.sends("455: 09");
    bus.hears("3CA:");
    bus.command(|master, _| master.set_output(mac(10), &[9])).unwrap();
    bus.wait(99);
    bus.sends_nothing();
    bus.wait(1);
    bus.sends("455: 09");
}

#[test]
fn output_data_have_the_size_of_the_scan_list() {
    let mut bus = Bus::online(config(), &[polled()]);
    let refused = bus.command(|master, _| master.set_output(mac(63), &[1, 2]));
    assert_eq!(refused, Err(CommandError::OutputLength { expected: 1, found: 2 }));
    let refused = bus.command(|master, _| master.set_output(mac(62), &[1]));
    assert_eq!(refused, Err(CommandError::ScanList(ScanListError::NotListed(mac(62)))));
    let refused = bus.command(|master, _| master.set_multicast_output(&[0; 33]));
    assert_eq!(refused, Err(CommandError::OutputLength { expected: 0, found: 33 }));
}

/// A master that loses its place on the network takes its frames back and says no more.
#[test]
fn off_line_nothing_is_sent() {
    let mut bus = Bus::running(config());
    bus.events.clear();
    bus.hears("427: 80 34 12 99 99 00 00");
    bus.tells("slave 63: Running -> Offline: master off line");
    assert_eq!(bus.withdrawn, [link_core::TxToken(0x1002)], "the poll that was in flight");
    assert_eq!(bus.master.own_status(), ScannerStatus::DUPLICATE_MAC_ID);
    bus.input(link_core::Input::TxDone(link_core::TxToken(0x1002), link_core::TxOutcome::Withdrawn));
    bus.wait(60_000);
    assert_eq!(bus.master.state(mac(63)), Some(SlaveState::Offline));
}

#[test]
fn heartbeats_and_shutdowns_are_told() {
    let mut bus = Bus::running(config());
    bus.hears("5FB: 3F CD 01 00 03 00 00 00");
    bus.tells("slave 63: heartbeat: operational");
    bus.hears("77F: 3F CE 01 00 01 00 00 00");
    bus.tells("slave 63: shutdown: open code 0x0000");
    assert_eq!(bus.master.slave_counters(mac(63)).unwrap().heartbeats, 1);
}

#[test]
fn frames_of_strangers_are_counted() {
    let mut bus = Bus::running(config());
    bus.hears("3C5: 01");
    bus.hears("455: 01");
    bus.hears("7ED: 3F 4B 02");
    assert_eq!(bus.master.counters().unrelated, 3);
    bus.input(link_core::Input::TxDone(link_core::TxToken(0x1009), link_core::TxOutcome::Sent));
    assert_eq!(bus.master.counters().stray_tx_done, 1);
}

use std::vec::Vec;
