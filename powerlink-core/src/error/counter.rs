//! Error counters with thresholds.

use super::Symptom;

/// One error counter object: how often in all, and whether it is too often now.
///
/// A symptom adds 8 to the threshold counter, a good cycle takes 1 away. At the threshold the node reacts, and the counter
/// starts at 0 again. With the default of 15 a second symptom with at most one good cycle between is one too many.
///
/// ```
/// use powerlink_core::error::ErrorCounter;
///
/// let mut counter = ErrorCounter::new(15);
/// assert!(!counter.symptom());
/// assert!(counter.symptom(), "8 + 8 is more than 15");
/// assert_eq!((counter.cumulative, counter.threshold_count), (2, 0));
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ErrorCounter {
    /// Sub-index 1: all symptoms; it wraps, and outlives resets of the node.
    pub cumulative: u32,
    /// Sub-index 2.
    pub threshold_count: u32,
    /// Sub-index 3: 0 for never, 1 for at once.
    pub threshold: u32,
}

/// The error counters of a controlled node.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ErrorCounters {
    counters: [ErrorCounter; Symptom::ALL.len()],
    /// Which had a symptom in this cycle, a bit each.
    in_this_cycle: u8,
}

impl ErrorCounter {
    /// A counter that has counted nothing.
    #[must_use]
    pub const fn new(threshold: u32) -> Self {
        Self { cumulative: 0, threshold_count: 0, threshold }
    }

    /// Counts a symptom; true if the threshold is reached.
    pub const fn symptom(&mut self) -> bool {
        self.cumulative = self.cumulative.wrapping_add(1);
        if self.threshold == 0 {
            return false;
        }
        self.threshold_count = self.threshold_count.saturating_add(SYMPTOM);
        if self.threshold_count < self.threshold {
            return false;
        }
        self.threshold_count = 0;
        true
    }

    /// Counts so many symptoms in a row, but none behind the one that reaches the threshold; true if one does. In one step.
    pub const fn symptoms(&mut self, count: u32) -> bool {
        let missing = self.threshold.saturating_sub(self.threshold_count);
        // The last one is counted as any single one is.
        let until_reached = missing.div_ceil(SYMPTOM).saturating_sub(1);
        let is_enough = self.threshold > 0 && count > until_reached;
        let before = if is_enough { until_reached } else { count };
        self.cumulative = self.cumulative.wrapping_add(before);
        if self.threshold > 0 {
            self.threshold_count = self.threshold_count.saturating_add(before.saturating_mul(SYMPTOM));
        }
        is_enough && self.symptom()
    }

    /// A cycle passed without the symptom.
    pub const fn good(&mut self) {
        self.threshold_count = self.threshold_count.saturating_sub(1);
    }
}

impl ErrorCounters {
    /// Counters that have counted nothing, with the default thresholds.
    #[must_use]
    pub const fn new() -> Self {
        Self { counters: [ErrorCounter::new(DEFAULT_THRESHOLD); Symptom::ALL.len()], in_this_cycle: 0 }
    }

    /// One of them.
    #[must_use]
    pub fn of(&self, symptom: Symptom) -> ErrorCounter {
        self.counters.get(symptom.index()).copied().unwrap_or(ErrorCounter::new(0))
    }

    /// One of them, to be changed by the managing node.
    pub(crate) fn of_mut(&mut self, symptom: Symptom) -> Option<&mut ErrorCounter> {
        self.counters.get_mut(symptom.index())
    }

    /// Counts a symptom; true if the threshold is reached.
    pub fn symptom(&mut self, symptom: Symptom) -> bool {
        self.in_this_cycle |= symptom.bit();
        self.of_mut(symptom).is_some_and(ErrorCounter::symptom)
    }

    /// Counts so many of one symptom, at most until the threshold is reached; true if it is.
    pub fn symptoms(&mut self, symptom: Symptom, count: u32) -> bool {
        self.in_this_cycle |= symptom.bit();
        self.of_mut(symptom).is_some_and(|counter| counter.symptoms(count))
    }

    /// The end of a cycle: what had no symptom in it recovers. The loss of PReq does so at each PReq
    /// ([`preq`](Self::preq)).
    pub fn end_of_cycle(&mut self) {
        let with_symptom = core::mem::take(&mut self.in_this_cycle);
        for (counter, symptom) in self.counters.iter_mut().zip(Symptom::ALL) {
            if with_symptom & symptom.bit() == 0 && symptom != Symptom::LossOfPreq {
                counter.good();
            }
        }
    }

