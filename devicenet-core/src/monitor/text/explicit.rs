//! Explicit and UCMM messages, and their fragments.

use core::fmt::{self, Formatter};

use cip_core::code::ClassId;
use cip_core::fragment::FragmentKind;
use cip_core::monitor::text::write_bytes;
use cip_core::monitor::{Explicit, Vocabulary};

use super::write_ends;
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
    let explicit = &fields.explicit;
    let Some(service) = explicit.service else {
        return f.write_str(if is_response { "response" } else { "request" });
    };
    match explicit.requested.unwrap_or(service) {
        ucmm::OPEN if fields.is_ucmm => f.write_str("Open")?,
        ucmm::CLOSE if fields.is_ucmm => f.write_str("Close")?,
        // Without the request, the form of the response has told its class.
        service if matches!(fields.detail, Detail::Allocated { .. }) => {
            let class = Some(ClassId::DEVICENET);
            Explicit { class, ..*explicit }.write_service(f, &Vocabulary::DEVICENET, service)?;
        }
        service => explicit.write_service(f, &Vocabulary::DEVICENET, service)?,
    }
    let text = fields.text_of(value);
    if is_response {
        return explicit.write_answer(f, &Vocabulary::DEVICENET, text, value);
    }
    if !matches!(fields.detail, Detail::Allocate { .. }) && fields.choice.is_none() {
        explicit.write_target(f, &Vocabulary::DEVICENET)?;
    }
    if let Some(choice) = fields.choice {
        f.write_str(" ")?;
        fmt::Display::fmt(&choice, f)?;
    }
    match text {
        Some(text) => {
            f.write_str(if fields.choice.is_some() { ", " } else { " " })?;
            fmt::Display::fmt(&text, f)
        }
        None => explicit.write_raw(f, &Vocabulary::DEVICENET, value),
    }
}

pub(super) fn write_fragment(f: &mut Formatter<'_>, reading: &Reading<'_>) -> fmt::Result {
    write_ends(f, reading.src, reading.dst)?;
    let Some(frag) = reading.frag else { return f.write_str("fragment") };
    fmt::Display::fmt(&frag, f)?;
    if frag.byte.kind == FragmentKind::Acknowledge {
        return Ok(());
    }
    match &reading.message {
        Some(message) => {
            f.write_str(" completes ")?;
            write_message(f, message.kind, &message.fields, message.value().unwrap_or_default())
        }
        None => write_bytes(f, reading.frame.data().get(2..).unwrap_or_default()),
    }
}
