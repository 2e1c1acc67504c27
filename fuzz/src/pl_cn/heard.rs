//! What a frame is to the node, read a second time: by offsets from the tables, without the types of the core.

use powerlink_core::nmt::Cause;

use super::device::{MAC, NODE};

/// What a frame is to the node.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Heard {
    Soc,
    /// For the node, of the managing node: flags, Size, and the process data that the frame has room for.
    Preq {
        flags: u8,
        size: usize,
        room: usize,
    },
    Pres,
    Soa {
        service: u8,
        is_own: bool,
        flags: u8,
    },
    /// An NMT command that controlled nodes follow, for this one.
    Command(Cause),
    /// Another NMT command for this node.
    Ignored,
    /// SDO for the node: the client, and the transaction if there is room for one.
    Sdo {
        from: u8,
        transaction: Option<u8>,
    },
    /// What only the managing node sends, of another node.
    Foreign,
    /// Nothing that the node acts upon.
    Nothing,
}

pub(super) fn read(bytes: &[u8]) -> Heard {
    let is_powerlink = bytes.get(12..14) == Some(&[0x88, 0xAB]) && bytes.len() >= 17;
    if !is_powerlink || bytes[6..12] == MAC.0 {
        return Heard::Nothing;
    }
    let at = |offset: usize| bytes.get(offset).copied();
    let is_at = |group: u8| bytes[..6] == [0x01, 0x11, 0x1E, 0, 0, group];
    let (is_own, to_own) = (bytes[..6] == MAC.0, bytes[15] == NODE.0);
    let of_mn = |heard| if bytes[16] == 240 { heard } else { Heard::Foreign };
    match bytes[14] & 0x7F {
        0x01 if is_at(1) && bytes.len() >= 36 => of_mn(Heard::Soc),
        0x03 if is_own && to_own && bytes.len() >= 24 => {
            of_mn(Heard::Preq { flags: bytes[18], size: word(bytes, 22), room: bytes.len() - 24 })
        }
        0x04 if is_at(2) && bytes.len() >= 24 && word(bytes, 22) <= bytes.len() - 24 => Heard::Pres,
        0x05 if is_at(3) && bytes.len() >= 23 => {
            of_mn(Heard::Soa { service: bytes[20], is_own: bytes[21] == NODE.0, flags: bytes[18] })
        }
        0x06 if is_at(4) || is_own || bytes[..6] == [0xFF; 6] => match at(17) {
            Some(0x04) if (to_own || bytes[15] == 255) && bytes.len() >= 20 => {
                command(bytes[18], &bytes[20..]).map_or(Heard::Nothing, of_mn)
            }
            Some(0x05) if to_own => Heard::Sdo { from: bytes[16], transaction: at(23) },
            _ => Heard::Nothing,
        },
        _ => Heard::Nothing,
    }
}

/// A command for the node, whether it follows it or not.
fn command(id: u8, data: &[u8]) -> Option<Heard> {
    let plain = match id {
        0x41..=0x44 | 0x48..=0x4B => {
            let (place, bit) = (usize::from(NODE.0 / 8), NODE.0 % 8);
            if data.get(place).is_none_or(|byte| byte >> bit & 1 == 0) {
                return None;
            }
            id - 0x20
        }
        _ => id,
    };
    let cause = match plain {
        0x21 => Cause::StartNode,
        0x22 => Cause::StopNode,
        0x23 => Cause::EnterPreOperational2,
        0x24 => Cause::EnableReadyToOperate,
        0x28 => Cause::ResetNode,
        0x29 => Cause::ResetCommunication,
        0x2A => Cause::ResetConfiguration,
        0x2B => Cause::SwReset,
        _ => return Some(Heard::Ignored),
    };
    Some(Heard::Command(cause))
}

fn word(bytes: &[u8], at: usize) -> usize {
    usize::from(u16::from_le_bytes([bytes[at], bytes[at + 1]]))
}
