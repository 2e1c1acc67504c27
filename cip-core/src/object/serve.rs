//! The checks that every request meets before its object.

use super::rule::rule_of;
use super::{AttributeRule, Call, Effect, Effects, Failure, Object};
use crate::code::{AttributeId, GeneralStatus, InstanceId, ServiceCode};
use crate::codec::Writer;

/// Carries out a request for the class of `object`, and writes the service data of the response to `out`. What a failure
/// leaves in `out` is no response: [`respond`](super::respond) takes it back.
///
/// The first check that fails gives the answer:
///
/// | Check | General status |
/// |---|---|
/// | class not implemented | 0x16, by the [`ObjectSet`](super::ObjectSet) |
/// | instance not implemented | 0x16 |
/// | malformed path | 0x04 |
/// | service not implemented for the class or the instance | 0x08 |
/// | attribute ID missing | 0x13 |
/// | attribute not implemented | 0x14 |
/// | attribute cannot be set | 0x0E |
/// | data shorter than the attribute | 0x13 |
/// | data longer than the attribute, data behind a Get | 0x15 |
/// | value, state of the object or of the device, storage | 0x09, 0x0C, 0x10, 0x19, by the object |
/// | reply larger than `out` | 0x11 |
///
/// Get_Attribute_Single is implemented for every instance, and for the class if it has attributes;
/// Set_Attribute_Single where [`Object::has_set`] says so. All other services are the business of
/// [`Object::service`]. A Set whose reply does not fit has been carried out.
pub fn serve<O: Object>(object: &mut O, call: &Call<'_>, out: &mut Writer<'_>) -> Result<Effects, Failure> {
    serve_any(object, call, out)
}

/// An object whose class is not known: one copy of the checks serves all classes.
trait AnyObject {
    fn rules(&self, instance: InstanceId) -> Option<&'static [AttributeRule]>;
    fn has_set(&self, instance: InstanceId) -> bool;
    fn get(&self, instance: InstanceId, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure>;
    fn set(
        &mut self,
        instance: InstanceId,
        attribute: AttributeId,
        value: &[u8],
        out: &mut Writer<'_>,
    ) -> Result<Effects, Failure>;
    fn service(&mut self, call: &Call<'_>, out: &mut Writer<'_>) -> Result<Effects, Failure>;
}

impl<O: Object> AnyObject for O {
    fn rules(&self, instance: InstanceId) -> Option<&'static [AttributeRule]> {
        rules(self, instance)
    }

    fn has_set(&self, instance: InstanceId) -> bool {
        Object::has_set(self, instance)
    }

    fn get(&self, instance: InstanceId, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure> {
        get(self, instance, attribute, out)
    }

    fn set(
        &mut self,
        instance: InstanceId,
        attribute: AttributeId,
        value: &[u8],
        out: &mut Writer<'_>,
    ) -> Result<Effects, Failure> {
        Object::set(self, instance, attribute, value, out)
    }

    fn service(&mut self, call: &Call<'_>, out: &mut Writer<'_>) -> Result<Effects, Failure> {
        Object::service(self, call, out)
    }
}

fn serve_any(object: &mut dyn AnyObject, call: &Call<'_>, out: &mut Writer<'_>) -> Result<Effects, Failure> {
    let Some(rules) = object.rules(call.instance) else { return Err(NO_INSTANCE) };
    call.check_path()?;
    // Get_Attribute_Single is implemented for the class if it has attributes.
    if call.service == ServiceCode::GET_ATTRIBUTE_SINGLE && !(call.instance.is_class() && rules.is_empty()) {
        let attribute = readable(call, rules)?;
        return object.get(call.instance, attribute, out).map(|()| Effects::NONE);
    }
    if call.service != ServiceCode::SET_ATTRIBUTE_SINGLE {
        return object.service(call, out);
    }
    match settable(call, rules) {
        Ok((attribute, value)) => {
            let effects = object.set(call.instance, attribute, value, out)?;
            Ok(effects.and(Effect::ATTRIBUTE_SET))
        }
        Err(failure) if object.has_set(call.instance) => Err(failure),
        Err(_) => object.service(call, out),
    }
}

/// The attribute of a Get, if the object has it.
fn readable(call: &Call<'_>, rules: &[AttributeRule]) -> Result<AttributeId, Failure> {
    let (attribute, rest) = call.attribute()?;
    if rule_of(rules, attribute).is_none() {
        return Err(NO_ATTRIBUTE);
    }
    if rest.is_empty() { Ok(attribute) } else { Err(GeneralStatus::TOO_MUCH_DATA.into()) }
}

/// The attribute of a Set and its value, if the object lets the attribute be set and the value has its length.
fn settable<'a>(call: &Call<'a>, rules: &[AttributeRule]) -> Result<(AttributeId, &'a [u8]), Failure> {
    let (attribute, value) = call.attribute()?;
    let Some(rule) = rule_of(rules, attribute) else { return Err(NO_ATTRIBUTE) };
    if !rule.is_settable() {
        return Err(GeneralStatus::ATTRIBUTE_NOT_SETTABLE.into());
    }
    rule.size().check(value)?;
    Ok((attribute, value))
}

/// The attributes of an instance, or of the class; `None` if there is no such instance.
pub(super) fn rules<O: Object + ?Sized>(
    object: &O,
    instance: InstanceId,
) -> Option<&'static [AttributeRule]> {
    if instance.is_class() { Some(object.class_attributes()) } else { object.attributes(instance) }
}

/// One copy of it for all classes.
#[inline(never)]
pub(super) fn is_any_settable(rules: Option<&[AttributeRule]>) -> bool {
    rules.unwrap_or_default().iter().any(AttributeRule::is_settable)
}

/// Writes the value of an attribute that the object has.
pub(super) fn get<O: Object>(
    object: &O,
    instance: InstanceId,
    attribute: AttributeId,
    out: &mut Writer<'_>,
) -> Result<(), Failure> {
    if instance.is_class() && attribute == REVISION {
        return Ok(out.u16(O::REVISION)?);
    }
    object.get(instance, attribute, out)
}

pub(super) const NO_INSTANCE: Failure = Failure::new(GeneralStatus::OBJECT_DOES_NOT_EXIST);
pub(super) const NO_ATTRIBUTE: Failure = Failure::new(GeneralStatus::ATTRIBUTE_NOT_SUPPORTED);
/// Class attribute 1.
const REVISION: AttributeId = AttributeId(1);
