//! Runs a scenario, as fast as possible or by the clock on the wall.

use core::sync::atomic::{AtomicBool, Ordering};
use core::time::Duration;
use std::io;

use devicenet_core::Access;
use link_core::Instant;
use link_core::time::Clock;
use transport_mock::nodes::{External, ExternalEvent, TooManyFrames};
use transport_mock::{Change, Network, NodeId};

use super::build::{self, Settings};
use super::event::NodeEvent;
use super::expectations::Verdict;
use super::sight::{Observer, View};
use super::socketcand::{ClientId, Outgoing, Server};
use super::summary::{Counting, Last, Summary};
use crate::scenario::{NodeIndex, Note, Role, Scenario};

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
                doors.hand_out(&mut self.network, server);
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
        Ok(())
    }

    /// The end.
    pub(super) fn finish(self) -> Outcome {
        let end = self.network.now();
        let ids: Vec<NodeId> = self.network.nodes().collect();
        let last = |node: NodeIndex| Last {
            status: self.observer.status(node),
            max_tec: self.observer.highest_tec(node),
            mac: self.network.machine::<Access>(ids[node.0]).map(|access| access.mac_id().into()),
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

/// The headings in the order of time, and of the file, the last first.
fn notes(scenario: &Scenario) -> Vec<&Note> {
    let mut notes: Vec<&Note> = scenario.notes.iter().collect();
    notes.sort_by_key(|note| note.at);
    notes.reverse();
    notes
}

/// The external nodes, through which clients come onto the bus.
struct Doors {
    /// In the order of the server's channels.
    nodes: Vec<Door>,
}

struct Door {
    id: NodeId,
    /// Whose frames are on their way, in order.
    senders: std::collections::VecDeque<ClientId>,
}

impl Doors {
    fn of(scenario: &Scenario, network: &Network<NodeEvent>) -> Self {
        let external = network.nodes().filter(|id| scenario.nodes[id.index()].role == Role::External);
        Self { nodes: external.map(|id| Door { id, senders: std::collections::VecDeque::new() }).collect() }
    }

    /// Frames of clients go to the bus.
    fn take_in(&mut self, network: &mut Network<NodeEvent>, server: &mut Server, outgoing: Vec<Outgoing>) {
        for Outgoing { client, channel, frame } in outgoing {
            let door = &mut self.nodes[channel];
            match network.command(door.id, |external: &mut External, _| external.inject(frame)) {
                Some(Ok(())) => door.senders.push_back(client),
                Some(Err(TooManyFrames)) => server.refuse(client, "too many frames wait to be sent"),
                None => server.refuse(client, "the node has no power"),
            }
        }
    }

    /// What was on the bus goes to clients.
    fn hand_out(&mut self, network: &mut Network<NodeEvent>, server: &mut Server) {
        for (channel, door) in self.nodes.iter_mut().enumerate() {
            while let Some((at, event)) =
                network.command(door.id, |external: &mut External, _| external.take()).flatten()
            {
                match event {
                    ExternalEvent::Received(frame) => server.frame(at, channel, &frame, None),
                    ExternalEvent::Done(frame, outcome) => {
                        let sender = door.senders.pop_front();
                        match (outcome, sender) {
                            (link_core::TxOutcome::Sent, _) => server.frame(at, channel, &frame, sender),
                            (_, Some(sender)) => server.refuse(sender, "the frame was not sent"),
                            (_, None) => {}
                        }
                    }
                    ExternalEvent::Link(link_core::LinkEvent::BusOff) => {
                        server.bus_error(at, channel, CLASS_BUS_OFF);
                        // As an interface with `restart-ms` does.
                        door.senders.clear();
                        network.schedule(network.now() + RESTART, Change::PowerCycle(door.id));
                    }
                    ExternalEvent::Link(link_core::LinkEvent::BusError(_)) => {
                        server.bus_error(at, channel, CLASS_BUS_ERROR);
                    }
                    ExternalEvent::Link(_) => {}
                }
            }
        }
    }
}

/// Virtual time after which the output is written.
const SLICE: Duration = Duration::from_millis(20);
/// So that neither the end of the run nor an interruption is missed by much, whatever a client does.
const LONGEST_WAIT: Duration = Duration::from_millis(100);
const RESTART: Duration = Duration::from_millis(100);
/// `CAN_ERR_BUSOFF` and `CAN_ERR_BUSERROR` of linux/can/error.h.
const CLASS_BUS_OFF: u32 = 0x40;
const CLASS_BUS_ERROR: u32 = 0x80;
