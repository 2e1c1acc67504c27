//! Tests of all objects: what they share is here, what they are about in the modules.

mod acknowledge_handler;
mod assembly;
mod common;
mod identity;
mod message_router;
mod order;
mod parameter;
mod sets;
mod vectors;

use std::vec::Vec;

use super::{Call, Effects, FailureOptions, Object, ObjectSet, Size, respond};
use crate::code::InstanceId;
use crate::codec::Writer;
use crate::data_type::DataType;
use crate::message::{BodyFormat, Request};
use crate::names::{Access, Shape, attribute_info};

/// The response, from the service byte on, to a request in the format 8/8.
pub(super) fn ask(objects: &mut impl ObjectSet, body: &[u8]) -> Vec<u8> {
    answer(objects, BodyFormat::Class8Instance8, FailureOptions::default(), body).0
}

/// As [`ask`], with what the objects leave to do; nothing after a refusal.
pub(super) fn ask_effects(objects: &mut impl ObjectSet, body: &[u8]) -> (Vec<u8>, Effects) {
    answer(objects, BodyFormat::Class8Instance8, FailureOptions::default(), body)
}

/// As a server does it, with a response buffer of 64 bytes.
pub(super) fn answer(
    objects: &mut impl ObjectSet,
    format: BodyFormat,
    options: FailureOptions,
    body: &[u8],
) -> (Vec<u8>, Effects) {
    let mut buffer = [0xA5; 64];
    let mut out = Writer::new(&mut buffer);
    let request = Request::parse(format, body).unwrap();
    let effects = match Call::of(&request) {
        Ok(call) => respond(objects, &call, options, &mut out).unwrap_or_default(),
        Err(failure) => {
            failure.emit(&mut out).unwrap();
            Effects::NONE
        }
    };
    (out.written().to_vec(), effects)
}

/// Ties the tables of an object to the names: every attribute has one, is not freer than it allows, and takes as many
/// bytes as its type.
#[track_caller]
pub(super) fn agrees_with_names<O: Object>(object: &O, instances: &[u16]) {
    let tables = instances.iter().map(|&id| (InstanceId(id), object.attributes(InstanceId(id)).unwrap()));
    for (instance, rules) in tables.chain([(InstanceId::CLASS, object.class_attributes())]) {
        for rule in rules {
            let at = std::format!("{} {instance} {}", O::CLASS, rule.id());
            let info = attribute_info(O::CLASS, instance, rule.id()).expect(&at);
            assert!(!rule.is_settable() || info.access == Access::GetSet, "{at} cannot be set");
            match rule.size() {
                Size::Bytes(size) => {
                    let expected = info.shape.size().or((info.shape == Shape::Bytes).then_some(size.into()));
                    assert_eq!(expected, Some(size.into()), "size of {at}");
                }
                Size::ShortString => assert_eq!(info.shape, Shape::Data(DataType::ShortString), "{at}"),
                Size::Any => assert_eq!(info.shape.size(), None, "{at} has a size"),
            }
            let mut buffer = [0; 256];
            let mut out = Writer::new(&mut buffer);
            super::serve::get(object, instance, rule.id(), &mut out).expect(&at);
            assert!(rule.size().check(out.written()).is_ok(), "what {at} answers has its size");
        }
        let mut ids: Vec<_> = rules.iter().map(|rule| rule.id()).collect();
        ids.sort();
        ids.dedup();
        assert_eq!(ids.len(), rules.len(), "an attribute of {} is listed twice", O::CLASS);
    }
}
