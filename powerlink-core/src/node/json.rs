//! Events as one flat object each.

use link_core::recording::json::{Words, optional};
use serde::ser::{Serialize, SerializeMap, Serializer};

use super::event::NodeEvent;
use crate::fields;
use crate::monitor::Kind;

/// `event`, the name of the event, and its fields, named as those of a [`Reading`](crate::monitor::Reading).
impl Serialize for NodeEvent {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("event", self.name())?;
        match self {
            Self::StateChanged { from, to, cause } => {
                map.serialize_entry("from", from)?;
                map.serialize_entry("to", to)?;
                map.serialize_entry("cause", cause)?;
            }
            Self::StatusLed(led) => map.serialize_entry("value", led)?,
            Self::ErrorLed(is_on) => map.serialize_entry("value", is_on)?,
            Self::ResetReason { command, reason } => {
                map.serialize_entry("nmt_command", &Words(command))?;
                map.serialize_entry("reason", &Words(reason))?;
            }
            Self::ProcessData { channel, is_valid } => {
                map.serialize_entry("channel", channel)?;
                map.serialize_entry("valid", is_valid)?;
            }
            Self::ValueRefused { channel, object, code } => {
                map.serialize_entry("channel", channel)?;
                fields::object(&mut map, *object)?;
                fields::abort(&mut map, *code)?;
            }
            Self::ValueUnreadable { object, code } => {
                fields::object(&mut map, *object)?;
                fields::abort(&mut map, *code)?;
            }
            Self::ObjectWritten(at) => fields::object(&mut map, *at)?,
            Self::SdoAborted { command, code } => {
                map.serialize_entry("command", &Words(command))?;
                fields::abort(&mut map, *code)?;
            }
            Self::SdoOpened { client } | Self::SdoRefused { client } => {
                map.serialize_entry("client", client)?;
            }
            Self::SdoClosed { client, by_timeout } => {
                map.serialize_entry("client", client)?;
                map.serialize_entry("by_timeout", by_timeout)?;
            }
            Self::Error(code) => fields::error(&mut map, *code)?,
            Self::ForeignFrame { message, from } => {
                optional(&mut map, "kind", Kind::told(*message, None))?;
                map.serialize_entry("src", from)?;
            }
            Self::AddressConflict { source } => map.serialize_entry("src_mac", &Words(source))?,
            Self::BadFrame(error) => map.serialize_entry("problem", &Words(error))?,
            Self::BufferTooShort => {}
        }
        map.end()
    }
}

impl NodeEvent {
    const fn name(&self) -> &'static str {
        match self {
            Self::StateChanged { .. } => "state_changed",
            Self::StatusLed(_) => "status_led",
            Self::ErrorLed(_) => "error_led",
            Self::ResetReason { .. } => "reset_reason",
            Self::ProcessData { .. } => "process_data",
            Self::ValueRefused { .. } => "value_refused",
            Self::ValueUnreadable { .. } => "value_unreadable",
            Self::ObjectWritten(_) => "object_written",
            Self::SdoAborted { .. } => "sdo_aborted",
            Self::SdoOpened { .. } => "sdo_opened",
            Self::SdoClosed { .. } => "sdo_closed",
            Self::SdoRefused { .. } => "sdo_refused",
            Self::Error(_) => "error",
            Self::ForeignFrame { .. } => "foreign_frame",
            Self::AddressConflict { .. } => "address_conflict",
            Self::BadFrame(_) => "bad_frame",
            Self::BufferTooShort => "buffer_too_short",
        }
    }
}
