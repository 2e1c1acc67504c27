//! The objects that every slave has: Identity, DeviceNet, Connection.

use cip_core::code::{AttributeId, ClassId, GeneralStatus, InstanceId, ServiceCode};
use cip_core::codec::Writer;
use cip_core::object::{AttributeRule, Call, Effects, Failure, Identity, Object};

use super::application::Application;
use super::connection_object::ConnectionObject;
use super::devicenet_object::DeviceNetObject;

/// One of them. A request is served by one object of several classes, so that a device without other objects has one copy of
/// the checks, and no tables of functions by which they would find the object.
pub(super) enum Own<'s, 'a, A: Application, const MESSAGE: usize, const DYNAMIC: usize> {
    Identity(MandatoryIdentity<'s>),
    DeviceNet(DeviceNetObject<'s, 'a, A, MESSAGE, DYNAMIC>),
    Connection(ConnectionObject<'s, 'a, A, MESSAGE, DYNAMIC>),
}

impl<A: Application, const MESSAGE: usize, const DYNAMIC: usize> Object for Own<'_, '_, A, MESSAGE, DYNAMIC> {
    /// That of none: which it is was found out before.
    const CLASS: ClassId = ClassId(0);

    fn revision(&self) -> u16 {
        match self {
            Self::Identity(object) => object.revision(),
            Self::DeviceNet(object) => object.revision(),
            Self::Connection(object) => object.revision(),
        }
    }

    fn attributes(&self, instance: InstanceId) -> Option<&'static [AttributeRule]> {
        match self {
            Self::Identity(object) => object.attributes(instance),
            Self::DeviceNet(object) => object.attributes(instance),
            Self::Connection(object) => object.attributes(instance),
        }
    }

    fn get(&self, instance: InstanceId, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure> {
        match self {
            Self::Identity(object) => object.get(instance, attribute, out),
            Self::DeviceNet(object) => object.get(instance, attribute, out),
            Self::Connection(object) => object.get(instance, attribute, out),
        }
    }

    fn set(
        &mut self,
        instance: InstanceId,
        attribute: AttributeId,
        value: &[u8],
        out: &mut Writer<'_>,
    ) -> Result<Effects, Failure> {
        match self {
            Self::Identity(object) => object.set(instance, attribute, value, out),
            Self::DeviceNet(object) => object.set(instance, attribute, value, out),
            Self::Connection(object) => object.set(instance, attribute, value, out),
        }
    }

    fn service(&mut self, call: &Call<'_>, out: &mut Writer<'_>) -> Result<Effects, Failure> {
        match self {
            Self::Identity(object) => object.service(call, out),
            Self::DeviceNet(object) => object.service(call, out),
            Self::Connection(object) => object.service(call, out),
        }
    }
}

/// The Identity object without the services that it need not have.
pub(super) struct MandatoryIdentity<'a>(pub(super) Identity<'a>);

impl Object for MandatoryIdentity<'_> {
    const CLASS: ClassId = ClassId::IDENTITY;

    fn attributes(&self, instance: InstanceId) -> Option<&'static [AttributeRule]> {
        self.0.attributes(instance)
    }

    fn get(&self, instance: InstanceId, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure> {
        self.0.get(instance, attribute, out)
    }

    fn service(&mut self, call: &Call<'_>, _: &mut Writer<'_>) -> Result<Effects, Failure> {
        if call.service == ServiceCode::RESET && !call.instance.is_class() {
            self.0.reset(call)
        } else {
            Err(GeneralStatus::SERVICE_NOT_SUPPORTED.into())
        }
    }
}
