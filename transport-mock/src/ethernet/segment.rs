//! A segment: what its owner can do with it.

use std::collections::BinaryHeap;
use std::time::Duration;

use link_core::Instant;
use link_core::ethernet::{LinkEvent, Machine};

use super::fault::{Fate, Fault, FaultId, Passage};
use super::record::{FrameRecord, Keep, Record};
use super::run::Happening;
use super::station::{Station, StationConfig, StationId};
use crate::rng::Rng;
use crate::timeline::Timeline;

/// What a segment is like.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct SegmentConfig {
    /// All that happens by chance follows from it.
    pub seed: u64,
    /// From any station to any other, through the hub. Default: 500 ns, one hub and some metres.
    pub propagation: Duration,
    /// What is remembered.
    pub keep: Keep,
}

impl Default for SegmentConfig {
    fn default() -> Self {
        Self { seed: 0, propagation: Duration::from_nanos(500), keep: Keep::All }
    }
}

/// Stations on a hub; see the [module](super) text.
#[derive(Debug)]
pub struct Segment<M: Machine> {
    pub(super) config: SegmentConfig,
    pub(super) now: Instant,
    pub(super) stations: Vec<Station<M>>,
    pub(super) deadlines: Timeline,
    pub(super) faults: Vec<Option<Fault>>,
    pub(super) queue: BinaryHeap<Happening>,
    /// The number of the next happening: of two at the same moment, the earlier caused comes first.
    pub(super) order: u64,
    /// When the wire is free again.
    pub(super) wire_free: Instant,
    /// Frames that were sent.
    pub(super) sent: u64,
    pub(super) records: Vec<Record<M::Event>>,
}

impl<M: Machine> Segment<M> {
    /// A segment without stations, at time zero.
    #[must_use]
    pub fn new(config: SegmentConfig) -> Self {
        Self {
            config,
            now: Instant::ZERO,
            stations: Vec::new(),
            deadlines: Timeline::new(),
            faults: Vec::new(),
            queue: BinaryHeap::new(),
            order: 0,
            wire_free: Instant::ZERO,
            sent: 0,
            records: Vec::new(),
        }
    }

    /// Adds a station, which is told that its link is up.
    pub fn add(&mut self, config: StationConfig, machine: M) -> StationId {
        let id = StationId(self.stations.len());
        let rng = Rng::new(self.config.seed, id.0 as u64);
        self.stations.push(Station {
            config,
            machine,
            outbox: std::collections::VecDeque::new(),
            ready: Instant::ZERO,
            is_plugged: true,
            connection: 0,
            rng,
        });
        self.deadlines.resize(self.stations.len());
        self.link(id, LinkEvent::Up);
        id
    }

    /// The present moment.
    #[must_use]
    pub const fn now(&self) -> Instant {
        self.now
    }

    /// All stations.
    pub fn stations(&self) -> impl Iterator<Item = StationId> + use<M> {
        (0..self.stations.len()).map(StationId)
    }

    /// The name of a station.
    #[must_use]
    pub fn name(&self, id: StationId) -> &str {
        &self.stations[id.0].config.name
    }

    /// The machine of a station.
    #[must_use]
    pub fn machine(&self, id: StationId) -> &M {
        &self.stations[id.0].machine
    }

    /// Does something with the machine of a station, and carries out what it leads to.
    pub fn with<R>(&mut self, id: StationId, action: impl FnOnce(&mut M, Instant) -> R) -> R {
        let result = action(&mut self.stations[id.0].machine, self.now);
        self.drain(id);
        result
    }

    /// A power cycle: the machine is another one, and what the adapter had to send and was about to receive is lost.
    pub fn replace(&mut self, id: StationId, machine: M) {
        let station = &mut self.stations[id.0];
        station.machine = machine;
        station.disconnect();
        if station.is_plugged {
            self.link(id, LinkEvent::Up);
        }
        self.drain(id);
    }

    /// Pulls the cable of a station. What it had to send, and sends from now on, is told as [not sent](LinkEvent::NotSent); what was
    /// on its way to it does not arrive.
    pub fn cut(&mut self, id: StationId) {
        let station = &mut self.stations[id.0];
        if std::mem::replace(&mut station.is_plugged, false) {
            let not_sent = station.disconnect();
            self.link(id, LinkEvent::Down);
            for _ in 0..not_sent {
                self.link(id, LinkEvent::NotSent);
            }
        }
    }

    /// Plugs the cable of a station in again.
    pub fn plug(&mut self, id: StationId) {
        if !std::mem::replace(&mut self.stations[id.0].is_plugged, true) {
            self.link(id, LinkEvent::Up);
        }
    }

    /// Whether the cable of a station is in.
    #[must_use]
    pub fn is_plugged(&self, id: StationId) -> bool {
        self.stations[id.0].is_plugged
    }

    /// Adds a fault. Of several, the first that does not let a frame [pass](Fate::Pass) decides.
    pub fn add_fault(&mut self, fault: impl FnMut(&Passage<'_>) -> Fate + 'static) -> FaultId {
        self.faults.push(Some(Fault::new(fault)));
        FaultId(self.faults.len() - 1)
    }

    /// Ends a fault.
    pub fn remove_fault(&mut self, id: FaultId) {
        self.faults[id.0] = None;
    }

    /// Ends all faults.
    pub fn clear_faults(&mut self) {
        self.faults.iter_mut().for_each(|fault| *fault = None);
    }

    /// Sends a frame from outside, as soon as the wire is free.
    pub fn inject(&mut self, bytes: &[u8]) {
        self.send(None, bytes.to_vec());
    }

    /// What happened, in order.
    #[must_use]
    pub fn records(&self) -> &[Record<M::Event>] {
        &self.records
    }

    /// The frames that were sent, in order.
    pub fn frames(&self) -> impl Iterator<Item = &FrameRecord> {
        self.records.iter().filter_map(|record| match record {
            Record::Frame(frame) => Some(frame),
            Record::Event { .. } | Record::Link { .. } => None,
        })
    }

    /// Takes away what happened, so that only what follows is remembered.
    pub fn take_records(&mut self) -> Vec<Record<M::Event>> {
        std::mem::take(&mut self.records)
    }

    /// Changes what is remembered.
    pub const fn keep(&mut self, keep: Keep) {
        self.config.keep = keep;
    }
}
