//! A scenario that has been checked: every name resolved, every number in its range.

use core::time::Duration;

use link_core::{BitRate, Frame, Instant};

use super::values::{Comparison, TimeRange};

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

/// `[[fault]]`
#[derive(Clone, PartialEq, Debug)]
pub struct Fault {
    /// From when.
    pub from: Instant,
    /// Until when; `None` is the end of the run.
    pub to: Option<Instant>,
    /// What is wrong.
    pub kind: FaultKind,
}

/// What a fault does.
#[derive(Clone, PartialEq, Debug)]
pub enum FaultKind {
    /// Bits are flipped, each with probability `rate`.
    BitErrors {
        /// Per bit.
        rate: f64,
        /// Only what these hear; empty: the bus.
        nodes: Vec<NodeIndex>,
    },
    /// One bit of one frame is flipped.
    BitError {
        /// Which attempt to send: 0 is the first that begins after `from`.
        frame: u64,
        /// Which bit, 0 is the start of frame, stuff bits count.
        bit: u32,
        /// Only what these hear; empty: the bus.
        nodes: Vec<NodeIndex>,
    },
    /// Frames do not arrive at these nodes though they arrive at all others.
    LostFrame {
        /// The probability per frame.
        rate: f64,
        /// Only this identifier.
        id: Option<u32>,
        /// They are lost after they were acknowledged; else these nodes see the last bit but one of the frame wrong.
        overrun: bool,
        /// Who misses them.
        nodes: Vec<NodeIndex>,
    },
    /// Bursts in which each bit is flipped with probability one half.
    Noise {
        /// Mean time from the end of one burst to the begin of the next.
        gap: Duration,
        /// Length of a burst.
        length: Duration,
        /// Only what these hear; empty: the bus.
        nodes: Vec<NodeIndex>,
    },
    /// A transceiver pulls the bus dominant.
    Babble {
        /// How long.
        pull: Duration,
        /// From the begin of one pull to that of the next; `pull` is a bus that is dominant for good.
        every: Duration,
    },
    /// The clocks of these nodes are off.
    Clock {
        /// Millionths.
        ppm: i32,
        /// Whose.
        nodes: Vec<NodeIndex>,
    },
    /// These nodes are a segment of their own, apart from all others.
    Segment {
        /// Who.
        nodes: Vec<NodeIndex>,
    },
}

impl FaultKind {
    /// What is wrong, in words.
    #[must_use]
    pub fn words(&self, scenario: &Scenario) -> String {
        let heard = |nodes: &[NodeIndex]| match nodes {
            [] => "on the bus".to_owned(),
            nodes => format!("in what {} hears", scenario.names(nodes)),
        };
        match self {
            Self::BitErrors { rate, nodes } => format!("bit errors {}, {rate} per bit", heard(nodes)),
            Self::BitError { frame, bit, nodes } => {
                format!("an error {} in bit {bit} of frame {frame} from now", heard(nodes))
            }
            Self::LostFrame { overrun: true, nodes, .. } => {
                format!("{} is too slow to read its frames", scenario.names(nodes))
            }
            Self::LostFrame { nodes, .. } => {
                format!("the end of frames is wrong {}", heard(nodes))
            }
            Self::Noise { nodes, .. } => format!("noise {}", heard(nodes)),
            Self::Babble { .. } => "a transceiver holds the bus dominant".to_owned(),
            Self::Clock { ppm, nodes } => {
                format!("the clock of {} is off by {ppm} ppm", scenario.names(nodes))
            }
            Self::Segment { nodes } => format!("{} apart", scenario.names(nodes)),
        }
    }
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

/// `[[expect]]`
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Expectation {
    /// The line of the file.
    pub line: usize,
    /// Of whom; empty is every node that it [can be expected of](Role::can_be), and then only what [`When::Never`]
    /// says.
    pub nodes: Vec<NodeIndex>,
    /// When.
    pub when: When,
    /// What; all of it at the same moment. That of an event is when everything that happens at its time has happened.
    pub what: What,
}

/// When something is expected. A second moment that is `None` is the end of the run, whenever that comes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum When {
    /// At some moment from the first to the second, both included.
    Within(Instant, Option<Instant>),
    /// At this moment, after everything that happens at it.
    At(Instant),
    /// At no moment from the first to the second.
    Never(Instant, Option<Instant>),
    /// At every moment from the first to the second.
    Always(Instant, Option<Instant>),
}

/// What is expected: all that is given.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct What {
    /// The state of network access.
    pub state: Option<StateName>,
    /// The transmit error counter.
    pub tec: Option<Comparison>,
    /// The receive error counter.
    pub rec: Option<Comparison>,
    /// Whether the controller is bus-off.
    pub bus_off: Option<bool>,
    /// Something that happens in this moment.
    pub event: Option<EventName>,
}

/// Declares a closed set of names that a file may use.
macro_rules! names {
    ($(#[$doc:meta])* $name:ident { $($(#[$item_doc:meta])* $item:ident = $text:literal),* $(,)? }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
        pub enum $name { $($(#[$item_doc])* $item),* }

        impl $name {
            /// All of them.
            pub const ALL: &'static [Self] = &[$(Self::$item),*];

            /// The name in the file.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Self::$item => $text),* }
            }
        }

        impl core::fmt::Display for $name {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                f.write_str(self.name())
            }
        }
    };
}

names! {
    /// The states of network access.
    StateName {
        /// No power.
        Nonexistent = "nonexistent",
        /// A duplicate MAC ID check request waits for being sent.
        SendingDupMac = "sending_dup_mac",
        /// A request was sent, the second runs.
        WaitingDupMac = "waiting_dup_mac",
        /// On line.
        OnLine = "online",
        /// Off line, because of a duplicate MAC ID or bus-off.
        CommFault = "comm_fault",
    }
}

names! {
    /// What can happen to a node.
    EventName {
        /// It was on the bus with a frame, acknowledged.
        Sent = "sent",
        /// An error counter reached 96.
        ErrorWarning = "error_warning",
        /// An error counter exceeds 127.
        ErrorPassive = "error_passive",
        /// Both error counters are below 128 again.
        ErrorActive = "error_active",
        /// TEC exceeds 255.
        BusOff = "bus_off",
        /// Network access changed its state.
        StateChanged = "state_changed",
        /// The node answered a duplicate MAC ID check request.
        Defended = "defended",
        /// Its MAC ID is taken.
        DuplicateMacId = "duplicate_mac_id",
        /// Nobody acknowledges its duplicate MAC ID check request.
        NotAcknowledged = "not_acknowledged",
        /// A tool gave it a MAC ID.
        MacIdAssigned = "mac_id_assigned",
    }
}

impl EventName {
    /// Whether only network access tells it.
    #[must_use]
    pub const fn is_of_access(self) -> bool {
        match self {
            Self::Sent | Self::ErrorWarning | Self::ErrorPassive | Self::ErrorActive | Self::BusOff => false,
            Self::StateChanged
            | Self::Defended
            | Self::DuplicateMacId
            | Self::NotAcknowledged
            | Self::MacIdAssigned => true,
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
