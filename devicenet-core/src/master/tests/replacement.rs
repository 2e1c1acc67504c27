//! A new device at MAC ID 63 takes the place of a missing slave, or does not.

use cip_core::identity::Revision;

use super::super::*;
use super::bus::{Bus, config, mac};

/// A slave that may be replaced by another device of vendor 0x03E7 and product 42.
fn replaceable(number: u8) -> ScanEntry {
    let key = ElectronicKey {
        vendor: Some(0x03E7.into()),
        product_code: Some(0x2A),
        revision: Some(Revision { major: 1, minor: 2 }),
        device_type: None,
    };
    ScanEntry { key, replaceable: true, ..ScanEntry::explicit_only(mac(number)) }
}

/// A master whose slaves do not answer, at the moment at which it looks at MAC ID 63.
#[track_caller]
fn missing(mode: ReplacementMode, entries: &[ScanEntry]) -> Bus {
    let mut bus = Bus::online(
        Config { replacement: mode, retry_after: MINUTE, retry_at_most: MINUTE, ..config() },
        entries,
    );
    let rounds: [&dyn Fn(&ScanEntry) -> std::string::String; 2] = [
        &|entry| std::format!("{:03X}: 04 4B 03 01 01 04", 0x406 + 8 * u16::from(entry.mac_id.number())),
        &|entry| std::format!("784: {:02X} 4B 02 34", 0x40 | entry.mac_id.number()),
    ];
    for round in rounds {
        for _ in 0..2 {
            for entry in entries {
                bus.sends(&round(entry));
            }
            bus.wait(1000);
        }
    }
    bus
}

/// The device at MAC ID 63 answers until it was asked for its revision.
#[track_caller]
fn answers(bus: &mut Bus, product: &str) {
    for (request, response) in [
        ("5FE: 04 4B 03 01 01 04", "CB 00"),
        ("5FC: 44 0E 01 01 01", "8E E7 03"),
        ("5FC: 04 0E 01 01 02", "8E 07 00"),
        ("5FC: 44 0E 01 01 03", product),
        ("5FC: 04 0E 01 01 04", "8E 01 03"),
    ] {
        bus.sends(request);
        bus.hears(&std::format!("5FB: {} {response}", &request[5..7]));
    }
}

#[test]
fn the_one_missing_slave_is_replaced() {
    let mut bus = missing(ReplacementMode::On, &[replaceable(10)]);
    bus.is(10, SlaveState::Waiting, ScannerStatus::NOT_FOUND);
    answers(&mut bus, "8E 2A 00");
    bus.sends("5FC: 44 10 03 01 01 0A");
    bus.hears("5FB: 44 90");
    bus.tells("replacement: the device at MAC ID 63 becomes slave 10");
    // It starts anew: its check is heard, and it is brought up a second after the last.
    bus.hears("457: 00 E7 03 44 33 22 11");
    bus.wait(1000);
    bus.hears("457: 00 E7 03 44 33 22 11");
    bus.wait(1005);
    bus.sends("456: 04 4B 03 01 01 04");
}

#[test]
fn a_dry_run_changes_nothing() {
    let mut bus = missing(ReplacementMode::DryRun, &[replaceable(10)]);
    answers(&mut bus, "8E 2A 00");
    bus.tells("replacement: the device at MAC ID 63 would become slave 10");
    bus.sends("5FE: 44 4C 03 01 01");
    bus.hears("5FB: 44 CC");
    bus.sends_nothing();
}

#[test]
fn two_missing_slaves_of_a_kind_are_not_guessed_between() {
    let mut bus = missing(ReplacementMode::On, &[replaceable(10), replaceable(20)]);
    answers(&mut bus, "8E 2A 00");
    bus.tells("replacement: several slaves of its kind are missing");
    bus.sends("5FE: 44 4C 03 01 01");
    bus.is(10, SlaveState::Waiting, ScannerStatus::REPLACEMENT_FAILED);
    bus.is(20, SlaveState::Waiting, ScannerStatus::REPLACEMENT_FAILED);
}

#[test]
fn another_product_replaces_nobody() {
    let mut bus = missing(ReplacementMode::On, &[replaceable(10)]);
    answers(&mut bus, "8E 2B 00");
    bus.tells("replacement: the device at MAC ID 63 is none that is missing");
    bus.sends("5FE: 44 4C 03 01 01");
}

#[test]
fn two_devices_at_63_are_not_chosen_between() {
    let mut bus = missing(ReplacementMode::On, &[replaceable(10)]);
    bus.hears("5FF: 00 E7 03 44 33 22 11");
    bus.hears("5FF: 00 E7 03 45 33 22 11");
    answers(&mut bus, "8E 2A 00");
    bus.tells("replacement: several devices were heard at MAC ID 63");
    bus.is(10, SlaveState::Waiting, ScannerStatus::REPLACEMENT_FAILED);
    bus.sends("5FE: 44 4C 03 01 01");
    bus.hears("5FB: 44 CC");
    bus.sends_nothing();
    bus.wait(4999);
    bus.sends_nothing();
}

