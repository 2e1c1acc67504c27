//! Whole DeviceNeX networks on the simulated bus, exact to the bit: a manager, the devices of its plan with a spare, and, in some
//! of them, a second manager, a device that nobody planned, and nodes that come back after bus-off.
//!
//! Byte 0 is what the network is like:
//!
//! | Bits | Content |
//! |---|---|
//! | 1-0 | the bit rate: 125, 250, 500 kbit/s, and 500 again |
//! | 2 | there is a second manager |
//! | 3 | its serial number is the lower one |
//! | 5-4 | the device that nobody planned: there is none, or it begins with OA 40, 67 or 5 |
//! | 6 | the bus-off interrupt of all nodes is 1 |
//! | 7 | the nodes have power one after the other, a second apart, and not all at once |
//!
//! Then each operation is one byte, modulo 12, with its argument behind it:
//!
//! | Byte | Operation | Argument |
//! |---|---|---|
//! | 0-2 | the network runs | [span](crate::input::span) |
//! | 3 | the power of a node fails and comes back; or fails, or comes back | which in bits 2-0, which of the three in bits 7-6 |
//! | 4 | a node loses the next frames | which in bits 2-0, how many in bits 7-3 |
//! | 5 | a node sees the end of the next frames spoilt | as before |
//! | 6 | bits are inverted, for all or for one node | which in bits 2-0, for all in bit 3, how many in bits 7-6 |
//! | 7 | nothing is wrong with the wire any more | |
//! | 8 | some nodes are on a segment of their own; none: the segments are joined | a bit for each |
//! | 9 | a node is unplugged, or plugged again | which |
//! | 10 | the inputs of the devices change | value |
//! | 11 | a stranger says something, or the manager is commanded something | what in bits 7-2, to which node in bits 1-0 |
//!
//! Each node has a referee of its own, `observed`, that hears and says what the node does. Besides, the network is judged:
//! never two nodes on line with one address once nothing was wrong for a while; no rule of the bus is broken; and left alone,
//! with power and cables, one manager works, and what it plans and is there runs.

mod node;
mod observed;
mod stranger;

use core::time::Duration;
use std::collections::BTreeSet;

use devicenex_core::access::StateKind;
use devicenex_core::manager::DeviceState;
use link_core::{BitRate, Instant};
use transport_mock::nodes::{External, Listener};
use transport_mock::{BusConfig, Change, Fault, FaultId, Ignore, Network, NodeConfig, NodeId, Scope, Which};

use crate::plant::{NODES, OWN, device, oa};
use node::{Node, Station};

/// Lets a network live as the bytes say.
pub fn run(data: &[u8]) {
    let Some((plan, operations)) = crate::input::plan_and_operations(data, MOST_OPERATIONS) else { return };
    let mut plant = Plant::new(plan);
    for [op, argument] in operations {
        plant.apply(op, argument);
    }
    plant.come_to_rest();
}

struct Plant {
    network: Network<()>,
    /// The managers first.
    nodes: Vec<NodeId>,
    stranger: NodeId,
    /// It acknowledges what is said on the other segment: a lone node would say its first frame for ever.
    ear: NodeId,
    /// The device that nobody planned has this address at the beginning.
    uninvited: Option<u8>,
    faults: BTreeSet<u32>,
    is_split: bool,
    /// Since when nothing is wrong with the wire.
    calm_since: Instant,
    transaction: u8,
}

impl Plant {
    fn new(plan: u8) -> Self {
        let rate = [BitRate::K125, BitRate::K250, BitRate::K500, BitRate::K500][usize::from(plan & 3)];
        let restarts = plan & 0x40 != 0;
        let uninvited = [None, Some(40), Some(67), Some(5)][usize::from(plan >> 4 & 3)];
        let mut nodes = vec![Node::manager(0x80, OWN, rate, restarts)];
        if plan & 4 != 0 {
            nodes.push(Node::manager(if plan & 8 != 0 { 0x70 } else { 0x90 }, SECOND, rate, restarts));
        }
        nodes.extend((0..DEVICES).map(|which| Node::device(device(which), which, 127, restarts)));
        nodes.extend(uninvited.map(|address| Node::device(device(UNINVITED), UNINVITED, address, restarts)));
        let mut network = Network::new(BusConfig::new(rate, 1));
        let stagger = if plan & 0x80 != 0 { Duration::from_secs(1) } else { Duration::ZERO };
        let nodes = (0..).zip(nodes).map(|(at, node)| {
            let power_up = Some(Instant::ZERO + stagger * at);
            network.add(NodeConfig { power_up, ..NodeConfig::named(at.to_string()) }, node)
        });
        let nodes: Vec<NodeId> = nodes.collect();
        let stranger = External::<()>::new().with_restart(Duration::from_millis(100));
        let stranger = network.add_silent(NodeConfig::named("stranger"), stranger);
        let ear = network.add_silent(NodeConfig::named("ear"), Listener::new(1));
        Self {
            network,
            nodes,
            stranger,
            ear,
            uninvited,
            faults: BTreeSet::new(),
            is_split: false,
            calm_since: Instant::ZERO,
            transaction: 0,
        }
    }

