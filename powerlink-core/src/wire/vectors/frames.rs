//! The golden frames: fields, words, and bytes as a raw socket sees them. Where nothing else is said, they were recorded from
//! openPOWERLINK 2.7.2.

use std::vec::Vec;

use super::super::*;
use crate::ethernet::group;
use crate::{MacAddress, NodeId};

pub(super) struct Vector {
    pub(super) frame: Frame<'static>,
    pub(super) words: &'static str,
    /// As a raw socket sees them.
    pub(super) bytes: &'static str,
}

pub(super) fn vectors() -> Vec<Vector> {
    std::vec![
        // SoC, MC=0, PS=0, NetTime set, RelativeTime 0, unpadded (36 bytes).
        Vector {
            frame: frame(
                group::SOC,
                MN,
                NodeId(255),
                NodeId(240),
                Body::Soc(Soc {
                    flags: Flags::empty(),
                    net_time: NetTime { seconds: 0x6B02_4858, nanoseconds: 0x105B_B7FD },
                    relative_time: 0
                })
            ),
            words: "MN -> all: SoC, net time 1795311704.274446333, relative 0 us",
            bytes: "01111e0000010200000000f088ab01fff00000005848026bfdb75b100000000000000000",
        },
        // SoC, all zero times, unpadded. Network of 2016.
        Vector {
            frame: frame(
                group::SOC,
                OLD_MN,
                NodeId(255),
                NodeId(240),
                Body::Soc(Soc {
                    flags: Flags::empty(),
                    net_time: NetTime { seconds: 0, nanoseconds: 0 },
                    relative_time: 0
                })
            ),
            words: "MN -> all: SoC, net time 0.000000000, relative 0 us",
            bytes: "01111e000001ec086b1c248188ab01fff000000000000000000000000000000000000000",
        },
        // SoA, MN PREOP1, NoService, unpadded (54 bytes).
        Vector {
            frame: frame(
                group::SOA,
                MN,
                NodeId(255),
                NodeId(240),
                soa(
                    NmtStateCode::PRE_OPERATIONAL_1,
                    Flags::empty(),
                    RequestedService::NO_SERVICE,
                    NodeId::NONE
                )
            ),
            words: "MN -> all: SoA, NMT_PRE_OPERATIONAL_1, NoService",
            bytes: "01111e0000030200000000f088ab05fff01d000000002000000000000000000000000000000000000000000000000000000000000000",
        },
        // SoA, MN PREOP1, IdentRequest for 1.
        Vector {
            frame: frame(
                group::SOA,
                MN,
                NodeId(255),
                NodeId(240),
                soa(
                    NmtStateCode::PRE_OPERATIONAL_1,
                    Flags::empty(),
                    RequestedService::IDENT_REQUEST,
                    NodeId(1)
                )
            ),
            words: "MN -> all: SoA, NMT_PRE_OPERATIONAL_1, IdentRequest for node 1, EA=0 ER=0",
            bytes: "01111e0000030200000000f088ab05fff01d000001012000000000000000000000000000000000000000000000000000000000000000",
        },
        // SoA, MN OP, UnspecifiedInvite for 240 (MN sends next).
        Vector {
            frame: frame(
                group::SOA,
                MN,
                NodeId(255),
                NodeId(240),
                soa(
                    NmtStateCode::OPERATIONAL,
                    Flags::empty(),
                    RequestedService::UNSPECIFIED_INVITE,
                    NodeId(240)
                )
            ),
            words: "MN -> all: SoA, NMT_OPERATIONAL, UnspecifiedInvite for MN, EA=0 ER=0",
            bytes: "01111e0000030200000000f088ab05fff0fd0000fff02000000000000000000000000000000000000000000000000000000000000000",
        },
        // SoA, MN PREOP1, StatusRequest for 1, ER=1. Network of 2016.
        Vector {
            frame: frame(
                group::SOA,
                OLD_MN,
                NodeId(255),
                NodeId(240),
                soa(
                    NmtStateCode::PRE_OPERATIONAL_1,
                    Flags::EXCEPTION_RESET,
                    RequestedService::STATUS_REQUEST,
                    NodeId(1)
                )
            ),
            words: "MN -> all: SoA, NMT_PRE_OPERATIONAL_1, StatusRequest for node 1, EA=0 ER=1",
            bytes: "01111e000003ec086b1c248188ab05fff01d020002012000000000000000000000000000000000000000000000000000000000000000",
        },
        // PReq to 1, RD=1, Size 1, data 0x20.
        Vector {
            frame: frame(CN, MN, NodeId(1), NodeId(240), preq(Flags::DATA_VALID, &[0x20])),
            words: "MN -> node 1: PReq, EA=0 RD=1, 1 byte",
            bytes: "0200000000010200000000f088ab0301f000010000000100200000000000000000000000000000000000000000000000000000000000000000000000",
        },
        // PReq to 2, RD=0, Size 10. Network of 2016.
        Vector {
            frame: frame(
                MacAddress([0, 0, 0, 0xBE, 0xEF, 2]),
                OLD_MN,
                NodeId(2),
                NodeId(240),
                preq(Flags::empty(), &[0; 10])
            ),
            words: "MN -> node 2: PReq, EA=0 RD=0, 10 bytes",
            bytes: "000000beef02ec086b1c248188ab0302f000000000000a00000000000000000000000000000000000000000000000000000000000000000000000000",
        },
        // PRes of 1, PREOP2, RD=0, Size 0.
        Vector {
            frame: frame(
                group::PRES,
                CN,
                NodeId(255),
                NodeId(1),
                pres(NmtStateCode::PRE_OPERATIONAL_2, Flags::empty(), 0x00, &[])
            ),
            words: "node 1 -> all: PRes, NMT_PRE_OPERATIONAL_2, EN=0 RD=0, PR=0 RS=0, 0 bytes",
            bytes: "01111e00000202000000000188ab04ff015d000000000000000000000000000000000000000000000000000000000000000000000000000000000000",
        },
        // PRes of 1, OP, RD=1, Size 1.
        Vector {
            frame: frame(
                group::PRES,
                CN,
                NodeId(255),
                NodeId(1),
                pres(NmtStateCode::OPERATIONAL, Flags::DATA_VALID, 0x00, &[0x01])
            ),
            words: "node 1 -> all: PRes, NMT_OPERATIONAL, EN=0 RD=1, PR=0 RS=0, 1 byte",
            bytes: "01111e00000202000000000188ab04ff01fd010000000100010000000000000000000000000000000000000000000000000000000000000000000000",
        },
        // PRes of 1, PREOP2, PR=3, RS=1, Size 0.
        Vector {
            frame: frame(
                group::PRES,
                CN,
                NodeId(255),
                NodeId(1),
                pres(NmtStateCode::PRE_OPERATIONAL_2, Flags::empty(), 0x19, &[])
            ),
            words: "node 1 -> all: PRes, NMT_PRE_OPERATIONAL_2, EN=0 RD=0, PR=3 RS=1, 0 bytes",
            bytes: "01111e00000202000000000188ab04ff015d001900000000000000000000000000000000000000000000000000000000000000000000000000000000",
        },
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

const fn frame(
    destination: MacAddress,
    source: MacAddress,
    to: NodeId,
    from: NodeId,
    body: Body<'static>,
) -> Frame<'static> {
    Frame { destination, source, to, from, body }
}

const fn soa(state: NmtStateCode, flags: Flags, service: RequestedService, target: NodeId) -> Body<'static> {
    Body::Soa(Soa { state, flags, service, target, version: 0x20 })
}

const fn preq(flags: Flags, data: &'static [u8]) -> Body<'static> {
    Body::Preq(Preq { flags, pdo_version: PdoVersion(0), data })
}

const fn pres(state: NmtStateCode, flags: Flags, request: u8, data: &'static [u8]) -> Body<'static> {
    Body::Pres(Pres { state, flags, request: AsyncRequest(request), pdo_version: PdoVersion(0), data })
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

const MN: MacAddress = MacAddress([2, 0, 0, 0, 0, 0xF0]);
const CN: MacAddress = MacAddress([2, 0, 0, 0, 0, 1]);
const OLD_MN: MacAddress = MacAddress([0xEC, 0x08, 0x6B, 0x1C, 0x24, 0x81]);
const OLD_CN: MacAddress = MacAddress([0, 0, 0, 0xBE, 0xEF, 1]);
