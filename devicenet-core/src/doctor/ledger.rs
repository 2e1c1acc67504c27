//! The findings, present and past, in fixed storage.

use core::time::Duration;

use link_core::Instant;

use super::finding::{Change, ChangeKind, Evidence, Facts, Finding};
use super::rule::{Rule, Severity};
use crate::id::MacId;

/// Something seen that makes a finding, or adds to one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Sign {
    pub(super) rule: Rule,
    pub(super) severity: Severity,
    pub(super) node: Option<MacId>,
    pub(super) facts: Facts,
    pub(super) since: Instant,
    pub(super) at: Instant,
    /// The frames that show it.
    pub(super) frames: [Option<u64>; 2],
}

/// What did not fit into a doctor's storage. All zero means that nothing was lost.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Forgotten {
    /// Findings that were over, given up for newer ones.
    pub past: u64,
    /// Findings that were not over, given up for worse ones, or never kept: each rule and node once, however long it lasts.
    pub present: u64,
    /// Changes of findings given up that nobody had asked for.
    pub changes: u64,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct Entry {
    finding: Finding,
    /// When what is wrong began for the last time: a finding outlives pauses.
    again: Instant,
    /// When it had ceased before that.
    ceased: Option<Instant>,
    untold: Untold,
}

/// What [`Ledger::poll`] has not told yet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
struct Untold {
    begins: bool,
    escalates: bool,
    ends: bool,
}

/// The findings, the oldest first.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Ledger<const N: usize> {
    entries: heapless::Vec<Entry, N>,
    /// The rules that have a finding which is not over.
    open: u32,
    next_id: u32,
    has_news: bool,
    /// By rule, the nodes of findings that were never kept; the last bit is for those of no node.
    turned_away: [u128; Rule::ALL.len()],
    pub(super) forgotten: Forgotten,
}

impl<const N: usize> Ledger<N> {
    pub(super) const fn new() -> Self {
        Self {
            entries: heapless::Vec::new(),
            open: 0,
            next_id: 1,
            has_news: false,
            turned_away: [0; Rule::ALL.len()],
            forgotten: Forgotten { past: 0, present: 0, changes: 0 },
        }
    }

    pub(super) fn findings(&self) -> impl DoubleEndedIterator<Item = &Finding> {
        self.entries.iter().map(|entry| &entry.finding)
    }

    /// The finding of a rule and a node that is not over.
    pub(super) fn open(&self, rule: Rule, node: Option<MacId>) -> Option<&Finding> {
        self.has_open(rule).then_some(())?;
        self.findings().find(|finding| finding.rule == rule && finding.node == node && !finding.is_over())
    }

    /// Whether a rule has a finding that is not over. One look, for where every frame passes.
    pub(super) fn has_open(&self, rule: Rule) -> bool {
        self.open & rule.bit() != 0
    }

    /// Begins a finding, or adds to the one that there is.
    pub(super) fn see(&mut self, sign: &Sign) {
        if let Some(entry) = self.entries.iter_mut().find(|entry| entry.finding.is_of(sign)) {
            entry.add(sign);
        } else {
            self.begin(sign);
        }
        self.open |= sign.rule.bit();
        self.has_news = true;
    }

    /// Makes what was seen more exact.
    pub(super) fn amend(&mut self, rule: Rule, node: MacId, better: impl Fn(Facts) -> Facts) {
        if !self.has_open(rule) {
            return;
        }
        let open = self.entries.iter_mut().filter(|entry| !entry.finding.is_over());
        let is_it = |entry: &&mut Entry| (entry.finding.rule, entry.finding.node) == (rule, Some(node));
        open.filter(is_it).for_each(|entry| entry.finding.facts = better(entry.finding.facts));
    }

    /// Ends the finding of a rule and a node.
    pub(super) fn end(&mut self, rule: Rule, node: Option<MacId>, at: Instant) {
        self.end_where(rule, at, |finding| finding.node == node);
    }

    /// Ends the findings of a rule that a condition applies to.
    pub(super) fn end_where(&mut self, rule: Rule, at: Instant, applies: impl Fn(&Finding) -> bool) {
        if !self.has_open(rule) {
            return;
        }
        let open = self.entries.iter_mut().filter(|entry| !entry.finding.is_over());
        for entry in open.filter(|entry| entry.finding.rule == rule) {
            if applies(&entry.finding) {
                entry.end(at);
                self.has_news = true;
            }
        }
        self.note_open();
    }

    /// What time alone does: findings subside, and faults that stay are worse.
    pub(super) fn age(&mut self, now: Instant, quiet: Duration, stuck: Duration) {
        if self.open == 0 {
            return;
        }
        for entry in self.entries.iter_mut().filter(|entry| !entry.finding.is_over()) {
            let finding = entry.finding;
            if finding.subsides() && now.saturating_since(finding.last) >= quiet {
                entry.end(finding.last + quiet);
                self.has_news = true;
            } else if finding.rule == Rule::Fault && finding.last.saturating_since(finding.since) >= stuck {
                // It was told again, so long after.
                entry.escalate(Severity::Error);
                self.has_news = true;
            }
        }
        self.note_open();
    }

