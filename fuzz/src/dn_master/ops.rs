//! What can happen to a master, read from bytes.
//!
//! The first two bytes are the configuration; then each operation is one byte, modulo 13, with its arguments behind it:
//!
//! | Byte | Operation | Arguments |
//! |---|---|---|
//! | 0 | time passes and a tick comes | [span](crate::input::span) |
//! | 1 | a tick with a time that has passed | span |
//! | 2 | the time of the next deadline comes, with a tick | |
//! | 3 | a frame | [frame](crate::input::frame) |
//! | 4 | a slave answers the last request to it | which slave, how |
//! | 5 | a slave sends a frame of I/O data | which slave and connection, byte 0, value |
//! | 6 | a slave checks its MAC ID, or objects | which slave, byte 0 |
//! | 7 | a frame in flight was sent | which |
//! | 8 | a frame in flight is given back | which |
//! | 9 | something below the frame | which |
//! | 10 | the application sets output data | which slave, value |
//! | 11 | the application asks a slave | which slave, length |
//! | 12 | another command | which, slave |

use core::time::Duration;

use arbitrary::{Result, Unstructured};
use link_core::{Frame, LinkEvent};

use crate::input::{self, link_event};

/// Something that happens to a master.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Op {
    Tick(Duration),
    TickInThePast(Duration),
    TickAtDeadline,
    Frame(Frame),
    Answer { slave: u8, how: u8 },
    Io { which: u8, head: u8, value: u8 },
    Check { slave: u8, head: u8 },
    Sent(u8),
    GivenBack(u8),
    Link(LinkEvent),
    Output { slave: u8, value: u8 },
    Ask { slave: u8, len: u8 },
    Command { which: u8, slave: u8 },
}

pub(super) fn op(input: &mut Unstructured<'_>) -> Result<Op> {
    let code: u8 = input.arbitrary()?;
    Ok(match code % 13 {
        0 => Op::Tick(input::span(input.arbitrary()?)),
        1 => Op::TickInThePast(input::span(input.arbitrary()?)),
        2 => Op::TickAtDeadline,
        3 => Op::Frame(input::frame(input)?),
        4 => Op::Answer { slave: input.arbitrary()?, how: input.arbitrary()? },
        5 => Op::Io { which: input.arbitrary()?, head: input.arbitrary()?, value: input.arbitrary()? },
        6 => Op::Check { slave: input.arbitrary()?, head: input.arbitrary()? },
        7 => Op::Sent(input.arbitrary()?),
        8 => Op::GivenBack(input.arbitrary()?),
        9 => Op::Link(link_event(input.arbitrary()?)),
        10 => Op::Output { slave: input.arbitrary()?, value: input.arbitrary()? },
        11 => Op::Ask { slave: input.arbitrary()?, len: input.arbitrary()? },
        _ => Op::Command { which: input.arbitrary()?, slave: input.arbitrary()? },
    })
}
