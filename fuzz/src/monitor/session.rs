//! A session on a bus, read from bytes: recorded frames, frames that belong to DeviceNet exchanges, and frames from before
//! with a byte changed.
//!
//! Each item is a [span](crate::input::span) since the frame before, then a byte whose bits 7-6 say what follows:
//!
//! | Bits 7-6 | Frame | Bytes that follow |
//! |---|---|---|
//! | 0x | as [`input`] reads it, from this byte on | |
//! | 10 | number bits 5-0 of [`exchange`] | the two nodes, then an argument |
//! | 11 | the one sent so many frames ago as bits 5-0 say | which byte of it is changed, and with what |

use core::time::Duration;

use arbitrary::{Result, Unstructured};
use devicenet_core::{Identifier, MacId};
use link_core::{Frame, Instant};

use crate::input;

/// A frame of a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Sent {
    pub(crate) at: Duration,
    pub(crate) frame: Frame,
}

/// The frame of that number, between nodes, with an argument.
pub(crate) type Exchange = fn(u8, u8, u8) -> Frame;

/// Reads a session, at most `most` frames of it, whose exchanges are those of a protocol.
pub(crate) fn read(input: &mut Unstructured<'_>, most: usize, exchange: Exchange) -> Vec<Sent> {
    let mut sent: Vec<Sent> = Vec::new();
    let mut at = Duration::ZERO;
    while !input.is_empty() && sent.len() < most {
        let Ok((span, frame)) = item(input, &sent, exchange) else { break };
        at += span;
        sent.push(Sent { at, frame });
    }
    sent
}

/// The bytes from which `read` reads these frames.
#[must_use]
pub fn session_bytes(frames: impl IntoIterator<Item = (Instant, Frame)>) -> Vec<u8> {
    let mut last = None;
    let mut bytes = Vec::new();
    for (at, frame) in frames {
        let span = last.map_or(Duration::ZERO, |last| at.saturating_since(last));
        last = Some(at);
        bytes.push(input::span_byte(span));
        bytes.extend(input::frame_bytes(&frame));
    }
    bytes
}

fn item(input: &mut Unstructured<'_>, before: &[Sent], exchange: Exchange) -> Result<(Duration, Frame)> {
    let (span, head): (u8, u8) = (input.arbitrary()?, input.arbitrary()?);
    let frame = match head >> 6 {
        0b10 => {
            let (nodes, argument) = (input.arbitrary()?, input.arbitrary()?);
            exchange(head & 0x3F, nodes, argument)
        }
        0b11 => {
            let back = usize::from(head & 0x3F) + 1;
            let (place, change) = (input.arbitrary()?, input.arbitrary()?);
            let earlier = before.len().checked_sub(back).and_then(|index| before.get(index));
            earlier
                .map_or_else(|| exchange(0, place, change), |earlier| changed(&earlier.frame, place, change))
        }
        _ => input::frame_after(head, input)?,
    };
    Ok((input::span(span), frame))
}

/// The frame with one byte of its data changed; in place 8 and above nothing is.
fn changed(frame: &Frame, place: u8, change: u8) -> Frame {
    let mut data = [0; Frame::MAX_DATA];
    let len = frame.data().len();
    data[..len].copy_from_slice(frame.data());
    if let Some(byte) = data[..len].get_mut(usize::from(place)) {
        *byte ^= change;
    }
    if frame.is_remote() || frame.dlc() > 8 {
        return *frame;
    }
    Frame::new(frame.id(), &data[..len]).unwrap_or(*frame)
}

