//! What can be wrong with a recording.

use core::fmt;
use std::io;

use super::detect::Format;
use super::network::Network;

/// Why an entry, or the rest of a recording, cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// One line or record is wrong; the next can be read.
    #[error("{0}")]
    Bad(Box<Bad>),
    /// The operating system refuses.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// The path is that of a folder.
    #[error("is a directory, not a recording")]
    Directory,
    /// No line or header in the beginning belongs to a known format.
    #[error("not a recording: candump log or screen output, pcap, pcapng or Vector ASC expected, {0} found")]
    UnknownFormat(&'static str),
    /// Text, or another format that holds CAN frames only.
    #[error("a {0}: Ethernet frames are in pcap and pcapng")]
    NotEthernet(Format),
    /// A capture of another network.
    #[error("link type {number} ({name}) {}", wanted_instead(*number, *wanted))]
    LinkType {
        /// What was to be read.
        wanted: Network,
        /// The number in the tcpdump.org list.
        number: u32,
        /// Its name there, or `unknown`.
        name: &'static str,
    },
    /// The file ends within a record.
    #[error("the file is cut off, or a length in it is wrong: it ends within the record after frame {after}")]
    Truncated {
        /// How many frames were read before.
        after: u64,
    },
    /// The structure of the file is broken, so that the next record cannot be found.
    #[error("the file is damaged after frame {after}: {what}")]
    Damaged {
        /// How many frames were read before.
        after: u64,
        /// What is wrong.
        what: String,
    },
}

impl RecordingError {
    /// Whether nothing more can be read after this.
    #[must_use]
    pub fn is_fatal(&self) -> bool {
        !matches!(self, Self::Bad(_))
    }

    #[cold]
    pub(super) fn damaged(after: u64, what: String) -> Self {
        Self::Damaged { after, what }
    }

    #[cold]
    pub(super) fn link_type(number: u32, wanted: Network) -> Self {
        Self::LinkType { wanted, number, name: link_type_name(number) }
    }
}

/// What was to be read, and how to get it.
fn wanted_instead(number: u32, wanted: Network) -> String {
    let named =
        |network: Network| format!("{} ({})", network.link_type(), link_type_name(network.link_type()));
    match Network::of_link_type(number) {
        Some(_) => format!("instead of {}: {}", named(wanted), wanted.advice()),
        // Such as `-i any` makes them.
        None => format!(
            "instead of {} or {}: capture on the interface itself, for instance `tshark -i can0 -w FILE` or `tshark -i eth0 -w FILE`",
            named(Network::Can),
            named(Network::Ethernet)
        ),
    }
}

/// The names of the link types that users meet.
fn link_type_name(number: u32) -> &'static str {
    match number {
        1 => "Ethernet",
        101 => "raw IP",
        113 => "Linux cooked capture",
        189 | 220 => "USB",
        190 => "CAN 2.0b, obsolete",
        227 => "CAN_SOCKETCAN",
        276 => "Linux cooked capture v2",
        _ => "unknown",
    }
}

/// A line or record that cannot be read.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Bad {
    /// Where it is.
    pub place: Place,
    /// What should have been there.
    pub expected: &'static str,
    /// What is there; empty at the end of the line.
    pub found: String,
}

/// A place in a recording, counted from 1.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Place {
    /// In a text file.
    Line {
        /// The line.
        line: u64,
        /// The byte in the line.
        column: usize,
    },
    /// In a binary file.
    Record {
        /// The packet, as Wireshark numbers them.
        record: u64,
        /// The byte in the packet; when the block around it is wrong, in the body of the block.
        byte: usize,
    },
}

/// `12:8`, as compilers and editors write it, or `record 12, byte 8`.
impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line { line, column } => write!(f, "{line}:{column}"),
            Self::Record { record, byte } => write!(f, "record {record}, byte {byte}"),
        }
    }
}

/// `12:8: an even number of hexadecimal digits expected, "G1" found`; a file name and a colon fit in front.
impl fmt::Display for Bad {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {} expected, ", self.place, self.expected)?;
        match self.found.is_empty() {
            true => f.write_str("nothing found"),
            false => write!(f, "{:?} found", self.found),
        }
    }
}

/// Where in a line, and what was expected: a [`Bad`] before it knows its line.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Fault {
    /// Byte in the line, from 0.
    pub(super) at: usize,
    pub(super) expected: &'static str,
}

impl Fault {
    #[cold]
    pub(super) fn in_line(self, line: u64, text: &[u8]) -> RecordingError {
        let rest = text.get(self.at..).unwrap_or_default();
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len()).clamp(0, FOUND_MAX);
        // A blank where something was expected: show the blank and what follows it.
        let end = if end == 0 { rest.len().min(FOUND_MAX) } else { end };
        RecordingError::Bad(Box::new(Bad {
            place: Place::Line { line, column: self.at + 1 },
            expected: self.expected,
            found: String::from_utf8_lossy(&rest[..end]).into_owned(),
        }))
    }

    #[cold]
    pub(super) fn in_record(self, record: u64, packet: &[u8]) -> RecordingError {
        let rest = packet.get(self.at..).unwrap_or_default();
        let found = match rest {
            [] => String::new(),
            _ => rest.iter().take(4).map(|byte| format!("{byte:02X}")).collect::<Vec<_>>().join(" "),
        };
        RecordingError::Bad(Box::new(Bad {
            place: Place::Record { record, byte: self.at + 1 },
            expected: self.expected,
            found,
        }))
    }
}

/// The most bytes of a bad line that a message shows.
const FOUND_MAX: usize = 24;
