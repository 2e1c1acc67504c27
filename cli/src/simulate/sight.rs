//! What a run shows, digested: records of the bus turned into what the views print, count and draw.

use std::rc::Rc;

use devicenet_core::access::AccessEvent;
use devicenet_core::master::MasterEvent;
use devicenet_core::tool::{ToolEvent, ToolState};
use devicenex_core::access as nex;
use link_core::{Instant, TxOutcome};
use transport_mock::change::ChangeKind;
use transport_mock::record::{FrameRecord, Outcome};
use transport_mock::{Counters, ErrorState, FaultId, Interest, NodeId, Record, Sink};

use super::build;
use super::event::{Effect, NodeEvent};
use super::exchange::{Exchange, Happening};
use super::expectations::{Judge, Status, Verdict};
use super::level::Level;
use super::said::{Reader, Said};
use super::state::{nex_state_name, state_name};
use crate::scenario::{Do, EventName, Kind, NodeIndex, Scenario, StateName};

/// One thing that happened.
#[derive(Debug)]
pub(super) enum Sight<'a> {
    /// An attempt to send a frame is over. A frame that got through is read.
    Frame { record: &'a FrameRecord<'a>, reading: Option<&'a Said<'a>> },
    /// A node tells something.
    Event { at: Instant, node: NodeIndex, event: &'a NodeEvent },
    /// The error counters of a node have changed its part in the bus.
    Level { at: Instant, node: NodeIndex, level: Level, counters: Counters },
    /// Somebody interferes. `node` is `None` for what concerns the bus.
    Change { at: Instant, node: Option<NodeIndex>, what: String, problem: bool },
    /// A rule that every node must keep was broken.
    Broken { at: Instant, node: NodeIndex, rule: &'a str },
    /// A heading of the scenario.
    Note { at: Instant, text: &'a str },
}

/// Whoever looks at a run.
pub(super) trait View {
    /// Sees what happened. `nodes` tells what the nodes are now.
    fn see(&mut self, nodes: &Nodes<'_>, sight: &Sight<'_>);
}

/// The nodes as they are at the moment.
#[derive(Debug)]
pub(super) struct Nodes<'a> {
    pub(super) scenario: &'a Scenario,
    judge: &'a Judge,
    attached: &'a [Attached],
}

/// Whether a node has power, and its cable.
#[derive(Clone, Copy, Debug)]
struct Attached {
    power: bool,
    cable: bool,
}

impl Nodes<'_> {
    pub(super) fn name(&self, node: NodeIndex) -> &str {
        &self.scenario.nodes[node.0].name
    }

    pub(super) fn status(&self, node: NodeIndex) -> Status {
        self.judge.status(node)
    }

    pub(super) fn has_power(&self, node: NodeIndex) -> bool {
        self.attached[node.0].power
    }

    /// Whether it has power and is on the cable.
    pub(super) fn is_attached(&self, node: NodeIndex) -> bool {
        let Attached { power, cable } = self.attached[node.0];
        power && cable
    }
}

/// Turns records into sights, and keeps the judge informed.
pub(super) struct Observer<'a> {
    scenario: &'a Scenario,
    /// One for each segment of the bus: each sees only what is on its own.
    readers: Vec<Reader>,
    judge: Judge,
    attached: Vec<Attached>,
    /// The highest transmit error counter of each node.
    highest: Vec<u16>,
    frames: u64,
    pub(super) views: Vec<Box<dyn View + 'a>>,
}

impl<'a> Observer<'a> {
    pub(super) fn new(scenario: &'a Scenario, views: Vec<Box<dyn View + 'a>>) -> Self {
        let initial = |node: NodeIndex| Status {
            state: scenario.nodes[node.0].role.is(Kind::Access).then_some(StateName::Nonexistent),
            oa: scenario.nodes[node.0].role.nex().map(|node| node.oa.number()),
            exchange: Rc::new(Exchange::of(&scenario.nodes[node.0])),
            ..Status::default()
        };
        let judge = Judge::new(scenario, initial);
        let attached = vec![Attached { power: false, cable: true }; scenario.nodes.len()];
        let readers = vec![Reader::new(scenario.protocol())];
        let highest = vec![0; scenario.nodes.len()];
        Self { scenario, readers, judge, attached, highest, frames: 0, views }
    }

