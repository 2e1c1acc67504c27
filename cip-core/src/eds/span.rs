//! Places in a file.

use std::vec::Vec;

use super::Encoding;
use super::encoding::Characters;

/// The bytes from `start` up to, not including, `end`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Span {
    /// The first byte.
    pub start: usize,
    /// The byte behind the last one.
    pub end: usize,
}

impl Span {
    /// The place between two bytes.
    #[must_use]
    pub const fn at(place: usize) -> Self {
        Self { start: place, end: place }
    }

    /// From the start of one to the end of another.
    #[must_use]
    pub const fn to(self, last: Self) -> Self {
        Self { start: self.start, end: last.end }
    }

    /// Its bytes in a file; none if it is not of this file.
    #[must_use]
    pub fn of(self, bytes: &[u8]) -> &[u8] {
        bytes.get(self.start..self.end).unwrap_or_default()
    }
}

/// Line and column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Place {
    /// From 1.
    pub line: usize,
    /// In characters, from 1.
    pub column: usize,
}

/// Where the lines of a file begin.
#[derive(Debug, Clone, Default)]
pub(super) struct Lines {
    /// The first byte of each line.
    starts: Vec<usize>,
}

impl Lines {
    /// From the ends of the lines but the last.
    pub(super) fn new(ends: impl Iterator<Item = usize>) -> Self {
        Self { starts: core::iter::once(0).chain(ends).collect() }
    }

    /// The line that a byte is on, from 1.
    pub(super) fn line_of(&self, at: usize) -> usize {
        self.starts.partition_point(|&start| start <= at)
    }

    /// The bytes of a line, without what ends it.
    pub(super) fn span_of(&self, line: usize, len: usize) -> Span {
        let start = line.checked_sub(1).and_then(|index| self.starts.get(index)).copied().unwrap_or(len);
        Span { start, end: self.starts.get(line).copied().unwrap_or(len) }
    }

    /// Tells lines and columns of places that ascend, in one pass over the file however many there are.
    pub(super) fn places(
        &self,
        bytes: &[u8],
        encoding: Encoding,
        mark: usize,
        ascending: impl Iterator<Item = usize>,
    ) -> Vec<Place> {
        let whole = Span { start: mark, end: bytes.len() };
        let (mut line, mut column) = (0, 1);
        let mut characters = Characters::of(bytes, whole, encoding);
        let place = |at| {
            let line_of_place = self.line_of(at);
            if line_of_place != line {
                line = line_of_place;
                column = 1;
                let start = self.span_of(line, bytes.len()).start.max(mark);
                characters = Characters::of(bytes, Span { start, end: bytes.len() }, encoding);
            }
            while characters.at() < at && characters.next().is_some() {
                column = usize::saturating_add(column, 1);
            }
            Place { line, column }
        };
        ascending.map(place).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_characters() {
        let bytes = "\u{FEFF}°°\n°x\r\n\r".as_bytes();
        let lines = Lines::new([8, 13, 14].into_iter());
        let places = lines.places(bytes, Encoding::Utf8, 3, [3, 5, 7, 8, 10, 13, 14].into_iter());
        let shown: Vec<_> = places.iter().map(|place| (place.line, place.column)).collect();
        assert_eq!(shown, [(1, 1), (1, 2), (1, 3), (2, 1), (2, 2), (3, 1), (4, 1)]);
        assert_eq!(lines.span_of(2, bytes.len()), Span { start: 8, end: 13 });
        assert_eq!(lines.span_of(9, bytes.len()), Span::at(14));
    }
}
