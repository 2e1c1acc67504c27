//! The transition table: every edge is taken, and the text shows it as it is.

use std::cell::RefCell;
use std::collections::HashSet;

use link_core::{BusErrorKind, LinkEvent};

use super::super::{Access, BusOffWhileChecking, Cause, EDGES, Edge, StateKind};
use super::bus::*;
use link_core::machine_laws;

std::thread_local! {
    static TAKEN: RefCell<HashSet<(StateKind, Cause, StateKind)>> = RefCell::default();
}

/// Called for every step of every machine on this thread.
pub(in super::super) fn record(from: StateKind, cause: Cause, to: StateKind) {
    TAKEN.with_borrow_mut(|taken| taken.insert((from, cause, to)));
}

#[test]
fn every_edge_is_taken() {
    let states: [fn(super::super::Config) -> Bus; 4] =
        [Bus::power_up, Bus::waiting, Bus::online, Bus::faulted];
    for make in states {
        make(config()).link(LinkEvent::Down);
        make(config()).link(LinkEvent::BusOff);
        make(config()).link(LinkEvent::BusError(BusErrorKind::Ack));
        make(config()).command(Access::reset);
        make(config()).command(|node, now| node.set_mac_id(now, mac(5))).unwrap();
        make(config()).hears(CHECK, &TWIN_REQUEST);
        make(config()).hears(CHECK, &TWIN_RESPONSE);
        make(config()).hears(0x537, &TWIN_RESPONSE);
        make(config()).hears(0x7ED, &[0x05, 0x4D, 0x34, 0x12, 0x45, 0x23, 0x00, 0x00]);
        let mut restarting = config();
        restarting.bus_off_interrupt = true;
        restarting.bus_off_while_checking = BusOffWhileChecking::FollowInterrupt;
        make(restarting).link(LinkEvent::BusOff);
    }
    let mut quick = config();
    quick.quick_connect = true;
    let mut bus = Bus::power_up(quick);
    bus.acknowledges();
    bus.wait(1000);
    bus.acknowledges();

    TAKEN.with_borrow(|taken| machine_laws::every_edge_was_taken(EDGES, taken, key));
}

#[test]
fn the_text_shows_the_table_as_it_is() {
    machine_laws::text_shows(include_str!("../state.rs"), "| Row | From | Cause | To |", EDGES);
}

#[test]
fn no_edge_is_listed_twice_and_rows_are_in_order() {
    machine_laws::edges_are_distinct(EDGES, key);
    assert!(EDGES.is_sorted_by_key(|edge| edge.number));
    assert_eq!(EDGES.iter().map(|edge| edge.number).collect::<HashSet<_>>().len(), 15, "all fifteen rows");
}

const fn key(edge: &Edge) -> (StateKind, Cause, StateKind) {
    (edge.from, edge.cause, edge.to)
}
