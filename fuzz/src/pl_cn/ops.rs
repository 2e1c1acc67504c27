//! What can happen to a controlled node, read from bytes.
//!
//! Three bytes of [configuration](super::device), then each operation is one byte, modulo 16, with its arguments behind it.
//!
//! | Byte | Operation | Arguments |
//! |---|---|---|
//! | 0 | time passes and a tick comes; bit 7: unnoticed; bit 6: backwards | [span](crate::input::span) |
//! | 1 | the time of the next deadline comes, with a tick; bit 7: one nanosecond before | |
//! | 2 | SoC; bit 7 MC, bits 5-4 one in four of another node | |
//! | 3 | PReq; bit 7 with a Size that is one more than the data, bit 6 without padding | flags, version, length, data |
//! | 4 | SoA; bits 6-4 choose the request, bit 7 for another node | flags |
//! | 5 | an NMT command; bits 5-4 whom: the node, all, another, all by a list; bits 7-6 one in four of another node | command |
//! | 6 | PRes of another node | node, flags, version, length, data |
//! | 7 | the next SDO frame of a client; bits 6-5 which frame, bit 7 the diagnostic device | see [`Sdo`] |
//! | 8 | an SDO frame | four bytes of the sequence layer, length, data |
//! | 9 | any frame from the addresses on; bits 6-4 its group | length, data |
//! | 10 | something below the frame | which |
//! | 11 | the application does something | which |
//! | 12 | so many good cycles, bits 7-4 and one more | |
//! | 13 | the start up to `Operational`, or as far as bits 5-4 say | |
//! | 14 | an StatusRequest as the managing node would send it: EA = EN | bit 7 of the operation is ER |
//! | 15 | any bytes | length, bytes |

use core::time::Duration;

use arbitrary::{Result, Unstructured};
use link_core::ethernet::LinkEvent;

use crate::input;

/// Something that happens to a node.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) enum Op {
    Tick(Duration),
    Elapse(Duration),
    Past(Duration),
    Deadline { early: bool },
    Soc { from: u8, multiplexed: bool },
    Preq { from: u8, flags: u8, version: u8, size: usize, data: Vec<u8>, is_padded: bool },
    Soa { service: u8, is_own: bool, flags: u8 },
    Command { from: u8, command: u8, whom: u8 },
    Pres { from: u8, flags: u8, version: u8, data: Vec<u8> },
    Sdo { is_diagnostic: bool, frame: Sdo },
    Sequence { bytes: [u8; 4], data: Vec<u8> },
    Group { group: u8, bytes: Vec<u8> },
    Link(LinkEvent),
    Application(Application),
    Cycles(u8),
    Start(u8),
    Status { reset: bool },
    Bytes(Vec<u8>),
}

