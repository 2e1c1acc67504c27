//! A bus on which anything may happen in any order, and what must hold on it.
//!
//! A node is powered up, a frame that waits for the bus is sent, one frame is lost by one receiver, a cable is unplugged and
//! plugged in again, segments are joined, time passes. A frame may wait for any time, as on a busy bus. Each bus has other
//! nodes that acknowledge. Time passes in steps of a part of the wait, and worlds that differ only in the time of day or in
//! what was counted are the same.
//!
//! Once the bus has been quiet for a wait there is one owner of an address at most; and from every world, if nothing more goes
//! wrong, every node comes to an end of its check.

use std::fmt::Debug;
use std::hash::Hash;
use std::marker::PhantomData;
use std::time::{Duration, Instant as Clock};

use link_core::{Action, Frame, Input, Instant, LinkCommand, LinkEvent, Machine, TxOutcome, TxToken};
use stateright::{Checker, HasDiscoveries, Model, Property};

/// Network access of a protocol.
pub(crate) trait Protocol: Clone + Eq + Hash + Debug + Send + Sync + 'static {
    type Access: Machine + Clone + Eq + Hash + Debug + Send + Sync;

    /// A node without power that wants that address; a lower place has a lower identity. The announcement is in ms, 0 for
    /// never.
    fn access(place: u32, address: u8, announcement: u32) -> Self::Access;

    fn address_on_line(access: &Self::Access) -> Option<u8>;

    /// It has come to an end of its check, whatever that is.
    fn is_settled(access: &Self::Access) -> bool;

    /// Whether the frame is to be answered by the owner of the address.
    fn is_challenge(frame: &Frame) -> bool;

    /// Moves its time towards zero, and forgets what it counted.
    fn forget_time_and_counts(access: &mut Self::Access, span: Duration);
}

/// What is explored.
#[derive(Clone)]
pub(crate) struct Bus<P> {
    /// One for each node; the first has the lowest identity.
    pub(crate) addresses: Vec<u8>,
    /// How many receptions may be lost.
    pub(crate) losses: u8,
    /// How often a cable may be unplugged.
    pub(crate) replugs: u8,
    /// How many steps of time make a wait.
    pub(crate) steps: u16,
    /// The nodes with an odd number are on a segment of their own at first.
    pub(crate) split: bool,
    /// After how many steps of time a node tells its address again; 0: never.
    pub(crate) announcement: u8,
    /// A frame is sent before time passes.
    pub(crate) prompt: bool,
    /// Nodes on line do not hear who wants their address: a mistake that must be found.
    pub(crate) deaf_on_line: bool,
    pub(crate) protocol: PhantomData<P>,
}

#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(crate) struct World<P: Protocol> {
    nodes: Vec<Node<P>>,
    losses_left: u8,
    replugs_left: u8,
    joined: bool,
    /// Steps of time since the last frame, as far as they matter.
    quiet: u16,
    /// Steps of time with two owners on a joined bus.
    conflict: u16,
}

#[derive(Clone, PartialEq, Eq, Hash, Debug)]
struct Node<P: Protocol> {
    access: P::Access,
    powered: bool,
    /// What waits for the bus.
    pending: Option<(TxToken, Frame)>,
}

#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum Step {
    PowerUp(usize),
    Send(usize),
    /// Sent by the first, lost by the second.
    SendAndLose(usize, usize),
    Join,
    /// The cable of a node is unplugged, and plugged in again at once.
    Replug(usize),
    TimePasses,
}

impl<P: Protocol> Bus<P> {
    /// Of that many nodes that want that address.
    pub(crate) fn of(addresses: &[u8]) -> Self {
        Self {
            addresses: addresses.to_vec(),
            losses: 1,
            replugs: 1,
            steps: 4,
            split: false,
            announcement: 0,
            prompt: false,
            deaf_on_line: false,
            protocol: PhantomData,
        }
    }

    fn step_millis(&self) -> u64 {
        u64::from(WAIT_MILLIS / self.steps)
    }

    fn access(&self, place: usize, address: u8) -> P::Access {
        let announcement = u64::from(self.announcement) * self.step_millis();
        P::access(u32::try_from(place).unwrap(), address, u32::try_from(announcement).unwrap())
    }

    fn connected(&self, world: &World<P>, one: usize, other: usize) -> bool {
        !self.split || world.joined || one % 2 == other % 2
    }

