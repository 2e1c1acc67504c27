//! Explicit and UCMM messages, and their fragments.

use core::fmt::{self, Formatter};

use cip_core::code::{AdditionalCode, ClassId, GeneralStatus, ServiceCode};
use cip_core::fragment::FragmentKind;
use cip_core::names::{additional_code_name, short_service_name, write_object};
use cip_core::text::{Hex, write_hex8, write_prefixed_hex};

use super::{write_bytes, write_ends};
use crate::monitor::kind::Kind;
use crate::monitor::reading::{Detail, Fields, Reading};
use crate::monitor::ucmm;

/// An explicit or UCMM message.
pub(super) fn write_message(
    f: &mut Formatter<'_>,
    kind: Kind,
    fields: &Fields<'_>,
    value: &[u8],
) -> fmt::Result {
    let is_response = matches!(kind, Kind::ExplicitResponse | Kind::UnconnectedResponse);
    let Some(service) = fields.service else {
        return f.write_str(if is_response { "response" } else { "request" });
    };
    write_service(f, fields, fields.requested.unwrap_or(service))?;
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
fn write_response(f: &mut Formatter<'_>, fields: &Fields<'_>, value: &[u8]) -> fmt::Result {
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
fn write_service(f: &mut Formatter<'_>, fields: &Fields<'_>, service: ServiceCode) -> fmt::Result {
    let of_set =
        fields.class == Some(ClassId::DEVICENET) || matches!(fields.detail, Detail::Allocated { .. });
    let name = match service {
        ServiceCode::ERROR_RESPONSE => Some("response"),
        service if of_set => short_service_name(ClassId::DEVICENET, service),
        ucmm::OPEN if fields.is_ucmm => Some("Open"),
        ucmm::CLOSE if fields.is_ucmm => Some("Close"),
        service => fields.name_of(service),
    };
    match name {
        Some(name) => f.write_str(name),
        None => fmt::Display::fmt(&service, f),
    }
}

/// ` Identity 1`, ` Connection class`
fn write_target(f: &mut Formatter<'_>, fields: &Fields<'_>) -> fmt::Result {
    let Some(class) = fields.class else { return Ok(()) };
    f.write_str(" ")?;
    match fields.instance {
        Some(instance) => write_object(f, class, instance),
        None => fmt::Display::fmt(&class, f),
    }
}

pub(super) fn write_fragment(f: &mut Formatter<'_>, reading: &Reading<'_>) -> fmt::Result {
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

/// `0x0C Object state conflict, another master owns the connection set`
pub(crate) fn write_status(
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
