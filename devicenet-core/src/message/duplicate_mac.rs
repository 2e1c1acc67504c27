//! The duplicate MAC ID check.

use cip_core::codec::{Full, ParseError, Reader, Wire, Writer};

use super::{DeviceIdentity, Direction, PortNumber};

/// Duplicate MAC ID check message, on `0x407 + 8n`, where n is the MAC ID that is being checked.
///
/// | Byte | Content |
/// |---|---|
/// | 0 | bit 7 R/R: 0 request, 1 response; bits 6-0 physical port number |
/// | 1-2 | Vendor ID, little-endian |
/// | 3-6 | Serial number, little-endian |
///
/// Exactly seven bytes, and every value of them is valid. Source: CIP Vol. 3, duplicate MAC ID check; Lika SFA-5000
/// manual.
///
/// ```
/// use devicenet_core::message::{DuplicateMacCheck, Direction, Wire};
///
/// let check = DuplicateMacCheck::parse(&[0x80, 0x34, 0x12, 0x45, 0x23, 0x00, 0x00])?;
/// assert_eq!(check.direction, Direction::Response);
/// assert_eq!((check.device.vendor.0, check.device.serial), (0x1234, 0x2345));
/// # Ok::<(), devicenet_core::message::ParseError>(())
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct DuplicateMacCheck {
    /// A request of a node that wants on line, or the response of one that is.
    pub direction: Direction,
    /// The sender's port.
    pub port: PortNumber,
    /// The sender.
    pub device: DeviceIdentity,
}

impl Wire<'_> for DuplicateMacCheck {
    const NAME: &'static str = "duplicate MAC ID check";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        let byte = reader.u8("R/R and port number")?;
        Ok(Self {
            direction: Direction::of(byte),
            port: PortNumber::from_low_bits(byte),
            device: DeviceIdentity::read(reader)?,
        })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        let ([v0, v1], [s0, s1, s2, s3]) =
            (self.device.vendor.0.to_le_bytes(), self.device.serial.to_le_bytes());
        out.bytes(&[self.direction.bit() | self.port.number(), v0, v1, s0, s1, s2, s3])
    }

    fn wire_len(&self) -> usize {
        7
    }
}
