//! Lists: attribute IDs, instances, statuses, values.

use core::fmt;

use crate::code::{AttributeId, GeneralStatus, InstanceId};
use crate::codec::{Full, ParseError, Reader, Tail, Wire, Writer};
use crate::text::write_decimal;

/// Why a list could not be written. Nothing of it is left in the buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum ListError {
    /// The buffer is too small.
    #[error(transparent)]
    Full(#[from] Full),
    /// There are more items than the count has numbers for, or more bytes than an offset reaches.
    #[error("the list is too long for its count or its offsets")]
    TooLong,
    /// A reply without a value whose status is success: its reader would look for the value.
    #[error("{0}: a reply without a value needs a status other than success")]
    NoValue(AttributeId),
}

/// A 16-bit count and as many 16-bit numbers: the request of Get_Attribute_List, and attributes such as the object
/// list of the Message Router.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct UintList<'a> {
    items: &'a [u8],
}

impl<'a> UintList<'a> {
    /// The numbers.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = u16> + use<'a> {
        self.items.as_chunks::<2>().0.iter().map(|&bytes| u16::from_le_bytes(bytes))
    }

    /// The numbers as attributes.
    pub fn attributes(&self) -> impl ExactSizeIterator<Item = AttributeId> + use<'a> {
        self.iter().map(AttributeId)
    }

    /// Writes a list of `numbers`.
    pub fn emit_numbers(numbers: &[u16], out: &mut Writer<'_>) -> Result<(), ListError> {
        counted(numbers, out, |out, &number| Ok(out.u16(number)?))
    }
}

impl<'a> Wire<'a> for UintList<'a> {
    const NAME: &'static str = "list of UINT";

    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        let count = usize::from(reader.u16("count")?);
        Ok(Self { items: reader.bytes(count.saturating_mul(2), "list")? })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u16(u16::try_from(self.items.len() / 2).map_err(|_| Full)?)?;
        out.bytes(self.items)
    }

    fn wire_len(&self) -> usize {
        self.items.len().saturating_add(2)
    }
}

impl fmt::Display for UintList<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("[")?;
        for (index, number) in self.iter().enumerate() {
            if index != 0 {
                f.write_str(", ")?;
            }
            write_decimal(f, number.into())?;
        }
        f.write_str("]")
    }
}

/// The response of Find_Next_Object_Instance: an 8-bit count and as many 16-bit instances.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct InstanceList<'a> {
    items: &'a [u8],
}

impl<'a> InstanceList<'a> {
    /// The instances.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = InstanceId> + use<'a> {
        self.items.as_chunks::<2>().0.iter().map(|&bytes| InstanceId(u16::from_le_bytes(bytes)))
    }

    /// Writes a list of `instances`, at most 255.
    pub fn emit_instances(instances: &[InstanceId], out: &mut Writer<'_>) -> Result<(), ListError> {
        let count = u8::try_from(instances.len()).map_err(|_| ListError::TooLong)?;
        whole(out, |out| {
            out.u8(count)?;
            instances.iter().try_for_each(|instance| Ok(out.u16(instance.0)?))
        })
    }
}

impl<'a> Wire<'a> for InstanceList<'a> {
    const NAME: &'static str = "Find_Next_Object_Instance response";

    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        let count = usize::from(reader.u8("count")?);
        Ok(Self { items: reader.bytes(count.saturating_mul(2), "instances")? })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u8(u8::try_from(self.items.len() / 2).map_err(|_| Full)?)?;
        out.bytes(self.items)
    }

    fn wire_len(&self) -> usize {
        self.items.len().saturating_add(1)
    }
}

/// The response of Set_Attribute_List: a 16-bit count, then for each attribute its 16-bit ID and a 16-bit status.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AttributeStatusList<'a> {
    items: &'a [u8],
}

impl<'a> AttributeStatusList<'a> {
    /// The attributes and their statuses, as they were sent: 0 is success, and none above 255 exists.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (AttributeId, u16)> + use<'a> {
        self.items.as_chunks::<4>().0.iter().map(|&[id_low, id_high, low, high]| {
            (AttributeId(u16::from_le_bytes([id_low, id_high])), u16::from_le_bytes([low, high]))
        })
    }

    /// Writes a list of `statuses`.
    pub fn emit_statuses(
        statuses: &[(AttributeId, GeneralStatus)],
        out: &mut Writer<'_>,
    ) -> Result<(), ListError> {
        counted(statuses, out, |out, (attribute, status)| {
            out.u16(attribute.0)?;
            Ok(out.u16(status.0.into())?)
        })
    }
}

impl<'a> Wire<'a> for AttributeStatusList<'a> {
    const NAME: &'static str = "Set_Attribute_List response";

    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        let count = usize::from(reader.u16("count")?);
        Ok(Self { items: reader.bytes(count.saturating_mul(4), "statuses")? })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u16(u16::try_from(self.items.len() / 4).map_err(|_| Full)?)?;
        out.bytes(self.items)
    }

    fn wire_len(&self) -> usize {
        self.items.len().saturating_add(2)
    }
}

/// The response of Get_Attribute_List: a 16-bit count, then for each attribute its 16-bit ID, a 16-bit status and, if
/// that is 0, the value. The bytes do not tell how long a value is: the reader must know the attributes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AttributeReplies<'a> {
    count: u16,
    items: &'a [u8],
}

/// One attribute in the response of Get_Attribute_List.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AttributeReply<'a> {
    /// The attribute.
    pub attribute: AttributeId,
    /// The value, or why there is none: never [`GeneralStatus::SUCCESS`].
    pub value: Result<&'a [u8], GeneralStatus>,
}

