//! The scan: its order, its pauses, and who is left out.

use core::time::Duration;

use super::super::*;
use super::bus::{Bus, config, mac};

/// Slaves that are believed what they are, so that bringing them up takes few frames.
fn entry(number: u8) -> ScanEntry {
    let poll = PollConnection { produce: 1, consume: 1, expected_packet_rate: 0 };
    ScanEntry { poll: Some(poll), ..ScanEntry::explicit_only(mac(number)) }
}

fn quick() -> Config {
    Config { deferred_delete: false, ..config() }
}

#[test]
fn polls_go_out_back_to_back_in_the_order_of_mac_ids() {
    let mut bus = Bus::online(quick(), &[entry(20), entry(10)]);
    // Both are brought up at once: they take turns.
    bus.sends("456: 04 4B 03 01 01 04");
    bus.sends("4A6: 04 4B 03 01 01 04");
    bus.hears("4A3: 04 CB 00");
    bus.hears("453: 04 CB 00");
    bus.sends("4A4: 44 0E 01 01 01");
    bus.sends("454: 44 0E 01 01 01");
}

#[test]
fn a_scan_ends_when_its_delay_is_over_and_its_responses_are_there() {
    let mut bus = Bus::online(quick(), &[entry(10)]);
    bus.answers_everything(&[entry(10)]);
    bus.sends("455:");
    bus.wait(9);
    bus.hears("3CA: 01");
    bus.sends_nothing();
    bus.wait(1);
    bus.tells("scan done");
    bus.sends("455:");
    // No response: the scan waits no longer than it is told to.
    bus.wait(9);
    bus.sends_nothing();
    bus.wait(1);
    bus.tells("scan done, 1 missing");
    assert_eq!(bus.master.slave_counters(mac(10)).unwrap().missed, 1);
    assert_eq!(bus.master.counters().scans, 2);
}

#[test]
fn without_interscan_delay_the_next_scan_follows_the_last_response() {
    let mut bus = Bus::online(Config { interscan_delay: Duration::ZERO, ..quick() }, &[entry(10)]);
    bus.answers_everything(&[entry(10)]);
    for _ in 0..3 {
        bus.sends("455:");
        bus.sends_nothing();
        bus.hears("3CA: 01");
        // Who has something to send with a higher identifier begins now.
        bus.sends_nothing();
        bus.wait(1);
    }
    bus.sends("455:");
    bus.wait(10);
    bus.tells("scan done, 1 missing");
    bus.sends("455:");
}

#[test]
fn background_slaves_are_polled_once_in_so_many_scans() {
    let background = ScanEntry { rate: ScanRate::Background, ..entry(20) };
    let config = Config { background_ratio: 3, ..quick() };
    let mut bus = Bus::online(config, &[entry(10), background]);
    bus.answers_everything(&[entry(10), background]);
    let mut polled = std::vec::Vec::new();
    for _ in 0..9 {
        bus.try_sends("455:");
        polled.push(bus.try_sends("4A5:"));
        bus.wait(10);
    }
    let times = |window: &[bool]| window.iter().filter(|&&due| due).count();
    assert!(polled.windows(3).all(|scans| times(scans) == 1), "{polled:?}");
}

#[test]
fn an_explicit_message_fits_into_every_scan() {
    let mut bus = Bus::online(Config { interscan_delay: Duration::ZERO, ..quick() }, &[entry(10), entry(20)]);
    bus.sends("456: 04 4B 03 01 01 04");
    bus.sends("4A6: 04 4B 03 01 01 04");
    bus.hears("453: 04 CB 00");
    bus.answers_everything(&[entry(10)]);
    // Slave 10 runs and is polled without a pause; slave 20 gets its requests all the same.
    bus.hears("4A3: 04 CB 00");
    bus.sends("455:");
    bus.sends("4A4: 44 0E 01 01 01");
    bus.hears("3CA: 01");
    // The answer has its time.
    bus.sends_nothing();
    bus.wait(2);
    bus.sends("455:");
    bus.hears("4A3: 44 8E 01 00");
    bus.sends("4A4: 04 0E 01 01 02");
    bus.hears("3CA: 01");
    bus.sends_nothing();
    // It is there: the next request belongs to the next scan.
    bus.hears("4A3: 04 8E 01 00");
    bus.sends("455:");
    bus.sends("4A4: 44 0E 01 01 03");
}

#[test]
fn a_scan_gives_way_to_a_few_frames_only() {
    let mut bus = Bus::online(Config { interscan_delay: Duration::ZERO, ..quick() }, &[entry(10)]);
    bus.answers_everything(&[entry(10)]);
    bus.sends("455:");
    bus.hears("3CA: 01");
    // Of nodes that never stop.
    bus.hears("4A3: 04 8E 01 00");
    bus.hears("4AB: 04 8E 01 00");
    bus.sends_nothing();
    bus.hears("4A3: 04 8E 01 00");
    bus.sends("455:");
}

#[test]
fn a_command_that_was_given_back_does_not_stop_the_scan() {
    let mut bus = Bus::online(quick(), &[entry(10)]);
    bus.answers_everything(&[entry(10)]);
    bus.drops("455:");
    assert_eq!(bus.master.counters().not_sent, 1);
    bus.wait(10);
    bus.sends("455:");
}
