//! What the numbers of an object mean: its attributes, its services, its additional codes.
//!
//! One table serves the decoder, which prints names and typed values, and the objects of a device, which need to know
//! what may be read and written.
//!
//! ```
//! use cip_core::code::{AttributeId, ClassId, InstanceId, ServiceCode};
//! use cip_core::names;
//!
//! let name = names::attribute_name(ClassId::CONNECTION, InstanceId(2), AttributeId(9));
//! assert_eq!(name, Some("expected_packet_rate"));
//! let name = names::service_name(ClassId::DEVICENET, ServiceCode(0x4B));
//! assert_eq!(name, Some("Allocate_Master/Slave_Connection_Set"));
//! ```

mod application;
mod infrastructure;

use core::fmt;
use core::ops::RangeInclusive;

use crate::code::{AdditionalCode, AttributeId, ClassId, InstanceId, ServiceCode};
use crate::codec::{Reader, Wire};
use crate::data_type::DataType;
use crate::message::UintList;
use crate::text::write_decimal;

/// One attribute of a class or of its instances.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AttributeInfo {
    /// The number.
    pub id: AttributeId,
    /// The name, as the specification and the manuals spell it.
    pub name: &'static str,
    /// What the bytes mean.
    pub shape: Shape,
    /// What may be done with it at most; a device may allow less.
    pub access: Access,
}

/// What may be done with an attribute.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Access {
    /// Read.
    Get,
    /// Read and written.
    GetSet,
}

/// What the bytes of an attribute mean: an elementary type, or one with a meaning that is printed in words.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Shape {
    /// A plain value.
    Data(DataType),
    /// USINT, 0-63.
    MacId,
    /// USINT: 0 125 kbit/s, 1 250 kbit/s, 2 500 kbit/s.
    BaudRate,
    /// UINT, ms.
    Milliseconds,
    /// USINT, s.
    Seconds,
    /// UINT.
    VendorId,
    /// UINT.
    DeviceType,
    /// Two USINT.
    Revision,
    /// WORD.
    IdentityStatus,
    /// USINT.
    DeviceState,
    /// USINT.
    ConnectionState,
    /// USINT.
    InstanceType,
    /// BYTE.
    TransportClassTrigger,
    /// BYTE.
    CommCharacteristics,
    /// UINT, a CAN identifier; 0xFFFF: none.
    ConnectionId,
    /// UDINT, a CAN identifier, with bit 31 set if it has 29 bits; 0xFFFFFFFF: none.
    WideConnectionId,
    /// USINT.
    WatchdogAction,
    /// USINT.
    TimeoutMultiplier,
    /// BYTE allocation choice, USINT MAC ID of the master; 255: not allocated.
    AllocationInformation,
    /// WORD descriptor, then 16 UINT.
    DiagnosticCounters,
    /// LWORD, one bit for each MAC ID.
    ActiveNodes,
    /// USINT, the code of an elementary type.
    DataTypeCode,
    /// WORD.
    ParameterDescriptor,
    /// WORD.
    ParameterClassDescriptor,
    /// UINT count, then as many UINT.
    UintList,
    /// Bytes whose meaning is not fixed by the class.
    Bytes,
}

impl Shape {
    /// The elementary type underneath, if it is one.
    pub const fn data_type(self) -> Option<DataType> {
        Some(match self {
            Self::Data(ty) => ty,
            Self::MacId | Self::BaudRate | Self::Seconds | Self::DeviceState | Self::ConnectionState => {
                DataType::Usint
            }
            Self::InstanceType | Self::WatchdogAction | Self::TimeoutMultiplier | Self::DataTypeCode => {
                DataType::Usint
            }
            Self::Milliseconds | Self::VendorId | Self::DeviceType | Self::ConnectionId => DataType::Uint,
            Self::WideConnectionId => DataType::Udint,
            Self::TransportClassTrigger | Self::CommCharacteristics => DataType::Byte,
            Self::IdentityStatus | Self::ParameterDescriptor | Self::ParameterClassDescriptor => {
                DataType::Word
            }
            Self::ActiveNodes => DataType::Lword,
            Self::Revision | Self::AllocationInformation | Self::DiagnosticCounters => return None,
            Self::UintList | Self::Bytes => return None,
        })
    }

    /// The number of bytes, if all values have the same.
    pub const fn size(self) -> Option<usize> {
        if let Some(ty) = self.data_type() {
            return ty.size();
        }
        if matches!(self, Self::Revision | Self::AllocationInformation) {
            return Some(2);
        }
        if matches!(self, Self::DiagnosticCounters) { Some(34) } else { None }
    }

