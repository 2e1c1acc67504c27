//! Readings in words.

use core::fmt::{self, Formatter};

use cip_core::code::{AdditionalCode, AttributeId, ClassId, GeneralStatus, InstanceId, ServiceCode};
use cip_core::fragment::FragmentKind;
use cip_core::message::BodyFormat;
use cip_core::names::{additional_code_name, attribute_name, service_name};
use cip_core::text::{Hex, write_decimal, write_hex8, write_hex16, write_prefixed_hex};
use cip_core::value::AttributeValue;

use super::kind::Kind;
use super::reading::{Detail, Fields, Note, Reading};
use super::{broadcast, ucmm};
use crate::id::MacId;
use crate::message::{DeviceState, GroupSelect, HeartbeatFlags, ShutdownCode};

/// The words, and after them the problem.
impl fmt::Display for Reading<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write_words(f, self)?;
        match &self.problem {
            Some(problem) => {
                f.write_str("  ! ")?;
                fmt::Display::fmt(problem, f)
            }
            None => Ok(()),
        }
    }
}

/// The words of a reading, without its problem. See [`Reading::words`].
#[derive(Debug, Clone, Copy)]
pub struct Words<'a>(&'a Reading<'a>);

impl fmt::Display for Words<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write_words(f, self.0)
    }
}

/// What a value means. See [`Reading::value_text`].
#[derive(Debug, Clone, Copy)]
pub struct ValueText<'a> {
    fields: &'a Fields,
    value: &'a [u8],
}

impl Reading<'_> {
    /// The words alone, for an output that shows the problem in its own way.
    #[must_use]
    pub fn words(&self) -> Words<'_> {
        Words(self)
    }

    /// What the value means: `EPR 75 ms`, `Vendor 12 (Banner Engineering)`. `None` where the bytes have no known
    /// meaning.
    #[must_use]
    pub fn value_text(&self) -> Option<ValueText<'_>> {
        self.fields.text_of(self.value().unwrap_or_default())
    }

    /// The name of the service.
    #[must_use]
    pub fn service_name(&self) -> Option<&'static str> {
        self.fields.service_name(self.kind)
    }
}

impl Fields {
    /// What `value`, the value of these fields, means.
    pub(super) fn text_of<'a>(&'a self, value: &'a [u8]) -> Option<ValueText<'a>> {
        let has_detail = self.detail != Detail::None && self.detail != Detail::WhoAnswer;
        let has_meaning = !value.is_empty() && self.attribute_known() && self.status.is_none();
        (has_detail || has_meaning).then_some(ValueText { fields: self, value })
    }

    /// The name of the attribute.
    #[must_use]
    pub fn attribute_name(&self) -> Option<&'static str> {
        attribute_name(self.class?, self.instance?, self.attribute?)
    }

    /// The name of the service, which depends on where it stands.
    pub(super) fn service_name(&self, kind: Kind) -> Option<&'static str> {
        let service = self.service?;
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
            _ if self.is_ucmm(kind) => match service {
                ucmm::OPEN => "Open_Explicit_Messaging_Connection",
                ucmm::CLOSE => "Close_Connection",
                _ => return service.name(),
            },
            _ => return self.name_of(service),
        })
    }

    fn is_ucmm(&self, kind: Kind) -> bool {
        // A response of the Group 2 Only unconnected port is of a class.
        matches!(kind, Kind::UnconnectedRequest | Kind::UnconnectedResponse) && self.class.is_none()
    }

    fn name_of(&self, service: ServiceCode) -> Option<&'static str> {
        match (self.class, self.detail) {
            (Some(class), _) => service_name(class, service),
            // Without the request, the form of the response has told it.
            (None, Detail::Allocated { .. }) => service_name(ClassId::DEVICENET, service),
            (None, _) => service.name(),
        }
    }

    fn attribute_known(&self) -> bool {
        self.class.is_some() && self.instance.is_some() && self.attribute.is_some()
    }
}

impl fmt::Display for ValueText<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let fields = self.fields;
        if fields.detail != Detail::None {
            return write_detail(f, fields);
        }
        let (Some(class), Some(instance), Some(attribute)) =
            (fields.class, fields.instance, fields.attribute)
        else {
            return fmt::Display::fmt(&Hex(self.value), f);
        };
        let value = AttributeValue { class, instance, attribute, data: self.value };
        match short_name(class, instance, attribute) {
            Some(name) => {
                f.write_str(name)?;
                f.write_str(" ")?;
                fmt::Display::fmt(&value, f)
            }
            None => write!(f, "{value:#}"),
        }
    }
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoConnection(state) => {
                f.write_str("connection ")?;
                fmt::Display::fmt(state, f)
            }
            Self::NotStored => f.write_str("message too long for the decoder"),
            Self::Restarted => f.write_str("restart"),
            Self::Repeated => f.write_str("repeated"),
        }
    }
}

