//! A capture of an Ethernet interface.

use super::detect::Format;
use super::error::RecordingError;
use super::frame::{Channels, RecordedFrame};
use super::network::Network;
use super::notes::Notes;
use super::pcap::Pcap;
use super::pcapng::PcapNg;
use super::window::Window;
use super::{Numbers, Source};

/// A capture of an Ethernet interface being read, as a stream: memory does not grow with the file.
pub struct Capture {
    reader: Reader,
    channels: Channels,
    notes: Notes,
    format: Format,
    numbers: Numbers,
}

enum Reader {
    Pcap(Pcap),
    PcapNg(PcapNg),
}

/// An Ethernet frame, from the destination address on.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct EthernetFrame {
    /// What was captured of it.
    pub bytes: Box<[u8]>,
    /// Its length on the wire, as the capture says.
    pub length: usize,
}

impl Capture {
    pub(super) fn new(window: Window<Source>, format: Format) -> Result<Self, RecordingError> {
        let reader = match format {
            Format::Pcap => Reader::Pcap(Pcap::new(window, Network::Ethernet)?),
            Format::PcapNg => Reader::PcapNg(PcapNg::new(window, Network::Ethernet)),
            Format::CandumpLog | Format::CandumpScreen | Format::Asc => {
                return Err(RecordingError::NotEthernet(format));
            }
        };
        let (channels, notes) = (Channels::default(), Notes::default());
        Ok(Self { reader, channels, notes, format, numbers: Numbers::default() })
    }

    /// Its format.
    #[must_use]
    pub fn format(&self) -> Format {
        self.format
    }

    /// The interfaces that have appeared so far.
    #[must_use]
    pub fn channels(&self) -> &Channels {
        &self.channels
    }

    /// What it tells besides its frames, as far as it was read.
    #[must_use]
    pub fn notes(&self) -> Notes {
        self.notes
    }
}

impl Iterator for Capture {
    type Item = Result<RecordedFrame<EthernetFrame>, RecordingError>;

    /// The next frame, or what is wrong with the next record. After an error that [is fatal](RecordingError::is_fatal) comes
    /// nothing more.
    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        if self.numbers.ended {
            return None;
        }
        let Self { reader, channels, notes, numbers, .. } = self;
        let keep = |packet: &[u8], original: usize| {
            Ok(EthernetFrame { bytes: packet.into(), length: original.max(packet.len()) })
        };
        let read = match reader {
            Reader::Pcap(pcap) => pcap.next(numbers.frames, keep),
            Reader::PcapNg(pcapng) => pcapng.next(numbers.frames, channels, notes, keep),
        };
        numbers.number(read)
    }
}
