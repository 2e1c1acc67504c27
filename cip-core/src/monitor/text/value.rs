//! What values mean.

use core::fmt::{self, Display, Formatter};

use super::service::ServiceText;
use crate::code::{AttributeId, ClassId, InstanceId, ServiceCode};
use crate::monitor::{Explicit, PacketRate, Vocabulary};
use crate::names::Shape;
use crate::text::{Hex, write_decimal};
use crate::value::ShapedValue;

/// What the value of an explicit message means: `EPR 75 ms`, `Vendor 12 (Banner Engineering)`.
#[derive(Debug, Clone, Copy)]
pub struct ValueText<'a> {
    explicit: &'a Explicit<'a>,
    vocabulary: &'a Vocabulary,
    value: &'a [u8],
}

impl Explicit<'_> {
    /// What `value`, the value of this message, means; `None` where the bytes have no known meaning.
    #[must_use]
    pub fn text_of<'a>(&'a self, vocabulary: &'a Vocabulary, value: &'a [u8]) -> Option<ValueText<'a>> {
        let is_known = self.class.is_some() && self.instance.is_some() && self.attribute.is_some();
        let has_meaning = self.rate.is_some()
            || match self.requested.or(self.service) {
                Some(ServiceCode::GET_ATTRIBUTE_SINGLE | ServiceCode::SET_ATTRIBUTE_SINGLE) => {
                    !value.is_empty() && is_known && self.status.is_none()
                }
                _ => ServiceText::of(self, vocabulary, value).is_some(),
            };
        has_meaning.then_some(ValueText { explicit: self, vocabulary, value })
    }
}

impl Display for ValueText<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { explicit, vocabulary, value } = *self;
        if let Some(rate) = explicit.rate {
            return write_rate(f, rate);
        }
        if let Some(text) = ServiceText::of(explicit, vocabulary, value) {
            return text.write(f, explicit, vocabulary);
        }
        match (explicit.class, explicit.instance, explicit.attribute) {
            (Some(class), Some(instance), Some(attribute)) => {
                write_attribute(f, vocabulary, class, instance, attribute, value)
            }
            _ => Hex(value).fmt(f),
        }
    }
}

/// The name of an attribute and its value.
pub(super) fn write_attribute(
    f: &mut Formatter<'_>,
    vocabulary: &Vocabulary,
    class: ClassId,
    instance: InstanceId,
    attribute: AttributeId,
    data: &[u8],
) -> fmt::Result {
    let info = (vocabulary.attribute)(class, instance, attribute);
    match short_name(class, instance, attribute).or(info.map(|info| info.name)) {
        Some(name) => f.write_str(name)?,
        None => attribute.fmt(f)?,
    }
    f.write_str(" ")?;
    ShapedValue { shape: info.map_or(Shape::Bytes, |info| info.shape), data }.fmt(f)
}

fn write_rate(f: &mut Formatter<'_>, rate: PacketRate) -> fmt::Result {
    f.write_str("EPR ")?;
    write_decimal(f, rate.used.into())?;
    f.write_str(" ms")?;
    if rate.requested == rate.used {
        return Ok(());
    }
    f.write_str(" (")?;
    write_decimal(f, rate.requested.into())?;
    f.write_str(" ms requested)")
}

/// Names that are shorter than those of the specification.
fn short_name(class: ClassId, instance: InstanceId, attribute: AttributeId) -> Option<&'static str> {
    match (class, attribute.0) {
        _ if instance.is_class() => None,
        (ClassId::CONNECTION, 9) => Some("EPR"),
        (ClassId::IDENTITY, 1) => Some("Vendor"),
        _ => None,
    }
}
