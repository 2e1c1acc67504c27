//! The transition table: every edge is taken, and the text shows it as it is.

use std::cell::RefCell;
use std::collections::HashSet;

use super::super::{Cause, EDGES, Edge, OfflineTool, ToolState};
use super::bus::Bus;
use link_core::machine_laws;

std::thread_local! {
    static TAKEN: RefCell<HashSet<(ToolState, Cause, ToolState)>> = RefCell::default();
}

/// Called for every step of every machine on this thread.
pub(in super::super) fn record(from: ToolState, cause: Cause, to: ToolState) {
    TAKEN.with_borrow_mut(|taken| taken.insert((from, cause, to)));
}

#[test]
fn every_edge_is_taken() {
    let claiming = || {
        let mut bus = Bus::online();
        bus.command(OfflineTool::claim).unwrap();
        bus
    };
    for make in [claiming, Bus::owner] {
        make().hears("7EE: 01 CB 06 00 08 07 06 05");
        make().command(OfflineTool::release);
        make().hears("42F: 80 34 12 99 99 00 00");
    }
    TAKEN.with_borrow(|taken| machine_laws::every_edge_was_taken(EDGES, taken, key));
}

#[test]
fn the_text_shows_the_table_as_it_is() {
    machine_laws::text_shows(include_str!("../state.rs"), "| From | Cause | To |", EDGES);
}

#[test]
fn no_edge_is_listed_twice() {
    machine_laws::edges_are_distinct(EDGES, key);
}

const fn key(edge: &Edge) -> (ToolState, Cause, ToolState) {
    (edge.from, edge.cause, edge.to)
}
