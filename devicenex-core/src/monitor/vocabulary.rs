//! The names that DeviceNeX has of its own: the link object keeps class 3, with attributes of its own **\[D\]**.

use core::fmt::{self, Formatter};

use cip_core::code::{AdditionalCode, AttributeId, ClassId, InstanceId, ServiceCode};
use cip_core::data_type::DataType;
use cip_core::monitor::Vocabulary;
use cip_core::names::{self, Access, AttributeInfo, Shape};

/// That of DeviceNeX.
pub(super) const DEVICENEX: Vocabulary =
    Vocabulary { attribute, service, short_service: service, additional, class };

fn attribute(class: ClassId, instance: InstanceId, attribute: AttributeId) -> Option<&'static AttributeInfo> {
    let own: &[AttributeInfo] = match class {
        _ if instance.is_class() => &[],
        LINK => &LINK_OBJECT,
        ClassId::CONNECTION => &CONNECTION,
        _ => &[],
    };
    let info = own.iter().find(|info| info.id == attribute);
    info.or_else(|| match class {
        LINK if !instance.is_class() => None,
        _ => names::attribute_info(class, instance, attribute),
    })
}

fn service(class: ClassId, service: ServiceCode) -> Option<&'static str> {
    if class == LINK { service.name() } else { names::service_name(class, service) }
}

fn additional(class: ClassId, code: AdditionalCode) -> Option<&'static str> {
    if class == LINK { None } else { names::additional_code_name(class, code) }
}

fn class(class: ClassId, f: &mut Formatter<'_>) -> fmt::Result {
    if class == LINK { f.write_str("DeviceNeX") } else { fmt::Display::fmt(&class, f) }
}

const fn info(id: u16, name: &'static str, shape: Shape, access: Access) -> AttributeInfo {
    AttributeInfo { id: AttributeId(id), name, shape, access }
}

/// The class of the link object.
pub(super) const LINK: ClassId = ClassId::DEVICENET;

static LINK_OBJECT: [AttributeInfo; 6] = [
    info(1, "Operational Address", Shape::Data(DataType::Usint), Access::GetSet),
    info(2, "Bit rate", Shape::BaudRate, Access::Get),
    info(3, "Bus-off interrupt", Shape::Data(DataType::Bool), Access::GetSet),
    info(4, "Bus-off counter", Shape::Data(DataType::Usint), Access::GetSet),
    info(5, "Connection instances in use", Shape::Bytes, Access::Get),
    info(6, "Hello wait", Shape::Milliseconds, Access::GetSet),
];

/// The attributes that are wider than those of DeviceNet.
static CONNECTION: [AttributeInfo; 2] = [
    info(4, "produced_connection_id", Shape::WideConnectionId, Access::Get),
    info(5, "consumed_connection_id", Shape::WideConnectionId, Access::GetSet),
];
