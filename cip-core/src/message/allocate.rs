//! Allocate and Release of the predefined master/slave connection set (DeviceNet object, CIP Vol. 3).

use core::fmt;

use super::BodyFormat;
use crate::codec::{Full, ParseError, Reader, Wire, Writer};
use crate::text::write_hex8;

bitflags::bitflags! {
    /// Which connections of the predefined set are meant, in Allocate, Release and the allocation information.
    ///
    /// | Bit | Meaning | Connection instances |
    /// |---|---|---|
    /// | 0 | explicit messages | 1 |
    /// | 1 | poll | 2 |
    /// | 2 | bit-strobe | 3 |
    /// | 3 | multicast poll | 5 |
    /// | 4 | change of state | 4, and 2 for the direction to the slave |
    /// | 5 | cyclic | 4, and 2 for the direction to the slave |
    /// | 6 | acknowledge suppression | with bit 4 or 5 only |
    /// | 7 | reserved | |
    ///
    /// What was received is kept as it is, the reserved bit included: make one with `from_bits_retain`, and judge it
    /// where the rules of the object are applied.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
    #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
    pub struct AllocationChoice: u8 {
        /// Explicit messages.
        const EXPLICIT = 0x01;
        /// Poll.
        const POLL = 0x02;
        /// Bit-strobe.
        const BIT_STROBE = 0x04;
        /// Multicast poll.
        const MULTICAST_POLL = 0x08;
        /// Change of state.
        const CHANGE_OF_STATE = 0x10;
        /// Cyclic.
        const CYCLIC = 0x20;
        /// The slave's change-of-state or cyclic messages are not acknowledged.
        const ACK_SUPPRESSION = 0x40;
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for AllocationChoice {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{=u8:#04x}", self.bits());
    }
}

impl fmt::Display for AllocationChoice {
    /// `explicit + poll`; `nothing` for zero.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_empty() {
            return f.write_str("nothing");
        }
        let mut separator = "";
        for (bit, name) in CHOICES {
            if self.contains(bit) {
                f.write_str(separator)?;
                f.write_str(name)?;
                separator = " + ";
            }
        }
        let unknown = self.difference(Self::all()).bits();
        if unknown == 0 {
            return Ok(());
        }
        f.write_str(separator)?;
        f.write_str("reserved 0x")?;
        write_hex8(f, unknown)
    }
}

/// The service data of Allocate_Master/Slave_Connection_Set.
///
/// | Byte | Content |
/// |---|---|
/// | 0 | allocation choice |
/// | 1 | MAC ID of the master, bits 5-0; bits 7-6 are 0 |
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AllocateRequest {
    /// The connections to allocate.
    pub choice: AllocationChoice,
    /// Byte 1 as it is: a server refuses values above 63.
    pub allocator: u8,
}

/// The service data of the response to Allocate.
///
/// | Byte | Content |
/// |---|---|
/// | 0 | bits 3-0 the body format of the explicit connection; bits 7-4 are 0 |
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AllocateResponse {
    body_format: u8,
}

impl AllocateResponse {
    /// A response that tells the body format.
    #[must_use]
    pub const fn new(format: BodyFormat) -> Self {
        Self { body_format: format.code() }
    }

    /// A response with a code of four bits, of which 5-15 are reserved; `None` for more than 15.
    #[must_use]
    pub const fn from_code(code: u8) -> Option<Self> {
        if code <= CODE_MAX { Some(Self { body_format: code }) } else { None }
    }

    /// The code of the body format, 0-15.
    #[must_use]
    pub const fn code(self) -> u8 {
        self.body_format
    }

    /// The body format; `None` for the reserved codes.
    #[must_use]
    pub const fn body_format(self) -> Option<BodyFormat> {
        BodyFormat::from_code(self.body_format)
    }
}

/// The service data of Release_Master/Slave_Connection_Set: the release choice, whose bits 6 and 7 are reserved.
///
/// At least one product manual prints a Release with bit 6 set, so it is read like any other value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ReleaseRequest {
    /// The connections to release.
    pub choice: AllocationChoice,
}

impl<'a> Wire<'a> for AllocateRequest {
    const NAME: &'static str = "Allocate request";

    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        let choice = AllocationChoice::from_bits_retain(reader.u8("allocation choice")?);
        Ok(Self { choice, allocator: reader.u8("allocator MAC ID")? })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.bytes(&[self.choice.bits(), self.allocator])
    }

    fn wire_len(&self) -> usize {
        2
    }
}

impl<'a> Wire<'a> for AllocateResponse {
    const NAME: &'static str = "Allocate response";

    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        let offset = reader.offset();
        let code = reader.u8("body format")?;
        Self::from_code(code).ok_or(ParseError::value("body format", offset, code.into()))
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u8(self.body_format)
    }

    fn wire_len(&self) -> usize {
        1
    }
}

impl<'a> Wire<'a> for ReleaseRequest {
    const NAME: &'static str = "Release request";

    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        Ok(Self { choice: AllocationChoice::from_bits_retain(reader.u8("release choice")?) })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u8(self.choice.bits())
    }

    fn wire_len(&self) -> usize {
        1
    }
}

const CODE_MAX: u8 = 0x0F;
const CHOICES: [(AllocationChoice, &str); 7] = [
    (AllocationChoice::EXPLICIT, "explicit"),
    (AllocationChoice::POLL, "poll"),
    (AllocationChoice::BIT_STROBE, "bit-strobe"),
    (AllocationChoice::MULTICAST_POLL, "multicast poll"),
    (AllocationChoice::CHANGE_OF_STATE, "change of state"),
    (AllocationChoice::CYCLIC, "cyclic"),
    (AllocationChoice::ACK_SUPPRESSION, "acknowledge suppression"),
];