fn write_words(f: &mut Formatter<'_>, reading: &Reading<'_>) -> fmt::Result {
    match reading.kind {
        Kind::DupMacRequest | Kind::DupMacResponse => write_check(f, reading)?,
        Kind::Heartbeat => write_broadcast(f, "heartbeat", reading)?,
        Kind::Shutdown => write_broadcast(f, "shutdown", reading)?,
        Kind::OfflineFaultRequest
        | Kind::OfflineFaultResponse
        | Kind::OfflineOwnershipRequest
        | Kind::OfflineOwnershipResponse => write_offline(f, reading)?,
        Kind::Reserved => write_raw(f, "reserved", reading)?,
        Kind::Invalid => write_raw(f, "invalid identifier", reading)?,
        Kind::Foreign => write_raw(f, "not DeviceNet", reading)?,
        Kind::Fragment | Kind::FragmentAck => write_fragment(f, reading)?,
        kind if kind.is_io() => write_io(f, reading)?,
        kind => {
            write_ends(f, reading.src, reading.dst)?;
            write_message(f, kind, &reading.fields, reading.value().unwrap_or_default())?;
        }
    }
    if let Some(note) = reading.note {
        f.write_str(" (")?;
        fmt::Display::fmt(&note, f)?;
        f.write_str(")")?;
    }
    if reading.assumed { f.write_str(" (assumed)") } else { Ok(()) }
}

/// `1 -> 10  `
fn write_ends(f: &mut Formatter<'_>, source: Option<MacId>, destination: Option<MacId>) -> fmt::Result {
    write_mac(f, source)?;
    f.write_str(" -> ")?;
    write_mac(f, destination)?;
    f.write_str("  ")
}

fn write_mac(f: &mut Formatter<'_>, mac: Option<MacId>) -> fmt::Result {
    match mac {
        Some(mac) => write_decimal(f, mac.number().into()),
        None => f.write_str("?"),
    }
}

/// An explicit or UCMM message.
fn write_message(f: &mut Formatter<'_>, kind: Kind, fields: &Fields, value: &[u8]) -> fmt::Result {
    let is_response = matches!(kind, Kind::ExplicitResponse | Kind::UnconnectedResponse);
    let Some(service) = fields.service else {
        return f.write_str(if is_response { "response" } else { "request" });
    };
    write_service(f, kind, fields, fields.requested.unwrap_or(service))?;
    if is_response {
        return write_response(f, fields, value);
    }
    if !matches!(fields.detail, Detail::Allocate { .. }) && fields.choice.is_none() {
        write_target(f, fields)?;
    }
    if let Some(choice) = fields.choice {
        f.write_str(" ")?;
        fmt::Display::fmt(&choice, f)?;
    }
    match fields.text_of(value) {
        Some(text) => {
            f.write_str(if fields.choice.is_some() { ", " } else { " " })?;
            fmt::Display::fmt(&text, f)
        }
        None => {
            if let Some(attribute) = fields.attribute {
                f.write_str(" ")?;
                match fields.attribute_name() {
                    Some(name) => f.write_str(name)?,
                    None => fmt::Display::fmt(&attribute, f)?,
                }
            }
            write_bytes(f, value)
        }
    }
}

/// `: ok`, `: Vendor 12`, `: error 0x16 Object does not exist`
fn write_response(f: &mut Formatter<'_>, fields: &Fields, value: &[u8]) -> fmt::Result {
    f.write_str(": ")?;
    if let Some(status) = fields.status {
        f.write_str("error ")?;
        let of_devicenet = fields.class == Some(ClassId::DEVICENET);
        return write_status(f, status, fields.additional.unwrap_or(AdditionalCode::NONE), of_devicenet);
    }
    match fields.text_of(value) {
        Some(text) => fmt::Display::fmt(&text, f),
        None if value.is_empty() => f.write_str("ok"),
        None => fmt::Display::fmt(&Hex(value), f),
    }
}

