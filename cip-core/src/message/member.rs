//! Bodies of the member services: Get_Member, Set_Member, Insert_Member, Remove_Member.

use crate::codec::{Full, ParseError, Reader, Tail, Wire, Writer};

/// The service data of a member service in formats 0-3.
///
/// | Byte | Content |
/// |---|---|
/// | 0 | attribute |
/// | 1-2 | member |
/// | 3.. | the value, for Set_Member and Insert_Member |
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MemberRequest<'a> {
    /// The attribute, at most 255.
    pub attribute: u8,
    /// The member.
    pub member: u16,
    /// The value.
    pub value: &'a [u8],
}

impl<'a> Wire<'a> for MemberRequest<'a> {
    const NAME: &'static str = "member service request";
    const TAIL: Tail = Tail::Open;

    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        Ok(Self { attribute: reader.u8("attribute")?, member: reader.u16("member")?, value: reader.rest() })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u8(self.attribute)?;
        out.u16(self.member)?;
        out.bytes(self.value)
    }

    fn wire_len(&self) -> usize {
        self.value.len().saturating_add(3)
    }
}

/// The service data of the response to Insert_Member: the member that was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MemberId(pub u16);

impl<'a> Wire<'a> for MemberId {
    const NAME: &'static str = "Insert_Member response";

    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        Ok(Self(reader.u16("member")?))
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u16(self.0)
    }

    fn wire_len(&self) -> usize {
        2
    }
}
