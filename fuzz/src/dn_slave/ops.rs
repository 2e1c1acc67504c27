//! What can happen to a slave, read from bytes.
//!
//! Three bytes of [configuration](super::device); bit 0 of the next chooses a server with two connections of the UCMM. Then
//! each operation is one byte, modulo 16, with its arguments behind it. Nodes are 0 to 3: the masters 4 and 5, and two
//! others, of which one has the slave's own MAC ID plus one.
//!
//! | Byte | Operation | Arguments |
//! |---|---|---|
//! | 0 | time passes and a tick comes | [span](crate::input::span) |
//! | 1 | time passes unnoticed | span |
//! | 2 | a tick with a time that has passed | span |
//! | 3 | the time of the next deadline comes, with a tick; bit 7: one nanosecond before | |
//! | 4 | any frame | [frame](crate::input::frame) |
//! | 5 | a request on the unconnected port | node, [request](request) |
//! | 6 | a request on the explicit connection; bit 6 the XID | node, request |
//! | 7 | a fragment on the explicit connection; bit 6 the XID | node, fragmentation byte, length, data |
//! | 8 | an acknowledge on it; bit 7: of the fragment that is waiting | node, count, status |
//! | 9 | an I/O message on 0x405, 0x400, 0x402 or 0x401 by bits 5-4 | node, length, data |
//! | 10 | the frame of a line was sent; bits 5-4 choose among those in flight; bit 7: given back | |
//! | 11 | something below the frame | which |
//! | 12 | the inputs change, and the slave is told | a byte |
//! | 13 | a UCMM request | node, service, two bytes |
//! | 14 | a request on a connection that was opened dynamically; bit 6 the XID | which, request |
//! | 15 | a request is sent in fragments on the explicit connection, each of which is acknowledged | node, request |

use core::time::Duration;

use arbitrary::{Result, Unstructured};
use link_core::{BusErrorKind, Frame, LinkEvent};

use crate::input;

/// Something that happens to a slave.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) enum Op {
    Tick(Duration),
    Elapse(Duration),
    TickInThePast(Duration),
    TickAtDeadline,
    TickBeforeDeadline,
    Frame(Frame),
    Unconnected { node: u8, body: Vec<u8> },
    Request { node: u8, xid: bool, body: Vec<u8> },
    Fragment { node: u8, xid: bool, byte: u8, data: Vec<u8> },
    Acknowledge { node: u8, count: Option<u8>, status: u8 },
    Io { line: u8, node: u8, data: Vec<u8> },
    Done { which: usize, sent: bool },
    Link(LinkEvent),
    Inputs(u8),
    Ucmm { node: u8, body: [u8; 3] },
    Dynamic { which: usize, xid: bool, body: Vec<u8> },
    InFragments { node: u8, body: Vec<u8> },
}

pub(super) fn op(input: &mut Unstructured<'_>) -> Result<Op> {
    let code: u8 = input.arbitrary()?;
    let (xid, high, bits) = (code & 0x40 != 0, code & 0x80 != 0, code >> 4 & 3);
    Ok(match code % 16 {
        0 => Op::Tick(input::span(input.arbitrary()?)),
        1 => Op::Elapse(input::span(input.arbitrary()?)),
        2 => Op::TickInThePast(input::span(input.arbitrary()?)),
        3 if high => Op::TickBeforeDeadline,
        3 => Op::TickAtDeadline,
        4 => Op::Frame(input::frame(input)?),
        5 => Op::Unconnected { node: input.arbitrary()?, body: request(input)? },
        6 => Op::Request { node: input.arbitrary()?, xid, body: request(input)? },
        7 => {
            let (node, byte) = (input.arbitrary()?, input.arbitrary()?);
            Op::Fragment { node, xid, byte, data: bytes(input, 6)? }
        }
        8 => {
            let (node, count, status): (u8, u8, u8) = input.arbitrary()?;
            Op::Acknowledge { node, count: (!high).then_some(count % 64), status: status % 4 }
        }
        9 => Op::Io { line: bits, node: input.arbitrary()?, data: bytes(input, 8)? },
        10 => Op::Done { which: bits.into(), sent: !high },
        11 => Op::Link(link_event(input.arbitrary()?)),
        12 => Op::Inputs(input.arbitrary()?),
        13 => Op::Ucmm { node: input.arbitrary()?, body: input.arbitrary()? },
        14 => Op::Dynamic { which: usize::from(input.arbitrary::<u8>()?), xid, body: request(input)? },
        _ => Op::InFragments { node: input.arbitrary()?, body: request(input)? },
    })
}

