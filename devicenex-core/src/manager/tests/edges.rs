//! The transition table: every edge is taken, and the text shows it as it is.

use std::cell::RefCell;
use std::collections::HashSet;

use link_core::machine_laws;

use super::super::{Cause, DeviceState, EDGES, Edge};

std::thread_local! {
    static TAKEN: RefCell<HashSet<(DeviceState, Cause, DeviceState)>> = RefCell::default();
}

/// Called for every step of every device on this thread.
pub(in super::super) fn record(from: DeviceState, cause: Cause, to: DeviceState) {
    TAKEN.with_borrow_mut(|taken| taken.insert((from, cause, to)));
}

const fn key(edge: &Edge) -> (DeviceState, Cause, DeviceState) {
    (edge.from, edge.cause, edge.to)
}

#[test]
fn the_text_shows_the_table() {
    machine_laws::text_shows(include_str!("../state.rs"), "| Row | From | Cause | To |", EDGES);
    machine_laws::edges_are_distinct(EDGES, key);
}
