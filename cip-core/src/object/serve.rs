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
    let rules = rules(object, call.instance)?;
    let has_set = call.service == ServiceCode::SET_ATTRIBUTE_SINGLE && object.has_set(call.instance);
    match Step::of(call, rules, has_set)? {
        Step::Get(attribute) => get(object, call.instance, attribute, out).map(|()| Effects::NONE),
        Step::Set(attribute, value) => {
            let effects = object.set(call.instance, attribute, value, out)?;
            Ok(effects.then(Effect::ATTRIBUTE_SET.into()))
        }
        Step::Other => object.service(call, out),
    }
}

/// What is left to do after the checks.
enum Step<'a> {
    Get(AttributeId),
    Set(AttributeId, &'a [u8]),
    Other,
}

impl<'a> Step<'a> {
    /// The checks that need nothing of the object but its table: one copy of the code for all classes.
    fn of(call: &Call<'a>, rules: &[AttributeRule], has_set: bool) -> Result<Self, Failure> {
        call.check_path()?;
        let has_get = call.service == ServiceCode::GET_ATTRIBUTE_SINGLE
            && !(call.instance.is_class() && rules.is_empty());
        if !has_get && !has_set {
            return Ok(Self::Other);
        }
        let (attribute, value) = call.attribute()?;
        let rule = rule_of(rules, attribute)?;
        if has_get {
            return if value.is_empty() {
                Ok(Self::Get(attribute))
            } else {
                Err(GeneralStatus::TOO_MUCH_DATA.into())
            };
        }
        if !rule.is_settable() {
            return Err(GeneralStatus::ATTRIBUTE_NOT_SETTABLE.into());
        }
        rule.size().check(value)?;
        Ok(Self::Set(attribute, value))
    }
}

/// The attributes of an instance, or of the class; 0x16 if there is no such instance.
pub(super) fn rules<O: Object + ?Sized>(
    object: &O,
    instance: InstanceId,
) -> Result<&'static [AttributeRule], Failure> {
    if instance.is_class() {
        return Ok(object.class_attributes());
    }
    object.attributes(instance).ok_or(Failure::new(GeneralStatus::OBJECT_DOES_NOT_EXIST))
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

/// Class attribute 1.
const REVISION: AttributeId = AttributeId(1);
