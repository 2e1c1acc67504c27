//! What the manager is told of its network: which device is to be where, with which connections, and who may stand in.

use core::fmt;

use cip_core::code::{AttributeId, ClassId, InstanceId, VendorId};
use cip_core::connection::{TransportClassTrigger, WatchdogAction};
use heapless::Vec;

use super::made::{Setting, Settings};
use crate::connection::GroupMessage;
use crate::id::{MessageId, OperationalAddress};
use crate::message::{
    ConnectionInstance, DeviceIdentity, GroupSelect, IdentifierLength, Predefined, Production,
};

/// Which devices are meant: vendor, product and revision, and one serial number or any.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct IdentityPattern {
    /// Identity object, attribute 1.
    pub vendor: VendorId,
    /// Identity object, attribute 3.
    pub product_code: u16,
    /// Identity object, attribute 4, first byte.
    pub major_revision: u8,
    /// Identity object, attribute 6; `None`: any device of that product.
    pub serial: Option<u32>,
}

/// One role in the plant: an address, who has it, and what it does.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct PlannedDevice<const CONNECTIONS: usize> {
    /// The address of the role, 0 to 126.
    pub address: OperationalAddress,
    /// The devices that it is meant for.
    pub identity: IdentityPattern,
    /// Those that may take over when it is lost.
    pub spares: Vec<IdentityPattern, SPARES>,
    /// The connections to make with it, in this order.
    pub connections: Vec<PlannedConnection, CONNECTIONS>,
    /// What is read from it without a connection when it is on line (paper 1-6): class, instance and attribute at most 255.
    pub reads: Vec<Attribute, READS>,
}

/// A connection to make with a device.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct PlannedConnection {
    /// Instance 2 to 13 of the predefined set; `None` for a dynamic one, which the device numbers. The manager has no I/O of
    /// its own **\[D\]**: it makes a polled connection, 2 or 3, but sends no commands, so that one with an expected packet rate
    /// times out.
    pub instance: Option<Predefined>,
    /// In ms; 0: for ever. The device may keep another one.
    pub expected_packet_rate: u16,
    /// What the device does when nothing arrives for four of them.
    pub watchdog_action: WatchdogAction,
    /// Whose data it consumes; `None` for one that only produces.
    pub consumes: Option<Source>,
    /// Attribute 3, if it shall not be what the device has by default: a change-of-state or cyclic connection without
    /// acknowledges, or what a dynamic one does.
    pub trigger: Option<TransportClassTrigger>,
    /// The Message ID with which the device shall produce: a low one has a high priority. 0 to 15 with 29 bits and for dynamic
    /// connections; with 11 bits 0 to 7 for change of state and cyclic, 0 to 3 for the others.
    pub message: MessageId,
}

/// A producing connection of another planned device.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Source {
    /// Its address.
    pub address: OperationalAddress,
    /// Which of its planned connections, counted from 0.
    pub connection: u8,
}

/// An attribute of an object.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Attribute {
    /// The class.
    pub class: ClassId,
    /// The instance.
    pub instance: InstanceId,
    /// The attribute.
    pub attribute: AttributeId,
}

/// Why a device was not added to the database.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum DatabaseError {
    /// 127 is no address.
    #[error("a planned device needs an address from 0 to 126")]
    NoAddress,
    /// That of the manager.
    #[error("OA {0} is the manager's own")]
    OwnAddress(OperationalAddress),
    /// It is planned already.
    #[error("OA {0} is in the database: remove that device first")]
    Planned(OperationalAddress),
    /// A device has one address.
    #[error(
        "this device is planned for OA {0}: remove it there first, or plan for any device of its product"
    )]
    Identity(OperationalAddress),
    /// No room.
    #[error("the database has room for {0} devices")]
    Full(usize),
    /// The explicit connection is made when it is needed.
    #[error("connection {0}: the explicit connection is not planned, the manager opens it when it needs it")]
    Explicit(u8),
    /// Twice the same.
    #[error("connection {0}: a device has each connection of the predefined set once")]
    Twice(u8),
    /// It consumes, and is not told what.
    #[error("connection {0}: a consuming connection needs the connection whose data it consumes")]
    NothingToConsume(u8),
    /// The connection has no such Message ID.
    #[error("connection {connection}: no Message ID {message} there; the last is {last}")]
    Message {
        /// Which of the planned connections, counted from 0.
        connection: u8,
        /// The planned one.
        message: u8,
        /// The highest one that its identifiers have room for.
        last: u8,
    },
    /// It cannot be read without a connection.
    #[error("{0} cannot be read: without a connection class, instance and attribute are at most 255")]
    Read(Attribute),
    /// It is not in the database.
    #[error("OA {0} is not in the database")]
    NotPlanned(OperationalAddress),
}