    /// The run is over.
    pub(super) fn finish(self, end: Instant) -> Verdict {
        self.judge.finish(end)
    }

    pub(super) fn status(&self, node: NodeIndex) -> Status {
        self.judge.status(node)
    }

    /// The highest transmit error counter that a node had.
    pub(super) fn highest_tec(&self, node: NodeIndex) -> u16 {
        self.highest[node.0]
    }

    /// Takes a record of the bus.
    fn take(&mut self, record: &Record<'_, NodeEvent>) {
        match record {
            Record::Frame(record) => self.frame(record),
            Record::Counters { at, node, counters } => self.counters(*at, index(*node), *counters),
            Record::Event { at, node, event } => self.event(*at, index(*node), event),
            Record::Change { at, change } => self.change(*at, change),
            Record::Violation(violation) => {
                let rule = format!("{}: {}", violation.rule, violation.what);
                self.show(&Sight::Broken { at: violation.at, node: index(violation.node), rule: &rule });
            }
            Record::Done { at, node, outcome: TxOutcome::Sent, .. } => {
                self.judge.happened(*at, index(*node), EventName::Sent);
            }
            Record::Error(_) | Record::Request { .. } | Record::Done { .. } => {}
        }
    }

    /// A heading is due.
    pub(super) fn note(&mut self, at: Instant, text: &str) {
        self.show(&Sight::Note { at, text });
    }

    /// Something is wrong outside, with whoever sits on an external node.
    pub(super) fn trouble(&mut self, at: Instant, node: Option<NodeIndex>, what: String) {
        self.show(&Sight::Change { at, node, what, problem: true });
    }

    fn frame(&mut self, record: &FrameRecord<'_>) {
        let reading = match record.outcome {
            Outcome::Ok => {
                self.frames += 1;
                let reader = self.readers.get_mut(record.segment);
                reader.map(|reader| reader.read(record.end, self.frames, record.frame))
            }
            Outcome::Error(_) | Outcome::Abandoned => None,
        };
        let nodes = Nodes { scenario: self.scenario, judge: &self.judge, attached: &self.attached };
        let sight = Sight::Frame { record, reading: reading.as_ref() };
        self.views.iter_mut().for_each(|view| view.see(&nodes, &sight));
    }

    fn counters(&mut self, at: Instant, node: NodeIndex, counters: Counters) {
        let before = self.judge.status(node);
        let (tec, rec) = (before.tec, before.rec);
        let bus_off = counters.state() == ErrorState::BusOff;
        self.judge.changed(at, node, Status { tec: counters.tec, rec: counters.rec, bus_off, ..before });
        self.highest[node.0] = self.highest[node.0].max(counters.tec);
        if let Some(level) = Level::entered(Counters { tec, rec }, counters) {
            self.judge.happened(at, node, level.event());
            self.show(&Sight::Level { at, node, level, counters });
        }
    }

    fn event(&mut self, at: Instant, node: NodeIndex, event: &NodeEvent) {
        let happened = match event {
            NodeEvent::Access(event) => self.access_event(at, node, event).map(Happening::from),
            NodeEvent::Address(address) => return self.set_oa(at, node, Some(address.number())),
            NodeEvent::NexAccess(event) => {
                self.follow(at, node, &NodeEvent::NexAccess(*event));
                self.nex_access_event(at, node, event).map(Happening::from)
            }
            NodeEvent::Action(action, effect) => {
                if matches!(action, Do::SetInput(_)) {
                    self.follow(at, node, event);
                }
                let what = event.words();
                let problem = matches!(effect, Effect::None(_));
                return self.show(&Sight::Change { at, node: Some(node), what, problem });
            }
            NodeEvent::Tool(event) => tool_event(event).map(Happening::from),
            NodeEvent::Master(MasterEvent::ScanDone { missing: 0 }) => Some(EventName::ScanDone.into()),
            NodeEvent::Master(MasterEvent::ScanDone { .. }) => Some(EventName::ResponseMissing.into()),
            event => self.follow(at, node, event),
        };
        if let Some(happened) = happened {
            self.judge.happened(at, node, happened);
        }
        self.show(&Sight::Event { at, node, event });
    }