    fn apply(&mut self, op: u8, argument: u8) {
        let node = self.nodes[usize::from(argument & 7) % self.nodes.len()];
        let count = Which::Next(u32::from(argument >> 3));
        match op % 12 {
            0..=2 => {
                let longest = if self.faults.contains(&NOISE) { LONGEST_NOISE } else { LONGEST_RUN };
                return self.run_for(crate::input::span(argument).min(longest));
            }
            3 => self.network.apply(match argument >> 6 {
                0 | 1 => Change::PowerCycle(node),
                2 => Change::PowerOff(node),
                _ => Change::PowerOn(node),
            }),
            4 => self.fault(
                Fault::Overrun { receiver: node, filter: None, which: count },
                u32::from(argument & 7),
            ),
            5 => {
                let fault = Fault::SpoiltEnd { receiver: node, filter: None, which: count };
                self.fault(fault, 8 + u32::from(argument & 7));
            }
            6 => {
                let rate = [1e-4, 1e-3, 5e-3, 2e-2][usize::from(argument >> 6)];
                let scope = if argument & 8 != 0 { Scope::Bus } else { Scope::Node(node) };
                self.fault(Fault::BitFlips { rate, scope }, NOISE);
            }
            7 => self.end_faults(),
            8 => self.split(argument),
            9 if self.network.is_plugged(node) => self.network.apply(Change::Cut(node)),
            9 => self.network.apply(Change::Plug(node)),
            10 => self.set_inputs(argument),
            _ => self.meddle(argument),
        }
        // What was done happens before what is done next.
        self.run_for(Duration::ZERO);
    }

    fn fault(&mut self, fault: Fault, number: u32) {
        self.faults.insert(number);
        self.network.apply(Change::FaultOn(FaultId(number), fault));
    }

    fn end_faults(&mut self) {
        for number in core::mem::take(&mut self.faults) {
            self.network.apply(Change::FaultOff(FaultId(number)));
            self.calm_since = self.network.now();
        }
    }

    fn split(&mut self, which: u8) {
        if core::mem::take(&mut self.is_split) {
            self.network.apply(Change::Join);
            self.calm_since = self.network.now();
        }
        let apart = (0_u8..).zip(&self.nodes).filter(|(at, _)| *at < 8 && which >> at & 1 == 1);
        let apart: Vec<NodeId> = apart.map(|(_, node)| *node).collect();
        if !apart.is_empty() {
            self.is_split = true;
            self.network.apply(Change::Split([&apart[..], &[self.ear]].concat()));
        }
    }

    fn set_inputs(&mut self, value: u8) {
        for &node in &self.nodes {
            self.network.command(node, |node: &mut Node, now| {
                if let Station::Device(device) = &mut node.station {
                    device.application_mut().inputs[0] = value;
                    device.inputs_changed(now);
                }
            });
        }
    }

    fn run_for(&mut self, span: Duration) {
        self.network.run_until(self.network.now() + span, &mut Ignore);
        assert_eq!(self.network.violations(), [], "the rules of the bus");
        let is_calm = self.faults.is_empty() && !self.is_split;
        if is_calm && self.network.now().saturating_since(self.calm_since) >= QUIET {
            self.nobody_shares_an_address();
        }
    }

    fn node(&self, node: NodeId) -> &Node {
        self.network.machine(node).expect("a node of the plant")
    }

    fn online(&self) -> impl Iterator<Item = (NodeId, u8)> {
        let online = self.nodes.iter().filter(|node| self.network.is_powered(**node));
        online.filter(|node| self.node(**node).access().is_online()).map(|node| {
            let address = self.node(*node).access().address().number();
            (*node, address)
        })
    }