impl<'a> AttributeReplies<'a> {
    /// The number of attributes.
    pub const fn count(&self) -> u16 {
        self.count
    }

    /// The attributes in their order. `len` tells how many bytes the value of an attribute takes, given the bytes that
    /// start with it; `None` ends the list with an error.
    pub fn iter(
        &self,
        len: impl Fn(AttributeId, &'a [u8]) -> Option<usize>,
    ) -> impl Iterator<Item = Result<AttributeReply<'a>, ParseError>> {
        entries(self.count, self.items, move |reader| {
            let attribute = AttributeId(reader.u16("attribute")?);
            let offset = reader.offset();
            let status = reader.u16("status")?;
            let value = match u8::try_from(status) {
                Ok(0) => Ok(read_value(reader, attribute, &len)?),
                Ok(refused) => Err(GeneralStatus(refused)),
                // Neither a success nor a status that exists: a value that is not there must not be read.
                Err(_) => return Err(ParseError::value("status", offset, status.into())),
            };
            Ok(AttributeReply { attribute, value })
        })
    }

    /// Writes a list of `replies`: of each a status, and the value or none.
    pub fn emit_replies(replies: &[AttributeReply<'_>], out: &mut Writer<'_>) -> Result<(), ListError> {
        counted(replies, out, |out, reply| {
            let (status, value) = match reply.value {
                Ok(value) => (GeneralStatus::SUCCESS, value),
                Err(GeneralStatus::SUCCESS) => return Err(ListError::NoValue(reply.attribute)),
                Err(status) => (status, &[][..]),
            };
            out.u16(reply.attribute.0)?;
            out.u16(status.0.into())?;
            Ok(out.bytes(value)?)
        })
    }
}

impl<'a> Wire<'a> for AttributeReplies<'a> {
    const NAME: &'static str = "Get_Attribute_List response";
    const TAIL: Tail = Tail::Open;

    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        Ok(Self { count: reader.u16("count")?, items: reader.rest() })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u16(self.count)?;
        out.bytes(self.items)
    }

    fn wire_len(&self) -> usize {
        self.items.len().saturating_add(2)
    }
}

/// The request of Set_Attribute_List: a 16-bit count, then for each attribute its 16-bit ID and the value. The bytes do
/// not tell how long a value is: the reader must know the attributes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AttributeSettings<'a> {
    count: u16,
    items: &'a [u8],
}

impl<'a> AttributeSettings<'a> {
    /// The number of attributes.
    pub const fn count(&self) -> u16 {
        self.count
    }

    /// The attributes and their values in their order. `len` tells how many bytes a value takes, as in
    /// [`AttributeReplies::iter`].
    pub fn iter(
        &self,
        len: impl Fn(AttributeId, &'a [u8]) -> Option<usize>,
    ) -> impl Iterator<Item = Result<(AttributeId, &'a [u8]), ParseError>> {
        entries(self.count, self.items, move |reader| {
            let attribute = AttributeId(reader.u16("attribute")?);
            Ok((attribute, read_value(reader, attribute, &len)?))
        })
    }

    /// Writes a list of `settings`.
    pub fn emit_settings(settings: &[(AttributeId, &[u8])], out: &mut Writer<'_>) -> Result<(), ListError> {
        counted(settings, out, |out, (attribute, value)| {
            out.u16(attribute.0)?;
            Ok(out.bytes(value)?)
        })
    }
}

impl<'a> Wire<'a> for AttributeSettings<'a> {
    const NAME: &'static str = "Set_Attribute_List request";
    const TAIL: Tail = Tail::Open;

    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        Ok(Self { count: reader.u16("count")?, items: reader.rest() })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u16(self.count)?;
        out.bytes(self.items)
    }

    fn wire_len(&self) -> usize {
        self.items.len().saturating_add(2)
    }
}

/// Writes a 16-bit count and the items, or nothing.
fn counted<T>(
    items: &[T],
    out: &mut Writer<'_>,
    mut item: impl FnMut(&mut Writer<'_>, &T) -> Result<(), ListError>,
) -> Result<(), ListError> {
    let count = u16::try_from(items.len()).map_err(|_| ListError::TooLong)?;
    whole(out, |out| {
        out.u16(count)?;
        items.iter().try_for_each(|each| item(out, each))
    })
}

/// Writes all of it, or nothing.
pub(super) fn whole(
    out: &mut Writer<'_>,
    write: impl FnOnce(&mut Writer<'_>) -> Result<(), ListError>,
) -> Result<(), ListError> {
    let start = out.len();
    let result = write(out);
    if result.is_err() {
        out.truncate(start);
    }
    result
}

/// `count` entries of a list, each read by `read`; an error ends the list, and so do bytes after it.
fn entries<'a, T>(
    count: u16,
    items: &'a [u8],
    read: impl Fn(&mut Reader<'a>) -> Result<T, ParseError>,
) -> impl Iterator<Item = Result<T, ParseError>> {
    let mut reader = Reader::new(items);
    let mut left = Some(count);
    core::iter::from_fn(move || match left? {
        0 => {
            left = None;
            reader.finish("list").err().map(Err)
        }
        more => {
            let entry = read(&mut reader);
            left = entry.is_ok().then(|| more.saturating_sub(1));
            Some(entry)
        }
    })
}

fn read_value<'a>(
    reader: &mut Reader<'a>,
    attribute: AttributeId,
    len: &impl Fn(AttributeId, &'a [u8]) -> Option<usize>,
) -> Result<&'a [u8], ParseError> {
    let offset = reader.offset();
    let len = len(attribute, reader.peek());
    let len = len.ok_or(ParseError::value("attribute of unknown length", offset, attribute.0.into()))?;
    reader.bytes(len, "value")
}
