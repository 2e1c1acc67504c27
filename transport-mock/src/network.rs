//! Machines on a bus, in virtual time.

use std::collections::BTreeMap;
use std::convert::Infallible;

use link_core::{
    Action, BitRate, Frame, Input, Instant, LinkCommand, LinkEvent, Machine, Mode, StandardId, TxOutcome,
    TxToken,
};

use crate::bus::{Bus, Counters, ErrorState, Note, after};
use crate::change::{Change, ChangeKind, Reaction};
use crate::node::{Housed, Keep, LocalClock, Slot};
use crate::record::{FrameRecord, Interest, Record, Sink};
use crate::referee::{self, Producers, Rule, Violation};
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
    /// Simulates every frame bit by bit, even if its outcome is certain. Slow, with the same results.
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
    /// the clock of the node. `None` if the machine is not an `M`, or has no power.
    pub fn command<M: 'static, R>(
        &mut self,
        node: NodeId,
        command: impl FnOnce(&mut M, Instant) -> R,
    ) -> Option<R> {
        let index = node.index();
        let state = self.nodes.get_mut(index).filter(|state| state.powered)?;
        let local = state.clock.local(self.now);
        let result = command(state.slot.machine_mut().downcast_mut()?, local);
        self.drain(index);
        self.serve_nodes();
        Some(result)
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

    /// Does the next thing, if it is due by `end`.
    fn step(&mut self, end: Instant) -> bool {
        let deadline = self.timeline.earliest();
        let others = deadline.min(self.next_change);
        if let Some(next) = self.bus.next() {
            let first = if next.begins {
                next.at < others && next.at < end
            } else {
                next.at <= others && next.at <= end
            };
            if first {
                self.now = self.bus.advance(next, others.min(end));
                return true;
            }
        }
        if others > end || others == Instant::MAX {
            return false;
        }
        self.now = self.now.max(others);
        if self.next_change <= deadline {
            self.change_next();
        } else {
            let node = self.timeline.first();
            self.feed(node, Input::Tick);
        }
        true
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

    /// Hands what the bus has to tell to the nodes, until nothing is left.
    fn serve_nodes(&mut self) {
        let mut index = 0;
        // Answers to commands come behind what is there already.
        while let Some(&(node, input)) = self.bus.outbox.get(index) {
            index += 1;
            self.feed(node, input);
        }
        self.bus.outbox.clear();
    }

    fn feed(&mut self, index: usize, input: Input) {
        let node = &mut self.nodes[index];
        if !node.powered {
            return;
        }
        if self.interest.contains(Interest::REQUESTS)
            && let Input::TxDone(token, outcome) = input
        {
            let (at, node) = (self.now, NodeId::new(index));
            self.pending.push(Pending::Done { at, node, token, outcome });
        }
        let local = node.clock.local(self.now);
        node.slot.input(local, input);
        self.drain(index);
    }

    /// Carries out what a machine wants, and notes when it must be called next.
    fn drain(&mut self, index: usize) {
        let node = &mut self.nodes[index];
        let local = node.clock.local(self.now);
        if node.last_call != self.now {
            node.last_call = self.now;
            node.calls = 0;
        }
        while let Some(action) = self.nodes[index].slot.poll(local) {
            self.carry_out(index, action);
            if self.called_too_often(index, "its output never ends") {
                return;
            }
        }
        let node = &self.nodes[index];
        let deadline = node.slot.deadline();
        let at = deadline.map_or(Instant::MAX, |deadline| node.clock.network(deadline.at).max(self.now));
        if let Some(deadline) = deadline
            && at == self.now
            && self.called_too_often(index, deadline.why)
        {
            return;
        }
        self.timeline.set(index, at);
    }

    /// Counts the calls of a machine at one moment. After too many, it is left alone for a while.
    fn called_too_often(&mut self, index: usize, why: &'static str) -> bool {
        let node = &mut self.nodes[index];
        node.calls += 1;
        if node.calls <= MOST_CALLS {
            return false;
        }
        self.timeline.set(index, after(self.now, STUCK_PAUSE));
        self.violation(index, referee::STUCK, || why.to_owned());
        true
    }

    fn carry_out(&mut self, index: usize, action: Action<E>) {
        match action {
            Action::Transmit(token, frame) => self.transmit(index, token, frame),
            Action::Withdraw(token) => self.bus.withdraw(self.now, index, token),
            Action::Link(command) => self.command_link(index, command),
            Action::Event(event) => {
                if self.interest.contains(Interest::EVENTS) {
                    self.pending.push(Pending::Event { at: self.now, node: NodeId::new(index), event });
                }
            }
        }
    }

    fn transmit(&mut self, index: usize, token: TxToken, frame: Frame) {
        if self.interest.contains(Interest::REQUESTS) {
            let (at, node) = (self.now, NodeId::new(index));
            self.pending.push(Pending::Request { at, node, token, frame });
        }
        if self.bus.in_flight(index) >= self.nodes[index].max_in_flight {
            let most = self.nodes[index].max_in_flight;
            self.violation(index, referee::IN_FLIGHT, || format!("{frame} when {most} are in flight"));
        }
        if self.bus.has_token(index, token) {
            self.violation(index, referee::TOKEN_REUSED, || format!("token {}: {frame}", token.0));
        }
        match self.bus.error_state(index) {
            None => self.violation(index, referee::LINK_DOWN, || frame.to_string()),
            Some(ErrorState::BusOff) => self.violation(index, referee::BUS_OFF, || frame.to_string()),
            Some(ErrorState::Active | ErrorState::Passive) if self.bus.mode(index).listen_only => {
                self.violation(index, referee::LISTEN_ONLY, || frame.to_string());
            }
            Some(ErrorState::Active | ErrorState::Passive) => {}
        }
        let node = &mut self.nodes[index];
        let ready = match node.reaction {
            Reaction::Immediate => self.now,
            Reaction::Fixed(delay) => self.now + delay,
            Reaction::Uniform(least, most) => {
                let range = u64::try_from(most.saturating_sub(least).as_nanos()).unwrap_or(u64::MAX);
                after(self.now + least, node.rng.below(range.saturating_add(1)))
            }
        };
        self.bus.request(index, token, frame, ready);
    }

    fn command_link(&mut self, index: usize, command: LinkCommand) {
        let answer = match command {
            LinkCommand::SetMode(mode) => self.set_mode(index, mode),
            LinkCommand::SetFilter(filter) => {
                self.bus.set_filter(index, filter);
                Some(LinkEvent::FilterSet)
            }
            LinkCommand::Reset => self.bus.reset(self.now, index).err().map(LinkEvent::Refused),
        };
        if let Some(event) = answer {
            self.bus.outbox.push((index, Input::Link(event)));
        }
    }

    fn set_mode(&mut self, index: usize, mode: Mode) -> Option<LinkEvent> {
        if let Err(kind) = self.bus.set_mode(self.now, index, mode) {
            return Some(LinkEvent::Refused(kind));
        }
        self.note_change(ChangeKind::Mode(NodeId::new(index), mode));
        Some(LinkEvent::ModeSet(mode))
    }

    fn change_next(&mut self) {
        let Some((_, change)) = self.changes.pop_first() else { return };
        self.next_change = self.changes.first_key_value().map_or(Instant::MAX, |((at, _), _)| *at);
        self.apply(change);
        self.serve_nodes();
    }

    /// Does something now.
    pub fn apply(&mut self, change: Change<E>) {
        let now = self.now;
        match change {
            Change::Cut(node) => {
                if self.exists(node) && std::mem::replace(&mut self.nodes[node.index()].plugged, false) {
                    self.note_change(ChangeKind::Cut(node));
                    self.bus.detach(now, node.index(), true);
                }
            }
            Change::Plug(node) => {
                if self.exists(node) && !std::mem::replace(&mut self.nodes[node.index()].plugged, true) {
                    self.note_change(ChangeKind::Plug(node));
                    if self.nodes[node.index()].powered {
                        self.bus.attach(now, node.index());
                    }
                }
            }
            Change::PowerOff(node) => self.power_off(node),
            Change::PowerOn(node) => self.power_on(node),
            Change::PowerCycle(node) => {
                self.power_off(node);
                self.power_on(node);
            }
            Change::SetBitRate(node, bit_rate) => self.change_mode(node, |mode| mode.bit_rate = bit_rate),
            Change::SetListenOnly(node, on) => self.change_mode(node, |mode| mode.listen_only = on),
            Change::SetClock(node, ppm) => {
                if self.exists(node) {
                    self.note_change(ChangeKind::Clock(node, ppm));
                    self.nodes[node.index()].clock.set(now, ppm);
                    self.bus.set_clock(now, node.index(), ppm);
                    self.drain(node.index());
                }
            }
            Change::SetReaction(node, reaction) => {
                if self.exists(node) {
                    self.note_change(ChangeKind::Reaction(node, reaction));
                    self.nodes[node.index()].reaction = reaction;
                }
            }
            Change::FaultOn(id, fault) => {
                self.note_change(ChangeKind::FaultOn(id, fault));
                self.bus.fault_on(now, id, fault);
            }
            Change::FaultOff(id) => {
                self.note_change(ChangeKind::FaultOff(id));
                self.bus.fault_off(id);
            }
            Change::Split(apart) => {
                self.bus.split(now, &apart);
                self.pend_change(OwnedChange::Split(apart));
            }
            Change::Join => {
                self.note_change(ChangeKind::Join);
                self.bus.join(now);
            }
            Change::Call(call) => call(self),
        }
    }

    fn power_on(&mut self, node: NodeId) {
        if !self.exists(node) || std::mem::replace(&mut self.nodes[node.index()].powered, true) {
            return;
        }
        self.note_change(ChangeKind::PowerOn(node));
        let index = node.index();
        self.nodes[index].slot.power_up();
        self.bus.reset_mode(index);
        if self.nodes[index].plugged {
            self.bus.attach(self.now, index);
        } else {
            self.drain(index);
        }
    }

    fn power_off(&mut self, node: NodeId) {
        if !self.exists(node) || !std::mem::replace(&mut self.nodes[node.index()].powered, false) {
            return;
        }
        self.note_change(ChangeKind::PowerOff(node));
        self.bus.detach(self.now, node.index(), false);
        self.timeline.set(node.index(), Instant::MAX);
        if let Some(producers) = &mut self.producers {
            producers.forget(node);
        }
    }

    fn change_mode(&mut self, node: NodeId, change: impl FnOnce(&mut Mode)) {
        if !self.exists(node) {
            return;
        }
        let mut mode = self.bus.mode(node.index());
        change(&mut mode);
        self.set_mode(node.index(), mode);
    }

    fn exists(&self, node: NodeId) -> bool {
        node.index() < self.nodes.len()
    }

    fn note_change(&mut self, change: ChangeKind<'static>) {
        self.pend_change(OwnedChange::Plain(change));
    }

    fn pend_change(&mut self, change: OwnedChange) {
        if self.interest.contains(Interest::CHANGES) {
            self.pending.push(Pending::Change { at: self.now, change });
        }
    }

    fn violation(&mut self, index: usize, rule: &'static str, what: impl FnOnce() -> String) {
        let violation = Violation { node: NodeId::new(index), at: self.now, rule, what: what() };
        self.blame(violation);
    }

    fn blame(&mut self, violation: Violation) {
        assert!(!self.config.strict, "seed {}: {violation}", self.config.seed);
        self.pending.push(Pending::Violation(self.violations.len()));
        self.violations.push(violation);
    }

    /// Shows what happened on the bus.
    fn publish_bus(&mut self, sink: &mut impl Sink<E>) {
        let mut blamed = Vec::new();
        for attempt in self.bus.finished.as_slice() {
            let Some(record) = FrameRecord::of(attempt) else { continue };
            if let Some(producers) = &mut self.producers {
                producers.see(&record, &mut |violation| blamed.push(violation));
            }
            if self.interest.contains(Interest::FRAMES) {
                show(&mut self.rules, &mut blamed, sink, &Record::Frame(record));
            }
        }
        self.bus.finished.clear();
        for note in self.bus.notes.drain(..) {
            let (record, interest) = match note {
                Note::Error(error) => (Record::Error(error), Interest::ERRORS),
                Note::Counters { at, node, counters } => {
                    (Record::Counters { at, node, counters }, Interest::COUNTERS)
                }
            };
            if self.interest.contains(interest) {
                show(&mut self.rules, &mut blamed, sink, &record);
            }
        }
        blamed.into_iter().for_each(|violation| self.blame(violation));
    }

    /// Shows what the machines did.
    fn publish(&mut self, sink: &mut impl Sink<E>) {
        while !self.pending.is_empty() {
            let mut pending = std::mem::take(&mut self.pending);
            let mut blamed = Vec::new();
            for one in pending.drain(..) {
                let record = match &one {
                    &Pending::Request { at, node, token, frame } => {
                        Record::Request { at, node, token, frame }
                    }
                    &Pending::Done { at, node, token, outcome } => Record::Done { at, node, token, outcome },
                    Pending::Event { at, node, event } => Record::Event { at: *at, node: *node, event },
                    Pending::Change { at, change } => Record::Change {
                        at: *at,
                        change: match change {
                            OwnedChange::Plain(change) => *change,
                            OwnedChange::Split(apart) => ChangeKind::Split(apart),
                        },
                    },
                    Pending::Violation(index) => {
                        if !self.interest.contains(Interest::VIOLATIONS) {
                            continue;
                        }
                        Record::Violation(&self.violations[*index])
                    }
                };
                show(&mut self.rules, &mut blamed, sink, &record);
            }
            // The memory is used again, unless somebody has added to the new one.
            if self.pending.is_empty() {
                self.pending = pending;
            }
            blamed.into_iter().for_each(|violation| self.blame(violation));
        }
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

fn show<E>(
    rules: &mut [Box<dyn Rule<E>>],
    blamed: &mut Vec<Violation>,
    sink: &mut impl Sink<E>,
    record: &Record<'_, E>,
) {
    for rule in rules {
        rule.see(record, &mut |violation| blamed.push(violation));
    }
    sink.record(record);
}

/// Calls of one machine at one moment before it counts as stuck. A master that talks to 63 slaves at once makes a few
/// hundred.
const MOST_CALLS: u32 = 10_000;
/// How long a stuck machine is left alone, in nanoseconds.
const STUCK_PAUSE: u64 = 1_000_000;
