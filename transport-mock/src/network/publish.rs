//! What happened, for sinks, rules and the referee.

use super::{Network, NodeId, OwnedChange, Pending};
use crate::bus::Note;
use crate::change::ChangeKind;
use crate::record::{FrameRecord, Interest, Record, Sink};
use crate::referee::{Rule, Violation};

impl<E: 'static> Network<E> {
    pub(super) fn violation(&mut self, index: usize, rule: &'static str, what: impl FnOnce() -> String) {
        let violation = Violation { node: NodeId::new(index), at: self.now, rule, what: what() };
        self.blame(violation);
    }

    pub(super) fn blame(&mut self, violation: Violation) {
        assert!(!self.config.strict, "seed {}: {violation}", self.config.seed);
        self.pending.push(Pending::Violation(self.violations.len()));
        self.violations.push(violation);
    }

    /// Shows what happened on the bus.
    pub(super) fn publish_bus(&mut self, sink: &mut impl Sink<E>) {
        let mut blamed = Vec::new();
        for attempt in self.bus.finished.as_slice() {
            let Some(record) = FrameRecord::of(attempt) else { continue };
            if let Some(producers) = &mut self.producers {
                producers.see(&record, &mut |violation| blamed.push(violation));
            }
            if self.interest.contains(Interest::FRAMES) {
                show(&mut self.rules, &mut blamed, sink, &Record::Frame(record));
            }
        }
        self.bus.finished.clear();
        for note in self.bus.notes.drain(..) {
            let (record, interest) = match note {
                Note::Error(error) => (Record::Error(error), Interest::ERRORS),
                Note::Counters { at, node, counters } => {
                    (Record::Counters { at, node, counters }, Interest::COUNTERS)
                }
            };
            if self.interest.contains(interest) {
                show(&mut self.rules, &mut blamed, sink, &record);
            }
        }
        blamed.into_iter().for_each(|violation| self.blame(violation));
    }

    /// Shows what was done to the network, before what the bus made of it.
    pub(super) fn publish_changes(&mut self, sink: &mut impl Sink<E>) {
        let is_change = |one: &Pending<E>| matches!(one, Pending::Change { .. });
        let others = self.pending.iter().position(|one| !is_change(one)).unwrap_or(self.pending.len());
        if others > 0 {
            let later = self.pending.split_off(others);
            self.publish(sink);
            self.pending.extend(later);
        }
    }

    /// Shows what the machines did.
    pub(super) fn publish(&mut self, sink: &mut impl Sink<E>) {
        while !self.pending.is_empty() {
            let mut pending = std::mem::take(&mut self.pending);
            let mut blamed = Vec::new();
            for one in pending.drain(..) {
                let record = match &one {
                    &Pending::Request { at, node, token, frame } => {
                        Record::Request { at, node, token, frame }
                    }
                    &Pending::Done { at, node, token, outcome } => Record::Done { at, node, token, outcome },
                    Pending::Event { at, node, event } => Record::Event { at: *at, node: *node, event },
                    Pending::Change { at, change } => Record::Change {
                        at: *at,
                        change: match change {
                            OwnedChange::Plain(change) => *change,
                            OwnedChange::Split(apart) => ChangeKind::Split(apart),
                        },
                    },
                    Pending::Violation(index) => {
                        if !self.interest.contains(Interest::VIOLATIONS) {
                            continue;
                        }
                        Record::Violation(&self.violations[*index])
                    }
                };
                show(&mut self.rules, &mut blamed, sink, &record);
            }
            // The memory is used again, unless somebody has added to the new one.
            if self.pending.is_empty() {
                self.pending = pending;
            }
            blamed.into_iter().for_each(|violation| self.blame(violation));
        }
    }
}

fn show<E>(
    rules: &mut [Box<dyn Rule<E>>],
    blamed: &mut Vec<Violation>,
    sink: &mut impl Sink<E>,
    record: &Record<'_, E>,
) {
    for rule in rules {
        rule.see(record, &mut |violation| blamed.push(violation));
    }
    sink.record(record);
}
