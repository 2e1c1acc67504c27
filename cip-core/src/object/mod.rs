//! Objects: what a device answers to explicit requests.
//!
//! An [`Object`] is one class with its instances; an [`ObjectSet`] is all of them; [`respond`] turns a [`Call`] into
//! the bytes of the response. Nothing here knows a network, waits, allocates or calls back: what is left to do after
//! the response, a reset for instance, is told in [`Effects`].
//!
//! | Step | By |
//! |---|---|
//! | bytes to [`Request`](crate::message::Request) | its `parse`; a body too short for service, class and instance gets no answer |
//! | request to [`Call`] | [`Call::of`], where a path is read |
//! | class, instance, service, attribute, access, length | [`serve`], by the [`AttributeRule`]s of the object |
//! | value, state of the object or of the device | the object |
//! | service byte, error response | [`respond`] |
//! | effects | the owner of the objects |
//!
//! | Object | Class | Made of |
//! |---|---|---|
//! | [`Identity`] | 0x01 | a [`DeviceIdentity`](crate::identity::DeviceIdentity) and the status of the moment |
//! | [`MessageRouter`], [`Router`] | 0x02 | nothing, or the set of the other objects |
//! | [`AssemblyObject`] | 0x04 | the [`Assemblies`] of the application |
//! | [`ParameterObject`] | 0x0F | the [`Parameters`] of the application |
//! | [`AcknowledgeHandler`] | 0x2B | [`AcknowledgeSettings`] |
//!
//! # The smallest class
//!
//! ```
//! use cip_core::code::{AttributeId, ClassId, InstanceId};
//! use cip_core::codec::Writer;
//! use cip_core::object::{AttributeRule, Failure, Object};
//!
//! struct Input(bool);
//!
//! impl Object for Input {
//!     const CLASS: ClassId = ClassId::DISCRETE_INPUT_POINT;
//!
//!     fn attributes(&self, instance: InstanceId) -> Option<&'static [AttributeRule]> {
//!         (instance.0 == 1).then_some(const { &[AttributeRule::get(3, 1)] })
//!     }
//!
//!     fn get(&self, _: InstanceId, _: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure> {
//!         Ok(out.u8(self.0.into())?)
//!     }
//! }
//! ```
//!
//! # A class of the vendor
//!
//! Class IDs 0x64-0xC7 and 0x300-0x4FF, attributes 0x64-0xC7 and services 0x32-0x4A belong to the vendor of a device.
//! Such a class is written as every other: its number, a table of its attributes, a `get`, and if it needs them a `set`
//! and a `service`. What happens in a `set` is told to the owner by a bit of [`Effect::APPLICATION`], if it must know.
//!
//! ```
//! use cip_core::code::{AttributeId, ClassId, GeneralStatus, InstanceId, ServiceCode};
//! use cip_core::codec::Writer;
//! use cip_core::object::{AttributeRule, Call, Effects, Failure, FailureOptions, Object, exact, respond};
//!
//! struct Lamp {
//!     brightness: u16,
//!     hours: u32,
//! }
//!
//! impl Object for Lamp {
//!     const CLASS: ClassId = ClassId(0x64);
//!
//!     fn attributes(&self, instance: InstanceId) -> Option<&'static [AttributeRule]> {
//!         const RULES: &[AttributeRule] = &[AttributeRule::get_set(100, 2), AttributeRule::get(101, 4)];
//!         (instance.0 == 1).then_some(RULES)
//!     }
//!
//!     fn get(&self, _: InstanceId, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure> {
//!         Ok(if attribute.0 == 100 { out.u16(self.brightness)? } else { out.u32(self.hours)? })
//!     }
//!
//!     fn set(&mut self, _: InstanceId, _: AttributeId, value: &[u8], _: &mut Writer<'_>) -> Result<Effects, Failure> {
//!         self.brightness = match u16::from_le_bytes(exact(value)?) {
//!             percent @ 0..=100 => percent,
//!             _ => return Err(GeneralStatus::INVALID_ATTRIBUTE_VALUE.into()),
//!         };
//!         Ok(Effects::NONE)
//!     }
//!
//!     fn service(&mut self, call: &Call<'_>, _: &mut Writer<'_>) -> Result<Effects, Failure> {
//!         if call.service != ServiceCode(0x32) || call.instance.is_class() {
//!             return Err(GeneralStatus::SERVICE_NOT_SUPPORTED.into());
//!         }
//!         call.no_data()?;
//!         self.hours = 0; // A new lamp was fitted.
//!         Ok(Effects::NONE)
//!     }
//! }
//!
//! let mut objects = (Lamp { brightness: 80, hours: 1234 },);
//! let mut answer = |service, data: &[u8]| {
//!     let call = Call::new(ServiceCode(service), ClassId(0x64), InstanceId(1), data);
//!     let mut buffer = [0; 8];
//!     let mut out = Writer::new(&mut buffer);
//!     let _effects = respond(&mut objects, &call, FailureOptions::default(), &mut out);
//!     out.written().to_vec()
//! };
//! assert_eq!(answer(0x0E, &[100]), [0x8E, 80, 0]);
//! assert_eq!(answer(0x10, &[100, 101, 0]), [0x94, 0x09, 0xFF]);
//! assert_eq!(answer(0x10, &[101, 0, 0, 0, 0]), [0x94, 0x0E, 0xFF]);
//! assert_eq!(answer(0x32, &[]), [0xB2]);
//! ```

