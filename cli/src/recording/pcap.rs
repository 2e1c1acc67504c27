//! pcap: one link type, no names of interfaces.
//!
//! | byte | size | field of a record |
//! |---|---|---|
//! | 0 | 4 | time, seconds |
//! | 4 | 4 | time, microseconds or nanoseconds, as the magic number of the file says |
//! | 8 | 4 | length of the packet in the file |
//! | 12 | 4 | length of the packet when it was captured |
//! | 16 | .. | the packet |
//!
//! Source: IETF draft-ietf-opsawg-pcap.

use std::io;

use link_core::Instant;
use pcap_file::pcap::PcapHeader;
use pcap_file::{Endianness, TsResolution};

use super::error::{Fault, RecordingError};
use super::fields::Fields;
use super::network::Network;
use super::window::{WINDOW, Window};
use super::{Parsed, Source};

/// Reads record after record.
pub(super) struct Pcap {
    window: Window<Source>,
    order: Endianness,
    resolution: TsResolution,
    records: u64,
}

impl Pcap {
    pub(super) fn new(mut window: Window<Source>, network: Network) -> Result<Self, RecordingError> {
        let seen = window.up_to(FILE_HEADER)?;
        let Ok((_, header)) = PcapHeader::from_slice(seen) else {
            return Err(RecordingError::Truncated { after: 0 });
        };
        window.skip(FILE_HEADER);
        match link_type(&header) {
            number if number == network.link_type() => {}
            number => return Err(RecordingError::link_type(number, network)),
        }
        Ok(Self { window, order: header.endianness, resolution: header.ts_resolution, records: 0 })
    }

    /// Of which network a file is, if it is of one that is read.
    pub(super) fn network(window: &mut Window<Source>) -> io::Result<Option<Network>> {
        let header = PcapHeader::from_slice(window.up_to(FILE_HEADER)?);
        Ok(header.ok().and_then(|(_, header)| Network::of_link_type(link_type(&header))))
    }

    /// The next frame, `None` at the end; `frames` were read before it. `parse` gets the packet, and the length that it had
    /// when it was captured.
    pub(super) fn next<C>(
        &mut self,
        frames: u64,
        parse: impl FnOnce(&[u8], usize) -> Result<C, Fault>,
    ) -> Result<Option<Parsed<C>>, RecordingError> {
        let truncated = || RecordingError::Truncated { after: frames };
        let header = Fields::new(self.window.up_to(RECORD_HEADER)?, self.order);
        if header.bytes.is_empty() {
            return Ok(None);
        }
        let field = |at| header.u32_at(at).ok_or_else(truncated);
        let (seconds, fraction, length) = (field(0)?, field(4)?, field(8)? as usize);
        let original = field(12)? as usize;
        if length > MAX_PACKET {
            return Err(RecordingError::damaged(frames, format!("a record says that it has {length} bytes")));
        }
        let size = RECORD_HEADER + length;
        let packet = match self.window.up_to(size)? {
            seen if seen.len() < size => return Err(truncated()),
            seen => &seen[RECORD_HEADER..],
        };
        self.records += 1;
        let (scale, digits) = match self.resolution {
            TsResolution::MicroSecond => (1000, 6),
            TsResolution::NanoSecond => (1, 9),
        };
        let nanos = u64::from(seconds) * 1_000_000_000 + u64::from(fraction) * scale;
        let content = parse(packet, original).map_err(|fault| fault.in_record(self.records, packet));
        self.window.skip(size);
        Ok(Some(Parsed { at: Instant::from_nanos(nanos), digits, channel: None, content: content? }))
    }
}

/// The upper bits of the field say how long the frame check sequence is.
fn link_type(header: &PcapHeader) -> u32 {
    u32::from(header.datalink) & 0xFFFF
}

const FILE_HEADER: usize = 24;
const RECORD_HEADER: usize = 16;
/// The longest CAN frame has 72 bytes, one of CAN XL 2 KiB, and Ethernet frames that an adapter puts together 64 KiB and a header: what
/// the window has no room for is no length.
const MAX_PACKET: usize = WINDOW - RECORD_HEADER;
