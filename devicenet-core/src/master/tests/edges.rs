//! The transition table: every edge is taken, and the text shows it as it is.

use std::cell::RefCell;
use std::collections::HashSet;

use super::super::{Cause, EDGES, Edge, SlaveState};
use super::bus::{Bus, config, mac, polled};
use link_core::machine_laws;

std::thread_local! {
    static TAKEN: RefCell<HashSet<(SlaveState, Cause, SlaveState)>> = RefCell::default();
}

/// Called for every step of every slave of every machine on this thread.
pub(in super::super) fn record(from: SlaveState, cause: Cause, to: SlaveState) {
    TAKEN.with_borrow_mut(|taken| taken.insert((from, cause, to)));
}

fn contacting() -> Bus {
    let mut bus = Bus::online(config(), &[polled()]);
    bus.sends("5FE: 04 4B 03 01 01 04");
    bus
}

fn configuring() -> Bus {
    let mut bus = contacting();
    bus.hears("5FB: 04 CB 00");
    bus
}

fn waiting() -> Bus {
    let mut bus = contacting();
    bus.hears("5FB: 04 94 02 02");
    bus
}

fn sizes_asked(bus: &mut Bus) {
    for (request, response) in [
        ("5FC: 44 10 05 01 0C 03", "5FB: 44 90"),
        ("5FC: 04 0E 01 01 01", "5FB: 04 8E E7 03"),
        ("5FC: 44 0E 01 01 02", "5FB: 44 8E 07 00"),
        ("5FC: 04 0E 01 01 03", "5FB: 04 8E 2A 00"),
    ] {
        bus.sends(request);
        bus.hears(response);
    }
}

#[test]
fn every_edge_is_taken() {
    for make in [waiting, contacting, configuring, || Bus::running(config())] {
        make().hears("427: 80 34 12 99 99 00 00");
        make().command(|master, now| master.restart_slave(now, mac(63))).unwrap();
        make().hears("5FF: 00 E7 03 44 33 22 11");
        make().wait(60_000);
    }
    contacting().hears("5FB: 04 94 0C 01");
    Bus::running(config()).hears("5FB: 05 CB 00");
    let mut bus = contacting();
    while !bus.events.iter().any(|event| event.ends_with("no answer")) {
        bus.try_sends("5FE: 04 4B 03 01 01 04");
        bus.try_sends("784: 7F 4B 02 34");
        bus.wait(100);
    }
    let mut bus = configuring();
    while !bus.events.iter().any(|event| event.ends_with("Configuring -> Waiting: no answer")) {
        bus.try_sends("5FC: 44 10 05 01 0C 03");
        bus.wait(100);
    }
    let mut bus = configuring();
    sizes_asked(&mut bus);
    bus.sends("5FC: 44 4B 03 01 02 04");
    bus.hears("5FB: 44 94 0C 01");
    let mut bus = configuring();
    sizes_asked(&mut bus);
    bus.sends("5FC: 44 4B 03 01 02 04");
    bus.hears("5FB: 44 CB 00");
    bus.sends("5FC: 04 0E 05 02 07");
    bus.hears("5FB: 04 8E 09 00");
    for answer in ["94 16 FF", "8E 01 00"] {
        let mut bus = configuring();
        bus.sends("5FC: 44 10 05 01 0C 03");
        bus.hears("5FB: 44 90");
        bus.sends("5FC: 04 0E 01 01 01");
        bus.hears(&std::format!("5FB: 04 {answer}"));
    }
    lost_by_its_check();
    let mut bus = configuring();
    bus.hears("5FF: 00 E7 03 44 33 22 11");
    bus.wait(1005);

    TAKEN.with_borrow(|taken| machine_laws::every_edge_was_taken(EDGES, taken, key));
}

/// A slave without time-out that starts anew.
fn lost_by_its_check() {
    let mut entry = polled();
    entry.poll = entry.poll.map(|poll| super::super::PollConnection { expected_packet_rate: 0, ..poll });
    entry.key = super::super::ElectronicKey::default();
    let mut bus = Bus::online(config(), &[entry]);
    bus.answers_everything(&[entry]);
    bus.hears("5FF: 00 E7 03 44 33 22 11");
    bus.wait(1005);
}

#[test]
fn the_text_shows_the_table_as_it_is() {
    machine_laws::text_shows(include_str!("../state.rs"), "| From | Cause | To |", EDGES);
}

#[test]
fn no_edge_is_listed_twice() {
    machine_laws::edges_are_distinct(EDGES, key);
}

const fn key(edge: &Edge) -> (SlaveState, Cause, SlaveState) {
    (edge.from, edge.cause, edge.to)
}
