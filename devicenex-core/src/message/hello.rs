//! Hello and Mini-who: who is there.

use core::fmt;

use cip_core::codec::{Full, ParseError, Reader, Wire, Writer};
use link_core::Frame;

use super::{DeviceIdentity, PortByte, RestOfIdentity};
use crate::id::{Direction, Identifier, Layout, OperationalAddress};

/// The data of a Hello (paper 4.1, figure 3) **\[P\]**.
///
/// | Byte | Content |
/// |---|---|
/// | 0-1 | serial number bytes 2 and 3 |
/// | 2-3 | vendor ID, little-endian |
/// | 4-5 | product code, little-endian |
/// | 6 | major revision |
/// | 7 | bit 7 reserved, 0; bits 6-0 physical port number **\[R\]** |
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct HelloData {
    /// What the identifier does not say of the sender.
    pub device: RestOfIdentity,
    /// The sender's port.
    pub port: PortByte,
}

/// A Hello, identifier and data: a node tells the address that it has or wants, and who it is.
///
/// ```
/// use devicenex_core::{OperationalAddress, id::Direction, message::{DeviceIdentity, Hello, PortByte}};
///
/// let device = DeviceIdentity { vendor: 0x0123.into(), product_code: 0x0456, major_revision: 2, serial: 0x1122_3344 };
/// let source = OperationalAddress::NONE;
/// let hello = Hello { source, direction: Direction::Request, device, port: PortByte::ZERO };
/// assert_eq!(hello.frame().unwrap().to_string(), "1FFE4433 [8] 22 11 23 01 56 04 02 00");
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Hello {
    /// The sender's address.
    pub source: OperationalAddress,
    /// A request of a node that joins, or the response of one that has the address.
    pub direction: Direction,
    /// The sender.
    pub device: DeviceIdentity,
    /// The sender's port.
    pub port: PortByte,
}

/// Mini-who (paper 4.2, figure 4) **\[P\]**: whoever has no address shall say Hello.
///
/// A remote frame on the identifier of a Hello request with address 127. The half of a serial number in it is the
/// *sender's*, so that two senders do not collide. It is sent with a DLC of 8 **\[D\]**, that of the Hello, and read with
/// any.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct MiniWho {
    /// The low half of the sender's serial number.
    pub serial_low: u16,
}

impl Hello {
    /// The frame.
    #[must_use]
    pub fn frame(&self) -> Option<Frame> {
        let data = HelloData { device: self.device.into(), port: self.port };
        super::frame(Identifier::hello(self.source, self.direction, self.device.serial_low()), &data)
    }

    /// Reads a frame; `None` if it is not a Hello.
    #[must_use]
    pub fn of_frame(frame: &Frame) -> Option<Result<Self, ParseError>> {
        let Layout::Hello { source, direction, serial_low } = Identifier::of_frame(frame).layout() else {
            return None;
        };
        if frame.is_remote() {
            return None;
        }
        Some(HelloData::parse(frame.data()).map(|data| Self {
            source,
            direction,
            device: DeviceIdentity::of_halves(serial_low, data.device),
            port: data.port,
        }))
    }
}

impl MiniWho {
    /// The frame.
    #[must_use]
    pub fn frame(&self) -> Option<Frame> {
        let id = Identifier::hello(OperationalAddress::NONE, Direction::Request, self.serial_low);
        Frame::remote(id.id(), DLC)
    }

    /// Reads a frame; `None` if it is not a Mini-who.
    #[must_use]
    pub fn of_frame(frame: &Frame) -> Option<Self> {
        match Identifier::of_frame(frame).layout() {
            Layout::Hello { source, direction: Direction::Request, serial_low }
                if source.is_none() && frame.is_remote() =>
            {
                Some(Self { serial_low })
            }
            _ => None,
        }
    }
}

impl Wire<'_> for HelloData {
    const NAME: &'static str = "Hello";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        Ok(Self { device: RestOfIdentity::read(reader)?, port: PortByte(reader.u8("port number")?) })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.bytes(&self.device.bytes(self.port.0))
    }

    fn wire_len(&self) -> usize {
        8
    }
}

/// `Hello request of OA 127: vendor 291, product 1110, revision 2, serial 0x11223344`
impl fmt::Display for Hello {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Hello {} of OA {}: {}", self.direction, self.source, self.device)
    }
}

const DLC: u8 = 8;
