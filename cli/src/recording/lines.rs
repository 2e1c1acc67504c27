//! Lines of a text file, without copying or allocating.

use std::io::{self, Read};

use memchr::memchr;

use super::window::Window;

/// Splits a source into lines. Memory is one buffer, whatever the file.
pub(super) struct Lines<R> {
    window: Window<R>,
    number: u64,
    /// Of the last line that was too long.
    beginning: Vec<u8>,
}

/// One line without its line end.
pub(super) enum Line<'a> {
    Text(&'a [u8]),
    /// Longer than the window: certainly no line of a recording. Its beginning.
    TooLong(&'a [u8]),
}

impl<R: Read> Lines<R> {
    pub(super) fn new(window: Window<R>) -> Self {
        Self { window, number: 0, beginning: Vec::new() }
    }

    /// What is to come, for whoever must look ahead.
    pub(super) fn window(&mut self) -> &mut Window<R> {
        &mut self.window
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
            let ahead = self.window.ahead();
            if let Some(length) = memchr(b'\n', &ahead[searched..]) {
                self.number += 1;
                let line = self.window.take(searched + length, 1);
                return Ok(Some(Line::Text(without_return(line))));
            }
            searched = ahead.len();
            if self.window.is_at_end() {
                if searched == 0 {
                    return Ok(None);
                }
                self.number += 1;
                return Ok(Some(Line::Text(without_return(self.window.take(searched, 0)))));
            }
            if !self.window.can_fill() {
                self.number += 1;
                return self.too_long().map(|line| Some(Line::TooLong(line)));
            }
            self.window.fill()?;
        }
    }

    /// Drops a line that fills the window, but for its beginning.
    #[cold]
    fn too_long(&mut self) -> io::Result<&[u8]> {
        let shown = self.window.ahead().iter().take(TOO_LONG_SHOWN).copied().collect();
        self.beginning = shown;
        loop {
            let seen = self.window.ahead();
            match memchr(b'\n', seen) {
                Some(length) => {
                    self.window.skip(length + 1);
                    break;
                }
                None => {
                    let seen = seen.len();
                    self.window.skip(seen);
                }
            }
            if self.window.is_at_end() {
                break;
            }
            self.window.fill()?;
        }
        Ok(&self.beginning)
    }
}

fn without_return(line: &[u8]) -> &[u8] {
    line.strip_suffix(b"\r").unwrap_or(line)
}

const TOO_LONG_SHOWN: usize = 64;

#[cfg(test)]
mod tests {
    use super::super::window::WINDOW;
    use super::*;

    fn split(text: &[u8]) -> Vec<(u64, Vec<u8>)> {
        let mut lines = Lines::new(Window::new(text));
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
    fn lines_across_the_end_of_the_window_stay_whole() {
        let text: Vec<u8> = (0..100_000).flat_map(|n| format!("line {n}\n").into_bytes()).collect();
        let lines = split(&text);
        assert_eq!(lines.len(), 100_000);
        assert!(lines.iter().enumerate().all(|(n, (_, line))| *line == format!("line {n}").into_bytes()));
    }

    #[test]
    fn a_line_without_end_is_cut_and_the_next_is_found() {
        let text = [vec![b'x'; 3 * WINDOW], b"\nnext\n".to_vec()].concat();
        let lines = split(&text);
        assert_eq!(lines[0].1, [b"long ".to_vec(), vec![b'x'; TOO_LONG_SHOWN]].concat());
        assert_eq!(lines[1], (2, b"next".to_vec()));
    }
}
