//! The one text form of bus traffic: what `decode` and `simulate` print, tests compare and bug reports quote.
//!
//! ```text
//! time               node  identifier  data                      decoded words
//! 1700000006.000000     1         456  01 4B 03 01 03 01        | ...
//! 1700000006.000300    10         453  01 CB 00                 | ...
//! 1700000006.000400     -    18FEF1FE  remote [5]               | ...
//! 1700000006.000500     -       error  00 04 00 00 00 00 00 00  | error frame: controller problem
//! 1700000006.000600     1        PRes  01 02 03 04 05 06 07 ..  | ...
//! ```
//! Time is in seconds with microseconds. The node is the one that sent, `-` where that is not known. The columns are
//! two blanks apart, and ` | ` comes first before the words. A column becomes wider when something does not fit, and
//! never narrower, so that lines stay aligned.

use core::fmt::{self, Display, Write as _};

use anstyle::{AnsiColor, Style};
use link_core::{Frame, Id, Instant};

use crate::recording::Content;
use crate::text::{UPPER, push_hex, push_number, push_seconds};

/// Writes lines of a trace into a buffer.
#[derive(Clone, Debug)]
pub struct Trace {
    coloured: bool,
    time_width: usize,
    node_width: usize,
}

/// How much a line should be noticed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Emphasis {
    /// Ordinary traffic.
    Normal,
    /// Something is wrong: red, where there are colours.
    Problem,
}

impl Trace {
    /// A trace in plain text, or with colours for a terminal.
    #[must_use]
    pub fn new(coloured: bool) -> Self {
        Self { coloured, time_width: TIME_WIDTH, node_width: NODE_WIDTH }
    }

    /// The same, with room for names of this width from the first line on.
    #[must_use]
    pub fn with_node_width(mut self, width: usize) -> Self {
        self.node_width = self.node_width.max(width);
        self
    }

    /// A frame that `node` sent.
    #[inline]
    pub fn frame(
        &mut self,
        out: &mut Vec<u8>,
        at: Instant,
        node: impl AsRef<[u8]>,
        frame: &Frame,
        words: impl Display,
    ) {
        let mut line = self.begin(out, at, node.as_ref(), Emphasis::Normal);
        line.frame(frame);
        line.words(words);
    }

    /// Any entry of a recording.
    #[inline]
    pub fn entry(
        &mut self,
        out: &mut Vec<u8>,
        at: Instant,
        node: impl AsRef<[u8]>,
        content: &Content,
        emphasis: Emphasis,
        words: impl Display,
    ) {
        let mut line = self.begin(out, at, node.as_ref(), emphasis);
        match content {
            Content::Classic(frame) => line.frame(frame),
            Content::Error(error) => {
                line.id(b"   error");
                line.data(&error.data);
            }
            Content::Fd(frame) => {
                line.frame_id(frame.id());
                line.data(frame.data());
            }
        }
        line.words(words);
    }

    /// An Ethernet frame: the name of its message stands for the identifier, and the data are those of its application, of
    /// which the column shows the first.
    #[inline]
    pub fn message(
        &mut self,
        out: &mut Vec<u8>,
        at: Instant,
        node: impl AsRef<[u8]>,
        (name, data): (&str, &[u8]),
        emphasis: Emphasis,
        words: impl Display,
    ) {
        let mut line = self.begin(out, at, node.as_ref(), emphasis);
        let mut id = [b' '; ID_WIDTH];
        for (slot, letter) in id.iter_mut().rev().zip(name.bytes().rev()) {
            *slot = letter;
        }
        line.id(&id);
        if data.len() > Frame::MAX_DATA {
            line.data(&data[..Frame::MAX_DATA - 1]);
            line.out.truncate(line.out.len() - 2);
            line.out.extend_from_slice(b"..");
        } else {
            line.data(data);
        }
        line.words(words);
    }

    /// Something that happened at a node without a frame: a change of state, a power cycle.
    pub fn event(
        &mut self,
        out: &mut Vec<u8>,
        at: Instant,
        node: &str,
        emphasis: Emphasis,
        words: impl Display,
    ) {
        let mut line = self.begin(out, at, node.as_ref(), emphasis);
        line.id(&[b' '; ID_WIDTH]);
        line.words(words);
    }

