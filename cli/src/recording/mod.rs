//! Recordings of a CAN bus, read and written as a stream: memory does not grow with the file. Captures of an Ethernet interface
//! are read too.
//!
//! | format | read | written |
//! |---|---|---|
//! | candump log (`-l`, `-L`) | yes | yes |
//! | candump screen output | yes | |
//! | pcap, pcapng with `LINKTYPE_CAN_SOCKETCAN` | yes | pcapng |
//! | Vector ASC | yes | |
//! | pcap, pcapng with `LINKTYPE_ETHERNET` | as a [`Capture`] | |
//!
//! The format is found in the content; a UTF-8 byte order mark before it is skipped. A line or record that cannot be read
//! is an error that says where, and what was expected; reading goes on after it. What a recording tells besides its
//! frames, such as frames that were lost, is in the [`Notes`].
//!
//! ```
//! use devicenet_cli::recording::{Content, Recording};
//! let log = b"(1700000000.000000) can0 456#014B03010301\n(1700000000.000100) can0 45";
//! let mut recording = Recording::from_reader(&log[..])?;
//! let first = recording.next().expect("one frame")?;
//! assert!(matches!(first.content, Content::Classic(frame) if frame.raw_id() == 0x456));
//! let bad = recording.next().expect("one bad line").unwrap_err();
//! assert_eq!(bad.to_string(), "2:28: \"#\" after the identifier expected, nothing found");
//! # Ok::<(), devicenet_cli::recording::RecordingError>(())
//! ```

mod asc;
mod candump;
mod capture;
pub(crate) mod controller;
mod detect;
mod error;
mod fields;
mod frame;
mod lines;
mod network;
mod notes;
mod pcap;
mod pcapng;
mod scan;
mod screen;
mod socketcan;
mod window;
mod write;

pub use capture::{Capture, EthernetFrame};
pub use detect::Format;
pub use error::{Bad, Place, RecordingError};
pub use frame::{ChannelId, Channels, Content, ErrorFrame, FdFrame, RecordedFrame};
pub use network::Network;
pub use notes::Notes;
pub use write::{Renamed, WriteFormat, Writer};

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use link_core::Instant;

use crate::standard::is_standard;
use asc::Asc;
use error::Fault;
use lines::{Line, Lines};
use pcap::Pcap;
use pcapng::PcapNg;
use screen::Screen;
use window::Window;

/// A recording being read: an iterator over its frames.
pub struct Recording {
    reader: Reader,
    channels: Channels,
    notes: Notes,
    format: Format,
    numbers: Numbers,
}

enum Reader {
    Candump(Lines<Source>),
    Screen(Lines<Source>, Screen),
    Asc(Lines<Source>, Asc),
    Pcap(Pcap),
    PcapNg(PcapNg),
}

type Source = Box<dyn Read>;

/// A frame that does not know its number yet.
#[derive(Clone, PartialEq, Eq, Debug)]
struct Parsed<C = Content> {
    at: Instant,
    digits: u8,
    channel: Option<ChannelId>,
    content: C,
}

/// How far a recording has been read.
#[derive(Default)]
struct Numbers {
    frames: u64,
    /// A fatal error was given out: nothing more comes.
    ended: bool,
}

impl Numbers {
    /// Gives a frame its number.
    #[inline]
    fn number<C>(
        &mut self,
        read: Result<Option<Parsed<C>>, RecordingError>,
    ) -> Option<Result<RecordedFrame<C>, RecordingError>> {
        match read.transpose()? {
            Ok(Parsed { at, digits, channel, content }) => {
                self.frames += 1;
                Some(Ok(RecordedFrame { n: self.frames, at, digits, channel, content }))
            }
            Err(error) => {
                self.ended = error.is_fatal();
                Some(Err(error))
            }
        }
    }
}

/// A recording of either network.
pub enum Opened {
    /// Of a CAN bus.
    Can(Recording),
    /// Of Ethernet.
    Ethernet(Capture),
}

impl Opened {
    /// Opens a file; `-` is standard input. Of which network it is, its content tells where nobody says it.
    ///
    /// # Errors
    /// [`RecordingError`] when it cannot be opened, or is not a recording of that network.
    pub fn open(path: &Path, network: Option<Network>) -> Result<Self, RecordingError> {
        Self::from_reader(source(path)?, network)
    }

    /// Reads from any source, which need not be buffered.
    ///
    /// # Errors
    /// [`RecordingError`] when the beginning cannot be read, or is not that of a recording of that network.
    pub fn from_reader(
        source: impl Read + 'static,
        network: Option<Network>,
    ) -> Result<Self, RecordingError> {
        let (mut window, format) = begin(Box::new(source))?;
        let found = match (network, format) {
            (Some(network), _) => Some(network),
            (None, Format::Pcap) => Pcap::network(&mut window)?,
            (None, Format::PcapNg) => PcapNg::network(&mut window)?,
            (None, Format::CandumpLog | Format::CandumpScreen | Format::Asc) => None,
        };
        match found.unwrap_or(Network::Can) {
            Network::Can => Recording::new(window, format).map(Self::Can),
            Network::Ethernet => Capture::new(window, format).map(Self::Ethernet),
        }
    }
}

