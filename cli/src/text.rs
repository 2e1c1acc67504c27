//! Numbers as text, without the machinery of `fmt`.

use std::borrow::Cow;

use link_core::Instant;

/// Two digits a byte.
#[inline]
pub(crate) fn push_hex(out: &mut Vec<u8>, bytes: &[u8], digits: &[u8; 16]) {
    for byte in bytes {
        out.extend_from_slice(&[digits[usize::from(byte >> 4)], digits[usize::from(byte & 0xF)]]);
    }
}

/// The bytes of an even number of hex digits.
pub(crate) fn hex_bytes(text: &str) -> Option<Vec<u8>> {
    if !text.len().is_multiple_of(2) || !text.bytes().all(|byte| byte.is_ascii_hexdigit()) {
        return None;
    }
    (0..text.len()).step_by(2).map(|at| u8::from_str_radix(text.get(at..at + 2)?, 16).ok()).collect()
}

/// A number without a sign: `12`, `0x0C`.
pub(crate) fn unsigned(text: &str) -> Option<u64> {
    let (digits, radix) = match text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")) {
        Some(digits) => (digits, 16),
        None => (text, 10),
    };
    // Rust takes a plus sign.
    u64::from_str_radix(digits, radix).ok().filter(|_| !digits.starts_with('+'))
}

/// Seconds with that many decimals, at most nine; further ones are cut off.
#[inline]
pub(crate) fn push_seconds(out: &mut Vec<u8>, at: Instant, decimals: u8) {
    let nanos = at.as_nanos();
    out.extend_from_slice(itoa::Buffer::new().format(nanos / 1_000_000_000).as_bytes());
    if decimals == 0 {
        return;
    }
    let mut fraction = (nanos % 1_000_000_000) as u32;
    let mut text = *b".000000000";
    for digit in text[1..].iter_mut().rev() {
        *digit = b'0' + (fraction % 10) as u8;
        fraction /= 10;
    }
    out.extend_from_slice(&text[..=usize::from(decimals.min(9))]);
}

/// The same as text of its own.
pub(crate) fn seconds(at: Instant, decimals: u8) -> String {
    let mut out = Vec::new();
    push_seconds(&mut out, at, decimals);
    String::from_utf8_lossy(&out).into_owned()
}

/// The same as a number.
pub(crate) fn seconds_number(at: Instant, decimals: u8) -> f64 {
    seconds(at, decimals).parse().unwrap_or_default()
}

/// Seconds since an earlier moment; 0 before it: `0.563104 s`.
pub(crate) fn seconds_since(origin: Instant, at: Instant, decimals: u8) -> String {
    let since = Instant::from_nanos(at.as_nanos().saturating_sub(origin.as_nanos()));
    seconds(since, decimals) + " s"
}

/// A number in decimal.
#[inline]
pub(crate) fn push_number(out: &mut Vec<u8>, number: impl itoa::Integer) {
    out.extend_from_slice(itoa::Buffer::new().format(number).as_bytes());
}

/// A name that somebody else has given, with a replacement for what would command a terminal.
pub(crate) fn printable(name: &str) -> Cow<'_, str> {
    match name.contains(char::is_control) {
        true => Cow::Owned(name.replace(char::is_control, "\u{FFFD}")),
        false => Cow::Borrowed(name),
    }
}

/// The product name of an Identity object, in ISO 8859-1, if there is one.
pub(crate) fn product_name(bytes: &[u8]) -> Option<String> {
    let name: String = bytes.iter().map(|&byte| char::from(byte)).collect();
    Some(printable(name.trim()).into_owned()).filter(|name| !name.is_empty())
}

/// `1 frame`, `2 frames`.
pub(crate) fn count(number: u64, what: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{number} {what}{plural}")
}

/// Digits of lower and upper case.
pub(crate) const LOWER: &[u8; 16] = b"0123456789abcdef";
pub(crate) const UPPER: &[u8; 16] = b"0123456789ABCDEF";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_keep_their_decimals() {
        let text = |nanos, decimals| {
            let mut out = Vec::new();
            push_seconds(&mut out, Instant::from_nanos(nanos), decimals);
            String::from_utf8(out).unwrap()
        };
        assert_eq!(text(1_700_000_000_000_250_999, 6), "1700000000.000250");
        assert_eq!(text(1_700_000_000_000_250_999, 9), "1700000000.000250999");
        assert_eq!(text(5_000_000_000, 0), "5");
        assert_eq!(text(1, 9), "0.000000001");
    }
}
