//! `[[expect]]`

use link_core::Instant;

use super::device::ConnectionName;
use super::names::names;
use super::nex::NexConnection;
use super::{EventName, Kind, NodeIndex, Role};
use crate::scenario::values::Comparison;

/// `[[expect]]`
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Expectation {
    /// The line of the file.
    pub line: usize,
    /// Of whom; empty is every node that it [can be expected of](What::fits), and then only what [`When::Never`] says.
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
    /// The operational address that it has, wants, or had; 127 is none.
    pub oa: Option<u8>,
    /// The transmit error counter.
    pub tec: Option<Comparison>,
    /// The receive error counter.
    pub rec: Option<Comparison>,
    /// Whether the controller is bus-off.
    pub bus_off: Option<bool>,
    /// Which connection is meant; without it the first that there is.
    pub connection: Option<ConnectionName>,
    /// The same of a DeviceNeX device.
    pub nex_connection: Option<NexConnection>,
    /// The state of that connection in a slave.
    pub connection_state: Option<ConnectionStateName>,
    /// What the data mean that this connection of a slave consumes.
    pub mode: Option<ModeName>,
    /// What a slave produces, or what a master has from `slave`.
    pub input: Option<Vec<u8>>,
    /// What a slave has consumed.
    pub output: Option<Vec<u8>>,
    /// The slave that a master is asked about, by its MAC ID.
    pub slave: Option<u8>,
    /// Where a master is with `slave`.
    pub slave_state: Option<SlaveStateName>,
    /// The scanner status of `slave`, or of the scanner itself.
    pub status: Option<Comparison>,
    /// The planned device that a manager is asked about, by its operational address.
    pub device: Option<u8>,
    /// What the manager knows of `device`.
    pub device_state: Option<DeviceStateName>,
    /// Something that happens in this moment.
    pub event: Option<EventName>,
}

impl What {
    /// The keys that are given, each with the nodes that it can be expected of.
    pub fn keys(&self) -> impl Iterator<Item = (&'static str, Kind)> {
        let input = if self.slave.is_some() { Kind::Master } else { Kind::Server };
        [
            ("state", self.state.is_some(), self.state.map_or(Kind::Any, StateName::kind)),
            ("oa", self.oa.is_some(), Kind::DeviceNex),
            ("tec", self.tec.is_some(), Kind::Any),
            ("rec", self.rec.is_some(), Kind::Any),
            ("bus_off", self.bus_off.is_some(), Kind::Any),
            ("connection_state", self.connection_state.is_some(), Kind::Server),
            ("mode", self.mode.is_some(), Kind::Server),
            ("input", self.input.is_some(), input),
            ("output", self.output.is_some(), Kind::Server),
            ("slave", self.slave.is_some(), Kind::Master),
            ("slave_state", self.slave_state.is_some(), Kind::Master),
            ("status", self.status.is_some(), Kind::Master),
            ("device", self.device.is_some(), Kind::Manager),
            ("device_state", self.device_state.is_some(), Kind::Manager),
            ("event", self.event.is_some(), self.event.map_or(Kind::Any, EventName::kind)),
        ]
        .into_iter()
        .filter(|(_, given, _)| *given)
        .map(|(key, _, kind)| (key, kind))
    }

    /// Whether it can be expected of a node with this role.
    #[must_use]
    pub fn fits(&self, role: &Role) -> bool {
        self.keys().all(|(_, kind)| role.is(kind))
    }
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
        /// DeviceNeX: it listens for the bit rate in use.
        DetectingBitRate = "detecting_bit_rate",
        /// DeviceNeX: the first Hello is to be sent, or was.
        Hello1 = "hello_1",
        /// DeviceNeX: the second Hello is to be sent, or was.
        Hello2 = "hello_2",
        /// DeviceNeX: without an address, waiting for one.
        Standby = "standby",
        /// DeviceNeX: off the bus.
        BusOff = "bus_off",
        /// DeviceNeX: its controller does not do what it must.
        Faulted = "faulted",
    }
}

impl StateName {
    /// Who can be in it.
    #[must_use]
    pub const fn kind(self) -> Kind {
        match self {
            Self::Nonexistent | Self::OnLine => Kind::Access,
            Self::SendingDupMac | Self::WaitingDupMac | Self::CommFault => Kind::DeviceNet,
            Self::DetectingBitRate
            | Self::Hello1
            | Self::Hello2
            | Self::Standby
            | Self::BusOff
            | Self::Faulted => Kind::DeviceNex,
        }
    }
}

names! {
    /// The states of a connection in a slave.
    ConnectionStateName {
        /// Neither allocated nor opened.
        NonExistent = "non_existent",
        /// Allocated; its expected packet rate is still to be set.
        Configuring = "configuring",
        /// Data flow.
        Established = "established",
        /// No message came in time.
        TimedOut = "timed_out",
        /// Explicit: it timed out, and waits for the end of the I/O connections.
        DeferredDelete = "deferred_delete",
    }
}

names! {
    /// What the data mean that a slave consumes.
    ModeName {
        /// Nothing was consumed since the connection was allocated.
        Inactive = "inactive",
        /// The master runs.
        Run = "run",
        /// The master is there but does not run.
        Idle = "idle",
        /// The master is lost.
        Fault = "fault",
    }
}

names! {
    /// Where a master is with a slave.
    SlaveStateName {
        /// The master is not on line.
        Offline = "offline",
        /// Until the next attempt.
        Waiting = "waiting",
        /// Its explicit connection is being allocated or opened.
        Contacting = "contacting",
        /// Its identity is checked, its connections are set up.
        Configuring = "configuring",
        /// Its I/O runs.
        Running = "running",
    }
}

names! {
    /// What a manager knows of a planned device.
    DeviceStateName {
        /// The manager is not on line, or leaves the work to another one.
        Idle = "idle",
        /// Whoever has its address is asked who it is.
        Probing = "probing",
        /// Nobody has its address; spares are left alone.
        Missing = "missing",
        /// It was heard without an address.
        Found = "found",
        /// It was sent its address.
        Assigned = "assigned",
        /// It says Hello with its address.
        Joining = "joining",
        /// It is on line, and its connections are being made.
        Connecting = "connecting",
        /// Its connections are as planned, and watched.
        Running = "running",
        /// It fell silent, and is asked again.
        Retrying = "retrying",
        /// It is gone: spares may take over.
        Lost = "lost",
        /// Somebody has its address for whom it is not planned.
        Conflict = "conflict",
    }
}
