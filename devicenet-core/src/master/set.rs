//! A set of slaves: one bit for each MAC ID.

use crate::id::MacId;

/// Slaves, in the order of their MAC IDs.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub(super) struct SlaveSet(u64);

impl SlaveSet {
    pub(super) const EMPTY: Self = Self(0);

    pub(super) const fn is_empty(self) -> bool {
        self.0 == 0
    }

    pub(super) const fn len(self) -> u32 {
        self.0.count_ones()
    }

    pub(super) fn contains(self, slave: MacId) -> bool {
        self.0 & bit(slave) != 0
    }

    pub(super) fn insert(&mut self, slave: MacId) {
        self.0 |= bit(slave);
    }

    pub(super) fn remove(&mut self, slave: MacId) {
        self.0 &= !bit(slave);
    }

    pub(super) const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    pub(super) const fn difference(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    pub(super) fn first(self) -> Option<MacId> {
        u8::try_from(self.0.trailing_zeros()).ok().and_then(MacId::new)
    }

    /// Those with this number or a higher one.
    pub(super) fn from(self, number: u8) -> Self {
        Self(self.0 & u64::MAX.checked_shl(number.into()).unwrap_or(0))
    }

    /// Those after a slave.
    pub(super) fn after(self, slave: MacId) -> Self {
        self.from(slave.number().saturating_add(1))
    }

    /// How many come before a slave.
    pub(super) fn rank(self, slave: MacId) -> usize {
        let before = self.difference(self.from(slave.number()));
        usize::try_from(before.len()).unwrap_or(usize::MAX)
    }
}

impl Iterator for SlaveSet {
    type Item = MacId;

    fn next(&mut self) -> Option<MacId> {
        let first = self.first()?;
        self.remove(first);
        Some(first)
    }
}

fn bit(slave: MacId) -> u64 {
    1_u64.checked_shl(slave.number().into()).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn members_come_in_their_order() {
        let mut set = SlaveSet::default();
        for number in [63, 0, 7, 62] {
            set.insert(MacId::new(number).unwrap());
        }
        let numbers = |set: SlaveSet| set.map(MacId::number).collect::<std::vec::Vec<_>>();
        assert_eq!(numbers(set), [0, 7, 62, 63]);
        assert_eq!(numbers(set.from(7)), [7, 62, 63]);
        assert_eq!(numbers(set.after(MacId::new(7).unwrap())), [62, 63]);
        assert!(set.after(MacId::MAX).is_empty());
        assert_eq!((set.rank(MacId::MIN), set.rank(MacId::MAX), set.len()), (0, 3, 4));
        set.remove(MacId::MAX);
        assert!(!set.contains(MacId::MAX) && set.contains(MacId::MIN));
    }
}
