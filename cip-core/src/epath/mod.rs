//! Paths: how CIP names an object, an attribute, a route (EPATH; CIP Vol. 1, appendix C).
//!
//! A path is a row of segments. Bits 7-5 of a segment's first byte say what it is:
//!
//! | Bits 7-5 | Segment | Bytes (packed) |
//! |---|---|---|
//! | 000 | port | bits 3-0 port (15: a 16-bit port follows), bit 4: an address length byte follows; link address |
//! | 001 | logical | bits 4-2 what, bits 1-0 width; value of 1, 2 or 4 bytes |
//! | 010 | network | bits 4-0 subtype; one byte, or with bit 4 set a length in words and as many words |
//! | 011 | symbolic | bits 4-0 length 1-31, ASCII characters; 0x60: extended form |
//! | 100 | data | 0x80: length in words, words; 0x91: length in bytes, characters, a pad byte if odd |
//! | 101 | constructed data type | length in bytes, bytes |
//! | 110 | elementary data type | none |
//!
//! DeviceNet uses the **packed** form, where the value of a 16-bit or 32-bit logical segment follows its first byte
//! directly; in the **padded** form of other networks a zero byte stands between. The bytes do not say which form
//! they are in.
//!
//! ```
//! use cip_core::epath::Epath;
//!
//! let path = Epath::packed(&[0x20, 0x04, 0x24, 0x65, 0x30, 0x03]);
//! assert_eq!(path.to_string(), "class 4 instance 101 attribute 3");
//! ```

mod display;
mod emit;
mod logical;
mod read;
mod segment;

pub use emit::SegmentError;
pub use logical::{LogicalPath, Unpackable};
pub use segment::{ElectronicKey, ExtendedSymbol, LogicalKind, Segment, Width};

use crate::codec::{Full, ParseError, Reader, Writer};

/// Whether wide segments have a pad byte.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PathForm {
    /// Without: DeviceNet.
    Packed,
    /// With: other networks.
    Padded,
}

/// The bytes of a path, not yet looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Epath<'a> {
    bytes: &'a [u8],
    form: PathForm,
}

impl<'a> Epath<'a> {
    /// A path in the form of DeviceNet.
    pub const fn packed(bytes: &'a [u8]) -> Self {
        Self { bytes, form: PathForm::Packed }
    }

    /// A path in the form of other networks.
    pub const fn padded(bytes: &'a [u8]) -> Self {
        Self { bytes, form: PathForm::Padded }
    }

    /// The bytes.
    pub const fn bytes(self) -> &'a [u8] {
        self.bytes
    }

    /// The form.
    pub const fn form(self) -> PathForm {
        self.form
    }

    /// The segments in their order. After an error the iterator ends.
    pub const fn segments(self) -> Segments<'a> {
        Segments { reader: Reader::new(self.bytes), form: self.form }
    }

    /// The IDs of the logical segments; a later one replaces an earlier one of its kind, segments of other types are
    /// passed over.
    pub fn logical(self) -> Result<LogicalPath, ParseError> {
        LogicalPath::of(self)
    }
}

/// The segments of a path. See [`Epath::segments`].
#[derive(Debug, Clone)]
pub struct Segments<'a> {
    reader: Reader<'a>,
    form: PathForm,
}

impl<'a> Iterator for Segments<'a> {
    type Item = Result<Segment<'a>, ParseError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.reader.is_empty() {
            return None;
        }
        let segment = Segment::read(&mut self.reader, self.form);
        if segment.is_err() {
            self.reader.rest();
        }
        Some(segment)
    }
}

impl core::iter::FusedIterator for Segments<'_> {}

/// Writes a zero pad byte if `padded`.
fn write_pad(out: &mut Writer<'_>, padded: bool) -> Result<(), Full> {
    if padded { out.u8(0) } else { Ok(()) }
}

/// Reads a pad byte, which must be zero, if `padded`.
fn read_pad(reader: &mut Reader<'_>, padded: bool) -> Result<(), ParseError> {
    if !padded {
        return Ok(());
    }
    let offset = reader.offset();
    match reader.u8("pad byte")? {
        0 => Ok(()),
        found => Err(ParseError::value("pad byte", offset, found.into())),
    }
}

#[cfg(test)]
mod tests;
