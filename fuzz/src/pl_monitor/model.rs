//! What is to be counted: a second, small program that looks at the bytes of each frame by their offsets.

use core::time::Duration;
use std::collections::HashMap;

use link_core::Instant;
use powerlink_core::monitor::{Captured, Kind, MAX_HISTORY, Monitor, NodeRecord, Reading};

use super::look::Look;

/// The network as the frames tell it.
#[derive(Default)]
pub(super) struct Model {
    /// By their numbers; also whoever is commanded without having been heard.
    nodes: HashMap<u8, Node>,
    polled: Option<u8>,
    slot: Slot,
    cycle: Cycle,
    /// Pairs of nodes that speak SDO, with the number of their last frame.
    connections: Vec<([u8; 2], u64)>,
    evicted: u64,
}

#[derive(Default)]
struct Node {
    frames: u64,
    mac: Option<[u8; 6]>,
    states: Vec<(u64, u8)>,
    ident: Option<u64>,
    polls: u64,
    poll: Poll,
    pres_missing: u64,
    pres_late: u64,
    answers_missing: u64,
    is_resetting: bool,
    sends_several: bool,
}

#[derive(Default, PartialEq)]
enum Poll {
    #[default]
    Never,
    Waiting,
    Missed,
    Answered,
}

#[derive(Default)]
enum Slot {
    #[default]
    Unknown,
    Closed,
    Open {
        service: u8,
        target: u8,
        is_answered: bool,
    },
}

#[derive(Default)]
struct Cycle {
    socs: u64,
    missing: u64,
    intervals: Vec<Duration>,
    last: Option<(Instant, u64)>,
    period: Option<u64>,
}

