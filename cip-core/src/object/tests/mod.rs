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

use super::{Call, Effects, FailureOptions, ObjectSet, respond};
use crate::codec::Writer;
use crate::message::{BodyFormat, Request};

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