    #[inline]
    fn begin<'a>(&mut self, out: &'a mut Vec<u8>, at: Instant, node: &[u8], emphasis: Emphasis) -> Line<'a> {
        let style = self.coloured.then_some(emphasis);
        if self.coloured {
            let _ = write!(Utf8(out), "{DIM}");
        }
        let start = out.len();
        push_seconds(out, at, 6);
        self.time_width = self.time_width.max(out.len() - start);
        align_right(out, start, self.time_width);
        if self.coloured {
            let _ = write!(Utf8(out), "{DIM:#}");
        }
        self.node_width = self.node_width.max(node.len());
        pad(out, 2 + self.node_width - node.len());
        out.extend_from_slice(node);
        out.extend_from_slice(b"  ");
        Line { out, missing: DATA_WIDTH, style }
    }
}

/// The rest of a line.
struct Line<'a> {
    out: &'a mut Vec<u8>,
    /// Blanks to the end of the data column.
    missing: usize,
    style: Option<Emphasis>,
}

impl Line<'_> {
    #[inline]
    fn frame(&mut self, frame: &Frame) {
        self.frame_id(frame.id());
        if frame.is_remote() {
            let start = self.out.len();
            self.out.extend_from_slice(b"remote [");
            push_number(self.out, frame.dlc());
            self.out.push(b']');
            self.missing = DATA_WIDTH.saturating_sub(self.out.len() - start);
            return;
        }
        self.data(frame.data());
        if frame.dlc() > 8 {
            self.out.extend_from_slice(b" _");
            self.out.push(UPPER[usize::from(frame.dlc() & 0xF)]);
        }
    }

    #[inline]
    fn frame_id(&mut self, id: Id) {
        let mut text = [b' '; ID_WIDTH];
        let (mut raw, digits) = match id {
            Id::Standard(id) => (u32::from(id.as_raw()), 3),
            Id::Extended(id) => (id.as_raw(), 8),
        };
        for slot in text.iter_mut().rev().take(digits) {
            *slot = UPPER[(raw & 0xF) as usize];
            raw >>= 4;
        }
        self.id(&text);
    }

    #[inline]
    fn id(&mut self, text: &[u8; ID_WIDTH]) {
        self.out.extend_from_slice(text);
        self.out.extend_from_slice(b"  ");
    }

    /// Fills the column; CAN FD data reach beyond it.
    #[inline]
    fn data(&mut self, bytes: &[u8]) {
        let (column, beyond) = bytes.split_at(bytes.len().min(Frame::MAX_DATA));
        let mut text = [b' '; DATA_WIDTH];
        for (slot, byte) in text.chunks_mut(3).zip(column) {
            slot[0] = UPPER[usize::from(byte >> 4)];
            slot[1] = UPPER[usize::from(byte & 0xF)];
        }
        self.out.extend_from_slice(&text);
        self.missing = 0;
        for byte in beyond {
            self.out.push(b' ');
            push_hex(self.out, &[*byte], UPPER);
        }
    }

    #[inline]
    fn words(self, words: impl Display) {
        pad(self.out, self.missing);
        self.out.extend_from_slice(b"  | ");
        // Writing into a vector cannot fail, and a `Display` that reports an error has no more to say.
        let _ = match self.style {
            Some(Emphasis::Problem) => write!(Utf8(self.out), "{RED}{words}{RED:#}"),
            Some(Emphasis::Normal) | None => write!(Utf8(self.out), "{words}"),
        };
        self.out.push(b'\n');
    }
}

/// Lets `fmt` write into a vector of bytes.
pub(crate) struct Utf8<'a>(pub(crate) &'a mut Vec<u8>);

impl fmt::Write for Utf8<'_> {
    #[inline]
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.extend_from_slice(text.as_bytes());
        Ok(())
    }

    /// Digits come one by one.
    #[inline]
    fn write_char(&mut self, character: char) -> fmt::Result {
        match u8::try_from(character) {
            Ok(byte) if byte.is_ascii() => self.0.push(byte),
            _ => self.0.extend_from_slice(character.encode_utf8(&mut [0; 4]).as_bytes()),
        }
        Ok(())
    }
}

