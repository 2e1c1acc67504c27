//! `decode --summary` of a capture of Ethernet: the cycle, each node, SDO, which errors nodes report, and which problems there were, in
//! constant memory.

mod json;
mod reports;
mod text;

use std::collections::BTreeMap;

use devicenet_core::doctor::Severity;
use link_core::Instant;
use powerlink_core::monitor::{Kind, Note, Reading};
use powerlink_core::wire::{AbortCode, Body, SdoCommandId};

use reports::Reports;

use crate::decode::summary::problems::Problems;
use crate::histogram::Histogram;
use crate::verdict::{Seen, Verdict};

/// The counts of a capture.
#[derive(Debug)]
pub(super) struct Summary {
    networks: Vec<Network>,
}

#[derive(Debug)]
struct Network {
    span: Option<(Instant, Instant)>,
    /// Decimals of a second that the capture gives.
    digits: u8,
    total: Count,
    /// Frames with an earlier time than the one before.
    clock_back: u64,
    kinds: [u64; Kind::ALL.len()],
    /// Intervals from SoC to SoC.
    cycle: Histogram,
    /// By node ID, and one more for frames without.
    nodes: Vec<Count>,
    /// By client and server.
    transfers: BTreeMap<(u8, u8), Transfers>,
    /// Those of clients and servers for which there was no more room.
    other_transfers: Transfers,
    aborts: BTreeMap<Abort, u64>,
    /// Refusals for which there was no more room.
    other_aborts: u64,
    reports: Reports,
    problems: Problems,
    /// In the end.
    verdict: Option<Verdict>,
}

#[derive(Debug, Default)]
struct Count {
    frames: u64,
    bytes: u64,
    problems: u64,
    /// From PReq to PRes.
    pres: Histogram,
}

/// The SDO transfers of a client and a server.
#[derive(Debug, Default)]
struct Transfers {
    reads: u64,
    writes: u64,
    /// Of other commands.
    others: u64,
    aborts: u64,
    /// From request to response.
    responses: Histogram,
}

/// What was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Abort {
    client: u8,
    server: u8,
    /// Index and sub-index.
    object: Option<(u16, u8)>,
    code: AbortCode,
}

impl Default for Summary {
    /// A capture without frames is still a network.
    fn default() -> Self {
        Self { networks: vec![Network::new()] }
    }
}

impl Summary {
    /// Counts a frame of a network.
    pub(super) fn observe(&mut self, index: usize, digits: u8, reading: &Reading<'_>) {
        if self.networks.len() <= index {
            self.networks.resize_with(index + 1, Network::new);
        }
        self.networks[index].observe(digits, reading);
    }

    /// Judges the networks by what is shown of them. So many records could not be read.
    pub(super) fn conclude(&mut self, unread: u64) {
        for network in &mut self.networks {
            let (frames, faulty_frames) = (network.total.frames, network.problems.faulty());
            network.verdict =
                Some(Verdict::new([], network.reports.count(), Seen { frames, faulty_frames, unread }));
        }
    }

    /// Whether something was wrong; `None` before it was judged.
    pub(super) fn is_bad(&self) -> Option<bool> {
        let mut verdicts = self.networks.iter().map(|network| network.verdict);
        verdicts.try_fold(false, |is_bad, verdict| verdict.map(|verdict| is_bad || verdict.is_bad()))
    }
}

impl Network {
    fn new() -> Self {
        Self {
            span: None,
            digits: 0,
            total: Count::default(),
            clock_back: 0,
            kinds: [0; Kind::ALL.len()],
            cycle: Histogram::default(),
            nodes: core::iter::repeat_with(Count::default).take(NODES + 1).collect(),
            transfers: BTreeMap::new(),
            other_transfers: Transfers::default(),
            aborts: BTreeMap::new(),
            other_aborts: 0,
            reports: Reports::default(),
            problems: Problems::default(),
            verdict: None,
        }
    }

