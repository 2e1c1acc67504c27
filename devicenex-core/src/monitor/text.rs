//! Readings in words.

use core::fmt::{self, Display, Formatter};

use cip_core::code::{AdditionalCode, InstanceId, ServiceCode};
use cip_core::fragment::FragmentKind;
use cip_core::monitor::text::{ValueText, write_bytes, write_data, write_remarks, write_status};
use cip_core::text::write_decimal;

use super::connections::ConnectionName;
use super::kind::Kind;
use super::reading::{Detail, Fields, Note, Reading, Stage};
use super::vocabulary::DEVICENEX;
use crate::id::OperationalAddress;
use crate::message::{
    ConnectionInstance, ConnectionRequest, ConnectionResponse, Granted, GroupSelect, Predefined, Production,
};

/// The words, and after them the problem.
impl Display for Reading<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write_words(f, self)?;
        match &self.problem {
            Some(problem) => {
                f.write_str("  ! ")?;
                problem.fmt(f)
            }
            None => Ok(()),
        }
    }
}

/// The words of a reading, without its problem. See [`Reading::words`].
#[derive(Debug, Clone, Copy)]
pub struct Words<'a>(&'a Reading<'a>);

impl Display for Words<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write_words(f, self.0)
    }
}

impl Reading<'_> {
    /// The words alone, for an output that shows the problem in its own way.
    #[must_use]
    pub fn words(&self) -> Words<'_> {
        Words(self)
    }

    /// What the value means: `EPR 75 ms`, `Vendor 12 (Banner Engineering)`. `None` where the bytes have no known meaning.
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

impl Fields<'_> {
    /// What `value`, the value of these fields, means.
    pub(super) fn text_of<'a>(&'a self, value: &'a [u8]) -> Option<ValueText<'a>> {
        self.explicit.text_of(&DEVICENEX, value)
    }

    /// The name of the service, which depends on where it stands.
    pub(super) fn service_name(&self, kind: Kind) -> Option<&'static str> {
        match (kind, self.explicit.service?) {
            (Kind::ConnectionRequest | Kind::ConnectionResponse, ServiceCode::ALLOCATE) => Some("Connect"),
            _ => self.explicit.service_name(&DEVICENEX),
        }
    }

    /// The name of the attribute.
    #[must_use]
    pub fn attribute_name(&self) -> Option<&'static str> {
        self.explicit.attribute_name(&DEVICENEX)
    }
}

impl Display for Note {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoConnection(state) => write!(f, "connection {state}"),
            Self::NotStored => f.write_str("message too long for the decoder"),
            Self::Restarted => f.write_str("restart"),
            Self::Replaced => f.write_str("replaces another device"),
            Self::Moved { from } => write!(f, "was OA {from}"),
            Self::Repeated => f.write_str("repeated"),
        }
    }
}

fn write_words(f: &mut Formatter<'_>, reading: &Reading<'_>) -> fmt::Result {
    match reading.kind {
        Kind::HelloRequest | Kind::HelloResponse => write_hello(f, reading)?,
        Kind::MiniWho => write_mini_who(f, reading)?,
        Kind::Roam => write_roam(f, reading)?,
        Kind::ConnectionRequest | Kind::ConnectionResponse => write_connection(f, reading)?,
        Kind::Implicit | Kind::ImplicitAck => write_implicit(f, reading)?,
        Kind::Reserved => write_raw(f, "reserved", reading)?,
        Kind::Foreign => write_raw(f, "not DeviceNeX", reading)?,
        Kind::Fragment | Kind::FragmentAck => write_fragment(f, reading)?,
        Kind::ConnectionlessRequest
        | Kind::ConnectionlessResponse
        | Kind::ExplicitRequest
        | Kind::ExplicitResponse => {
            write_ends(f, reading.src, reading.dst)?;
            write_message(f, reading.kind, &reading.fields, reading.value().unwrap_or_default())?;
        }
    }
    write_remarks(f, reading.note, reading.assumed)
}

/// `1 -> 67  `
fn write_ends(
    f: &mut Formatter<'_>,
    source: Option<OperationalAddress>,
    destination: Option<OperationalAddress>,
) -> fmt::Result {
    write_address(f, source)?;
    f.write_str(" -> ")?;
    write_address(f, destination)?;
    f.write_str("  ")
}

