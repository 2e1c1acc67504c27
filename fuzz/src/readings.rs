//! What must hold for every reading of the passive decoder, whatever the frame and whatever came before it.

use core::fmt::Display;

use devicenet_core::Identifier;
use devicenet_core::monitor::{Kind, Reading};
use link_core::Frame;
use serde_json::{Map, Value};

use crate::passive::{self, contains};

/// Judges a reading of `frame`; returns its line.
pub(crate) fn judge(reading: &Reading<'_>, frame: &Frame) -> String {
    assert_eq!(reading.frame, *frame);
    identifier(reading, frame);
    let problem = reading.problem.as_ref().map(|problem| (problem as &dyn Display, problem.code()));
    let text = passive::line(reading, &reading.words(), problem, LONGEST_LINE);
    assert!(problem.is_some() || !text.contains(" ! "), "a problem that is none: {text}");
    json(reading, &text);
    text
}

/// The group and the Message ID are those of the identifier; what is no DeviceNet frame is foreign.
fn identifier(reading: &Reading<'_>, frame: &Frame) {
    let Some(id) = Identifier::of_frame(frame) else {
        assert!(frame.is_extended() || frame.is_remote(), "{frame}");
        assert_eq!((reading.kind, reading.group, reading.msg), (Kind::Foreign, None, None), "{frame}");
        return;
    };
    assert_ne!(reading.kind, Kind::Foreign, "{frame}");
    assert_eq!(reading.group, id.group().number(), "{frame}");
    assert_eq!(reading.msg, reading.group.map(|_| id.message_id()), "{frame}");
    if let Some(mac) = id.mac_id().filter(|_| reading.kind != Kind::MulticastPollCommand) {
        let ends = [reading.src, reading.dst];
        assert!(ends == [None, None] || ends.contains(&Some(mac)), "{mac} is neither end of {reading}");
    }
    if let Some(value) = reading.value() {
        assert!(contains(frame.data(), value), "{value:02X?} is a piece of {frame}");
    }
}

/// The JSON object says the same as the fields.
fn json(reading: &Reading<'_>, text: &str) {
    let json = serde_json::to_string(reading).expect("a reading always serialises");
    let object = passive::object(&json, text, reading.kind.name());
    let number = |key: &str| object.get(key).and_then(Value::as_u64);
    assert_eq!(number("group"), reading.group.map(u64::from), "{json}");
    assert_eq!(number("msg"), reading.msg.map(u64::from), "{json}");
    assert_eq!(number("src"), reading.src.map(|mac| mac.number().into()), "{json}");
    assert_eq!(number("dst"), reading.dst.map(|mac| mac.number().into()), "{json}");
    assert_eq!(object.contains_key("problem"), reading.problem.is_some(), "{json}");
    assert_eq!(object.contains_key("message"), reading.message.is_some(), "{json}");
    assert_eq!(object.contains_key("request"), reading.request.is_some(), "{json}");
    values(&object, reading.value());
    if let (Some(message), Some(Value::Object(object))) = (reading.message, object.get("message")) {
        values(object, message.value());
        assert_eq!(object["data"], hex(message.data));
        assert!(message.value().is_none_or(|value| contains(message.data, value)), "{json}");
    }
    assert!(!has_null(&Value::Object(object)), "absent fields are left out: {json}");
}

fn values(object: &Map<String, Value>, value: Option<&[u8]>) {
    assert_eq!(object.get("value").cloned(), value.map(|value| Value::String(hex(value))));
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// A number that is not finite becomes null.
fn has_null(value: &Value) -> bool {
    match value {
        Value::Null => true,
        Value::Array(items) => items.iter().any(has_null),
        Value::Object(fields) => fields.values().any(has_null),
        Value::Bool(_) | Value::Number(_) | Value::String(_) => false,
    }
}

/// A message of 512 bytes in hexadecimal, and words around it.
const LONGEST_LINE: usize = 4096;
