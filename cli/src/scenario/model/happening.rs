//! What can happen to a node, and to whom.

use super::Kind;
use super::names::names;

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
        /// Manager: a connection that a planned device has already is not as planned.
        Differs = "differs",
        /// Manager: a device stands by that may stand in for one that is there.
        Spare = "spare",
        /// Manager: nobody can stand in for a device that is lost.
        NoSpare = "no_spare",
        /// Manager: somebody has the address of a planned device for whom it is not planned.
        Conflict = "conflict",
        /// Manager: there is another manager on the bus.
        SecondManager = "second_manager",
        /// Manager: another node has its address, and it says Hello with its own once more, or with another.
        Rejoins = "rejoins",
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
            | Self::Differs
            | Self::NoSpare
            | Self::Spare
            | Self::Conflict
            | Self::SecondManager
            | Self::Rejoins
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
                | Self::Differs
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
                | Self::Differs
        )
    }
}
