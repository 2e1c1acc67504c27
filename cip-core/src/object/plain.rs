//! Objects without tables.

use super::serve::{NO_ATTRIBUTE, NO_INSTANCE};
use super::{Call, Failure};
use crate::code::{AttributeId, GeneralStatus, ServiceCode};
use crate::codec::Writer;

/// An object that has no [tables](super::AttributeRule) of its attributes: [`get`](Self::get) and [`set`](Self::set) say
/// themselves what there is, which is less code where they do so anyhow. It may be of one class or of another, as the request
/// says. What is left to do after the response it notes itself.
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
    ) -> Result<(), Failure>;

    /// Carries out any other service, as [`Object::service`](super::Object::service) does, but returns no effects: what is left
    /// to do it notes itself.
    fn service(&mut self, call: &Call<'_>, out: &mut Writer<'_>) -> Result<(), Failure>;
}

/// Carries out a request with the checks of [`serve`](super::serve), in the same order.
pub fn serve_plain<O: PlainObject>(
    object: &mut O,
    call: &Call<'_>,
    out: &mut Writer<'_>,
) -> Result<(), Failure> {
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
                done => done,
            }
        }
        ServiceCode::SET_ATTRIBUTE_SINGLE if object.has_set(call) => {
            let (attribute, value) = call.attribute()?;
            match object.set(call, attribute, value, out) {
                // What cannot be set can be read, or is not there.
                Err(NOT_SETTABLE) if object.get(call, attribute, out) == Err(NO_ATTRIBUTE) => {
                    Err(NO_ATTRIBUTE)
                }
                done => done,
            }
        }
        _ => object.service(call, out),
    }
}

const NOT_SETTABLE: Failure = Failure::new(GeneralStatus::ATTRIBUTE_NOT_SETTABLE);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::code::{ClassId, InstanceId};
    use crate::object::{AttributeRule, Effects, FailureOptions, Object, exact, respond_with, serve};
    use std::vec::Vec;

    /// Instance 1 has attribute 1, and 2 which can be set; instance 2 has attribute 1 alone. As an object with tables, and
    /// without.
    struct Toy(u16);

    impl Object for Toy {
        const CLASS: ClassId = ClassId(0x64);

        fn attributes(&self, instance: InstanceId) -> Option<&'static [AttributeRule]> {
            const RULES: &[AttributeRule] = &[AttributeRule::get(1, 1), AttributeRule::get_set(2, 2)];
            match instance.0 {
                1 => Some(RULES),
                2 => RULES.get(..1),
                _ => None,
            }
        }

        fn get(&self, _: InstanceId, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure> {
            let written = if attribute.0 == 1 { out.u8(7) } else { out.u16(self.0) };
            Ok(written?)
        }

        fn set(
            &mut self,
            _: InstanceId,
            _: AttributeId,
            value: &[u8],
            _: &mut Writer<'_>,
        ) -> Result<Effects, Failure> {
            self.0 = u16::from_le_bytes(exact(value)?);
            Ok(Effects::NONE)
        }
    }

    impl PlainObject for Toy {
        fn exists(&self, call: &Call<'_>) -> bool {
            call.instance.0 <= 2
        }

        fn has_set(&self, call: &Call<'_>) -> bool {
            call.instance.0 == 1
        }

        fn get(
            &mut self,
            call: &Call<'_>,
            attribute: AttributeId,
            out: &mut Writer<'_>,
        ) -> Result<(), Failure> {
            match (call.instance.0, attribute.0) {
                (0, 1) => Ok(out.u16(1)?),
                (1 | 2, 1) => Ok(out.u8(7)?),
                (1, 2) => Ok(out.u16(self.0)?),
                _ => Err(NO_ATTRIBUTE),
            }
        }

        fn set(
            &mut self,
            _: &Call<'_>,
            attribute: AttributeId,
            value: &[u8],
            _: &mut Writer<'_>,
        ) -> Result<(), Failure> {
            if attribute.0 != 2 {
                return Err(NOT_SETTABLE);
            }
            self.0 = u16::from_le_bytes(exact(value)?);
            Ok(())
        }

        fn service(&mut self, _: &Call<'_>, _: &mut Writer<'_>) -> Result<(), Failure> {
            Err(GeneralStatus::SERVICE_NOT_SUPPORTED.into())
        }
    }

    /// What is answered by `serve`, and what is left in the object.
    fn answered(
        call: &Call<'_>,
        room: usize,
        serve: impl FnOnce(&mut Toy, &Call<'_>, &mut Writer<'_>) -> Result<(), Failure>,
    ) -> (Vec<u8>, Result<(), Failure>, u16) {
        let mut toy = Toy(0x1234);
        let mut buffer = [0; 8];
        let mut out = Writer::new(&mut buffer[..room]);
        let done = respond_with(call, FailureOptions::default(), &mut out, |out| serve(&mut toy, call, out));
        (out.written().to_vec(), done, toy.0)
    }

    #[test]
    fn it_is_answered_as_with_tables() {
        let data: Vec<Vec<u8>> = (0..4_u8)
            .flat_map(|attribute| (0..4).map(move |n| [&[attribute][..], &[9; 3][..n]].concat()))
            .collect();
        let mut set = 0;
        for (service, instance) in
            [0x0E, 0x10, 0x05].into_iter().flat_map(|service| (0..4).map(move |n| (service, n)))
        {
            for data in data.iter().map(Vec::as_slice).chain([&[][..]]) {
                for room in [3, 8] {
                    let call = Call::new(ServiceCode(service), ClassId(0x64), InstanceId(instance), data);
                    let plain = answered(&call, room, serve_plain);
                    let with_tables = |toy: &mut Toy, call: &Call<'_>, out: &mut Writer<'_>| {
                        serve(toy, call, out).map(|_| ())
                    };
                    assert_eq!(plain, answered(&call, room, with_tables), "{call:?}");
                    set += usize::from(plain.2 != 0x1234);
                }
            }
        }
        assert_eq!(set, 2);
    }
}