fn write_address(f: &mut Formatter<'_>, address: Option<OperationalAddress>) -> fmt::Result {
    match address {
        Some(address) => write_decimal(f, address.number().into()),
        None => f.write_str("?"),
    }
}

/// `Hello 1 OA 127  vendor 291, product 1110, revision 2, serial 0x11223344`
fn write_hello(f: &mut Formatter<'_>, reading: &Reading<'_>) -> fmt::Result {
    f.write_str(match (reading.fields.detail, reading.kind) {
        (Detail::Hello(Stage::First), _) => "Hello 1",
        (Detail::Hello(Stage::Second), _) => "Hello 2",
        (Detail::Hello(Stage::Announcement), _) => "Hello announcement",
        (_, Kind::HelloResponse) => "Hello response",
        _ => "Hello",
    })?;
    f.write_str(" OA ")?;
    write_address(f, reading.src)?;
    write_device(f, &reading.fields)
}

fn write_device(f: &mut Formatter<'_>, fields: &Fields<'_>) -> fmt::Result {
    let Some(device) = fields.device else { return Ok(()) };
    write!(f, "  {device}")?;
    match fields.port {
        Some(port @ 1..) => write!(f, ", port {port}"),
        Some(0) | None => Ok(()),
    }
}

/// `Mini-who of 1`, or without a known sender `Mini-who  serial ending in 0x0001`.
fn write_mini_who(f: &mut Formatter<'_>, reading: &Reading<'_>) -> fmt::Result {
    f.write_str("Mini-who")?;
    match (reading.src, reading.fields.detail) {
        (Some(source), _) => write!(f, " of {source}"),
        (None, Detail::MiniWho { serial_low }) => write!(f, "  serial ending in 0x{serial_low:04X}"),
        (None, _) => Ok(()),
    }
}

/// `ROAM to OA 67  vendor 291, product 1110, revision 2, serial 0x11223344`
fn write_roam(f: &mut Formatter<'_>, reading: &Reading<'_>) -> fmt::Result {
    let Detail::Roam { requested } = reading.fields.detail else {
        return write_raw(f, "ROAM", reading);
    };
    write!(f, "ROAM to OA {requested}")?;
    write_device(f, &reading.fields)
}

fn write_connection(f: &mut Formatter<'_>, reading: &Reading<'_>) -> fmt::Result {
    write_ends(f, reading.src, reading.dst)?;
    match reading.fields.detail {
        Detail::Connect(connect) => write_connect(f, &connect),
        Detail::Granted { response, instance } => write_granted(f, &response, instance),
        _ => {
            let explicit = &reading.fields.explicit;
            match explicit.status {
                Some(status) => {
                    f.write_str("Connect: error ")?;
                    write_status(f, status, explicit.additional.unwrap_or(AdditionalCode::NONE), None)
                }
                None => write_raw(f, "Connect", reading),
            }
        }
    }
}

/// `Connect multicast, producing, 29 bits, EPR 500 ms, Auto reset, Message ID 0`; `Connect dynamic, 29-bit explicit, Message ID 2`
fn write_connect(f: &mut Formatter<'_>, connect: &ConnectionRequest) -> fmt::Result {
    f.write_str("Connect ")?;
    match connect.target {
        Some(target) => {
            let instance = ConnectionInstance::of(target.instance);
            instance.fmt(f)?;
            if connect.predefined != matches!(instance, ConnectionInstance::Predefined(_)) {
                f.write_str(if connect.predefined { " as predefined" } else { " as dynamic" })?;
            }
            write_group(f, Some(instance), connect.group)?;
            write!(f, ", EPR {} ms, {}", target.expected_packet_rate, target.watchdog_action)?;
        }
        None => {
            f.write_str(if connect.predefined { "predefined" } else { "dynamic" })?;
            write_group(f, None, connect.group)?;
        }
    }
    write!(f, ", Message ID {}", connect.source_message)
}

