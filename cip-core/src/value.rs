//! Attribute values in words.

use core::fmt;

use crate::code::{AttributeId, ClassId, DataTypeCode, DeviceType, InstanceId, VendorId};
use crate::codec::{Reader, Wire};
use crate::connection::{
    CommCharacteristics, ConnectionState, InstanceType, TimeoutMultiplier, TransportClassTrigger,
    WatchdogAction,
};
use crate::identity::{DeviceState, IdentityStatus, Revision};
use crate::message::{AllocationChoice, UintList};
use crate::names::{AttributeInfo, Shape, attribute_info};
use crate::parameter::{ParameterClassDescriptor, ParameterDescriptor};
use crate::text::{Hex, write_decimal, write_hex16};

/// The value of an attribute with what is needed to print it in words. With `#` the name of the attribute stands in
/// front. What is not known, or does not have the form it should have, is printed as hexadecimal bytes.
///
/// ```
/// use cip_core::code::{AttributeId, ClassId, InstanceId};
/// use cip_core::value::AttributeValue;
///
/// let value = |class, instance, attribute, data| AttributeValue {
///     class,
///     instance: InstanceId(instance),
///     attribute: AttributeId(attribute),
///     data,
/// };
/// assert_eq!(value(ClassId::CONNECTION, 2, 9, &[75, 0]).to_string(), "75 ms");
/// assert_eq!(value(ClassId::CONNECTION, 2, 1, &[3]).to_string(), "Established");
/// assert_eq!(value(ClassId::IDENTITY, 1, 1, &[12, 0]).to_string(), "12 (Banner Engineering)");
/// assert_eq!(format!("{:#}", value(ClassId::IDENTITY, 1, 4, &[1, 2])), "Revision 1.2");
/// assert_eq!(value(ClassId::IDENTITY, 1, 4, &[1, 2, 3]).to_string(), "01 02 03");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AttributeValue<'a> {
    /// The class.
    pub class: ClassId,
    /// The instance.
    pub instance: InstanceId,
    /// The attribute.
    pub attribute: AttributeId,
    /// The bytes.
    pub data: &'a [u8],
}

impl AttributeValue<'_> {
    /// Writes the name of the attribute, or its number.
    pub(crate) fn write_name(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.info() {
            Some(info) => f.write_str(info.name),
            None => fmt::Display::fmt(&self.attribute, f),
        }
    }

    /// Writes the value alone.
    pub(crate) fn write_value(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shape = self.info().map_or(Shape::Bytes, |info| info.shape);
        fmt::Display::fmt(&ShapedValue { shape, data: self.data }, f)
    }

    fn info(&self) -> Option<&'static AttributeInfo> {
        attribute_info(self.class, self.instance, self.attribute)
    }
}

impl fmt::Display for AttributeValue<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if f.alternate() {
            self.write_name(f)?;
            f.write_str(" ")?;
        }
        self.write_value(f)
    }
}

/// Bytes of a known shape, printed in words, or in hexadecimal if they do not have it.
///
/// ```
/// use cip_core::names::Shape;
/// use cip_core::value::ShapedValue;
///
/// let id = |data| ShapedValue { shape: Shape::WideConnectionId, data }.to_string();
/// assert_eq!(id(&[0x07, 0x00, 0x86, 0x82]), "0x02860007");
/// assert_eq!(id(&[0xA5, 0x03, 0x00, 0x00]), "0x3A5");
/// assert_eq!(id(&[0xFF; 4]), "none");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ShapedValue<'a> {
    /// What the bytes should be.
    pub shape: Shape,
    /// The bytes.
    pub data: &'a [u8],
}

impl fmt::Display for ShapedValue<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_shaped(f, self.shape, self.data).unwrap_or_else(|| write_bytes(f, self.data))
    }
}

