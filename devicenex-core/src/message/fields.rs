//! Fields that several messages share.

use core::fmt;

use cip_core::code::VendorId;
use cip_core::codec::{ParseError, Reader};

/// Who a device is, all over the world: vendor, product, major revision and serial number **\[P\]**.
///
/// The order, by vendor ID first and serial number last, decides between two devices that join with one address **\[D\]**:
/// the lower one keeps it.
///
/// There is no default: a vendor ID is assigned by ODVA, and the vendor sees to it that no serial number is used twice.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DeviceIdentity {
    /// Identity object, attribute 1.
    pub vendor: VendorId,
    /// Identity object, attribute 3.
    pub product_code: u16,
    /// Identity object, attribute 4, first byte.
    pub major_revision: u8,
    /// Identity object, attribute 6.
    pub serial: u32,
}

impl DeviceIdentity {
    /// The half of the serial number that is part of an identifier.
    #[must_use]
    pub const fn serial_low(&self) -> u16 {
        let [low, high, ..] = self.serial.to_le_bytes();
        u16::from_le_bytes([low, high])
    }

    pub(crate) const fn of_halves(serial_low: u16, rest: RestOfIdentity) -> Self {
        let [byte_0, byte_1] = serial_low.to_le_bytes();
        let [byte_2, byte_3] = rest.serial_high.to_le_bytes();
        Self {
            vendor: rest.vendor,
            product_code: rest.product_code,
            major_revision: rest.major_revision,
            serial: u32::from_le_bytes([byte_0, byte_1, byte_2, byte_3]),
        }
    }
}

impl From<&cip_core::identity::DeviceIdentity> for DeviceIdentity {
    fn from(device: &cip_core::identity::DeviceIdentity) -> Self {
        Self {
            vendor: device.vendor,
            product_code: device.product_code,
            major_revision: device.revision.major,
            serial: device.serial,
        }
    }
}

/// `vendor 4660, product 1110, revision 2, serial 0x11223344`
impl fmt::Display for DeviceIdentity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { vendor, product_code, major_revision, serial } = self;
        write!(
            f,
            "vendor {}, product {product_code}, revision {major_revision}, serial 0x{serial:08X}",
            vendor.0
        )
    }
}

/// The part of an identity that Hello and ROAM carry as data.
///
/// | Byte | Content |
/// |---|---|
/// | 0-1 | serial number bytes 2 and 3 |
/// | 2-3 | vendor ID, little-endian |
/// | 4-5 | product code, little-endian |
/// | 6 | major revision |
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct RestOfIdentity {
    /// The high half of the serial number; the low half is in the identifier.
    pub serial_high: u16,
    /// Vendor ID.
    pub vendor: VendorId,
    /// Product code.
    pub product_code: u16,
    /// Major revision.
    pub major_revision: u8,
}

impl RestOfIdentity {
    pub(super) fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        Ok(Self {
            serial_high: reader.u16("serial number, high half")?,
            vendor: VendorId(reader.u16("vendor ID")?),
            product_code: reader.u16("product code")?,
            major_revision: reader.u8("major revision")?,
        })
    }

    pub(super) const fn bytes(self, last: u8) -> [u8; 8] {
        let [serial_2, serial_3] = self.serial_high.to_le_bytes();
        let [vendor_low, vendor_high] = self.vendor.0.to_le_bytes();
        let [product_low, product_high] = self.product_code.to_le_bytes();
        [serial_2, serial_3, vendor_low, vendor_high, product_low, product_high, self.major_revision, last]
    }
}

impl From<DeviceIdentity> for RestOfIdentity {
    fn from(device: DeviceIdentity) -> Self {
        let [_, _, byte_2, byte_3] = device.serial.to_le_bytes();
        Self {
            serial_high: u16::from_le_bytes([byte_2, byte_3]),
            vendor: device.vendor,
            product_code: device.product_code,
            major_revision: device.major_revision,
        }
    }
}

/// Byte 7 of a Hello: bits 6-0 are the number of the physical port **\[R\]**, bit 7 is reserved.
///
/// A Hello with the reserved bit set is read all the same: it may come from a node of a later time, and tells its address.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(transparent))]
pub struct PortByte(pub u8);

impl PortByte {
    /// The only port of most devices.
    pub const ZERO: Self = Self(0);

    /// The number of the port, 0 to 127.
    #[must_use]
    pub const fn number(self) -> u8 {
        self.0 & !RESERVED
    }

    /// Whether the reserved bit is set.
    #[must_use]
    pub const fn is_reserved(self) -> bool {
        self.0 & RESERVED != 0
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

/// Takes all that remains, at most `most` bytes.
pub(super) fn rest<'a>(
    reader: &mut Reader<'a>,
    most: usize,
    message: &'static str,
) -> Result<&'a [u8], ParseError> {
    let bytes = reader.bytes(reader.remaining().min(most), message)?;
    reader.finish(message)?;
    Ok(bytes)
}

const RESERVED: u8 = 0x80;
