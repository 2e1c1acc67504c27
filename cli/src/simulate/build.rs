//! From a scenario to machines on a bus.

use core::time::Duration;

use devicenet_core::MacId;
use devicenet_core::access::{Access, Config};
use devicenet_core::message::{DeviceIdentity, PortNumber};
use link_core::{Filter, Instant, StandardId, frame::standard_id};
use transport_mock::bus::Fault;
use transport_mock::nodes::{Babbler, External, Listener, Replay};
use transport_mock::rng::Rng;
use transport_mock::{BusConfig, Change, FaultId, Network, NodeConfig, NodeId, Reaction, Scope, Which};

use super::event::NodeEvent;
use crate::scenario::{AccessNode, Do, FaultKind, Node, NodeIndex, Recorded, Role, Scenario, TimeRange};

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
    let config = BusConfig { shared: Some(is_shared), ..BusConfig::new(scenario.bus.bit_rate, seed) };
    let mut network = Network::new(config);
    let mut ids = Vec::new();
    for (index, node) in scenario.nodes.iter().enumerate() {
        ids.push(add(&mut network, node, seed, index, is_served));
    }
    for (index, fault) in scenario.faults.iter().enumerate() {
        plan_fault(&mut network, scenario, &ids, index, &fault.kind, fault.from, fault.to);
    }
    plan_actions(&mut network, scenario, &ids);
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
        listen_only: matches!(node.role, Role::Listener),
        reaction: match node.reaction {
            TimeRange { max: Duration::ZERO, .. } => Reaction::Immediate,
            TimeRange { min, max } if min == max => Reaction::Fixed(min),
            TimeRange { min, max } => Reaction::Uniform(min, max),
        },
        clock_ppm: node.clock_ppm,
        ..NodeConfig::named(node.name.as_str())
    };
    match &node.role {
        Role::Access(access) => {
            // The MAC ID survives without power.
            network.add_with_memory(config, Access::new(access_config(access)), |old, fresh| {
                *fresh = Access::new(Config { mac_id: old.mac_id(), ..old.config().clone() });
            })
        }
        Role::Replay(frames) => {
            let timed = |recorded: &Recorded| (Instant::ZERO + recorded.after, recorded.frame);
            let frames: Vec<_> = frames.iter().map(timed).collect();
            network.add_silent(config, Replay::new(frames))
        }
        Role::External if is_served => network.add_silent(config, External::default()),
        Role::External | Role::Listener => network.add_silent(config, Listener::new(0)),
        Role::Babbler { frame, period } => network.add_silent(config, Babbler::new(*frame, *period)),
    }
}

fn access_config(access: &AccessNode) -> Config {
    let device = DeviceIdentity { vendor: access.vendor.into(), serial: access.serial };
    // Both were checked with the scenario.
    let port = PortNumber::new(access.port).unwrap_or(PortNumber::ZERO);
    let mac = MacId::new(access.mac).unwrap_or(MacId::DEFAULT);
    Config {
        bus_off_interrupt: access.boi,
        quick_connect: access.quick_connect,
        offline_set: access.offline_set,
        ..Config::new(device, port, mac)
    }
}

fn plan_fault(
    network: &mut Network<NodeEvent>,
    scenario: &Scenario,
    ids: &[NodeId],
    index: usize,
    kind: &FaultKind,
    from: Instant,
    to: Option<Instant>,
) {
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
            for node in nodes {
                network.schedule(from, Change::SetClock(id(node), *ppm));
                if let Some(to) = to {
                    network.schedule(to, Change::SetClock(id(node), scenario.nodes[node.0].clock_ppm));
                }
            }
            return;
        }
        FaultKind::Segment { nodes } => {
            network.schedule(from, Change::Split(nodes.iter().map(id).collect()));
            if let Some(to) = to {
                network.schedule(to, Change::Join);
            }
            return;
        }
    };
    for (part, fault) in parts.into_iter().enumerate() {
        let id = FaultId(index as u32 | (part as u32) << 16);
        network.schedule(from, Change::FaultOn(id, fault));
        if let Some(to) = to {
            network.schedule(to, Change::FaultOff(id));
        }
    }
}

fn plan_actions(network: &mut Network<NodeEvent>, scenario: &Scenario, ids: &[NodeId]) {
    for action in &scenario.actions {
        for node in &action.nodes {
            let id = ids[node.0];
            let change = match action.what {
                Do::Cut => Change::Cut(id),
                Do::Plug => Change::Plug(id),
                Do::PowerOff => Change::PowerOff(id),
                Do::PowerOn => Change::PowerOn(id),
                Do::PowerCycle => Change::PowerCycle(id),
                Do::SetBitRate(rate) => Change::SetBitRate(id, rate),
                Do::SetMac(mac) => {
                    let mac = MacId::new(mac).unwrap_or(MacId::DEFAULT);
                    command(id, move |access, now| {
                        // The machine has its MAC ID from software, so that it cannot refuse.
                        let _ = access.set_mac_id(now, mac);
                    })
                }
                Do::Reset => command(id, Access::reset),
            };
            network.schedule(action.at, change);
        }
    }
}

fn command(id: NodeId, act: impl FnOnce(&mut Access, Instant) + 'static) -> Change<NodeEvent> {
    Change::Call(Box::new(move |network| {
        network.command(id, act);
    }))
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
