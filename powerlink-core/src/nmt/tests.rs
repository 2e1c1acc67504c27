//! Every edge, every command in every state, and what must not happen.

use std::cell::RefCell;
use std::collections::HashSet;
use std::vec::Vec;

use link_core::machine_laws;

use super::*;
use crate::wire::NmtCommandId;

std::thread_local! {
    static TAKEN: RefCell<HashSet<(NmtState, Cause, NmtState)>> = RefCell::default();
}

/// Called for every step of every machine on this thread.
pub(super) fn record(from: NmtState, cause: Cause, to: NmtState) {
    TAKEN.with_borrow_mut(|taken| taken.insert((from, cause, to)));
}

const fn key(edge: &Edge) -> (NmtState, Cause, NmtState) {
    (edge.from, edge.cause, edge.to)
}

/// Every machine that any order of causes leads to.
fn machines() -> HashSet<Nmt> {
    let step = |nmt: &Nmt, cause: Cause| {
        let mut next = nmt.clone();
        next.apply(cause).map(|_| next)
    };
    machine_laws::reachable(Nmt::new(), &Cause::ALL, step, 100)
}

fn in_state(state: NmtState) -> Vec<Nmt> {
    machines().into_iter().filter(|nmt| nmt.state() == state).collect()
}

#[test]
fn every_edge_is_taken_and_every_state_reached() {
    let states: HashSet<_> = machines().iter().map(Nmt::state).collect();
    assert_eq!(states, HashSet::from(NmtState::ALL));
    TAKEN.with_borrow(|taken| machine_laws::every_edge_was_taken(EDGES, taken, key));
}

#[test]
fn the_text_shows_the_table_as_it_is() {
    machine_laws::text_shows(include_str!("edges.rs"), "| Name | From | Cause | To |", EDGES);
    machine_laws::edges_are_distinct(EDGES, key);
}

/// A state and a cause lead to one state, CT5 and CT6 apart, and to what the table says.
#[test]
fn what_is_not_in_the_table_changes_nothing() {
    for nmt in machines() {
        for cause in Cause::ALL {
            let allowed: Vec<_> = EDGES
                .iter()
                .filter(|edge| (edge.from, edge.cause) == (nmt.state(), cause))
                .map(|edge| edge.to)
                .collect();
            let mut next = nmt.clone();
            match next.apply(cause) {
                Some(edge) => {
                    assert!(allowed.contains(&next.state()));
                    assert_eq!((edge.from, edge.cause, edge.to), (nmt.state(), cause, next.state()));
                }
                None => {
                    assert!(allowed.is_empty(), "{cause} in {}", nmt.state());
                    assert_eq!(next, nmt);
                }
            }
        }
    }
}

/// EPSG DS 301 and replays against openPOWERLINK 2.7.2: a row a command, a column a state, `.` for ignored.
#[test]
fn every_command_in_every_state() {
    const COLUMNS: [NmtState; 12] = NmtState::ALL;
    //    Off Initialising ResetApp ResetComm ResetConf NotActive Pre1 Pre2 Ready Operational Stopped Basic
    const ROWS: [(NmtCommandId, &str); 8] = [
        (NmtCommandId::START_NODE, ". . . . . . . . OP . . ."),
        (NmtCommandId::STOP_NODE, ". . . . . . . ST ST ST . ."),
        (NmtCommandId::ENTER_PRE_OPERATIONAL_2, ". . . . . . . . . P2 P2 ."),
        (NmtCommandId::ENABLE_READY_TO_OPERATE, ". . . . . . . RO . . . ."),
        (NmtCommandId::RESET_NODE, ". . . RA RA RA RA RA RA RA RA RA"),
        (NmtCommandId::RESET_COMMUNICATION, ". . . . RC RC RC RC RC RC RC RC"),
        (NmtCommandId::RESET_CONFIGURATION, ". . . . . RF RF RF RF RF RF RF"),
        (NmtCommandId::SW_RESET, ". IN IN IN IN IN IN IN IN IN IN IN"),
    ];
    for (command, row) in ROWS {
        for (from, expected) in COLUMNS.into_iter().zip(row.split(' ')) {
            let to = match expected {
                "." => from,
                "OP" => NmtState::Operational,
                "ST" => NmtState::Stopped,
                "P2" => NmtState::PreOperational2,
                "RO" => NmtState::ReadyToOperate,
                "RA" => NmtState::ResetApplication,
                "RC" => NmtState::ResetCommunication,
                "RF" => NmtState::ResetConfiguration,
                _ => NmtState::Initialising,
            };
            for mut nmt in in_state(from) {
                // The application of a node in PreOperational2 is ready; without that the command leads nowhere.
                nmt.apply(Cause::ApplicationReady);
                if nmt.state() != from {
                    continue;
                }
                nmt.apply(Cause::of_command(command).unwrap());
                assert_eq!(nmt.state(), to, "{command} in {from}");
            }
        }
    }
}

#[test]
fn extended_commands_are_the_plain_ones_and_all_others_are_not_followed() {
    for number in 0..=u8::MAX {
        let cause = Cause::of_command(NmtCommandId(number));
        match number {
            0x21..=0x24 | 0x28..=0x2B => assert!(cause.is_some(), "{number:#X}"),
            0x41..=0x44 | 0x48..=0x4B => {
                assert_eq!(cause, Cause::of_command(NmtCommandId(number - 0x20)), "{number:#X}");
            }
            _ => assert_eq!(cause, None, "{number:#X}"),
        }
    }
}

#[test]
fn ready_to_operate_needs_both_conditions_in_any_order_and_forgets_them_afterwards() {
    let pair = [Cause::EnableReadyToOperate, Cause::ApplicationReady];
    for [first, second] in [pair, [pair[1], pair[0]]] {
        for mut nmt in in_state(NmtState::Operational) {
            nmt.apply(Cause::EnterPreOperational2);
            nmt.apply(first);
            nmt.apply(first);
            assert_eq!(nmt.state(), NmtState::PreOperational2);
            nmt.apply(Cause::StopNode);
            nmt.apply(Cause::EnterPreOperational2);
            nmt.apply(second);
            assert_eq!(nmt.state(), NmtState::PreOperational2, "the first was forgotten in Stopped");
            nmt.apply(first);
            assert_eq!(nmt.state(), NmtState::ReadyToOperate);
        }
    }
}

/// The tables of EPSG DS 301: codes, and what the low four bits name.
#[test]
fn codes_name_the_super_state() {
    for state in NmtState::ALL {
        let low = state.code().0 & 0x0F;
        assert_eq!(low == 0x09, state.is_initialisation(), "{state}");
        assert_eq!(matches!(low, 0x0C..=0x0E), state.is_communicating(), "{state}");
        assert_eq!(low == 0x0D, state.is_powerlink_mode(), "{state}");
    }
}
