//! One JSON object a frame.

use core::fmt::{self, Display, Write as _};

use link_core::{Id, Instant};
use powerlink_core::monitor as powerlink;

use super::meaning::Meaning;
use super::sheets::Note;
use crate::recording::{Content, RecordedFrame};
use crate::text::{LOWER, push_hex, push_number, push_seconds};

/// Writes an object with the fields that every frame has, `t`, `n`, `id`, `ext`, `rtr`, `dlc`, `data`, then `channel`
/// where the recording names one, then those that tell its meaning, and `eds` with what its values are called in an
/// Electronic Data Sheet.
pub(super) fn object(
    out: &mut Vec<u8>,
    frame: &RecordedFrame,
    channel: Option<&str>,
    meaning: &Meaning<'_>,
    note: Option<&Note<'_>>,
) {
    begin(out, frame, channel);
    match meaning {
        Meaning::Read(reading) => {
            join(out, reading);
            if let Some(note) = note {
                out.pop();
                let object = serde_json::json!({ "file": note.file, "values": note.values, "text": note.to_string().trim_start() });
                out.extend_from_slice(b",\"eds\":");
                let _ = serde_json::to_writer(&mut *out, &object);
                out.push(b'}');
            }
            out.push(b'\n');
        }
        Meaning::Nex(reading) => {
            join(out, reading);
            out.push(b'\n');
        }
        Meaning::Outside(words) => {
            out.extend_from_slice(b",\"protocol\":\"unknown\",\"kind\":\"foreign\",\"problem\":");
            push_display(out, words);
            out.extend_from_slice(b",\"problem_code\":\"");
            out.extend_from_slice(words.code().as_bytes());
            out.extend_from_slice(b"\",\"text\":");
            push_display(out, words);
            out.extend_from_slice(b"}\n");
        }
    }
}

/// The same of an Ethernet frame: `t`, `n`, `length`, `captured` where that is less, `data` behind the Ethernet headers, `channel`.
pub(super) fn ethernet(
    out: &mut Vec<u8>,
    (at, digits): (Instant, u8),
    channel: Option<&str>,
    reading: &powerlink::Reading<'_>,
) {
    out.extend_from_slice(b"{\"t\":");
    push_seconds(out, at, digits);
    out.extend_from_slice(b",\"n\":");
    push_number(out, reading.n);
    let powerlink::Captured { bytes, length } = reading.frame;
    out.extend_from_slice(b",\"length\":");
    push_number(out, length);
    if bytes.len() < length {
        out.extend_from_slice(b",\"captured\":");
        push_number(out, bytes.len());
    }
    out.extend_from_slice(b",\"data\":\"");
    push_hex(out, reading.payload(), LOWER);
    out.push(b'"');
    if let Some(channel) = channel {
        out.extend_from_slice(b",\"channel\":");
        push_string(out, channel);
    }
    join(out, reading);
    out.push(b'\n');
}

/// Goes on with the fields of another object.
fn join(out: &mut Vec<u8>, object: &impl serde::Serialize) {
    let joint = out.len();
    // Numbers, names and words: nothing in it can fail, nor can the vector.
    let _ = serde_json::to_writer(&mut *out, object);
    out[joint] = b',';
}

fn begin(out: &mut Vec<u8>, frame: &RecordedFrame, channel: Option<&str>) {
    out.extend_from_slice(b"{\"t\":");
    push_seconds(out, frame.at, frame.digits);
    out.extend_from_slice(b",\"n\":");
    push_number(out, frame.n);
    let (id, is_extended, is_remote, dlc, data) = match &frame.content {
        Content::Classic(frame) => {
            (frame.raw_id(), frame.is_extended(), frame.is_remote(), frame.dlc(), frame.data())
        }
        Content::Error(error) => (error.class, false, false, 8, &error.data[..]),
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
}

fn push_display(out: &mut Vec<u8>, words: impl Display) {
    out.push(b'"');
    // Writing into a vector cannot fail.
    let _ = write!(Escaped(out), "{words}");
    out.push(b'"');
}

/// A string in quotation marks.
fn push_string(out: &mut Vec<u8>, text: &str) {
    push_display(out, text);
}

/// Lets `fmt` write into a JSON string.
struct Escaped<'a>(&'a mut Vec<u8>);

impl fmt::Write for Escaped<'_> {
    #[inline]
    fn write_str(&mut self, text: &str) -> fmt::Result {
        if text.bytes().any(needs_escape) {
            self.escape(text)
        } else {
            self.0.extend_from_slice(text.as_bytes())
        }
        Ok(())
    }
}

impl Escaped<'_> {
    #[cold]
    fn escape(&mut self, text: &str) {
        for byte in text.bytes() {
            match byte {
                b'"' | b'\\' => self.0.extend_from_slice(&[b'\\', byte]),
                0..0x20 => {
                    self.0.extend_from_slice(b"\\u00");
                    push_hex(self.0, &[byte], LOWER);
                }
                _ => self.0.push(byte),
            }
        }
    }
}

fn needs_escape(byte: u8) -> bool {
    byte < 0x20 || byte == b'"' || byte == b'\\'
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strings_are_escaped() {
        let mut out = Vec::new();
        push_string(&mut out, "a \"b\" \\ \u{1}\n°");
        let read: String = serde_json::from_slice(&out).unwrap();
        assert_eq!(read, "a \"b\" \\ \u{1}\n°");
    }
}
