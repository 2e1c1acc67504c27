//! Readings as one flat object.

use cip_core::monitor::Vocabulary;
use cip_core::monitor::json::{Words, optional};
use cip_core::text::LowerHex;
use serde::ser::{Serialize, SerializeMap, Serializer};

use super::connections::{ConnectionName, Predefined};
use super::kind::Kind;
use super::reading::{Fields, Message, Reading};

/// The fields that the decoder adds to those of the recorded frame (time, number, identifier, data), absent ones left
/// out:
///
/// `protocol`, `group`, `msg`, `src`, `dst`, `kind`, `service`, `service_name`, `requested` (the service that was
/// refused), `class`, `instance`, `attribute`, `attribute_name`, `status`, `additional`, `status_name`, `choice`,
/// `vendor`, `serial`, `port`, `value`, `value_text`, `frag` { `type`, `count`, `status` }, `message` { the same for the whole message, `data` }, `request`
/// { `n`, `latency` in seconds }, `problem`, `problem_code`, `note`, `assumed`, `text`.
impl Serialize for Reading<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("protocol", if self.kind == Kind::Foreign { "unknown" } else { "devicenet" })?;
        optional(&mut map, "group", self.group)?;
        optional(&mut map, "msg", self.msg)?;
        optional(&mut map, "src", self.src.map(u8::from))?;
        optional(&mut map, "dst", self.dst.map(u8::from))?;
        map.serialize_entry("kind", &self.kind)?;
        fields(&mut map, self.kind, &self.fields, self.value())?;
        optional(&mut map, "frag", self.frag)?;
        optional(&mut map, "message", self.message)?;
        optional(&mut map, "request", self.request)?;
        optional(&mut map, "problem", self.problem)?;
        optional(&mut map, "problem_code", self.problem.map(|problem| problem.code()))?;
        optional(&mut map, "note", self.note.map(Words))?;
        if self.assumed {
            map.serialize_entry("assumed", &true)?;
        }
        map.serialize_entry("text", &Words(self))?;
        map.end()
    }
}

impl Serialize for Message<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("kind", &self.kind)?;
        fields(&mut map, self.kind, &self.fields, self.value())?;
        map.serialize_entry("data", &Words(LowerHex(self.data)))?;
        map.end()
    }
}

impl Serialize for Predefined {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl Serialize for ConnectionName {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

fn fields<M: SerializeMap>(
    map: &mut M,
    kind: Kind,
    fields: &Fields<'_>,
    value: Option<&[u8]>,
) -> Result<(), M::Error> {
    let explicit = &fields.explicit;
    explicit.entries(map, &Vocabulary::DEVICENET, fields.service_name(kind), explicit.instance)?;
    optional(map, "choice", fields.choice.map(|choice| choice.bits()))?;
    optional(map, "vendor", fields.vendor)?;
    optional(map, "serial", fields.serial)?;
    optional(map, "port", fields.port)?;
    optional(map, "value", value.map(|value| Words(LowerHex(value))))?;
    optional(map, "value_text", fields.text_of(value.unwrap_or_default()).map(Words))
}
