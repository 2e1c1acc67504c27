//! Formatting without allocation and without the machinery of `write!`: a decoder prints millions of lines.

use core::fmt::{self, Write as _};

/// Bytes as two-digit hexadecimal numbers between single spaces.
///
/// ```
/// # use link_core::text::Hex;
/// assert_eq!(Hex(&[0x0E, 0x01]).to_string(), "0E 01");
/// ```
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Hex<'a>(pub &'a [u8]);

impl fmt::Display for Hex<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = 1;
        for chunk in self.0.chunks(HEX_CHUNK) {
            let mut text = [b' '; 3 * HEX_CHUNK];
            for (place, &byte) in text.chunks_exact_mut(3).zip(chunk) {
                if let [_, high, low] = place {
                    [*high, *low] = digits(byte);
                }
            }
            // Each byte has a space before it; the very first has none.
            let end = chunk.len().saturating_mul(3);
            write_ascii(f, text.get(separator..end).unwrap_or_default())?;
            separator = 0;
        }
        Ok(())
    }
}

impl fmt::Debug for Hex<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// Bytes as lower-case hexadecimal digits without spaces.
///
/// ```
/// # use link_core::text::LowerHex;
/// assert_eq!(LowerHex(&[0x0E, 0x01]).to_string(), "0e01");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LowerHex<'a>(pub &'a [u8]);

impl fmt::Display for LowerHex<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0
            .iter()
            .try_for_each(|&byte| write_ascii(f, &digits(byte).map(|digit| digit.to_ascii_lowercase())))
    }
}

/// Characters of ISO 8859-1 in double quotes; what cannot be printed, the quote and the backslash are escaped.
///
/// ```
/// # use link_core::text::Quoted;
/// assert_eq!(Quoted(b"GRT1-DRT\0").to_string(), r#""GRT1-DRT\x00""#);
/// ```
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Quoted<'a>(pub &'a [u8]);

impl fmt::Display for Quoted<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_char('"')?;
        for &byte in self.0 {
            write_character(f, byte)?;
        }
        f.write_char('"')
    }
}

impl fmt::Debug for Quoted<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// A number of bytes in words.
///
/// ```
/// # use link_core::text::ByteCount;
/// assert_eq!([0, 1, 8].map(|count| ByteCount(count).to_string()), ["0 bytes", "1 byte", "8 bytes"]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ByteCount(pub usize);

impl ByteCount {
    /// The word behind the number.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        if self.0 == 1 { "byte" } else { "bytes" }
    }
}

impl fmt::Display for ByteCount {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_decimal(f, u64::try_from(self.0).unwrap_or(u64::MAX))?;
        f.write_char(' ')?;
        f.write_str(self.unit())
    }
}

/// Writes two hexadecimal digits.
pub fn write_hex8(f: &mut fmt::Formatter<'_>, byte: u8) -> fmt::Result {
    write_ascii(f, &digits(byte))
}

/// Writes four hexadecimal digits.
pub fn write_hex16(f: &mut fmt::Formatter<'_>, value: u16) -> fmt::Result {
    let [high, low] = value.to_be_bytes();
    write_hex8(f, high)?;
    write_hex8(f, low)
}

/// Writes `0x` and as many digits as the value needs: two, four or eight.
pub fn write_prefixed_hex(f: &mut fmt::Formatter<'_>, value: u32) -> fmt::Result {
    f.write_str("0x")?;
    let bytes = value.to_be_bytes();
    let significant: &[u8] = match bytes {
        [0, 0, 0, low @ ..] => &{ low },
        [0, 0, low @ ..] => &{ low },
        all => &{ all },
    };
    significant.iter().try_for_each(|&byte| write_hex8(f, byte))
}

