//! Machines on a bus, in virtual time.

mod changes;
mod publish;
mod run;

use std::collections::BTreeMap;
use std::convert::Infallible;

use link_core::{BitRate, Frame, Instant, Machine, Mode, StandardId, TxOutcome, TxToken};

use crate::bus::{Bus, Counters, ErrorState};
use crate::change::{Change, ChangeKind, Reaction};
use crate::node::{Housed, Keep, LocalClock, Slot};
use crate::record::{Interest, Sink};
use crate::referee::{Producers, Rule, Violation};
use crate::rng::Rng;
use crate::timeline::Timeline;

pub use crate::node::{NodeConfig, NodeId};

/// What a bus is like.
#[derive(Clone, Debug)]
pub struct BusConfig {
    /// The rate of nodes that do not say otherwise, and of faults.
    pub bit_rate: BitRate,
    /// All randomness follows from it.
    pub seed: u64,
    /// Simulates every bit of every frame in every controller, even where the outcome is certain. Slow, with the same
    /// results.
    pub force_exact: bool,
    /// Panics at the first [`Violation`], for tests. Otherwise they are recorded.
    pub strict: bool,
    /// 11-bit identifiers that several nodes may produce with different data; `None` does not check producers.
    pub shared: Option<fn(StandardId) -> bool>,
}

impl BusConfig {
    /// A bus at `bit_rate`: cheap where possible, not strict, identifiers with one producer each.
    #[must_use]
    pub const fn new(bit_rate: BitRate, seed: u64) -> Self {
        Self { bit_rate, seed, force_exact: false, strict: false, shared: Some(|_| false) }
    }
}

/// Machines on a bus, in virtual time.
///
/// What happens at one moment happens in this order: ends of bits and frames, changes, deadlines, beginnings of
/// frames; and in each of these in the order of the nodes. The same machines, seed, changes and commands give the
/// same records.
pub struct Network<E> {
    config: BusConfig,
    bus: Bus,
    nodes: Vec<Node<E>>,
    timeline: Timeline,
    now: Instant,
    changes: BTreeMap<(Instant, u64), Change<E>>,
    next_change: Instant,
    scheduled: u64,
    producers: Option<Producers>,
    rules: Vec<Box<dyn Rule<E>>>,
    violations: Vec<Violation>,
    interest: Interest,
    /// Records that nobody has seen yet.
    pending: Vec<Pending<E>>,
}

struct Node<E> {
    name: String,
    slot: Box<dyn Slot<E>>,
    clock: LocalClock,
    reaction: Reaction,
    rng: Rng,
    powered: bool,
    own_power: bool,
    plugged: bool,
    max_in_flight: usize,
    /// Calls at one moment.
    last_call: Instant,
    calls: u32,
}

enum Pending<E> {
    Request { at: Instant, node: NodeId, token: TxToken, frame: Frame },
    Done { at: Instant, node: NodeId, token: TxToken, outcome: TxOutcome },
    Event { at: Instant, node: NodeId, event: E },
    Change { at: Instant, change: OwnedChange },
    Violation(usize),
}

enum OwnedChange {
    Plain(ChangeKind<'static>),
    Split(Vec<NodeId>),
}

impl<E> Node<E> {
    /// Its machine has power.
    const fn runs(&self) -> bool {
        self.powered || self.own_power
    }
}

impl<E: 'static> Network<E> {
    /// An empty network at time zero.
    #[must_use]
    pub fn new(config: BusConfig) -> Self {
        let bit = config.bit_rate.bit_time_nanos().unwrap_or(1).max(1);
        Self {
            bus: Bus::new(bit, config.seed, config.force_exact),
            nodes: Vec::new(),
            timeline: Timeline::new(),
            now: Instant::ZERO,
            changes: BTreeMap::new(),
            next_change: Instant::MAX,
            scheduled: 0,
            producers: config.shared.map(Producers::new),
            rules: Vec::new(),
            violations: Vec::new(),
            interest: Interest::all(),
            pending: Vec::new(),
            config,
        }
    }

