//! I/O: nodes that stop answering or answer late, masters that stop asking, and data that cannot be.

use core::time::Duration;

use cip_core::monitor::Flaw;
use link_core::Instant;

use super::Clinic;
use super::finding::{Exchange, Facts};
use super::ledger::Sign;
use super::patient::Seen;
use super::rhythm::Before;
use super::rule::{Rule, Severity};
use crate::id::{Identifier, MacId, Purpose};
use crate::monitor::{Kind, Predefined, Problem, Reading};

impl<const N: usize> Clinic<'_, N> {
    /// A frame of I/O.
    pub(super) fn io(&mut self, reading: &Reading<'_>, identifier: Identifier) {
        let Some(mac) = identifier.mac_id() else { return };
        let is_part = reading.frag.is_some() && reading.message.is_none();
        let seen = Seen { n: reading.n, at: reading.at };
        let before = match lane_of(identifier.purpose()) {
            Some(which) => self.patient(mac).peek(which).last.map(|last| last.at),
            None => self.patient(mac).commanded.replace(seen.at),
        };
        let is_again = self.patient(mac).repeats(seen.at, &reading.frame);
        // An error since the last answer, or the last command: this can be that one again, or the answer to a command that was lost.
        let has_error = self.last_error.is_some_and(|error| before.is_none_or(|before| before <= error));
        let doubt = match (is_again, has_error) {
            (_, true) => Doubt::Error,
            (true, false) => Doubt::Again,
            (false, false) => Doubt::None,
        };
        match identifier.purpose() {
            Purpose::PollCommand if !is_part => self.command(mac, Predefined::Poll, seen),
            Purpose::PollResponse if !is_part => self.answer(mac, Predefined::Poll, seen),
            Purpose::BitStrobeCommand => self.command_to_all(mac, Predefined::BitStrobe, seen),
            Purpose::BitStrobeResponse => self.answer(mac, Predefined::BitStrobe, seen),
            Purpose::MulticastPollCommand if !is_part => {
                self.command_to_all(mac, Predefined::MulticastPoll, seen);
            }
            Purpose::MulticastPollResponse if !is_part => self.answer(mac, Predefined::MulticastPoll, seen),
            Purpose::ChangeOfState => {
                if !is_part {
                    self.produced(mac, reading, doubt);
                }
                self.answer(mac, Predefined::CosCyclic, seen);
            }
            _ => {}
        }
        self.io_problem(reading, mac, doubt, is_part);
    }

    /// A change-of-state or cyclic message of a slave.
    fn produced(&mut self, mac: MacId, reading: &Reading<'_>, doubt: Doubt) {
        let Some(rhythm) = self.records.rhythm(mac) else { return };
        let seen = Seen { n: reading.n, at: reading.at };
        let before = match (reading.problem, doubt) {
            (Some(Problem::Flaw(Flaw::Unacknowledged { .. })), _) => Before::Unacknowledged,
            (_, Doubt::Again | Doubt::Error) => Before::Doubtful,
            (_, Doubt::None) => Before::Sent,
        };
        let message = reading.message.as_ref();
        let data = message.map_or(reading.value(), |message| message.value()).unwrap_or_default();
        if let Some(first) = self.patient(mac).rhythm.message(seen, data, &rhythm, before) {
            self.second_sender(mac, reading, first);
        }
    }

    fn command(&mut self, mac: MacId, which: Predefined, seen: Seen) {
        self.is_served(mac, seen.at);
        if self.records.awaits(mac, which, seen.n) {
            self.patient(mac).lane(which).command(seen);
        }
    }

    fn command_to_all(&mut self, sender: MacId, which: Predefined, seen: Seen) {
        for mac in MacId::all() {
            if self.records.is_addressed(mac, which, sender) {
                self.is_served(mac, seen.at);
                self.patient(mac).lane(which).command(seen);
            }
        }
    }

    fn answer(&mut self, mac: MacId, which: Predefined, seen: Seen) {
        let first = self.patient(mac).lane(which).answer(seen);
        if first.is_some() {
            let doubled = &mut self.patient(mac).doubled;
            *doubled = doubled.saturating_sub(1);
        }
        let is_waited_for =
            |facts: Facts| matches!(facts, Facts::Silence { exchange, .. } if exchange == exchange_of(which));
        if let Some(first) = first {
            let patience = self.records.patience(mac, which);
            self.judge_wait(mac, which, first, seen, patience);
        }
        self.ledger.end_where(Rule::NotAnswering, seen.at, |finding| {
            finding.node == Some(mac) && is_waited_for(finding.facts)
        });
    }

    fn judge_wait(
        &mut self,
        mac: MacId,
        which: Predefined,
        first: Seen,
        answer: Seen,
        patience: Option<Duration>,
    ) {
        let longest = answer.at.saturating_since(first.at);
        let node = Some(mac);
        let Some(patience) = patience else { return };
        if longest >= patience {
            // The peer has given up: that was not slow, that was nothing.
            return self.silent(mac, which, first.at, patience, answer);
        }
        if longest.saturating_mul(100) >= patience.saturating_mul(self.config.slow_percent.into()) {
            self.patient(mac).lane(which).prompt = 0;
            return self.ledger.see(&Sign {
                rule: Rule::SlowAnswers,
                severity: Severity::Warning,
                node,
                facts: Facts::Wait { longest, patience },
                since: first.at,
                at: answer.at,
                frames: [Some(first.n), Some(answer.n)],
            });
        }
        if self.ledger.has_open(Rule::SlowAnswers) {
            let patient = self.patient(mac);
            patient.lane(which).is_in_time();
            if patient.is_prompt() {
                self.ledger.end(Rule::SlowAnswers, node, answer.at);
            }
        }
    }

    fn silent(&mut self, mac: MacId, which: Predefined, since: Instant, patience: Duration, seen: Seen) {
        let lane = *self.patient(mac).peek(which);
        let exchange = exchange_of(which);
        let first = lane.since.or(lane.last).map(|first| first.n);
        let newest = lane.newest.map(|newest| newest.n);
        // How long the peer waits is not known, if its allocation was before all that was heard.
        let is_assumed = self.records.patience(mac, which).is_none() && !self.records.is_allocation_told(mac);
        self.begin_once(&Sign {
            rule: Rule::NotAnswering,
            severity: if is_assumed { Severity::Warning } else { Severity::Error },
            node: Some(mac),
            facts: Facts::Silence { exchange, patience },
            since,
            at: seen.at,
            frames: [first, newest],
        });
    }

    fn io_problem(&mut self, reading: &Reading<'_>, mac: MacId, doubt: Doubt, is_part: bool) {
        let seen = Seen { n: reading.n, at: reading.at };
        let (rule, facts) = match reading.problem {
            Some(Problem::Flaw(Flaw::OutOfSequence { after, found }))
                if doubt != Doubt::None && after == found =>
            {
                return;
            }
            Some(Problem::Flaw(Flaw::IoLength { expected, found })) => {
                (Rule::WrongLength, Facts::Length { expected, found })
            }
            Some(Problem::Flaw(Flaw::OutOfSequence { after, found })) => {
                (Rule::FragmentSequence, Facts::Fragments { after, found })
            }
            Some(Problem::Flaw(Flaw::UnexpectedIoResponse)) if doubt == Doubt::Again => {
                return self.doubled(mac, reading);
            }
            Some(Problem::Flaw(Flaw::UnexpectedIoResponse)) if doubt == Doubt::None => {
                return self.unasked(mac, reading);
            }
            _ if !is_part && is_unasked_from_the_start(reading) => return self.unasked(mac, reading),
            _ => return,
        };
        let node = reading.src.or(reading.dst);
        self.event(rule, Severity::Warning, node, facts, seen);
    }

    /// Which nodes are silent by now.
    pub(super) fn look_at_io(&mut self, now: Instant) {
        for mac in MacId::all() {
            for which in COMMANDED {
                let Some(silence) = self.patient(mac).peek(which).silence(now) else { continue };
                let patience = self.records.patience(mac, which).unwrap_or(self.config.unknown_patience);
                if silence >= patience
                    && let Some(first) = self.patient(mac).peek(which).since
                {
                    self.silent(mac, which, first.at, patience, Seen { n: first.n, at: now });
                }
            }
            self.look_at_changes(mac, now);
        }
    }

    /// A slave that produces by change of state or cyclic does so at its expected packet rate at least.
    fn look_at_changes(&mut self, mac: MacId, now: Instant) {
        let which = Predefined::CosCyclic;
        let Some(active) = self.records.overdue(mac, which, now) else { return };
        let last = self.patient(mac).peek(which).last;
        // What was not acknowledged is the master's fault.
        if last.is_some_and(|last| last.at > active) {
            return;
        }
        let Some(patience) = self.records.patience(mac, which) else { return };
        self.silent(mac, which, active, patience, Seen { n: 0, at: now });
    }

    /// Which masters are silent by now, although they could be heard.
    pub(super) fn look_at_masters(&mut self, now: Instant, deaf_until: Instant) {
        // By the number of the master, and one place for masters that are not known.
        let mut silent: [Option<Neglect>; MacId::COUNT + 1] = [None; MacId::COUNT + 1];
        let place_of = |master: Option<MacId>| master.map_or(MacId::COUNT, MacId::index);
        for mac in MacId::all() {
            let since = self.neglected_since(mac, now).filter(|&since| since > deaf_until);
            let Some(since) = since else { continue };
            let master = self.patient(mac).owner;
            if let Some(slot) = silent.get_mut(place_of(master)) {
                let held = slot.get_or_insert(Neglect { master, slave: mac, slaves: 0, since });
                held.slaves = held.slaves.saturating_add(1);
                held.since = held.since.min(since);
            }
        }
        self.ledger.end_where(Rule::MasterSilent, now, |finding| {
            silent.get(place_of(finding.node)).is_none_or(Option::is_none)
        });
        for Neglect { master, slave, slaves, since } in silent.into_iter().flatten() {
            let facts = Facts::Abandoned { slave, slaves };
            if self.ledger.open(Rule::MasterSilent, master).is_some_and(|held| held.facts == facts) {
                continue;
            }
            let frames = [self.patient(slave).peek(Predefined::Poll).last.map(|last| last.n), None];
            self.ledger.see(&Sign {
                rule: Rule::MasterSilent,
                severity: Severity::Error,
                node: master,
                facts,
                since,
                at: now,
                frames,
            });
        }
    }

    /// Since when a slave waits for its master in vain, which it has always answered.
    fn neglected_since(&mut self, mac: MacId, now: Instant) -> Option<Instant> {
        // The master asks for it, and it is the slave that is silent.
        if self.patient(mac).asked.is_some() {
            return None;
        }
        let commanded = COMMANDED.into_iter().find_map(|which| {
            let lane = self.patient(mac).peek(which);
            lane.last.filter(|_| lane.since.is_none())?;
            self.records.overdue(mac, which, now)
        });
        commanded.or_else(|| {
            let last = self.patient(mac).peek(Predefined::CosCyclic).last?;
            let active = self.records.overdue(mac, Predefined::CosCyclic, now)?;
            (last.at > active).then_some(active)
        })
    }
}

