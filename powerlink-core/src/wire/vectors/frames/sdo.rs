//! ASnd: SDO.

use std::vec::Vec;

use super::super::super::*;
use super::{CN, MN, Vector, frame};
use crate::NodeId;
use crate::ethernet::group;

pub(super) fn vectors() -> Vec<Vector> {
    std::vec![
        // SDO InitReq of the client.
        Vector {
            frame: frame(
                group::ASND,
                MN,
                NodeId(1),
                NodeId(240),
                sdo((0, Con::None), (0, Con::Initialisation), None)
            ),
            words: "MN -> node 1: SDO, rcon=0/0 scon=1/0",
            bytes: "01111e0000040200000000f088ab0601f005000100000000000000000000000000000000000000000000000000000000000000000000000000000000",
        },
        // SDO InitResp of the client.
        Vector {
            frame: frame(
                group::ASND,
                MN,
                NodeId(1),
                NodeId(240),
                sdo((0, Con::Initialisation), (0, Con::Valid), None)
            ),
            words: "MN -> node 1: SDO, rcon=1/0 scon=2/0",
            bytes: "01111e0000040200000000f088ab0601f005010200000000000000000000000000000000000000000000000000000000000000000000000000000000",
        },
        // SDO WriteByIndex 0x1006/0 = 50000, SegmentSize 8, TID 3.
        Vector {
            frame: frame(
                group::ASND,
                MN,
                NodeId(1),
                NodeId(240),
                sdo(
                    (3, Con::Valid),
                    (4, Con::Valid),
                    Some(SdoCommand::request(3, SdoCommandId(0x01), &[0x06, 0x10, 0, 0, 0x50, 0xC3, 0, 0]))
                )
            ),
            words: "MN -> node 1: SDO, rcon=2/3 scon=2/4, WriteByIndex, transaction 3, 8 bytes",
            bytes: "01111e0000040200000000f088ab0601f0050e12000000030001080000000610000050c3000000000000000000000000000000000000000000000000",
        },
        // SDO WriteByIndex response, TID 3.
        Vector {
            frame: frame(
                group::ASND,
                CN,
                NodeId(240),
                NodeId(1),
                sdo((4, Con::Valid), (4, Con::Valid), Some(response(3, 0x01, &[])))
            ),
            words: "node 1 -> MN: SDO, rcon=2/4 scon=2/4, WriteByIndex response, transaction 3, 0 bytes",
            bytes: "01111e00000402000000000188ab06f00105121200000003800100000000000000000000000000000000000000000000000000000000000000000000",
        },
        // SDO ReadByIndex 0x1018/0 request, TID 3.
        Vector {
            frame: frame(
                group::ASND,
                MN,
                NodeId(1),
                NodeId(240),
                sdo(
                    (2, Con::Valid),
                    (3, Con::Valid),
                    Some(SdoCommand::request(3, SdoCommandId(0x02), &[0x18, 0x10, 0, 0]))
                )
            ),
            words: "MN -> node 1: SDO, rcon=2/2 scon=2/3, ReadByIndex, transaction 3, 4 bytes",
            bytes: "01111e0000040200000000f088ab0601f0050a0e00000003000204000000181000000000000000000000000000000000000000000000000000000000",
        },
        // SDO ReadByIndex response, u8 value 4.
        Vector {
            frame: frame(
                group::ASND,
                CN,
                NodeId(240),
                NodeId(1),
                sdo((3, Con::Valid), (3, Con::Valid), Some(response(3, 0x02, &[4])))
            ),
            words: "node 1 -> MN: SDO, rcon=2/3 scon=2/3, ReadByIndex response, transaction 3, 1 byte",
            bytes: "01111e00000402000000000188ab06f001050e0e00000003800201000000040000000000000000000000000000000000000000000000000000000000",
        },
        // SDO abort 0x06020000 (read of 0x2FFF/0), TID 8.
        Vector {
            frame: frame(
                group::ASND,
                CN,
                NodeId(240),
                NodeId(1),
                sdo((8, Con::Valid), (8, Con::Valid), Some(abort(8, 0x02, &[0x00, 0x00, 0x02, 0x06])))
            ),
            words: "node 1 -> MN: SDO, rcon=2/8 scon=2/8, ReadByIndex response, transaction 8, abort: object does not exist",
            bytes: "01111e00000402000000000188ab06f00105222200000008c00204000000000002060000000000000000000000000000000000000000000000000000",
        },
        // SDO abort 0x06090011 (read of 0x1018/9), TID 9.
        Vector {
            frame: frame(
                group::ASND,
                CN,
                NodeId(240),
                NodeId(1),
                sdo((9, Con::Valid), (9, Con::Valid), Some(abort(9, 0x02, &[0x11, 0x00, 0x09, 0x06])))
            ),
            words: "node 1 -> MN: SDO, rcon=2/9 scon=2/9, ReadByIndex response, transaction 9, abort: sub-index does not exist",
            bytes: "01111e00000402000000000188ab06f00105262600000009c00204000000110009060000000000000000000000000000000000000000000000000000",
        },
        // SDO acknowledge by the client, no command.
        Vector {
            frame: frame(
                group::ASND,
                MN,
                NodeId(1),
                NodeId(240),
                sdo((1, Con::Valid), (1, Con::Valid), None)
            ),
            words: "MN -> node 1: SDO, rcon=2/1 scon=2/1",
            bytes: "01111e0000040200000000f088ab0601f005060600000000000000000000000000000000000000000000000000000000000000000000000000000000",
        },
        // SDO abort 0x06070010 (2 bytes written to u32 0x1F99), TID 11.
        Vector {
            frame: frame(
                group::ASND,
                CN,
                NodeId(240),
                NodeId(1),
                sdo((11, Con::Valid), (11, Con::Valid), Some(abort(11, 0x01, &[0x10, 0x00, 0x07, 0x06])))
            ),
            words: "node 1 -> MN: SDO, rcon=2/11 scon=2/11, WriteByIndex response, transaction 11, abort: length does not match",
            bytes: "01111e00000402000000000188ab06f001052e2e0000000bc00104000000100007060000000000000000000000000000000000000000000000000000",
        },
        // SDO abort 0x05040001 (answer to CommandID 0x55), TID 15.
        Vector {
            frame: frame(
                group::ASND,
                CN,
                NodeId(240),
                NodeId(1),
                sdo((15, Con::Valid), (15, Con::Valid), Some(abort(15, 0x01, &[0x01, 0x00, 0x04, 0x05])))
            ),
            words: "node 1 -> MN: SDO, rcon=2/15 scon=2/15, WriteByIndex response, transaction 15, abort: unknown command",
            bytes: "01111e00000402000000000188ab06f001053e3e0000000fc00104000000010004050000000000000000000000000000000000000000000000000000",
        },
    ]
}

const fn sdo(receive: (u8, Con), send: (u8, Con), command: Option<SdoCommand<'static>>) -> Body<'static> {
    let (receive, send) = (SequenceHalf::new(receive.0, receive.1), SequenceHalf::new(send.0, send.1));
    Body::Sdo(Sdo { sequence: SdoSequence { receive, send }, command })
}

const fn response(transaction: u8, command: u8, data: &'static [u8]) -> SdoCommand<'static> {
    SdoCommand { is_response: true, ..SdoCommand::request(transaction, SdoCommandId(command), data) }
}

const fn abort(transaction: u8, command: u8, code: &'static [u8]) -> SdoCommand<'static> {
    SdoCommand { is_abort: true, ..response(transaction, command, code) }
}