impl IdentityPattern {
    /// Exactly that device.
    #[must_use]
    pub const fn exact(device: DeviceIdentity) -> Self {
        let DeviceIdentity { vendor, product_code, major_revision, serial } = device;
        Self { vendor, product_code, major_revision, serial: Some(serial) }
    }

    /// Every device of its product and revision.
    #[must_use]
    pub const fn product_of(device: DeviceIdentity) -> Self {
        Self { serial: None, ..Self::exact(device) }
    }

    /// Whether a device is meant.
    #[must_use]
    pub fn matches(&self, device: &DeviceIdentity) -> bool {
        self.vendor == device.vendor
            && self.product_code == device.product_code
            && self.major_revision == device.major_revision
            && self.serial.is_none_or(|serial| serial == device.serial)
    }
}

impl<const CONNECTIONS: usize> PlannedDevice<CONNECTIONS> {
    /// A device without connections and spares.
    #[must_use]
    pub const fn new(address: OperationalAddress, identity: IdentityPattern) -> Self {
        Self { address, identity, spares: Vec::new(), connections: Vec::new(), reads: Vec::new() }
    }

    /// Whether a device may stand in.
    #[must_use]
    pub fn is_spare(&self, device: &DeviceIdentity) -> bool {
        self.spares.iter().any(|pattern| pattern.matches(device))
    }

    /// Whether a device may have the address, as what it is meant for or as a spare.
    #[must_use]
    pub fn accepts(&self, device: &DeviceIdentity) -> bool {
        self.identity.matches(device) || self.is_spare(device)
    }

    pub(super) fn check(&self) -> Result<(), DatabaseError> {
        if self.address.is_none() {
            return Err(DatabaseError::NoAddress);
        }
        for (number, connection) in (0_u8..).zip(&self.connections) {
            let twice =
                |other: &PlannedConnection| other.instance.is_some() && other.instance == connection.instance;
            if connection.instance == Some(Predefined::Explicit) {
                return Err(DatabaseError::Explicit(number));
            }
            if self.connections.iter().take(number.into()).any(twice) {
                return Err(DatabaseError::Twice(number));
            }
            if connection.consumes.is_none() && connection.must_consume() {
                return Err(DatabaseError::NothingToConsume(number));
            }
            let last = connection.last_message();
            if connection.message > last {
                let (message, last) = (connection.message.number(), last.number());
                return Err(DatabaseError::Message { connection: number, message, last });
            }
        }
        match self.reads.iter().find(|read| read.short().is_none()) {
            Some(read) => Err(DatabaseError::Read(*read)),
            None => Ok(()),
        }
    }
}

impl Attribute {
    /// Class, instance and attribute in eight bits each, as a request without a connection has them; `None` if one has more.
    pub(super) fn short(&self) -> Option<[u8; 3]> {
        let Self { class, instance, attribute } = *self;
        Some([class.0.try_into().ok()?, instance.0.try_into().ok()?, attribute.0.try_into().ok()?])
    }
}

impl PlannedConnection {
    /// The multicast connection by which a device produces, with 29 bits.
    #[must_use]
    pub const fn producer(expected_packet_rate: u16) -> Self {
        Self {
            instance: Some(Predefined::Implicit(Production::MulticastProducer, IdentifierLength::Extended)),
            expected_packet_rate,
            watchdog_action: WatchdogAction::TRANSITION_TO_TIMED_OUT,
            consumes: None,
            trigger: None,
            message: MessageId::from_low_bits(0),
        }
    }

    /// The connection by which a device produces when its data change, with 29 bits and without acknowledges: there may be
    /// many that consume.
    #[must_use]
    pub const fn change_of_state(expected_packet_rate: u16) -> Self {
        Self {
            instance: Some(Predefined::Implicit(Production::ChangeOfState, IdentifierLength::Extended)),
            trigger: Some(TransportClassTrigger(0x10)),
            ..Self::producer(expected_packet_rate)
        }
    }

