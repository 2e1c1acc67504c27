//! The nodes that perform network access.

use core::time::Duration;

use cip_core::code::{AttributeId, ClassId, InstanceId};
use cip_core::identity::DeviceIdentity;
use cip_core::message::AllocationChoice;
use devicenet_core::master::{FirstContact, ReplacementMode, ScanEntry};
use devicenet_core::message;

use super::names::names;

/// What every node that performs network access has, and all that one with `role = "access"` has.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct AccessNode {
    /// The MAC ID switch, 0 to 63.
    pub mac: u8,
    /// Who it is.
    pub device: DeviceIdentity,
    /// Physical port number, 0 to 127.
    pub port: u8,
    /// Bus-off interrupt: after bus-off reset the controller and begin anew.
    pub boi: bool,
    /// Quick Connect: on line with the first duplicate MAC ID check request.
    pub quick_connect: bool,
    /// It can be found and repaired through the offline connection set.
    pub offline_set: bool,
    /// Its MAC ID cannot be set over the network.
    pub switches: bool,
}

impl AccessNode {
    /// What the duplicate MAC ID check and the offline connection set show of it.
    #[must_use]
    pub const fn on_the_wire(&self) -> message::DeviceIdentity {
        message::DeviceIdentity { vendor: self.device.vendor, serial: self.device.serial }
    }
}

/// A node with `role = "slave"`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct SlaveNode {
    /// Its network access.
    pub access: AccessNode,
    /// The I/O connections that a master can allocate.
    pub offers: AllocationChoice,
    /// Instance 2.
    pub poll: Sizes,
    /// Instance 3; it consumes one bit.
    pub bit_strobe: Sizes,
    /// Instance 4; what it consumes comes over instance 2.
    pub change_of_state: Sizes,
    /// Instance 5.
    pub multicast_poll: Sizes,
    /// The input data, of which each connection sends the first bytes.
    pub input: Vec<u8>,
    /// It has the UCMM.
    pub ucmm: bool,
    /// It has the unconnected port of Group 2.
    pub unconnected_port: bool,
    /// The heartbeat interval in seconds, 0 for none; `None` if it has no heartbeat.
    pub heartbeat: Option<u8>,
    /// It says so when it leaves the network on purpose.
    pub shutdown_message: bool,
    /// It listens for the bit rate in use before anything else.
    pub detects_bit_rate: bool,
}

/// Bytes, seen from the slave.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Sizes {
    /// From the slave.
    pub produce: u16,
    /// To the slave.
    pub consume: u16,
}

/// A node with `role = "master"`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct MasterNode {
    /// Its network access.
    pub access: AccessNode,
    /// It starts in run mode.
    pub run: bool,
    /// From the end of one poll scan to the start of the next.
    pub interscan_delay: Duration,
    /// How long a scan waits for responses.
    pub response_wait: Duration,
    /// Slaves in the background are polled once in so many scans.
    pub background_ratio: u16,
    /// How a slave is first addressed.
    pub first_contact: FirstContact,
    /// The first pause after an attempt that failed.
    pub retry_after: Duration,
    /// The longest pause.
    pub retry_at_most: Duration,
    /// Automatic device replacement.
    pub replacement: ReplacementMode,
    /// How often MAC ID 63 is looked at.
    pub replacement_retry: Duration,
    /// What the multicast poll sends at first.
    pub multicast_output: Vec<u8>,
    /// The scan list.
    pub scan: Vec<ScannedSlave>,
}

impl MasterNode {
    /// The entry of the slave with this MAC ID.
    #[must_use]
    pub fn scanned(&self, mac: u8) -> Option<&ScannedSlave> {
        self.scan.iter().find(|slave| slave.entry.mac_id.number() == mac)
    }
}

/// `[[node.scan]]`
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ScannedSlave {
    /// As the master takes it.
    pub entry: ScanEntry,
    /// What the master sends at first.
    pub output: Vec<u8>,
    /// The bit in the bit-strobe command at first.
    pub strobe_bit: bool,
    /// What is written before the I/O starts.
    pub writes: Vec<Write>,
}

/// A line of a slave's configuration.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Write {
    /// The class.
    pub class: ClassId,
    /// The instance.
    pub instance: InstanceId,
    /// The attribute.
    pub attribute: AttributeId,
    /// The value.
    pub value: Vec<u8>,
}

names! {
    /// The connections of the predefined set.
    ConnectionName {
        /// Instance 1, or one that a client has opened.
        Explicit = "explicit",
        /// Instance 2.
        Poll = "poll",
        /// Instance 3.
        BitStrobe = "bit_strobe",
        /// Instance 4, by change of state.
        ChangeOfState = "cos",
        /// Instance 4, cyclic.
        Cyclic = "cyclic",
        /// Instance 5.
        MulticastPoll = "multicast_poll",
    }
}

impl ConnectionName {
    /// The instance of the Connection object.
    #[must_use]
    pub const fn instance(self) -> u8 {
        match self {
            Self::Explicit => 1,
            Self::Poll => 2,
            Self::BitStrobe => 3,
            Self::ChangeOfState | Self::Cyclic => 4,
            Self::MulticastPoll => 5,
        }
    }

    /// Its bit in the allocation choice.
    #[must_use]
    pub const fn choice(self) -> AllocationChoice {
        match self {
            Self::Explicit => AllocationChoice::EXPLICIT,
            Self::Poll => AllocationChoice::POLL,
            Self::BitStrobe => AllocationChoice::BIT_STROBE,
            Self::ChangeOfState => AllocationChoice::CHANGE_OF_STATE,
            Self::Cyclic => AllocationChoice::CYCLIC,
            Self::MulticastPoll => AllocationChoice::MULTICAST_POLL,
        }
    }
}