mod acknowledge_handler;
mod assembly;
mod call;
mod common;
mod effect;
mod failure;
mod identity;
#[doc(hidden)]
pub mod laws;
mod message_router;
mod parameter;
mod plain;
mod rule;
mod serve;
mod set;

pub use acknowledge_handler::{AcknowledgeHandler, AcknowledgeLists, AcknowledgePath, AcknowledgeSettings};
pub use assembly::{Assemblies, Assembly, AssemblyKind, AssemblyObject, Member};
pub use call::Call;
pub use common::{
    CommonServices, attribute_list, attributes_all, class_attribute, find_next_instance, set_attribute_list,
};
pub use effect::{Effect, Effects};
pub use failure::{Failure, FailureOptions, exact};
pub use identity::{Identity, Resets};
pub use message_router::{MessageRouter, Router, RouterConnections};
pub use parameter::{
    FullParameter, International, Parameter, ParameterClassDescriptor, ParameterDescriptor, ParameterObject,
    ParameterStorage, Parameters, Scaling, ScalingLinks,
};
pub use plain::{PlainObject, serve_plain};
pub use rule::{AttributeRule, Size};
pub use serve::serve;
pub use set::{Chain, ObjectSet, respond, respond_with};

use crate::code::{AttributeId, ClassId, GeneralStatus, InstanceId};
use crate::codec::Writer;

/// An object class with its instances, as a device implements it.
///
/// [`serve`] has made its checks before it calls [`get`](Self::get) and [`set`](Self::set): they see only instances
/// and attributes that the tables have, and values of the right length.
pub trait Object {
    /// The class.
    const CLASS: ClassId;

    /// Class attribute 1.
    const REVISION: u16 = 1;

    /// The attributes of the class itself (instance 0). Attribute 1 is answered with [`REVISION`](Self::REVISION), all
    /// others by [`get`](Self::get). By default the revision alone.
    fn class_attributes(&self) -> &'static [AttributeRule] {
        REVISION_ONLY
    }

    /// The attributes of an instance other than 0; `None` if it does not exist.
    fn attributes(&self, instance: InstanceId) -> Option<&'static [AttributeRule]>;

    /// True if the service Set_Attribute_Single is implemented for the instance: a service that is not is refused
    /// before the attribute is looked at. By default, if any attribute can be set.
    fn has_set(&self, instance: InstanceId) -> bool {
        serve::is_any_settable(serve::rules(self, instance))
    }

    /// The instance that follows `instance`, in ascending order, beginning with what follows 0. By default, if
    /// instance 1 exists, it is the only one.
    fn next_instance(&self, instance: InstanceId) -> Option<InstanceId> {
        (instance.is_class() && self.attributes(FIRST).is_some()).then_some(FIRST)
    }

    /// Writes the value of an attribute.
    fn get(&self, instance: InstanceId, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure>;

    /// Sets an attribute. The response has data only if they are written to `out`, such as the packet rate that a
    /// connection really uses. A failure must leave the object as it was.
    fn set(
        &mut self,
        _instance: InstanceId,
        _attribute: AttributeId,
        _value: &[u8],
        _out: &mut Writer<'_>,
    ) -> Result<Effects, Failure> {
        Err(GeneralStatus::ATTRIBUTE_NOT_SETTABLE.into())
    }

    /// Carries out any other service, and writes the service data of its response. What the class does not have is
    /// 0x08, which is all that the default answers.
    fn service(&mut self, _call: &Call<'_>, _out: &mut Writer<'_>) -> Result<Effects, Failure> {
        Err(GeneralStatus::SERVICE_NOT_SUPPORTED.into())
    }
}

/// A borrowed object is an object, so that a set can be put together for one request.
impl<O: Object> Object for &mut O {
    const CLASS: ClassId = O::CLASS;
    const REVISION: u16 = O::REVISION;

    fn class_attributes(&self) -> &'static [AttributeRule] {
        (**self).class_attributes()
    }

    fn attributes(&self, instance: InstanceId) -> Option<&'static [AttributeRule]> {
        (**self).attributes(instance)
    }

    fn has_set(&self, instance: InstanceId) -> bool {
        (**self).has_set(instance)
    }

    fn next_instance(&self, instance: InstanceId) -> Option<InstanceId> {
        (**self).next_instance(instance)
    }

    fn get(&self, instance: InstanceId, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure> {
        (**self).get(instance, attribute, out)
    }

    fn set(
        &mut self,
        instance: InstanceId,
        attribute: AttributeId,
        value: &[u8],
        out: &mut Writer<'_>,
    ) -> Result<Effects, Failure> {
        (**self).set(instance, attribute, value, out)
    }

    fn service(&mut self, call: &Call<'_>, out: &mut Writer<'_>) -> Result<Effects, Failure> {
        (**self).service(call, out)
    }
}

const REVISION_ONLY: &[AttributeRule] = &[AttributeRule::get(1, 2)];
const FIRST: InstanceId = InstanceId(1);

#[cfg(test)]
mod tests;
