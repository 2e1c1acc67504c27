//! A scenario that has been checked: every name resolved, every number in its range.

mod expect;
mod fault;

use core::time::Duration;

use link_core::{BitRate, Frame, Instant};

pub use expect::{EventName, Expectation, StateName, What, When};
pub use fault::{Fault, FaultKind};

use super::values::TimeRange;

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
            Self::Replay(_) => "replay",
            Self::Listener => "listener",
            Self::Babbler { .. } => "babbler",
            Self::External => "external",
        }
    }

    /// Whether `what` can be expected of it.
    #[must_use]
    pub const fn can_be(&self, what: &What) -> bool {
        let has_access = matches!(self, Self::Access(_));
        match what.event {
            Some(EventName::Sent) if matches!(self, Self::Listener) => false,
            Some(event) if event.is_of_access() && !has_access => false,
            Some(_) | None => has_access || what.state.is_none(),
        }
    }
}

/// A node with `role = "access"`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct AccessNode {
    /// The MAC ID switch, 0 to 63.
    pub mac: u8,
    /// Vendor ID.
    pub vendor: u16,
    /// Serial number.
    pub serial: u32,
    /// Physical port number, 0 to 127.
    pub port: u8,
    /// Bus-off interrupt: after bus-off reset the controller and begin anew.
    pub boi: bool,
    /// Quick Connect: on line with the first duplicate MAC ID check request.
    pub quick_connect: bool,
    /// It can be found and repaired through the offline connection set.
    pub offline_set: bool,
}

/// A frame that a replay node plays.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Recorded {
    /// From power-up.
    pub after: Duration,
    /// What is sent.
    pub frame: Frame,
}

/// `[[action]]`
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Action {
    /// When.
    pub at: Instant,
    /// To whom; several when the node has a `count`.
    pub nodes: Vec<NodeIndex>,
    /// What.
    pub what: Do,
}

/// What an action does.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Do {
    /// Takes the plug out of the bus; the node keeps its power.
    Cut,
    /// Puts it back.
    Plug,
    /// Switches the node off.
    PowerOff,
    /// Switches it on.
    PowerOn,
    /// Both, one after the other.
    PowerCycle,
    /// Turns the MAC ID switch.
    SetMac(u8),
    /// Turns the bit rate switch.
    SetBitRate(BitRate),
    /// Resets the device, as its Identity object's Reset service does.
    Reset,
}

impl Do {
    /// The name in the file.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Cut => "cut",
            Self::Plug => "plug",
            Self::PowerOff => "power_off",
            Self::PowerOn => "power_on",
            Self::PowerCycle => "power_cycle",
            Self::SetMac(_) => "set_mac",
            Self::SetBitRate(_) => "set_bit_rate",
            Self::Reset => "reset",
        }
    }
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
