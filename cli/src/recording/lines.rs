//! Lines of a text file, without copying or allocating.

use std::io::{self, Read};

use memchr::memchr;

/// Splits a reader into lines. Memory is one buffer, whatever the file.
pub(super) struct Lines<R> {
    source: R,
    buffer: Box<[u8]>,
    /// The bytes of the buffer that are not yet given out.
    start: usize,
    end: usize,
    at_end: bool,
    number: u64,
}

/// One line without its line end.
pub(super) enum Line<'a> {
    Text(&'a [u8]),
    /// Longer than the buffer: certainly no line of a recording. Its beginning.
    TooLong(&'a [u8]),
}

impl<R: Read> Lines<R> {
    pub(super) fn new(source: R) -> Self {
        let buffer = vec![0; BUFFER].into_boxed_slice();
        Self { source, buffer, start: 0, end: 0, at_end: false, number: 0 }
    }

    /// Reads once more, if there is room and more to come, without giving anything out.
    pub(super) fn read_ahead(&mut self) -> io::Result<()> {
        match self.can_read_ahead() {
            true => self.fill(),
            false => Ok(()),
        }
    }

    /// Whether [`read_ahead`](Self::read_ahead) may add to what [`ahead`](Self::ahead) shows.
    pub(super) fn can_read_ahead(&self) -> bool {
        !self.at_end && self.end < self.buffer.len()
    }

    /// What was read and not yet given out.
    pub(super) fn ahead(&self) -> &[u8] {
        &self.buffer[self.start..self.end]
    }

    /// Drops so many bytes of what [`ahead`](Self::ahead) shows.
    pub(super) fn skip(&mut self, bytes: usize) {
        self.start = (self.start + bytes).min(self.end);
    }

    /// What was read, and then the rest of the source.
    pub(super) fn into_reader(self) -> impl Read {
        let peeked = self.buffer[self.start..self.end].to_vec();
        io::Cursor::new(peeked).chain(self.source)
    }

    /// The number of the line that [`next`](Self::next) gave last, from 1.
    pub(super) fn number(&self) -> u64 {
        self.number
    }

    /// The next line, `None` at the end.
    #[inline]
    pub(super) fn next(&mut self) -> io::Result<Option<Line<'_>>> {
        let mut searched = 0;
        loop {
            if let Some(length) = memchr(b'\n', &self.buffer[self.start + searched..self.end]) {
                let line = self.start..self.start + searched + length;
                self.start = line.end + 1;
                self.number += 1;
                return Ok(Some(Line::Text(without_return(&self.buffer[line]))));
            }
            searched = self.end - self.start;
            if self.at_end {
                if searched == 0 {
                    return Ok(None);
                }
                let line = self.start..self.end;
                self.start = self.end;
                self.number += 1;
                return Ok(Some(Line::Text(without_return(&self.buffer[line]))));
            }
            if searched == self.buffer.len() {
                self.skip_line()?;
                self.number += 1;
                return Ok(Some(Line::TooLong(&self.buffer[..TOO_LONG_SHOWN])));
            }
            self.fill()?;
        }
    }

    #[cold]
    fn fill(&mut self) -> io::Result<()> {
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

    /// Drops the rest of a line that fills the buffer, but keeps its beginning at the front.
    #[cold]
    fn skip_line(&mut self) -> io::Result<()> {
        loop {
            (self.start, self.end) = (TOO_LONG_SHOWN, TOO_LONG_SHOWN);
            let read = match self.source.read(&mut self.buffer[TOO_LONG_SHOWN..]) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                result => result?,
            };
            self.end += read;
            self.at_end = read == 0;
            let rest = &self.buffer[self.start..self.end];
            if let Some(length) = memchr(b'\n', rest) {
                self.start += length + 1;
                return Ok(());
            }
            if self.at_end {
                return Ok(());
            }
        }
    }
}

fn without_return(line: &[u8]) -> &[u8] {
    line.strip_suffix(b"\r").unwrap_or(line)
}

const BUFFER: usize = 256 * 1024;
const TOO_LONG_SHOWN: usize = 64;

#[cfg(test)]
mod tests {
    use super::*;

    fn split(text: &[u8]) -> Vec<(u64, Vec<u8>)> {
        let mut lines = Lines::new(text);
        let mut all = Vec::new();
        while let Some(line) = lines.next().unwrap() {
            let text = match line {
                Line::Text(text) => text.to_vec(),
                Line::TooLong(text) => [b"long ", text].concat(),
            };
            all.push((lines.number(), text));
        }
        all
    }

    #[test]
    fn splits_at_either_line_end_and_needs_none_at_the_end() {
        let lines = split(b"a\r\n\nb");
        assert_eq!(lines, [(1, b"a".to_vec()), (2, b"".to_vec()), (3, b"b".to_vec())]);
    }

    #[test]
    fn lines_across_the_end_of_the_buffer_stay_whole() {
        let text: Vec<u8> = (0..100_000).flat_map(|n| format!("line {n}\n").into_bytes()).collect();
        let lines = split(&text);
        assert_eq!(lines.len(), 100_000);
        assert!(lines.iter().enumerate().all(|(n, (_, line))| *line == format!("line {n}").into_bytes()));
    }

    #[test]
    fn a_line_without_end_is_cut_and_the_next_is_found() {
        let text = [vec![b'x'; 3 * BUFFER], b"\nnext\n".to_vec()].concat();
        let lines = split(&text);
        assert_eq!(lines[0].1, [b"long ".to_vec(), vec![b'x'; TOO_LONG_SHOWN]].concat());
        assert_eq!(lines[1], (2, b"next".to_vec()));
    }
}
