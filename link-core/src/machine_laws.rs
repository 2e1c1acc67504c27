//! What holds for every state machine, for the tests of the cores: the transition table, and all that a machine can come
//! to.

use core::fmt::{Debug, Display};
use core::hash::Hash;
use std::collections::{HashSet, VecDeque};
use std::string::ToString;
use std::vec::Vec;

/// The table under `heading` in the text of a module has these edges.
#[track_caller]
pub fn text_shows<E: Display>(text: &str, heading: &str, edges: &[E]) {
    let documented: Vec<_> = text
        .lines()
        .filter_map(|line| line.strip_prefix("/// "))
        .skip_while(|line| *line != heading)
        .skip(2)
        .take_while(|line| line.starts_with('|'))
        .collect();
    let actual: Vec<_> = edges.iter().map(ToString::to_string).collect();
    assert_eq!(documented, actual, "put this into the text of EDGES:\n{}", actual.join("\n"));
}

/// No edge is left that nobody has taken.
#[track_caller]
pub fn every_edge_was_taken<E: Debug, K: Eq + Hash>(edges: &[E], taken: &HashSet<K>, key: impl Fn(&E) -> K) {
    let missed: Vec<_> = edges.iter().filter(|edge| !taken.contains(&key(edge))).collect();
    assert!(missed.is_empty(), "{missed:#?}");
}

/// No edge is listed twice.
#[track_caller]
pub fn edges_are_distinct<E, K: Eq + Hash>(edges: &[E], key: impl Fn(&E) -> K) {
    let distinct: HashSet<_> = edges.iter().map(key).collect();
    assert_eq!(distinct.len(), edges.len());
}

/// Every world that steps lead to from `start`; they are fewer than `limit`.
#[track_caller]
pub fn reachable<W: Clone + Eq + Hash, S: Copy>(
    start: W,
    steps: &[S],
    step: impl Fn(&W, S) -> Option<W>,
    limit: usize,
) -> HashSet<W> {
    let mut seen = HashSet::from([start.clone()]);
    let mut open = VecDeque::from([start]);
    while let Some(world) = open.pop_front() {
        for &next in steps {
            if let Some(next) = step(&world, next)
                && seen.insert(next.clone())
            {
                open.push_back(next);
            }
        }
        assert!(seen.len() < limit, "the state space does not close");
    }
    seen
}