/// Whether a frame is what it seems.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Doubt {
    None,
    /// It is the one before again.
    Again,
    /// There was an error since the last answer of the slave, or of a command since the last command.
    Error,
}

/// A master, and a slave that it leaves alone.
#[derive(Debug, Clone, Copy)]
struct Neglect {
    master: Option<MacId>,
    slave: MacId,
    slaves: u8,
    since: Instant,
}

/// A response to a poll of which none was ever seen.
fn is_unasked_from_the_start(reading: &Reading<'_>) -> bool {
    let is_response = matches!(reading.kind, Kind::PollResponse | Kind::BitStrobeResponse);
    is_response && reading.request.is_none() && reading.assumed
}

/// The kind of I/O that a slave answers with, or produces; an acknowledge answers the latter.
const fn lane_of(purpose: Purpose) -> Option<Predefined> {
    match purpose {
        Purpose::PollResponse => Some(Predefined::Poll),
        Purpose::BitStrobeResponse => Some(Predefined::BitStrobe),
        Purpose::MulticastPollResponse => Some(Predefined::MulticastPoll),
        Purpose::ChangeOfState | Purpose::ChangeOfStateAcknowledge => Some(Predefined::CosCyclic),
        _ => None,
    }
}

pub(super) const fn exchange_of(which: Predefined) -> Exchange {
    match which {
        Predefined::Explicit => Exchange::Explicit,
        Predefined::Poll => Exchange::Poll,
        Predefined::BitStrobe => Exchange::BitStrobe,
        Predefined::CosCyclic => Exchange::ChangeOfState,
        Predefined::MulticastPoll => Exchange::MulticastPoll,
    }
}

const COMMANDED: [Predefined; 3] = [Predefined::Poll, Predefined::BitStrobe, Predefined::MulticastPoll];
