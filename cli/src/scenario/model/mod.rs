//! A scenario that has been checked: every name resolved, every number in its range.

mod action;
mod device;
mod expect;
mod fault;
mod happening;
mod names;
mod nex;

use core::time::Duration;

use cip_core::identity::DeviceIdentity;
use link_core::{BitRate, Frame, Instant};

pub use action::{Action, Do, Output};
pub use device::{AccessNode, ConnectionName, MasterNode, ScannedSlave, Sizes, SlaveNode, Write};
pub use expect::{
    ConnectionStateName, DeviceStateName, Expectation, ModeName, SlaveStateName, StateName, What, When,
};
pub use fault::{Fault, FaultKind};
pub use happening::EventName;
pub use nex::{
    Attribute, DeviceNode, ManagerNode, NexConnection, NexNode, Pattern, Planned, PlannedIo, WatchdogName,
};

use super::values::TimeRange;
use names::names;

/// What is simulated, what happens to it, and what is expected of it.
#[derive(Clone, PartialEq, Debug)]
pub struct Scenario {
    /// The file as the user named it.
    pub file: String,
    /// `title`
    pub title: Option<String>,
    /// `[bus]`
    pub bus: Bus,
    /// `[[node]]`, in the order of the file; one with a `count` is that many nodes.
    pub nodes: Vec<Node>,
    /// `[[action]]`, in the order of the file.
    pub actions: Vec<Action>,
    /// `[[fault]]`
    pub faults: Vec<Fault>,
    /// `[[expect]]`
    pub expectations: Vec<Expectation>,
    /// `[[note]]`
    pub notes: Vec<Note>,
}

/// `[bus]`
#[derive(Clone, PartialEq, Debug)]
pub struct Bus {
    /// The rate of every node that does not say otherwise.
    pub bit_rate: BitRate,
    /// Of everything random.
    pub seed: u64,
    /// How long the scenario runs.
    pub duration: Duration,
}

/// The place of a node in [`Scenario::nodes`].
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct NodeIndex(pub usize);

/// `[[node]]`
#[derive(Clone, PartialEq, Debug)]
pub struct Node {
    /// Unique.
    pub name: String,
    /// What it does.
    pub role: Role,
    /// When it is switched on; of a range the seed draws.
    pub power_up: TimeRange,
    /// From the end of a frame to the earliest answer; of a range the seed draws each time.
    pub reaction: TimeRange,
    /// Its own switch.
    pub bit_rate: BitRate,
    /// How much its clock runs fast (or slow, when negative), in millionths.
    pub clock_ppm: i32,
}

/// What a node does.
#[derive(Clone, PartialEq, Debug)]
pub enum Role {
    /// A DeviceNet node that gets on the line and defends its MAC ID, no more.
    Access(AccessNode),
    /// A DeviceNet slave.
    Slave(Box<SlaveNode>),
    /// A DeviceNet master.
    Master(Box<MasterNode>),
    /// A tool that recovers nodes through the offline connection set.
    Tool(AccessNode),
    /// A DeviceNeX device.
    Device(Box<DeviceNode>),
    /// A DeviceNeX network manager.
    Manager(Box<ManagerNode>),
    /// Plays a recording.
    Replay(Vec<Recorded>),
    /// Receives, and never disturbs the bus: listen-only.
    Listener,
    /// Sends one frame over and over.
    Babbler {
        /// What it sends.
        frame: Frame,
        /// From the start of one to the start of the next; zero is as fast as the bus takes them.
        period: Duration,
    },
    /// Attached from outside.
    External,
}