    /// The node's own PReq was received, and is correct.
    pub fn preq(&mut self) {
        if let Some(counter) = self.of_mut(Symptom::LossOfPreq) {
            counter.good();
        }
    }

    /// Power-on values: thresholds by default, and nothing on the way to them. What was counted in all stays.
    pub fn reset(&mut self) {
        self.in_this_cycle = 0;
        for counter in &mut self.counters {
            *counter =
                ErrorCounter { cumulative: counter.cumulative, ..ErrorCounter::new(DEFAULT_THRESHOLD) };
        }
    }
}

impl Default for ErrorCounters {
    fn default() -> Self {
        Self::new()
    }
}

/// What a symptom adds.
const SYMPTOM: u32 = 8;
const DEFAULT_THRESHOLD: u32 = 15;

#[cfg(test)]
mod tests {
    use super::*;

    /// Symptoms in a row until the threshold is reached, and what the counter was before.
    fn symptoms_until_reached(threshold: u32) -> usize {
        let mut counter = ErrorCounter::new(threshold);
        (1..100).find(|_| counter.symptom()).unwrap_or(0)
    }

    #[test]
    fn at_and_around_each_threshold() {
        let expected =
            [(0, 0), (1, 1), (7, 1), (8, 1), (9, 2), (15, 2), (16, 2), (17, 3), (80, 10), (81, 11)];
        for (threshold, symptoms) in expected {
            assert_eq!(symptoms_until_reached(threshold), symptoms, "threshold {threshold}");
        }
    }

    /// Of EPSG DS 301 with 15: 8 - good + 8 must reach it; openPOWERLINK: one in ten cycles does nothing.
    #[test]
    fn good_cycles_between_two_symptoms() {
        for good in 0..12 {
            let mut counter = ErrorCounter::new(15);
            assert!(!counter.symptom());
            (0..good).for_each(|_| counter.good());
            assert_eq!(counter.symptom(), good <= 1, "{good} good cycles");
        }
        let mut counter = ErrorCounter::new(15);
        for _ in 0..100 {
            assert!(!counter.symptom());
            (0..9).for_each(|_| counter.good());
        }
        assert_eq!(counter.cumulative, 100);
    }

    /// As one by one, up to the first that reaches the threshold.
    #[test]
    fn many_symptoms_in_one_step() {
        for threshold in (0..100).chain([u32::MAX]) {
            for (begun, count) in (0..30).flat_map(|begun| (0..15).map(move |count| (begun, count))) {
                let counter = ErrorCounter { cumulative: u32::MAX, threshold_count: begun, threshold };
                let (mut many, mut each) = (counter, counter);
                let is_reached = (0..count).any(|_| each.symptom());
                assert_eq!((many.symptoms(count), many), (is_reached, each), "{count} from {counter:?}");
            }
        }
        let mut counter = ErrorCounter::new(0);
        assert!(!counter.symptoms(u32::MAX));
        assert_eq!((counter.cumulative, counter.threshold_count), (u32::MAX, 0));
    }

    #[test]
    fn a_cycle_with_a_symptom_is_not_a_good_one() {
        let mut counters = ErrorCounters::new();
        counters.symptom(Symptom::LossOfSoc);
        counters.end_of_cycle();
        assert_eq!(counters.of(Symptom::LossOfSoc).threshold_count, 8);
        counters.end_of_cycle();
        assert_eq!(counters.of(Symptom::LossOfSoc).threshold_count, 7);
    }

    #[test]
    fn the_loss_of_preq_recovers_with_preqs_alone() {
        let mut counters = ErrorCounters::new();
        counters.symptom(Symptom::LossOfPreq);
        counters.end_of_cycle();
        counters.end_of_cycle();
        assert_eq!(counters.of(Symptom::LossOfPreq).threshold_count, 8);
        counters.preq();
        assert_eq!(counters.of(Symptom::LossOfPreq).threshold_count, 7);
    }

    #[test]
    fn a_reset_keeps_what_was_counted_in_all_which_wraps() {
        let mut counters = ErrorCounters::new();
        *counters.of_mut(Symptom::Crc).unwrap() =
            ErrorCounter { cumulative: u32::MAX, threshold_count: 0, threshold: 0 };
        counters.symptom(Symptom::Crc);
        counters.symptom(Symptom::LossOfSoa);
        counters.reset();
        assert_eq!(counters.of(Symptom::Crc), ErrorCounter::new(15));
        assert_eq!(
            counters.of(Symptom::LossOfSoa),
            ErrorCounter { cumulative: 1, threshold_count: 0, threshold: 15 }
        );
    }
}
