//! ROAM: a device gets an address.

use core::fmt;

use cip_core::codec::{Full, ParseError, Reader, Wire, Writer};
use link_core::Frame;

use super::{DeviceIdentity, RestOfIdentity};
use crate::id::{Identifier, Layout, OperationalAddress};

/// The data of a ROAM, Reallocate Operational Address Message (paper 4.3, figure 6) **\[P\]**.
///
/// | Byte | Content |
/// |---|---|
/// | 0-1 | target's serial number bytes 2 and 3 |
/// | 2-3 | target's vendor ID, little-endian |
/// | 4-5 | target's product code, little-endian |
/// | 6 | target's major revision |
/// | 7 | bit 7: 0; bits 6-0 requested OA |
///
/// With bit 7 set it is refused **\[D\]**.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct RoamData {
    /// What the identifier does not say of the target.
    pub target: RestOfIdentity,
    /// The address that it shall have.
    pub requested: OperationalAddress,
}

/// A ROAM, identifier and data: a device without an address gets one. It does not answer; that it says Hello with the new
/// address shows that it took it.
///
/// ```
/// use devicenex_core::{OperationalAddress, message::{DeviceIdentity, Roam}};
///
/// let target = DeviceIdentity { vendor: 0x0123.into(), product_code: 0x0456, major_revision: 2, serial: 0x1122_3344 };
/// let roam = Roam { target, requested: OperationalAddress::new(67).unwrap() };
/// assert_eq!(roam.frame().unwrap().to_string(), "1EFE4433 [8] 22 11 23 01 56 04 02 43");
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Roam {
    /// For whom it is.
    pub target: DeviceIdentity,
    /// The address that it shall have.
    pub requested: OperationalAddress,
}

impl Roam {
    /// The frame.
    #[must_use]
    pub fn frame(&self) -> Option<Frame> {
        let data = RoamData { target: self.target.into(), requested: self.requested };
        super::frame(Identifier::roam(self.target.serial_low()), &data)
    }

    /// Reads a frame; `None` if it is not a ROAM to a device without an address.
    #[must_use]
    pub fn of_frame(frame: &Frame) -> Option<Result<Self, ParseError>> {
        match Identifier::of_frame(frame).layout() {
            Layout::Roam { destination, serial_low } if destination.is_none() && !frame.is_remote() => {
                Some(RoamData::parse(frame.data()).map(|data| Self {
                    target: DeviceIdentity::of_halves(serial_low, data.target),
                    requested: data.requested,
                }))
            }
            _ => None,
        }
    }
}

impl Wire<'_> for RoamData {
    const NAME: &'static str = "ROAM";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        let target = RestOfIdentity::read(reader)?;
        let offset = reader.offset();
        let byte = reader.u8("requested OA")?;
        let requested =
            OperationalAddress::new(byte).ok_or(ParseError::value("requested OA", offset, byte.into()))?;
        Ok(Self { target, requested })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.bytes(&self.target.bytes(self.requested.number()))
    }

    fn wire_len(&self) -> usize {
        8
    }
}

/// `ROAM to OA 67: vendor 291, product 1110, revision 2, serial 0x11223344`
impl fmt::Display for Roam {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "ROAM to OA {}: {}", self.requested, self.target)
    }
}
