//! The characters of a file, with the place of each in its bytes.

use super::Span;

/// How the bytes of a file are characters. An EDS should be ISO 8859-1; what editors make of it is read as well.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum Encoding {
    /// ASCII.
    Ascii,
    /// ISO 8859-1; the bytes 0x80-0x9F, which it does not assign, are read as Windows-1252 has them.
    Latin1,
    /// UTF-8, told by a byte order mark or by characters that are no accident.
    Utf8,
    /// UTF-16 after the byte order mark FF FE.
    Utf16Le,
    /// UTF-16 after the byte order mark FE FF.
    Utf16Be,
}

impl Encoding {
    /// Finds the encoding of a file, and how many bytes its byte order mark takes.
    pub(super) fn detect(bytes: &[u8]) -> (Self, usize) {
        match bytes {
            [0xEF, 0xBB, 0xBF, ..] => (Self::Utf8, 3),
            [0xFF, 0xFE, ..] => (Self::Utf16Le, 2),
            [0xFE, 0xFF, ..] => (Self::Utf16Be, 2),
            _ if bytes.is_ascii() => (Self::Ascii, 0),
            _ if core::str::from_utf8(bytes).is_ok() => (Self::Utf8, 0),
            _ => (Self::Latin1, 0),
        }
    }

    /// The name that an editor has for it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ascii => "ASCII",
            Self::Latin1 => "ISO 8859-1",
            Self::Utf8 => "UTF-8",
            Self::Utf16Le => "UTF-16 (little-endian)",
            Self::Utf16Be => "UTF-16 (big-endian)",
        }
    }
}

/// A character and its bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Located {
    pub(super) character: char,
    pub(super) start: usize,
    pub(super) end: usize,
}

/// The characters of a piece of a file. Bytes that are none are U+FFFD; no byte is passed over.
#[derive(Debug, Clone)]
pub(super) struct Characters<'a> {
    rest: &'a [u8],
    at: usize,
    encoding: Encoding,
}

impl<'a> Characters<'a> {
    /// Of the bytes of `span`.
    pub(super) fn of(bytes: &'a [u8], span: Span, encoding: Encoding) -> Self {
        Self { rest: span.of(bytes), at: span.start, encoding }
    }

    /// The place of the next character.
    pub(super) const fn at(&self) -> usize {
        self.at
    }

    /// The next character, without taking it.
    pub(super) fn peek(&self) -> Option<char> {
        self.clone().next().map(|located| located.character)
    }

    fn decode(&self) -> Option<(char, usize)> {
        let &first = self.rest.first()?;
        Some(match self.encoding {
            Encoding::Ascii => (char::from(first), 1),
            Encoding::Latin1 => (windows_1252(first), 1),
            Encoding::Utf8 => utf8(self.rest),
            Encoding::Utf16Le => utf16(self.rest, u16::from_le_bytes),
            Encoding::Utf16Be => utf16(self.rest, u16::from_be_bytes),
        })
    }
}

impl Iterator for Characters<'_> {
    type Item = Located;

    fn next(&mut self) -> Option<Located> {
        let (character, len) = self.decode()?;
        let start = self.at;
        let (_, rest) = self.rest.split_at_checked(len)?;
        self.rest = rest;
        self.at = start.saturating_add(len);
        Some(Located { character, start, end: self.at })
    }
}

/// ISO 8859-1 with the letters and signs that Windows has in the place of controls.
fn windows_1252(byte: u8) -> char {
    let index = usize::from(byte).checked_sub(0x80);
    index.and_then(|index| WINDOWS_1252.get(index)).copied().unwrap_or(char::from(byte))
}

fn utf8(bytes: &[u8]) -> (char, usize) {
    for len in 1..=4 {
        let Some(head) = bytes.get(..len) else { break };
        if let Ok(text) = core::str::from_utf8(head)
            && let Some(character) = text.chars().next()
        {
            return (character, len);
        }
    }
    (char::REPLACEMENT_CHARACTER, 1)
}

fn utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> (char, usize) {
    let (units, _) = bytes.as_chunks::<2>();
    let mut characters = char::decode_utf16(units.iter().take(2).copied().map(unit));
    match characters.next() {
        Some(Ok(character)) => (character, character.len_utf16().saturating_mul(2)),
        Some(Err(_)) => (char::REPLACEMENT_CHARACTER, 2),
        // Half a unit at the end of the file.
        None => (char::REPLACEMENT_CHARACTER, 1),
    }
}

/// 0x80-0x9F; what Windows-1252 does not assign either stays a control.
const WINDOWS_1252: [char; 32] = [
    '€', '\u{81}', '‚', 'ƒ', '„', '…', '†', '‡', 'ˆ', '‰', 'Š', '‹', 'Œ', '\u{8D}', 'Ž', '\u{8F}', '\u{90}',
    '‘', '’', '“', '”', '•', '–', '—', '˜', '™', 'š', '›', 'œ', '\u{9D}', 'ž', 'Ÿ',
];

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::{string::String, vec::Vec};

    fn read(bytes: &[u8]) -> (Encoding, String) {
        let (encoding, mark) = Encoding::detect(bytes);
        let span = Span { start: mark, end: bytes.len() };
        (encoding, Characters::of(bytes, span, encoding).map(|located| located.character).collect())
    }

    #[test]
    fn what_editors_write() {
        assert_eq!(read(b"25 \xB0C"), (Encoding::Latin1, "25 °C".into()));
        assert_eq!(read(b"Manufacturer\x92s"), (Encoding::Latin1, "Manufacturer’s".into()));
        assert_eq!(read("25 °C".as_bytes()), (Encoding::Utf8, "25 °C".into()));
        assert_eq!(read(b"\xEF\xBB\xBFa"), (Encoding::Utf8, "a".into()));
        assert_eq!(read(b"\xFF\xFE[\0\xB0\0"), (Encoding::Utf16Le, "[°".into()));
        assert_eq!(read(b"\xFE\xFF\xD8\x3D\xDE\x00"), (Encoding::Utf16Be, "😀".into()));
        assert_eq!(read(b"plain"), (Encoding::Ascii, "plain".into()));
    }

    #[test]
    fn broken_characters_are_replaced() {
        assert_eq!(read(b"\xEF\xBB\xBFa\xFF"), (Encoding::Utf8, "a\u{FFFD}".into()));
        assert_eq!(read(b"\xFF\xFE\x00\xD8a\0x"), (Encoding::Utf16Le, "\u{FFFD}a\u{FFFD}".into()));
    }

    proptest! {
        #[test]
        fn no_byte_is_passed_over(bytes: Vec<u8>, mark in 0..4_usize) {
            let mut file = [&b""[..], b"\xEF\xBB\xBF", b"\xFF\xFE", b"\xFE\xFF"][mark].to_vec();
            file.extend(bytes);
            let (encoding, mut at) = Encoding::detect(&file);
            for located in Characters::of(&file, Span { start: at, end: file.len() }, encoding) {
                prop_assert_eq!(located.start, at);
                prop_assert!(located.end > at);
                at = located.end;
            }
            prop_assert_eq!(at, file.len());
        }
    }
}
