//! The golden frames: fields, words, and bytes as a raw socket sees them. Where nothing else is said, they were recorded from
//! openPOWERLINK 2.7.2.

mod asnd;
mod cycle;
mod sdo;

use std::vec::Vec;

use super::super::*;
use crate::{MacAddress, NodeId};

pub(super) struct Vector {
    pub(super) frame: Frame<'static>,
    pub(super) words: &'static str,
    /// As a raw socket sees them.
    pub(super) bytes: &'static str,
}

pub(super) fn vectors() -> Vec<Vector> {
    [cycle::vectors(), asnd::vectors(), sdo::vectors()].into_iter().flatten().collect()
}

const fn frame(
    destination: MacAddress,
    source: MacAddress,
    to: NodeId,
    from: NodeId,
    body: Body<'static>,
) -> Frame<'static> {
    Frame { destination, source, to, from, body }
}

const MN: MacAddress = MacAddress([2, 0, 0, 0, 0, 0xF0]);
const CN: MacAddress = MacAddress([2, 0, 0, 0, 0, 1]);
const OLD_MN: MacAddress = MacAddress([0xEC, 0x08, 0x6B, 0x1C, 0x24, 0x81]);
const OLD_CN: MacAddress = MacAddress([0, 0, 0, 0xBE, 0xEF, 1]);
