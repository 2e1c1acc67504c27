//! What the network does is told as it happens, but no more often than anybody can read: the rest of a second is told with its number
//! and its end.

use core::time::Duration;
use std::collections::BTreeMap;

use link_core::Instant;

use super::folds::Told;

/// Of each name, and of each node, so many a second.
#[derive(Default)]
pub(super) struct Limits {
    kinds: BTreeMap<(String, Option<u64>), Kind>,
}

struct Kind {
    /// The begin of its second.
    since: Instant,
    told: u32,
    /// What was held back: how many, and the last.
    more: Option<(u64, Told)>,
}

impl Limits {
    /// Takes an event. Whether it is to be told now; otherwise [`due`](Self::due) will tell of it.
    pub(super) fn admit(&mut self, now: Instant, told: &Told) -> bool {
        let node = told.fields.get("node").and_then(serde_json::Value::as_u64);
        let kind = self.kinds.entry((told.name.clone(), node));
        let kind = kind.or_insert(Kind { since: now, told: 0, more: None });
        if kind.told < most(&told.name) {
            kind.told += 1;
            return true;
        }
        let before = kind.more.as_ref().map_or(0, |(count, _)| *count);
        kind.more = Some((before + 1, told.clone()));
        false
    }

    /// What was held back for a second.
    pub(super) fn due(&mut self, now: Instant) -> Vec<Told> {
        if self.kinds.values().all(|kind| now.saturating_since(kind.since) < SECOND) {
            return Vec::new();
        }
        self.take(now, |kind| now.saturating_since(kind.since) >= SECOND)
    }

    /// All that is held back.
    pub(super) fn rest(&mut self, now: Instant) -> Vec<Told> {
        self.take(now, |_| true)
    }

    fn take(&mut self, now: Instant, is_over: impl Fn(&Kind) -> bool) -> Vec<Told> {
        let mut due = Vec::new();
        self.kinds.retain(|_, kind| {
            if !is_over(kind) {
                return true;
            }
            let since = core::mem::replace(&mut kind.since, now);
            kind.told = 0;
            let Some((count, last)) = kind.more.take() else { return false };
            due.push(line(last, count, now.saturating_since(since)));
            true
        });
        due
    }
}

/// `PreOperational1 -> PreOperational2: SoC (the last of 17 more in 1.0 s)`
fn line(mut last: Told, count: u64, span: Duration) -> Told {
    last.words += &format!(" (the last of {count} more in {:.1} s)", span.as_secs_f64());
    last.fields.insert("count".into(), count.into());
    last
}

/// A node starts with about 20 changes of its state; process data change in every cycle, and many objects are written in a row.
fn most(name: &str) -> u32 {
    match name {
        "inputs" | "outputs" | "object_written" => 100,
        _ => 30,
    }
}

const SECOND: Duration = Duration::from_secs(1);

#[cfg(test)]
mod tests {
    use serde_json::Map;

    use super::*;

    fn told(name: &str, node: u64, words: &str) -> Told {
        let fields = Map::from_iter([("node".to_owned(), node.into())]);
        Told { name: name.into(), fields, words: words.into() }
    }

    fn at(millis: u64) -> Instant {
        Instant::from_millis(millis)
    }

    #[test]
    fn the_rest_of_a_second_is_told_with_its_number_and_its_end() {
        let mut limits = Limits::default();
        let change = |number: u64| told("state_changed", 1, &format!("change {number}"));
        let count = (0..500).filter(|number| limits.admit(at(*number), &change(*number))).count();
        assert_eq!(count, 30);
        // Of another node, or of another name.
        assert!(limits.admit(at(500), &told("state_changed", 2, "change")));
        assert!(limits.admit(at(500), &told("error_led", 1, "on")));
        assert_eq!(limits.due(at(999)), []);
        let due = limits.due(at(1_000));
        assert_eq!(due.len(), 1);
        assert_eq!(due[0].words, "change 499 (the last of 470 more in 1.0 s)");
        assert_eq!((&due[0].fields["count"], &due[0].fields["node"]), (&470.into(), &1.into()));
        // The next second has as many again, and then nothing is left.
        assert!(limits.admit(at(1_001), &change(0)));
        assert_eq!(limits.due(at(2_000)), []);
        assert!(limits.kinds.is_empty() && limits.rest(at(2_000)).is_empty());
    }
}