    fn nobody_shares_an_address(&self) {
        let mut addresses = BTreeSet::new();
        for (node, address) in self.online() {
            assert!(addresses.insert(address), "{node} has OA {address}, and another too");
        }
    }

    /// Left alone, with power and cables, one manager works, and what it plans and is there runs.
    fn come_to_rest(&mut self) {
        self.end_faults();
        self.split(0);
        for node in self.nodes.clone() {
            self.network.apply(Change::Plug(node));
            let access = self.node(node).access();
            let is_stuck = matches!(access.state().kind(), StateKind::BusOff | StateKind::Faulted)
                || self.node(node).as_manager().is_some() && access.address().is_none();
            self.network.apply(if is_stuck { Change::PowerCycle(node) } else { Change::PowerOn(node) });
        }
        self.run_for(REST);
        let kinds: Vec<StateKind> =
            self.nodes.iter().map(|node| self.node(*node).access().state().kind()).collect();
        if kinds.contains(&StateKind::BusOff) {
            // Two that had one address have driven each other off the bus before one of them could tell it.
            return;
        }
        let settled = |kind: &StateKind| matches!(kind, StateKind::Online | StateKind::Standby);
        assert!(kinds.iter().all(settled), "{kinds:?}");
        let managers = self.nodes.iter().filter_map(|node| self.node(*node).as_manager());
        let working: Vec<_> = managers.filter(|manager| manager.works()).collect();
        let [manager] = working[..] else { panic!("{} managers work", working.len()) };
        let taken: Vec<u8> = self.uninvited.into_iter().collect();
        for &address in NODES[..3].iter().filter(|address| !taken.contains(address)) {
            // Without its producer a consumer has nothing to consume.
            if !taken.contains(&67) {
                let state = manager.device(oa(address)).map(|view| view.state);
                assert_eq!(state, Some(DeviceState::Running), "OA {address}");
            }
        }
    }
}

/// The address of the second manager.
const SECOND: u8 = 2;
/// Producer, spare, and consumers, of which two are of one product.
const DEVICES: u8 = 5;
const UNINVITED: u8 = 5;
const LONGEST_RUN: Duration = Duration::from_secs(12);
/// While bits are inverted, each of them is simulated.
const LONGEST_NOISE: Duration = Duration::from_millis(500);
/// The number of that fault.
const NOISE: u32 = 16;
/// Longer than from one announcement of an address to the next, with the wait for the answer.
const QUIET: Duration = Duration::from_secs(15);
/// Longer than any time-out and any pause of a manager, and than three of them in a row.
const REST: Duration = Duration::from_secs(120);
const MOST_OPERATIONS: usize = 40;

#[cfg(test)]
mod tests {
    use super::*;

    fn after(bytes: &[u8]) -> Plant {
        run(bytes);
        let mut plant = Plant::new(bytes[0]);
        for op in bytes[1..].chunks(2) {
            plant.apply(op[0], op[1]);
        }
        plant
    }

    fn outputs(plant: &Plant, at: usize) -> [[u8; 2]; 2] {
        plant.node(plant.nodes[at]).as_device().expect("a device").application().outputs
    }

    /// Detection, addresses and connections take a good ten seconds.
    #[test]
    fn a_plant_is_brought_up_and_data_flow() {
        let plant = after(&[2, 0, 0xCC, 0, 0xCC, 10, 7, 0, 0xC1]);
        // The producer is the first device, after the manager.
        for at in [3, 4] {
            assert_eq!(outputs(&plant, at)[0], [7, 0]);
        }
    }

    #[test]
    fn the_spare_takes_over() {
        let plant = after(&[2, 0, 0xCC, 0, 0xCC, 9, 1, 0, 0xCC, 10, 9, 0, 0xC1]);
        assert_eq!(outputs(&plant, 3)[0], [9, 1]);
    }

    /// Each manager on its own segment works; together one of them does.
    #[test]
    fn two_managers_are_joined() {
        let mut plant = after(&[0x06, 8, 0x12, 0, 0xCC, 0, 0xCC]);
        let working = |plant: &Plant| {
            let works = |at: &usize| plant.node(plant.nodes[*at]).as_manager().expect("a manager").works();
            [0, 1].iter().filter(|at| works(at)).count()
        };
        assert_eq!(working(&plant), 2);
        plant.apply(8, 0);
        for _ in 0..3 {
            plant.apply(0, 0xCC);
        }
        assert_eq!(working(&plant), 1);
    }
}