/// The frames of which exchanges consist, with a slave and a master from `nodes`: bits 3-0 the slave, bits 5-4 the
/// master, bit 7 XID.
pub(crate) fn exchange(number: u8, nodes: u8, argument: u8) -> Frame {
    let slave = mac(10 + (nodes & 0x0F));
    let master = mac(nodes >> 4 & 0x03);
    let xid = nodes >> 1 & 0x40;
    let (to_slave, to_master) = (xid | slave.number(), xid | master.number());
    let fragment = |count: u8| match count & 0x3F {
        0 => 0x00,
        count if argument & 0x80 == 0 => 0x40 | count,
        count => 0x80 | count,
    };
    let low = argument & 0x3F;
    let long = [argument, 1, 2, 3, 4, 5, 6, 7];
    let some = &long[..usize::from(argument & 0x07) + 1];
    let request = |body: &[u8]| frame(Identifier::explicit_request(slave), to_master, body);
    let response = |body: &[u8]| frame(Identifier::explicit_response(slave), to_master, body);
    let open = |body: &[u8]| frame(Identifier::unconnected_request(master), to_slave, body);
    let opened = |body: &[u8]| frame(Identifier::unconnected_response(slave), to_master, body);
    let group3 = |source: MacId, header: u8, body: &[u8]| {
        frame(Identifier::group3(argument >> 5 & 3, source).expect("0 to 3"), header, body)
    };
    match number {
        0 => plain(Identifier::duplicate_mac_check(slave), &[argument & 0x80, 0x34, 0x12, argument, 0, 0, 0]),
        1 => frame(
            Identifier::group2_unconnected_request(slave),
            to_master,
            &[0x4B, 3, 1, argument, to_master & 0x3F],
        ),
        2 => response(&[0xCB, argument & 0x07]),
        3 => frame(Identifier::group2_unconnected_request(slave), to_master, &[0x4C, 3, 1, argument]),
        4 => response(&[0xCC]),
        5 => request(&[0x4B, 3, 1, argument, to_master & 0x3F]),
        6 => request(&[0x0E, 1, 1, argument]),
        7 => request(&[0x0E, 5, argument >> 5, argument & 0x1F]),
        8 => response(&[0x8E, argument, argument >> 4]),
        9 => response(&[0x94, argument, 0xFF]),
        10 => request(&[0x10, 5, argument >> 6, 9, argument, 0]),
        11 => response(&[0x90, argument, 0]),
        12 => request(&[0x10, 5, argument >> 6, argument & 0x1F, 3]),
        13 => plain(Identifier::poll_command(slave), some),
        14 => plain(Identifier::poll_response(slave), some),
        15 => plain(Identifier::poll_command(slave), &[fragment(low), 1, 2, 3, 4, 5, 6, argument]),
        16 => plain(Identifier::poll_response(slave), &[fragment(low), 1, 2, 3, 4, 5, 6, argument]),
        17 => plain(Identifier::bit_strobe_command(master), &[argument; 8]),
        18 => plain(Identifier::bit_strobe_response(slave), some),
        19 => plain(Identifier::change_of_state(slave), some),
        20 => plain(Identifier::change_of_state_acknowledge(slave), &some[1..]),
        21 => plain(Identifier::multicast_poll_command(mac(low)), some),
        22 => plain(Identifier::multicast_poll_response(slave), some),
        23 => request_fragment(Identifier::explicit_request(slave), to_master, fragment(low), argument),
        24 => request_fragment(Identifier::explicit_response(slave), to_master, fragment(low), argument),
        25 => frame(Identifier::explicit_response(slave), 0x80 | to_master, &[0xC0 | low, argument >> 7]),
        26 => frame(Identifier::explicit_request(slave), 0x80 | to_master, &[0xC0 | low, argument >> 7]),
        27 => open(&[0x4B, argument & 0x0F, 0x30 | argument >> 5]),
        28 => opened(&[0xCB, argument & 0x0F, argument >> 5, argument & 3, 0]),
        29 => open(&[0x4C, argument & 3, 0]),
        30 => opened(&[0xCC]),
        31 => group3(master, to_slave, &[0x0E, 1, 0, 1, 0, argument & 0x0F]),
        32 => group3(slave, to_master, &[0x8E, argument, 0]),
        33 => group3(slave, 0x80 | to_master, &[fragment(low), 0x8E, 1, 2, 3, 4, argument]),
        34 => opened(&[0x94, 0x02, argument]),
        35 => {
            frame(Identifier::unconnected_response(slave), slave.number(), &[0xCD, 1, 0, argument, 0, 0, 0])
        }
        36 => frame(Identifier::explicit_response(slave), slave.number(), &[0xCE, 4, 0, 2, 0, argument, 2]),
        37 => plain(Identifier::COMMUNICATION_FAULTED_REQUEST, &[argument & 0x7F, 0x4B, argument % 7]),
        38 => plain(Identifier::COMMUNICATION_FAULTED_RESPONSE, &[0, 0x34, 0x12, argument, 0, 0, 0]),
        39 => plain(Identifier::COMMUNICATION_FAULTED_REQUEST, &[low, 0x4D, 0x34, 0x12, 1, 0, 0, 0]),
        40 => plain(Identifier::OFFLINE_OWNERSHIP_REQUEST, &[master.number(), 0x4B, 6, 0, argument, 0, 0, 0]),
        41 => {
            plain(Identifier::OFFLINE_OWNERSHIP_RESPONSE, &[master.number(), 0xCB, 6, 0, argument, 0, 0, 0])
        }
        42 => request(&[0x01, 1, 1]),
        43 => request(&[argument & 0x7F, 3, 1, 5]),
        44 => open(&[0x4B, argument & 0x0F, argument]),
        45 => {
            frame(Identifier::group2(slave, argument & 7).expect("three bits"), to_master, &[0x8E, argument])
        }
        _ => request(&[0x10, 3, 1, argument & 0x0F, number]),
    }
}

fn plain(id: Identifier, data: &[u8]) -> Frame {
    id.frame(data).expect("at most eight bytes")
}

fn frame(id: Identifier, header: u8, body: &[u8]) -> Frame {
    plain(id, &[&[header], body].concat())
}

fn request_fragment(id: Identifier, header: u8, fragment: u8, argument: u8) -> Frame {
    let body = [fragment, 0x0E | argument & 0x80, 1, 2, 3, 4, argument];
    let len = if fragment & 0x80 == 0 { body.len() } else { 2 + usize::from(argument % 5) };
    frame(id, 0x80 | header, &body[..len])
}

fn mac(number: u8) -> MacId {
    MacId::new(number & 0x3F).expect("six bits")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_session_is_read_from_its_bytes() {
        let check = plain(Identifier::duplicate_mac_check(mac(10)), &[0, 0x34, 0x12, 1, 0, 0, 0]);
        let poll = plain(Identifier::poll_command(mac(10)), &[3]);
        let bytes = session_bytes([(Instant::from_millis(7), check), (Instant::from_millis(10), poll)]);
        let read = read(&mut Unstructured::new(&bytes), 10, exchange);
        assert_eq!(
            read,
            [Sent { at: Duration::ZERO, frame: check }, Sent { at: Duration::from_millis(3), frame: poll }]
        );
    }

    #[test]
    fn an_earlier_frame_comes_back_changed() {
        let read = read(&mut Unstructured::new(&[0, 0x80 | 13, 0, 1, 0, 0xC0, 1, 0x40]), 10, exchange);
        assert_eq!((read[0].frame.data(), read[1].frame.data()), (&[1, 1][..], &[1, 0x41][..]));
    }

    #[test]
    fn every_exchange_is_a_frame() {
        for number in 0..64 {
            for argument in 0..=255 {
                let _ = exchange(number, argument, argument);
            }
        }
    }
}