/// Writes a decimal number; width and fill of the formatter are not applied.
pub fn write_decimal(f: &mut fmt::Formatter<'_>, value: u64) -> fmt::Result {
    if let Ok(digit @ 0..=9) = u8::try_from(value) {
        return f.write_char(char::from(digit | b'0'));
    }
    let mut digits = [b'0'; MAX_DECIMAL_DIGITS];
    let mut rest = value;
    let mut used: usize = 0;
    for place in digits.iter_mut().rev() {
        *place = u8::try_from(rest % 10).map_or(b'0', |digit| digit | b'0');
        rest /= 10;
        used = used.saturating_add(1);
        if rest == 0 {
            break;
        }
    }
    write_ascii(f, digits.get(MAX_DECIMAL_DIGITS.saturating_sub(used)..).unwrap_or_default())
}

/// Writes a signed decimal number; width and fill of the formatter are not applied.
pub fn write_signed(f: &mut fmt::Formatter<'_>, value: i64) -> fmt::Result {
    if value < 0 {
        f.write_char('-')?;
    }
    write_decimal(f, value.unsigned_abs())
}

/// Writes words with a separator between them.
pub fn write_joined<'a>(
    f: &mut fmt::Formatter<'_>,
    separator: &str,
    words: impl IntoIterator<Item = &'a str>,
) -> fmt::Result {
    let mut before = "";
    for word in words {
        f.write_str(before)?;
        f.write_str(word)?;
        before = separator;
    }
    Ok(())
}

fn write_character(f: &mut fmt::Formatter<'_>, byte: u8) -> fmt::Result {
    match byte {
        b'"' | b'\\' => {
            f.write_char('\\')?;
            f.write_char(char::from(byte))
        }
        0x20..=0x7E | 0xA0..=0xAC | 0xAE..=0xFF => f.write_char(char::from(byte)),
        _ => {
            f.write_str("\\x")?;
            write_hex8(f, byte)
        }
    }
}

/// Several characters at once: a formatter is entered through a table of functions each time.
fn write_ascii(f: &mut fmt::Formatter<'_>, text: &[u8]) -> fmt::Result {
    f.write_str(core::str::from_utf8(text).map_err(|_| fmt::Error)?)
}

fn digits(byte: u8) -> [u8; 2] {
    [byte >> 4, byte & 0x0F].map(|nibble| HEX_DIGITS.get(usize::from(nibble)).copied().unwrap_or(b'?'))
}

const HEX_DIGITS: [u8; 16] = *b"0123456789ABCDEF";
/// The data of a frame in one piece.
const HEX_CHUNK: usize = 8;
const MAX_DECIMAL_DIGITS: usize = 20;

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::{format, string::ToString};

    struct Prefixed(u32);

    impl fmt::Display for Prefixed {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            write_prefixed_hex(f, self.0)
        }
    }

    struct Signed(i64);

    impl fmt::Display for Signed {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            write_signed(f, self.0)
        }
    }

    #[test]
    fn hexadecimal_width_follows_the_value() {
        assert_eq!(Prefixed(0x0A).to_string(), "0x0A");
        assert_eq!(Prefixed(0x100).to_string(), "0x0100");
        assert_eq!(Prefixed(0x1_0000).to_string(), "0x00010000");
    }

    #[test]
    fn quotes_and_controls_are_escaped() {
        assert_eq!(Quoted(b"a\"b\\c\n\x7F").to_string(), r#""a\"b\\c\x0A\x7F""#);
        assert_eq!(Quoted(&[0xE9, 0x85]).to_string(), "\"\u{e9}\\x85\"");
    }

    proptest! {
        #[test]
        fn decimal_is_what_the_standard_library_prints(value: i64) {
            prop_assert_eq!(Signed(value).to_string(), value.to_string());
        }

        #[test]
        fn hex_is_what_the_standard_library_prints(bytes: std::vec::Vec<u8>) {
            let expected = bytes.iter().map(|byte| format!("{byte:02X}")).collect::<std::vec::Vec<_>>().join(" ");
            prop_assert_eq!(Hex(&bytes).to_string(), expected);
        }
    }
}