/// A file, or standard input.
fn source(path: &Path) -> Result<Source, RecordingError> {
    match is_standard(path) {
        true => Ok(Box::new(io::stdin().lock())),
        // Not every operating system says so itself.
        false if path.is_dir() => Err(RecordingError::Directory),
        false => Ok(Box::new(File::open(path)?)),
    }
}

/// Finds the format, and passes over a byte order mark.
fn begin(source: Source) -> Result<(Window<Source>, Format), RecordingError> {
    let mut window = Window::new(source);
    // A pipe may give the beginning in pieces, and must not be waited for longer than necessary.
    let format = loop {
        if window.can_fill() {
            window.fill()?;
        }
        let nothing_yet = detect::without_bom(window.ahead()).trim_ascii().is_empty();
        match Format::detect(window.ahead()) {
            Ok(_) if nothing_yet && window.can_fill() => {}
            Err(_) if window.can_fill() => {}
            result => break result?,
        }
    };
    let bom = window.ahead().len() - detect::without_bom(window.ahead()).len();
    window.skip(bom);
    Ok((window, format))
}

impl Recording {
    /// Opens a file; `-` is standard input.
    ///
    /// # Errors
    /// [`RecordingError`] when it cannot be opened, or is not a recording.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        Self::from_reader(source(path)?)
    }

    /// Reads from any source, which need not be buffered.
    ///
    /// # Errors
    /// [`RecordingError`] when the beginning cannot be read, or is not that of a recording.
    pub fn from_reader(source: impl Read + 'static) -> Result<Self, RecordingError> {
        let (window, format) = begin(Box::new(source))?;
        Self::new(window, format)
    }

    fn new(window: Window<Source>, format: Format) -> Result<Self, RecordingError> {
        let reader = match format {
            Format::CandumpLog => Reader::Candump(Lines::new(window)),
            Format::CandumpScreen => Reader::Screen(Lines::new(window), Screen::default()),
            Format::Asc => Reader::Asc(Lines::new(window), Asc::default()),
            Format::Pcap => Reader::Pcap(Pcap::new(window, Network::Can)?),
            Format::PcapNg => Reader::PcapNg(PcapNg::new(window, Network::Can)),
        };
        let (channels, notes) = (Channels::default(), Notes::default());
        Ok(Self { reader, channels, notes, format, numbers: Numbers::default() })
    }

    /// Its format.
    #[must_use]
    pub fn format(&self) -> Format {
        self.format
    }

    /// The channels that have appeared so far.
    #[must_use]
    pub fn channels(&self) -> &Channels {
        &self.channels
    }

    /// What it tells besides its frames, as far as it was read.
    #[must_use]
    pub fn notes(&self) -> Notes {
        self.notes
    }

    #[inline]
    fn read(&mut self) -> Result<Option<Parsed>, RecordingError> {
        let Self { channels, notes, numbers, .. } = self;
        match &mut self.reader {
            Reader::Candump(lines) => next_in_lines(lines, |line| match candump::parse(line, channels) {
                Err(_) if line.trim_ascii().is_empty() || notes.take_drop_count(line) => Ok(None),
                parsed => parsed.map(Some),
            }),
            Reader::Screen(lines, screen) => {
                screen.learn(lines.window())?;
                next_in_lines(lines, |line| match screen.parse(line, channels) {
                    Err(_) if line.trim_ascii().is_empty() || notes.take_drop_count(line) => Ok(None),
                    parsed => parsed,
                })
            }
            Reader::Asc(lines, asc) => next_in_lines(lines, |line| asc.parse(line, channels)),
            Reader::Pcap(pcap) => pcap.next(numbers.frames, |packet, _| socketcan::parse(packet)),
            Reader::PcapNg(pcapng) => {
                pcapng.next(numbers.frames, channels, notes, |packet, _| socketcan::parse(packet))
            }
        }
    }
}

/// The next line that holds a frame.
#[inline]
fn next_in_lines(
    lines: &mut Lines<Source>,
    mut parse: impl FnMut(&[u8]) -> Result<Option<Parsed>, Fault>,
) -> Result<Option<Parsed>, RecordingError> {
    loop {
        let number = lines.number() + 1;
        let (line, parsed) = match lines.next()? {
            None => return Ok(None),
            Some(Line::Text(line)) => (line, parse(line)),
            Some(Line::TooLong(line)) => (line, Err(Fault { at: 0, expected: "a line of at most 256 KiB" })),
        };
        match parsed {
            Ok(Some(parsed)) => return Ok(Some(parsed)),
            Ok(None) => {}
            Err(fault) => return Err(fault.in_line(number, line)),
        }
    }
}

impl Iterator for Recording {
    type Item = Result<RecordedFrame, RecordingError>;

    /// The next frame, or what is wrong with the next line. After an error that
    /// [is fatal](RecordingError::is_fatal) comes nothing more.
    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        if self.numbers.ended {
            return None;
        }
        let read = self.read();
        self.numbers.number(read)
    }
}