    /// Adds a node.
    pub fn add<M>(&mut self, config: NodeConfig, machine: M) -> NodeId
    where
        M: Machine + Clone + 'static,
        E: From<M::Event>,
    {
        self.house(config, Housed { fresh: machine.clone(), machine, keep: None, convert: E::from })
    }

    /// Adds a node that keeps something without power: at each power-up `on_power_up` gets the machine that lost its
    /// power and the one that starts.
    pub fn add_with_memory<M>(
        &mut self,
        config: NodeConfig,
        machine: M,
        on_power_up: impl FnMut(&M, &mut M) + 'static,
    ) -> NodeId
    where
        M: Machine + Clone + 'static,
        E: From<M::Event>,
    {
        let keep: Keep<M> = Box::new(on_power_up);
        self.house(config, Housed { fresh: machine.clone(), machine, keep: Some(keep), convert: E::from })
    }

    /// Adds a node whose machine has nothing to tell, such as those of [`nodes`](crate::nodes).
    pub fn add_silent<M>(&mut self, config: NodeConfig, machine: M) -> NodeId
    where
        M: Machine<Event = Infallible> + Clone + 'static,
    {
        let convert = |never: Infallible| match never {};
        self.house(config, Housed { fresh: machine.clone(), machine, keep: None, convert })
    }

    /// Adds a rule to those that every run is checked against.
    pub fn add_rule(&mut self, rule: impl Rule<E> + 'static) {
        self.rules.push(Box::new(rule));
        self.bus.interest = Interest::all();
    }