/// A service, its object, and data, as the byte in front says:
///
/// | Byte, modulo 16 | Request | Arguments |
/// |---|---|---|
/// | 0-2 | Allocate | choice, allocator |
/// | 3 | Release | choice |
/// | 4 | Set the packet rate; bits 6-4 the instance | UINT |
/// | 5 | Set another attribute of a connection; bits 6-4 the instance | attribute, up to 3 bytes |
/// | 6 | Get an attribute of a connection; bits 6-4 the instance | attribute |
/// | 7 | Reset, Delete, Apply or another service of a connection; bits 6-4 the instance | service |
/// | 8 | Get attribute 5 of the DeviceNet object | |
/// | 9 | Set an attribute of the DeviceNet object | attribute, up to 3 bytes |
/// | 10 | Set an attribute of the Acknowledge Handler | attribute, up to 3 bytes |
/// | 11 | Get attribute of Identity; bit 7: the name | attribute |
/// | 12 | Reset of Identity | up to 3 bytes |
/// | 13-15 | anything | up to 6 bytes |
fn request(input: &mut Unstructured<'_>) -> Result<Vec<u8>> {
    let head: u8 = input.arbitrary()?;
    let instance = head >> 4 & 7;
    let with = |start: &[u8], data: Vec<u8>| [start, &data].concat();
    Ok(match head % 16 {
        0..=2 => {
            let (choice, allocator): (u8, u8) = input.arbitrary()?;
            // Most of the time what a master would send.
            let allocator = if allocator < 0xC0 { 4 + allocator % 2 } else { allocator };
            vec![0x4B, 3, 1, choice, allocator]
        }
        3 => vec![0x4C, 3, 1, input.arbitrary()?],
        4 => {
            let [low, high]: [u8; 2] = input.arbitrary()?;
            vec![0x10, 5, instance, 9, low, high]
        }
        5 => {
            let attribute: u8 = input.arbitrary()?;
            with(&[0x10, 5, instance, attribute % 20], bytes(input, 3)?)
        }
        6 => vec![0x0E, 5, instance, input.arbitrary::<u8>()? % 20],
        7 => {
            let service: u8 = input.arbitrary()?;
            let service = if service < 0xC0 { [0x05, 0x09, 0x0D][usize::from(service % 3)] } else { service };
            vec![service & 0x7F, 5, instance.max(1)]
        }
        8 => vec![0x0E, 3, 1, 5],
        9 => {
            let attribute: u8 = input.arbitrary()?;
            with(&[0x10, 3, 1, attribute % 14], bytes(input, 3)?)
        }
        10 => {
            let attribute: u8 = input.arbitrary()?;
            with(&[0x10, 0x2B, 1, attribute % 4], bytes(input, 3)?)
        }
        11 if head & 0x80 != 0 => vec![0x0E, 1, 1, 7],
        11 => vec![0x0E, 1, 1, input.arbitrary::<u8>()? % 12],
        12 => with(&[0x05, 1, 1], bytes(input, 3)?),
        _ => bytes(input, 6)?,
    })
}

/// A length, modulo one more than the greatest, and as many bytes.
fn bytes(input: &mut Unstructured<'_>, most: usize) -> Result<Vec<u8>> {
    let len = usize::from(input.arbitrary::<u8>()?) % (most + 1);
    let mut data = vec![0; len];
    input.fill_buffer(&mut data)?;
    Ok(data)
}

fn link_event(which: u8) -> LinkEvent {
    match which % 8 {
        0..=2 => LinkEvent::Up,
        3 => LinkEvent::Down,
        4 => LinkEvent::BusOff,
        5 => LinkEvent::ErrorPassive,
        6 => LinkEvent::BusError(BusErrorKind::Ack),
        _ => LinkEvent::Counters { tec: u16::from(which), rec: 0 },
    }
}
