//! The simulated bus: where nothing can differ it takes the short way, and that must come to the same as bit by bit.
//!
//! A workload runs on both paths: every record of one is the same on the other, at the same nanosecond, and so are the
//! error counters. Besides, the referee finds nothing, every request is answered once, and the bits add up.
//!
//! Where a node has another bit rate or a clock beyond tolerance, there is a third path, on which a node hears of a frame when
//! it samples its last bit, an eighth of a bit before the end that the record gives. So these runs are not compared; all else must hold for them.

mod talker;
mod workload;

use std::collections::BTreeSet;

use core::time::Duration;

use arbitrary::Unstructured;
use link_core::wire::INTERMISSION_BITS;
use link_core::{Instant, TxToken};
use transport_mock::change::ChangeKind;
use transport_mock::record::{FrameRecord, Outcome};
use transport_mock::{BusConfig, Counters, ErrorState, Network, NodeId, Record};

use workload::Workload;

/// Runs a workload on both paths.
pub fn run(data: &[u8]) {
    let Ok(workload) = Workload::read(&mut Unstructured::new(data)) else { return };
    let (cheap, exact) = (Run::of(&workload, false), Run::of(&workload, true));
    if !workload.one_rate {
        return;
    }
    for (cheap, exact) in cheap.lines.iter().zip(&exact.lines) {
        assert_eq!(cheap, exact, "the cheap and the exact path");
    }
    assert_eq!(cheap.lines.len(), exact.lines.len());
    assert_eq!(cheap.nodes, exact.nodes);
}

/// What came of a workload.
struct Run {
    lines: Vec<String>,
    nodes: Vec<(Counters, Option<ErrorState>)>,
}

impl Run {
    fn of(workload: &Workload, force_exact: bool) -> Self {
        let config =
            BusConfig { force_exact, shared: None, ..BusConfig::new(workload.bit_rate, workload.seed) };
        let mut network = Network::<()>::new(config);
        workload.install(&mut network);
        let mut lines = Vec::new();
        let mut bookkeeper = Bookkeeper::new(workload);
        network.run_until(workload.end, &mut |record: &Record<'_, ()>| {
            assert!(lines.len() < MOST_RECORDS, "more than {MOST_RECORDS} records");
            lines.push(record.to_string());
            bookkeeper.see(record);
        });
        assert_eq!(network.violations(), [], "the referee");
        assert_eq!(network.now(), workload.end);
        let nodes: Vec<_> =
            network.nodes().map(|node| (network.counters(node), network.error_state(node))).collect();
        Self { lines, nodes }
    }
}

/// Holds the records against each other.
struct Bookkeeper {
    undisturbed: bool,
    /// The length of a bit, if all nodes agree on it.
    bit: Option<u64>,
    in_flight: BTreeSet<(NodeId, TxToken)>,
    /// When the last frame of a segment was over.
    free_at: Vec<Instant>,
    numbers: BTreeSet<(usize, u64)>,
}

impl Bookkeeper {
    fn new(workload: &Workload) -> Self {
        let bit = workload.in_step.then(|| workload.bit_rate.bit_time_nanos()).flatten();
        let undisturbed = workload.is_undisturbed();
        Self { undisturbed, bit, in_flight: BTreeSet::new(), free_at: Vec::new(), numbers: BTreeSet::new() }
    }

    fn see(&mut self, record: &Record<'_, ()>) {
        match *record {
            Record::Frame(ref frame) => self.frame(frame),
            Record::Counters { counters, .. } => {
                assert!(counters.tec <= 263 && counters.rec <= 255, "{record}");
            }
            Record::Request { node, token, .. } => {
                assert!(self.in_flight.insert((node, token)), "{record} is in flight already");
            }
            Record::Done { node, token, .. } => {
                assert!(self.in_flight.remove(&(node, token)), "{record} was not in flight");
            }
            Record::Change { change, .. } => self.change(change),
            Record::Error(_) | Record::Event { .. } => {}
            Record::Violation(violation) => panic!("{violation}"),
        }
    }

    /// A node without power forgets what it has in flight.
    fn change(&mut self, change: ChangeKind<'_>) {
        if let ChangeKind::PowerOff(node) = change {
            self.in_flight.retain(|&(other, _)| other != node);
        }
    }

    fn frame(&mut self, frame: &FrameRecord<'_>) {
        // An attempt goes on on both sides of a split.
        assert!(self.numbers.insert((frame.segment, frame.number)), "{frame}: a number twice");
        assert!(frame.start < frame.end && !frame.senders.is_empty(), "{frame}");
        // A disturbed bit can pass for an acknowledgement, and who acknowledged can be gone before the end.
        if self.undisturbed && frame.outcome == Outcome::Ok {
            assert!(frame.receivers.iter().next().is_some(), "{frame}: nobody has acknowledged it");
        }
        if self.free_at.len() <= frame.segment {
            self.free_at.resize(frame.segment + 1, Instant::ZERO);
        }
        let Some(bit) = self.bit else { return };
        let free_at = &mut self.free_at[frame.segment];
        assert!(frame.start >= *free_at, "{frame}: begins before the bus is free at {free_at}");
        *free_at = frame.end;
        if frame.outcome == Outcome::Ok {
            let nanos = frame.end.saturating_since(frame.start).as_nanos();
            assert_eq!(nanos, u128::from(frame.frame.bit_len()) * u128::from(bit), "{frame}");
            if self.undisturbed {
                // A dominant third bit of intermission, which only a fault makes, is a start of frame.
                *free_at += Duration::from_nanos(u64::from(INTERMISSION_BITS) * bit);
            }
        }
    }
}

const MOST_RECORDS: usize = 100_000;

#[cfg(test)]
mod tests {
    use super::*;

    /// Three nodes at 500 kbit/s; each item is a distance, then a node and a frame.
    const THREE_NODES: [u8; 9] = [1, 0x12, 60, 0, 0, 0, 0, 0, 0];

    #[test]
    fn frames_that_meet_are_sent_one_after_the_other() {
        let mut bytes = THREE_NODES.to_vec();
        for node in 0..3 {
            bytes.extend([u8::from(node == 0) * 8, node, 1, node, 1, 0x55]);
        }
        let workload = Workload::read(&mut Unstructured::new(&bytes)).unwrap();
        let run_of = Run::of(&workload, false);
        let sent = run_of.lines.iter().filter(|line| line.contains(" ok, ")).count();
        assert_eq!(sent, 3, "{:#?}", run_of.lines);
        run(&bytes);
    }

    #[test]
    fn a_lone_node_repeats_for_ever_and_stays_on_the_bus() {
        let bytes = [1, 0x10, 255, 0, 0, 8, 0, 1, 0, 1, 0x55];
        let workload = Workload::read(&mut Unstructured::new(&bytes)).unwrap();
        let run_of = Run::of(&workload, false);
        assert_eq!(run_of.nodes[0].0.tec, 128);
        assert_eq!(run_of.nodes[0].1, Some(ErrorState::Passive));
        run(&bytes);
    }
}
