//! Writing recordings.

use std::borrow::Cow;
use std::io::{self, Write};

use core::time::Duration;

use link_core::{Id, Instant};
use pcap_file::pcapng::PcapNgWriter;
use pcap_file::pcapng::blocks::enhanced_packet::EnhancedPacketBlock;
use pcap_file::pcapng::blocks::interface_description::{
    InterfaceDescriptionBlock, InterfaceDescriptionOption,
};
use pcap_file::{DataLink, PcapError};

use super::frame::Content;
use super::socketcan;
use crate::text::{UPPER, push_hex, push_seconds};

/// The formats that are written.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum WriteFormat {
    /// As `candump -l` writes it.
    CandumpLog,
    /// pcapng with link type `CAN_SOCKETCAN` and times in nanoseconds.
    PcapNg,
}

impl WriteFormat {
    /// From the end of a file name: `.pcapng` or `.ntar` means pcapng, all else a candump log.
    #[must_use]
    pub fn of_name(name: &str) -> Self {
        let extension = name.rsplit_once('.').map_or("", |(_, extension)| extension);
        match extension.eq_ignore_ascii_case("pcapng") || extension.eq_ignore_ascii_case("ntar") {
            true => Self::PcapNg,
            false => Self::CandumpLog,
        }
    }
}

/// A channel whose name the format cannot hold.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Renamed {
    /// Its name.
    pub name: String,
    /// Its name in the recording.
    pub written: String,
}

/// Writes frames into a recording.
pub struct Writer<W: Write>(Kind<W>);

enum Kind<W: Write> {
    Candump { out: W, line: Vec<u8>, renamed: Vec<Renamed> },
    PcapNg { out: Box<PcapNgWriter<W>>, interfaces: Vec<String>, packet: Vec<u8> },
}

impl<W: Write> Writer<W> {
    /// A writer to `out`, which should be buffered.
    ///
    /// # Errors
    /// When the header cannot be written.
    pub fn new(out: W, format: WriteFormat) -> io::Result<Self> {
        Ok(Self(match format {
            WriteFormat::CandumpLog => Kind::Candump { out, line: Vec::new(), renamed: Vec::new() },
            WriteFormat::PcapNg => Kind::PcapNg {
                out: Box::new(PcapNgWriter::new(out).map_err(io_error)?),
                interfaces: Vec::new(),
                packet: Vec::new(),
            },
        }))
    }

    /// Writes one entry. A candump log gets six decimals of a second, or nine when `digits` are more than six; blanks
    /// in the name of a channel would end it there, and are written as `_`.
    ///
    /// # Errors
    /// When `out` fails.
    pub fn write(&mut self, at: Instant, digits: u8, channel: &str, content: &Content) -> io::Result<()> {
        match &mut self.0 {
            Kind::Candump { out, line, renamed } => {
                line.clear();
                candump_line(line, at, digits, word(channel, renamed), content);
                out.write_all(line)
            }
            Kind::PcapNg { out, interfaces, packet } => {
                let known = interfaces.iter().position(|name| name == channel);
                let index = match known {
                    Some(index) => index,
                    None => {
                        let options = vec![
                            InterfaceDescriptionOption::IfName(Cow::Borrowed(channel)),
                            InterfaceDescriptionOption::IfTsResol(9),
                        ];
                        let linktype = DataLink::from(socketcan::LINK_TYPE);
                        let block = InterfaceDescriptionBlock { linktype, snaplen: 0, options };
                        out.write_pcapng_block(block).map_err(io_error)?;
                        interfaces.push(channel.to_owned());
                        interfaces.len() - 1
                    }
                };
                socketcan::emit(content, packet);
                out.write_pcapng_block(EnhancedPacketBlock {
                    interface_id: index as u32,
                    timestamp: Duration::from_nanos(at.as_nanos()),
                    original_len: packet.len() as u32,
                    data: Cow::Borrowed(packet),
                    options: Vec::new(),
                })
                .map_err(io_error)?;
                Ok(())
            }
        }
    }

    /// The channels whose names were written otherwise than given.
    #[must_use]
    pub fn renamed(&self) -> &[Renamed] {
        match &self.0 {
            Kind::Candump { renamed, .. } => renamed,
            Kind::PcapNg { .. } => &[],
        }
    }

    /// Writes out what is buffered.
    ///
    /// # Errors
    /// When `out` fails.
    pub fn finish(self) -> io::Result<()> {
        match self.0 {
            Kind::Candump { mut out, .. } => out.flush(),
            Kind::PcapNg { out, .. } => out.into_inner().flush(),
        }
    }
}

/// A name as one word.
fn word<'a>(name: &'a str, renamed: &'a mut Vec<Renamed>) -> &'a str {
    let is_blank = |byte: u8| byte.is_ascii_whitespace() || byte.is_ascii_control();
    if !name.is_empty() && !name.bytes().any(is_blank) {
        return name;
    }
    let index = renamed.iter().position(|renamed| renamed.name == name).unwrap_or_else(|| {
        let written = match name {
            "" => "_".to_owned(),
            name => {
                name.chars().map(|it| if u8::try_from(it).is_ok_and(is_blank) { '_' } else { it }).collect()
            }
        };
        renamed.push(Renamed { name: name.to_owned(), written });
        renamed.len() - 1
    });
    &renamed[index].written
}

fn candump_line(line: &mut Vec<u8>, at: Instant, digits: u8, channel: &str, content: &Content) {
    line.push(b'(');
    push_seconds(line, at, if digits > 6 { 9 } else { 6 });
    line.extend_from_slice(b") ");
    line.extend_from_slice(channel.as_bytes());
    line.push(b' ');
    match content {
        Content::Classic(frame) => {
            push_id(line, frame.id());
            line.push(b'#');
            if frame.is_remote() {
                line.push(b'R');
                match frame.dlc() {
                    0 => {}
                    dlc @ 1..=8 => line.push(b'0' + dlc),
                    _ => line.push(b'8'),
                }
            } else {
                push_hex(line, frame.data(), UPPER);
            }
            if frame.dlc() > 8 {
                line.push(b'_');
                line.push(UPPER[usize::from(frame.dlc() & 0xF)]);
            }
        }
        Content::Error(error) => {
            let bits = error.class | super::scan::ERROR_FLAG;
            push_hex(line, &bits.to_be_bytes(), UPPER);
            line.push(b'#');
            push_hex(line, &error.data, UPPER);
        }
        Content::Fd(frame) => {
            push_id(line, frame.id());
            line.extend_from_slice(b"##");
            line.push(b'0' + (u8::from(frame.bit_rate_switch) | u8::from(frame.error_passive) << 1));
            push_hex(line, frame.data(), UPPER);
        }
    }
    line.push(b'\n');
}

fn push_id(line: &mut Vec<u8>, id: Id) {
    match id {
        Id::Standard(id) => {
            let [high, low] = id.as_raw().to_be_bytes();
            line.push(UPPER[usize::from(high & 0xF)]);
            push_hex(line, &[low], UPPER);
        }
        Id::Extended(id) => push_hex(line, &id.as_raw().to_be_bytes(), UPPER),
    }
}

fn io_error(error: PcapError) -> io::Error {
    match error {
        PcapError::IoError(error) => error,
        other => io::Error::other(other),
    }
}
