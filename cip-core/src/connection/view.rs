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

/// All attributes of one connection, as Get_Attribute_Single reads them.
///
/// | Attribute | Type | Content |
/// |---|---|---|
/// | 1 | USINT | state |
/// | 2 | USINT | instance_type |
/// | 3 | BYTE | transportClass_trigger |
/// | 4 | UINT | produced_connection_id |
/// | 5 | UINT | consumed_connection_id |
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ConnectionView {
    /// Attribute 1.
    pub state: ConnectionState,
    /// Attribute 2.
    pub instance_type: InstanceType,
    /// Attribute 3.
    pub transport_class_trigger: TransportClassTrigger,
    /// Attribute 4; 0xFFFF: it does not produce.
    pub produced_id: u16,
    /// Attribute 5; 0xFFFF: it does not consume.
    pub consumed_id: u16,
    /// Attribute 6.
    pub comm_characteristics: CommCharacteristics,
    /// Attribute 7.
    pub produced_size: u16,
    /// Attribute 8.
    pub consumed_size: u16,
    /// Attributes 9, 12, 17 and 18.
    pub settings: Settings,
    /// Attributes 13 and 14.
    pub produced_path: ConnectionPath,
    /// Attributes 15 and 16.
    pub consumed_path: ConnectionPath,
}

impl ConnectionView {
    /// Writes an attribute; 0x14 if there is none of that number.
    pub fn get(&self, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), GeneralStatus> {
        match attribute.0 {
            1 => out.u8(self.state.0)?,
            2 => out.u8(self.instance_type.0)?,
            3 => out.u8(self.transport_class_trigger.0)?,
            4 => out.u16(self.produced_id)?,
            5 => out.u16(self.consumed_id)?,
            6 => out.u8(self.comm_characteristics.0)?,
            7 => out.u16(self.produced_size)?,
            8 => out.u16(self.consumed_size)?,
            9 => out.u16(self.settings.expected_packet_rate)?,
            12 => out.u8(self.settings.watchdog_action.0)?,
            13 => out.u16(self.produced_path.len())?,
            14 => self.produced_path.emit(out)?,
            15 => out.u16(self.consumed_path.len())?,
            16 => self.consumed_path.emit(out)?,
            17 => out.u16(self.settings.production_inhibit_time)?,
            18 => out.u8(self.settings.multiplier.0)?,
            _ => return Err(GeneralStatus::ATTRIBUTE_NOT_SUPPORTED),
        }
        Ok(())
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
