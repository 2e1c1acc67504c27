//! Every interleaving of two and three nodes, by a model checker on the real machines.
//!
//! What may happen in any order: a node is powered up, a frame that waits for the bus is sent, one frame is lost by one
//! receiver, a cable is unplugged and plugged in again, segments are joined, time passes. A frame may wait for any time, as on a busy bus, for Hello has the lowest
//! priority. Each bus has other nodes that acknowledge. Time passes in steps of a part of the Hello wait, and worlds that
//! differ only in the time of day or in what was counted are the same.
//!
//! What must hold: once the bus has been quiet for a Hello wait there is one owner of an address at most; and from every
//! world, if nothing more goes wrong, every node gets on line or to Standby.

use std::time::{Duration, Instant as Clock};

use devicenex_core::access::{Access, AccessEvent, Config, Role, StateKind};
use devicenex_core::id::Direction;
use devicenex_core::message::{Hello, PortByte};
use link_core::{Action, BitRate, Frame, Input, Instant, LinkCommand, LinkEvent, Machine, TxOutcome};
use stateright::{Checker, HasDiscoveries, Model, Property};

use super::plant::{device, oa};

/// What is explored.
#[derive(Clone)]
struct Bus {
    /// One for each node; the first has the lowest identity.
    addresses: Vec<u8>,
    /// How many receptions may be lost.
    losses: u8,
    /// How often a cable may be unplugged.
    replugs: u8,
    /// How many steps of time make a Hello wait.
    steps: u16,
    /// The nodes with an odd number are on a segment of their own at first.
    split: bool,
    /// After how many steps of time a node tells its address again; 0: never.
    announcement: u8,
    /// A frame is sent before time passes.
    prompt: bool,
    /// Nodes on line do not hear Hello requests: a mistake that must be found.
    deaf_on_line: bool,
}

#[derive(Clone, PartialEq, Eq, Hash, Debug)]
struct World {
    nodes: Vec<Node>,
    losses_left: u8,
    replugs_left: u8,
    joined: bool,
    /// Steps of time since the last frame, as far as they matter.
    quiet: u16,
    /// Steps of time with two owners on a joined bus.
    conflict: u16,
}

#[derive(Clone, PartialEq, Eq, Hash, Debug)]
struct Node {
    access: Access,
    powered: bool,
    /// What waits for the bus.
    pending: Option<Frame>,
}

#[derive(Clone, Copy, PartialEq, Debug)]
enum Step {
    PowerUp(usize),
    Send(usize),
    /// Sent by the first, lost by the second.
    SendAndLose(usize, usize),
    Join,
    /// The cable of a node is unplugged, and plugged in again at once.
    Replug(usize),
    TimePasses,
}

impl Bus {
    /// Of that many nodes that want that address.
    fn of(addresses: &[u8]) -> Self {
        Self {
            addresses: addresses.to_vec(),
            losses: 1,
            replugs: 1,
            steps: 4,
            split: false,
            announcement: 0,
            prompt: false,
            deaf_on_line: false,
        }
    }

    fn step_millis(&self) -> u64 {
        u64::from(HELLO_WAIT / self.steps)
    }

    fn access(&self, place: usize, address: u8) -> Access {
        // It begins with an address, as if a ROAM had given it.
        let role = Role::NetworkManager { address: oa(address), bit_rate: BitRate::K500 };
        let mut config = Config::new(device(u32::try_from(place).unwrap()), PortByte::ZERO, role);
        config.hello_wait = HELLO_WAIT;
        config.announcement = u32::from(self.announcement) * u32::from(HELLO_WAIT / self.steps);
        Access::new(config)
    }

    fn connected(&self, world: &World, one: usize, other: usize) -> bool {
        !self.split || world.joined || one % 2 == other % 2
    }

    /// What follows if nothing more goes wrong: nodes are powered up, frames are sent, time passes.
    fn next_without_trouble(&self, world: &World) -> Step {
        let place_of = |wanted: fn(&Node) -> bool| world.nodes.iter().position(wanted);
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

    fn settles(&self, world: &World) -> bool {
        let mut world = world.clone();
        for _ in 0..SETTLED_AFTER {
            if world.is_settled() && (self.announcement == 0 || world.owners_are_alone()) {
                return world.owners_are_alone() && self.nobody_lost_an_uncontested_address(&world);
            }
            world = self.next_state(&world, self.next_without_trouble(&world)).unwrap();
        }
        false
    }

    fn nobody_lost_an_uncontested_address(&self, world: &World) -> bool {
        self.addresses.iter().zip(&world.nodes).all(|(address, node)| {
            let contested = self.addresses.iter().filter(|other| *other == address).count() > 1;
            contested || node.access.is_online()
        })
    }

    fn report(self, name: &str) -> usize {
        let started = Clock::now();
        let checker = self.checker().finish_when(HasDiscoveries::AnyFailures).spawn_bfs().join();
        checker.assert_properties();
        let states = checker.unique_state_count();
        println!("{name}: {states} worlds, {:.1?}", started.elapsed());
        states
    }
}

impl Model for Bus {
    type State = World;
    type Action = Step;

