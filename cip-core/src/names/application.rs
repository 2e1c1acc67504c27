//! Application objects that are met commonly: the attributes that a simple device has.

use super::{AttributeInfo, BOOL, BYTE, SHORT_STRING, Shape, USINT, get, get_set};
use crate::code::ClassId;
use crate::data_type::DataType;

/// The attributes of the instances of an application class.
pub(super) const fn instance_table(class: ClassId) -> &'static [AttributeInfo] {
    match class {
        ClassId::DISCRETE_INPUT_POINT => &DISCRETE_INPUT_POINT,
        ClassId::DISCRETE_OUTPUT_POINT => &DISCRETE_OUTPUT_POINT,
        ClassId::ANALOG_INPUT_POINT => &ANALOG_INPUT_POINT,
        ClassId::ANALOG_OUTPUT_POINT => &ANALOG_OUTPUT_POINT,
        ClassId::PRESENCE_SENSING => &PRESENCE_SENSING,
        ClassId::POSITION_SENSOR => &POSITION_SENSOR,
        ClassId::S_DEVICE_SUPERVISOR => &S_DEVICE_SUPERVISOR,
        ClassId::S_ANALOG_SENSOR | ClassId::S_ANALOG_ACTUATOR | ClassId::S_SINGLE_STAGE_CONTROLLER => {
            &S_ANALOG
        }
        _ => &[],
    }
}

static DISCRETE_INPUT_POINT: [AttributeInfo; 2] = [get(3, "Value", BOOL), get(4, "Status", BOOL)];

static DISCRETE_OUTPUT_POINT: [AttributeInfo; 6] = [
    get_set(3, "Value", BOOL),
    get(4, "Status", BOOL),
    get_set(5, "Fault action", BOOL),
    get_set(6, "Fault value", BOOL),
    get_set(7, "Idle action", BOOL),
    get_set(8, "Idle value", BOOL),
];

static ANALOG_INPUT_POINT: [AttributeInfo; 4] = [
    get(3, "Value", Shape::Bytes),
    get(4, "Status", BOOL),
    get_set(7, "Input range", USINT),
    get_set(8, "Value data type", USINT),
];

static ANALOG_OUTPUT_POINT: [AttributeInfo; 8] = [
    get_set(3, "Value", Shape::Bytes),
    get(4, "Status", BOOL),
    get_set(7, "Output range", USINT),
    get_set(8, "Value data type", USINT),
    get_set(9, "Fault action", USINT),
    get_set(10, "Idle action", USINT),
    get_set(11, "Fault value", Shape::Bytes),
    get_set(12, "Idle value", Shape::Bytes),
];

static PRESENCE_SENSING: [AttributeInfo; 2] = [get(1, "Output", BOOL), get(4, "Diagnostic", BOOL)];

static POSITION_SENSOR: [AttributeInfo; 1] = [get(3, "Value", Shape::Data(DataType::Dint))];

static S_DEVICE_SUPERVISOR: [AttributeInfo; 9] = [
    get(3, "Device type", SHORT_STRING),
    get(4, "SEMI standard revision level", SHORT_STRING),
    get(5, "Manufacturer's name", SHORT_STRING),
    get(6, "Manufacturer's model number", SHORT_STRING),
    get(7, "Software or firmware revision level", SHORT_STRING),
    get(8, "Hardware revision level", SHORT_STRING),
    get(9, "Manufacturer's serial number", SHORT_STRING),
    get(11, "Device status", USINT),
    get(12, "Exception status", BYTE),
];

static S_ANALOG: [AttributeInfo; 1] = [get(6, "Value", Shape::Bytes)];