/// `Connect: multicast, producing, 29 bits, EPR 500 ms, Message ID 2, body format 8/8`
fn write_granted(
    f: &mut Formatter<'_>,
    granted: &ConnectionResponse,
    instance: Option<InstanceId>,
) -> fmt::Result {
    f.write_str("Connect: ")?;
    let instance = instance.map(ConnectionInstance::of);
    match instance {
        Some(instance) => instance.fmt(f)?,
        None => f.write_str("predefined")?,
    }
    write_group(f, instance, granted.group)?;
    if let Granted::Predefined { expected_packet_rate } = granted.granted {
        write!(f, ", EPR {expected_packet_rate} ms")?;
    }
    write!(f, ", Message ID {}", granted.source_message)?;
    match granted.body_format.body_format() {
        Some(format) => write!(f, ", body format {format}"),
        None => write!(f, ", body format {}", granted.body_format.0 & 0x0F),
    }
}

/// The group, unless the instance has told it.
fn write_group(
    f: &mut Formatter<'_>,
    instance: Option<ConnectionInstance>,
    group: GroupSelect,
) -> fmt::Result {
    match (instance, group) {
        (Some(ConnectionInstance::Predefined(Predefined::Explicit)), GroupSelect::EXPLICIT_29) => Ok(()),
        (Some(ConnectionInstance::Predefined(Predefined::Implicit(..))), GroupSelect::IMPLICIT_29) => Ok(()),
        _ => write!(f, ", {group}"),
    }
}

/// An explicit message, on a connection or without one.
fn write_message(f: &mut Formatter<'_>, kind: Kind, fields: &Fields<'_>, value: &[u8]) -> fmt::Result {
    if matches!(kind, Kind::ConnectionlessRequest | Kind::ConnectionlessResponse) {
        f.write_str("connectionless ")?;
    }
    fields.explicit.write(f, &DEVICENEX, kind.is_response(), value)
}

fn write_fragment(f: &mut Formatter<'_>, reading: &Reading<'_>) -> fmt::Result {
    write_ends(f, reading.src, reading.dst)?;
    let Some(frag) = reading.frag else { return f.write_str("fragment") };
    frag.fmt(f)?;
    if frag.byte.kind == FragmentKind::Acknowledge {
        return Ok(());
    }
    match &reading.message {
        Some(message) => {
            f.write_str(" completes ")?;
            write_message(f, message.kind, &message.fields, message.value().unwrap_or_default())
        }
        None => write_bytes(f, reading.frame.data()),
    }
}

/// `multicast 67 -> 5  03 6B`, `polled 67 <- 1  03`: the server of the connection first, the arrow shows where the data go.
fn write_implicit(f: &mut Formatter<'_>, reading: &Reading<'_>) -> fmt::Result {
    let on = reading.connection;
    match on.map(|on| on.name) {
        Some(ConnectionName::Instance(instance)) => match ConnectionInstance::of(instance) {
            ConnectionInstance::Predefined(Predefined::Implicit(production, _)) => {
                f.write_str(production_name(production))?;
            }
            other => write!(f, "implicit {other}")?,
        },
        Some(ConnectionName::Standard { group, message }) => {
            write!(f, "implicit group {} message {message}", group.number())?;
        }
        Some(ConnectionName::Explicit) | None => f.write_str("implicit")?,
    }
    let is_ack = reading.kind == Kind::ImplicitAck;
    f.write_str(if is_ack { " ack " } else { " " })?;
    let is_reverse = on.is_some_and(|on| Some(on.server) != reading.src);
    let (server, peer) = if is_reverse { (reading.dst, reading.src) } else { (reading.src, reading.dst) };
    write_address(f, server)?;
    f.write_str(if is_reverse { " <- " } else { " -> " })?;
    match peer {
        Some(_) => write_address(f, peer)?,
        None => f.write_str("*")?,
    }
    let data = reading.frame.data();
    write_data(f, reading.frag, reading.message.as_ref().map(|message| message.data), data)
}

const fn production_name(production: Production) -> &'static str {
    match production {
        Production::MulticastProducer | Production::MulticastConsumer => "multicast",
        other => other.name(),
    }
}

fn write_raw(f: &mut Formatter<'_>, name: &str, reading: &Reading<'_>) -> fmt::Result {
    f.write_str(name)?;
    write_bytes(f, reading.frame.data())
}
