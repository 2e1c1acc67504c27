//! The laws of an object as assertions, for the tests of this and other crates. They need neither `std` nor `alloc`.

use super::serve::get;
use super::{Object, Size};
use crate::code::InstanceId;
use crate::codec::Writer;
use crate::data_type::DataType;
use crate::names::{Access, Shape, attribute_info};

/// Ties the tables of an object to the names: every attribute has one, is listed once, is not freer than the names
/// allow, takes as many bytes as its type, and can be read with that size.
///
/// `instances` are those to look at, besides the class. Attributes of the vendor (0x64-0xC7) need no name.
#[track_caller]
pub fn agrees_with_names<O: Object>(object: &O, instances: &[u16]) {
    for instance in instances.iter().copied().map(InstanceId).chain([InstanceId::CLASS]) {
        let rules =
            if instance.is_class() { Some(object.class_attributes()) } else { object.attributes(instance) };
        let rules = rules.unwrap_or_default();
        assert!(instance.is_class() || object.attributes(instance).is_some(), "{} {instance}", O::CLASS);
        for rule in rules {
            let id = rule.id();
            let times = rules.iter().filter(|other| other.id() == id).count();
            assert!(times == 1, "{} {instance} {id} is listed {times} times", O::CLASS);

            let mut buffer = [0; 256];
            let mut out = Writer::new(&mut buffer);
            let read = get(object, instance, id, &mut out);
            assert!(read.is_ok(), "{} {instance} {id} is listed and cannot be read: {read:?}", O::CLASS);
            let sized = rule.size().check(out.written());
            assert!(sized.is_ok(), "{} {instance} {id} has not the size listed", O::CLASS);

            let Some(info) = attribute_info(O::CLASS, instance, id) else {
                assert!(matches!(id.0, 0x64..=0xC7), "{} {instance} {id} has no name", O::CLASS);
                continue;
            };
            let allowed = !rule.is_settable() || info.access == Access::GetSet;
            assert!(allowed, "{} {instance} {id} can be set", O::CLASS);
            let agrees = match rule.size() {
                Size::Bytes(size) => {
                    info.shape == Shape::Bytes || info.shape.size() == Some(usize::from(size))
                }
                Size::ShortString => info.shape == Shape::Data(DataType::ShortString),
                Size::Any => info.shape.size().is_none(),
            };
            assert!(agrees, "{} {instance} {id} has another size than {:?}", O::CLASS, info.shape);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::code::{AttributeId, ClassId};
    use crate::object::{AttributeRule, Failure};

    /// A Message Router that answers two bytes to everything.
    struct Listing(&'static [AttributeRule]);

    impl Object for Listing {
        const CLASS: ClassId = ClassId::MESSAGE_ROUTER;

        fn attributes(&self, instance: InstanceId) -> Option<&'static [AttributeRule]> {
            (instance.0 == 1).then_some(self.0)
        }

        fn get(&self, _: InstanceId, _: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure> {
            Ok(out.u16(0)?)
        }
    }

    #[test]
    fn a_table_by_the_names() {
        agrees_with_names(&Listing(&const { [AttributeRule::get(2, 2), AttributeRule::get(100, 2)] }), &[1]);
    }

    #[test]
    #[should_panic(expected = "has another size than Data(Uint)")]
    fn another_type() {
        agrees_with_names(&Listing(&const { [AttributeRule::get(2, 0).sized(Size::Any)] }), &[1]);
    }

    #[test]
    #[should_panic(expected = "has not the size listed")]
    fn another_value() {
        agrees_with_names(&Listing(&const { [AttributeRule::get(2, 1)] }), &[1]);
    }

    #[test]
    #[should_panic(expected = "can be set")]
    fn too_much_freedom() {
        agrees_with_names(&Listing(&const { [AttributeRule::get_set(2, 2)] }), &[1]);
    }

    #[test]
    #[should_panic(expected = "has no name")]
    fn unknown() {
        agrees_with_names(&Listing(&const { [AttributeRule::get(9, 2)] }), &[1]);
    }

    #[test]
    #[should_panic(expected = "is listed 2 times")]
    fn twice() {
        agrees_with_names(&Listing(&const { [AttributeRule::get(2, 2), AttributeRule::get(2, 2)] }), &[1]);
    }
}
