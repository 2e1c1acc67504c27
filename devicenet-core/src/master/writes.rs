//! Attribute writes: a slave's configuration, sent before its I/O starts, and again after it was replaced.

use cip_core::code::{AttributeId, ClassId, InstanceId};
use cip_core::codec::{Full, ParseError, Reader, Writer};

/// A Set_Attribute_Single of the configuration.
///
/// | Byte | Content |
/// |---|---|
/// | 0-1 | class, little-endian |
/// | 2-3 | instance, little-endian |
/// | 4-5 | attribute, little-endian |
/// | 6 | length of the value |
/// | 7.. | the value |
///
/// This is how the master stores it; on the wire it is a request in the body format of the connection.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AttributeWrite<'a> {
    /// The class.
    pub class: ClassId,
    /// The instance.
    pub instance: InstanceId,
    /// The attribute.
    pub attribute: AttributeId,
    /// The value, at most 255 bytes.
    pub value: &'a [u8],
}

impl<'a> AttributeWrite<'a> {
    pub(super) fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        let class = ClassId(reader.u16("class")?);
        let instance = InstanceId(reader.u16("instance")?);
        let attribute = AttributeId(reader.u16("attribute")?);
        let len = reader.u8("length of the value")?;
        Ok(Self { class, instance, attribute, value: reader.bytes(len.into(), "value")? })
    }

    pub(super) fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u16(self.class.0)?;
        out.u16(self.instance.0)?;
        out.u16(self.attribute.0)?;
        out.u8(u8::try_from(self.value.len()).map_err(|_| Full)?)?;
        out.bytes(self.value)
    }
}