    /// What follows if nothing more goes wrong: nodes are powered up, frames are sent, time passes.
    fn next_without_trouble(&self, world: &World<P>) -> Step {
        let place_of = |wanted: fn(&Node<P>) -> bool| world.nodes.iter().position(wanted);
        if let Some(dark) = place_of(|node| !node.powered) {
            Step::PowerUp(dark)
        } else if let Some(sender) = place_of(|node| node.pending.is_some()) {
            Step::Send(sender)
        } else if self.split && !world.joined {
            Step::Join
        } else {
            Step::TimePasses
        }
    }

    fn settles(&self, world: &World<P>) -> bool {
        let mut world = world.clone();
        for _ in 0..SETTLED_AFTER {
            if world.is_settled() && (self.announcement == 0 || world.owners_are_alone()) {
                return world.owners_are_alone() && self.nobody_lost_an_uncontested_address(&world);
            }
            world = self.next_state(&world, self.next_without_trouble(&world)).unwrap();
        }
        false
    }

    fn nobody_lost_an_uncontested_address(&self, world: &World<P>) -> bool {
        self.addresses.iter().zip(&world.nodes).all(|(address, node)| {
            let contested = self.addresses.iter().filter(|other| *other == address).count() > 1;
            contested || P::address_on_line(&node.access) == Some(*address)
        })
    }

    /// Demands that all properties hold in every world, and tells how many there are.
    pub(crate) fn check(self, name: &str) -> usize {
        let started = Clock::now();
        let checker = self.checker().finish_when(HasDiscoveries::AnyFailures).spawn_bfs().join();
        checker.assert_properties();
        let worlds = checker.unique_state_count();
        println!("{name}: {worlds} worlds, {:.1?}", started.elapsed());
        worlds
    }

    /// Demands that the property is broken, and tells how.
    pub(crate) fn finds(self, property: &'static str) -> Vec<Step> {
        let wanted = HasDiscoveries::AnyOf([property].into());
        let checker = self.checker().finish_when(wanted).spawn_bfs().join();
        checker.discovery(property).expect("it should be broken").into_actions()
    }
}

impl<P: Protocol> Model for Bus<P> {
    type State = World<P>;
    type Action = Step;

    fn init_states(&self) -> Vec<World<P>> {
        let nodes = self.addresses.iter().enumerate();
        vec![World {
            nodes: nodes
                .map(|(place, &address)| Node {
                    access: self.access(place, address),
                    powered: false,
                    pending: None,
                })
                .collect(),
            losses_left: self.losses,
            replugs_left: self.replugs,
            joined: !self.split,
            quiet: 0,
            conflict: 0,
        }]
    }

    fn actions(&self, world: &World<P>, steps: &mut Vec<Step>) {
        for (place, node) in world.nodes.iter().enumerate() {
            if !node.powered {
                steps.push(Step::PowerUp(place));
            } else if world.replugs_left > 0 {
                steps.push(Step::Replug(place));
            }
            if node.pending.is_none() {
                continue;
            }
            steps.push(Step::Send(place));
            if world.losses_left > 0 {
                let others = (0..world.nodes.len()).filter(|&other| {
                    other != place && world.nodes[other].powered && self.connected(world, place, other)
                });
                steps.extend(others.map(|other| Step::SendAndLose(place, other)));
            }
        }
        if self.split && !world.joined {
            steps.push(Step::Join);
        }
        if !self.prompt || world.nodes.iter().all(|node| node.pending.is_none()) {
            steps.push(Step::TimePasses);
        }
    }

    fn next_state(&self, world: &World<P>, step: Step) -> Option<World<P>> {
        let mut next = world.clone();
        match step {
            Step::PowerUp(place) => {
                next.nodes[place].powered = true;
                next.nodes[place].input(Instant::ZERO, Input::Link(LinkEvent::Up));
            }
            Step::Send(sender) => next.send(self, sender, None),
            Step::SendAndLose(sender, loser) => {
                next.losses_left -= 1;
                next.send(self, sender, Some(loser));
            }
            Step::Join => next.joined = true,
            Step::Replug(place) => {
                next.replugs_left -= 1;
                next.nodes[place].replug();
            }
            Step::TimePasses => next.time_passes(self),
        }
        Some(next)
    }