#[test]
fn a_device_with_switches_keeps_its_mac_id() {
    let mut bus = missing(ReplacementMode::On, &[replaceable(10)]);
    answers(&mut bus, "8E 2A 00");
    bus.sends("5FC: 44 10 03 01 01 0A");
    bus.hears("5FB: 44 94 0E FF");
    bus.tells("replacement: the device at MAC ID 63 does not let its MAC ID be set");
}

/// A slave that refuses its configuration shows status 89 as well, and is there: nobody takes its place.
#[test]
fn a_slave_that_answers_is_not_replaced() {
    let mut bus = Bus::online(Config { replacement: ReplacementMode::On, ..config() }, &[replaceable(10)]);
    let write = AttributeWrite { class: 0x64.into(), instance: 1.into(), attribute: 1.into(), value: &[7] };
    bus.command(|master, _| master.set_configuration(mac(10), &[write])).unwrap();
    for (request, response) in [
        ("456: 04 4B 03 01 01 04", "CB 00"),
        ("454: 44 10 05 01 0C 03", "90"),
        ("454: 04 0E 01 01 01", "8E E7 03"),
        ("454: 44 0E 01 01 02", "8E 07 00"),
        ("454: 04 0E 01 01 03", "8E 2A 00"),
        ("454: 44 0E 01 01 04", "8E 01 03"),
        ("454: 04 10 64 01 01 07", "94 09 FF"),
    ] {
        bus.sends(request);
        bus.hears(&std::format!("453: {} {response}", &request[5..7]));
    }
    bus.is(10, SlaveState::Waiting, ScannerStatus::REPLACEMENT_FAILED);
    bus.sends("456: 44 4C 03 01 01");
    bus.hears("453: 44 CC");
    bus.wait(900);
    bus.sends_nothing();
}

#[test]
fn nobody_looks_without_reason() {
    for (mode, entry) in [
        (ReplacementMode::Off, replaceable(10)),
        (ReplacementMode::On, ScanEntry { replaceable: false, ..replaceable(10) }),
    ] {
        let mut bus = missing(mode, &[entry]);
        bus.wait(30_000);
        bus.sends_nothing();
    }
}

#[test]
fn the_look_is_repeated() {
    let mut bus = missing(ReplacementMode::On, &[replaceable(10)]);
    bus.sends("5FE: 04 4B 03 01 01 04");
    bus.wait(5999);
    bus.sends_nothing();
    bus.wait(1);
    bus.sends("5FE: 44 4B 03 01 01 04");
    bus.wait(1000);
    // A device that comes up is looked at when it is on line.
    bus.hears("5FF: 00 E7 03 44 33 22 11");
    bus.wait(1005);
    bus.sends("5FE: 04 4B 03 01 01 04");
}

/// The look failed after the Allocate was answered: the device still has that connection when it is looked at again.
#[test]
fn what_a_look_that_failed_left_is_released_by_the_next() {
    let mut bus = missing(ReplacementMode::On, &[replaceable(10)]);
    bus.sends("5FE: 04 4B 03 01 01 04");
    bus.hears("5FB: 04 CB 00");
    bus.sends("5FC: 44 0E 01 01 01");
    bus.wait(2500 + 5000);
    bus.sends("5FE: 04 4B 03 01 01 04");
    bus.hears("5FB: 04 94 0B 02");
    bus.sends("5FE: 44 4C 03 01 01");
    bus.hears("5FB: 44 CC");
    answers(&mut bus, "8E 2A 00");
    bus.sends("5FC: 44 10 03 01 01 0A");
}

/// Nor is it released for ever.
#[test]
fn a_device_at_63_that_cannot_be_released_is_left() {
    let mut bus = missing(ReplacementMode::On, &[replaceable(10)]);
    bus.sends("5FE: 04 4B 03 01 01 04");
    bus.hears("5FB: 04 94 0B 02");
    bus.sends("5FE: 44 4C 03 01 01");
    bus.hears("5FB: 44 94 0B 02");
    bus.sends("5FE: 04 4B 03 01 01 04");
    bus.hears("5FB: 04 94 0B 02");
    bus.wait(4999);
    bus.sends_nothing();
    bus.wait(1);
    bus.sends("5FE: 44 4B 03 01 01 04");
}

/// A device that does not say what it is is let go.
#[test]
fn a_device_at_63_that_refuses_its_identity_replaces_nobody() {
    let mut bus = missing(ReplacementMode::On, &[replaceable(10)]);
    bus.sends("5FE: 04 4B 03 01 01 04");
    bus.hears("5FB: 04 CB 00");
    bus.sends("5FC: 44 0E 01 01 01");
    bus.hears("5FB: 44 94 14 FF");
    bus.tells("replacement: the device at MAC ID 63 is none that is missing");
    bus.sends("5FE: 04 4C 03 01 01");
}

const MINUTE: core::time::Duration = core::time::Duration::from_secs(60);
