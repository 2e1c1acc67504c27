//! Frames and bytes as texts write them.

use link_core::Frame;
use link_core::frame::standard_id;

/// A frame written as `5FF: 00 E7 03`; what stands behind four blanks is a comment.
///
/// # Panics
/// When it is none.
#[must_use]
#[track_caller]
pub fn frame(text: &str) -> Frame {
    let text = text.trim();
    let text = text.split("    ").next().unwrap_or(text);
    let (id, data) = text.split_once(':').unwrap_or_else(|| panic!("no frame: {text}"));
    let id = u16::from_str_radix(id.trim(), 16).unwrap_or_else(|_| panic!("no identifier: {text}"));
    Frame::new(standard_id(id), &bytes(data)).unwrap_or_else(|| panic!("more than eight bytes: {text}"))
}

/// Bytes in hexadecimal.
///
/// # Panics
/// When they are none.
#[must_use]
#[track_caller]
pub fn bytes(text: &str) -> Vec<u8> {
    let byte = |byte| u8::from_str_radix(byte, 16).unwrap_or_else(|_| panic!("no bytes: {text}"));
    text.split_whitespace().map(byte).collect()
}
