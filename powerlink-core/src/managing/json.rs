//! Events as one flat object each.

use link_core::recording::json::Words;
use serde::ser::{Serialize, SerializeMap, Serializer};

use super::event::MnEvent;
use crate::fields;

/// `event`, the name of the event, and its fields, named as those of a [`Reading`](crate::monitor::Reading); `node` is whom it is
/// about.
impl Serialize for MnEvent {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("event", self.name())?;
        match self {
            Self::StateChanged { from, to, cause } => {
                map.serialize_entry("from", from)?;
                map.serialize_entry("to", to)?;
                map.serialize_entry("cause", cause)?;
            }
            Self::NodeChanged { node, from, to, cause } => {
                map.serialize_entry("node", node)?;
                map.serialize_entry("from", from)?;
                map.serialize_entry("to", to)?;
                map.serialize_entry("cause", cause)?;
            }
            Self::NodeLost { node, reason } | Self::NodeRefused { node, reason } => {
                map.serialize_entry("node", node)?;
                map.serialize_entry("reason", &Words(reason))?;
            }
            Self::ConfigurationAborted { node, at, code } | Self::SdoFailed { node, at, code } => {
                map.serialize_entry("node", node)?;
                fields::object(&mut map, *at)?;
                fields::abort(&mut map, *code)?;
            }
            Self::Inputs { node, is_valid } => {
                map.serialize_entry("node", node)?;
                map.serialize_entry("valid", is_valid)?;
            }
            Self::PresLost { node } | Self::PresLate { node } | Self::UnknownNode(node) => {
                map.serialize_entry("node", node)?;
            }
            Self::NodeError { node, code } => {
                map.serialize_entry("node", node)?;
                fields::error(&mut map, *code)?;
            }
            Self::NmtRequested { from, command, target } => {
                map.serialize_entry("node", from)?;
                map.serialize_entry("nmt_command", &Words(command))?;
                map.serialize_entry("target", target)?;
            }
            Self::ObjectRead { node, at, len } => {
                map.serialize_entry("node", node)?;
                fields::object(&mut map, *at)?;
                map.serialize_entry("length", len)?;
            }
            Self::ObjectWritten { node, at } => {
                map.serialize_entry("node", node)?;
                fields::object(&mut map, *at)?;
            }
            Self::OtherManagingNode(source) => map.serialize_entry("src_mac", &Words(source))?,
            Self::AddressConflict { node, source } => {
                map.serialize_entry("node", node)?;
                map.serialize_entry("src_mac", &Words(source))?;
            }
            Self::BadFrame(error) => map.serialize_entry("problem", &Words(error))?,
            Self::CycleExceeded | Self::BufferTooShort => {}
        }
        map.end()
    }
}

impl MnEvent {
    const fn name(&self) -> &'static str {
        match self {
            Self::StateChanged { .. } => "state_changed",
            Self::NodeChanged { .. } => "node_changed",
            Self::NodeLost { .. } => "node_lost",
            Self::NodeRefused { .. } => "node_refused",
            Self::ConfigurationAborted { .. } => "configuration_aborted",
            Self::Inputs { .. } => "inputs",
            Self::PresLost { .. } => "pres_lost",
            Self::PresLate { .. } => "pres_late",
            Self::CycleExceeded => "cycle_exceeded",
            Self::NodeError { .. } => "node_error",
            Self::NmtRequested { .. } => "nmt_requested",
            Self::ObjectRead { .. } => "object_read",
            Self::ObjectWritten { .. } => "object_written",
            Self::SdoFailed { .. } => "sdo_failed",
            Self::OtherManagingNode(_) => "other_managing_node",
            Self::AddressConflict { .. } => "address_conflict",
            Self::UnknownNode(_) => "unknown_node",
            Self::BadFrame(_) => "bad_frame",
            Self::BufferTooShort => "buffer_too_short",
        }
    }
}
