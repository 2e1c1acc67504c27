//! Readings in words.

mod explicit;
mod problem;
mod value;

pub use value::ValueText;

use core::fmt::{self, Formatter};

use cip_core::monitor::text::{write_bytes, write_data, write_remarks};
use cip_core::text::{write_decimal, write_hex8};

use super::kind::Kind;
use super::reading::{Detail, Fields, Note, Reading};
use crate::id::MacId;
use explicit::{write_fragment, write_message};
use value::write_detail;

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

impl fmt::Display for Note {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoConnection(state) => {
                f.write_str("connection ")?;
                fmt::Display::fmt(state, f)
            }
            Self::NotStored => f.write_str("message too long for the decoder"),
            Self::Restarted => f.write_str("restart"),
            Self::RestartedOrAnother => f.write_str("restart, or another device"),
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
    write_remarks(f, reading.note, reading.assumed)
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
    write_data(f, reading.frag, reading.message.as_ref().map(|message| message.data), data)
}

fn write_check(f: &mut Formatter<'_>, reading: &Reading<'_>) -> fmt::Result {
    f.write_str("dup MAC ")?;
    write_mac(f, reading.src)?;
    f.write_str(if reading.kind == Kind::DupMacRequest { " request" } else { " response" })?;
    write_device(f, &reading.fields)
}

/// `  vendor 4660 serial 0x00002345`, and the port if it is not the first.
fn write_device(f: &mut Formatter<'_>, fields: &Fields<'_>) -> fmt::Result {
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
