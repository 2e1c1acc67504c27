//! Every edge, and that a lost SoC counts once.

use std::cell::RefCell;
use std::collections::HashSet;

use link_core::machine_laws;

use super::*;

type Key = (CycleMode, CycleState, CycleEvent, Losses, CycleState);

std::thread_local! {
    static TAKEN: RefCell<HashSet<Key>> = RefCell::default();
}

/// Called for every step of every machine on this thread.
pub(super) fn record(edge: Key) {
    TAKEN.with_borrow_mut(|taken| taken.insert(edge));
}

const fn key(edge: &CycleEdge) -> Key {
    (edge.mode, edge.from, edge.event, edge.losses, edge.to)
}

const EVENTS: [CycleEvent; 6] = [
    CycleEvent::Soc,
    CycleEvent::Preq,
    CycleEvent::Pres,
    CycleEvent::Soa,
    CycleEvent::Asnd,
    CycleEvent::SocTimeout,
];

const WATCHED: Supervision = Supervision { is_timed: true, is_preq_due: true };

#[test]
fn every_edge_is_taken_and_nothing_else_happens() {
    for poll in [PollWithoutSoc::Stay, PollWithoutSoc::WaitSoa] {
        let steps: std::vec::Vec<_> = EVENTS
            .into_iter()
            .flat_map(|event| [CycleMode::Polled, CycleMode::Stopped].map(|mode| (mode, event)))
            .flat_map(|(mode, event)| [false, true].map(|due| (mode, event, due)))
            .collect();
        let step = |cycle: &Cycle, (mode, event, is_preq_due): (CycleMode, CycleEvent, bool)| {
            let mut next = cycle.clone();
            let losses = next.apply(mode, event, Supervision { is_timed: true, is_preq_due });
            let is_listed = CYCLE_EDGES.iter().any(|edge| {
                (edge.mode, edge.from, edge.event, edge.to) == (mode, cycle.state(), event, next.state())
                    && edge.losses.contains(losses)
            });
            assert!(is_listed || next == *cycle && losses.is_empty(), "{mode} {event} in {cycle:?}");
            Some(next)
        };
        machine_laws::reachable(Cycle::new(poll), &steps, step, 10_000);
    }
    TAKEN.with_borrow(|taken| machine_laws::every_edge_was_taken(CYCLE_EDGES, taken, key));
}

#[test]
fn the_text_shows_the_table_as_it_is() {
    machine_laws::text_shows(include_str!("edges.rs"), "| Mode | From | Event | Missing | To |", CYCLE_EDGES);
    machine_laws::edges_are_distinct(CYCLE_EDGES, key);
}

/// How often SoC, PReq and SoA were missed after the events.
#[track_caller]
fn missed(poll: PollWithoutSoc, supervision: Supervision, events: &[CycleEvent]) -> [usize; 3] {
    let mut cycle = Cycle::new(poll);
    let losses: std::vec::Vec<_> =
        events.iter().map(|&event| cycle.apply(CycleMode::Polled, event, supervision)).collect();
    [Losses::SOC, Losses::PREQ, Losses::SOA]
        .map(|loss| losses.iter().filter(|losses| losses.contains(loss)).count())
}

#[test]
fn a_lost_soc_counts_once_however_it_is_noticed() {
    use CycleEvent::{Preq, Soa, Soc, SocTimeout};
    for poll in [PollWithoutSoc::Stay, PollWithoutSoc::WaitSoa] {
        // By order, then by time.
        assert_eq!(missed(poll, WATCHED, &[Soc, Preq, Soa, Preq, SocTimeout, Soc])[0], 1, "{poll:?}");
        // By time, then by order.
        assert_eq!(missed(poll, WATCHED, &[Soc, Preq, Soa, SocTimeout, Preq, Soa, Soc])[0], 1, "{poll:?}");
        // By order cycle by cycle, before the first timeout, which tells of the first of them.
        let late = [Soc, Preq, Soa, Preq, Soa, Preq, Soa, SocTimeout];
        assert_eq!(missed(poll, WATCHED, &late)[0], 2, "{poll:?}");
        let later = [&late[..], &[Preq, Soa, SocTimeout, SocTimeout]].concat();
        assert_eq!(missed(poll, WATCHED, &later)[0], 3, "{poll:?}");
        assert_eq!(missed(poll, WATCHED, &[&later[..], &[SocTimeout, Preq, Soa]].concat())[0], 4, "{poll:?}");
        // Two in a row.
        let two = [Soc, Preq, Soa, SocTimeout, Preq, Soa, SocTimeout, Preq, Soa, Soc];
        assert_eq!(missed(poll, WATCHED, &two)[0], 2, "{poll:?}");
        // Without a timer, cycle by cycle.
        let untimed = Supervision { is_timed: false, is_preq_due: true };
        assert_eq!(missed(poll, untimed, &[Soc, Preq, Soa, Preq, Soa, Preq, Soa, Soc])[0], 2, "{poll:?}");
    }
}

#[test]
fn a_lost_soa_counts_once_however_it_is_noticed() {
    use CycleEvent::{Asnd, Preq, Soa, Soc};
    let one = [Soc, Preq, Asnd, Asnd, Soc, Preq, Soa];
    assert_eq!(missed(PollWithoutSoc::Stay, WATCHED, &one)[2], 1);
    let two = [Soc, Preq, Asnd, Soc, Preq, Asnd, Soc, Preq, Soa];
    assert_eq!(missed(PollWithoutSoc::Stay, WATCHED, &two)[2], 2);
}

#[test]
fn a_good_cycle_misses_nothing() {
    use CycleEvent::{Asnd, Preq, Pres, Soa, Soc};
    let good = [Soc, Pres, Preq, Pres, Soa, Asnd, Soc, Preq, Soa];
    assert_eq!(missed(PollWithoutSoc::Stay, WATCHED, &good), [0, 0, 0]);
}

#[test]
fn a_preq_that_is_not_due_is_not_missed() {
    use CycleEvent::{Soa, Soc};
    let multiplexed = Supervision { is_timed: true, is_preq_due: false };
    assert_eq!(missed(PollWithoutSoc::Stay, multiplexed, &[Soc, Soa, Soc, Soa]), [0, 0, 0]);
    assert_eq!(missed(PollWithoutSoc::Stay, WATCHED, &[Soc, Soa, Soc, Soa]), [0, 2, 0]);
}
