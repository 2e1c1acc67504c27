//! What the bytes of the fuzzer mean: frames and spans of time. Generators only; nothing here judges.
//!
//! All are read from the front, field by field, so that a seed can be composed byte by byte, and bytes that are missing
//! at the end are zero. Each generator has an inverse, by which seeds are made from captures and vectors.
//!
//! A frame:
//!
//! | Byte | Content |
//! |---|---|
//! | 0 | bits 3-0 data length code, bit 4 remote frame, bit 5 29-bit identifier; bits 7-6 are free |
//! | 1-2 or 1-4 | identifier, little-endian; bits beyond 11 or 29 are ignored |
//! | then | the data: 0 to 8 bytes, none in a remote frame |
//!
//! A span of time is one byte: bits 7-6 choose the unit, bits 5-0 count it.
//!
//! | Bits 7-6 | Unit |
//! |---|---|
//! | 00 | 1 us |
//! | 01 | 1 ms |
//! | 10 | 50 ms |
//! | 11 | 1 s |

use core::time::Duration;

use arbitrary::{Result, Unstructured};
use link_core::frame::{extended_id, standard_id};
use link_core::link::LinkCommandKind;
use link_core::{BusErrorKind, Frame, LinkEvent};

/// The input of a network: a byte that says what it is like, then operations of one byte each with an argument behind it, not
/// more than `most`.
#[must_use]
pub fn plan_and_operations(data: &[u8], most: usize) -> Option<(u8, impl Iterator<Item = [u8; 2]>)> {
    let (&plan, rest) = data.split_first()?;
    let operations = rest.chunks(2).map(|pair| [pair[0], pair.get(1).copied().unwrap_or(0)]);
    Some((plan, operations.take(most)))
}

/// Reads a frame.
///
/// # Errors
/// None as long as zeros stand for missing bytes.
pub fn frame(input: &mut Unstructured<'_>) -> Result<Frame> {
    frame_after(input.arbitrary()?, input)
}

/// Reads the rest of a frame whose byte 0 is `head`, for inputs that use its free bits.
///
/// # Errors
/// None as long as zeros stand for missing bytes.
pub fn frame_after(head: u8, input: &mut Unstructured<'_>) -> Result<Frame> {
    let dlc = head & 0x0F;
    let id = if head & EXTENDED != 0 {
        link_core::Id::Extended(extended_id(input.arbitrary()?))
    } else {
        link_core::Id::Standard(standard_id(input.arbitrary()?))
    };
    if head & REMOTE != 0 {
        return Ok(Frame::remote(id, dlc).expect("four bits"));
    }
    let mut data = [0; Frame::MAX_DATA];
    let len = usize::from(dlc).min(data.len());
    input.fill_buffer(&mut data[..len])?;
    let frame = if dlc > 8 { Frame::with_dlc(id, dlc, data) } else { Frame::new(id, &data[..len]) };
    Ok(frame.expect("the length fits"))
}

/// The bytes from which [`frame`] reads this frame.
#[must_use]
pub fn frame_bytes(frame: &Frame) -> Vec<u8> {
    let extended = if frame.is_extended() { EXTENDED } else { 0 };
    let remote = if frame.is_remote() { REMOTE } else { 0 };
    let id_len = if frame.is_extended() { 4 } else { 2 };
    let mut bytes = vec![frame.dlc() | extended | remote];
    bytes.extend(&frame.raw_id().to_le_bytes()[..id_len]);
    bytes.extend(frame.data());
    bytes
}

/// The span that a byte means.
#[must_use]
pub fn span(byte: u8) -> Duration {
    let count = u64::from(byte & 0x3F);
    match byte >> 6 {
        0 => Duration::from_micros(count),
        1 => Duration::from_millis(count),
        2 => Duration::from_millis(50 * count),
        _ => Duration::from_secs(count),
    }
}

/// The byte that means the span nearest below.
#[must_use]
pub fn span_byte(span: Duration) -> u8 {
    (0..=u8::MAX)
        .filter(|&byte| self::span(byte) <= span)
        .max_by_key(|&byte| self::span(byte))
        .unwrap_or_default()
}

/// What happens below the frame, by a byte modulo 8.
#[must_use]
pub fn link_event(which: u8) -> LinkEvent {
    match which % 8 {
        0 | 1 => LinkEvent::Up,
        2 => LinkEvent::Down,
        3 => LinkEvent::BusOff,
        4 => LinkEvent::BusError(BusErrorKind::Ack),
        5 => LinkEvent::BusError(BusErrorKind::Bit),
        6 => LinkEvent::Overrun { lost: 1 },
        _ => LinkEvent::Refused(LinkCommandKind::Reset),
    }
}

const REMOTE: u8 = 0x10;
const EXTENDED: u8 = 0x20;

#[cfg(test)]
mod tests {
    use super::*;

    fn read(bytes: &[u8]) -> Frame {
        frame(&mut Unstructured::new(bytes)).unwrap()
    }

    #[test]
    fn frames_are_read_as_the_table_says() {
        assert_eq!(read(&[0x02, 0x2F, 0x05, 0xAA, 0xBB]).to_string(), "52F [2] AA BB");
        assert_eq!(read(&[0x18, 0x2F, 0xFD]).to_string(), "52F [8] remote");
        assert_eq!(read(&[0x20, 0x33, 0x44, 0xFE, 0xFF]).to_string(), "1FFE4433 [0]");
        assert_eq!(read(&[0x0F, 0x00, 0x00, 1]).to_string(), "000 [15] 01 00 00 00 00 00 00 00");
    }

    #[test]
    fn a_frame_is_read_from_its_bytes() {
        let id = standard_id(0x3C5);
        for frame in [
            Frame::new(id, &[1, 2, 3]).unwrap(),
            Frame::with_dlc(id, 12, [7; 8]).unwrap(),
            Frame::remote(extended_id(0x1234_5678), 4).unwrap(),
            Frame::new(extended_id(0), &[]).unwrap(),
        ] {
            assert_eq!(read(&frame_bytes(&frame)), frame);
        }
    }

    #[test]
    fn a_span_is_rounded_down_to_its_byte() {
        assert_eq!(span(span_byte(Duration::from_micros(20))), Duration::from_micros(20));
        assert_eq!(span(span_byte(Duration::from_millis(1020))), Duration::from_secs(1));
        assert_eq!(span(span_byte(Duration::from_secs(500))), Duration::from_secs(63));
    }
}
