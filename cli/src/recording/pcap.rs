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

use link_core::Instant;
use pcap_file::pcap::PcapHeader;
use pcap_file::{Endianness, TsResolution};

use super::error::RecordingError;
use super::fields::Fields;
use super::window::Window;
use super::{Parsed, Source, socketcan};

/// Reads record after record.
pub(super) struct Pcap {
    window: Window<Source>,
    order: Endianness,
    resolution: TsResolution,
    records: u64,
}

impl Pcap {
    pub(super) fn new(mut window: Window<Source>) -> Result<Self, RecordingError> {
        let seen = window.up_to(FILE_HEADER)?;
        let Ok((_, header)) = PcapHeader::from_slice(seen) else {
            return Err(RecordingError::Truncated { after: 0 });
        };
        window.skip(FILE_HEADER);
        // The upper bits of the field say how long the frame check sequence is.
        match u32::from(header.datalink) & 0xFFFF {
            socketcan::LINK_TYPE => {}
            number => return Err(RecordingError::link_type(number)),
        }
        Ok(Self { window, order: header.endianness, resolution: header.ts_resolution, records: 0 })
    }

    /// The next frame, `None` at the end; `frames` were read before it.
    pub(super) fn next(&mut self, frames: u64) -> Result<Option<Parsed>, RecordingError> {
        let truncated = || RecordingError::Truncated { after: frames };
        let header = Fields::new(self.window.up_to(RECORD_HEADER)?, self.order);
        if header.bytes.is_empty() {
            return Ok(None);
        }
        let field = |at| header.u32_at(at).ok_or_else(truncated);
        let (seconds, fraction, length) = (field(0)?, field(4)?, field(8)?);
        field(12)?;
        if length > MAX_PACKET {
            return Err(RecordingError::damaged(frames, format!("a record says that it has {length} bytes")));
        }
        let size = RECORD_HEADER + length as usize;
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
        let content = socketcan::parse(packet).map_err(|fault| fault.in_record(self.records, packet));
        self.window.skip(size);
        Ok(Some(Parsed { at: Instant::from_nanos(nanos), digits, channel: None, content: content? }))
    }
}

const FILE_HEADER: usize = 24;
const RECORD_HEADER: usize = 16;
/// The longest CAN frame has 72 bytes, one of CAN XL 2 KiB: more is no length.
const MAX_PACKET: u32 = 64 * 1024;
