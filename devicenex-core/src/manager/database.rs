//! What the manager is told of its network: which device is to be where, with which connections, and who may stand in.

use core::fmt;

use cip_core::code::{AttributeId, ClassId, InstanceId, VendorId};
use cip_core::connection::{TransportClassTrigger, WatchdogAction};
use heapless::Vec;

use super::slot::Setting;
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
    /// What is read from it without a connection when it is on line (paper 1-6).
    pub reads: Vec<Attribute, READS>,
}

/// A connection to make with a device.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct PlannedConnection {
    /// Instance 2 to 13 of the predefined set; `None` for a dynamic one, which the device numbers.
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
    /// The Message ID with which the device shall produce: a low one has a high priority.
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
        }
        Ok(())
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

    /// What is to be set after the connection was granted, from `first` on; the rest was in the request.
    pub(super) fn next_setting(&self, first: Setting) -> Option<Setting> {
        let is_dynamic = self.instance.is_none();
        Setting::ALL.into_iter().filter(|setting| *setting >= first).find(|setting| match setting {
            Setting::Trigger => self.trigger.is_some(),
            Setting::ConsumedId => self.consumes.is_some(),
            Setting::WatchdogAction | Setting::PacketRate => is_dynamic,
        })
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