    fn properties(&self) -> Vec<Property<Self>> {
        vec![
            Property::always(ONE_OWNER, |bus: &Self, world: &World<P>| {
                let quiet = world.quiet >= bus.steps && world.nodes.iter().all(|node| node.pending.is_none());
                bus.split || !quiet || world.owners_are_alone()
            }),
            Property::always(CONFLICT_ENDS, |bus: &Self, world: &World<P>| {
                // Each lost frame may cost another announcement.
                let lost = bus.losses - world.losses_left;
                !bus.split || world.conflict <= u16::from(bus.announcement) * u16::from(1 + lost)
            }),
            Property::always(WAY_FORWARD, |bus: &Self, world: &World<P>| bus.settles(world)),
            Property::sometimes("a node on line", |_, world: &World<P>| {
                world.nodes.iter().any(|node| P::address_on_line(&node.access).is_some())
            }),
        ]
    }
}

impl<P: Protocol> World<P> {
    fn send(&mut self, bus: &Bus<P>, sender: usize, loser: Option<usize>) {
        let (token, frame) = self.nodes[sender].pending.take().unwrap();
        let receivers: Vec<_> = (0..self.nodes.len())
            .filter(|&place| place != sender && Some(place) != loser && bus.connected(self, sender, place))
            .collect();
        for place in receivers {
            let node = &mut self.nodes[place];
            let on_line = P::address_on_line(&node.access).is_some();
            if node.powered && !(bus.deaf_on_line && P::is_challenge(&frame) && on_line) {
                node.input(Instant::ZERO, Input::Frame(frame));
            }
        }
        self.nodes[sender].input(Instant::ZERO, Input::TxDone(token, TxOutcome::Sent));
        self.quiet = 0;
        if self.owners_are_alone() {
            self.conflict = 0;
        }
    }

    fn time_passes(&mut self, bus: &Bus<P>) {
        let had_two_owners = !self.owners_are_alone();
        let span = Duration::from_millis(bus.step_millis());
        for node in self.nodes.iter_mut().filter(|node| node.powered) {
            node.input(Instant::ZERO + span, Input::Tick);
            P::forget_time_and_counts(&mut node.access, span);
        }
        self.quiet = (self.quiet + 1).min(bus.steps);
        if bus.split && self.joined && had_two_owners {
            self.conflict = (self.conflict + 1).min(MUCH_TOO_LONG);
        }
    }

    /// No two nodes on line have one address.
    fn owners_are_alone(&self) -> bool {
        let mut owned: Vec<_> =
            self.nodes.iter().filter_map(|node| P::address_on_line(&node.access)).collect();
        let owners = owned.len();
        owned.sort_unstable();
        owned.dedup();
        owned.len() == owners
    }

    fn is_settled(&self) -> bool {
        self.joined && self.nodes.iter().all(|node| P::is_settled(&node.access) && node.pending.is_none())
    }
}

impl<P: Protocol> Node<P> {
    /// What was with the controller is dropped by it.
    fn replug(&mut self) {
        self.input(Instant::ZERO, Input::Link(LinkEvent::Down));
        if let Some((token, _)) = self.pending.take() {
            self.input(Instant::ZERO, Input::TxDone(token, TxOutcome::Dropped));
        }
        self.input(Instant::ZERO, Input::Link(LinkEvent::Up));
    }

    fn input(&mut self, now: Instant, input: Input) {
        let mut inputs = vec![input];
        while let Some(input) = inputs.pop() {
            self.access.input(now, input);
            while let Some(action) = self.access.poll(now) {
                inputs.extend(self.carry_out(action));
            }
        }
        P::forget_time_and_counts(&mut self.access, Duration::ZERO);
    }

    /// What the controller answers at once.
    fn carry_out(&mut self, action: Action<<P::Access as Machine>::Event>) -> Option<Input> {
        match action {
            Action::Transmit(token, frame) => {
                assert_eq!(self.pending.replace((token, frame)), None, "two frames in flight");
                None
            }
            Action::Withdraw(token) => {
                self.pending = None;
                Some(Input::TxDone(token, TxOutcome::Withdrawn))
            }
            Action::Link(LinkCommand::SetMode(mode)) => Some(Input::Link(LinkEvent::ModeSet(mode))),
            Action::Link(LinkCommand::SetFilter(_) | LinkCommand::Reset) | Action::Event(_) => None,
        }
    }
}

/// How long others have to object.
pub(crate) const WAIT_MILLIS: u16 = 1000;
const MUCH_TOO_LONG: u16 = 100;
/// Steps without trouble after which every node has come to an end of its check.
const SETTLED_AFTER: usize = 60;
pub(crate) const ONE_OWNER: &str = "one owner of an address on a quiet bus";
pub(crate) const CONFLICT_ENDS: &str = "joined segments come to one owner";
pub(crate) const WAY_FORWARD: &str = "every node comes to an end of its check";
