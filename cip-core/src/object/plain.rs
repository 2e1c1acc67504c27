//! Objects without tables.

use super::serve::{NO_ATTRIBUTE, NO_INSTANCE};
use super::{Call, Effect, Effects, Failure};
use crate::code::{AttributeId, GeneralStatus, ServiceCode};
use crate::codec::Writer;

/// An object that has no [tables](super::AttributeRule) of its attributes: [`get`](Self::get) and [`set`](Self::set) say
/// themselves what there is, which is less code where they do so anyhow. It may be of one class or of another, as the request
/// says.
pub trait PlainObject {
    /// Whether there is the instance; 0 is the class.
    fn exists(&self, call: &Call<'_>) -> bool;

    /// Whether an attribute of the instance can be set at all.
    fn has_set(&self, call: &Call<'_>) -> bool;

    /// Writes the value of an attribute of an instance that exists, the class included; 0x14 if it has none of that number.
    fn get(&mut self, call: &Call<'_>, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure>;

    /// Sets an attribute, if the value has its length; 0x0E if it cannot be set or is not there. A failure must leave the
    /// object as it was.
    fn set(
        &mut self,
        call: &Call<'_>,
        attribute: AttributeId,
        value: &[u8],
        out: &mut Writer<'_>,
    ) -> Result<Effects, Failure>;

    /// Carries out any other service, as [`Object::service`](super::Object::service) does.
    fn service(&mut self, call: &Call<'_>, out: &mut Writer<'_>) -> Result<Effects, Failure>;
}

/// Carries out a request with the checks of [`serve`](super::serve), in the same order.
pub fn serve_plain<O: PlainObject>(
    object: &mut O,
    call: &Call<'_>,
    out: &mut Writer<'_>,
) -> Result<Effects, Failure> {
    if !object.exists(call) {
        return Err(NO_INSTANCE);
    }
    call.check_path()?;
    match call.service {
        ServiceCode::GET_ATTRIBUTE_SINGLE => {
            let (attribute, rest) = call.attribute()?;
            match object.get(call, attribute, out) {
                Err(NO_ATTRIBUTE) => Err(NO_ATTRIBUTE),
                _ if !rest.is_empty() => Err(GeneralStatus::TOO_MUCH_DATA.into()),
                done => done.map(|()| Effects::NONE),
            }
        }
        ServiceCode::SET_ATTRIBUTE_SINGLE if object.has_set(call) => {
            let (attribute, value) = call.attribute()?;
            match object.set(call, attribute, value, out) {
                // What cannot be set can be read, or is not there.
                Err(NOT_SETTABLE) if object.get(call, attribute, out) == Err(NO_ATTRIBUTE) => {
                    Err(NO_ATTRIBUTE)
                }
                done => done.map(|effects| effects.and(Effect::ATTRIBUTE_SET)),
            }
        }
        _ => object.service(call, out),
    }
}

const NOT_SETTABLE: Failure = Failure::new(GeneralStatus::ATTRIBUTE_NOT_SETTABLE);