    /// The machine of a node, if it is an `M`.
    #[must_use]
    pub fn machine<M: 'static>(&self, node: NodeId) -> Option<&M> {
        self.nodes.get(node.index())?.slot.machine().downcast_ref()
    }

    /// Gives a command to the machine of a node, and carries out what follows. The closure gets the present moment on
    /// the clock of the node. `None` if the machine is not an `M`, or has no power, not even
    /// [its own](NodeConfig::own_power).
    pub fn command<M: 'static, R>(
        &mut self,
        node: NodeId,
        command: impl FnOnce(&mut M, Instant) -> R,
    ) -> Option<R> {
        let index = node.index();
        let state = self.nodes.get_mut(index).filter(|state| state.runs())?;
        let local = state.clock.local(self.now);
        let result = command(state.slot.machine_mut().downcast_mut()?, local);
        self.drain(index);
        self.serve_nodes();
        Some(result)
    }

    /// Changes what a node without power keeps, such as a switch that is turned while it is off: its next power-up hook
    /// (see [`add_with_memory`](Self::add_with_memory)) gets the machine as it is left here. `None` if the machine is
    /// not an `M`, or has power.
    pub fn alter_memory<M: 'static, R>(
        &mut self,
        node: NodeId,
        alter: impl FnOnce(&mut M) -> R,
    ) -> Option<R> {
        let state = self.nodes.get_mut(node.index()).filter(|state| !state.powered)?;
        Some(alter(state.slot.machine_mut().downcast_mut()?))
    }

    /// Puts an event into the record as if a node had told it, such as what is done to it and cannot be seen on the bus.
    pub fn tell(&mut self, node: NodeId, event: E) {
        if self.interest.contains(Interest::EVENTS) {
            self.pending.push(Pending::Event { at: self.now, node, event });
        }
    }

    /// Does something at `at`, or now if that has passed. Of several at one moment, the first that was scheduled comes
    /// first.
    pub fn schedule(&mut self, at: Instant, change: Change<E>) {
        let at = at.max(self.now);
        self.scheduled += 1;
        self.changes.insert((at, self.scheduled), change);
        self.next_change = self.next_change.min(at);
    }

    /// The present moment.
    #[must_use]
    pub const fn now(&self) -> Instant {
        self.now
    }

    /// What the network was made of.
    #[must_use]
    pub const fn config(&self) -> &BusConfig {
        &self.config
    }

    /// The nodes.
    pub fn nodes(&self) -> impl Iterator<Item = NodeId> + use<E> {
        (0..self.nodes.len()).map(NodeId::new)
    }

    /// The name of a node.
    #[must_use]
    pub fn name(&self, node: NodeId) -> &str {
        self.nodes.get(node.index()).map_or("", |node| &node.name)
    }

    /// Whether a node has power.
    #[must_use]
    pub fn is_powered(&self, node: NodeId) -> bool {
        self.nodes.get(node.index()).is_some_and(|node| node.powered)
    }

    /// Whether the cable of a node is plugged.
    #[must_use]
    pub fn is_plugged(&self, node: NodeId) -> bool {
        self.nodes.get(node.index()).is_some_and(|node| node.plugged)
    }

    /// The error counters of a node.
    #[must_use]
    pub fn counters(&self, node: NodeId) -> Counters {
        self.bus.counters(node.index())
    }

    /// How a node takes part in the bus; `None` without power or cable.
    #[must_use]
    pub fn error_state(&self, node: NodeId) -> Option<ErrorState> {
        self.bus.error_state(node.index())
    }

    /// Bit rate and mode of a node's controller.
    #[must_use]
    pub fn mode(&self, node: NodeId) -> Mode {
        self.bus.mode(node.index())
    }

    /// The rules that were broken so far.
    #[must_use]
    pub fn violations(&self) -> &[Violation] {
        &self.violations
    }

    /// When something happens next by itself, [`Instant::MAX`] if never.
    #[must_use]
    pub fn next_event_time(&self) -> Instant {
        if self.bus.has_news() {
            return self.now;
        }
        let bus = self.bus.next().map_or(Instant::MAX, |next| next.at);
        bus.min(self.next_change).min(self.timeline.earliest())
    }

    /// Runs until `end`, and does everything that happens up to then. A frame that could begin exactly at `end` has not
    /// begun, because a command may still add another.
    pub fn run_until(&mut self, end: Instant, sink: &mut impl Sink<E>) {
        self.interest = if self.rules.is_empty() { sink.interest() } else { Interest::all() };
        self.bus.interest = self.interest;
        if self.producers.is_some() {
            self.bus.interest |= Interest::FRAMES;
        }
        loop {
            if self.bus.has_news() {
                self.publish_changes(sink);
                self.publish_bus(sink);
                self.serve_nodes();
            }
            if !self.pending.is_empty() {
                self.publish(sink);
            }
            if !self.step(end) {
                break;
            }
        }
        self.now = self.now.max(end);
    }

    fn house<M>(&mut self, config: NodeConfig, housed: Housed<M, E>) -> NodeId
    where
        M: Machine + Clone + 'static,
    {
        let index = self.nodes.len();
        let id = NodeId::new(index);
        let max_in_flight = housed.machine.max_in_flight();
        let mode = Mode {
            bit_rate: config.bit_rate.unwrap_or(self.config.bit_rate),
            listen_only: config.listen_only,
        };
        self.bus.add(mode, config.clock_ppm, config.filter, max_in_flight);
        self.nodes.push(Node {
            name: config.name,
            slot: Box::new(housed),
            clock: LocalClock::new(config.clock_ppm),
            reaction: config.reaction,
            rng: Rng::new(self.config.seed, index as u64),
            powered: false,
            own_power: config.own_power,
            plugged: true,
            max_in_flight,
            last_call: Instant::MAX,
            calls: 0,
        });
        self.timeline.resize(self.nodes.len());
        if let Some(at) = config.power_up {
            self.schedule(at, Change::PowerOn(id));
        }
        id
    }
}

impl<E> std::fmt::Debug for Network<E> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Network")
            .field("now", &self.now)
            .field("nodes", &self.nodes.iter().map(|node| &node.name).collect::<Vec<_>>())
            .field("changes", &self.changes)
            .field("violations", &self.violations)
            .finish_non_exhaustive()
    }
}