    /// The numbers that a value may be, without the reserved ones, in ascending ranges; none if it is not one whole number.
    ///
    /// ```
    /// use cip_core::names::Shape;
    ///
    /// let ranges: Vec<_> = Shape::MacId.numbers().collect();
    /// assert_eq!(ranges, [0..=63]);
    /// let ranges: Vec<_> = Shape::ConnectionId.numbers().collect();
    /// assert_eq!(ranges, [0..=0x7FF, 0xFFFF..=0xFFFF]);
    /// ```
    pub fn numbers(self) -> impl Iterator<Item = RangeInclusive<i128>> {
        let (ranges, also) = match self {
            Self::MacId => (Some(0..=63), None),
            Self::BaudRate => (Some(0..=2), None),
            Self::WatchdogAction => (Some(0..=3), None),
            Self::TimeoutMultiplier => (Some(0..=7), None),
            // Of 11 bits, and none.
            Self::ConnectionId => (Some(0..=0x7FF), Some(0xFFFF..=0xFFFF)),
            other => (other.data_type().and_then(DataType::numbers), None),
        };
        ranges.into_iter().chain(also)
    }

    /// The number of bytes that a value takes which `data` begin with; `None` if they do not tell it.
    ///
    /// ```
    /// use cip_core::data_type::DataType;
    /// use cip_core::names::Shape;
    ///
    /// assert_eq!(Shape::VendorId.value_len(&[0x34, 0x12, 0x07]), Some(2));
    /// assert_eq!(Shape::Data(DataType::ShortString).value_len(&[2, b'a', b'b', 0x07]), Some(3));
    /// assert_eq!(Shape::UintList.value_len(&[1, 0, 5, 0, 0x07]), Some(4));
    /// assert_eq!(Shape::Bytes.value_len(&[1]), None);
    /// ```
    pub fn value_len(self, data: &[u8]) -> Option<usize> {
        if let Some(size) = self.size() {
            return Some(size);
        }
        let mut reader = Reader::new(data);
        match self {
            Self::Data(ty) => ty.read(&mut reader).map(|_| ()).ok()?,
            Self::UintList => UintList::read(&mut reader).map(|_| ()).ok()?,
            _ => return None,
        }
        Some(reader.offset())
    }
}

/// The known attributes of a class (instance 0, without the common ones) or of its instances, in ascending order.
pub const fn attributes(class: ClassId, instance: InstanceId) -> &'static [AttributeInfo] {
    let (of_class, of_instance) = infrastructure::tables(class);
    match (instance.is_class(), of_instance.is_empty()) {
        (true, _) => of_class,
        (false, true) => application::instance_table(class),
        (false, false) => of_instance,
    }
}

/// The attributes 1-7 that every class can have in its instance 0.
pub const fn common_class_attributes() -> &'static [AttributeInfo] {
    &infrastructure::COMMON_CLASS
}

/// What is known of an attribute.
pub fn attribute_info(
    class: ClassId,
    instance: InstanceId,
    attribute: AttributeId,
) -> Option<&'static AttributeInfo> {
    let common = if instance.is_class() { common_class_attributes() } else { &[] };
    attributes(class, instance).iter().chain(common).find(|info| info.id == attribute)
}

/// The number of bytes that the value of an attribute takes which `data` begin with; `None` if the attribute is not
/// known or they do not tell it. For [`AttributeReplies::iter`](crate::message::AttributeReplies::iter) and the like.
pub fn value_len(class: ClassId, instance: InstanceId, attribute: AttributeId, data: &[u8]) -> Option<usize> {
    attribute_info(class, instance, attribute)?.shape.value_len(data)
}

/// The name of an attribute.
pub fn attribute_name(class: ClassId, instance: InstanceId, attribute: AttributeId) -> Option<&'static str> {
    attribute_info(class, instance, attribute).map(|info| info.name)
}

/// The name of a service: of the class if it has one of its own, else the common one.
pub const fn service_name(class: ClassId, service: ServiceCode) -> Option<&'static str> {
    match (class, service.0) {
        (ClassId::DEVICENET, 0x4B) => Some("Allocate_Master/Slave_Connection_Set"),
        (ClassId::DEVICENET, 0x4C) => Some("Release_Master/Slave_Connection_Set"),
        (ClassId::CONNECTION, 0x4B) => Some("Connection_Bind"),
        (ClassId::CONNECTION, 0x4C) => Some("Producing_Application_Lookup"),
        (ClassId::PARAMETER, 0x4B) => Some("Get_Enum_String"),
        (ClassId::ACKNOWLEDGE_HANDLER, 0x4B) => Some("Add_AckData_Path"),
        (ClassId::ACKNOWLEDGE_HANDLER, 0x4C) => Some("Remove_AckData_Path"),
        _ => service.name(),
    }
}

/// The name of a service as a trace has it: that of [`service_name`], short where everybody knows the service by one word.
pub const fn short_service_name(class: ClassId, service: ServiceCode) -> Option<&'static str> {
    match (class, service) {
        (ClassId::DEVICENET, ServiceCode::ALLOCATE) => Some("Allocate"),
        (ClassId::DEVICENET, ServiceCode::RELEASE) => Some("Release"),
        _ => service_name(class, service),
    }
}

