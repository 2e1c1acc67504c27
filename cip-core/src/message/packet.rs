//! Multiple_Service_Packet: several requests, or their responses, in one.

use super::ListError;
use super::list::whole;
use crate::codec::{Full, ParseError, Reader, Tail, Wire, Writer};

/// The service data of Multiple_Service_Packet, request and response alike.
///
/// | Byte | Content |
/// |---|---|
/// | 0-1 | number of services n |
/// | 2.. | n 16-bit offsets, from byte 0 |
/// | then | the services, without gaps |
///
/// A parsed packet has offsets that ascend and lie inside of it.
///
/// ```
/// use cip_core::codec::Wire;
/// use cip_core::message::MultipleServicePacket;
///
/// let packet = MultipleServicePacket::parse(&[2, 0, 6, 0, 8, 0, 0x8E, 0x01, 0x8E, 0x02, 0x03])?;
/// assert!(packet.services().eq([&[0x8E, 0x01][..], &[0x8E, 0x02, 0x03]]));
/// # Ok::<(), cip_core::codec::ParseError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MultipleServicePacket<'a> {
    bytes: &'a [u8],
    offsets: &'a [u8],
}

impl<'a> MultipleServicePacket<'a> {
    /// The services, each from its service byte on.
    pub fn services(&self) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        let bytes = self.bytes;
        let starts = offsets(self.offsets);
        let ends = starts.clone().skip(1).chain([bytes.len()]);
        starts.zip(ends).map(move |(start, end)| bytes.get(start..end).unwrap_or_default())
    }
}

impl<'a> Wire<'a> for MultipleServicePacket<'a> {
    const NAME: &'static str = "Multiple_Service_Packet";
    const TAIL: Tail = Tail::Open;

    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        let bytes = reader.peek();
        let count = usize::from(reader.u16("number of services")?);
        let offset_of_offsets = reader.offset();
        let table = reader.bytes(count.saturating_mul(2), "offsets")?;
        let mut least = table.len().saturating_add(2);
        for (index, offset) in offsets(table).enumerate() {
            if offset < least || offset > bytes.len() || (index == 0 && offset != least) {
                let at = offset_of_offsets.saturating_add(index.saturating_mul(2));
                return Err(ParseError::value("offset", at, u32::try_from(offset).unwrap_or(u32::MAX)));
            }
            least = offset;
        }
        if table.is_empty() {
            return Ok(Self { bytes: bytes.get(..2).unwrap_or_default(), offsets: table });
        }
        reader.rest();
        Ok(Self { bytes, offsets: table })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.bytes(self.bytes)
    }

    fn wire_len(&self) -> usize {
        self.bytes.len()
    }
}

/// Writes `services` as the data of a Multiple_Service_Packet.
pub fn emit_packets(services: &[&[u8]], out: &mut Writer<'_>) -> Result<(), ListError> {
    let count = u16::try_from(services.len()).map_err(|_| ListError::TooLong)?;
    let mut offset = services.len().saturating_mul(2).saturating_add(2);
    whole(out, |out| {
        out.u16(count)?;
        for service in services {
            out.u16(u16::try_from(offset).map_err(|_| ListError::TooLong)?)?;
            offset = offset.saturating_add(service.len());
        }
        services.iter().try_for_each(|service| Ok(out.bytes(service)?))
    })
}

fn offsets(table: &[u8]) -> impl Iterator<Item = usize> + Clone {
    table.as_chunks::<2>().0.iter().map(|&bytes| usize::from(u16::from_le_bytes(bytes)))
}
