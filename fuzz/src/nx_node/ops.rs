//! What can happen to a device, read from bytes.
//!
//! Three bytes of [configuration](super::station::config). Then each operation is one byte, modulo 16, with its arguments
//! behind it. Nodes are modulo 8: 0 to 4 are OA 1, 5 is OA 2, 6 is OA 127, 7 is the device's own.
//!
//! | Byte | Operation | Arguments |
//! |---|---|---|
//! | 0 | time passes and a tick comes | [span](crate::input::span) |
//! | 1 | time passes unnoticed | span |
//! | 2 | a tick with a time that has passed | span |
//! | 3 | the time of the next deadline comes, with a tick; bit 7: one nanosecond before | |
//! | 4 | any frame | [frame](crate::input::frame) |
//! | 5 | a connection request | node, [request](connection) |
//! | 6 | an explicit request, Message ID in bits 5-4 | node, [request](request) |
//! | 7 | a fragment of one | node, fragmentation byte, length, data |
//! | 8 | an acknowledge; bit 7: on the connectionless port | node, count, status |
//! | 9 | an implicit message, as a connection consumes it | which, length, data |
//! | 10 | a frame was sent; bits 5-4 choose among those in flight; bit 7: given back | |
//! | 11 | something below the frame | which |
//! | 12 | the inputs change, and the device is told | a byte |
//! | 13 | a connectionless request | node, request |
//! | 14 | Hello with the device's address, bit 7 a response; bit 6: Mini-who; bit 5: ROAM | a byte |
//! | 15 | a request is sent in fragments, each of which is acknowledged | node, request |

use core::time::Duration;

use arbitrary::{Result, Unstructured};
use link_core::{Frame, LinkEvent};

use crate::input;

/// Something that happens to a device.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) enum Op {
    Tick(Duration),
    Elapse(Duration),
    TickInThePast(Duration),
    TickAtDeadline,
    TickBeforeDeadline,
    Frame(Frame),
    Connect { node: u8, body: Vec<u8> },
    Request { node: u8, message: u8, body: Vec<u8> },
    Fragment { node: u8, byte: u8, data: Vec<u8> },
    Acknowledge { node: u8, connectionless: bool, count: u8, status: u8 },
    Implicit { which: usize, data: Vec<u8> },
    Done { which: usize, sent: bool },
    Link(LinkEvent),
    Inputs(u8),
    Connectionless { node: u8, body: Vec<u8> },
    Hello { response: bool, serial: u8 },
    MiniWho(u8),
    Roam(u8),
    InFragments { node: u8, body: Vec<u8> },
}

pub(super) fn op(input: &mut Unstructured<'_>) -> Result<Op> {
    let code: u8 = input.arbitrary()?;
    let (high, bits) = (code & 0x80 != 0, code >> 4 & 3);
    Ok(match code % 16 {
        0 => Op::Tick(input::span(input.arbitrary()?)),
        1 => Op::Elapse(input::span(input.arbitrary()?)),
        2 => Op::TickInThePast(input::span(input.arbitrary()?)),
        3 if high => Op::TickBeforeDeadline,
        3 => Op::TickAtDeadline,
        4 => Op::Frame(input::frame(input)?),
        5 => Op::Connect { node: input.arbitrary()?, body: connection(input)? },
        6 => Op::Request { node: input.arbitrary()?, message: bits, body: request(input)? },
        7 => Op::Fragment { node: input.arbitrary()?, byte: input.arbitrary()?, data: bytes(input, 8)? },
        8 => {
            let (node, count, status): (u8, u8, u8) = input.arbitrary()?;
            Op::Acknowledge { node, connectionless: high, count: count % 64, status: status % 4 }
        }
        9 => Op::Implicit { which: usize::from(input.arbitrary::<u8>()?), data: bytes(input, 8)? },
        10 => Op::Done { which: bits.into(), sent: !high },
        11 => Op::Link(input::link_event(input.arbitrary()?)),
        12 => Op::Inputs(input.arbitrary()?),
        13 => Op::Connectionless { node: input.arbitrary()?, body: request(input)? },
        14 if code & 0x40 != 0 => Op::MiniWho(input.arbitrary()?),
        14 if code & 0x20 != 0 => Op::Roam(input.arbitrary()?),
        14 => Op::Hello { response: high, serial: input.arbitrary()? },
        _ => Op::InFragments { node: input.arbitrary()?, body: request(input)? },
    })
}