/// A service and what it is for, in the words of a trace: `Set_Attribute_Single Connection 2`, `Reset Connection class`.
///
/// ```
/// use cip_core::code::{ClassId, InstanceId, ServiceCode};
/// use cip_core::names::Operation;
///
/// let operation = |service| Operation { service, class: ClassId::DEVICENET, instance: InstanceId(1) };
/// assert_eq!(operation(ServiceCode::ALLOCATE).to_string(), "Allocate DeviceNet 1");
/// assert_eq!(operation(ServiceCode(0x7A)).to_string(), "service 0x7A DeviceNet 1");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Operation {
    /// The service.
    pub service: ServiceCode,
    /// The class.
    pub class: ClassId,
    /// The instance.
    pub instance: InstanceId,
}

impl fmt::Display for Operation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match short_service_name(self.class, self.service) {
            Some(name) => f.write_str(name)?,
            None => fmt::Display::fmt(&self.service, f)?,
        }
        f.write_str(" ")?;
        write_object(f, self.class, self.instance)
    }
}

/// Writes an object in the words of a trace: `Connection 2`, `Connection class`.
///
/// # Errors
/// When `f` fails.
pub fn write_object(f: &mut fmt::Formatter<'_>, class: ClassId, instance: InstanceId) -> fmt::Result {
    fmt::Display::fmt(&class, f)?;
    if instance.is_class() {
        return f.write_str(" class");
    }
    f.write_str(" ")?;
    write_decimal(f, instance.0.into())
}

/// The meaning of an additional code in an error response of a class.
pub const fn additional_code_name(class: ClassId, code: AdditionalCode) -> Option<&'static str> {
    match (class, code) {
        (ClassId::DEVICENET, AdditionalCode::ALLOCATION_CONFLICT) => {
            Some("another master owns the connection set")
        }
        (ClassId::DEVICENET, AdditionalCode::INVALID_CHOICE) => Some("invalid allocation/release choice"),
        (ClassId::DEVICENET, AdditionalCode::INVALID_UNCONNECTED_SERVICE) => {
            Some("invalid service on the Group 2 Only unconnected port")
        }
        (ClassId::DEVICENET, AdditionalCode::RESOURCE_UNAVAILABLE) => {
            Some("a resource of the predefined connection set is unavailable")
        }
        _ => code.name(),
    }
}

const fn get(id: u16, name: &'static str, shape: Shape) -> AttributeInfo {
    AttributeInfo { id: AttributeId(id), name, shape, access: Access::Get }
}

const fn get_set(id: u16, name: &'static str, shape: Shape) -> AttributeInfo {
    AttributeInfo { id: AttributeId(id), name, shape, access: Access::GetSet }
}

const BOOL: Shape = Shape::Data(DataType::Bool);
const BYTE: Shape = Shape::Data(DataType::Byte);
const EPATH: Shape = Shape::Data(DataType::Epath);
const INT: Shape = Shape::Data(DataType::Int);
const SHORT_STRING: Shape = Shape::Data(DataType::ShortString);
const STRINGI: Shape = Shape::Data(DataType::StringI);
const UDINT: Shape = Shape::Data(DataType::Udint);
const UINT: Shape = Shape::Data(DataType::Uint);
const USINT: Shape = Shape::Data(DataType::Usint);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_ascend() {
        for &class in ClassId::NAMED {
            for instance in [InstanceId::CLASS, InstanceId(1)] {
                let table = attributes(class, instance);
                assert!(table.is_sorted_by(|a, b| a.id < b.id), "{class} {instance}");
            }
        }
        assert!(common_class_attributes().is_sorted_by(|a, b| a.id < b.id));
    }

    #[test]
    fn instance_0_has_the_attributes_of_the_class() {
        let revision = attribute_name(ClassId::CONNECTION, InstanceId(0), AttributeId(1));
        assert_eq!(revision, Some("Revision"));
        let state = attribute_name(ClassId::CONNECTION, InstanceId(1), AttributeId(1));
        assert_eq!(state, Some("state"));
        let assembly = attribute_name(ClassId::PARAMETER, InstanceId(0), AttributeId(9));
        assert_eq!(assembly, Some("Configuration assembly instance"));
        assert_eq!(attribute_name(ClassId(0x64), InstanceId(1), AttributeId(1)), None);
    }

    #[test]
    fn services_of_a_class_come_before_the_common_ones() {
        assert_eq!(service_name(ClassId::CONNECTION, ServiceCode(0x4B)), Some("Connection_Bind"));
        assert_eq!(service_name(ClassId::CONNECTION, ServiceCode::RESET), Some("Reset"));
        assert_eq!(service_name(ClassId::ASSEMBLY, ServiceCode(0x4B)), None);
        let name = additional_code_name(ClassId::DEVICENET, AdditionalCode(2));
        assert_eq!(name, Some("invalid allocation/release choice"));
        assert_eq!(additional_code_name(ClassId::ASSEMBLY, AdditionalCode(2)), None);
    }
}