/// A frame of a client that keeps to the protocol.
///
/// | Bits 6-5 | Frame | Arguments |
/// |---|---|---|
/// | 0 | the next step of the opening, or an acknowledge | |
/// | 1 | a command in order | [which](command) |
/// | 2 | the last one again | |
/// | 3 | it closes | |
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) enum Sdo {
    Open,
    Command { id: u8, segmentation: u8, wants_acknowledge: bool, data: Vec<u8> },
    Again,
    Close,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Application {
    PowerOn,
    Reset,
    SwitchOff,
    Ready,
    Request(u8),
    /// Bits 15-12 of an error entry.
    Error(u8),
    Inputs(u8),
    Validity(bool),
    Register(u8),
}

pub(super) fn op(input: &mut Unstructured<'_>) -> Result<Op> {
    let code: u8 = input.arbitrary()?;
    let high = code & 0x80 != 0;
    Ok(match code % 16 {
        0 => {
            let span = input::span(input.arbitrary()?);
            match code >> 6 {
                0 => Op::Tick(span),
                1 => Op::Past(span),
                _ => Op::Elapse(span),
            }
        }
        1 => Op::Deadline { early: high },
        2 => Op::Soc { from: sender(code), multiplexed: high },
        3 => {
            let [flags, version]: [u8; 2] = input.arbitrary()?;
            let data = bytes(input, 96)?;
            Op::Preq {
                from: sender(code),
                flags,
                version,
                size: data.len() + usize::from(high),
                data,
                is_padded: code & 0x40 == 0,
            }
        }
        4 => {
            let services = [0x00, 0x01, 0x02, 0x03, 0x06, 0xA0, 0xFF, 0xFF];
            let service = services[usize::from(code >> 4 & 7)];
            Op::Soa { service, is_own: !high, flags: input.arbitrary()? }
        }
        5 => Op::Command {
            from: if code >> 6 == 3 { 2 } else { 240 },
            command: command_id(input.arbitrary()?),
            whom: code >> 4 & 3,
        },
        6 => {
            let [from, flags, version]: [u8; 3] = input.arbitrary()?;
            Op::Pres { from, flags, version, data: bytes(input, 96)? }
        }
        7 => Op::Sdo { is_diagnostic: high, frame: sdo(code >> 5 & 3, input)? },
        8 => Op::Sequence { bytes: input.arbitrary()?, data: bytes(input, 64)? },
        9 => Op::Group { group: code >> 4 & 7, bytes: bytes(input, 255)? },
        10 => Op::Link(link_event(input.arbitrary()?)),
        11 => Op::Application(application(input.arbitrary()?)),
        12 => Op::Cycles(code >> 4),
        13 => Op::Start(code >> 4 & 3),
        14 => Op::Status { reset: high },
        _ => Op::Bytes(bytes(input, 255)?),
    })
}

/// Most of the time the managing node.
fn sender(code: u8) -> u8 {
    [240, 240, 240, 2][usize::from(code >> 4 & 3)]
}

/// Most of the time a command that a controlled node knows.
fn command_id(byte: u8) -> u8 {
    const KNOWN: [u8; 8] = [0x21, 0x22, 0x23, 0x24, 0x28, 0x29, 0x2A, 0x2B];
    match byte {
        0..0x60 => KNOWN[usize::from(byte % 8)],
        0x60..0xA0 => KNOWN[usize::from(byte % 8)] + 0x20,
        _ => byte,
    }
}

fn sdo(which: u8, input: &mut Unstructured<'_>) -> Result<Sdo> {
    Ok(match which {
        0 => Sdo::Open,
        1 => command(input)?,
        2 => Sdo::Again,
        _ => Sdo::Close,
    })
}

/// A command, as the byte in front says; bit 7 asks for an acknowledge at once.
///
/// | Byte, modulo 8 | Command | Arguments |
/// |---|---|---|
/// | 0, 1 | read | [object](object) |
/// | 2, 3 | write | object, length, value |
/// | 4, 5 | a part of a write, bits 5-4 which | object, length, value |
/// | 6 | a write that begins, with its size | object, size, length, value |
/// | 7 | any, bits 5-4 which part | command, length, data |
fn command(input: &mut Unstructured<'_>) -> Result<Sdo> {
    let head: u8 = input.arbitrary()?;
    let (wants_acknowledge, part) = (head & 0x80 != 0, head & 0x30);
    let (id, segmentation, data) = match head % 8 {
        0 | 1 => (2, 0, object(input)?),
        2 | 3 => (1, 0, [object(input)?, bytes(input, 40)?].concat()),
        4 | 5 => (1, part, [if part == 0x10 { object(input)? } else { vec![] }, bytes(input, 64)?].concat()),
        6 => {
            let at = object(input)?;
            let size = u32::from(input.arbitrary::<u8>()?);
            (1, 0x10, [&size.to_le_bytes()[..], &at, &bytes(input, 64)?].concat())
        }
        _ => (input.arbitrary()?, part, bytes(input, 40)?),
    };
    Ok(Sdo::Command { id, segmentation, wants_acknowledge, data })
}

/// One of the objects that a managing node writes, or any.
fn object(input: &mut Unstructured<'_>) -> Result<Vec<u8>> {
    const KNOWN: [(u16, u8); 24] = [
        (0x1006, 0),
        (0x1003, 0),
        (0x1003, 1),
        (0x1018, 1),
        (0x1020, 1),
        (0x1300, 0),
        (0x1400, 1),
        (0x1401, 1),
        (0x1600, 0),
        (0x1600, 1),
        (0x1601, 0),
        (0x1601, 1),
        (0x1A00, 0),
        (0x1A00, 1),
        (0x1C0B, 3),
        (0x1C0D, 3),
        (0x1C14, 0),
        (0x1F98, 4),
        (0x1F98, 5),
        (0x1F98, 8),
        (0x1F99, 0),
        (0x1F9E, 0),
        (0x2000, 0),
        (0x6200, 1),
    ];
    let which: u8 = input.arbitrary()?;
    let (index, sub) = match KNOWN.get(usize::from(which)) {
        Some(&known) => known,
        None => (u16::from_le_bytes([input.arbitrary()?, 0x10 | which & 0x7F]), input.arbitrary()?),
    };
    let [low, high] = index.to_le_bytes();
    Ok(vec![low, high, sub, 0])
}

fn bytes(input: &mut Unstructured<'_>, most: usize) -> Result<Vec<u8>> {
    let len = usize::from(input.arbitrary::<u8>()?) % (most + 1);
    let mut bytes = vec![0; len];
    input.fill_buffer(&mut bytes)?;
    Ok(bytes)
}

fn link_event(which: u8) -> LinkEvent {
    match which % 8 {
        0 | 1 => LinkEvent::Up,
        2 => LinkEvent::Down,
        3 | 4 => LinkEvent::CrcError,
        5 => LinkEvent::Collision,
        6 => LinkEvent::FramesLost { count: which.into() },
        _ => LinkEvent::NotSent,
    }
}

fn application(which: u8) -> Application {
    let value = which >> 4;
    match which % 16 {
        0 => Application::PowerOn,
        1 => Application::Reset,
        2 => Application::SwitchOff,
        3..=5 => Application::Ready,
        6 | 7 => Application::Request(command_id(which)),
        8 | 9 => Application::Error(value),
        10 | 11 => Application::Inputs(value),
        12 => Application::Validity(value & 1 == 1),
        _ => Application::Register(value),
    }
}
