//! From a scenario to machines on a bus.

use core::time::Duration;

use devicenet_core::access::Access;
use link_core::{Filter, Instant, StandardId, frame::standard_id};
use transport_mock::bus::Fault;
use transport_mock::nodes::{Babbler, Listener, Replay};
use transport_mock::rng::Rng;
use transport_mock::{BusConfig, Change, FaultId, Network, NodeConfig, NodeId, Reaction, Scope, Which};

use super::act::{act, remember};
use super::doors;
use super::event::NodeEvent;
use super::machines::{
    DeviceMachine, ManagerMachine, MasterMachine, SlaveMachine, ToolMachine, access_config,
};
use crate::scenario::{FaultKind, Node, NodeIndex, Protocol, Recorded, Role, Scenario, TimeRange};

/// What a run sets otherwise than the scenario.
#[derive(Clone, Copy, Debug, Default)]
pub struct Settings {
    /// The seed, instead of that of the scenario.
    pub seed: Option<u64>,
    /// How long to run, instead of the duration of the scenario.
    pub until: Option<Duration>,
}

/// Builds the network and plans everything that will be done to it. External nodes are driven from outside if
/// `is_served`; else they are there and acknowledge.
pub(super) fn network(scenario: &Scenario, seed: u64, is_served: bool) -> Network<NodeEvent> {
    let shared = match scenario.protocol() {
        Protocol::DeviceNet => is_shared,
        Protocol::DeviceNex => |_| false,
    };
    let config = BusConfig { shared: Some(shared), ..BusConfig::new(scenario.bus.bit_rate, seed) };
    let mut network = Network::new(config);
    let mut ids = Vec::new();
    for (index, node) in scenario.nodes.iter().enumerate() {
        ids.push(add(&mut network, node, seed, index, is_served));
    }
    plan_faults(&mut network, scenario, &ids);
    for action in &scenario.actions {
        for node in &action.nodes {
            let (id, what) = (ids[node.0], action.what.clone());
            network.schedule(action.at, Change::Call(Box::new(move |network| act(network, id, &what))));
        }
    }
    network
}

/// Of a fault on the bus: the fault of the scenario, and which part of it.
pub(super) const fn fault_of(id: FaultId) -> (usize, u32) {
    ((id.0 & 0xFFFF) as usize, id.0 >> 16)
}

fn add(network: &mut Network<NodeEvent>, node: &Node, seed: u64, index: usize, is_served: bool) -> NodeId {
    let config = NodeConfig {
        power_up: Some(draw(node.power_up, seed, index)),
        bit_rate: Some(node.bit_rate),
        // A DeviceNeX device disturbs nobody before it knows the bit rate.
        listen_only: matches!(node.role, Role::Listener | Role::Device(_)),
        reaction: match node.reaction {
            TimeRange { max: Duration::ZERO, .. } => Reaction::Immediate,
            TimeRange { min, max } if min == max => Reaction::Fixed(min),
            TimeRange { min, max } => Reaction::Uniform(min, max),
        },
        clock_ppm: node.clock_ppm,
        own_power: is_served && node.role == Role::External,
        ..NodeConfig::named(node.name.as_str())
    };
    match &node.role {
        Role::Access(access) => {
            let machine = Access::new(access_config(access));
            network.add_with_memory(config, machine, |old, fresh| remember(fresh, old.mac_id()))
        }
        Role::Slave(slave) => {
            let (spec, machine) = (slave.clone(), SlaveMachine::new(slave, node.bit_rate));
            network.add_with_memory(config, machine, move |old, fresh| *fresh = old.restarted(&spec))
        }
        Role::Master(master) => {
            let (spec, machine) = (master.clone(), MasterMachine::new(master));
            network.add_with_memory(config, machine, move |old, fresh| *fresh = old.restarted(&spec))
        }
        Role::Tool(tool) => {
            let (spec, machine) = (tool.clone(), ToolMachine::new(tool));
            network.add_with_memory(config, machine, move |old, fresh| *fresh = old.restarted(&spec))
        }
        Role::Device(device) => {
            let (spec, machine) = (device.clone(), DeviceMachine::new(device));
            network.add_with_memory(config, machine, move |old, fresh| *fresh = old.restarted(&spec))
        }
        Role::Manager(manager) => network.add(config, ManagerMachine::new(manager, node.bit_rate)),
        Role::Replay(frames) => {
            let timed = |recorded: &Recorded| (Instant::ZERO + recorded.after, recorded.frame);
            let frames: Vec<_> = frames.iter().map(timed).collect();
            network.add_silent(config, Replay::since(Instant::ZERO, frames))
        }
        Role::External if is_served => network.add_silent(config, doors::outside()),
        Role::External | Role::Listener => network.add_silent(config, Listener::new(0)),
        Role::Babbler { frame, period } => network.add_silent(config, Babbler::new(*frame, *period)),
    }
}

