//! `[[expect]]`

use link_core::Instant;

use super::device::ConnectionName;
use super::names::names;
use super::nex::NexConnection;
use super::{Kind, NodeIndex, Role};
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
        /// It was given a MAC ID over the network.
        MacIdAssigned = "mac_id_assigned",
        /// A device was given an operational address.
        AddressAssigned = "address_assigned",
        /// Another node has its operational address, which it gives up.
        AddressTaken = "address_taken",
        /// It heard its own address and identity.
        OwnIdentity = "own_identity",
        /// A ROAM for the device was not obeyed.
        RoamRefused = "roam_refused",
        /// Slave: a master has allocated connections.
        Allocated = "allocated",
        /// Slave: nothing is allocated any longer.
        Released = "released",
        /// Slave, device: a connection changed its state.
        ConnectionChanged = "connection_changed",
        /// Slave, device: a connection timed out. Manager: that of a planned device did.
        TimedOut = "timed_out",
        /// Slave: what its outputs mean has changed.
        ModeChanged = "mode_changed",
        /// Slave: its outputs have changed.
        OutputChanged = "output_changed",
        /// Slave: it was reset over the network.
        Reset = "reset",
        /// Slave: it found the bit rate in use.
        BitRateDetected = "bit_rate_detected",
        /// Slave: a frame for it was not obeyed.
        Ignored = "ignored",
        /// Master: it is elsewhere with a slave.
        SlaveChanged = "slave_changed",
        /// Master: the I/O of a slave runs.
        Established = "established",
        /// Master: a slave that ran is lost. Manager: a planned device is.
        Lost = "lost",
        /// Master: the scanner status of a slave has changed.
        StatusChanged = "status_changed",
        /// Master: other input data of a slave.
        InputChanged = "input_changed",
        /// Master: a scan is over.
        ScanDone = "scan_done",
        /// Master: a scan is over, and responses are missing.
        ResponseMissing = "response_missing",
        /// Master: a heartbeat of a slave.
        Heartbeat = "heartbeat",
        /// Master: a slave says that it goes off line.
        Shutdown = "shutdown",
        /// Master: a new device was given the MAC ID of a slave. Manager: another device has the address of a lost one.
        Replaced = "replaced",
        /// Master: a new device was not given the MAC ID of a slave.
        NotReplaced = "not_replaced",
        /// Device: it refused a connection; manager: a device did.
        Refused = "refused",
        /// Manager: a planned device has another state.
        DeviceChanged = "device_changed",
        /// Manager: a device that is planned nowhere.
        Unknown = "unknown",
        /// Manager: a device was added to the database.
        Learned = "learned",
        /// Manager: a device is on line with its planned address.
        Addressed = "addressed",
        /// Manager: a device does not take its address.
        NotAddressed = "not_addressed",
        /// Manager: a connection of a planned device is established.
        Connected = "connected",
        /// Manager: a device stands by that may stand in for one that is there.
        Spare = "spare",
        /// Manager: nobody can stand in for a device that is lost.
        NoSpare = "no_spare",
        /// Manager: somebody has the address of a planned device for whom it is not planned.
        Conflict = "conflict",
        /// Manager: there is another manager on the bus.
        SecondManager = "second_manager",
        /// Manager: an attribute of a planned device was read.
        Read = "read",
        /// Tool: the offline connection set is its own.
        Owner = "owner",
        /// Tool: a faulted node answered. Manager: a planned device was heard.
        Found = "found",
        /// Tool: all faulted nodes had the time to answer.
        WhoDone = "who_done",
        /// Tool: a device is on line with its new MAC ID.
        Recovered = "recovered",
        /// Tool: a device did not get its new MAC ID.
        NotRecovered = "not_recovered",
    }
}

impl EventName {
    /// Who tells it.
    #[must_use]
    pub const fn kind(self) -> Kind {
        match self {
            Self::Sent => Kind::Sender,
            Self::ErrorWarning | Self::ErrorPassive | Self::ErrorActive | Self::BusOff => Kind::Any,
            Self::StateChanged | Self::Defended | Self::NotAcknowledged => Kind::Access,
            Self::DuplicateMacId | Self::MacIdAssigned => Kind::DeviceNet,
            Self::OwnIdentity | Self::AddressTaken | Self::Refused => Kind::DeviceNex,
            Self::AddressAssigned | Self::RoamRefused => Kind::Device,
            Self::Allocated | Self::Released => Kind::Slave,
            Self::ConnectionChanged
            | Self::ModeChanged
            | Self::OutputChanged
            | Self::Reset
            | Self::BitRateDetected
            | Self::Ignored => Kind::Server,
            Self::TimedOut => Kind::Watcher,
            Self::SlaveChanged
            | Self::Established
            | Self::StatusChanged
            | Self::InputChanged
            | Self::ScanDone
            | Self::ResponseMissing
            | Self::Heartbeat
            | Self::Shutdown
            | Self::NotReplaced => Kind::Master,
            Self::Lost | Self::Replaced => Kind::Supervisor,
            Self::Found => Kind::Searcher,
            Self::Owner | Self::WhoDone | Self::Recovered | Self::NotRecovered => Kind::Tool,
            Self::DeviceChanged
            | Self::Unknown
            | Self::Learned
            | Self::Addressed
            | Self::NotAddressed
            | Self::Connected
            | Self::NoSpare
            | Self::Spare
            | Self::Conflict
            | Self::SecondManager
            | Self::Read => Kind::Manager,
        }
    }

    /// Whether it is about one slave of a master.
    #[must_use]
    pub const fn has_slave(self) -> bool {
        matches!(
            self,
            Self::SlaveChanged
                | Self::Established
                | Self::StatusChanged
                | Self::InputChanged
                | Self::Heartbeat
                | Self::Shutdown
                | Self::Lost
                | Self::Replaced
        )
    }

    /// Whether it is about one planned device of a manager.
    #[must_use]
    pub const fn has_device(self) -> bool {
        matches!(
            self,
            Self::DeviceChanged
                | Self::Learned
                | Self::Found
                | Self::Addressed
                | Self::NotAddressed
                | Self::Connected
                | Self::Refused
                | Self::TimedOut
                | Self::Lost
                | Self::Replaced
                | Self::NoSpare
                | Self::Conflict
                | Self::Read
        )
    }

    /// Whether it is about one connection.
    #[must_use]
    pub const fn has_connection(self) -> bool {
        matches!(
            self,
            Self::ConnectionChanged
                | Self::TimedOut
                | Self::ModeChanged
                | Self::OutputChanged
                | Self::InputChanged
                | Self::Connected
        )
    }
}
