//! What can happen to a tool, read from bytes: each operation is one byte, modulo 11, with its arguments behind it.
//!
//! | Byte | Operation | Arguments |
//! |---|---|---|
//! | 0 | time passes and a tick comes | [span](crate::input::span) |
//! | 1 | a tick with a time that has passed | span |
//! | 2 | the time of the next deadline comes, with a tick | |
//! | 3 | a frame | [frame](crate::input::frame) |
//! | 4 | another tool sends of ownership | request or response |
//! | 5 | a faulted node answers | how |
//! | 6 | a node sends of the check of MAC ID 3 or the tool's own | which, byte 0 |
//! | 7 | the frame in flight was sent | access or tool |
//! | 8 | the frame in flight is given back | access or tool |
//! | 9 | something below the frame | which |
//! | 10 | a command | which |

use core::time::Duration;

use arbitrary::{Result, Unstructured};
use link_core::{Frame, LinkEvent};

use crate::input::{self, link_event};

/// Something that happens to a tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Op {
    Tick(Duration),
    TickInThePast(Duration),
    TickAtDeadline,
    Frame(Frame),
    Ownership(u8),
    Answer(u8),
    Check { which: u8, head: u8 },
    Sent(u8),
    GivenBack(u8),
    Link(LinkEvent),
    Command(u8),
}

pub(super) fn op(input: &mut Unstructured<'_>) -> Result<Op> {
    let code: u8 = input.arbitrary()?;
    Ok(match code % 11 {
        0 => Op::Tick(input::span(input.arbitrary()?)),
        1 => Op::TickInThePast(input::span(input.arbitrary()?)),
        2 => Op::TickAtDeadline,
        3 => Op::Frame(input::frame(input)?),
        4 => Op::Ownership(input.arbitrary()?),
        5 => Op::Answer(input.arbitrary()?),
        6 => Op::Check { which: input.arbitrary()?, head: input.arbitrary()? },
        7 => Op::Sent(input.arbitrary()?),
        8 => Op::GivenBack(input.arbitrary()?),
        9 => Op::Link(link_event(input.arbitrary()?)),
        _ => Op::Command(input.arbitrary()?),
    })
}
