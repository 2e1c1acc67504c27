//! Runs a scenario, as fast as possible or by the clock on the wall.

use core::sync::atomic::{AtomicBool, Ordering};
use core::time::Duration;
use std::io;

use devicenet_core::{Access, MacId};
use link_core::Instant;
use link_core::time::Clock;
use transport_mock::{Network, NodeId};

use super::build::{self, Settings};
use super::doors::Doors;
use super::event::NodeEvent;
use super::expectations::{Status, Verdict};
use super::machines::{DeviceMachine, MasterMachine, ScanTimes, SlaveMachine, ToolMachine};
use super::sight::{Observer, View};
use super::socketcand::Server;
use super::summary::{Counting, Last, ScanSummary, SlaveSummary, Summary};
use crate::scenario::{NodeIndex, Note, Scenario};

/// What a run has come to.
#[derive(Clone, PartialEq, Debug)]
pub struct Outcome {
    /// When it ended.
    pub end: Instant,
    /// The expectations.
    pub verdict: Verdict,
    /// The figures.
    pub summary: Summary,
}

/// A run in progress.
pub(super) struct Run<'a> {
    scenario: &'a Scenario,
    network: Network<NodeEvent>,
    observer: Observer<'a>,
    counted: std::rc::Rc<core::cell::RefCell<super::summary::Figures>>,
    /// The headings that are still to come, the last first.
    notes: Vec<&'a Note>,
    end: Instant,
}

impl<'a> Run<'a> {
    pub(super) fn new(
        scenario: &'a Scenario,
        settings: Settings,
        mut views: Vec<Box<dyn View + 'a>>,
        is_served: bool,
    ) -> Self {
        let (counting, counted) = Counting::new(scenario);
        views.push(Box::new(counting));
        let seed = settings.seed.unwrap_or(scenario.bus.seed);
        Self {
            scenario,
            network: build::network(scenario, seed, is_served),
            observer: Observer::new(scenario, views),
            counted,
            notes: notes(scenario),
            end: Instant::ZERO + settings.until.unwrap_or(scenario.bus.duration),
        }
    }

    /// As fast as possible; `between` is called again and again, to write out what has come.
    pub(super) fn at_full_speed(&mut self, mut between: impl FnMut() -> io::Result<()>) -> io::Result<()> {
        while self.network.now() < self.end {
            self.run_to((self.network.now() + SLICE).min(self.end));
            between()?;
        }
        Ok(())
    }

    /// By the clock on the wall, with clients on the external nodes if there is a server, until the end or until
    /// `interrupted` is set.
    pub(super) fn by_the_clock(
        &mut self,
        mut server: Option<Server>,
        interrupted: &AtomicBool,
        mut between: impl FnMut() -> io::Result<()>,
    ) -> io::Result<()> {
        let mut doors = Doors::of(self.scenario, &self.network);
        let clock = Clock::start();
        while self.network.now() < self.end && !interrupted.load(Ordering::Relaxed) {
            self.run_to(clock.now().min(self.end).max(self.network.now()));
            if let Some(server) = &mut server {
                doors.hand_out(&mut self.network, server, &mut self.observer);
            }
            between()?;
            // Rounded up: what begins at a moment is done when it has passed.
            let next = self.network.next_event_time() + Duration::from_nanos(1);
            let note = self.notes.last().map_or(Instant::MAX, |note| note.at);
            let wake = next.min(note).min(self.end);
            match &mut server {
                None => std::thread::sleep(clock.until(wake).min(LONGEST_WAIT)),
                Some(server) => {
                    let wake = server.deadline().map_or(wake, |deadline| deadline.min(wake));
                    let outgoing = server.wait(clock.until(wake).min(LONGEST_WAIT), || clock.now());
                    self.run_to(clock.now().min(self.end).max(self.network.now()));
                    doors.take_in(&mut self.network, server, outgoing);
                }
            }
        }
        if let Some(server) = &mut server {
            doors.hand_out(&mut self.network, server, &mut self.observer);
            doors.conclude(&self.network, server, &mut self.observer);
        }
        Ok(())
    }

    /// The end.
    pub(super) fn finish(self) -> Outcome {
        let end = self.network.now();
        let ids: Vec<NodeId> = self.network.nodes().collect();
        let last = |node: NodeIndex| {
            let status = self.observer.status(node);
            let slave = self.network.machine::<SlaveMachine>(ids[node.0]);
            let device = self.network.machine::<DeviceMachine>(ids[node.0]);
            let master = self.network.machine::<MasterMachine>(ids[node.0]);
            Last {
                max_tec: self.observer.highest_tec(node),
                mac: access(&self.network, ids[node.0]).map(|access| access.mac_id().into()),
                oa: status.oa,
                received: slave.map(SlaveMachine::received).or(device.map(DeviceMachine::received)),
                slave: slave.map(SlaveMachine::counters),
                scan: master.map(|master| scan(master, &status)),
                status,
            }
        };
        let summary = self.counted.borrow().summary(end, last);
        Outcome { end, verdict: self.observer.finish(end), summary }
    }

    fn run_to(&mut self, to: Instant) {
        while let Some(note) = self.notes.pop_if(|note| note.at <= to) {
            // It comes before what happens at the same moment.
            let just_before = note.at.saturating_sub(Duration::from_nanos(1)).max(self.network.now());
            if note.at > Instant::ZERO {
                self.network.run_until(just_before, &mut self.observer);
            }
            self.observer.note(note.at, &note.text);
        }
        self.network.run_until(to, &mut self.observer);
    }
}

/// The network access of a node.
fn access(network: &Network<NodeEvent>, node: NodeId) -> Option<&Access> {
    (network.machine::<Access>(node))
        .or_else(|| network.machine::<SlaveMachine>(node).map(SlaveMachine::access))
        .or_else(|| network.machine::<MasterMachine>(node).map(MasterMachine::access))
        .or_else(|| network.machine::<ToolMachine>(node).map(ToolMachine::access))
}

/// What a master has come to.
fn scan(master: &MasterMachine, status: &Status) -> ScanSummary {
    let ScanTimes { count, shortest, longest, sum } = master.scans();
    let slaves = status.exchange.slaves().map(|(mac, state, status)| SlaveSummary {
        mac,
        state,
        status,
        counters: MacId::new(mac).and_then(|mac| master.counters(mac)).unwrap_or_default(),
    });
    ScanSummary {
        scans: count,
        min: shortest.as_secs_f64(),
        mean: sum.as_secs_f64() / f64::from(count.max(1)),
        max: longest.as_secs_f64(),
        slaves: slaves.collect(),
    }
}

/// The headings in the order of time, and of the file, the last first.
fn notes(scenario: &Scenario) -> Vec<&Note> {
    let mut notes: Vec<&Note> = scenario.notes.iter().collect();
    notes.sort_by_key(|note| note.at);
    notes.reverse();
    notes
}

/// Virtual time after which the output is written.
const SLICE: Duration = Duration::from_millis(20);
/// So that neither the end of the run nor an interruption is missed by much, whatever a client does.
const LONGEST_WAIT: Duration = Duration::from_millis(100);
