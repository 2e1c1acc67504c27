//! Which format a recording has, from its first bytes.

use core::fmt;

use super::asc::Asc;
use super::candump;
use super::error::RecordingError;
use super::frame::Channels;
use super::screen::Screen;

/// The formats that are read.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Format {
    /// The log of `candump -l` or `-L`.
    CandumpLog,
    /// What candump shows on the screen.
    CandumpScreen,
    /// Vector ASC.
    Asc,
    /// pcap, of either byte order, in microseconds or nanoseconds.
    Pcap,
    /// pcapng.
    PcapNg,
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::CandumpLog => "candump log",
            Self::CandumpScreen => "candump screen output",
            Self::Asc => "Vector ASC",
            Self::Pcap => "pcap",
            Self::PcapNg => "pcapng",
        })
    }
}

impl Format {
    /// What one entry of it is called.
    pub(crate) const fn entry(self) -> &'static str {
        match self {
            Self::CandumpLog | Self::CandumpScreen | Self::Asc => "line",
            Self::Pcap | Self::PcapNg => "record",
        }
    }

    /// Recognises a format by a binary signature, or by the first line that one of the text formats can read.
    pub(super) fn detect(beginning: &[u8]) -> Result<Self, RecordingError> {
        let beginning = without_bom(beginning);
        match beginning {
            [0xA1, 0xB2, 0xC3, 0xD4, ..] | [0xD4, 0xC3, 0xB2, 0xA1, ..] => return Ok(Self::Pcap),
            [0xA1, 0xB2, 0x3C, 0x4D, ..] | [0x4D, 0x3C, 0xB2, 0xA1, ..] => return Ok(Self::Pcap),
            [0x0A, 0x0D, 0x0D, 0x0A, ..] => return Ok(Self::PcapNg),
            [0x1F, 0x8B, ..] => {
                return Err(RecordingError::UnknownFormat("gzip data (unpack it first)"));
            }
            [0x28, 0xB5, 0x2F, 0xFD, ..] => {
                return Err(RecordingError::UnknownFormat("zstd data (unpack it first)"));
            }
            [0xFD, b'7', b'z', b'X', b'Z', 0x00, ..] => {
                return Err(RecordingError::UnknownFormat("xz data (unpack it first)"));
            }
            [b'B', b'Z', b'h', b'1'..=b'9', 0x31, 0x41, 0x59, 0x26, 0x53, 0x59, ..] => {
                return Err(RecordingError::UnknownFormat("bzip2 data (unpack it first)"));
            }
            [b'P', b'K', 0x03, 0x04, ..] => {
                return Err(RecordingError::UnknownFormat("a ZIP archive (unpack it first)"));
            }
            [0xFF, 0xFE, ..] | [0xFE, 0xFF, ..] => {
                return Err(RecordingError::UnknownFormat("UTF-16 text (save it as UTF-8)"));
            }
            [b'L', b'O', b'G', b'G', ..] => {
                return Err(RecordingError::UnknownFormat(
                    "Vector BLF (convert it, for instance with python-can: `can_logconvert FILE.blf FILE.log`)",
                ));
            }
            _ if beginning.starts_with(b";$FILEVERSION=") => {
                return Err(RecordingError::UnknownFormat(
                    "PEAK trace (convert it, for instance with python-can: `can_logconvert FILE.trc FILE.log`)",
                ));
            }
            _ if beginning.iter().take(512).any(|byte| *byte == 0) => {
                return Err(RecordingError::UnknownFormat("binary data"));
            }
            _ => {}
        }
        let mut channels = Channels::default();
        for line in beginning.split(|byte| *byte == b'\n') {
            // Before anything else: a scenario may hold a log that it replays.
            if is_of_scenario(line) {
                return Err(RecordingError::UnknownFormat("a scenario (run it with `devicenet simulate`)"));
            }
            if is_of_eds(line) {
                return Err(RecordingError::UnknownFormat(
                    "an Electronic Data Sheet (check it with `devicenet eds check`)",
                ));
            }
            if candump::parse(line.trim_ascii_end(), &mut channels).is_ok() {
                return Ok(Self::CandumpLog);
            }
            if Asc::is_header(line) {
                return Ok(Self::Asc);
            }
            if let Ok(Some(_)) = Screen::default().parse(line, &mut channels) {
                return Ok(Self::CandumpScreen);
            }
            if let Ok(Some(_)) = Asc::default().parse(line.trim_ascii_end(), &mut channels) {
                return Ok(Self::Asc);
            }
        }
        match beginning.trim_ascii() {
            // A log into which nothing was written.
            [] => Ok(Self::CandumpLog),
            _ => Err(RecordingError::UnknownFormat("text of another kind")),
        }
    }
}