/// The short words of the services that everybody knows by them, else the name, else the number.
fn write_service(f: &mut Formatter<'_>, kind: Kind, fields: &Fields, service: ServiceCode) -> fmt::Result {
    let of_set =
        fields.class == Some(ClassId::DEVICENET) || matches!(fields.detail, Detail::Allocated { .. });
    let name = match service {
        ServiceCode::ALLOCATE if of_set => Some("Allocate"),
        ServiceCode::RELEASE if of_set => Some("Release"),
        ucmm::OPEN if fields.is_ucmm(kind) => Some("Open"),
        ucmm::CLOSE if fields.is_ucmm(kind) => Some("Close"),
        ServiceCode::ERROR_RESPONSE => Some("response"),
        service => fields.name_of(service),
    };
    match name {
        Some(name) => f.write_str(name),
        None => fmt::Display::fmt(&service, f),
    }
}

/// ` Identity 1`, ` Connection class`
fn write_target(f: &mut Formatter<'_>, fields: &Fields) -> fmt::Result {
    let Some(class) = fields.class else { return Ok(()) };
    f.write_str(" ")?;
    fmt::Display::fmt(&class, f)?;
    match fields.instance {
        Some(InstanceId::CLASS) => f.write_str(" class"),
        Some(instance) => {
            f.write_str(" ")?;
            write_decimal(f, instance.0.into())
        }
        None => Ok(()),
    }
}

fn write_fragment(f: &mut Formatter<'_>, reading: &Reading<'_>) -> fmt::Result {
    write_ends(f, reading.src, reading.dst)?;
    let Some(frag) = reading.frag else { return f.write_str("fragment") };
    fmt::Display::fmt(&frag.byte, f)?;
    if frag.byte.kind == FragmentKind::Acknowledge {
        return match frag.status {
            Some(0) | None => Ok(()),
            Some(1) => f.write_str(": too much data"),
            Some(status) => {
                f.write_str(": status ")?;
                write_prefixed_hex(f, status.into())
            }
        };
    }
    match &reading.message {
        Some(message) => {
            f.write_str(" completes ")?;
            write_message(f, message.kind, &message.fields, message.value().unwrap_or_default())
        }
        None => write_bytes(f, reading.frame.data().get(2..).unwrap_or_default()),
    }
}

/// `poll 10 <- 1  03`, `poll 10 -> 1  03 6B 00`
fn write_io(f: &mut Formatter<'_>, reading: &Reading<'_>) -> fmt::Result {
    let (name, is_command) = match reading.kind {
        Kind::PollCommand => ("poll", true),
        Kind::PollResponse => ("poll", false),
        Kind::BitStrobeCommand => ("bit-strobe", true),
        Kind::BitStrobeResponse => ("bit-strobe", false),
        Kind::MulticastPollCommand => ("multicast poll", true),
        Kind::MulticastPollResponse => ("multicast poll", false),
        Kind::CosCyclicAck => ("COS/cyclic ack", reading.group == Some(2)),
        Kind::CosCyclic => ("COS/cyclic", reading.group == Some(2)),
        _ => ("I/O", false),
    };
    f.write_str(name)?;
    f.write_str(" ")?;
    let (slave, master) = if is_command { (reading.dst, reading.src) } else { (reading.src, reading.dst) };
    match (slave, reading.kind) {
        (None, Kind::BitStrobeCommand | Kind::MulticastPollCommand) => f.write_str("*")?,
        (slave, _) => write_mac(f, slave)?,
    }
    f.write_str(if is_command { " <- " } else { " -> " })?;
    write_mac(f, master)?;
    let data = reading.frame.data();
    match (&reading.frag, &reading.message) {
        (Some(frag), Some(message)) => {
            f.write_str("  ")?;
            fmt::Display::fmt(&frag.byte, f)?;
            f.write_str(" completes")?;
            write_bytes(f, message.data)
        }
        (Some(frag), None) => {
            f.write_str("  ")?;
            fmt::Display::fmt(&frag.byte, f)?;
            write_bytes(f, data.get(1..).unwrap_or_default())
        }
        (None, _) => write_bytes(f, data),
    }
}

fn write_check(f: &mut Formatter<'_>, reading: &Reading<'_>) -> fmt::Result {
    f.write_str("dup MAC ")?;
    write_mac(f, reading.src)?;
    f.write_str(if reading.kind == Kind::DupMacRequest { " request" } else { " response" })?;
    write_device(f, &reading.fields)
}