    /// The connection by which a device produces at every packet rate, with 29 bits and without acknowledges.
    #[must_use]
    pub const fn cyclic(expected_packet_rate: u16) -> Self {
        Self {
            instance: Some(Predefined::Implicit(Production::Cyclic, IdentifierLength::Extended)),
            trigger: Some(TransportClassTrigger(0x00)),
            ..Self::producer(expected_packet_rate)
        }
    }

    /// The multicast connection by which a device consumes what another produces, with 29 bits.
    #[must_use]
    pub const fn consumer(of: Source, expected_packet_rate: u16) -> Self {
        Self {
            instance: Some(Predefined::Implicit(Production::MulticastConsumer, IdentifierLength::Extended)),
            consumes: Some(of),
            ..Self::producer(expected_packet_rate)
        }
    }

    /// How long its identifiers are.
    pub(super) const fn length(&self) -> IdentifierLength {
        match self.instance {
            Some(Predefined::Implicit(_, length)) => length,
            Some(Predefined::Explicit) | None => IdentifierLength::Extended,
        }
    }

    /// What its identifiers are: that of the predefined instance, 29 bits for a dynamic one.
    pub(super) const fn group(&self) -> GroupSelect {
        match self.instance {
            Some(Predefined::Implicit(production, IdentifierLength::Standard)) => match production {
                // Data that are waited for before data that are asked for.
                Production::ChangeOfState | Production::Cyclic => GroupSelect::GROUP_1,
                Production::Polled
                | Production::Broadcast
                | Production::MulticastProducer
                | Production::MulticastConsumer => GroupSelect::GROUP_2,
            },
            Some(Predefined::Explicit | Predefined::Implicit(_, IdentifierLength::Extended)) | None => {
                GroupSelect::IMPLICIT_29
            }
        }
    }

    /// The highest Message ID that its identifiers have.
    fn last_message(&self) -> MessageId {
        let group = self.group();
        let all = (0..=0xF).rev().filter_map(MessageId::new);
        let mut valid = all.filter(|message| GroupMessage::new(group, *message).is_ok());
        valid.next().unwrap_or_default()
    }

    /// Whether the device produces on it by itself, so that the manager can hear it.
    pub(super) const fn is_heard(&self) -> bool {
        match self.instance {
            Some(Predefined::Implicit(production, _)) => match production {
                Production::Broadcast
                | Production::MulticastProducer
                | Production::ChangeOfState
                | Production::Cyclic => true,
                Production::Polled | Production::MulticastConsumer => false,
            },
            Some(Predefined::Explicit) => false,
            None => self.consumes.is_none(),
        }
    }

    /// What is to be set after the connection was granted; the rest was in the request.
    pub(super) fn settings(&self) -> Settings {
        let is_dynamic = self.instance.is_none();
        let mut settings = Settings::default();
        for setting in Setting::ALL {
            let is_set = match setting {
                Setting::Trigger => self.trigger.is_some(),
                Setting::ConsumedId => self.consumes.is_some(),
                Setting::WatchdogAction | Setting::PacketRate => is_dynamic,
            };
            if is_set {
                settings.insert(setting);
            }
        }
        settings
    }

    const fn must_consume(&self) -> bool {
        matches!(self.instance, Some(Predefined::Implicit(Production::MulticastConsumer, _)))
    }

    /// The number of the instance that is asked for.
    pub(super) fn number(&self) -> Option<InstanceId> {
        self.instance.map(|predefined| ConnectionInstance::Predefined(predefined).number())
    }
}

/// `vendor 4660, product 1110, revision 2, any serial`
impl fmt::Display for IdentityPattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { vendor, product_code, major_revision, serial } = self;
        write!(f, "vendor {}, product {product_code}, revision {major_revision}, ", vendor.0)?;
        match serial {
            Some(serial) => write!(f, "serial 0x{serial:08X}"),
            None => f.write_str("any serial"),
        }
    }
}

/// `Identity instance 1, attribute 7`
impl fmt::Display for Attribute {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} instance {}, attribute {}", self.class, self.instance.0, self.attribute.0)
    }
}

/// How many patterns of spares a device can have.
pub const SPARES: usize = 4;
/// How many attributes can be read from a device when it is on line.
pub const READS: usize = 4;
