//! Acceptance filters: which identifiers a machine wants to see.

use embedded_can_types::{ExtendedId, Id, StandardId};

use crate::frame::Frame;

/// Identifiers that agree with `value` in every bit of `mask`, of one identifier format.
///
/// Remote frames pass like data frames: the machine decides what they mean.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Filter {
    extended: bool,
    value: u32,
    mask: u32,
}

impl Filter {
    /// Exactly this identifier.
    #[must_use]
    pub fn exact(id: impl Into<Id>) -> Self {
        match id.into() {
            Id::Standard(id) => Self::standard(id, StandardId::MAX.as_raw()),
            Id::Extended(id) => Self::extended(id, ExtendedId::MAX.as_raw()),
        }
    }

    /// 11-bit identifiers that agree with `value` where `mask` has ones.
    #[must_use]
    pub fn standard(value: StandardId, mask: u16) -> Self {
        let mask = u32::from(mask & StandardId::MAX.as_raw());
        Self { extended: false, value: u32::from(value.as_raw()) & mask, mask }
    }

    /// 29-bit identifiers that agree with `value` where `mask` has ones.
    #[must_use]
    pub fn extended(value: ExtendedId, mask: u32) -> Self {
        let mask = mask & ExtendedId::MAX.as_raw();
        Self { extended: true, value: value.as_raw() & mask, mask }
    }

    /// Every 11-bit identifier.
    pub const ALL_STANDARD: Self = Self { extended: false, value: 0, mask: 0 };
    /// Every 29-bit identifier.
    pub const ALL_EXTENDED: Self = Self { extended: true, value: 0, mask: 0 };

    /// Whether an identifier passes.
    #[must_use]
    pub fn accepts(&self, id: Id) -> bool {
        let (extended, raw) = match id {
            Id::Standard(id) => (false, u32::from(id.as_raw())),
            Id::Extended(id) => (true, id.as_raw()),
        };
        self.extended == extended && raw & self.mask == self.value
    }

    /// Whether everything that passes `other` passes this filter.
    #[must_use]
    pub const fn covers(&self, other: &Self) -> bool {
        self.extended == other.extended
            && self.mask & other.mask == self.mask
            && other.value & self.mask == self.value
    }

    /// Whether it is for 29-bit identifiers.
    #[must_use]
    pub const fn is_extended(&self) -> bool {
        self.extended
    }

    /// The bits that an identifier must have, where [`mask`](Self::mask) has ones.
    #[must_use]
    pub const fn value(&self) -> u32 {
        self.value
    }

    /// The bits that count.
    #[must_use]
    pub const fn mask(&self) -> u32 {
        self.mask
    }
}

/// A set of filters; a frame passes if it passes one of them.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct FilterSet {
    filters: heapless::Vec<Filter, { FilterSet::CAPACITY }>,
}

impl FilterSet {
    /// The most filters that a set holds.
    pub const CAPACITY: usize = 16;

    /// Nothing passes.
    #[must_use]
    pub const fn none() -> Self {
        Self { filters: heapless::Vec::new() }
    }

    /// These filters, of which none should cover another.
    #[must_use]
    pub fn of<const N: usize>(filters: [Filter; N]) -> Self {
        Self { filters: heapless::Vec::from_array(filters) }
    }

    /// Every frame passes.
    #[must_use]
    pub fn all() -> Self {
        Self::of([Filter::ALL_STANDARD, Filter::ALL_EXTENDED])
    }

    /// Adds a filter, in place of those that it covers. A full set is widened to every identifier of that format
    /// instead: a filter is a help to the receiver, so letting more through is harmless, and losing frames is not.
    pub fn add(&mut self, filter: Filter) {
        if self.filters.iter().any(|other| other.covers(&filter)) {
            return;
        }
        self.drop_covered_by(&filter);
        if self.filters.push(filter).is_ok() {
            return;
        }
        let widest = if filter.extended { Filter::ALL_EXTENDED } else { Filter::ALL_STANDARD };
        self.drop_covered_by(&widest);
        if self.filters.push(widest).is_err() {
            // Full of filters of the other format: give up selection altogether.
            *self = Self::all();
        }
    }

    fn drop_covered_by(&mut self, filter: &Filter) {
        let mut kept = Self::none();
        for other in self.filters.iter().filter(|other| !filter.covers(other)) {
            // It had room before.
            let _ = kept.filters.push(*other);
        }
        *self = kept;
    }

    /// Whether a frame passes.
    #[must_use]
    pub fn accepts(&self, frame: &Frame) -> bool {
        self.filters.iter().any(|filter| filter.accepts(frame.id()))
    }

    /// The filters, for a transport that has its own form of them.
    #[must_use]
    pub fn as_slice(&self) -> &[Filter] {
        &self.filters
    }
}

impl FromIterator<Filter> for FilterSet {
    fn from_iter<I: IntoIterator<Item = Filter>>(filters: I) -> Self {
        let mut set = Self::none();
        set.extend(filters);
        set
    }
}

impl Extend<Filter> for FilterSet {
    fn extend<I: IntoIterator<Item = Filter>>(&mut self, filters: I) {
        filters.into_iter().for_each(|filter| self.add(filter));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    extern crate std;

    fn standard(raw: u16) -> StandardId {
        StandardId::new(raw).unwrap()
    }

    #[test]
    fn a_mask_selects_and_the_format_matters() {
        // UCMM requests of all 64 MAC IDs: 0x780 to 0x7BF.
        let ucmm = Filter::standard(standard(0x780), 0x7C0);
        assert!(ucmm.accepts(standard(0x7BF).into()));
        assert!(!ucmm.accepts(standard(0x7C0).into()));
        assert!(!ucmm.accepts(ExtendedId::new(0x780).unwrap().into()));
    }

    #[test]
    fn a_full_set_accepts_more_and_never_less() {
        let set: FilterSet = (0..20).map(|raw| Filter::exact(standard(raw))).collect();
        for raw in 0..20 {
            assert!(set.accepts(&Frame::new(standard(raw), &[]).unwrap()));
        }
        assert!(set.as_slice().len() <= FilterSet::CAPACITY);
    }

    #[test]
    fn a_widened_set_has_room_for_the_other_format() {
        let mut set: FilterSet = (0..40).map(|raw| Filter::exact(standard(raw))).collect();
        assert_eq!(set.as_slice(), [Filter::ALL_STANDARD], "what is covered takes no room");
        let exact = Filter::exact(ExtendedId::ZERO);
        set.add(exact);
        assert_eq!(set.as_slice(), [Filter::ALL_STANDARD, exact]);
    }

    proptest! {
        #[test]
        fn a_filter_covers_what_passes_both(
            values in [0..8_u16, 0..8_u16],
            masks in [0..8_u16, 0..8_u16],
        ) {
            let filter = |index: usize| Filter::standard(standard(values[index]), masks[index] | 0x7F8);
            let (one, other) = (filter(0), filter(1));
            let implied = (0..0x800).map(|raw| Id::from(standard(raw))).all(|id| !other.accepts(id) || one.accepts(id));
            prop_assert_eq!(one.covers(&other), implied);
        }
    }

    #[test]
    fn a_set_full_of_one_format_gives_up_for_a_filter_of_the_other() {
        let mut set: FilterSet = (0..16).map(|raw| Filter::exact(standard(raw))).collect();
        assert_eq!(set.as_slice().len(), FilterSet::CAPACITY);
        set.add(Filter::exact(ExtendedId::ZERO));
        assert_eq!(set, FilterSet::all());
    }
}
