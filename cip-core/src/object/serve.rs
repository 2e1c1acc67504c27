//! The checks that every request meets before its object.

use super::rule::rule_of;
use super::{AttributeRule, Call, Effect, Effects, Failure, Object};
use crate::code::{AttributeId, GeneralStatus, InstanceId, ServiceCode};
use crate::codec::Writer;

/// Carries out a request for the class of `object`, and writes the service data of the response to `out`. After a
/// failure nothing of it is left in `out`.
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
    let start = out.len();
    let result = dispatch(object, call, out);
    if result.is_err() {
        out.truncate(start);
    }
    result
}

fn dispatch<O: Object>(object: &mut O, call: &Call<'_>, out: &mut Writer<'_>) -> Result<Effects, Failure> {
    let rules = rules(object, call.instance)?;
    call.check_path()?;
    match call.service {
        ServiceCode::GET_ATTRIBUTE_SINGLE if !(call.instance.is_class() && rules.is_empty()) => {
            let attribute = check_get(rules, call)?;
            get(object, call.instance, attribute, out)?;
            Ok(Effects::NONE)
        }
        ServiceCode::SET_ATTRIBUTE_SINGLE if object.has_set(call.instance) => {
            let (attribute, value) = check_set(rules, call)?;
            Ok(object.set(call.instance, attribute, value, out)?.then(Effect::ATTRIBUTE_SET.into()))
        }
        _ => object.service(call, out),
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

fn check_get(rules: &[AttributeRule], call: &Call<'_>) -> Result<AttributeId, Failure> {
    let (attribute, value) = call.attribute()?;
    rule_of(rules, attribute)?;
    if value.is_empty() { Ok(attribute) } else { Err(GeneralStatus::TOO_MUCH_DATA.into()) }
}

fn check_set<'a>(rules: &[AttributeRule], call: &Call<'a>) -> Result<(AttributeId, &'a [u8]), Failure> {
    let (attribute, value) = call.attribute()?;
    let rule = rule_of(rules, attribute)?;
    if !rule.is_settable() {
        return Err(GeneralStatus::ATTRIBUTE_NOT_SETTABLE.into());
    }
    rule.size.check(value)?;
    Ok((attribute, value))
}

/// Class attribute 1.
const REVISION: AttributeId = AttributeId(1);
