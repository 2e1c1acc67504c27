//! The objects that make a device a device: class attributes and instance attributes.

use super::{
    AttributeInfo, BOOL, BYTE, EPATH, INT, SHORT_STRING, STRINGI, Shape, UDINT, UINT, USINT, get, get_set,
};
use crate::code::ClassId;

type Table = &'static [AttributeInfo];

/// The attributes of the class itself, beyond the common ones, and of its instances.
pub(super) const fn tables(class: ClassId) -> (Table, Table) {
    match class {
        ClassId::IDENTITY => (&[], &IDENTITY),
        ClassId::MESSAGE_ROUTER => (&[], &MESSAGE_ROUTER),
        ClassId::DEVICENET => (&[], &DEVICENET),
        ClassId::ASSEMBLY => (&[], &ASSEMBLY),
        ClassId::CONNECTION => (&[], &CONNECTION),
        ClassId::PARAMETER => (&PARAMETER_CLASS, &PARAMETER),
        ClassId::ACKNOWLEDGE_HANDLER => (&[], &ACKNOWLEDGE_HANDLER),
        _ => (&[], &[]),
    }
}

pub(super) static COMMON_CLASS: [AttributeInfo; 7] = [
    get(1, "Revision", UINT),
    get(2, "Max instance", UINT),
    get(3, "Number of instances", UINT),
    get(4, "Optional attribute list", Shape::UintList),
    get(5, "Optional service list", Shape::UintList),
    get(6, "Max class attribute ID", UINT),
    get(7, "Max instance attribute ID", UINT),
];

static IDENTITY: [AttributeInfo; 10] = [
    get(1, "Vendor ID", Shape::VendorId),
    get(2, "Device type", Shape::DeviceType),
    get(3, "Product code", UINT),
    get(4, "Revision", Shape::Revision),
    get(5, "Status", Shape::IdentityStatus),
    get(6, "Serial number", UDINT),
    get(7, "Product name", SHORT_STRING),
    get(8, "State", Shape::DeviceState),
    get(9, "Configuration consistency value", UINT),
    get_set(10, "Heartbeat interval", Shape::Seconds),
];

static MESSAGE_ROUTER: [AttributeInfo; 4] = [
    get(1, "Object list", Shape::UintList),
    get(2, "Number available", UINT),
    get(3, "Number active", UINT),
    get(4, "Active connections", Shape::Bytes),
];

static DEVICENET: [AttributeInfo; 13] = [
    get_set(1, "MAC ID", Shape::MacId),
    get_set(2, "Baud rate", Shape::BaudRate),
    get_set(3, "Bus-off interrupt", BOOL),
    get_set(4, "Bus-off counter", USINT),
    get(5, "Allocation information", Shape::AllocationInformation),
    get(6, "MAC ID switch changed", BOOL),
    get(7, "Baud rate switch changed", BOOL),
    get(8, "MAC ID switch value", USINT),
    get(9, "Baud rate switch value", USINT),
    get_set(10, "Quick Connect", BOOL),
    get(11, "Safety Network Number", Shape::Bytes),
    get_set(12, "Diagnostic counters", Shape::DiagnosticCounters),
    get(13, "Active node table", Shape::ActiveNodes),
];

static ASSEMBLY: [AttributeInfo; 4] = [
    get(1, "Number of members in list", UINT),
    get(2, "Member list", Shape::Bytes),
    get_set(3, "Data", Shape::Bytes),
    get(4, "Size", UINT),
];

static CONNECTION: [AttributeInfo; 19] = [
    get(1, "state", Shape::ConnectionState),
    get(2, "instance_type", Shape::InstanceType),
    get(3, "transportClass_trigger", Shape::TransportClassTrigger),
    get(4, "produced_connection_id", Shape::ConnectionId),
    get_set(5, "consumed_connection_id", Shape::ConnectionId),
    get(6, "initial_comm_characteristics", Shape::CommCharacteristics),
    get(7, "produced_connection_size", UINT),
    get(8, "consumed_connection_size", UINT),
    get_set(9, "expected_packet_rate", Shape::Milliseconds),
    get(10, "CIP_produced_connection_id", UDINT),
    get(11, "CIP_consumed_connection_id", UDINT),
    get_set(12, "watchdog_timeout_action", Shape::WatchdogAction),
    get(13, "produced_connection_path_length", UINT),
    get_set(14, "produced_connection_path", EPATH),
    get(15, "consumed_connection_path_length", UINT),
    get_set(16, "consumed_connection_path", EPATH),
    get_set(17, "production_inhibit_time", Shape::Milliseconds),
    get_set(18, "connection_timeout_multiplier", Shape::TimeoutMultiplier),
    get(19, "connection_binding_list", Shape::UintList),
];

static PARAMETER_CLASS: [AttributeInfo; 3] = [
    get(8, "Parameter class descriptor", Shape::ParameterClassDescriptor),
    get(9, "Configuration assembly instance", UINT),
    get_set(10, "Native language", USINT),
];

static PARAMETER: [AttributeInfo; 24] = [
    get_set(1, "Parameter value", Shape::Bytes),
    get_set(2, "Link path size", USINT),
    get_set(3, "Link path", EPATH),
    get(4, "Descriptor", Shape::ParameterDescriptor),
    get(5, "Data type", Shape::DataTypeCode),
    get(6, "Data size", USINT),
    get(7, "Parameter name", SHORT_STRING),
    get(8, "Units", SHORT_STRING),
    get(9, "Help", SHORT_STRING),
    get(10, "Minimum", Shape::Bytes),
    get(11, "Maximum", Shape::Bytes),
    get(12, "Default", Shape::Bytes),
    get(13, "Scaling multiplier", UINT),
    get(14, "Scaling divisor", UINT),
    get(15, "Scaling base", UINT),
    get(16, "Scaling offset", INT),
    get(17, "Multiplier link", UINT),
    get(18, "Divisor link", UINT),
    get(19, "Base link", UINT),
    get(20, "Offset link", UINT),
    get(21, "Decimal precision", USINT),
    get(22, "International parameter name", STRINGI),
    get(23, "International engineering units", STRINGI),
    get(24, "International help", STRINGI),
];

static ACKNOWLEDGE_HANDLER: [AttributeInfo; 7] = [
    get_set(1, "Acknowledge timer", Shape::Milliseconds),
    get_set(2, "Retry limit", USINT),
    get_set(3, "COS producing connection instance", UINT),
    get(4, "Ack list size", BYTE),
    get(5, "Ack list", Shape::Bytes),
    get(6, "Data with ack path list size", BYTE),
    get(7, "Data with ack path list", Shape::Bytes),
];
