//! The transition table: every edge is taken, and the text shows it as it is.

use std::cell::RefCell;
use std::collections::HashSet;
use std::vec::Vec;

use link_core::link::LinkCommandKind;
use link_core::{LinkEvent, machine_laws};

use super::super::{Access, Cause, Config, EDGES, Edge, StateKind};
use super::bus::*;

std::thread_local! {
    static TAKEN: RefCell<HashSet<(StateKind, Cause, StateKind)>> = RefCell::default();
}

/// Called for every step of every machine on this thread.
pub(in super::super) fn record(from: StateKind, cause: Cause, to: StateKind) {
    TAKEN.with_borrow_mut(|taken| taken.insert((from, cause, to)));
}

fn second_hello(config: Config) -> Bus {
    let mut bus = Bus::greeting(config);
    bus.acknowledges();
    bus.wait(1000);
    bus.is(StateKind::Hello2);
    bus
}

fn second_hello_with_address(config: Config) -> Bus {
    let mut bus = Bus::roamed(config);
    bus.acknowledges();
    bus.wait(1000);
    bus
}

fn off(config: Config) -> Bus {
    let mut bus = Bus::standby(config);
    bus.link(LinkEvent::BusOff);
    bus
}

fn mode_refused(config: Config) -> Bus {
    let mut bus = Bus::power_up(config);
    bus.link(LinkEvent::Refused(LinkCommandKind::SetMode));
    bus.is(StateKind::Faulted);
    bus
}

fn restart_refused(mut config: Config) -> Bus {
    config.bus_off_interrupt = true;
    let mut bus = off(config);
    bus.wait(100);
    bus.link(LinkEvent::Refused(LinkCommandKind::Reset));
    bus.is(StateKind::Faulted);
    bus
}

/// A manager that lost its address, with the given steps behind it.
fn dispossessed(steps: fn(&mut Bus)) -> Bus {
    let mut bus = Bus::greeting(manager());
    bus.response(LOWER, 67);
    bus.answer(link_core::TxOutcome::Withdrawn);
    steps(&mut bus);
    bus
}

#[test]
fn every_edge_is_taken() {
    let early = |mut config: Config| {
        config.early_roam = true;
        config
    };
    let states: Vec<Make> = std::vec![
        Bus::listening,
        Bus::greeting,
        second_hello,
        Bus::standby,
        Bus::roamed,
        second_hello_with_address,
        Bus::online,
        off,
        mode_refused,
        restart_refused,
    ];
    for make in states {
        make(config()).link(LinkEvent::Down);
        make(config()).link(LinkEvent::BusOff);
        make(config()).command(Access::reset);
        make(config()).command(|node, now| node.set_address(now, oa(5)));
        make(config()).request(LOWER, 67);
        make(config()).request(HIGHER, 67);
        make(config()).response(HIGHER, 67);
        make(config()).mini_who();
        make(early(config())).roam(OWN, 5);
    }
    let mut announcing = config();
    announcing.announcement = 500;
    Bus::online(announcing).wait(500);
    let mut restarting = config();
    restarting.bus_off_interrupt = true;
    let mut bus = off(restarting);
    bus.wait(100);
    bus.link(LinkEvent::Up);

    let mut restarting = manager();
    restarting.bus_off_interrupt = true;
    let mut bus = Bus::greeting(restarting);
    bus.command(Access::reset);
    bus.link(LinkEvent::BusOff);
    bus.wait(100);
    bus.link(LinkEvent::Up);
    mode_refused(manager()).command(Access::reset);
    dispossessed(|_| {}).command(Access::reset);
    dispossessed(|bus| {
        bus.acknowledges();
        bus.wait(1000);
    })
    .command(Access::reset);
    dispossessed(|bus| {
        for _ in 0..2 {
            bus.acknowledges();
            bus.wait(1000);
        }
        bus.is(StateKind::Standby);
    })
    .command(Access::reset);
    let mut bus = Bus::greeting(manager());
    bus.says_both(HELLO_67);
    bus.is(StateKind::Online);
    bus.command(Access::reset);

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
}

const fn key(edge: &Edge) -> (StateKind, Cause, StateKind) {
    (edge.from, edge.cause, edge.to)
}
