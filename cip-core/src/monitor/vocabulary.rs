//! What a network calls its own.

use core::fmt::{self, Formatter};

use crate::code::{AdditionalCode, AttributeId, ClassId, InstanceId, ServiceCode};
use crate::names::{self, AttributeInfo};

/// The names of services, attributes and additional codes, where those of a network differ from the general ones: networks
/// use class 3, that of the link, each in its own way.
#[derive(Debug, Clone, Copy)]
pub struct Vocabulary {
    /// What is known of an attribute.
    pub attribute: fn(ClassId, InstanceId, AttributeId) -> Option<&'static AttributeInfo>,
    /// The name of a service of a class, as in the specification.
    pub service: fn(ClassId, ServiceCode) -> Option<&'static str>,
    /// The same in one word, where everybody knows it by that.
    pub short_service: fn(ClassId, ServiceCode) -> Option<&'static str>,
    /// What an additional code of a class means.
    pub additional: fn(ClassId, AdditionalCode) -> Option<&'static str>,
    /// Writes the name of a class.
    pub class: fn(ClassId, &mut Formatter<'_>) -> fmt::Result,
}

impl Vocabulary {
    /// That of DeviceNet.
    pub const DEVICENET: Self = Self {
        attribute: names::attribute_info,
        service: service_of,
        short_service: short_service_of,
        additional: additional_of_devicenet,
        class: write_class,
    };

    /// How many bytes the value of an attribute takes which `data` begin with.
    pub(super) fn value_len(
        &self,
        class: ClassId,
        instance: InstanceId,
        attribute: AttributeId,
        data: &[u8],
    ) -> Option<usize> {
        (self.attribute)(class, instance, attribute)?.shape.value_len(data)
    }

    pub(super) fn attribute_name(
        &self,
        class: ClassId,
        instance: InstanceId,
        attribute: AttributeId,
    ) -> Option<&'static str> {
        (self.attribute)(class, instance, attribute).map(|info| info.name)
    }
}

fn service_of(class: ClassId, service: ServiceCode) -> Option<&'static str> {
    names::service_name(class, service)
}

fn short_service_of(class: ClassId, service: ServiceCode) -> Option<&'static str> {
    names::short_service_name(class, service)
}

fn additional_of_devicenet(class: ClassId, code: AdditionalCode) -> Option<&'static str> {
    if class == ClassId::DEVICENET { names::additional_code_name(class, code) } else { None }
}

fn write_class(class: ClassId, f: &mut Formatter<'_>) -> fmt::Result {
    fmt::Display::fmt(&class, f)
}
