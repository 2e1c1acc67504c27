//! One JSON object a frame.

use link_core::Id;

use crate::recording::{Content, RecordedFrame};
use crate::text::{LOWER, push_hex, push_number, push_seconds};

/// Writes the fields that every frame has: `t`, `n`, `channel` where there is one, `id`, `ext`, `rtr`, `dlc`, `data`.
pub(super) fn object(out: &mut Vec<u8>, frame: &RecordedFrame, channel: Option<&str>) {
    out.extend_from_slice(b"{\"t\":");
    push_seconds(out, frame.at, frame.digits);
    out.extend_from_slice(b",\"n\":");
    push_number(out, frame.n);
    let (id, is_extended, is_remote, dlc, data) = match &frame.content {
        Content::Classic(frame) => {
            (frame.raw_id(), frame.is_extended(), frame.is_remote(), frame.dlc(), frame.data())
        }
        Content::Error(error) => (error.class, true, false, 8, &error.data[..]),
        Content::Fd(frame) => match frame.id() {
            Id::Standard(id) => (u32::from(id.as_raw()), false, false, frame.dlc(), frame.data()),
            Id::Extended(id) => (id.as_raw(), true, false, frame.dlc(), frame.data()),
        },
    };
    out.extend_from_slice(b",\"id\":");
    push_number(out, id);
    out.extend_from_slice(if is_extended { b",\"ext\":true" } else { b",\"ext\":false" });
    out.extend_from_slice(if is_remote { b",\"rtr\":true" } else { b",\"rtr\":false" });
    out.extend_from_slice(b",\"dlc\":");
    push_number(out, dlc);
    out.extend_from_slice(b",\"data\":\"");
    push_hex(out, data, LOWER);
    out.push(b'"');
    if let Some(channel) = channel {
        out.extend_from_slice(b",\"channel\":");
        push_string(out, channel);
    }
    out.extend_from_slice(b"}\n");
}

/// A string in quotation marks.
fn push_string(out: &mut Vec<u8>, text: &str) {
    out.push(b'"');
    for byte in text.bytes() {
        match byte {
            b'"' | b'\\' => out.extend_from_slice(&[b'\\', byte]),
            0..0x20 => {
                out.extend_from_slice(b"\\u00");
                push_hex(out, &[byte], LOWER);
            }
            _ => out.push(byte),
        }
    }
    out.push(b'"');
}
