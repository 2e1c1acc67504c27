//! Reading and writing of bytes: the only door between a slice and a value.
//!
//! Everything on the wire is little-endian. A [`Reader`] knows the bytes that remain and the name of the field that
//! is being read, so that a short message yields an error that says which field was cut; a [`Writer`] fills a slice
//! that the caller owns and says [`Full`] instead of truncating. Neither can panic.
//!
//! ```
//! use link_core::codec::{Reader, Writer};
//!
//! let mut reader = Reader::new(&[0x34, 0x12, 0x01]);
//! assert_eq!(reader.u16("product code"), Ok(0x1234));
//! let error = reader.u32("serial number").unwrap_err();
//! assert_eq!(error.to_string(), "serial number at offset 2: 4 bytes expected, 1 found");
//!
//! let mut buffer = [0; 4];
//! let mut writer = Writer::new(&mut buffer);
//! writer.u16(0x1234).unwrap();
//! assert_eq!(writer.written(), [0x34, 0x12]);
//! ```

mod error;
#[doc(hidden)]
pub mod laws;
mod reader;
mod writer;

pub use error::{Full, ParseError, ParseErrorKind};
pub use reader::Reader;
pub use writer::Writer;

/// How the bytes of a type end, which decides what a test may demand of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Tail {
    /// The length is fixed or told by the bytes themselves: every strict prefix and every trailing byte is an error.
    Closed,
    /// The type ends in free data or in optional fields: a shorter or longer message can be valid as well.
    Open,
}

/// A value with a byte layout.
///
/// The laws, checked by a test of every implementation: `parse(emit(x)) == x`; `emit(parse(b)) == b` for every `b`
/// that parses; `emit` writes exactly `wire_len()` bytes; with [`Tail::Closed`] every strict prefix and every
/// trailing byte is refused.
pub trait Wire<'a>: Sized {
    /// What the message is called in errors and listings.
    const NAME: &'static str;
    /// How the bytes end.
    const TAIL: Tail = Tail::Closed;

    /// Reads the value from the front of `reader`.
    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError>;

    /// Writes the value to the end of `out`.
    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full>;

    /// The number of bytes that [`emit`](Self::emit) writes.
    fn wire_len(&self) -> usize;

    /// Reads the value from `bytes`, which must hold nothing else.
    fn parse(bytes: &'a [u8]) -> Result<Self, ParseError> {
        let mut reader = Reader::new(bytes);
        let value = Self::read(&mut reader)?;
        reader.finish(Self::NAME)?;
        Ok(value)
    }
}