/// `None` if the bytes do not have the shape; nothing has been written then.
fn write_shaped(f: &mut fmt::Formatter<'_>, shape: Shape, data: &[u8]) -> Option<fmt::Result> {
    Some(match shape {
        Shape::Data(ty) => {
            let mut reader = Reader::new(data);
            let value = ty.read(&mut reader).ok().filter(|_| reader.is_empty())?;
            fmt::Display::fmt(&value, f)
        }
        Shape::MacId => write_decimal(f, byte(data)?.into()),
        Shape::BaudRate => match byte(data)? {
            0 => f.write_str("125 kbit/s"),
            1 => f.write_str("250 kbit/s"),
            2 => f.write_str("500 kbit/s"),
            other => write_number(f, other.into(), " (reserved)"),
        },
        Shape::Milliseconds => write_number(f, uint(data)?, " ms"),
        Shape::Seconds => write_number(f, byte(data)?.into(), " s"),
        Shape::VendorId => write_named(f, uint(data)?, VendorId(uint(data)?).name()),
        Shape::DeviceType => write_named(f, uint(data)?, DeviceType(uint(data)?).name()),
        Shape::Revision => fmt::Display::fmt(&Revision::parse(data).ok()?, f),
        Shape::IdentityStatus => fmt::Display::fmt(&IdentityStatus::from_bits_retain(uint(data)?), f),
        Shape::DeviceState => fmt::Display::fmt(&DeviceState(byte(data)?), f),
        Shape::ConnectionState => fmt::Display::fmt(&ConnectionState(byte(data)?), f),
        Shape::InstanceType => fmt::Display::fmt(&InstanceType(byte(data)?), f),
        Shape::TransportClassTrigger => fmt::Display::fmt(&TransportClassTrigger(byte(data)?), f),
        Shape::CommCharacteristics => fmt::Display::fmt(&CommCharacteristics(byte(data)?), f),
        Shape::ConnectionId => write_connection_id(f, uint(data)?),
        Shape::WideConnectionId => write_wide_connection_id(f, udint(data)?),
        Shape::WatchdogAction => fmt::Display::fmt(&WatchdogAction(byte(data)?), f),
        Shape::TimeoutMultiplier => fmt::Display::fmt(&TimeoutMultiplier(byte(data)?), f),
        Shape::AllocationInformation => write_allocation(f, <[u8; 2]>::try_from(data).ok()?),
        Shape::DiagnosticCounters => write_counters(f, <&[u8; 34]>::try_from(data).ok()?),
        Shape::ActiveNodes => write_nodes(f, u64::from_le_bytes(data.try_into().ok()?)),
        Shape::DataTypeCode => fmt::Display::fmt(&DataTypeCode(byte(data)?), f),
        Shape::ParameterDescriptor => {
            fmt::Display::fmt(&ParameterDescriptor::from_bits_retain(uint(data)?), f)
        }
        Shape::ParameterClassDescriptor => {
            fmt::Display::fmt(&ParameterClassDescriptor::from_bits_retain(uint(data)?), f)
        }
        Shape::UintList => fmt::Display::fmt(&UintList::parse(data).ok()?, f),
        Shape::Bytes => write_bytes(f, data),
    })
}

fn byte(data: &[u8]) -> Option<u8> {
    match data {
        [byte] => Some(*byte),
        _ => None,
    }
}

fn uint(data: &[u8]) -> Option<u16> {
    data.try_into().ok().map(u16::from_le_bytes)
}

fn udint(data: &[u8]) -> Option<u32> {
    data.try_into().ok().map(u32::from_le_bytes)
}

fn write_bytes(f: &mut fmt::Formatter<'_>, data: &[u8]) -> fmt::Result {
    if data.is_empty() {
        return f.write_str("no data");
    }
    fmt::Display::fmt(&Hex(data), f)
}

fn write_number(f: &mut fmt::Formatter<'_>, number: u16, unit: &str) -> fmt::Result {
    write_decimal(f, number.into())?;
    f.write_str(unit)
}

/// `12 (Banner Engineering)`
fn write_named(f: &mut fmt::Formatter<'_>, number: u16, name: Option<&str>) -> fmt::Result {
    write_decimal(f, number.into())?;
    let Some(name) = name else { return Ok(()) };
    f.write_str(" (")?;
    f.write_str(name)?;
    f.write_str(")")
}

fn write_connection_id(f: &mut fmt::Formatter<'_>, id: u16) -> fmt::Result {
    if id == NO_CONNECTION_ID {
        return f.write_str("none");
    }
    f.write_str("0x")?;
    write_hex16(f, id)
}

/// `0x3A5`, `0x1D860209`: as many digits as the identifier has.
fn write_wide_connection_id(f: &mut fmt::Formatter<'_>, id: u32) -> fmt::Result {
    if id == u32::MAX {
        return f.write_str("none");
    }
    match id & EXTENDED {
        0 => write!(f, "0x{id:03X}"),
        _ => write!(f, "0x{:08X}", id & !EXTENDED),
    }
}

/// `explicit + poll, master 4`
fn write_allocation(f: &mut fmt::Formatter<'_>, [choice, master]: [u8; 2]) -> fmt::Result {
    fmt::Display::fmt(&AllocationChoice::from_bits_retain(choice), f)?;
    if master == NOT_ALLOCATED {
        return f.write_str(", no master");
    }
    f.write_str(", master ")?;
    write_decimal(f, master.into())
}

/// The counters that are not zero.
fn write_counters(f: &mut fmt::Formatter<'_>, data: &[u8; 34]) -> fmt::Result {
    let mut words = data.as_chunks::<2>().0.iter().map(|&word| u16::from_le_bytes(word));
    f.write_str("descriptor 0x")?;
    write_hex16(f, words.next().unwrap_or_default())?;
    for (name, count) in COUNTERS.into_iter().zip(words).filter(|&(_, count)| count != 0) {
        f.write_str(", ")?;
        f.write_str(name)?;
        f.write_str(" ")?;
        write_decimal(f, count.into())?;
    }
    Ok(())
}

