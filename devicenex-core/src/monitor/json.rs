//! Readings as one flat object.

use cip_core::monitor::json::{Words, optional};
use cip_core::text::LowerHex;
use serde::ser::{Serialize, SerializeMap, Serializer};

use super::connections::ConnectionName;
use super::kind::Kind;
use super::reading::{Detail, Fields, Message, OnConnection, Reading};
use super::vocabulary::DEVICENEX;
use crate::message::{Granted, GroupSelect};

/// The fields that the decoder adds to those of the recorded frame (time, number, identifier, data), absent ones left
/// out:
///
/// `protocol`, `group`, `msg`, `src`, `dst`, `kind`, `transaction`, `service`, `service_name`, `requested` (the service that
/// was refused), `class`, `instance`, `attribute`, `attribute_name`, `status`, `additional`, `status_name`, `vendor`,
/// `product`, `revision`, `serial`, `port`, `stage` (of a Hello: `first`, `second`, `asked`, `response`), `requested_oa` (of a
/// ROAM), `predefined`, `group_select`, `source_message`, `epr`, `watchdog_action`, `body_format` (of a connection request or
/// response), `value`, `value_text`, `connection` { `server`, `client`, `instance`, `name`, `state` }, `frag` { `type`,
/// `count`, `status` }, `message` { the same for the whole message, `data` }, `request` { `n`, `latency` in seconds },
/// `problem`, `problem_code`, `note`, `assumed`, `text`.
impl Serialize for Reading<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("protocol", if self.kind == Kind::Foreign { "unknown" } else { "devicenex" })?;
        optional(&mut map, "group", self.group())?;
        optional(&mut map, "msg", self.msg())?;
        optional(&mut map, "src", self.src.map(u8::from))?;
        optional(&mut map, "dst", self.dst.map(u8::from))?;
        map.serialize_entry("kind", &self.kind)?;
        fields(&mut map, self.kind, &self.fields, self.value())?;
        optional(&mut map, "connection", self.connection)?;
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

impl Serialize for OnConnection {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("server", &u8::from(self.server))?;
        optional(&mut map, "client", self.client.map(u8::from))?;
        if let ConnectionName::Instance(instance) = self.name {
            map.serialize_entry("instance", &instance)?;
        }
        map.serialize_entry("name", &Words(self.name))?;
        map.serialize_entry("state", &self.state)?;
        map.end()
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
    optional(map, "transaction", fields.transaction)?;
    // The detail tells the instance.
    fields.explicit.entries(map, &DEVICENEX, fields.service_name(kind), None)?;
    optional(map, "vendor", fields.device.map(|device| device.vendor))?;
    optional(map, "product", fields.device.map(|device| device.product_code))?;
    optional(map, "revision", fields.device.map(|device| device.major_revision))?;
    optional(map, "serial", fields.device.map(|device| device.serial))?;
    optional(map, "port", fields.port)?;
    detail(map, fields)?;
    optional(map, "value", value.map(|value| Words(LowerHex(value))))?;
    optional(map, "value_text", fields.text_of(value.unwrap_or_default()).map(Words))
}

fn detail<M: SerializeMap>(map: &mut M, fields: &Fields<'_>) -> Result<(), M::Error> {
    match fields.detail {
        Detail::None => optional(map, "instance", fields.explicit.instance),
        Detail::Hello(stage) => map.serialize_entry("stage", stage.name()),
        Detail::MiniWho { serial_low } => map.serialize_entry("serial_low", &serial_low),
        Detail::Roam { requested } => map.serialize_entry("requested_oa", &u8::from(requested)),
        Detail::Connect(connect) => {
            map.serialize_entry("predefined", &connect.predefined)?;
            group(map, connect.group)?;
            map.serialize_entry("source_message", &connect.source_message)?;
            optional(map, "instance", connect.target.map(|target| target.instance))?;
            optional(map, "epr", connect.target.map(|target| target.expected_packet_rate))?;
            optional(map, "watchdog_action", connect.target.map(|target| target.watchdog_action))
        }
        Detail::Granted { response, instance } => {
            let rate = match response.granted {
                Granted::Predefined { expected_packet_rate } => Some(expected_packet_rate),
                Granted::Dynamic { .. } => None,
            };
            map.serialize_entry("predefined", &rate.is_some())?;
            group(map, response.group)?;
            map.serialize_entry("source_message", &response.source_message)?;
            optional(map, "instance", instance)?;
            optional(map, "epr", rate)?;
            map.serialize_entry("body_format", &(response.body_format.0 & 0x0F))
        }
    }
}

fn group<M: SerializeMap>(map: &mut M, group: GroupSelect) -> Result<(), M::Error> {
    map.serialize_entry("group_select", &group)
}
