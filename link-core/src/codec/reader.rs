//! Bounded little-endian reading.

use super::{ParseError, ParseErrorKind};

/// Reads little-endian fields from a slice, never past its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Reader<'a> {
    rest: &'a [u8],
    offset: usize,
}

macro_rules! numbers {
    ($($number:ident)*) => {$(
        #[doc = concat!("Reads a little-endian `", stringify!($number), "`.")]
        pub fn $number(&mut self, field: &'static str) -> Result<$number, ParseError> {
            Ok($number::from_le_bytes(self.array(field)?))
        }
    )*};
}

impl<'a> Reader<'a> {
    /// A reader of all of `bytes`.
    pub const fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes, offset: 0 }
    }

    /// The number of bytes read so far, counted from the start of the outermost slice.
    pub const fn offset(&self) -> usize {
        self.offset
    }

    /// The number of bytes that remain.
    pub const fn remaining(&self) -> usize {
        self.rest.len()
    }

    /// True if nothing remains.
    pub const fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }

    /// The bytes that remain, without taking them.
    pub const fn peek(&self) -> &'a [u8] {
        self.rest
    }

    numbers!(u8 u16 u32 u64 i8 i16 i32 i64 f32 f64);

    /// Reads `N` bytes.
    pub fn array<const N: usize>(&mut self, field: &'static str) -> Result<[u8; N], ParseError> {
        let Some((head, rest)) = self.rest.split_first_chunk::<N>() else {
            return Err(self.short(field, N));
        };
        self.rest = rest;
        self.offset = self.offset.saturating_add(N);
        Ok(*head)
    }

    /// Takes `len` bytes.
    pub fn bytes(&mut self, len: usize, field: &'static str) -> Result<&'a [u8], ParseError> {
        let Some((head, rest)) = self.rest.split_at_checked(len) else {
            return Err(self.short(field, len));
        };
        self.rest = rest;
        self.offset = self.offset.saturating_add(len);
        Ok(head)
    }

    /// Takes all that remains.
    pub fn rest(&mut self) -> &'a [u8] {
        let rest = self.rest;
        self.offset = self.offset.saturating_add(rest.len());
        self.rest = &[];
        rest
    }

    /// A reader of the next `len` bytes only; offsets in its errors still count from the outermost slice.
    pub fn sub(&mut self, len: usize, field: &'static str) -> Result<Self, ParseError> {
        let offset = self.offset;
        Ok(Self { rest: self.bytes(len, field)?, offset })
    }

    /// Demands that nothing remains; `message` names what is complete by now.
    pub const fn finish(self, message: &'static str) -> Result<(), ParseError> {
        if self.rest.is_empty() {
            return Ok(());
        }
        let kind = ParseErrorKind::Trailing { found: self.rest.len() };
        Err(ParseError { field: message, offset: self.offset, kind })
    }

    const fn short(&self, field: &'static str, expected: usize) -> ParseError {
        let kind = ParseErrorKind::Short { expected, found: self.rest.len() };
        ParseError { field, offset: self.offset, kind }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    #[test]
    fn numbers_are_little_endian() {
        let mut reader = Reader::new(&[0x01, 0x34, 0x12, 0xEF, 0xBE, 0xAD, 0xDE, 0xFE, 0xFF]);
        assert_eq!(reader.u8("a"), Ok(1));
        assert_eq!(reader.u16("b"), Ok(0x1234));
        assert_eq!(reader.u32("c"), Ok(0xDEAD_BEEF));
        assert_eq!(reader.i16("d"), Ok(-2));
        assert_eq!(reader.finish("all"), Ok(()));
    }

    #[test]
    fn a_failed_read_takes_nothing() {
        let mut reader = Reader::new(&[1, 2, 3]);
        assert!(reader.u32("serial").is_err());
        assert_eq!((reader.offset(), reader.remaining()), (0, 3));
        assert_eq!(reader.bytes(3, "all"), Ok(&[1, 2, 3][..]));
    }

    #[test]
    fn offsets_of_a_sub_reader_count_from_the_start() {
        let mut reader = Reader::new(&[1, 2, 3, 4]);
        reader.u8("head").unwrap();
        let mut sub = reader.sub(2, "body").unwrap();
        sub.u8("x").unwrap();
        let error = sub.u16("y").unwrap_err();
        assert_eq!(error.to_string(), "y at offset 2: 2 bytes expected, 1 found");
        assert_eq!(reader.u8("tail"), Ok(4));
    }

    #[test]
    fn trailing_bytes_name_the_message() {
        let error = Reader::new(&[0]).finish("Allocate").unwrap_err();
        assert_eq!(error.to_string(), "Allocate at offset 0: 1 trailing byte");
    }
}
