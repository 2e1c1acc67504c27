//! Get_Attributes_All of the Identity object.

use super::{DeviceIdentity, DeviceState, IdentityStatus, ProductName, Revision};
use crate::code::{DeviceType, VendorId};
use crate::codec::{Full, ParseError, Reader, Tail, Wire, Writer};

/// The response data of Get_Attributes_All of the Identity object.
///
/// | Bytes | Attribute |
/// |---|---|
/// | 0-1 | 1 vendor |
/// | 2-3 | 2 device type |
/// | 4-5 | 3 product code |
/// | 6-7 | 4 revision |
/// | 8-9 | 5 status |
/// | 10-13 | 6 serial number |
/// | 14.. | 7 product name, SHORT_STRING |
/// | then | 8 state, one byte, optional |
/// | then | 9 configuration consistency value, two bytes, optional |
/// | then | 10 heartbeat interval in seconds, one byte, optional |
///
/// An optional attribute is present only if all before it are; a device that lacks one in between sends 0 for it, or
/// 255 for the state.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct IdentityAttributes {
    /// Attributes 1-4, 6 and 7.
    pub identity: DeviceIdentity,
    /// Attribute 5.
    pub status: IdentityStatus,
    /// Attributes 8-10.
    pub optional: OptionalAttributes,
}

/// Attributes 8-10, as far as they are there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum OptionalAttributes {
    /// None of them.
    None,
    /// Attribute 8.
    State(DeviceState),
    /// Attributes 8 and 9.
    Consistency(DeviceState, u16),
    /// Attributes 8, 9 and 10.
    Heartbeat(DeviceState, u16, u8),
}

impl<'a> Wire<'a> for IdentityAttributes {
    const NAME: &'static str = "Get_Attributes_All of the Identity object";
    const TAIL: Tail = Tail::Open;

    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        let vendor = VendorId(reader.u16("vendor")?);
        let device_type = DeviceType(reader.u16("device type")?);
        let product_code = reader.u16("product code")?;
        let revision = Revision::read(reader)?;
        let status = IdentityStatus::from_bits_retain(reader.u16("status")?);
        let serial = reader.u32("serial number")?;
        let name = ProductName::read(reader)?;
        let identity = DeviceIdentity { vendor, device_type, product_code, revision, serial, name };
        Ok(Self { identity, status, optional: OptionalAttributes::read(reader)? })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u16(self.identity.vendor.0)?;
        out.u16(self.identity.device_type.0)?;
        out.u16(self.identity.product_code)?;
        self.identity.revision.emit(out)?;
        out.u16(self.status.bits())?;
        out.u32(self.identity.serial)?;
        self.identity.name.emit(out)?;
        self.optional.emit(out)
    }

    fn wire_len(&self) -> usize {
        let optional: usize = match self.optional {
            OptionalAttributes::None => 0,
            OptionalAttributes::State(_) => 1,
            OptionalAttributes::Consistency(..) => 3,
            OptionalAttributes::Heartbeat(..) => 4,
        };
        self.identity.name.wire_len().saturating_add(14).saturating_add(optional)
    }
}

impl OptionalAttributes {
    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        if reader.is_empty() {
            return Ok(Self::None);
        }
        let state = DeviceState(reader.u8("state")?);
        if reader.is_empty() {
            return Ok(Self::State(state));
        }
        let consistency = reader.u16("configuration consistency value")?;
        if reader.is_empty() {
            return Ok(Self::Consistency(state, consistency));
        }
        Ok(Self::Heartbeat(state, consistency, reader.u8("heartbeat interval")?))
    }

    pub(crate) fn emit(self, out: &mut Writer<'_>) -> Result<(), Full> {
        match self {
            Self::None => Ok(()),
            Self::State(state) => out.u8(state.0),
            Self::Consistency(state, consistency) => {
                out.u8(state.0)?;
                out.u16(consistency)
            }
            Self::Heartbeat(state, consistency, interval) => {
                out.u8(state.0)?;
                out.u16(consistency)?;
                out.u8(interval)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::laws;
    use proptest::{collection::vec, prelude::*};

    /// Built from the values that an Omron GRT1-DRT answers one by one in the Konvolucio.DeviceNet logs (vendor 47,
    /// product code 0x056C, name GRT1-DRT); revision, status and serial number are made up.
    #[test]
    fn attributes_of_a_terminal() {
        let bytes = b"\x2F\x00\x0C\x00\x6C\x05\x01\x02\x01\x00\x04\x03\x02\x01\x08GRT1-DRT";
        let all = IdentityAttributes::parse(bytes).unwrap();
        assert_eq!(all.identity.vendor, VendorId::OMRON);
        assert_eq!(all.identity.name, ProductName::new("GRT1-DRT").unwrap());
        assert_eq!((all.status, all.optional), (IdentityStatus::OWNED, OptionalAttributes::None));
        let short = IdentityAttributes::parse(&bytes[..bytes.len() - 1]).unwrap_err();
        assert_eq!(short.field, "product name");
    }

    proptest! {
        #[test]
        fn accepted_bytes_survive(head in vec(any::<u8>(), 14), name in vec(any::<u8>(), 0..=32), tail in vec(any::<u8>(), 0..6)) {
            let len = [u8::try_from(name.len()).unwrap()];
            let bytes = [&head[..], &len, &name, &tail].concat();
            let accepted = laws::accepted_bytes_survive::<IdentityAttributes>(&bytes, &mut [0; 60]);
            prop_assert_eq!(accepted, matches!(tail.len(), 0 | 1 | 3 | 4));
        }
    }
}
