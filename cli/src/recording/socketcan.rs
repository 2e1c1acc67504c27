//! A packet of link type 227, `LINKTYPE_CAN_SOCKETCAN`.
//!
//! | byte | size | field |
//! |---|---|---|
//! | 0 | 4 | identifier, big-endian; bit 31: 29 bits, bit 30: remote, bit 29: error |
//! | 4 | 1 | length |
//! | 5 | 1 | CAN FD flags: 1 bit rate switch, 2 error-passive, 4 CAN FD |
//! | 6 | 1 | reserved |
//! | 7 | 1 | raw data length code of a classic frame of 8 bytes, if 9 to 15 |
//! | 8 | .. | data |
//!
//! Source: tcpdump.org, LINKTYPE_CAN_SOCKETCAN.

use link_core::{Frame, Id};

use super::error::Fault;
use super::frame::{Content, ErrorFrame, FdFrame};
use super::scan::{CanId, ERROR_FLAG, EXTENDED_FLAG, REMOTE_FLAG};

/// The number of the link type.
pub(super) const LINK_TYPE: u32 = 227;

/// Reads one packet.
pub(super) fn parse(packet: &[u8]) -> Result<Content, Fault> {
    let fault = |at, expected| Err(Fault { at, expected });
    let Some((header, data)) = packet.split_first_chunk::<8>() else {
        return fault(packet.len(), "a header of 8 bytes");
    };
    let [a, b, c, d, length, flags, _, raw_dlc] = *header;
    let Some(id) = CanId::from_bits(u32::from_be_bytes([a, b, c, d])) else {
        return fault(0, "an 11-bit identifier, or bit 31 set");
    };
    let length = usize::from(length);
    // Old kernels leave the flag out: the length tells as well, or the size of their `struct canfd_frame`.
    let is_fd = flags & FLAG_FD != 0 || length > Frame::MAX_DATA || packet.len() == FD_SIZE;
    let id = match id {
        CanId::Frame { id, remote: true } => {
            let dlc = if length == 8 && (9..=15).contains(&raw_dlc) { raw_dlc } else { length as u8 };
            let frame = if length <= Frame::MAX_DATA { Frame::remote(id, dlc) } else { None };
            return match frame {
                Some(frame) => Ok(Content::Classic(frame)),
                None => fault(4, "a length of at most 8"),
            };
        }
        CanId::Frame { id, remote: false } => id,
        CanId::Error { class } => {
            let mut details = [0; Frame::MAX_DATA];
            let Some(slots) = details.get_mut(..length) else { return fault(4, "a length of at most 8") };
            let Some(bytes) = data.get(..length) else { return fault(packet.len(), TOO_SHORT) };
            slots.copy_from_slice(bytes);
            return Ok(Content::Error(ErrorFrame { class, data: details }));
        }
    };
    let Some(bytes) = data.get(..length) else { return fault(packet.len(), TOO_SHORT) };
    let frame = if is_fd {
        FdFrame::new(id, bytes, flags & 1 != 0, flags & 2 != 0).map(|frame| Content::Fd(Box::new(frame)))
    } else {
        match bytes.first_chunk::<8>() {
            Some(eight) if (9..=15).contains(&raw_dlc) => Frame::with_dlc(id, raw_dlc, *eight),
            _ => Frame::new(id, bytes),
        }
        .map(Content::Classic)
    };
    frame.map_or_else(|| fault(4, "a length that CAN or CAN FD has"), Ok)
}

/// Writes one packet.
pub(super) fn emit(content: &Content, packet: &mut Vec<u8>) {
    packet.clear();
    let (bits, length, flags, raw_dlc, data) = match content {
        Content::Classic(frame) => {
            let remote = if frame.is_remote() { REMOTE_FLAG } else { 0 };
            let raw_dlc = if frame.dlc() > 8 { frame.dlc() } else { 0 };
            (id_bits(frame.id()) | remote, frame.dlc().min(8), 0, raw_dlc, frame.data())
        }
        Content::Error(error) => (error.class | ERROR_FLAG, 8, 0, 0, &error.data[..]),
        Content::Fd(frame) => {
            let flags = FLAG_FD | u8::from(frame.bit_rate_switch) | u8::from(frame.error_passive) << 1;
            (id_bits(frame.id()), frame.data().len() as u8, flags, 0, frame.data())
        }
    };
    packet.extend_from_slice(&bits.to_be_bytes());
    packet.extend_from_slice(&[length, flags, 0, raw_dlc]);
    packet.extend_from_slice(data);
}

fn id_bits(id: Id) -> u32 {
    match id {
        Id::Standard(id) => u32::from(id.as_raw()),
        Id::Extended(id) => id.as_raw() | EXTENDED_FLAG,
    }
}

const FLAG_FD: u8 = 4;
const TOO_SHORT: &str = "as many bytes as the length says";
/// Header and 64 bytes.
const FD_SIZE: usize = 72;
