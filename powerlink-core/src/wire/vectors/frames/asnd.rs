//! ASnd: IdentResponse, StatusResponse and NMT commands.

use std::vec::Vec;

use super::super::super::*;
use super::{CN, MN, OLD_CN, OLD_MN, Vector, frame};
use crate::NodeId;
use crate::ethernet::group;

pub(super) fn vectors() -> Vec<Vector> {
    std::vec![
        // IdentResponse of 1 in PREOP2, features 0x00010265, MTU 1500, limits 36/36, response time 50000 ns, type 0x000F0191, revision 0x00020007, date/time 0.
        Vector {
            frame: frame(
                group::ASND,
                CN,
                NodeId(255),
                NodeId(1),
                ident(NmtStateCode::PRE_OPERATIONAL_2, 0x0002_0007)
            ),
            words: "node 1 -> all: IdentResponse, NMT_PRE_OPERATIONAL_2, vendor 0x00000000, product 0x00000000, revision 2.7, PR=0 RS=0",
            bytes: "01111e00000402000000000188ab06ff010100005d00200065020100dc052400240050c30000000091010f00000000000000000007000200000000000000000000000000000000000000000000000000000000000164a8c000fffffffe64a8c030312d6666666666666666000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000",
        },
        // IdentResponse of 1 in PREOP1, other device (revision 0x00020004), MAC 00:00:00:be:ef:01. Network of 2016.
        Vector {
            frame: frame(
                group::ASND,
                OLD_CN,
                NodeId(255),
                NodeId(1),
                ident(NmtStateCode::PRE_OPERATIONAL_1, 0x0002_0004)
            ),
            words: "node 1 -> all: IdentResponse, NMT_PRE_OPERATIONAL_1, vendor 0x00000000, product 0x00000000, revision 2.4, PR=0 RS=0",
            bytes: "01111e000004000000beef0188ab06ff010100001d00200065020100dc052400240050c30000000091010f00000000000000000004000200000000000000000000000000000000000000000000000000000000000164a8c000fffffffe64a8c030312d6666666666666666000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000",
        },
        // StatusResponse of 1, PREOP2, EC=1, EN=0, nothing waiting.
        Vector {
            frame: frame(
                group::ASND,
                CN,
                NodeId(255),
                NodeId(1),
                status(NmtStateCode::PRE_OPERATIONAL_2, Flags::EXCEPTION_CLEAR)
            ),
            words: "node 1 -> all: StatusResponse, NMT_PRE_OPERATIONAL_2, EC=1 EN=0, PR=0 RS=0",
            bytes: "01111e00000402000000000188ab06ff010208005d000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000",
        },
        // StatusResponse of 1, OP, EC=0, EN=0.
        Vector {
            frame: frame(
                group::ASND,
                CN,
                NodeId(255),
                NodeId(1),
                status(NmtStateCode::OPERATIONAL, Flags::empty())
            ),
            words: "node 1 -> all: StatusResponse, NMT_OPERATIONAL, EC=0 EN=0, PR=0 RS=0",
            bytes: "01111e00000402000000000188ab06ff01020000fd000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000",
        },
        // StatusResponse of 1, PREOP1, EC=1. Network of 2016.
        Vector {
            frame: frame(
                group::ASND,
                OLD_CN,
                NodeId(255),
                NodeId(1),
                status(NmtStateCode::PRE_OPERATIONAL_1, Flags::EXCEPTION_CLEAR)
            ),
            words: "node 1 -> all: StatusResponse, NMT_PRE_OPERATIONAL_1, EC=1 EN=0, PR=0 RS=0",
            bytes: "01111e000004000000beef0188ab06ff010208001d000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000",
        },
        // NMTResetNode to 255 (broadcast).
        Vector {
            frame: frame(group::ASND, MN, NodeId(255), NodeId(240), command(0x28, [0x00, 0x00])),
            words: "MN -> all: NMTResetNode",
            bytes: "01111e0000040200000000f088ab06fff004280000000000000000000000000000000000000000000000000000000000000000000000000000000000",
        },
        // NMTStartNode to 1.
        Vector {
            frame: frame(group::ASND, MN, NodeId(1), NodeId(240), command(0x21, [0x00, 0x00])),
            words: "MN -> node 1: NMTStartNode",
            bytes: "01111e0000040200000000f088ab0601f004210000000000000000000000000000000000000000000000000000000000000000000000000000000000",
        },
        // NMTResetNode to 1, reason 0x8243. Network of 2016.
        Vector {
            frame: frame(group::ASND, OLD_MN, NodeId(1), NodeId(240), command(0x28, [0x43, 0x82])),
            words: "MN -> node 1: NMTResetNode, reason: loss of PRes threshold",
            bytes: "01111e000004ec086b1c248188ab0601f004280043820000000000000000000000000000000000000000000000000000000000000000000000000000",
        },
        // NMTStartNodeEx, broadcast, node list {2}; ignored by node 1.
        Vector {
            frame: frame(group::ASND, MN, NodeId(255), NodeId(240), command(0x41, [0x04, 0x00])),
            words: "MN -> all: NMTStartNodeEx",
            bytes: "01111e0000040200000000f088ab06fff004410004000000000000000000000000000000000000000000000000000000000000000000000000000000",
        },
    ]
}

/// The demo node of openPOWERLINK, CiA 401, in two of its revisions.
fn ident(state: NmtStateCode, revision: u32) -> Body<'static> {
    let mut host_name = [0; 32];
    host_name[..11].copy_from_slice(b"01-ffffffff");
    Body::IdentResponse(IdentResponse {
        flags: Flags::empty(),
        request: AsyncRequest::NONE,
        state,
        version: 0x20,
        features: FeatureFlags::from_bits_retain(0x0001_0265),
        mtu: 1500,
        poll_in_size: 36,
        poll_out_size: 36,
        response_time: 50_000,
        device_type: 0x000F_0191,
        identity: Identity { vendor_id: 0, product_code: 0, revision, serial_number: 0 },
        vendor_extension_1: 0,
        configuration: ConfigurationStamp { date: 0, time: 0 },
        software: ConfigurationStamp { date: 0, time: 0 },
        ip: IpParameters {
            address: [192, 168, 100, 1].into(),
            subnet_mask: [255, 255, 255, 0].into(),
            gateway: [192, 168, 100, 254].into(),
        },
        host_name,
        vendor_extension_2: [0; 48],
    })
}

/// Two unused entries.
fn status(state: NmtStateCode, flags: Flags) -> Body<'static> {
    let entries = [ErrorEntry::default(); 2].into_iter().collect();
    Body::StatusResponse(StatusResponse {
        flags,
        request: AsyncRequest::NONE,
        state,
        static_errors: [0; 8],
        entries,
    })
}

/// The first two bytes of the command data; nothing tells the rest from padding.
fn command(command: u8, [first, second]: [u8; 2]) -> Body<'static> {
    let mut data = std::vec![0; MAX_COMMAND_DATA];
    (data[0], data[1]) = (first, second);
    Body::NmtCommand(NmtCommand { command: NmtCommandId(command), data: data.leak() })
}
