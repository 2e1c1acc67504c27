//! What can happen to a network manager, read from bytes.
//!
//! The first byte is the configuration; then each operation is one byte, modulo 13, with its arguments behind it:
//!
//! | Byte | Operation | Arguments |
//! |---|---|---|
//! | 0 | time passes and a tick comes | [span](crate::input::span) |
//! | 1 | a tick with a time that has passed | span |
//! | 2 | the time of the next deadline comes, with a tick | |
//! | 3 | a frame | [frame](crate::input::frame) |
//! | 4 | a device says Hello | which device, with which address and in which direction |
//! | 5 | a node answers the last request to it | which node, how |
//! | 6 | a node sends data | which node, which connection |
//! | 7 | a frame in flight was sent | which |
//! | 8 | a frame in flight is given back | which |
//! | 9 | something below the frame | which |
//! | 10 | the application commands something | which, which address |
//! | 11 | another manager asks who is there | low byte of its serial number |
//! | 12 | another manager gives an address away | which device |

use core::time::Duration;

use arbitrary::{Result, Unstructured};
use link_core::{Frame, LinkEvent};

use crate::input::{self, link_event};

/// Something that happens to a manager.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Op {
    Tick(Duration),
    TickInThePast(Duration),
    TickAtDeadline,
    Frame(Frame),
    Hello { device: u8, how: u8 },
    Answer { node: u8, how: u8 },
    Data { node: u8, connection: u8 },
    Sent(u8),
    GivenBack(u8),
    Link(LinkEvent),
    Command { which: u8, node: u8 },
    MiniWho(u8),
    Roam(u8),
}

pub(super) fn op(input: &mut Unstructured<'_>) -> Result<Op> {
    let code: u8 = input.arbitrary()?;
    Ok(match code % 13 {
        0 => Op::Tick(input::span(input.arbitrary()?)),
        1 => Op::TickInThePast(input::span(input.arbitrary()?)),
        2 => Op::TickAtDeadline,
        3 => Op::Frame(input::frame(input)?),
        4 => Op::Hello { device: input.arbitrary()?, how: input.arbitrary()? },
        5 => Op::Answer { node: input.arbitrary()?, how: input.arbitrary()? },
        6 => Op::Data { node: input.arbitrary()?, connection: input.arbitrary()? },
        7 => Op::Sent(input.arbitrary()?),
        8 => Op::GivenBack(input.arbitrary()?),
        9 => Op::Link(link_event(input.arbitrary()?)),
        10 => Op::Command { which: input.arbitrary()?, node: input.arbitrary()? },
        11 => Op::MiniWho(input.arbitrary()?),
        _ => Op::Roam(input.arbitrary()?),
    })
}