    /// The next piece of news.
    pub(super) fn poll(&mut self) -> Option<Change> {
        if !self.has_news {
            return None;
        }
        let change = self.entries.iter_mut().find_map(Entry::news);
        self.has_news = change.is_some();
        change
    }

    fn begin(&mut self, sign: &Sign) {
        if self.entries.is_full() && !self.make_room(sign.severity) {
            return self.turn_away(sign);
        }
        let finding = Finding {
            id: self.next_id,
            rule: sign.rule,
            severity: sign.severity,
            node: sign.node,
            since: sign.since,
            last: sign.at,
            until: None,
            count: 1,
            evidence: evidence(Evidence::default(), sign),
            facts: sign.facts,
            first_cause: self.first_cause(sign),
        };
        self.next_id = self.next_id.saturating_add(1);
        // There is room by now, unless there never is any.
        let untold = Untold { begins: true, ..Untold::default() };
        let entry = Entry { finding, again: sign.since, ceased: None, untold };
        if self.entries.push(entry).is_err() {
            self.turn_away(sign);
        }
    }

    /// There is no room. What lasts is seen again and again, and counts once.
    fn turn_away(&mut self, sign: &Sign) {
        let nodes = self.turned_away.get_mut(sign.rule.index());
        let bit = 1_u128.rotate_left(sign.node.map_or(u128::BITS - 1, |mac| mac.number().into()));
        if let Some(nodes) = nodes.filter(|nodes| **nodes & bit == 0) {
            *nodes |= bit;
            self.forgotten.present = self.forgotten.present.saturating_add(1);
        }
    }

    /// Gives up the oldest finding that is over, else the oldest of the least severe if that is less than the new one.
    fn make_room(&mut self, severity: Severity) -> bool {
        let over = self.entries.iter().position(|entry| entry.finding.is_over());
        let least = || {
            let worst = |(_, entry): &(usize, &Entry)| entry.finding.severity;
            let (index, entry) = self.entries.iter().enumerate().min_by_key(worst)?;
            (entry.finding.severity < severity).then_some(index)
        };
        let Some(index) = over.or_else(least) else { return false };
        let entry = self.entries.remove(index);
        let counter = if over.is_some() { &mut self.forgotten.past } else { &mut self.forgotten.present };
        *counter = counter.saturating_add(1);
        let untold = [entry.untold.begins, entry.untold.escalates, entry.untold.ends];
        let untold = untold.into_iter().filter(|untold| *untold).map(|_| 1_u64);
        self.forgotten.changes = self.forgotten.changes.saturating_add(untold.sum());
        self.note_open();
        true
    }

    /// What was wrong with the node, or with the bus, before that.
    fn first_cause(&self, sign: &Sign) -> Option<Rule> {
        let causes = causes_of(sign.rule);
        let precedes = |entry: &&Entry| {
            let node = entry.finding.node;
            (node.is_none() || node == sign.node) && entry.explains(sign.since)
        };
        let known =
            |&cause: &Rule| self.entries.iter().filter(precedes).any(|entry| entry.finding.rule == cause);
        causes.iter().copied().find(known)
    }

    fn note_open(&mut self) {
        let open = self.entries.iter().filter(|entry| !entry.finding.is_over());
        self.open = open.fold(0, |set, entry| set | entry.finding.rule.bit());
    }
}

impl Finding {
    /// Since when nothing is wrong any more; `None` as long as something is. When it is told to be over can be long after.
    fn ceased(&self) -> Option<Instant> {
        if self.is_burst() { Some(self.last) } else { self.until }
    }

    /// What is seen is this finding again: it is not over, or not for long.
    fn is_of(&self, sign: &Sign) -> bool {
        let is_same = self.rule == sign.rule && self.node == sign.node;
        // Devices without a MAC ID are told apart.
        let is_same = is_same && (self.rule != Rule::WaitingForRecovery || self.facts == sign.facts);
        is_same && self.until.is_none_or(|until| sign.since.saturating_since(until) <= RELAPSE)
    }
}

impl Entry {
    /// Whether what began at `since` can come of it: it was wrong by then, and not right again for long.
    fn explains(&self, since: Instant) -> bool {
        let present = (self.again, self.finding.ceased());
        let before = self.ceased.map(|ceased| (self.finding.since, Some(ceased)));
        [Some(present), before].into_iter().flatten().any(|(began, ceased)| {
            began <= since && ceased.is_none_or(|ceased| since.saturating_since(ceased) <= AFTERMATH)
        })
    }

