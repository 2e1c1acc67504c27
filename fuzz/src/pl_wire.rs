//! The frames of POWERLINK: what is accepted survives, what is written is read back, the rest is refused without a panic.
//!
//! The same bytes are tried in every role: as a whole frame, behind the headers of every message type and service, and as each
//! wire type. Reserved bits and padding are written as zeros, so what is written is part of what was read.

use std::fmt::Debug;

use link_core::codec::{ParseErrorKind, Reader, Wire, Writer, laws};
use powerlink_core::ethernet::{MAX_FRAME, MIN_FRAME};
use powerlink_core::pdo::MappingEntry;
use powerlink_core::wire::{Body, Frame, FrameError, Header, InitiateSize, NodeList, Sdo};
use powerlink_core::{NodeId, wire};

/// Checks every law of the frames on `data`.
pub fn run(data: &[u8]) {
    let data = &data[..data.len().min(LONGEST)];
    frame(data);
    for (group, kind) in KINDS {
        frame(&[&head(group, kind), data].concat());
    }
    macro_rules! each {
        ($($Type:ident),*) => { $( wire_type::<wire::$Type>(data, &mut [0; LONGEST + 1]); )* };
    }
    powerlink_core::for_each_wire_type!(each);
    segment_sizes(data);
    numbers(data);
}

fn frame(bytes: &[u8]) {
    let frame = match Frame::parse(bytes) {
        Ok(frame) => frame,
        Err(error) => return refused(error, bytes),
    };
    let header = Header::read(&mut Reader::new(bytes)).expect("the frame has one");
    assert_eq!((header.to, header.from), (frame.to, frame.from));
    assert_eq!(header.message_type, frame.body.message_type());
    let text = frame.to_string();
    assert!(text.starts_with(&frame.from.to_string()) && !text.contains(char::is_control), "{text:?}");

    let mut buffer = [0xA5; MAX_FRAME + 1];
    let emitted = frame.emit(&mut buffer).expect("it was in a frame").to_vec();
    assert!((MIN_FRAME..=MAX_FRAME.max(bytes.len())).contains(&emitted.len()), "{} bytes", emitted.len());
    part_of(&emitted, bytes);
    let again = Frame::parse(&emitted).expect("it was read before");
    if !ends_in_free_data(&frame.body) {
        assert_eq!(again, frame);
    }
    let mut buffer = [0x5A; MAX_FRAME + 1];
    assert_eq!(again.emit(&mut buffer).expect("it was emitted before"), emitted);
}

/// What padding belongs to, because nothing tells it from data.
fn ends_in_free_data(body: &Body<'_>) -> bool {
    matches!(body, Body::NmtCommand(_) | Body::NmtRequest(_) | Body::OtherAsnd(..) | Body::Other(..))
}

/// An error says where, and what it found there.
fn refused(error: FrameError, bytes: &[u8]) {
    assert!(!error.to_string().is_empty());
    match error {
        FrameError::OtherProtocol(ethertype) => assert_eq!(bytes[12..14], ethertype.to_be_bytes()),
        FrameError::Malformed(error) => {
            assert!(error.offset <= bytes.len(), "{error} of {} bytes", bytes.len());
            if let ParseErrorKind::Short { expected, found } = error.kind {
                assert!(found < expected, "{error}");
            }
        }
    }
}

/// Every bit that is written was read; what is written behind the end is padding.
fn part_of(emitted: &[u8], given: &[u8]) {
    for (at, &byte) in emitted.iter().enumerate() {
        let read = given.get(at).copied().unwrap_or(0);
        assert_eq!(byte & read, byte, "byte {at}: {byte:02X} of {read:02X}");
    }
}

/// The laws look behind the end of what is written.
fn wire_type<'a, T: Wire<'a> + Debug + PartialEq>(data: &'a [u8], buffer: &'a mut [u8]) {
    let Ok(value) = T::parse(data) else { return };
    let emitted = laws::round_trip(&value, buffer);
    part_of(emitted, data);
    assert!(emitted.len() <= data.len(), "{value:?}");
}

/// The two readings of SegmentSize differ only where a transfer begins, and each reads what it wrote.
fn segment_sizes(data: &[u8]) {
    for initiate in [InitiateSize::Counted, InitiateSize::NotCounted] {
        let Ok(sdo) = Sdo::read_as(&mut Reader::new(data), initiate) else { continue };
        let mut buffer = [0; LONGEST + 16];
        let mut out = Writer::new(&mut buffer);
        sdo.sequence.emit(&mut out).expect("there is room");
        if let Some(command) = sdo.command {
            command.emit_as(&mut out, initiate).expect("there is room");
            assert_eq!(command.abort().is_some(), command.is_abort && command.data.len() >= 4);
        }
        part_of(out.written(), data);
        assert_eq!(Sdo::read_as(&mut Reader::new(out.written()), initiate), Ok(sdo));
    }
}

fn numbers(data: &[u8]) {
    let list = NodeList::of(data);
    let mut again = NodeList::default();
    (0..=u8::MAX).map(NodeId).filter(|&node| list.contains(node)).for_each(|node| again.insert(node));
    assert_eq!(again, list);
    if let Some(number) = data.first_chunk().copied().map(u64::from_le_bytes) {
        let entry = MappingEntry::of(number);
        assert_eq!(entry.number(), number & !0xFF00_0000);
        assert_eq!(MappingEntry::of(entry.number()), entry);
    }
}

const LONGEST: usize = 1024;

/// The headers of a frame from node 1 to node 240, up to the content: the group, the message type, and the service of an ASnd.
fn head(group: u8, kind: &[u8]) -> Vec<u8> {
    let (message_type, service) = kind.split_at(1);
    let addresses = [0x01, 0x11, 0x1E, 0, 0, group, 2, 0, 0, 0, 0, 1, 0x88, 0xAB];
    [&addresses, message_type, &[240, 1], service].concat()
}

const KINDS: [(u8, &[u8]); 12] = [
    (1, &[0x01]),
    (2, &[0x03]),
    (2, &[0x04]),
    (3, &[0x05]),
    (4, &[0x06, 0x01]),
    (4, &[0x06, 0x02]),
    (4, &[0x06, 0x03]),
    (4, &[0x06, 0x04]),
    (4, &[0x06, 0x05]),
    (4, &[0x06, 0x06]),
    (5, &[0x07]),
    (5, &[0x8D]),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// A SoC of openPOWERLINK without padding, and an IdentRequest with reserved bits set.
    #[test]
    fn recorded_frames_are_accepted() {
        let soc = [&head(1, &[0x01])[..], &[0; 19]].concat();
        assert_eq!(soc.len(), 36);
        assert!(Frame::parse(&soc).is_ok());
        run(&soc);
        run(&[0x1D, 0xFF, 0xFF, 0x01, 0x01, 0x20, 0x01]);
        run(&[]);
    }
}