/// Text without the byte order mark that some editors put before UTF-8.
pub(super) fn without_bom(beginning: &[u8]) -> &[u8] {
    beginning.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(beginning)
}

/// Whether a line opens a table that every scenario has.
fn is_of_scenario(line: &[u8]) -> bool {
    matches!(line.trim_ascii(), b"[bus]" | b"[[node]]")
}

/// Whether a line opens one of the sections that every Electronic Data Sheet has.
fn is_of_eds(line: &[u8]) -> bool {
    [&b"[File]"[..], b"[Device]"].iter().any(|section| line.trim_ascii().eq_ignore_ascii_case(section))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_first_line_that_can_be_read() {
        assert_eq!(Format::detect(b"noise\n(1.0) can0 123#\r\n").unwrap(), Format::CandumpLog);
        assert_eq!(Format::detect(b"interrupted\n  can0  123   [0]\n").unwrap(), Format::CandumpScreen);
        assert_eq!(Format::detect(b"date Mon Sep 30 15:06:13.191 2019\n").unwrap(), Format::Asc);
        assert_eq!(Format::detect(b"   0.5 1  123  Rx   d 0\n").unwrap(), Format::Asc);
        assert_eq!(Format::detect(b"").unwrap(), Format::CandumpLog);
        assert_eq!(Format::detect(b"\xEF\xBB\xBF").unwrap(), Format::CandumpLog);
    }

    #[test]
    fn says_what_else_it_seems_to_be() {
        let found = |bytes| Format::detect(bytes).unwrap_err().to_string();
        assert!(found(b"\x1F\x8B\x08").ends_with("gzip data (unpack it first) found"));
        assert!(found(b"\xFD7zXZ\0\0").ends_with("xz data (unpack it first) found"));
        assert!(found(b"BZh91AY&SY\x8B").ends_with("bzip2 data (unpack it first) found"));
        assert!(found(b"PK\x03\x04\x14\0").ends_with("a ZIP archive (unpack it first) found"));
        assert!(found(b"$ a valve\r\n[File]\r\n").contains("an Electronic Data Sheet (check it with"));
        assert!(found(b"\x7FELF\x00").ends_with("binary data found"));
        assert!(found(b"\xFF\xFE(\x001\x00").ends_with("UTF-16 text (save it as UTF-8) found"));
        assert!(found(b"\xFE\xFF\x00(\x001").ends_with("UTF-16 text (save it as UTF-8) found"));
        assert!(found(b"LOGG\x90\x00\x00\x00").contains("Vector BLF (convert it"));
        assert!(found(b";$FILEVERSION=2.1\n;$STARTTIME=43008\n").contains("PEAK trace (convert it"));
        assert!(
            found(b"# A cell.\ntitle = \"Cell\"\n[bus]\r\n")
                .ends_with("a scenario (run it with `devicenet simulate`) found")
        );
        assert!(found(b"[[node]]\n").contains("devicenet simulate"));
        assert!(found(b"[package]\nname = 1\n").ends_with("text of another kind found"));
    }
}