impl Role {
    /// The name in the file.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Access(_) => "access",
            Self::Slave(_) => "slave",
            Self::Master(_) => "master",
            Self::Tool(_) => "tool",
            Self::Device(_) => "device",
            Self::Manager(_) => "manager",
            Self::Replay(_) => "replay",
            Self::Listener => "listener",
            Self::Babbler { .. } => "babbler",
            Self::External => "external",
        }
    }

    /// What every DeviceNet node has.
    #[must_use]
    pub const fn access(&self) -> Option<&AccessNode> {
        match self {
            Self::Access(access) | Self::Tool(access) => Some(access),
            Self::Slave(slave) => Some(&slave.access),
            Self::Master(master) => Some(&master.access),
            Self::Device(_)
            | Self::Manager(_)
            | Self::Replay(_)
            | Self::Listener
            | Self::Babbler { .. }
            | Self::External => None,
        }
    }

    /// What every DeviceNeX node has.
    #[must_use]
    pub const fn nex(&self) -> Option<&NexNode> {
        match self {
            Self::Device(device) => Some(&device.node),
            Self::Manager(manager) => Some(&manager.node),
            Self::Access(_)
            | Self::Slave(_)
            | Self::Master(_)
            | Self::Tool(_)
            | Self::Replay(_)
            | Self::Listener
            | Self::Babbler { .. }
            | Self::External => None,
        }
    }

    /// Who it is, if it is anybody.
    pub(super) const fn identity_mut(&mut self) -> Option<&mut DeviceIdentity> {
        match self {
            Self::Access(access) | Self::Tool(access) => Some(&mut access.device),
            Self::Slave(slave) => Some(&mut slave.access.device),
            Self::Master(master) => Some(&mut master.access.device),
            Self::Device(device) => Some(&mut device.node.device),
            Self::Manager(manager) => Some(&mut manager.node.device),
            Self::Replay(_) | Self::Listener | Self::Babbler { .. } | Self::External => None,
        }
    }

    /// The protocol that it speaks, if any.
    #[must_use]
    pub const fn protocol(&self) -> Option<Protocol> {
        if self.access().is_some() {
            return Some(Protocol::DeviceNet);
        }
        if self.nex().is_some() { Some(Protocol::DeviceNex) } else { None }
    }

    /// Whether it is one of these.
    #[must_use]
    pub fn is(&self, kind: Kind) -> bool {
        kind.roles().contains(&self.name())
    }
}

names! {
    /// What the nodes of a bus speak.
    Protocol {
        /// 11-bit identifiers, MAC IDs.
        DeviceNet = "devicenet",
        /// 29-bit identifiers, operational addresses.
        DeviceNex = "devicenex",
    }
}

/// Nodes that can be or do the same things.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Kind {
    /// All.
    Any,
    /// Those that can send.
    Sender,
    /// Those that perform network access.
    Access,
    /// Those on DeviceNet.
    DeviceNet,
    /// Those on DeviceNeX.
    DeviceNex,
    /// `role = "slave"`
    Slave,
    /// `role = "master"`
    Master,
    /// `role = "tool"`
    Tool,
    /// `role = "device"`
    Device,
    /// `role = "manager"`
    Manager,
    /// Those that exchange I/O when they are told to: slaves and devices.
    Server,
    /// Those that watch connections: slaves, devices, managers.
    Watcher,
    /// Those that watch others: masters and managers.
    Supervisor,
    /// Those that look for others: tools and managers.
    Searcher,
}

impl Kind {
    /// The roles that are meant, as a file names them.
    #[must_use]
    pub const fn roles(self) -> &'static [&'static str] {
        match self {
            Self::Any => &[
                "access", "slave", "master", "tool", "device", "manager", "replay", "listener", "babbler",
                "external",
            ],
            Self::Sender => {
                &["access", "slave", "master", "tool", "device", "manager", "replay", "babbler", "external"]
            }
            Self::Access => &["access", "slave", "master", "tool", "device", "manager"],
            Self::DeviceNet => &["access", "slave", "master", "tool"],
            Self::DeviceNex => &["device", "manager"],
            Self::Slave => &["slave"],
            Self::Master => &["master"],
            Self::Tool => &["tool"],
            Self::Device => &["device"],
            Self::Manager => &["manager"],
            Self::Server => &["slave", "device"],
            Self::Watcher => &["slave", "device", "manager"],
            Self::Supervisor => &["master", "manager"],
            Self::Searcher => &["tool", "manager"],
        }
    }
}

/// A frame that a replay node plays.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Recorded {
    /// From power-up.
    pub after: Duration,
    /// What is sent.
    pub frame: Frame,
}

/// `[[note]]`: a heading in the trace.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Note {
    /// When.
    pub at: Instant,
    /// What it says.
    pub text: String,
}

impl Scenario {
    /// What the nodes speak; DeviceNet if none of them says.
    #[must_use]
    pub fn protocol(&self) -> Protocol {
        self.nodes.iter().find_map(|node| node.role.protocol()).unwrap_or(Protocol::DeviceNet)
    }

    /// `left, right and 2 more`
    #[must_use]
    pub fn names(&self, nodes: &[NodeIndex]) -> String {
        let named: Vec<&str> = nodes
            .iter()
            .take(MOST_NAMES)
            .filter_map(|node| Some(self.nodes.get(node.0)?.name.as_str()))
            .collect();
        match nodes.len().saturating_sub(MOST_NAMES) {
            0 => named.join(", "),
            more => format!("{} and {more} more", named.join(", ")),
        }
    }
}

const MOST_NAMES: usize = 4;