    fn access_event(&mut self, at: Instant, node: NodeIndex, event: &AccessEvent) -> Option<EventName> {
        match event {
            AccessEvent::StateChanged { to, .. } => {
                self.enter(at, node, state_name(*to));
                Some(EventName::StateChanged)
            }
            AccessEvent::Duplicate { .. } => Some(EventName::DuplicateMacId),
            AccessEvent::Challenged { .. } => Some(EventName::Defended),
            AccessEvent::NotAcknowledged => Some(EventName::NotAcknowledged),
            AccessEvent::MacIdAssigned { .. } => Some(EventName::MacIdAssigned),
            AccessEvent::NotSent { .. }
            | AccessEvent::MacIdLocked { .. }
            | AccessEvent::Identify { .. }
            | AccessEvent::BadFrame { .. }
            | AccessEvent::FramesLost { .. }
            | AccessEvent::LinkRefused(_) => None,
        }
    }

    fn nex_access_event(
        &mut self,
        at: Instant,
        node: NodeIndex,
        event: &nex::AccessEvent,
    ) -> Option<EventName> {
        match event {
            nex::AccessEvent::StateChanged { to, .. } => {
                self.enter(at, node, nex_state_name(*to));
                Some(EventName::StateChanged)
            }
            nex::AccessEvent::AddressAssigned { .. } => Some(EventName::AddressAssigned),
            nex::AccessEvent::AddressTaken { .. } => Some(EventName::AddressTaken),
            nex::AccessEvent::BitRateLocked(_) => Some(EventName::BitRateDetected),
            nex::AccessEvent::Defended { .. } => Some(EventName::Defended),
            nex::AccessEvent::OwnIdentity(_) => Some(EventName::OwnIdentity),
            nex::AccessEvent::RoamRefused { .. } => Some(EventName::RoamRefused),
            nex::AccessEvent::NotAcknowledged => Some(EventName::NotAcknowledged),
            nex::AccessEvent::NotSent { .. }
            | nex::AccessEvent::BadFrame(_)
            | nex::AccessEvent::FramesLost { .. }
            | nex::AccessEvent::LinkRefused(_) => None,
        }
    }

    /// A node has another operational address.
    fn set_oa(&mut self, at: Instant, node: NodeIndex, oa: Option<u8>) {
        let before = self.judge.status(node);
        self.judge.changed(at, node, Status { oa, ..before });
    }

    /// Connections and data have changed.
    fn follow(&mut self, at: Instant, node: NodeIndex, event: &NodeEvent) -> Option<Happening> {
        let mut status = self.judge.status(node);
        let happened = Rc::make_mut(&mut status.exchange).follow(event);
        self.judge.changed(at, node, status);
        happened
    }

    fn change(&mut self, at: Instant, change: &ChangeKind<'_>) {
        match change {
            ChangeKind::PowerOn(node) => self.attached[node.index()].power = true,
            ChangeKind::PowerOff(node) => {
                self.attached[node.index()].power = false;
                self.detached(at, index(*node));
                self.lost_power(at, index(*node));
                // It begins with it again.
                let first = self.scenario.nodes[node.index()].role.nex().map(|node| node.oa.number());
                self.set_oa(at, index(*node), first);
                if self.enter(at, index(*node), StateName::Nonexistent) {
                    // Nobody is left to tell it.
                    self.judge.happened(at, index(*node), EventName::StateChanged);
                }
            }
            ChangeKind::Plug(node) => self.attached[node.index()].cable = true,
            ChangeKind::Cut(node) => {
                self.attached[node.index()].cable = false;
                self.detached(at, index(*node));
            }
            // Each part goes on with what was seen before; those that come back are new to the others.
            ChangeKind::Split(_) => {
                self.readers.truncate(1);
                self.readers.extend_from_within(..);
            }
            ChangeKind::Join => self.readers.truncate(1),
            _ => {}
        }
        if let Some((node, what)) = self.words(change) {
            self.show(&Sight::Change { at, node, what, problem: false });
        }
    }

    /// Network access is in this state now. Returns whether it was in another; a role without it has none.
    fn enter(&mut self, at: Instant, node: NodeIndex, state: StateName) -> bool {
        let before = self.judge.status(node);
        let is_new = before.state.is_some_and(|was| was != state);
        if is_new {
            self.judge.changed(at, node, Status { state: Some(state), ..before });
        }
        is_new
    }

