//! What anybody on the cable can cause as often as they like: equal events are told once a second, with their number.

use core::time::Duration;

use link_core::Instant;
use serde_json::{Map, Value};

/// Events that are held back for a while. Of each name there are not more than [`DIFFERENT`]; further ones are counted together.
#[derive(Default)]
pub(super) struct Folds {
    folds: Vec<Fold>,
}

/// An event with its fields, as it is told.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Told {
    pub(super) name: String,
    pub(super) fields: Map<String, Value>,
    pub(super) words: String,
}

struct Fold {
    /// Without fields and words: all that are different from those that are kept.
    told: Told,
    /// When it was told.
    at: Instant,
    /// How often it came since.
    more: u64,
}

impl Folds {
    /// Whether it is one of those that come again and again.
    pub(super) fn concern(told: &Told) -> bool {
        FOLDED.contains(&&*told.name)
    }

    /// Takes an event. Whether it is to be told now; otherwise [`due`](Self::due) will tell of it.
    pub(super) fn admit(&mut self, now: Instant, told: &Told) -> bool {
        if let Some(fold) = self.folds.iter_mut().find(|fold| fold.told == *told) {
            fold.more += 1;
            return false;
        }
        let different = self.folds.iter().filter(|fold| fold.told.name == told.name).count();
        let is_told = different < DIFFERENT || OF_NODES.contains(&&*told.name);
        let told = match is_told {
            true => told.clone(),
            false => Told { name: told.name.clone(), fields: Map::new(), words: String::new() },
        };
        match self.folds.iter_mut().find(|fold| fold.told == told) {
            Some(fold) => fold.more += 1,
            None => self.folds.push(Fold { told, at: now, more: u64::from(!is_told) }),
        }
        is_told
    }

    /// What has been held back long enough.
    pub(super) fn due(&mut self, now: Instant) -> Vec<Told> {
        if self.folds.iter().all(|fold| now.saturating_since(fold.at) < WHILE) {
            return Vec::new();
        }
        self.take(|fold| now.saturating_since(fold.at) >= WHILE, now)
    }

    /// All that is held back.
    pub(super) fn rest(&mut self, now: Instant) -> Vec<Told> {
        self.take(|_| true, now)
    }

    /// What came again is told, and may come again; what did not is forgotten.
    fn take(&mut self, is_over: impl Fn(&Fold) -> bool, now: Instant) -> Vec<Told> {
        self.folds.retain(|fold| fold.more > 0 || !is_over(fold));
        let over = self.folds.iter_mut().filter(|fold| is_over(fold));
        over.map(|fold| {
            let told = fold.line(now);
            (fold.at, fold.more) = (now, 0);
            told
        })
        .collect()
    }
}

impl Fold {
    /// `bad frame: .. (17 more in 1.0 s)`
    fn line(&self, now: Instant) -> Told {
        let Self { told, at, more } = self;
        let span = now.saturating_since(*at).as_secs_f64();
        let words = match &*told.words {
            "" => format!("{}: {more} others in {span:.1} s", told.name.replace('_', " ")),
            words => format!("{words} ({more} more in {span:.1} s)"),
        };
        let mut fields = told.fields.clone();
        fields.insert("count".into(), (*more).into());
        Told { name: told.name.clone(), fields, words }
    }
}

/// Those that frames of strangers cause, and what fails in every cycle.
const FOLDED: &[&str] = &[
    "bad_frame",
    "error",
    "node_error",
    "foreign_frame",
    "sdo_refused",
    "sdo_aborted",
    "other_managing_node",
    "unknown_node",
    "address_conflict",
    "value_refused",
    "value_unreadable",
    "pres_lost",
    "pres_late",
    "cycle_exceeded",
];
/// Those that differ by the node of the plan alone: each is told with its node.
const OF_NODES: &[&str] = &["pres_lost", "pres_late"];
/// How many different ones of any other name are told apart.
const DIFFERENT: usize = 4;
/// How long equal ones are only counted.
const WHILE: Duration = Duration::from_secs(1);

#[cfg(test)]
mod tests {
    use super::*;

    fn bad_frame(words: &str) -> Told {
        let fields = [("value".to_owned(), words.into())].into_iter().collect();
        Told { name: "bad_frame".into(), fields, words: format!("bad frame: {words}") }
    }

    fn at(millis: u64) -> Instant {
        Instant::from_millis(millis)
    }

    fn words(told: &[Told]) -> Vec<&str> {
        told.iter().map(|told| &*told.words).collect()
    }

    #[test]
    fn equal_ones_are_told_once_a_second_with_their_number() {
        let mut folds = Folds::default();
        assert!(folds.admit(at(0), &bad_frame("short")));
        for millis in 1..=900 {
            assert!(!folds.admit(at(millis), &bad_frame("short")));
            assert_eq!(folds.due(at(millis)), []);
        }
        let due = folds.due(at(1_000));
        assert_eq!(words(&due), ["bad frame: short (900 more in 1.0 s)"]);
        assert_eq!((&due[0].fields["count"], &due[0].fields["value"]), (&900.into(), &"short".into()));
        // The flood goes on, then ends.
        assert!(!folds.admit(at(1_500), &bad_frame("short")));
        assert_eq!(words(&folds.due(at(2_500))), ["bad frame: short (1 more in 1.5 s)"]);
        assert_eq!(folds.due(at(3_500)), []);
        assert!(folds.admit(at(3_600), &bad_frame("short")));
    }

    /// A cable is pulled: each node of the plan has a line, which says whom it is about.
    #[test]
    fn every_node_that_is_missed_is_named() {
        let lost = |node: u8| {
            let fields = [("node".to_owned(), node.into())].into_iter().collect();
            Told { name: "pres_lost".into(), fields, words: format!("PRes of node {node} lost") }
        };
        let mut folds = Folds::default();
        assert!((1..=239).all(|node| folds.admit(at(0), &lost(node))));
        assert!((1..=239).all(|node| !folds.admit(at(20), &lost(node))));
        let due = folds.due(at(1_000));
        assert_eq!(due.len(), 239);
        assert!(due.iter().zip(1..=239).all(|(told, node)| told.fields["node"] == node));
    }

    #[test]
    fn different_ones_are_counted_together_beyond_a_few() {
        let mut folds = Folds::default();
        let told =
            (0..100).filter(|number| folds.admit(at(*number), &bad_frame(&number.to_string()))).count();
        assert_eq!(told, DIFFERENT);
        assert!(folds.folds.len() <= DIFFERENT + 1);
        assert!(!folds.admit(at(100), &bad_frame("2")));
        let rest = folds.rest(at(200));
        assert_eq!(words(&rest), ["bad frame: 2 (1 more in 0.2 s)", "bad frame: 96 others in 0.2 s"]);
        assert_eq!(rest[1].fields.keys().collect::<Vec<_>>(), ["count"]);
    }
}
