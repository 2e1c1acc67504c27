//! The nodes that speak DeviceNeX.

use cip_core::code::{AttributeId, ClassId, InstanceId};
use cip_core::connection::WatchdogAction;
use cip_core::identity::DeviceIdentity;
use devicenex_core::OperationalAddress;
use devicenex_core::message::{self, IdentifierLength, Predefined, Production};

use super::names::names;

/// What every DeviceNeX node has.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct NexNode {
    /// The operational address that it begins with.
    pub oa: OperationalAddress,
    /// Who it is.
    pub device: DeviceIdentity,
    /// Physical port number, 0 to 127.
    pub port: u8,
    /// Bus-off interrupt: after bus-off reset the controller and begin anew.
    pub boi: bool,
    /// How long others have to object after each Hello, in ms.
    pub hello_wait: u16,
    /// How often it tells its address when it is on line, in ms; 0: never.
    pub announcement: u32,
}

impl NexNode {
    /// What a Hello shows of it.
    #[must_use]
    pub const fn on_the_wire(&self) -> message::DeviceIdentity {
        message::DeviceIdentity {
            vendor: self.device.vendor,
            product_code: self.device.product_code,
            major_revision: self.device.revision.major,
            serial: self.device.serial,
        }
    }
}

/// A node with `role = "device"`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct DeviceNode {
    /// Its place on the network.
    pub node: NexNode,
    /// What it produces at first, on every connection that produces.
    pub input: Vec<u8>,
    /// The bytes that it consumes, on every connection that consumes.
    pub consume: u16,
}

/// A node with `role = "manager"`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ManagerNode {
    /// Its place on the network.
    pub node: NexNode,
    /// How often it asks who has no address while a device is missing, in ms.
    pub mini_who: u32,
    /// The same while none is missing, in ms; 0: never.
    pub idle_mini_who: u32,
    /// How often a device is sent its address before that is reported as failed.
    pub roam_tries: u8,
    /// How often a request is sent before a device counts as lost.
    pub connect_tries: u8,
    /// How long spares are left alone while the device itself was never seen, in ms.
    pub spare_wait: u32,
    /// Devices that match nothing are added to the database.
    pub learning: bool,
    /// For how long another manager must be silent before this one works again, in ms; 0: for ever.
    pub takeover_after: u32,
    /// How long it is without an address that another node has, in ms; 0: for ever.
    pub rejoin_after: u32,
    /// The database.
    pub planned: Vec<Planned>,
}

/// `[[node.planned]]`: an address, who has it, and what it does.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Planned {
    /// 0 to 126.
    pub oa: OperationalAddress,
    /// For whom it is.
    pub device: Pattern,
    /// Who may take over when it is lost.
    pub spares: Vec<Pattern>,
    /// What is made with it, in this order.
    pub connections: Vec<PlannedIo>,
    /// What is read from it without a connection.
    pub reads: Vec<Attribute>,
}

/// Which devices are meant.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Pattern {
    /// Vendor, product and major revision; the serial number only if [`any_serial`](Self::any_serial) is not set.
    pub device: message::DeviceIdentity,
    /// Every device of that product.
    pub any_serial: bool,
}

impl Pattern {
    /// Whether a device is meant.
    #[must_use]
    pub fn is(&self, device: &message::DeviceIdentity) -> bool {
        let serial = if self.any_serial { device.serial } else { self.device.serial };
        message::DeviceIdentity { serial, ..self.device } == *device
    }
}

/// `reads = [{ .. }]`
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Attribute {
    /// The class.
    pub class: ClassId,
    /// The instance.
    pub instance: InstanceId,
    /// The attribute.
    pub attribute: AttributeId,
}

/// `connections = [{ .. }]`
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct PlannedIo {
    /// Which.
    pub connection: NexConnection,
    /// The expected packet rate, in ms; 0: for ever.
    pub epr: u16,
    /// What the device does when nothing arrives for four of them.
    pub watchdog: WatchdogAction,
    /// Whose data it consumes: an address, and which of the connections that are planned with it.
    pub from: Option<(OperationalAddress, u8)>,
}