    fn init_states(&self) -> Vec<World> {
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

    fn actions(&self, world: &World, steps: &mut Vec<Step>) {
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

    fn next_state(&self, world: &World, step: Step) -> Option<World> {
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
            Property::always(ONE_OWNER, |bus: &Self, world: &World| {
                let quiet = world.quiet >= bus.steps && world.nodes.iter().all(|node| node.pending.is_none());
                bus.split || !quiet || world.owners_are_alone()
            }),
            Property::always(CONFLICT_ENDS, |bus: &Self, world: &World| {
                // Each lost frame may cost another announcement.
                let lost = bus.losses - world.losses_left;
                !bus.split || world.conflict <= u16::from(bus.announcement) * u16::from(1 + lost)
            }),
            Property::always(WAY_FORWARD, |bus: &Self, world: &World| bus.settles(world)),
            Property::sometimes("a node on line", |_, world: &World| {
                world.nodes.iter().any(|node| node.access.is_online())
            }),
        ]
    }
}

impl World {
    fn send(&mut self, bus: &Bus, sender: usize, loser: Option<usize>) {
        let frame = self.nodes[sender].pending.take().unwrap();
        let receivers: Vec<_> = (0..self.nodes.len())
            .filter(|&place| place != sender && Some(place) != loser && bus.connected(self, sender, place))
            .collect();
        for place in receivers {
            let node = &mut self.nodes[place];
            let is_request =
                matches!(Hello::of_frame(&frame), Some(Ok(hello)) if hello.direction == Direction::Request);
            if node.powered && !(bus.deaf_on_line && is_request && node.access.is_online()) {
                node.input(Instant::ZERO, Input::Frame(frame));
            }
        }
        self.nodes[sender].input(Instant::ZERO, Input::TxDone(Access::TOKEN, TxOutcome::Sent));
        self.quiet = 0;
        if self.owners_are_alone() {
            self.conflict = 0;
        }
    }

    fn time_passes(&mut self, bus: &Bus) {
        let had_two_owners = !self.owners_are_alone();
        let span = Duration::from_millis(bus.step_millis());
        for node in self.nodes.iter_mut().filter(|node| node.powered) {
            node.input(Instant::ZERO + span, Input::Tick);
            node.access.shift_time(span);
        }
        self.quiet = (self.quiet + 1).min(bus.steps);
        if bus.split && self.joined && had_two_owners {
            self.conflict = (self.conflict + 1).min(MUCH_TOO_LONG);
        }
    }

    /// No two nodes on line have one address.
    fn owners_are_alone(&self) -> bool {
        let mut owned: Vec<_> = self
            .nodes
            .iter()
            .filter(|node| node.access.is_online())
            .map(|node| node.access.address().number())
            .collect();
        let owners = owned.len();
        owned.sort_unstable();
        owned.dedup();
        owned.len() == owners
    }

    fn is_settled(&self) -> bool {
        self.joined
            && self.nodes.iter().all(|node| {
                let kind = node.access.state().kind();
                matches!(kind, StateKind::Online | StateKind::Standby) && node.pending.is_none()
            })
    }
}

impl Node {
    /// What was with the controller is dropped by it.
    fn replug(&mut self) {
        self.input(Instant::ZERO, Input::Link(LinkEvent::Down));
        if self.pending.take().is_some() {
            self.input(Instant::ZERO, Input::TxDone(Access::TOKEN, TxOutcome::Dropped));
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
        self.access.clear_counters();
    }

    /// What the controller answers at once.
    fn carry_out(&mut self, action: Action<AccessEvent>) -> Option<Input> {
        match action {
            Action::Transmit(_, frame) => {
                assert_eq!(self.pending.replace(frame), None, "two frames in flight");
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

#[test]
fn two_nodes_with_one_address() {
    let worlds = Bus::of(&[67, 67]).report("two nodes, one address, one lost frame");
    assert!(worlds > 1000, "{worlds}");
}

#[test]
fn two_nodes_with_different_addresses() {
    Bus::of(&[67, 68]).report("two nodes, two addresses, one lost frame");
}

#[test]
fn three_nodes_of_which_two_or_three_want_one_address() {
    for addresses in [[67, 67, 67], [67, 68, 67]] {
        let bus = Bus { steps: 2, ..Bus::of(&addresses) };
        bus.report(&format!("three nodes, addresses {addresses:?}, one lost frame"));
    }
}

#[test]
fn joined_segments() {
    let bus = Bus { split: true, announcement: 6, prompt: true, ..Bus::of(&[67, 67]) };
    bus.report("two joined segments, announcements, one lost frame");
}

/// The checker finds what it should: a copy that does not defend its address.
#[test]
fn a_node_that_does_not_defend_its_address_is_found() {
    let checker = Bus { deaf_on_line: true, ..Bus::of(&[67, 67]) }
        .checker()
        .finish_when(HasDiscoveries::AnyFailures)
        .spawn_bfs()
        .join();
    let discoveries = checker.discoveries();
    let found = discoveries.get(ONE_OWNER).or(discoveries.get(WAY_FORWARD));
    let steps = found.expect("two owners").clone().into_actions();
    println!("two owners after {} steps: {steps:?}", steps.len());
}

/// And that the announcement is what ends the conflict of joined segments: without it, nobody speaks.
#[test]
fn without_announcements_joined_segments_keep_two_owners() {
    let checker = Bus { split: true, prompt: true, ..Bus::of(&[67, 67]) }
        .checker()
        .finish_when(HasDiscoveries::AnyFailures)
        .spawn_bfs()
        .join();
    let discoveries = checker.discoveries();
    assert!(discoveries.contains_key(CONFLICT_ENDS) || discoveries.contains_key(WAY_FORWARD));
}

const HELLO_WAIT: u16 = 1000;
const MUCH_TOO_LONG: u16 = 100;
/// Steps without trouble after which everybody is on line or in Standby.
const SETTLED_AFTER: usize = 60;
const ONE_OWNER: &str = "one owner of an address on a quiet bus";
const CONFLICT_ENDS: &str = "joined segments come to one owner";
const WAY_FORWARD: &str = "every node gets on line or to Standby";
