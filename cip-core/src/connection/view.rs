//! What is read from a connection.

use super::{CommCharacteristics, ConnectionState, InstanceType, Settings, TransportClassTrigger};
use crate::code::{AttributeId, GeneralStatus, InstanceId};
use crate::codec::{Full, Writer};

/// A path in attribute 14 or 16.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ConnectionPath {
    /// No bytes.
    Empty,
    /// The data of an assembly: `20 04 24 ii 30 03`, or `20 04 25 ii ii 30 03`.
    Assembly(InstanceId),
    /// The Acknowledge Handler: `20 2B 24 01`.
    AcknowledgeHandler,
}

/// The attributes of one connection, as Get_Attribute_Single reads them: one by one.
///
/// | Attribute | Type | Content |
/// |---|---|---|
/// | 1 | USINT | state |
/// | 2 | USINT | instance_type |
/// | 3 | BYTE | transportClass_trigger |
/// | 4 | UINT, on DeviceNeX UDINT | produced_connection_id |
/// | 5 | UINT, on DeviceNeX UDINT | consumed_connection_id |
/// | 6 | BYTE | initial_comm_characteristics |
/// | 7 | UINT | produced_connection_size |
/// | 8 | UINT | consumed_connection_size |
/// | 9 | UINT | expected_packet_rate, ms |
/// | 12 | USINT | watchdog_timeout_action |
/// | 13 | UINT | produced_connection_path_length, bytes |
/// | 14 | EPATH | produced_connection_path, packed |
/// | 15 | UINT | consumed_connection_path_length, bytes |
/// | 16 | EPATH | consumed_connection_path, packed |
/// | 17 | UINT | production_inhibit_time, ms |
/// | 18 | USINT | connection_timeout_multiplier |
///
/// Source: CIP Vol. 1, Connection object.
pub trait ConnectionView {
    /// UINT or UDINT, as the network has it.
    type Id: ConnectionId;

    /// Attribute 1.
    fn state(&self) -> ConnectionState;

    /// Attribute 2.
    fn instance_type(&self) -> InstanceType;

    /// Attribute 3.
    fn transport_class_trigger(&self) -> TransportClassTrigger;

    /// Attribute 4; all bits set: it does not produce.
    fn produced_id(&self) -> Self::Id;

    /// Attribute 5; all bits set: it does not consume.
    fn consumed_id(&self) -> Self::Id;

    /// Attribute 6.
    fn comm_characteristics(&self) -> CommCharacteristics;

    /// Attribute 7.
    fn produced_size(&self) -> u16;

    /// Attribute 8.
    fn consumed_size(&self) -> u16;

    /// Attributes 9, 12, 17 and 18.
    fn settings(&self) -> &Settings;

    /// Attributes 13 and 14.
    fn produced_path(&self) -> ConnectionPath;

    /// Attributes 15 and 16.
    fn consumed_path(&self) -> ConnectionPath;

    /// Writes an attribute; 0x14 if there is none of that number.
    fn get(&self, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), GeneralStatus> {
        let byte = match attribute.0 {
            1 => self.state().0,
            2 => self.instance_type().0,
            3 => self.transport_class_trigger().0,
            6 => self.comm_characteristics().0,
            12 => self.settings().watchdog_action.0,
            18 => self.settings().multiplier.0,
            4 => return Ok(self.produced_id().emit(out)?),
            5 => return Ok(self.consumed_id().emit(out)?),
            14 => return Ok(self.produced_path().emit(out)?),
            16 => return Ok(self.consumed_path().emit(out)?),
            number => {
                return Ok(out.u16(match number {
                    7 => self.produced_size(),
                    8 => self.consumed_size(),
                    9 => self.settings().expected_packet_rate,
                    13 => self.produced_path().len(),
                    15 => self.consumed_path().len(),
                    17 => self.settings().production_inhibit_time,
                    _ => return Err(GeneralStatus::ATTRIBUTE_NOT_SUPPORTED),
                })?);
            }
        };
        Ok(out.u8(byte)?)
    }
}

/// A value of attributes 4 and 5.
pub trait ConnectionId {
    /// Writes it.
    fn emit(self, out: &mut Writer<'_>) -> Result<(), Full>;
}

impl ConnectionId for u16 {
    fn emit(self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u16(self)
    }
}

impl ConnectionId for u32 {
    fn emit(self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u32(self)
    }
}

impl ConnectionPath {
    /// The number of its bytes.
    pub const fn len(self) -> u16 {
        match self {
            Self::Empty => 0,
            Self::Assembly(InstanceId(0..=0xFF)) => 6,
            Self::Assembly(_) => 7,
            Self::AcknowledgeHandler => 4,
        }
    }

    /// True if it has no bytes.
    pub const fn is_empty(self) -> bool {
        matches!(self, Self::Empty)
    }

    /// Writes it in the packed form. The layouts are few and constant, so that no code for paths is needed.
    pub fn emit(self, out: &mut Writer<'_>) -> Result<(), Full> {
        match self {
            Self::Empty => Ok(()),
            Self::Assembly(InstanceId(instance)) => match u8::try_from(instance) {
                Ok(instance) => out.bytes(&[0x20, 0x04, 0x24, instance, 0x30, 0x03]),
                Err(_) => {
                    let [low, high] = instance.to_le_bytes();
                    out.bytes(&[0x20, 0x04, 0x25, low, high, 0x30, 0x03])
                }
            },
            Self::AcknowledgeHandler => out.bytes(&[0x20, 0x2B, 0x24, 0x01]),
        }
    }
}
