//! `[[expect]]`

use link_core::Instant;

use super::NodeIndex;
use crate::scenario::values::Comparison;

/// `[[expect]]`
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Expectation {
    /// The line of the file.
    pub line: usize,
    /// Of whom; empty is every node that it [can be expected of](super::Role::can_be), and then only what [`When::Never`]
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