    fn add(&mut self, sign: &Sign) {
        let finding = &mut self.finding;
        // What is told again can have begun before the last time.
        let began = if sign.since > finding.last { sign.since } else { sign.at };
        if let Some(ceased) = finding.ceased().filter(|&ceased| began.saturating_since(ceased) > AFTERMATH) {
            (self.again, self.ceased) = (began, Some(ceased));
        }
        finding.count = finding.count.saturating_add(1);
        finding.last = finding.last.max(sign.at);
        finding.facts = worse(finding.facts, sign.facts);
        finding.evidence = evidence(finding.evidence, sign);
        if finding.until.take().is_some() {
            // Whoever was not told of the end need not be told of the beginning.
            let is_news = !core::mem::take(&mut self.untold.ends);
            self.untold.begins |= is_news;
        }
        self.escalate(sign.severity);
    }

    fn escalate(&mut self, severity: Severity) {
        if severity > self.finding.severity {
            self.finding.severity = severity;
            self.untold.escalates = !self.untold.begins;
        }
    }

    fn end(&mut self, at: Instant) {
        self.finding.until = Some(at.max(self.finding.last));
        self.untold.ends = true;
    }

    /// Takes the next piece of news: it begins before it ends.
    fn news(&mut self) -> Option<Change> {
        let Untold { begins, escalates, ends } = &mut self.untold;
        let kinds =
            [(begins, ChangeKind::Begins), (escalates, ChangeKind::Escalates), (ends, ChangeKind::Ends)];
        for (untold, kind) in kinds {
            if core::mem::take(untold) {
                return Some(Change { kind, finding: self.finding });
            }
        }
        None
    }
}

fn evidence(mut evidence: Evidence, sign: &Sign) -> Evidence {
    sign.frames.into_iter().flatten().for_each(|n| evidence.add(n));
    evidence
}

/// Of two observations of one finding the one that tells more.
fn worse(before: Facts, now: Facts) -> Facts {
    match (before, now) {
        (Facts::Wait { longest: held, .. }, Facts::Wait { longest, patience }) => {
            Facts::Wait { longest: longest.max(held), patience }
        }
        (Facts::Load { peak_permille: held }, Facts::Load { peak_permille }) => {
            Facts::Load { peak_permille: peak_permille.max(held) }
        }
        (Facts::Errors { kinds: held, .. }, Facts::Errors { kinds, .. }) if held.total() > kinds.total() => {
            before
        }
        (Facts::Lost(held), Facts::Lost(lost)) => Facts::Lost(held.saturating_add(lost)),
        (Facts::Rivals { holder: a, rival: b }, Facts::Rivals { holder, rival }) => {
            Facts::Rivals { holder: holder.or(a), rival: rival.or(b) }
        }
        (_, now) => now,
    }
}

/// The rules that explain a finding of this one, the best explanation first.
const fn causes_of(rule: Rule) -> &'static [Rule] {
    match rule {
        Rule::NotAnswering | Rule::NotFound => &[
            Rule::DuplicateMacId,
            Rule::WaitingForRecovery,
            Rule::Left,
            Rule::Restarted,
            Rule::Fault,
            Rule::BusOff,
            Rule::NotAcknowledged,
            Rule::ErrorFrames,
            Rule::Overrun,
            Rule::BusLoad,
        ],
        Rule::SlowAnswers => &[Rule::BusLoad, Rule::ErrorFrames, Rule::Overrun],
        Rule::MasterSilent => {
            &[Rule::DuplicateMacId, Rule::Left, Rule::Restarted, Rule::BusOff, Rule::ErrorFrames]
        }
        Rule::WaitingForRecovery => &[Rule::DuplicateMacId],
        Rule::AllocationRefused => &[Rule::TwoMasters],
        Rule::KeyMismatch => &[Rule::IdentityChanged],
        Rule::BusOff | Rule::ErrorPassive => &[Rule::ErrorFrames, Rule::NotAcknowledged],
        Rule::FragmentSequence => &[Rule::IdentifierCollision, Rule::ErrorFrames, Rule::Overrun],
        Rule::DuplicateMacId
        | Rule::Fault
        | Rule::SizeMismatch
        | Rule::IdentityChanged
        | Rule::TwoMasters
        | Rule::ForeignMacId
        | Rule::UnexpectedAllocation
        | Rule::IdentifierCollision
        | Rule::ErrorFrames
        | Rule::NotAcknowledged
        | Rule::ForeignTraffic
        | Rule::BusLoad
        | Rule::Overrun
        | Rule::WrongLength
        | Rule::Restarted
        | Rule::Left => &[],
    }
}

/// Whatever is there again so soon was never away.
const RELAPSE: Duration = Duration::from_secs(10);
/// So long after it has ceased, what is wrong explains something else. A longer pause has something before it and something after.
const AFTERMATH: Duration = Duration::from_secs(5);
