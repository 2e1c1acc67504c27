//! The objects that every slave has: Identity, DeviceNet, Connection.

use cip_core::code::{AttributeId, ClassId, GeneralStatus, ServiceCode};
use cip_core::codec::Writer;
use cip_core::object::{Call, Failure, PlainObject};

use super::application::{Application, Parts};
use super::connection_object::ConnectionObject;
use super::devicenet_object::{self, DeviceNetObject};
use super::server::Server;

/// One of them, by the class of the request. Of Identity, what a device must have: one that has more of it is served by
/// [`Identity`](cip_core::object::Identity) itself.
impl<A: Application, const MESSAGE: usize, const DYNAMIC: usize> PlainObject
    for Server<'_, A, MESSAGE, DYNAMIC>
{
    fn exists(&self, call: &Call<'_>) -> bool {
        match call.class {
            _ if call.instance.is_class() => true,
            ClassId::CONNECTION => self.is_connection(call.instance),
            _ => call.instance.0 == 1,
        }
    }

    fn has_set(&self, call: &Call<'_>) -> bool {
        match call.class {
            _ if call.instance.is_class() => false,
            ClassId::CONNECTION => self.which(call.instance).is_some(),
            ClassId::DEVICENET => A::PARTS.intersects(Parts::OPTIONAL_ATTRIBUTES.union(Parts::SETTINGS)),
            _ => false,
        }
    }

    fn get(&mut self, call: &Call<'_>, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure> {
        match call.class {
            _ if call.instance.is_class() => class_attribute(call.class, attribute, out),
            ClassId::CONNECTION => ConnectionObject { server: self }.get(call, attribute, out),
            ClassId::DEVICENET => DeviceNetObject(self).get(attribute, out),
            _ => {
                let identity = self.node.identity();
                if identity.has(attribute) { identity.emit_attribute(attribute, out) } else { Err(ABSENT) }
            }
        }
    }

    fn set(
        &mut self,
        call: &Call<'_>,
        attribute: AttributeId,
        value: &[u8],
        out: &mut Writer<'_>,
    ) -> Result<(), Failure> {
        match call.class {
            ClassId::CONNECTION => {
                ConnectionObject { server: self }.set(call.instance, attribute, value, out)
            }
            _ => DeviceNetObject(self).set(attribute, value),
        }
    }

    fn service(&mut self, call: &Call<'_>, out: &mut Writer<'_>) -> Result<(), Failure> {
        match call.class {
            ClassId::CONNECTION => ConnectionObject { server: self }.service(call, out),
            ClassId::DEVICENET => DeviceNetObject(self).service(call, out),
            _ if call.service == ServiceCode::RESET && !call.instance.is_class() => {
                let effects = self.node.identity().reset(call)?;
                self.carry_out(effects);
                Ok(())
            }
            _ => Err(GeneralStatus::SERVICE_NOT_SUPPORTED.into()),
        }
    }
}

/// The revision, which is all that these classes have.
fn class_attribute(class: ClassId, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure> {
    if attribute.0 != 1 {
        return Err(ABSENT);
    }
    Ok(out.u16(if class == ClassId::DEVICENET { devicenet_object::REVISION } else { 1 })?)
}

const ABSENT: Failure = Failure::new(GeneralStatus::ATTRIBUTE_NOT_SUPPORTED);
