//! Bodies of common services that have a fixed layout.

use crate::code::InstanceId;
use crate::codec::{Full, ParseError, Reader, Tail, Wire, Writer};

crate::code::codes! {
    /// What a Reset of the Identity object does.
    pub struct ResetType(u8), "reset type" in decimal {
        POWER_CYCLE = 0, "power cycle";
        OUT_OF_BOX = 1, "out-of-box configuration";
        OUT_OF_BOX_KEEP_COMMUNICATION = 2, "out-of-box configuration, communication parameters kept";
    }
}

impl ResetType {
    /// True for 100-199.
    pub const fn is_vendor_specific(self) -> bool {
        matches!(self.0, 100..=199)
    }
}

/// The service data of Reset: nothing, or one byte with the type.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ResetRequest {
    /// The type; none means a power cycle.
    pub kind: Option<ResetType>,
}

impl<'a> Wire<'a> for ResetRequest {
    const NAME: &'static str = "Reset request";
    const TAIL: Tail = Tail::Open;

    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        if reader.is_empty() {
            return Ok(Self { kind: None });
        }
        Ok(Self { kind: Some(ResetType(reader.u8("reset type")?)) })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        self.kind.map_or(Ok(()), |kind| out.u8(kind.0))
    }

    fn wire_len(&self) -> usize {
        usize::from(self.kind.is_some())
    }
}

/// The service data of Find_Next_Object_Instance. The search starts after the instance addressed; the response is an
/// [`InstanceList`](super::InstanceList).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FindNextRequest {
    /// The most instances to return.
    pub max: u8,
}

impl<'a> Wire<'a> for FindNextRequest {
    const NAME: &'static str = "Find_Next_Object_Instance request";

    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        Ok(Self { max: reader.u8("maximum of instances")? })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u8(self.max)
    }

    fn wire_len(&self) -> usize {
        1
    }
}

/// The service data of the response to Create: the new instance, then data of the object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CreateResponse<'a> {
    /// The instance created.
    pub instance: InstanceId,
    /// What the object adds.
    pub data: &'a [u8],
}

impl<'a> Wire<'a> for CreateResponse<'a> {
    const NAME: &'static str = "Create response";
    const TAIL: Tail = Tail::Open;

    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        Ok(Self { instance: InstanceId(reader.u16("instance")?), data: reader.rest() })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u16(self.instance.0)?;
        out.bytes(self.data)
    }

    fn wire_len(&self) -> usize {
        self.data.len().saturating_add(2)
    }
}
