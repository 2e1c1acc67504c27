//! Several objects behind one door.

use super::{Call, Effects, Failure, FailureOptions, Object, serve};
use crate::code::{ClassId, GeneralStatus};
use crate::codec::Writer;

/// The objects that a device serves: `()`, a tuple of up to eight [`Object`]s, or a [`Chain`] of sets. The compiler
/// knows each of them, so that a request costs a comparison of class IDs and a direct call.
///
/// If two objects are of one class, the first serves it.
pub trait ObjectSet {
    /// Carries out a request as [`serve`] does; `None` if no object is of its class.
    fn serve(&mut self, call: &Call<'_>, out: &mut Writer<'_>) -> Option<Result<Effects, Failure>>;

    /// The classes, in their order in the set.
    fn classes(&self) -> impl Iterator<Item = ClassId>;

    /// True if an object of the class is there.
    fn contains(&self, class: ClassId) -> bool {
        self.classes().any(|own| own == class)
    }
}

/// Two sets as one: the first one's objects, then the second one's.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Chain<A, B>(pub A, pub B);

/// Writes the whole response to a request, from the service byte on.
///
/// | | Byte 0 | then |
/// |---|---|---|
/// | carried out | service code + 0x80 | service data |
/// | refused | 0x94 | general status, additional code |
///
/// Returns what was answered. `out` needs room for three bytes, or else a refusal leaves it as it was.
///
/// ```
/// use cip_core::code::{ClassId, InstanceId, ServiceCode};
/// use cip_core::codec::Writer;
/// use cip_core::object::{Call, FailureOptions, respond};
///
/// // A device without any objects.
/// let call = Call::new(ServiceCode::GET_ATTRIBUTE_SINGLE, ClassId::IDENTITY, InstanceId(1), &[7]);
/// let mut buffer = [0; 8];
/// let mut out = Writer::new(&mut buffer);
/// let answered = respond(&mut (), &call, FailureOptions::default(), &mut out);
/// assert!(answered.is_err());
/// assert_eq!(out.written(), [0x94, 0x16, 0xFF]);
/// ```
pub fn respond<S: ObjectSet>(
    objects: &mut S,
    call: &Call<'_>,
    options: FailureOptions,
    out: &mut Writer<'_>,
) -> Result<Effects, Failure> {
    respond_with(call, options, out, |out| {
        objects.serve(call, out).unwrap_or(Err(GeneralStatus::OBJECT_DOES_NOT_EXIST.into()))
    })
}

/// The same for a device that finds the object itself: `serve` writes the service data.
#[inline]
pub fn respond_with<T>(
    call: &Call<'_>,
    options: FailureOptions,
    out: &mut Writer<'_>,
    serve: impl FnOnce(&mut Writer<'_>) -> Result<T, Failure>,
) -> Result<T, Failure> {
    let start = out.len();
    let result = match out.u8(call.service.response_byte()) {
        Ok(()) => serve(out),
        Err(full) => Err(full.into()),
    };
    match result {
        Err(failure) => Err(refuse(failure.under(options, call.is_by_path()), start, out)),
        done @ Ok(_) => done,
    }
}

/// Writes an error response in the place of what was written from `start` on.
// In line it is longer, cold or not.
#[cold]
#[inline(never)]
fn refuse(failure: Failure, start: usize, out: &mut Writer<'_>) -> Failure {
    out.truncate(start);
    // A refusal that has no room is none: the owner sees the failure and an empty `out`.
    let _ = failure.emit(out);
    failure
}

impl<S: ObjectSet> ObjectSet for &mut S {
    fn serve(&mut self, call: &Call<'_>, out: &mut Writer<'_>) -> Option<Result<Effects, Failure>> {
        (**self).serve(call, out)
    }

    fn classes(&self) -> impl Iterator<Item = ClassId> {
        (**self).classes()
    }
}

impl<A: ObjectSet, B: ObjectSet> ObjectSet for Chain<A, B> {
    fn serve(&mut self, call: &Call<'_>, out: &mut Writer<'_>) -> Option<Result<Effects, Failure>> {
        self.0.serve(call, out).or_else(|| self.1.serve(call, out))
    }

    fn classes(&self) -> impl Iterator<Item = ClassId> {
        self.0.classes().chain(self.1.classes())
    }
}

macro_rules! tuples {
    ($(($($Object:ident $object:ident)*);)*) => {$(
        impl<$($Object: Object),*> ObjectSet for ($($Object,)*) {
            fn serve(
                &mut self,
                _call: &Call<'_>,
                _out: &mut Writer<'_>,
            ) -> Option<Result<Effects, Failure>> {
                let ($($object,)*) = self;
                $(
                    if _call.class == $Object::CLASS {
                        return Some(serve($object, _call, _out));
                    }
                )*
                None
            }

            fn classes(&self) -> impl Iterator<Item = ClassId> {
                [$($Object::CLASS),*].into_iter()
            }
        }
    )*};
}

tuples! {
    ();
    (A a);
    (A a B b);
    (A a B b C c);
    (A a B b C c D d);
    (A a B b C c D d E e);
    (A a B b C c D d E e F f);
    (A a B b C c D d E e F f G g);
    (A a B b C c D d E e F f G g H h);
}
