//! A part of a file in memory that moves on as it is read.

use std::io::{self, Read};

/// A buffer of fixed size before a source: memory does not grow with the file.
pub(super) struct Window<R> {
    source: R,
    buffer: Box<[u8]>,
    /// The bytes of the buffer that are not yet given out.
    start: usize,
    end: usize,
    at_end: bool,
}

impl<R: Read> Window<R> {
    pub(super) fn new(source: R) -> Self {
        let buffer = vec![0; WINDOW].into_boxed_slice();
        Self { source, buffer, start: 0, end: 0, at_end: false }
    }

    /// What was read and not yet given out.
    #[inline]
    pub(super) fn ahead(&self) -> &[u8] {
        &self.buffer[self.start..self.end]
    }

    /// Whether there is room, and perhaps more to come.
    #[inline]
    pub(super) fn can_fill(&self) -> bool {
        !self.at_end && self.end - self.start < self.buffer.len()
    }

    /// Whether the source has been read to its end.
    #[inline]
    pub(super) fn is_at_end(&self) -> bool {
        self.at_end
    }

    /// Reads once, which may wait, and gives nothing out. There must be room.
    #[cold]
    pub(super) fn fill(&mut self) -> io::Result<()> {
        self.buffer.copy_within(self.start..self.end, 0);
        self.end -= self.start;
        self.start = 0;
        let read = loop {
            match self.source.read(&mut self.buffer[self.end..]) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                result => break result?,
            }
        };
        self.at_end = read == 0;
        self.end += read;
        Ok(())
    }

    /// Reads until so many bytes can be seen, at most [`WINDOW`]; fewer when the source ends.
    #[inline]
    pub(super) fn up_to(&mut self, bytes: usize) -> io::Result<&[u8]> {
        while self.end - self.start < bytes && self.can_fill() {
            self.fill()?;
        }
        let seen = self.ahead();
        Ok(&seen[..bytes.min(seen.len())])
    }

    /// Gives out so many bytes of what can be seen.
    #[inline]
    pub(super) fn skip(&mut self, bytes: usize) {
        self.start = (self.start + bytes).min(self.end);
    }

    /// Gives out so many bytes of what can be seen, and drops some after them.
    #[inline]
    pub(super) fn take(&mut self, bytes: usize, and_drop: usize) -> &[u8] {
        let taken = self.start..self.start + bytes;
        self.start = taken.end + and_drop;
        &self.buffer[taken]
    }

    /// Gives out so many bytes, seen or not, and says whether they were there.
    #[inline]
    pub(super) fn discard(&mut self, bytes: usize) -> io::Result<bool> {
        let mut missing = bytes;
        loop {
            let seen = missing.min(self.end - self.start);
            self.skip(seen);
            missing -= seen;
            if missing == 0 || self.at_end {
                return Ok(missing == 0);
            }
            self.fill()?;
        }
    }
}

/// The most bytes that can be seen at once.
pub(super) const WINDOW: usize = 256 * 1024;