/// `  vendor 4660 serial 0x00002345`, and the port if it is not the first.
fn write_device(f: &mut Formatter<'_>, fields: &Fields) -> fmt::Result {
    let (Some(vendor), Some(serial)) = (fields.vendor, fields.serial) else { return Ok(()) };
    f.write_str("  vendor ")?;
    write_decimal(f, vendor.0.into())?;
    f.write_str(" serial 0x")?;
    serial.to_be_bytes().iter().try_for_each(|&byte| write_hex8(f, byte))?;
    match fields.port {
        Some(port @ 1..) => {
            f.write_str(" port ")?;
            write_decimal(f, port.into())
        }
        Some(0) | None => Ok(()),
    }
}

fn write_broadcast(f: &mut Formatter<'_>, name: &str, reading: &Reading<'_>) -> fmt::Result {
    f.write_str(name)?;
    f.write_str(" ")?;
    write_mac(f, reading.src)?;
    if reading.fields.detail == Detail::None {
        return Ok(());
    }
    f.write_str("  ")?;
    write_detail(f, &reading.fields)
}

fn write_offline(f: &mut Formatter<'_>, reading: &Reading<'_>) -> fmt::Result {
    f.write_str("offline")?;
    let fields = &reading.fields;
    match (reading.kind, fields.detail) {
        (Kind::OfflineFaultResponse, Detail::WhoAnswer) => f.write_str(" Who response")?,
        (Kind::OfflineFaultResponse, Detail::Identify { .. }) => f.write_str(" Identify response")?,
        (Kind::OfflineOwnershipRequest, _) => f.write_str(" ownership request")?,
        (Kind::OfflineOwnershipResponse, _) => f.write_str(" ownership response")?,
        _ => {
            f.write_str(" ")?;
            f.write_str(fields.service_name(reading.kind).unwrap_or("message"))?;
        }
    }
    if let Some(text) = fields.text_of(&[]) {
        f.write_str("  ")?;
        fmt::Display::fmt(&text, f)?;
    }
    write_device(f, fields)
}

fn write_raw(f: &mut Formatter<'_>, name: &str, reading: &Reading<'_>) -> fmt::Result {
    f.write_str(name)?;
    write_bytes(f, reading.frame.data())
}

/// Two spaces and the bytes, if there are any.
fn write_bytes(f: &mut Formatter<'_>, data: &[u8]) -> fmt::Result {
    if data.is_empty() {
        return Ok(());
    }
    f.write_str("  ")?;
    fmt::Display::fmt(&Hex(data), f)
}

fn write_detail(f: &mut Formatter<'_>, fields: &Fields) -> fmt::Result {
    match fields.detail {
        Detail::None | Detail::WhoAnswer => Ok(()),
        Detail::PacketRate { requested, used } => {
            f.write_str("EPR ")?;
            write_decimal(f, used.into())?;
            f.write_str(" ms")?;
            match requested.filter(|&requested| requested != used) {
                Some(requested) => {
                    f.write_str(" (")?;
                    write_decimal(f, requested.into())?;
                    f.write_str(" ms requested)")
                }
                None => Ok(()),
            }
        }
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
            if let Some(instance) = fields.instance {
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
        Detail::Close => match (fields.instance, fields.requested) {
            (Some(instance), _) => {
                f.write_str("instance ")?;
                write_decimal(f, instance.0.into())
            }
            (None, _) => f.write_str("ok"),
        },
        Detail::Heartbeat { state, flags, consistency } => write_heartbeat(f, state, flags, consistency),
        Detail::Shutdown { code } => {
            if let Some(class) = fields.class {
                fmt::Display::fmt(&class, f)?;
            }
            if let Some(instance) = fields.instance {
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

/// `0x0C Object state conflict, another master owns the connection set`
pub(super) fn write_status(
    f: &mut Formatter<'_>,
    status: GeneralStatus,
    additional: AdditionalCode,
    of_devicenet: bool,
) -> fmt::Result {
    f.write_str("0x")?;
    write_hex8(f, status.0)?;
    if let Some(name) = status.name() {
        f.write_str(" ")?;
        f.write_str(name)?;
    }
    if additional == AdditionalCode::NONE {
        return Ok(());
    }
    f.write_str(", ")?;
    match additional_code_name(ClassId::DEVICENET, additional).filter(|_| of_devicenet) {
        Some(name) => f.write_str(name),
        None => {
            f.write_str("additional ")?;
            write_prefixed_hex(f, additional.0.into())
        }
    }
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

const MATCH: u8 = 0x40;
const ALL_NODES: u8 = 0x3F;
