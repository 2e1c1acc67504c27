//! Which nodes want which identifier: a table, so that a frame costs nothing to those that do not want it.

use link_core::{Filter, FilterSet, Frame, Id};

/// A set of nodes.
#[derive(Clone, PartialEq, Eq, Hash, Debug, Default)]
pub struct NodeSet {
    words: Vec<u64>,
}

impl NodeSet {
    /// Whether a node is in the set.
    #[must_use]
    pub fn contains(&self, node: usize) -> bool {
        self.words.get(node / 64).is_some_and(|word| word >> (node % 64) & 1 == 1)
    }

    /// The nodes, in order.
    pub fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        self.words.iter().enumerate().flat_map(|(index, &word)| ones(word).map(move |bit| 64 * index + bit))
    }

    /// How many.
    #[must_use]
    pub fn len(&self) -> usize {
        self.words.iter().map(|word| word.count_ones() as usize).sum()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.words.iter().all(|&word| word == 0)
    }

    pub(crate) fn insert(&mut self, node: usize) {
        if self.words.len() <= node / 64 {
            self.words.resize(node / 64 + 1, 0);
        }
        self.words[node / 64] |= 1 << (node % 64);
    }

    pub(crate) fn remove(&mut self, node: usize) {
        if let Some(word) = self.words.get_mut(node / 64) {
            *word &= !(1 << (node % 64));
        }
    }

    pub(crate) fn clear(&mut self) {
        self.words.clear();
    }

    pub(crate) fn copy_from(&mut self, other: &Self) {
        self.words.clear();
        self.words.extend_from_slice(&other.words);
    }

    fn word(&self, index: usize) -> u64 {
        self.words.get(index).copied().unwrap_or(0)
    }
}

/// The acceptance filters of all nodes, turned inside out.
#[derive(Clone, Debug)]
pub(crate) struct Acceptance {
    /// Words a row.
    stride: usize,
    /// A row for each 11-bit identifier.
    standard: Vec<u64>,
    /// The nodes that have a filter for 29-bit identifiers.
    extended: NodeSet,
    filters: Vec<FilterSet>,
}

impl Acceptance {
    pub(crate) fn new() -> Self {
        Self { stride: 0, standard: Vec::new(), extended: NodeSet::default(), filters: Vec::new() }
    }

    /// Adds a node.
    pub(crate) fn push(&mut self, filter: FilterSet) {
        let node = self.filters.len();
        if node / 64 >= self.stride {
            let stride = (2 * self.stride).max(1);
            let mut wider = vec![0; STANDARD_IDS * stride];
            for id in 0..STANDARD_IDS {
                wider[id * stride..][..self.stride]
                    .copy_from_slice(&self.standard[id * self.stride..][..self.stride]);
            }
            (self.stride, self.standard) = (stride, wider);
        }
        self.filters.push(FilterSet::none());
        self.set(node, filter);
    }

    /// Changes what a node wants.
    pub(crate) fn set(&mut self, node: usize, filter: FilterSet) {
        let (word, bit) = (node / 64, 1_u64 << (node % 64));
        for old in self.filters[node].as_slice().iter().filter(|filter| !filter.is_extended()) {
            each_id(old, |id| self.standard[id * self.stride + word] &= !bit);
        }
        for new in filter.as_slice().iter().filter(|filter| !filter.is_extended()) {
            each_id(new, |id| self.standard[id * self.stride + word] |= bit);
        }
        if filter.as_slice().iter().any(Filter::is_extended) {
            self.extended.insert(node);
        } else {
            self.extended.remove(node);
        }
        self.filters[node] = filter;
    }

    /// Whether a node wants a frame.
    pub(crate) fn accepts(&self, node: usize, frame: &Frame) -> bool {
        match frame.id() {
            Id::Standard(id) => {
                let row = usize::from(id.as_raw()) * self.stride;
                self.standard[row + node / 64] >> (node % 64) & 1 == 1
            }
            Id::Extended(_) => self.filters[node].accepts(frame),
        }
    }

    /// Calls `each` with every node of `among` that wants `frame`, and with `sender`, in order.
    pub(crate) fn for_each(
        &self,
        frame: &Frame,
        among: &NodeSet,
        sender: usize,
        mut each: impl FnMut(usize),
    ) {
        for index in 0..self.stride {
            let wanting = match frame.id() {
                Id::Standard(id) => self.standard[usize::from(id.as_raw()) * self.stride + index],
                Id::Extended(_) => self.extended.word(index),
            };
            let mut word = wanting & among.word(index);
            if sender / 64 == index {
                word |= 1 << (sender % 64);
            }
            for bit in ones(word) {
                let node = 64 * index + bit;
                if !frame.is_extended() || node == sender || self.filters[node].accepts(frame) {
                    each(node);
                }
            }
        }
    }
}

/// The numbers of the ones in a word.
fn ones(mut word: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        if word == 0 {
            return None;
        }
        let bit = word.trailing_zeros() as usize;
        word &= word - 1;
        Some(bit)
    })
}

/// Calls `each` with every 11-bit identifier that passes `filter`: value and every subset of the bits that do not count.
fn each_id(filter: &Filter, mut each: impl FnMut(usize)) {
    let free = !filter.mask() as usize & (STANDARD_IDS - 1);
    let mut subset = free;
    loop {
        each(filter.value() as usize | subset);
        if subset == 0 {
            return;
        }
        subset = (subset - 1) & free;
    }
}

const STANDARD_IDS: usize = 0x800;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::any_frame;
    use link_core::frame::{extended_id, standard_id};
    use proptest::prelude::*;

    fn any_filter() -> impl Strategy<Value = FilterSet> {
        let filter = prop_oneof![
            (0..0x800_u16, 0..0x800_u16)
                .prop_map(|(value, mask)| Filter::standard(standard_id(value), mask & 0x783)),
            (any::<u32>(), any::<u32>())
                .prop_map(|(value, mask)| Filter::extended(extended_id(value), mask & 7)),
        ];
        prop::collection::vec(filter, 0..4).prop_map(|filters| filters.into_iter().collect())
    }

    proptest! {
        #[test]
        fn the_table_says_what_the_filters_say(
            filters in prop::collection::vec(any_filter(), 70),
            changed in any_filter(),
            frame in any_frame(),
            sender in 0..70_usize,
        ) {
            let mut table = Acceptance::new();
            filters.iter().for_each(|filter| table.push(filter.clone()));
            table.set(3, changed.clone());
            let mut filters = filters;
            filters[3] = changed;
            let mut among = NodeSet::default();
            (0..70).filter(|node| node % 3 != 0 && *node != sender).for_each(|node| among.insert(node));
            let mut seen = Vec::new();
            table.for_each(&frame, &among, sender, |node| seen.push(node));
            let expected: Vec<usize> = (0..70)
                .filter(|&node| node == sender || among.contains(node) && filters[node].accepts(&frame))
                .collect();
            prop_assert_eq!(seen, expected);
            prop_assert!((0..70).all(|node| table.accepts(node, &frame) == filters[node].accepts(&frame)));
        }
    }
}
