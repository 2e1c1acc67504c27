//! The transition table: every edge is taken, and the text shows it as it is.

use std::cell::RefCell;
use std::collections::HashSet;
use std::string::ToString;
use std::vec::Vec;

use super::super::{Cause, EDGES, OfflineTool, ToolState};
use super::bus::Bus;

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
    let missed: Vec<_> = TAKEN.with_borrow(|taken| {
        EDGES.iter().filter(|edge| !taken.contains(&(edge.from, edge.cause, edge.to))).collect()
    });
    assert!(missed.is_empty(), "{missed:#?}");
}

#[test]
fn the_text_shows_the_table_as_it_is() {
    let text = include_str!("../state.rs");
    let documented: Vec<_> = text
        .lines()
        .filter_map(|line| line.strip_prefix("/// "))
        .skip_while(|line| *line != "| From | Cause | To |")
        .skip(2)
        .take_while(|line| line.starts_with('|'))
        .collect();
    let actual: Vec<_> = EDGES.iter().map(ToString::to_string).collect();
    assert_eq!(documented, actual, "put this into the text of EDGES:\n{}", actual.join("\n"));
}

#[test]
fn no_edge_is_listed_twice() {
    let distinct: HashSet<_> = EDGES.iter().map(|edge| (edge.from, edge.cause, edge.to)).collect();
    assert_eq!(distinct.len(), EDGES.len());
}
