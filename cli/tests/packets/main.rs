//! pcap and pcapng files with everything that the formats allow, and with what they do not. The layouts are those of the
//! IETF drafts (draft-ietf-opsawg-pcapng, draft-ietf-opsawg-pcap) and of tcpdump.org, `LINKTYPE_CAN_SOCKETCAN`.
#![allow(
    clippy::arithmetic_side_effects,
    clippy::as_conversions,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test may panic"
)]

mod contents;
mod interfaces;
mod networks;
mod structure;

use devicenet_cli::recording::{Bad, Content, Notes, Place, Recording, RecordingError};
use link_core::Frame;
use link_core::frame::standard_id;

/// Identifier 0x455 with the data 0x4B.
const PACKET: &[u8] = &[0, 0, 4, 0x55, 1, 0, 0, 0, 0x4B];
const CAN: u16 = 227;
const ETHERNET: u16 = 1;

/// A block, little-endian: type, length, body on a 32-bit boundary, length.
fn block(kind: u32, body: &[u8]) -> Vec<u8> {
    let padding = body.len().next_multiple_of(4) - body.len();
    let length = (12 + body.len() + padding) as u32;
    [&kind.to_le_bytes()[..], &length.to_le_bytes(), body, &[0; 3][..padding], &length.to_le_bytes()].concat()
}

/// Section header: magic number, version 1.0, length of the section unknown.
fn section() -> Vec<u8> {
    block(0x0A0D_0D0A, &[0x4D, 0x3C, 0x2B, 0x1A, 1, 0, 0, 0, 255, 255, 255, 255, 255, 255, 255, 255])
}

fn option(code: u16, value: &[u8]) -> Vec<u8> {
    let padding = value.len().next_multiple_of(4) - value.len();
    [&code.to_le_bytes()[..], &(value.len() as u16).to_le_bytes(), value, &[0; 3][..padding]].concat()
}

/// Interface description: link type, reserved, snapshot length, options.
fn interface(link_type: u16, options: &[Vec<u8>]) -> Vec<u8> {
    block(1, &[&link_type.to_le_bytes()[..], &[0; 6], &options.concat()].concat())
}

/// Enhanced packet: interface, time, length in the file, length on the wire, packet.
fn packet(interface: u32, units: u64, data: &[u8]) -> Vec<u8> {
    let fields = [interface, (units >> 32) as u32, units as u32, data.len() as u32, data.len() as u32];
    block(6, &[&fields.map(u32::to_le_bytes).concat(), data].concat())
}

/// What a file holds: channel and time in nanoseconds of each frame, or the error.
struct Read {
    entries: Vec<Result<(String, u64), RecordingError>>,
    notes: Notes,
}

fn read(blocks: &[Vec<u8>]) -> Read {
    read_bytes([section(), blocks.concat()].concat())
}

fn read_bytes(bytes: Vec<u8>) -> Read {
    let mut recording = Recording::from_reader(std::io::Cursor::new(bytes)).unwrap();
    let mut entries = Vec::new();
    while let Some(entry) = recording.next() {
        entries.push(entry.map(|frame| {
            let expected = Frame::new(standard_id(0x455), &[0x4B]).unwrap();
            assert_eq!(frame.content, Content::Classic(expected));
            let name = frame.channel.map_or("", |channel| recording.channels().name(channel));
            (name.to_owned(), frame.at.as_nanos())
        }));
    }
    Read { entries, notes: recording.notes() }
}

impl Read {
    #[track_caller]
    fn frames(&self) -> Vec<(&str, u64)> {
        let frames =
            self.entries.iter().map(|entry| entry.as_ref().unwrap_or_else(|error| panic!("{error}")));
        frames.map(|(name, at)| (&**name, *at)).collect()
    }

    /// The bad record at a place in the file, and that it is not the end of it.
    #[track_caller]
    fn bad(&self, index: usize) -> (Place, &'static str) {
        assert!(self.entries[index + 1].is_ok(), "the rest is read");
        match &self.entries[index] {
            Err(RecordingError::Bad(bad)) => {
                let Bad { place, expected, .. } = **bad;
                (place, expected)
            }
            other => panic!("{other:?}"),
        }
    }

    /// The error that ends the file.
    #[track_caller]
    fn fatal(&self) -> String {
        let error = self.entries.last().unwrap().as_ref().unwrap_err();
        assert!(error.is_fatal());
        error.to_string()
    }
}