names! {
    /// The connections of DeviceNeX.
    NexConnection {
        /// Instance 1.
        Explicit = "explicit",
        /// Instance 3.
        Polled = "poll",
        /// Instance 2.
        Polled11 = "poll_11",
        /// Instance 5.
        Broadcast = "broadcast",
        /// Instance 4.
        Broadcast11 = "broadcast_11",
        /// Instance 7: the producing end.
        Producer = "multicast_producer",
        /// Instance 6: the producing end.
        Producer11 = "multicast_producer_11",
        /// Instance 9.
        ChangeOfState = "cos",
        /// Instance 8.
        ChangeOfState11 = "cos_11",
        /// Instance 11.
        Cyclic = "cyclic",
        /// Instance 10.
        Cyclic11 = "cyclic_11",
        /// Instance 13: the consuming end.
        Consumer = "multicast_consumer",
        /// Instance 12: the consuming end.
        Consumer11 = "multicast_consumer_11",
        /// Instances 128 to 255, which the device numbers.
        Dynamic = "dynamic",
    }
}

impl NexConnection {
    /// As the paper counts it; `None` for a dynamic one.
    #[must_use]
    pub const fn predefined(self) -> Option<Predefined> {
        use IdentifierLength::{Extended, Standard};
        Some(match self {
            Self::Explicit => Predefined::Explicit,
            Self::Polled => Predefined::Implicit(Production::Polled, Extended),
            Self::Polled11 => Predefined::Implicit(Production::Polled, Standard),
            Self::Broadcast => Predefined::Implicit(Production::Broadcast, Extended),
            Self::Broadcast11 => Predefined::Implicit(Production::Broadcast, Standard),
            Self::Producer => Predefined::Implicit(Production::MulticastProducer, Extended),
            Self::Producer11 => Predefined::Implicit(Production::MulticastProducer, Standard),
            Self::ChangeOfState => Predefined::Implicit(Production::ChangeOfState, Extended),
            Self::ChangeOfState11 => Predefined::Implicit(Production::ChangeOfState, Standard),
            Self::Cyclic => Predefined::Implicit(Production::Cyclic, Extended),
            Self::Cyclic11 => Predefined::Implicit(Production::Cyclic, Standard),
            Self::Consumer => Predefined::Implicit(Production::MulticastConsumer, Extended),
            Self::Consumer11 => Predefined::Implicit(Production::MulticastConsumer, Standard),
            Self::Dynamic => return None,
        })
    }

    /// Whether it is this instance of the Connection object.
    #[must_use]
    pub fn is(self, instance: u16) -> bool {
        match self.predefined() {
            Some(predefined) => u16::from(predefined.number()) == instance,
            None => (128..=255).contains(&instance),
        }
    }

    /// Whether a device sends on it without being asked.
    #[must_use]
    pub const fn sends(self) -> bool {
        match self {
            Self::Broadcast
            | Self::Broadcast11
            | Self::Producer
            | Self::Producer11
            | Self::ChangeOfState
            | Self::ChangeOfState11
            | Self::Cyclic
            | Self::Cyclic11 => true,
            Self::Explicit
            | Self::Polled
            | Self::Polled11
            | Self::Consumer
            | Self::Consumer11
            | Self::Dynamic => false,
        }
    }

    /// Whether it consumes what another device sends, and nothing else.
    #[must_use]
    pub const fn consumes_only(self) -> bool {
        matches!(self, Self::Consumer | Self::Consumer11)
    }
}

names! {
    /// What a consumer does when nothing arrives in time.
    WatchdogName {
        /// The connection is timed out until it is set up again.
        TimeOut = "time_out",
        /// The connection is deleted.
        AutoDelete = "auto_delete",
        /// The connection begins anew.
        AutoReset = "auto_reset",
    }
}

impl WatchdogName {
    /// The value of attribute 12.
    #[must_use]
    pub const fn action(self) -> WatchdogAction {
        match self {
            Self::TimeOut => WatchdogAction::TRANSITION_TO_TIMED_OUT,
            Self::AutoDelete => WatchdogAction::AUTO_DELETE,
            Self::AutoReset => WatchdogAction::AUTO_RESET,
        }
    }
}
