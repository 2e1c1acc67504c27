//! Fields that several messages share.

use core::fmt;

use cip_core::code::{ServiceCode, VendorId};
use cip_core::codec::{Full, ParseError, Reader, Writer};

use crate::id::MacId;

/// Bit 7 of a service byte or of byte 0 of a duplicate MAC ID check: R/R.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "lowercase"))]
pub enum Direction {
    /// 0
    Request,
    /// 1
    Response,
}

impl Direction {
    /// What bit 7 of a byte says.
    #[must_use]
    pub const fn of(byte: u8) -> Self {
        if byte & RESPONSE_BIT == 0 { Self::Request } else { Self::Response }
    }

    /// Bit 7: 0x00 or 0x80.
    #[must_use]
    pub const fn bit(self) -> u8 {
        match self {
            Self::Request => 0,
            Self::Response => RESPONSE_BIT,
        }
    }
}

impl fmt::Display for Direction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Request => "request",
            Self::Response => "response",
        })
    }
}

/// Who a device is, all over the world: vendor ID and serial number.
///
/// | Byte | Content |
/// |---|---|
/// | 0-1 | Vendor ID, little-endian |
/// | 2-5 | Serial number, little-endian |
///
/// There is no default: a vendor ID is assigned by ODVA, and the vendor sees to it that no serial number is used twice.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DeviceIdentity {
    /// Identity object, attribute 1.
    pub vendor: VendorId,
    /// Identity object, attribute 6.
    pub serial: u32,
}

impl DeviceIdentity {
    pub(crate) fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        Ok(Self { vendor: VendorId(reader.u16("vendor ID")?), serial: reader.u32("serial number")? })
    }

    pub(crate) fn emit(self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u16(self.vendor.0)?;
        out.u32(self.serial)
    }
}

/// `vendor 4660, serial 0x00002345`
impl fmt::Display for DeviceIdentity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "vendor {}, serial 0x{:08X}", self.vendor.0, self.serial)
    }
}

/// The physical port that a check or a Who response comes from, 0 to 127. A device with one DeviceNet port uses 0.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(transparent))]
pub struct PortNumber(u8);

impl PortNumber {
    /// The only port of most devices.
    pub const ZERO: Self = Self(0);

    /// The port of that number; `None` above 127.
    #[must_use]
    pub const fn new(number: u8) -> Option<Self> {
        if number < RESPONSE_BIT { Some(Self(number)) } else { None }
    }

    /// The number, 0 to 127.
    #[must_use]
    pub const fn number(self) -> u8 {
        self.0
    }

    pub(crate) const fn from_low_bits(byte: u8) -> Self {
        Self(byte & !RESPONSE_BIT)
    }
}

impl fmt::Display for PortNumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.0, f)
    }
}

/// Reads a service byte that must be that of `service` in that direction.
pub(super) fn service(
    reader: &mut Reader<'_>,
    service: ServiceCode,
    direction: Direction,
) -> Result<(), ParseError> {
    constant(reader, "service", service.request_byte() | direction.bit())
}

/// Reads a service byte that must be that of `service`, in either direction.
pub(super) fn service_of_either_direction(
    reader: &mut Reader<'_>,
    service: ServiceCode,
) -> Result<Direction, ParseError> {
    let offset = reader.offset();
    let byte = reader.u8("service")?;
    match ServiceCode::split(byte) {
        (code, _) if code == service => Ok(Direction::of(byte)),
        _ => Err(ParseError::value("service", offset, byte.into())),
    }
}

/// Reads a byte that can only have one value.
pub(super) fn constant(reader: &mut Reader<'_>, field: &'static str, value: u8) -> Result<(), ParseError> {
    let offset = reader.offset();
    match reader.u8(field)? {
        byte if byte == value => Ok(()),
        byte => Err(ParseError::value(field, offset, byte.into())),
    }
}

/// Reads a MAC ID in bits 5-0 of a byte whose bits 7-6 must be 0.
pub(super) fn mac_id(reader: &mut Reader<'_>, field: &'static str) -> Result<MacId, ParseError> {
    let offset = reader.offset();
    let byte = reader.u8(field)?;
    MacId::new(byte).ok_or(ParseError::value(field, offset, byte.into()))
}

const RESPONSE_BIT: u8 = 0x80;
