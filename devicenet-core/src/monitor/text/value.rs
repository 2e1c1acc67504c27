//! What values and the details of a message mean.

use core::fmt::{self, Formatter};

use cip_core::code::{ClassId, ServiceCode};
use cip_core::message::BodyFormat;
use cip_core::monitor::Vocabulary;
use cip_core::names::service_name;
use cip_core::text::{write_decimal, write_hex16, write_prefixed_hex};

use super::write_mac;
use crate::id::MacId;
use crate::message::{DeviceState, GroupSelect, HeartbeatFlags, ShutdownCode};
use crate::monitor::kind::Kind;
use crate::monitor::reading::{Detail, Fields};
use crate::monitor::{broadcast, ucmm};

/// What a value means. See [`Reading::value_text`](crate::monitor::Reading::value_text).
#[derive(Debug, Clone, Copy)]
pub struct ValueText<'a> {
    fields: &'a Fields<'a>,
    value: &'a [u8],
}

impl Fields<'_> {
    /// What `value`, the value of these fields, means.
    pub(in crate::monitor) fn text_of<'a>(&'a self, value: &'a [u8]) -> Option<ValueText<'a>> {
        let has_detail = self.detail != Detail::None && self.detail != Detail::WhoAnswer;
        let has_meaning = has_detail || self.explicit.text_of(&Vocabulary::DEVICENET, value).is_some();
        has_meaning.then_some(ValueText { fields: self, value })
    }

    /// The name of the service, which depends on where it stands.
    pub(in crate::monitor) fn service_name(&self, kind: Kind) -> Option<&'static str> {
        let service = self.explicit.service?;
        Some(match (kind, service) {
            (_, ServiceCode::ERROR_RESPONSE) => return service.name(),
            (Kind::OfflineFaultRequest | Kind::OfflineFaultResponse, ServiceCode(0x4B)) => "Who",
            (Kind::OfflineFaultRequest | Kind::OfflineFaultResponse, ServiceCode(0x4C)) => "Identify",
            (Kind::OfflineFaultRequest | Kind::OfflineFaultResponse, ServiceCode(0x4D)) => "Change_MAC_ID",
            (Kind::OfflineOwnershipRequest | Kind::OfflineOwnershipResponse, ServiceCode(0x4B)) => {
                "Allocate_Offline_Connection_Set"
            }
            (Kind::Heartbeat, broadcast::HEARTBEAT) => "Device_Heartbeat",
            (Kind::Shutdown, broadcast::SHUTDOWN) => "Device_Shutdown",
            _ if self.is_ucmm => match service {
                ucmm::OPEN => "Open_Explicit_Messaging_Connection",
                ucmm::CLOSE => "Close_Connection",
                _ => return service.name(),
            },
            // Without the request, the form of the response has told its class.
            _ if matches!(self.detail, Detail::Allocated { .. }) => {
                return service_name(ClassId::DEVICENET, service);
            }
            _ => return self.explicit.service_name(&Vocabulary::DEVICENET),
        })
    }
}

impl fmt::Display for ValueText<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let fields = self.fields;
        if fields.detail != Detail::None {
            return write_detail(f, fields);
        }
        match fields.explicit.text_of(&Vocabulary::DEVICENET, self.value) {
            Some(text) => fmt::Display::fmt(&text, f),
            None => Ok(()),
        }
    }
}

pub(super) fn write_detail(f: &mut Formatter<'_>, fields: &Fields<'_>) -> fmt::Result {
    match fields.detail {
        Detail::None | Detail::WhoAnswer => Ok(()),
        Detail::Allocate { allocator } => {
            f.write_str("master ")?;
            write_decimal(f, allocator.into())
        }
        Detail::Allocated { format } => write_format(f, format),
        Detail::Open { format, group, source } => {
            let group = GroupSelect::new(group).unwrap_or(GroupSelect::NODE_PING);
            if group == GroupSelect::NODE_PING {
                return fmt::Display::fmt(&group, f);
            }
            fmt::Display::fmt(&group, f)?;
            if group != GroupSelect::GROUP_2 {
                f.write_str(" Message ID ")?;
                write_decimal(f, source.into())?;
            }
            f.write_str(", ")?;
            write_format(f, format)
        }
        Detail::Opened { format, destination, source } => {
            if let Some(instance) = fields.explicit.instance {
                f.write_str("instance ")?;
                write_decimal(f, instance.0.into())?;
                f.write_str(", ")?;
            }
            f.write_str("Message ID ")?;
            write_decimal(f, source.into())?;
            if destination != 0 {
                f.write_str(", requests on ")?;
                write_decimal(f, destination.into())?;
            }
            f.write_str(", ")?;
            write_format(f, format)
        }
        Detail::Close => match (fields.explicit.instance, fields.explicit.requested) {
            (Some(instance), _) => {
                f.write_str("instance ")?;
                write_decimal(f, instance.0.into())
            }
            (None, _) => f.write_str("ok"),
        },
        Detail::Heartbeat { state, flags, consistency } => write_heartbeat(f, state, flags, consistency),
        Detail::Shutdown { code } => {
            if let Some(class) = fields.explicit.class {
                fmt::Display::fmt(&class, f)?;
            }
            if let Some(instance) = fields.explicit.instance {
                f.write_str(" ")?;
                write_decimal(f, instance.0.into())?;
            }
            f.write_str(", ")?;
            fmt::Display::fmt(&ShutdownCode(code), f)
        }
        Detail::Who { nodes, delay_offset } => {
            write_nodes(f, nodes)?;
            f.write_str(", delay by byte ")?;
            write_decimal(f, delay_offset.into())
        }
        Detail::Identify { nodes } => write_nodes(f, nodes),
        Detail::ChangeMacId { mac } => {
            f.write_str("to ")?;
            write_mac(f, Some(mac))
        }
        Detail::Ownership { client } => {
            f.write_str("tool ")?;
            write_mac(f, Some(client))
        }
    }
}

fn write_heartbeat(f: &mut Formatter<'_>, state: u8, flags: u8, consistency: u16) -> fmt::Result {
    fmt::Display::fmt(&DeviceState(state), f)?;
    let flags = HeartbeatFlags::from_bits_retain(flags);
    for (flag, name) in [
        (HeartbeatFlags::DEVICE_FAULT, ", device fault"),
        (HeartbeatFlags::USER_FAULT, ", user fault"),
        (HeartbeatFlags::SYSTEM_FAULT, ", system fault"),
        (HeartbeatFlags::EVENT, ", event"),
    ] {
        if flags.contains(flag) {
            f.write_str(name)?;
        }
    }
    f.write_str(", configuration 0x")?;
    write_hex16(f, consistency)
}

/// Match and Value.
fn write_nodes(f: &mut Formatter<'_>, nodes: u8) -> fmt::Result {
    if nodes & MATCH != 0 {
        f.write_str("MAC ID ")?;
        return write_mac(f, Some(MacId::from_low_bits(nodes)));
    }
    if nodes == ALL_NODES {
        return f.write_str("all nodes");
    }
    f.write_str("mask ")?;
    write_prefixed_hex(f, nodes.into())
}

fn write_format(f: &mut Formatter<'_>, code: u8) -> fmt::Result {
    f.write_str("body format ")?;
    match BodyFormat::from_code(code) {
        Some(format) => fmt::Display::fmt(&format, f),
        None => write_decimal(f, code.into()),
    }
}

const MATCH: u8 = 0x40;

const ALL_NODES: u8 = 0x3F;