    /// A controller is gone, and with it its counters: it has not become error-active.
    fn detached(&mut self, at: Instant, node: NodeIndex) {
        let before = self.judge.status(node);
        let Status { state, oa, exchange, .. } = before;
        self.judge.changed(at, node, Status { state, oa, exchange, ..Status::default() });
    }

    /// Connections and data are gone with the power.
    fn lost_power(&mut self, at: Instant, node: NodeIndex) {
        let before = self.judge.status(node);
        let exchange = Rc::new(before.exchange.without_power(&self.scenario.nodes[node.0]));
        self.judge.changed(at, node, Status { exchange, ..before });
    }

    fn show(&mut self, sight: &Sight<'_>) {
        let nodes = Nodes { scenario: self.scenario, judge: &self.judge, attached: &self.attached };
        self.views.iter_mut().for_each(|view| view.see(&nodes, sight));
    }

    fn words(&self, change: &ChangeKind<'_>) -> Option<(Option<NodeIndex>, String)> {
        let of = |node: &NodeId, what: &str| Some((Some(index(*node)), what.to_owned()));
        let names = |nodes: &[NodeId]| {
            let names: Vec<&str> =
                nodes.iter().map(|node| self.scenario.nodes[node.index()].name.as_str()).collect();
            names.join(", ")
        };
        match change {
            ChangeKind::Cut(node) => of(node, "cable unplugged"),
            ChangeKind::Plug(node) => of(node, "cable plugged"),
            ChangeKind::PowerOff(node) => of(node, "power off"),
            ChangeKind::PowerOn(node) => of(node, "power on"),
            ChangeKind::Mode(node, mode) if mode.listen_only => {
                of(node, &format!("bit rate {}, listen-only", mode.bit_rate))
            }
            ChangeKind::Mode(node, mode) => of(node, &format!("bit rate {}", mode.bit_rate)),
            ChangeKind::Clock(node, ppm) => of(node, &format!("clock off by {ppm} ppm")),
            ChangeKind::FaultOn(id, _) => Some((None, format!("fault begins: {}", self.fault(*id)?))),
            ChangeKind::FaultOff(id) => Some((None, format!("fault ends: {}", self.fault(*id)?))),
            ChangeKind::Split(nodes) => Some((None, format!("the bus is cut: {} apart", names(nodes)))),
            ChangeKind::Join => Some((None, "the bus is whole again".to_owned())),
            _ => None,
        }
    }

    /// A fault of several nodes is several on the bus; the first speaks for all.
    fn fault(&self, id: FaultId) -> Option<String> {
        let (fault, part) = build::fault_of(id);
        let fault = self.scenario.faults.get(fault).filter(|_| part == 0)?;
        Some(fault.kind.words(self.scenario))
    }
}

impl Sink<NodeEvent> for Observer<'_> {
    fn interest(&self) -> Interest {
        Interest::FRAMES
            | Interest::COUNTERS
            | Interest::EVENTS
            | Interest::CHANGES
            | Interest::VIOLATIONS
            | Interest::REQUESTS
    }

    fn record(&mut self, record: &Record<'_, NodeEvent>) {
        self.take(record);
    }
}

/// Nodes of the network are added in the order of the scenario.
pub(super) fn index(node: NodeId) -> NodeIndex {
    NodeIndex(node.index())
}

const fn tool_event(event: &ToolEvent) -> Option<EventName> {
    match event {
        ToolEvent::StateChanged { to: ToolState::Owner, .. } => Some(EventName::Owner),
        ToolEvent::Found(_) => Some(EventName::Found),
        ToolEvent::WhoDone { .. } => Some(EventName::WhoDone),
        ToolEvent::Recovered { .. } => Some(EventName::Recovered),
        ToolEvent::NotRecovered { .. } => Some(EventName::NotRecovered),
        _ => None,
    }
}

/// The time that a frame occupied the bus, in nanoseconds.
pub(super) fn length(record: &FrameRecord<'_>) -> u64 {
    record.end.as_nanos().saturating_sub(record.start.as_nanos())
}