/// What a frame shows to be wrong; of several the decoder tells one.
#[derive(Default)]
pub(super) struct Expected(Vec<&'static str>);

impl Expected {
    /// What is to be told is told, and what is told of this kind is so.
    pub(super) fn check(&self, reading: &Reading<'_>) {
        let Self(codes) = self;
        let told = reading.problem.map(|problem| problem.code());
        assert!(codes.is_empty() || told.is_some(), "{codes:?} is not told: {reading}");
        if let Some(told) = told.filter(|told| COUNTED.contains(told)) {
            assert!(codes.contains(&told), "{told} of {codes:?}: {reading}");
        }
    }

    fn add(&mut self, is_so: bool, code: &'static str) {
        if is_so {
            self.0.push(code);
        }
    }
}

impl Model {
    /// Takes note of frame number `n`.
    pub(super) fn observe(&mut self, at: Instant, n: u64, frame: Captured<'_>, look: &Look<'_>) -> Expected {
        let mut expected = Expected::default();
        let Some(&[_, to, from]) = look.powerlink.get(..3).filter(|_| look.kind != Kind::Invalid) else {
            return expected;
        };
        let is_cut = frame.bytes.len() < frame.length && !look.is_whole;
        let sender = self.nodes.entry(from).or_default();
        sender.frames += 1;
        sender.is_resetting = false;
        let before = sender.mac.replace(look.source);
        expected.add(before.is_some_and(|before| before != look.source), "two_sources");
        if matches!(look.kind, Kind::Soc | Kind::Preq | Kind::Soa) || (look.kind, from) == (Kind::Pres, 240) {
            let awaited = self.polled.take().and_then(|node| self.nodes.get_mut(&node));
            if let Some(node) = awaited.filter(|node| node.poll == Poll::Waiting) {
                node.poll = Poll::Missed;
                node.pres_missing += 1;
                expected.add(true, "pres_missing");
            }
        }
        if matches!(look.kind, Kind::Soc | Kind::Soa) {
            expected.add(self.ends_unanswered(), "answer_missing");
        }
        match look.kind {
            Kind::Soc => {
                if !matches!(self.slot, Slot::Unknown) {
                    self.slot = Slot::Closed;
                }
                expected.add(self.cycle.observe(at, look) > 0, "soc_missing");
            }
            Kind::Soa if look.is_whole => {
                self.slot =
                    Slot::Open { service: look.powerlink[6], target: look.powerlink[7], is_answered: false };
                if look.powerlink[3] == 0x1D {
                    self.cycle.last = None;
                }
            }
            Kind::Soa => self.slot = Slot::Unknown,
            Kind::Preq => {
                let node = self.nodes.entry(to).or_default();
                node.polls += 1;
                node.poll = Poll::Waiting;
                self.polled = Some(to);
            }
            Kind::Pres => self.respond(from, &mut expected),
            Kind::AsndIdentResponse
            | Kind::AsndStatusResponse
            | Kind::AsndNmtRequest
            | Kind::AsndNmtCommand
            | Kind::AsndSdo
            | Kind::AsndOther => {
                let is_invited = self.use_slot(from, look.kind);
                expected.add(!is_invited, "not_invited");
                self.asynchronous(n, (to, from), look);
            }
            Kind::Amni | Kind::Ainv | Kind::Reserved | Kind::Foreign | Kind::Invalid => {}
        }
        if let Some(state) = look.state(is_cut) {
            let states = &mut self.nodes.entry(from).or_default().states;
            if states.last().is_none_or(|&(_, last)| last != state) {
                states.push((n, state));
            }
        }
        expected
    }

    fn respond(&mut self, from: u8, expected: &mut Expected) {
        let node = self.nodes.entry(from).or_default();
        match node.poll {
            // PRes chaining knows no PReq.
            Poll::Never => return,
            Poll::Waiting => {}
            Poll::Missed => {
                node.pres_late += 1;
                expected.add(true, "pres_late");
            }
            Poll::Answered => expected.add(true, "pres_without_preq"),
        }
        node.poll = Poll::Answered;
    }

    fn ends_unanswered(&mut self) -> bool {
        let Slot::Open { service: 0x01 | 0x02, target, is_answered: false } = self.slot else { return false };
        // Whoever was never heard, or is being reset, has nothing to answer.
        match self.nodes.get_mut(&target) {
            Some(node) if node.frames > 0 && !node.is_resetting => {
                node.answers_missing += 1;
                true
            }
            _ => false,
        }
    }

    fn use_slot(&mut self, from: u8, kind: Kind) -> bool {
        let sender = self.nodes.entry(from).or_default();
        if sender.states.last().is_some_and(|&(_, state)| state == 0x1E) {
            return true;
        }
        let Slot::Open { service, target, is_answered } = &mut self.slot else {
            return matches!(self.slot, Slot::Unknown);
        };
        let is_asked_for = match *service {
            0x00 => false,
            0x01 => kind == Kind::AsndIdentResponse,
            0x02 => kind == Kind::AsndStatusResponse,
            _ => !matches!(kind, Kind::AsndIdentResponse | Kind::AsndStatusResponse),
        };
        let is_invited = *target == from && is_asked_for && (sender.sends_several || !*is_answered);
        *is_answered |= is_invited;
        is_invited
    }

    fn asynchronous(&mut self, n: u64, (to, from): (u8, u8), look: &Look<'_>) {
        match look.kind {
            Kind::AsndIdentResponse if look.is_whole => {
                let node = self.nodes.entry(from).or_default();
                node.ident = Some(n);
                // FeatureFlags, bit 16.
                node.sends_several = look.powerlink[12] & 0x01 != 0;
            }
            Kind::AsndNmtCommand if look.is_whole => {
                self.command(to, look.powerlink[4], &look.powerlink[6..])
            }
            Kind::AsndSdo if look.is_whole => {
                let ends = if to < from { [to, from] } else { [from, to] };
                match self.connections.iter_mut().find(|(known, _)| *known == ends) {
                    Some((_, last)) => *last = n,
                    None => {
                        if self.connections.len() == CONNECTIONS {
                            self.connections.sort_by_key(|(_, last)| *last);
                            self.connections.remove(0);
                            self.evicted += 1;
                        }
                        self.connections.push((ends, n));
                    }
                }
            }
            _ => {}
        }
    }

    fn command(&mut self, to: u8, command: u8, list: &[u8]) {
        let is_extended = match command {
            0x28..=0x2B => false,
            0x48..=0x4B => true,
            _ => return,
        };
        for node in (0..=u8::MAX).filter(|&node| to == node || to == 0xFF) {
            let is_listed = list.get(usize::from(node / 8)).is_some_and(|byte| byte >> (node % 8) & 1 != 0);
            if is_extended && !is_listed {
                continue;
            }
            let node = self.nodes.entry(node).or_default();
            node.is_resetting = true;
            node.poll = Poll::Never;
        }
    }

    /// The records say the same.
    pub(super) fn check(&self, monitor: &Monitor) {
        let mut known: Vec<u8> =
            self.nodes.iter().filter(|(_, node)| node.is_known()).map(|(&id, _)| id).collect();
        known.sort_unstable();
        assert_eq!(monitor.nodes().map(|record| record.node.0).collect::<Vec<_>>(), known);
        monitor.nodes().for_each(|record| self.nodes[&record.node.0].check(record));
        self.cycle.check(monitor);
        assert_eq!(monitor.lost().connections, self.evicted);
    }
}

impl Node {
    fn is_known(&self) -> bool {
        self.frames > 0 || self.polls > 0
    }

    fn check(&self, record: &NodeRecord) {
        assert_eq!((record.frames, record.mac.map(|mac| mac.0)), (self.frames, self.mac), "{record:?}");
        assert_eq!(
            (record.polls, record.pres_missing, record.pres_late, record.answers_missing),
            (self.polls, self.pres_missing, self.pres_late, self.answers_missing),
            "{record:?}"
        );
        assert_eq!(record.state.map(|state| state.0), self.states.last().map(|&(_, state)| state));
        let history: Vec<_> = record.history.iter().map(|change| (change.n, change.state.0)).collect();
        let forgotten = self.states.len().saturating_sub(MAX_HISTORY);
        assert_eq!(history, self.states[forgotten..]);
        assert_eq!(record.forgotten, forgotten as u64);
        assert_eq!(record.ident.is_some(), self.ident.is_some());
    }
}

impl Cycle {
    /// How many SoCs before this one are missing.
    fn observe(&mut self, at: Instant, look: &Look<'_>) -> u64 {
        self.socs += 1;
        let Some(relative) = look.powerlink.get(14..22) else {
            self.last = None;
            return 0;
        };
        let relative = u64::from_le_bytes(relative.try_into().expect("eight"));
        let Some((before, last)) = self.last.replace((at, relative)) else { return 0 };
        let interval = at.checked_since(before);
        let missing = match relative.checked_sub(last) {
            // The managing node has started again.
            None => {
                self.period = None;
                return 0;
            }
            Some(0) => interval.map_or(0, |interval| self.missing_in(interval)),
            Some(grown) => match self.period.filter(|period| grown % period == 0) {
                Some(period) => grown / period - 1,
                None => {
                    self.period = Some(grown);
                    0
                }
            },
        };
        self.missing = self.missing.saturating_add(missing);
        if missing == 0 {
            self.intervals.extend(interval);
        }
        missing
    }

    /// By the mean, once there are eight.
    fn missing_in(&self, interval: Duration) -> u64 {
        match self.mean() {
            Some(mean) if self.intervals.len() >= 8 && mean > 0 => {
                let rounded = (2 * interval.as_nanos() / mean).div_ceil(2);
                u64::try_from(rounded).expect("a session is not that long").saturating_sub(1)
            }
            _ => 0,
        }
    }

    fn mean(&self) -> Option<u128> {
        let sum: u128 = self.intervals.iter().map(Duration::as_nanos).sum();
        sum.checked_div(self.intervals.len() as u128)
    }

    fn check(&self, monitor: &Monitor) {
        let cycle = monitor.cycle();
        assert_eq!(
            (cycle.socs, cycle.missing, cycle.intervals),
            (self.socs, self.missing, self.intervals.len() as u64)
        );
        let (min, max) = (self.intervals.iter().min(), self.intervals.iter().max());
        assert_eq!(
            (cycle.min, cycle.max),
            (min.copied().unwrap_or_default(), max.copied().unwrap_or_default())
        );
        assert_eq!(cycle.mean().map(|mean| mean.as_nanos()), self.mean());
        let jitter = self
            .intervals
            .iter()
            .map(|interval| interval.as_nanos().abs_diff(self.mean().unwrap_or(0)))
            .max();
        assert_eq!(cycle.jitter().map(|jitter| jitter.as_nanos()), jitter);
        assert_eq!(cycle.nominal(), self.period.map(Duration::from_micros));
    }
}

/// Of the decoder.
const CONNECTIONS: usize = 256;
/// The problems that this program knows as well.
const COUNTED: [&str; 7] = [
    "two_sources",
    "pres_missing",
    "pres_late",
    "pres_without_preq",
    "answer_missing",
    "not_invited",
    "soc_missing",
];