/// Moves what stands from `start` to the end to the right.
#[inline]
fn align_right(out: &mut Vec<u8>, start: usize, width: usize) {
    let missing = width.saturating_sub(out.len() - start);
    if missing > 0 {
        pad(out, missing);
        out[start..].rotate_right(missing);
    }
}

#[inline]
fn pad(out: &mut Vec<u8>, blanks: usize) {
    for _ in 0..blanks {
        out.push(b' ');
    }
}

const DIM: Style = Style::new().dimmed();
const RED: Style = AnsiColor::Red.on_default();

/// Three digits before the point are enough for a simulation.
const TIME_WIDTH: usize = 10;
/// Two digits of a MAC ID, and some letters of a name.
const NODE_WIDTH: usize = 4;
const ID_WIDTH: usize = 8;
const DATA_WIDTH: usize = 23;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::ErrorFrame;
    use link_core::frame::{extended_id, standard_id};

    #[test]
    fn columns_are_aligned_and_only_grow() {
        let (mut trace, mut out) = (Trace::new(false), Vec::new());
        let at = Instant::from_nanos(6_000_300_999);
        let allocate = Frame::new(standard_id(0x456), &[0x01, 0x4B, 0x03, 0x01, 0x03, 0x01]).unwrap();
        let long = Frame::with_dlc(standard_id(0x3CA), 9, [0xFF; 8]).unwrap();
        let remote = Frame::remote(extended_id(0x18FE_F1FE), 5).unwrap();
        let error = Content::Error(ErrorFrame { class: 4, data: [0, 4, 0, 0, 0, 0, 0, 0] });
        trace.frame(&mut out, at, "1", &allocate, "allocate");
        trace.frame(&mut out, at, "10", &long, "poll");
        trace.event(&mut out, at, "scanner", Emphasis::Normal, "online");
        trace.entry(&mut out, at, "-", &Content::Classic(remote), Emphasis::Normal, "remote frame");
        trace.entry(
            &mut out,
            Instant::from_micros(1_700_000_000_000_000),
            "-",
            &error,
            Emphasis::Problem,
            "error",
        );
        let expected = "\
              \x20 6.000300     1       456  01 4B 03 01 03 01        | allocate\n\
              \x20 6.000300    10       3CA  FF FF FF FF FF FF FF FF _9  | poll\n\
              \x20 6.000300  scanner                                     | online\n\
              \x20 6.000300        -  18FEF1FE  remote [5]               | remote frame\n\
              1700000000.000000        -     error  00 04 00 00 00 00 00 00  | error\n";
        assert_eq!(String::from_utf8(out).unwrap(), expected);
    }

    #[test]
    fn long_data_of_ethernet_are_cut() {
        let (mut trace, mut out) = (Trace::new(false), Vec::new());
        for len in [0, 8, 9] {
            trace.message(
                &mut out,
                Instant::ZERO,
                "1",
                ("PRes", &[0xA5; 9][..len]),
                Emphasis::Normal,
                "words",
            );
        }
        let expected = "\
              \x20 0.000000     1      PRes                           | words\n\
              \x20 0.000000     1      PRes  A5 A5 A5 A5 A5 A5 A5 A5  | words\n\
              \x20 0.000000     1      PRes  A5 A5 A5 A5 A5 A5 A5 ..  | words\n";
        assert_eq!(String::from_utf8(out).unwrap(), expected);
    }

    #[test]
    fn a_terminal_shows_problems_in_red() {
        let mut out = Vec::new();
        let frame = Content::Classic(Frame::new(standard_id(0x455), &[]).unwrap());
        Trace::new(true).entry(&mut out, Instant::ZERO, "1", &frame, Emphasis::Problem, "odd");
        assert!(String::from_utf8(out).unwrap().ends_with("| \u{1b}[31modd\u{1b}[0m\n"));
    }
}