/// `nodes 1, 5, 63`
fn write_nodes(f: &mut fmt::Formatter<'_>, nodes: u64) -> fmt::Result {
    if nodes == 0 {
        return f.write_str("no nodes");
    }
    let mut separator = "nodes ";
    for node in (0..64_u8).filter(|&node| nodes.unbounded_shr(node.into()) & 1 == 1) {
        f.write_str(separator)?;
        write_decimal(f, node.into())?;
        separator = ", ";
    }
    Ok(())
}

const NO_CONNECTION_ID: u16 = 0xFFFF;
/// A connection ID of 29 bits.
const EXTENDED: u32 = 0x8000_0000;
const NOT_ALLOCATED: u8 = 0xFF;
const COUNTERS: [&str; 16] = [
    "arbitration loss",
    "overload",
    "bit error",
    "stuff error",
    "ack error",
    "form error",
    "CRC error",
    "receive message loss",
    "warning",
    "receive error",
    "transmit error",
    "reserved 12",
    "reserved 13",
    "reserved 14",
    "reserved 15",
    "reserved 16",
];

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::{collection::vec, prelude::*};
    use std::format;
    use std::string::{String, ToString};

    fn text(class: ClassId, instance: u16, attribute: u16, data: &[u8]) -> String {
        let (instance, attribute) = (InstanceId(instance), AttributeId(attribute));
        AttributeValue { class, instance, attribute, data }.to_string()
    }

    #[test]
    fn values_with_a_meaning() {
        let cases: [(ClassId, u16, u16, &[u8], &str); 22] = [
            // Values from the Konvolucio.DeviceNet and IAI captures.
            (ClassId::IDENTITY, 1, 3, &[0x6C, 0x05], "1388"),
            (ClassId::IDENTITY, 1, 7, b"\x08GRT1-DRT", "\"GRT1-DRT\""),
            (ClassId::IDENTITY, 1, 1, &[0x6C, 0x00], "108 (Beckhoff)"),
            (ClassId::IDENTITY, 1, 2, &[0, 0], "0 (Generic device)"),
            (ClassId::CONNECTION, 2, 9, &[0x4B, 0x00], "75 ms"),
            (ClassId::CONNECTION, 2, 7, &[0x20, 0x00], "32"),
            (ClassId::CONNECTION, 1, 12, &[3], "Deferred delete"),
            // The others are built from the tables.
            (ClassId::CONNECTION, 2, 4, &[0xFF, 0xFF], "none"),
            (ClassId::CONNECTION, 2, 4, &[0xE5, 0x03], "0x03E5"),
            (
                ClassId::CONNECTION,
                2,
                14,
                &[0x20, 0x04, 0x24, 0x65, 0x30, 0x03],
                "class 4 instance 101 attribute 3",
            ),
            (ClassId::CONNECTION, 2, 1, &[9], "connection state 9"),
            (ClassId::DEVICENET, 1, 2, &[2], "500 kbit/s"),
            (ClassId::DEVICENET, 1, 5, &[0x03, 0x04], "explicit + poll, master 4"),
            (ClassId::DEVICENET, 1, 5, &[0x00, 0xFF], "nothing, no master"),
            (ClassId::DEVICENET, 1, 13, &[0x22, 0, 0, 0, 0, 0, 0, 0x80], "nodes 1, 5, 63"),
            (ClassId::MESSAGE_ROUTER, 1, 1, &[2, 0, 1, 0, 3, 0], "[1, 3]"),
            (ClassId::PARAMETER, 1, 5, &[0xC7], "UINT"),
            (ClassId::PARAMETER, 1, 4, &[0x10, 0x00], "0x0010 (read only)"),
            (ClassId::PARAMETER, 0, 8, &[0x01, 0x00], "0x0001 (instances)"),
            (ClassId::PARAMETER, 1, 22, &[], "\"\""),
            (ClassId::DEVICENET, 0, 1, &[2, 0], "2"),
            (ClassId(0x64), 1, 1, &[0x01, 0x46, 0x00], "01 46 00"),
        ];
        for (class, instance, attribute, data, expected) in cases {
            assert_eq!(text(class, instance, attribute, data), expected, "{class} {instance} {attribute}");
        }
    }

    #[test]
    fn counters_that_count() {
        let mut data = [0; 34];
        data[0] = 0x07;
        data[6] = 3;
        let expected = "descriptor 0x0007, bit error 3";
        assert_eq!(text(ClassId::DEVICENET, 1, 12, &data), expected);
    }

    proptest! {
        /// Whatever the bytes, the text is either typed or all of the bytes.
        #[test]
        fn nothing_is_lost(class in prop::sample::select(ClassId::NAMED), instance in 0..3_u16, attribute in 0..30_u16, data in vec(any::<u8>(), 0..12)) {
            let printed = text(class, instance, attribute, &data);
            prop_assert!(!printed.is_empty());
            let info = attribute_info(class, InstanceId(instance), AttributeId(attribute));
            if info.is_none_or(|info| info.shape.size().is_some_and(|size| size != data.len())) && !data.is_empty() {
                prop_assert_eq!(printed, format!("{}", Hex(&data)));
            }
        }
    }
}