/// A connection request, as the byte in front says.
///
/// | Byte | Request | Arguments |
/// |---|---|---|
/// | bit 7 | anything | up to 8 bytes |
/// | 0-13 | that instance, in a group that it can be in; bits 6-4 the Message ID | EPR, UINT; action |
/// | 14 | dynamic, two bytes | P, group and Message ID |
/// | 15 | dynamic, with the number 128 and up in bits 6-4 | group and Message ID; EPR; action |
fn connection(input: &mut Unstructured<'_>) -> Result<Vec<u8>> {
    let head: u8 = input.arbitrary()?;
    if head & 0x80 != 0 {
        return bytes(input, 8);
    }
    let message = head >> 4 & 7;
    Ok(match head % 16 {
        14 => vec![0x4B, input.arbitrary()?],
        15 => {
            let [group, low, high, action]: [u8; 4] = input.arbitrary()?;
            vec![0x4B, group & 0x7F, 128 + message, 0, low, high, action % 4]
        }
        instance => {
            let [low, high, action]: [u8; 3] = input.arbitrary()?;
            let group = match instance {
                1 => 0xD0,
                instance if instance % 2 == 1 => 0xC0,
                _ => 0x80,
            };
            vec![0x4B, group | message, instance, 0, low, high, action % 4]
        }
    })
}

/// A service, its object, and data, as the byte in front says. The names of the connections are 0 to 7 in bits 6-4: 1, 3,
/// 7, 9, 13, 128, 129, 2.
///
/// | Byte, modulo 16 | Request | Arguments |
/// |---|---|---|
/// | 0 | Set the packet rate | UINT |
/// | 1 | Set another attribute of a connection | attribute, up to 4 bytes |
/// | 2 | Get an attribute of a connection | attribute |
/// | 3 | Reset, Delete, Apply or another service of a connection | service |
/// | 4 | Set attribute 3 | a byte |
/// | 5 | Set attribute 5 to what OA 2 produces on instance 7 | |
/// | 6 | Get an attribute of the link object | attribute |
/// | 7 | Set one | attribute, up to 3 bytes |
/// | 8 | Set an attribute of the Acknowledge Handler | attribute, up to 3 bytes |
/// | 9 | Get an attribute of Identity; bit 7: the name | attribute |
/// | 10 | Reset of Identity | up to 3 bytes |
/// | 11-15 | anything | up to 12 bytes |
fn request(input: &mut Unstructured<'_>) -> Result<Vec<u8>> {
    let head: u8 = input.arbitrary()?;
    let instance = [1, 3, 7, 9, 13, 128, 129, 2][usize::from(head >> 4 & 7)];
    let with = |start: &[u8], data: Vec<u8>| [start, &data].concat();
    Ok(match head % 16 {
        0 => {
            let [low, high]: [u8; 2] = input.arbitrary()?;
            vec![0x10, 5, instance, 9, low, high]
        }
        1 => {
            let attribute: u8 = input.arbitrary()?;
            with(&[0x10, 5, instance, attribute % 20], bytes(input, 4)?)
        }
        2 => vec![0x0E, 5, instance, input.arbitrary::<u8>()? % 20],
        3 => {
            let service: u8 = input.arbitrary()?;
            let service = if service < 0xC0 { [0x05, 0x09, 0x0D][usize::from(service % 3)] } else { service };
            vec![service & 0x7F, 5, if head & 0x80 != 0 { 0 } else { instance }]
        }
        4 => vec![0x10, 5, instance, 3, input.arbitrary()?],
        5 => vec![0x10, 5, instance, 5, 7, 0, 4, 0x80],
        6 => vec![0x0E, 3, 1, input.arbitrary::<u8>()? % 8],
        7 => {
            let attribute: u8 = input.arbitrary()?;
            with(&[0x10, 3, 1, attribute % 8], bytes(input, 3)?)
        }
        8 => {
            let attribute: u8 = input.arbitrary()?;
            with(&[0x10, 0x2B, 1, attribute % 4], bytes(input, 3)?)
        }
        9 if head & 0x80 != 0 => vec![0x0E, 1, 1, 7],
        9 => vec![0x0E, 1, 1, input.arbitrary::<u8>()? % 12],
        10 => with(&[0x05, 1, 1], bytes(input, 3)?),
        _ => bytes(input, 12)?,
    })
}

/// A length, modulo one more than the greatest, and as many bytes.
fn bytes(input: &mut Unstructured<'_>, most: usize) -> Result<Vec<u8>> {
    let len = usize::from(input.arbitrary::<u8>()?) % (most + 1);
    let mut data = vec![0; len];
    input.fill_buffer(&mut data)?;
    Ok(data)
}
