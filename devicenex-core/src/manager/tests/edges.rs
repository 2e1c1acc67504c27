//! The transition table: every edge is taken, and the text shows it as it is.

use std::cell::RefCell;
use std::collections::HashSet;

use link_core::{Input, LinkEvent, machine_laws};

use super::super::{Cause, DeviceState, EDGES, Edge, PlannedConnection};
use super::bus::*;
use crate::id::Direction;
use crate::message::{IdentifierLength, Predefined, Production};

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

/// Every state, and how it is reached.
const STATES: [(DeviceState, fn() -> Bus); 11] = [
    (DeviceState::Idle, || Bus::power_up(config(), [producer()])),
    (DeviceState::Probing, Bus::probing),
    (DeviceState::Missing, Bus::missing),
    (DeviceState::Found, Bus::found),
    (DeviceState::Assigned, Bus::assigned),
    (DeviceState::Joining, Bus::joining),
    (DeviceState::Connecting, Bus::connecting),
    (DeviceState::Running, Bus::running),
    (DeviceState::Retrying, Bus::retrying),
    (DeviceState::Lost, Bus::lost),
    (DeviceState::Conflict, Bus::conflict),
];

/// What can happen in any of them.
const STIMULI: &[fn(&mut Bus)] = &[
    |bus| bus.hello(127, Direction::Request, PLANNED),
    |bus| bus.hello(127, Direction::Request, SPARE),
    |bus| bus.hello(127, Direction::Request, STRANGER),
    |bus| bus.hello(67, Direction::Request, PLANNED),
    |bus| bus.hello(67, Direction::Request, SPARE),
    |bus| bus.hello(67, Direction::Request, STRANGER),
    |bus| bus.hello(67, Direction::Response, PLANNED),
    |bus| bus.hello(67, Direction::Response, SPARE),
    |bus| bus.hello(67, Direction::Response, STRANGER),
    |bus| bus.mini_who(0x0001),
    |bus| bus.input(Input::Link(LinkEvent::Down)),
    |bus| {
        bus.wait_on_the_bus(30_000);
    },
];

/// In every state, whatever can happen, and two things one after the other: no step that the table does not have (which debug
/// builds check), and no row that is never taken.
#[test]
fn every_edge_is_taken() {
    for (state, reach) in STATES {
        let reached = reach();
        reached.is(67, state);
        for first in STIMULI {
            let mut bus = reached.clone();
            first(&mut bus);
            for second in STIMULI {
                second(&mut bus.clone());
            }
        }
    }
    // Who has the address answers.
    let mut bus = Bus::probing();
    bus.identifies(PLANNED);
    bus.is(67, DeviceState::Connecting);
    // It answers the second request.
    let mut bus = Bus::retrying();
    bus.answers_connection();
    bus.is(67, DeviceState::Running);
    // It refuses one connection, and falls silent on the other.
    let mut plan = producer();
    let broadcast = Predefined::Implicit(Production::Broadcast, IdentifierLength::Extended);
    plan.connections
        .push(PlannedConnection { instance: Some(broadcast), ..PlannedConnection::producer(0) })
        .unwrap();
    let mut bus = Bus::on_line(config(), [plan]);
    bus.wait_on_the_bus(600);
    bus.hello(67, Direction::Request, PLANNED);
    bus.wait(2020);
    bus.answers_connection();
    let sent = bus.acknowledges();
    bus.hears(&std::format!("1D0386{}: 94 08 FF", &sent.last().unwrap()[6..8]));
    bus.wait(1000);
    bus.is(67, DeviceState::Retrying);
    // It takes its address after the last ROAM, and gives it up at once; later it takes none at all.
    for leaves in [2, 3] {
        let mut bus = Bus::found();
        for _ in 0..leaves {
            bus.wait_on_the_bus(1020 + 2 * 500 + 10);
            bus.hello(67, Direction::Request, PLANNED);
            bus.is(67, DeviceState::Joining);
            bus.hello(127, Direction::Request, PLANNED);
            bus.hello(127, Direction::Request, PLANNED);
            bus.wait_on_the_bus(10_000);
            bus.hello(127, Direction::Request, PLANNED);
        }
    }
    // A connection that is no longer there.
    let mut bus = Bus::adopted(0);
    bus.wait(1000);
    bus.answers_get(&[1]);
    bus.is(67, DeviceState::Connecting);

    TAKEN.with_borrow(|taken| machine_laws::every_edge_was_taken(EDGES, taken, key));
}
