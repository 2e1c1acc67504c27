//! A pcap file of Ethernet frames.

use core::time::Duration;
use std::fs::File;
use std::io::{BufWriter, ErrorKind, Write as _};
use std::path::{Path, PathBuf};

use link_core::Instant;
use pcap_file::pcap::{PcapHeader, PcapPacket, PcapWriter};
use pcap_file::{DataLink, TsResolution};

use crate::exit::Failure;
use crate::standard::is_standard;

pub(super) struct Recorder {
    writer: PcapWriter<BufWriter<File>>,
    path: PathBuf,
    /// The zero of the session's clock, since 1970.
    zero: Duration,
}

impl Recorder {
    /// A new file; one that exists is not touched.
    pub(super) fn create(path: &Path, zero: Duration) -> Result<Self, Failure> {
        if is_standard(path) {
            return Err(Failure::Usage(
                "--record -: standard output has the lines of the station; record into a file".to_owned(),
            ));
        }
        let wrong = |error: &dyn core::fmt::Display| {
            Failure::Usage(format!("{}: cannot be recorded to: {error}", path.display()))
        };
        let file = File::create_new(path).map_err(|error| match error.kind() {
            ErrorKind::AlreadyExists => {
                wrong(&"it exists, and is not written over; name another file, or remove it")
            }
            _ => wrong(&error),
        })?;
        let header = PcapHeader {
            datalink: DataLink::ETHERNET,
            ts_resolution: TsResolution::NanoSecond,
            ..PcapHeader::default()
        };
        let writer = PcapWriter::with_header(BufWriter::new(file), header).map_err(|error| wrong(&error))?;
        Ok(Self { writer, path: path.into(), zero })
    }

    pub(super) fn write(&mut self, at: Instant, frame: &[u8]) -> Result<(), Failure> {
        let since_zero = at.saturating_since(Instant::ZERO);
        let len = u32::try_from(frame.len()).unwrap_or(u32::MAX);
        let packet = PcapPacket::new(self.zero + since_zero, len, frame);
        match self.writer.write_packet(&packet) {
            Ok(_) => Ok(()),
            Err(error) => Err(self.failed(&error)),
        }
    }

    pub(super) fn finish(self) -> Result<(), Failure> {
        let path = self.path;
        self.writer
            .into_writer()
            .flush()
            .map_err(|error| Failure::Usage(format!("{}: cannot be written: {error}", path.display())))
    }

    fn failed(&self, error: &dyn core::fmt::Display) -> Failure {
        Failure::Usage(format!("{}: cannot be written: {error}", self.path.display()))
    }
}
