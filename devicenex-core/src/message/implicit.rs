//! Implicit (I/O) messages of more than eight bytes.

use cip_core::codec::{Full, ParseError, Reader, Tail, Wire, Writer};
use cip_core::fragment::{FragmentByte, FragmentKind, IO_FRAGMENT_LEN};

use super::fields::rest;

/// A fragment of an implicit message on a connection whose configured size is above eight bytes, as in DeviceNet **\[D\]**.
/// Nothing on the wire says so. A message of up to eight bytes is the data of one frame, without any header.
///
/// | Byte | Content |
/// |---|---|
/// | 0 | bits 7-6 type: 00 first, 01 middle, 10 last; bits 5-0 count, 0x3F in a first fragment that is the only one |
/// | 1-7 | a part of the data, 0 to 7 bytes |
///
/// Never acknowledged; an acknowledge type is refused.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ImplicitFragment<'a> {
    /// First, middle or last, and its count; not an acknowledge.
    pub fragment: FragmentByte,
    /// The part, at most seven bytes.
    pub data: &'a [u8],
}

impl<'a> Wire<'a> for ImplicitFragment<'a> {
    const NAME: &'static str = "implicit fragment";
    const TAIL: Tail = Tail::Open;

    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        let offset = reader.offset();
        let byte = reader.u8("fragmentation byte")?;
        let fragment = FragmentByte::from(byte);
        if fragment.kind == FragmentKind::Acknowledge {
            return Err(ParseError::value("fragment type", offset, byte.into()));
        }
        Ok(Self { fragment, data: rest(reader, IO_FRAGMENT_LEN, Self::NAME)? })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u8(self.fragment.into())?;
        out.bytes(self.data)
    }

    fn wire_len(&self) -> usize {
        self.data.len().saturating_add(1)
    }
}
