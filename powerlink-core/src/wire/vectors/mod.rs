//! Golden frames: recorded from openPOWERLINK 2.7.2 (managing node 240, controlled node 1, on a virtual link), taken from
//! the example capture of powerlink_analyzer (a network of 2016), or made after the specification. Each is read into the fields
//! that stand here, shown in words, and written again byte by byte.
//!
//! If one of these fails, the code is wrong: they are never changed to what it says.

mod frames;

use std::string::ToString;
use std::vec::Vec;

use super::*;
use crate::ethernet::MIN_FRAME;

use frames::{Vector, vectors};

#[test]
fn golden_frames_are_read_and_written_again() {
    for Vector { frame, words, bytes: hex } in vectors() {
        let given = bytes(hex);
        assert_eq!(Frame::parse(&given), Ok(frame.clone()), "{words}");
        assert_eq!(frame.to_string(), words);
        let mut buffer = [0xA5; 200];
        let mut padded = given.clone();
        padded.resize(given.len().max(MIN_FRAME), 0);
        assert_eq!(frame.emit(&mut buffer).unwrap(), padded, "{words}");
    }
}

/// Frames that were made to be refused, and one that must not be.
#[test]
fn cut_frames_are_refused_and_reserved_bits_are_not() {
    let cut_in_size = bytes("0200000000010200000000f088ab0301f0000100000001");
    let error = Frame::parse(&cut_in_size).unwrap_err();
    assert_eq!(error.to_string(), "Size at offset 22: 2 bytes expected, 1 found");

    let cut_behind_the_target = bytes("01111e0000030200000000f088ab05fff01d00000101");
    assert!(Frame::parse(&cut_behind_the_target).is_err());

    let reserved_bits = bytes(
        "01111e0000030200000000f088ab05fff01d00ff01012001000000000000000000000000000000000000000000000000000000000000",
    );
    let words = Frame::parse(&reserved_bits).unwrap().to_string();
    assert_eq!(words, "MN -> all: SoA, NMT_PRE_OPERATIONAL_1, IdentRequest for node 1, EA=0 ER=0");

    let unknown = bytes("0200000000010200000000f088ab0901f000010000");
    assert_eq!(Frame::parse(&unknown).unwrap().to_string(), "MN -> node 1: message type 0x09, 4 bytes");

    let other = bytes("0200000000010200000000f00800450000");
    assert_eq!(Frame::parse(&other), Err(FrameError::OtherProtocol(0x0800)));
}

/// What an abort code of a golden frame says.
#[test]
fn abort_codes_are_read_from_their_frames() {
    let codes = vectors().into_iter().filter_map(|vector| match vector.frame.body {
        Body::Sdo(Sdo { command: Some(command), .. }) => command.abort(),
        _ => None,
    });
    let expected = [0x0602_0000, 0x0609_0011, 0x0607_0010, 0x0504_0001].map(AbortCode);
    assert_eq!(codes.collect::<Vec<_>>(), expected);
}

fn bytes(hex: &str) -> Vec<u8> {
    hex.as_bytes()
        .chunks(2)
        .map(|pair| u8::from_str_radix(core::str::from_utf8(pair).unwrap(), 16).unwrap())
        .collect()
}