    fn observe(&mut self, digits: u8, reading: &Reading<'_>) {
        self.digits = digits;
        self.span =
            Some(self.span.map_or((reading.at, reading.at), |(first, last)| {
                (first.min(reading.at), last.max(reading.at))
            }));
        self.kinds[reading.kind as usize] += 1;
        let sender = reading.src.map_or(NODES, |node| usize::from(node.0));
        for count in [&mut self.total, &mut self.nodes[sender]] {
            count.add(reading);
        }
        self.clock_back += u64::from(matches!(reading.note, Some(Note::ClockBack { .. })));
        if let Some(interval) = reading.interval {
            self.cycle.record(interval);
        }
        if let Some(Body::Sdo(_)) = reading.body {
            self.sdo(reading);
        }
        self.reports.observe(digits, reading);
        if let Some(problem) = reading.problem {
            let frame = (reading.n, reading.at, digits);
            self.problems.add((problem.code(), Severity::Warning), frame, || problem.to_string());
        }
    }

    /// A transfer counts when it is answered.
    fn sdo(&mut self, reading: &Reading<'_>) {
        let Some(Body::Sdo(sdo)) = &reading.body else { return };
        let (Some(command), Some(request)) = (&sdo.command, reading.request) else { return };
        let (Some(server), Some(client)) = (reading.src, reading.dst) else { return };
        let pair = (client.0, server.0);
        let has_room = self.transfers.len() < MOST_PAIRS || self.transfers.contains_key(&pair);
        let transfers =
            if has_room { self.transfers.entry(pair).or_default() } else { &mut self.other_transfers };
        match command.command {
            SdoCommandId::READ_BY_INDEX => transfers.reads += 1,
            SdoCommandId::WRITE_BY_INDEX => transfers.writes += 1,
            _ => transfers.others += 1,
        }
        transfers.responses.record(request.latency);
        if let Some(code) = command.abort() {
            transfers.aborts += 1;
            let object = reading.object.map(|object| (object.index, object.sub));
            let abort = Abort { client: client.0, server: server.0, object, code };
            if self.aborts.len() < MOST_ABORTS || self.aborts.contains_key(&abort) {
                *self.aborts.entry(abort).or_default() += 1;
            } else {
                self.other_aborts += 1;
            }
        }
    }

    /// The transfers of each client and server; those for which there was no more room last.
    fn transfers(&self) -> impl Iterator<Item = (Option<(u8, u8)>, &Transfers)> {
        let others = Some((None, &self.other_transfers)).filter(|(_, others)| others.responses.count() > 0);
        self.transfers.iter().map(|(pair, transfers)| (Some(*pair), transfers)).chain(others)
    }

    /// What was refused, and how often; that for which there was no more room last.
    fn aborts(&self) -> impl Iterator<Item = (Option<&Abort>, u64)> {
        let others = Some((None, self.other_aborts)).filter(|(_, others)| *others > 0);
        self.aborts.iter().map(|(abort, count)| (Some(abort), *count)).chain(others)
    }

    /// The time between the first and the last frame.
    fn seconds(&self) -> f64 {
        self.span.map_or(0.0, |(first, last)| last.saturating_since(first).as_secs_f64())
    }

    /// How many frames of each kind there were.
    fn kinds(&self) -> impl Iterator<Item = (Kind, u64)> {
        Kind::ALL.into_iter().zip(self.kinds).filter(|(_, frames)| *frames > 0)
    }

    /// The senders by node ID; those without one last.
    fn senders(&self) -> impl Iterator<Item = (Option<u8>, &Count)> {
        let numbered = (0..=u8::MAX).map(Some).chain([None]).zip(&self.nodes);
        numbered.filter(|(_, count)| count.frames > 0)
    }
}

impl Count {
    fn add(&mut self, reading: &Reading<'_>) {
        self.frames += 1;
        self.bytes += reading.frame.length as u64;
        self.problems += u64::from(reading.problem.is_some());
        if reading.kind == Kind::Pres
            && let Some(request) = reading.request
        {
            self.pres.record(request.latency);
        }
    }
}

/// Node IDs.
const NODES: usize = 256;
/// Clients and servers that are kept apart: twice as many as a network has nodes.
const MOST_PAIRS: usize = 512;
/// Refusals that are kept apart: an object that is asked for again and again is one.
const MOST_ABORTS: usize = 1024;
