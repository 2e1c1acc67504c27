//! The master as a node: others open a connection through the UCMM and ask it about itself.

use super::bus::{Bus, config};

#[test]
fn it_answers_on_its_own_objects_while_it_scans() {
    let mut bus = Bus::running(config());
    bus.sends("5FD:");
    bus.hears("3FF: 34 12");
    // A tool at MAC ID 2 opens a connection in Group 3 with its Message ID 1.
    bus.hears("782: 04 4B 00 31");
    bus.sends("744: 02 CB 00 00 06 00");
    bus.hears("642: 04 0E 01 01 01");
    bus.sends("604: 02 8E 34 12");
    bus.hears("642: 44 0E 03 01 01");
    bus.sends("604: 42 8E 04");
    // It is nobody's slave.
    bus.hears("642: 04 0E 03 01 05");
    bus.sends("604: 02 8E 00 FF");
    bus.hears("782: 04 4C 06 00");
    bus.sends("744: 02 CC");
    bus.wait(10);
    bus.sends("5FD:");
}

#[test]
fn it_has_no_unconnected_port_of_group_2() {
    let mut bus = Bus::running(config());
    bus.sends("5FD:");
    bus.hears("3FF: 34 12");
    bus.hears("426: 02 4B 03 01 01 02");
    bus.sends_nothing();
}

#[test]
fn its_indicator_counts_slaves_as_connections() {
    let mut bus = Bus::online(config(), &[super::bus::polled()]);
    bus.tells("network status flashing green");
    bus.brings_up_63();
    bus.tells("network status green");
    bus.sends("5FD:");
    bus.wait(320);
    bus.tells("network status flashing red");
}