/// Of what happens at one moment, faults end before others begin, in whatever order the file has them.
fn plan_faults(network: &mut Network<NodeEvent>, scenario: &Scenario, ids: &[NodeId]) {
    let (mut begins, mut ends) = (Vec::new(), Vec::new());
    for (index, fault) in scenario.faults.iter().enumerate() {
        for (begin, end) in switches(scenario, ids, index, &fault.kind) {
            begins.push((fault.from, begin));
            ends.extend(fault.to.map(|to| (to, end)));
        }
    }
    for (at, change) in ends.into_iter().chain(begins) {
        network.schedule(at, change);
    }
}

/// What switches each part of a fault on, and off again.
fn switches(
    scenario: &Scenario,
    ids: &[NodeId],
    index: usize,
    kind: &FaultKind,
) -> Vec<(Change<NodeEvent>, Change<NodeEvent>)> {
    let id = |node: &NodeIndex| ids[node.0];
    let scopes = |nodes: &[NodeIndex]| match nodes {
        [] => vec![Scope::Bus],
        nodes => nodes.iter().map(|node| Scope::Node(id(node))).collect(),
    };
    let parts: Vec<Fault> = match kind {
        FaultKind::BitErrors { rate, nodes } => {
            scopes(nodes).into_iter().map(|scope| Fault::BitFlips { rate: *rate, scope }).collect()
        }
        FaultKind::BitError { frame, bit, nodes } => scopes(nodes)
            .into_iter()
            .map(|scope| Fault::FlipBit { frame: *frame, bit: *bit, scope })
            .collect(),
        FaultKind::Noise { gap, length, nodes } => {
            let burst = |scope| Fault::Bursts { gap: *gap, length: *length, scope };
            scopes(nodes).into_iter().map(burst).collect()
        }
        FaultKind::Babble { pull, every } => vec![Fault::Babble { pull: *pull, every: *every }],
        FaultKind::LostFrame { rate, id: wanted, overrun, nodes } => {
            let filter = wanted.map(|id| Filter::standard(standard_id(id as u16), 0x7FF));
            let which = if *rate >= 1.0 { Which::All } else { Which::Share(*rate) };
            let lost = |node: &NodeIndex| match overrun {
                true => Fault::Overrun { receiver: id(node), filter, which },
                false => Fault::SpoiltEnd { receiver: id(node), filter, which },
            };
            nodes.iter().map(lost).collect()
        }
        FaultKind::Clock { ppm, nodes } => {
            let own = |node: &NodeIndex| scenario.nodes[node.0].clock_ppm;
            let set = |node| (Change::SetClock(id(node), *ppm), Change::SetClock(id(node), own(node)));
            return nodes.iter().map(set).collect();
        }
        FaultKind::Segment { nodes } => {
            return vec![(Change::Split(nodes.iter().map(id).collect()), Change::Join)];
        }
    };
    let named = |(part, fault)| {
        let id = FaultId(index as u32 | (part as u32) << 16);
        (Change::FaultOn(id, fault), Change::FaultOff(id))
    };
    parts.into_iter().enumerate().map(named).collect()
}

/// The moment in a range of times, drawn for the node at that place.
fn draw(range: TimeRange, seed: u64, index: usize) -> Instant {
    let span = u64::try_from((range.max - range.min).as_nanos()).unwrap_or(u64::MAX);
    let drawn = Rng::new(seed, POWER_UP_STREAMS + index as u64).below(span.saturating_add(1));
    Instant::ZERO + range.min + Duration::from_nanos(drawn)
}

/// Duplicate MAC ID checks are what nodes of one MAC ID send with different data on purpose, and the offline connection
/// set is for all; every other identifier has one producer.
fn is_shared(id: StandardId) -> bool {
    let id = id.as_raw();
    id & 0x607 == 0x407 || (0x7EC..=0x7EF).contains(&id)
}

/// Apart from the streams of nodes and faults on the bus.
const POWER_UP_STREAMS: u64 = 1 << 40;
