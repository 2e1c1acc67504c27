//! What a device tells everybody unasked: heartbeat and shutdown.
//!
//! Both look like an unconnected response: on `0x740 + n` from a UCMM-capable node, on `0x403 + 8n` from a Group 2 Only
//! server, where n is the sender. The header carries the sender's MAC ID as well, by which a receiver knows that it is
//! no response to anybody.
//!
//! Reserved bits: FRAG and XID of the header must be 0 and are refused otherwise; bits 7-4 of the flags and reserved
//! codes are kept.

use core::fmt;

use bitflags::bitflags;
use cip_core::code::{ClassId, InstanceId, ServiceCode};
use cip_core::codec::{Full, ParseError, Reader, Wire, Writer};

use super::Direction;
use super::fields::{mac_id, service};
use crate::id::MacId;

/// Device Heartbeat message.
///
/// | Byte | Content |
/// |---|---|
/// | 0 | FRAG 0, XID 0, sender's MAC ID |
/// | 1 | 0xCD |
/// | 2-3 | Identity object instance ID, little-endian, normally 1 |
/// | 4 | device state, Identity attribute 8 |
/// | 5 | [`HeartbeatFlags`] |
/// | 6-7 | configuration consistency value, Identity attribute 9, little-endian; 0 if not supported |
///
/// Sent every Identity attribute 10 seconds; 0 means never. Source: CIP Vol. 3; IXXAT canAnalyser DeviceNet module
/// manual; Limitorque MX manual LMENIM2328.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Heartbeat {
    /// The sender.
    pub node: MacId,
    /// Of the Identity object.
    pub instance: InstanceId,
    /// How the device is.
    pub state: DeviceState,
    /// What troubles it.
    pub flags: HeartbeatFlags,
    /// Changes when the configuration does.
    pub configuration_consistency: u16,
}

bitflags! {
    /// Byte 5 of a heartbeat. Reserved bits that were received are kept.
    ///
    /// | Bit | Content |
    /// |---|---|
    /// | 0 | DF, device fault |
    /// | 1 | UF, user fault |
    /// | 2 | SF, system fault, for example a connection timed out |
    /// | 3 | EV, event; 0 in a heartbeat |
    /// | 4-7 | reserved, 0 |
    #[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
    #[cfg_attr(feature = "serde", derive(serde::Serialize))]
    pub struct HeartbeatFlags: u8 {
        /// DF.
        const DEVICE_FAULT = 0x01;
        /// UF.
        const USER_FAULT = 0x02;
        /// SF.
        const SYSTEM_FAULT = 0x04;
        /// EV.
        const EVENT = 0x08;
    }
}

impl HeartbeatFlags {
    /// Bits 7-4, in place: 0 unless something is wrong.
    #[must_use]
    pub const fn reserved_bits(self) -> u8 {
        self.bits() & 0xF0
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for HeartbeatFlags {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{=u8:#04x}", self.bits());
    }
}

/// The state of a device, Identity attribute 8. Open: a value without a name is kept.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(transparent))]
pub struct DeviceState(pub u8);

impl DeviceState {
    /// 0: no power.
    pub const NONEXISTENT: Self = Self(0);
    /// 1
    pub const SELF_TESTING: Self = Self(1);
    /// 2: needs configuration.
    pub const STANDBY: Self = Self(2);
    /// 3
    pub const OPERATIONAL: Self = Self(3);
    /// 4
    pub const MAJOR_RECOVERABLE_FAULT: Self = Self(4);
    /// 5
    pub const MAJOR_UNRECOVERABLE_FAULT: Self = Self(5);

    /// The name, if the state has one.
    #[must_use]
    pub const fn name(self) -> Option<&'static str> {
        match self {
            Self::NONEXISTENT => Some("nonexistent"),
            Self::SELF_TESTING => Some("self testing"),
            Self::STANDBY => Some("standby"),
            Self::OPERATIONAL => Some("operational"),
            Self::MAJOR_RECOVERABLE_FAULT => Some("major recoverable fault"),
            Self::MAJOR_UNRECOVERABLE_FAULT => Some("major unrecoverable fault"),
            _ => None,
        }
    }
}

/// The name, or `device state 0x09`.
impl fmt::Display for DeviceState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.name() {
            Some(name) => f.write_str(name),
            None => write!(f, "device state 0x{:02X}", self.0),
        }
    }
}

/// Device Shutdown message, sent once when a device leaves the network on purpose.
///
/// | Byte | Content |
/// |---|---|
/// | 0 | FRAG 0, XID 0, sender's MAC ID |
/// | 1 | 0xCE |
/// | 2-3 | class ID of the object responsible, little-endian |
/// | 4-5 | its instance ID, little-endian |
/// | 6-7 | [`ShutdownCode`], little-endian |
///
/// Source: CIP Vol. 3; IXXAT canAnalyser DeviceNet module manual.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Shutdown {
    /// The sender.
    pub node: MacId,
    /// Whose doing it is.
    pub class: ClassId,
    /// Of that class.
    pub instance: InstanceId,
    /// Why.
    pub code: ShutdownCode,
}

/// Why a device shuts down.
///
/// | Range | Defined by |
/// |---|---|
/// | 0x0000-0x01FF | ODVA |
/// | 0x0200-0x02FF | the vendor |
/// | 0x0300-0x04FF | the object class |
/// | 0x0500-0xFFFF | reserved |
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(transparent))]
pub struct ShutdownCode(pub u16);

/// `vendor-specific code 0x0201`
impl fmt::Display for ShutdownCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let definer = match self.0 {
            0x0000..=0x01FF => "open",
            0x0200..=0x02FF => "vendor-specific",
            0x0300..=0x04FF => "class-specific",
            0x0500..=0xFFFF => "reserved",
        };
        write!(f, "{definer} code 0x{:04X}", self.0)
    }
}

impl Wire<'_> for Heartbeat {
    const NAME: &'static str = "heartbeat";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        let node = mac_id(reader, "header")?;
        service(reader, HEARTBEAT, Direction::Response)?;
        Ok(Self {
            node,
            instance: InstanceId(reader.u16("Identity instance ID")?),
            state: DeviceState(reader.u8("device state")?),
            flags: HeartbeatFlags::from_bits_retain(reader.u8("flags")?),
            configuration_consistency: reader.u16("configuration consistency value")?,
        })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.bytes(&[self.node.number(), HEARTBEAT.response_byte()])?;
        out.u16(self.instance.0)?;
        out.bytes(&[self.state.0, self.flags.bits()])?;
        out.u16(self.configuration_consistency)
    }

    fn wire_len(&self) -> usize {
        8
    }
}

impl Wire<'_> for Shutdown {
    const NAME: &'static str = "shutdown";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        let node = mac_id(reader, "header")?;
        service(reader, SHUTDOWN, Direction::Response)?;
        Ok(Self {
            node,
            class: ClassId(reader.u16("class ID")?),
            instance: InstanceId(reader.u16("instance ID")?),
            code: ShutdownCode(reader.u16("shutdown code")?),
        })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.bytes(&[self.node.number(), SHUTDOWN.response_byte()])?;
        out.u16(self.class.0)?;
        out.u16(self.instance.0)?;
        out.u16(self.code.0)
    }

    fn wire_len(&self) -> usize {
        8
    }
}

const HEARTBEAT: ServiceCode = ServiceCode(0x4D);
const SHUTDOWN: ServiceCode = ServiceCode(0x4E);
