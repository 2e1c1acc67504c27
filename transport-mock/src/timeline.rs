//! Who must be called next: a tournament of deadlines.

use link_core::Instant;

/// One instant for each node, with the earliest at hand. Setting one costs the logarithm of the number of nodes and
/// stops early; looking up the earliest costs nothing. Of several at the same moment the first node wins.
#[derive(Clone, Debug)]
pub(crate) struct Timeline {
    /// A power of two: the leaves begin here.
    base: usize,
    /// A binary tree in an array: the children of `i` are `2i` and `2i + 1`.
    times: Vec<Instant>,
}

impl Timeline {
    pub(crate) fn new() -> Self {
        Self { base: 1, times: vec![Instant::MAX; 2] }
    }

    /// Makes room for `nodes` nodes.
    pub(crate) fn resize(&mut self, nodes: usize) {
        let base = nodes.next_power_of_two();
        if base <= self.base {
            return;
        }
        let leaves: Vec<Instant> = self.times[self.base..].to_vec();
        self.times = vec![Instant::MAX; 2 * base];
        self.base = base;
        for (node, at) in leaves.into_iter().enumerate() {
            self.set(node, at);
        }
    }

    /// Sets the deadline of a node; [`Instant::MAX`] is never.
    pub(crate) fn set(&mut self, node: usize, at: Instant) {
        let mut index = self.base + node;
        if self.times[index] == at {
            return;
        }
        self.times[index] = at;
        while index > 1 {
            index /= 2;
            let earliest = self.times[2 * index].min(self.times[2 * index + 1]);
            if self.times[index] == earliest {
                return;
            }
            self.times[index] = earliest;
        }
    }

    /// The earliest deadline.
    pub(crate) fn earliest(&self) -> Instant {
        self.times[1]
    }

    /// The first node with the earliest deadline.
    pub(crate) fn first(&self) -> usize {
        let mut index = 1;
        while index < self.base {
            index *= 2;
            if self.times[index] != self.times[index / 2] {
                index += 1;
            }
        }
        index - self.base
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn it_knows_the_first_of_the_earliest(sets in prop::collection::vec((0..37_usize, 0..20_u64), 1..200)) {
            let mut timeline = Timeline::new();
            timeline.resize(5);
            timeline.resize(37);
            let mut plain = vec![Instant::MAX; 37];
            for (node, at) in sets {
                let at = if at == 19 { Instant::MAX } else { Instant::from_nanos(at) };
                timeline.set(node, at);
                plain[node] = at;
                let earliest = plain.iter().min().copied().unwrap();
                prop_assert_eq!(timeline.earliest(), earliest);
                prop_assert_eq!(Some(timeline.first()), plain.iter().position(|&at| at == earliest));
            }
        }
    }
}
