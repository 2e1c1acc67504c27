//! Golden frames: recorded from openPOWERLINK 2.7.2 (managing node 240, controlled node 1, on a virtual link), taken from
//! the example capture of powerlink_analyzer (a network of 2016), or made after the specification.
//!
//! If one of these fails, the code is wrong: they are never changed to what it says.

use std::string::ToString;
use std::vec::Vec;

use super::*;
use crate::ethernet::MIN_FRAME;

/// What a frame is in words, and its bytes as a raw socket sees them.
const FRAMES: &[(&str, &str)] = &[
    // SoC, MC=0, PS=0, NetTime set, RelativeTime 0, unpadded (36 bytes) (openPOWERLINK)
    (
        "MN -> all: SoC, net time 1795311704.274446333, relative 0 us",
        "01111e0000010200000000f088ab01fff00000005848026bfdb75b100000000000000000",
    ),
    // SoC, all zero times, unpadded (openPOWERLINK)
    (
        "MN -> all: SoC, net time 0.000000000, relative 0 us",
        "01111e000001ec086b1c248188ab01fff000000000000000000000000000000000000000",
    ),
    // SoA, MN PREOP1, NoService, unpadded (54 bytes) (openPOWERLINK)
    (
        "MN -> all: SoA, NMT_PRE_OPERATIONAL_1, NoService",
        "01111e0000030200000000f088ab05fff01d000000002000000000000000000000000000000000000000000000000000000000000000",
    ),
    // SoA, MN PREOP1, IdentRequest for 1 (openPOWERLINK)
    (
        "MN -> all: SoA, NMT_PRE_OPERATIONAL_1, IdentRequest for node 1, EA=0 ER=0",
        "01111e0000030200000000f088ab05fff01d000001012000000000000000000000000000000000000000000000000000000000000000",
    ),
    // SoA, MN OP, UnspecifiedInvite for 240 (MN sends next) (openPOWERLINK)
    (
        "MN -> all: SoA, NMT_OPERATIONAL, UnspecifiedInvite for MN, EA=0 ER=0",
        "01111e0000030200000000f088ab05fff0fd0000fff02000000000000000000000000000000000000000000000000000000000000000",
    ),
    // SoA, MN PREOP1, StatusRequest for 1, ER=1 (openPOWERLINK)
    (
        "MN -> all: SoA, NMT_PRE_OPERATIONAL_1, StatusRequest for node 1, EA=0 ER=1",
        "01111e000003ec086b1c248188ab05fff01d020002012000000000000000000000000000000000000000000000000000000000000000",
    ),
    // PReq to 1, RD=1, Size 1, data 20  (openPOWERLINK)
    (
        "MN -> node 1: PReq, EA=0 RD=1, 1 bytes",
        "0200000000010200000000f088ab0301f000010000000100200000000000000000000000000000000000000000000000000000000000000000000000",
    ),
    // PReq to 2, RD=0, Size 10 (openPOWERLINK)
    (
        "MN -> node 2: PReq, EA=0 RD=0, 10 bytes",
        "000000beef02ec086b1c248188ab0302f000000000000a00000000000000000000000000000000000000000000000000000000000000000000000000",
    ),
    // PRes of 1, PREOP2, RD=0, Size 0 (openPOWERLINK)
    (
        "node 1 -> all: PRes, NMT_PRE_OPERATIONAL_2, EN=0 RD=0, PR=0 RS=0, 0 bytes",
        "01111e00000202000000000188ab04ff015d000000000000000000000000000000000000000000000000000000000000000000000000000000000000",
    ),
    // PRes of 1, OP, RD=1, Size 1 (openPOWERLINK)
    (
        "node 1 -> all: PRes, NMT_OPERATIONAL, EN=0 RD=1, PR=0 RS=0, 1 bytes",
        "01111e00000202000000000188ab04ff01fd010000000100010000000000000000000000000000000000000000000000000000000000000000000000",
    ),
    // PRes of 1, PREOP2, PR=3, RS=1, Size 0 (openPOWERLINK)
    (
        "node 1 -> all: PRes, NMT_PRE_OPERATIONAL_2, EN=0 RD=0, PR=3 RS=1, 0 bytes",
        "01111e00000202000000000188ab04ff015d001900000000000000000000000000000000000000000000000000000000000000000000000000000000",
    ),
    // IdentResponse of 1 in PREOP2, features 0x00010265, MTU 1500, limits 36/36, response time 50000 ns, type 0x000F0191, revision 0x00020007, date/time 0 (openPOWERLINK)
    (
        "node 1 -> all: IdentResponse, NMT_PRE_OPERATIONAL_2, vendor 0x00000000, product 0x00000000, revision 0x00020007, PR=0 RS=0",
        "01111e00000402000000000188ab06ff010100005d00200065020100dc052400240050c30000000091010f00000000000000000007000200000000000000000000000000000000000000000000000000000000000164a8c000fffffffe64a8c030312d6666666666666666000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000",
    ),
    // IdentResponse of 1 in PREOP1, other device (revision 0x00020004), MAC 00:00:00:be:ef:01 (openPOWERLINK)
    (
        "node 1 -> all: IdentResponse, NMT_PRE_OPERATIONAL_1, vendor 0x00000000, product 0x00000000, revision 0x00020004, PR=0 RS=0",
        "01111e000004000000beef0188ab06ff010100001d00200065020100dc052400240050c30000000091010f00000000000000000004000200000000000000000000000000000000000000000000000000000000000164a8c000fffffffe64a8c030312d6666666666666666000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000",
    ),
    // StatusResponse of 1, PREOP2, EC=1, EN=0, nothing waiting (openPOWERLINK)
    (
        "node 1 -> all: StatusResponse, NMT_PRE_OPERATIONAL_2, EC=1 EN=0, PR=0 RS=0",
        "01111e00000402000000000188ab06ff010208005d000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000",
    ),
    // StatusResponse of 1, OP, EC=0, EN=0 (openPOWERLINK)
    (
        "node 1 -> all: StatusResponse, NMT_OPERATIONAL, EC=0 EN=0, PR=0 RS=0",
        "01111e00000402000000000188ab06ff01020000fd000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000",
    ),
    // StatusResponse of 1, PREOP1, EC=1 (openPOWERLINK)
    (
        "node 1 -> all: StatusResponse, NMT_PRE_OPERATIONAL_1, EC=1 EN=0, PR=0 RS=0",
        "01111e000004000000beef0188ab06ff010208001d000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000",
    ),
    // NMTResetNode to 255 (broadcast) (openPOWERLINK)
    (
        "MN -> all: NMTResetNode",
        "01111e0000040200000000f088ab06fff004280000000000000000000000000000000000000000000000000000000000000000000000000000000000",
    ),
    // NMTStartNode to 1 (openPOWERLINK)
    (
        "MN -> node 1: NMTStartNode",
        "01111e0000040200000000f088ab0601f004210000000000000000000000000000000000000000000000000000000000000000000000000000000000",
    ),
    // NMTResetNode to 1, reason 0x8243 (openPOWERLINK)
    (
        "MN -> node 1: NMTResetNode, reason: loss of PRes threshold",
        "01111e000004ec086b1c248188ab0601f004280043820000000000000000000000000000000000000000000000000000000000000000000000000000",
    ),
    // NMTStartNodeEx, broadcast, node list {2}; ignored by node 1 (openPOWERLINK)
    (
        "MN -> all: NMTStartNodeEx",
        "01111e0000040200000000f088ab06fff004410004000000000000000000000000000000000000000000000000000000000000000000000000000000",
    ),
    // SDO InitReq of the client (openPOWERLINK)
    (
        "MN -> node 1: SDO, rcon=0/0 scon=1/0",
        "01111e0000040200000000f088ab0601f005000100000000000000000000000000000000000000000000000000000000000000000000000000000000",
    ),
    // SDO InitResp of the client (openPOWERLINK)
    (
        "MN -> node 1: SDO, rcon=1/0 scon=2/0",
        "01111e0000040200000000f088ab0601f005010200000000000000000000000000000000000000000000000000000000000000000000000000000000",
    ),
    // SDO WriteByIndex 0x1006/0 = 50000, SegmentSize 8, TID 3 (openPOWERLINK)
    (
        "MN -> node 1: SDO, rcon=2/3 scon=2/4, WriteByIndex, transaction 3, 8 bytes",
        "01111e0000040200000000f088ab0601f0050e12000000030001080000000610000050c3000000000000000000000000000000000000000000000000",
    ),
    // SDO WriteByIndex response, TID 3 (openPOWERLINK)
    (
        "node 1 -> MN: SDO, rcon=2/4 scon=2/4, WriteByIndex response, transaction 3, 0 bytes",
        "01111e00000402000000000188ab06f00105121200000003800100000000000000000000000000000000000000000000000000000000000000000000",
    ),
    // SDO ReadByIndex 0x1018/0 request, TID 3 (openPOWERLINK)
    (
        "MN -> node 1: SDO, rcon=2/2 scon=2/3, ReadByIndex, transaction 3, 4 bytes",
        "01111e0000040200000000f088ab0601f0050a0e00000003000204000000181000000000000000000000000000000000000000000000000000000000",
    ),
    // SDO ReadByIndex response, u8 value 4 (openPOWERLINK)
    (
        "node 1 -> MN: SDO, rcon=2/3 scon=2/3, ReadByIndex response, transaction 3, 1 bytes",
        "01111e00000402000000000188ab06f001050e0e00000003800201000000040000000000000000000000000000000000000000000000000000000000",
    ),
    // SDO abort 0x06020000 (read of 0x2FFF/0), TID 8 (openPOWERLINK)
    (
        "node 1 -> MN: SDO, rcon=2/8 scon=2/8, ReadByIndex response, transaction 8, abort: object does not exist",
        "01111e00000402000000000188ab06f00105222200000008c00204000000000002060000000000000000000000000000000000000000000000000000",
    ),
    // SDO abort 0x06090011 (read of 0x1018/9), TID 9 (openPOWERLINK)
    (
        "node 1 -> MN: SDO, rcon=2/9 scon=2/9, ReadByIndex response, transaction 9, abort: sub-index does not exist",
        "01111e00000402000000000188ab06f00105262600000009c00204000000110009060000000000000000000000000000000000000000000000000000",
    ),
    // SDO acknowledge by the client, no command (openPOWERLINK)
    (
        "MN -> node 1: SDO, rcon=2/1 scon=2/1",
        "01111e0000040200000000f088ab0601f005060600000000000000000000000000000000000000000000000000000000000000000000000000000000",
    ),
    // SDO abort 0x06070010 (2 bytes written to u32 0x1F99), TID 11 (openPOWERLINK)
    (
        "node 1 -> MN: SDO, rcon=2/11 scon=2/11, WriteByIndex response, transaction 11, abort: length does not match",
        "01111e00000402000000000188ab06f001052e2e0000000bc00104000000100007060000000000000000000000000000000000000000000000000000",
    ),
    // SDO abort 0x05040001 (answer to CommandID 0x55), TID 15 (openPOWERLINK)
    (
        "node 1 -> MN: SDO, rcon=2/15 scon=2/15, WriteByIndex response, transaction 15, abort: unknown command",
        "01111e00000402000000000188ab06f001053e3e0000000fc00104000000010004050000000000000000000000000000000000000000000000000000",
    ),
];

fn bytes(hex: &str) -> Vec<u8> {
    hex.as_bytes()
        .chunks(2)
        .map(|pair| u8::from_str_radix(core::str::from_utf8(pair).unwrap(), 16).unwrap())
        .collect()
}

#[test]
fn golden_frames_are_read_and_written_again() {
    for (words, hex) in FRAMES {
        let given = bytes(hex);
        let frame = Frame::parse(&given).unwrap();
        assert_eq!(frame.to_string(), *words);
        let mut buffer = [0xA5; 200];
        let emitted = frame.emit(&mut buffer).unwrap();
        let mut padded = given.clone();
        padded.resize(given.len().max(MIN_FRAME), 0);
        assert_eq!(emitted, padded, "{words}");
    }
}

#[test]
fn the_ident_response_of_a_demo_node_field_by_field() {
    let (_, hex) = FRAMES.iter().find(|(words, _)| words.contains("revision 0x00020007")).unwrap();
    let given = bytes(hex);
    assert_eq!(given.len(), 176);
    let Ok(Frame { body: Body::IdentResponse(ident), .. }) = Frame::parse(&given) else {
        panic!("an IdentResponse")
    };
    let mut host_name = [0; 32];
    host_name[..11].copy_from_slice(b"01-ffffffff");
    assert_eq!(
        ident,
        IdentResponse {
            flags: Flags::empty(),
            request: AsyncRequest::NONE,
            state: NmtStateCode::PRE_OPERATIONAL_2,
            version: POWERLINK_V2,
            features: FeatureFlags::from_bits_retain(0x0001_0265),
            mtu: 1500,
            poll_in_size: 36,
            poll_out_size: 36,
            response_time: 50_000,
            device_type: 0x000F_0191,
            identity: Identity { vendor_id: 0, product_code: 0, revision: 0x0002_0007, serial_number: 0 },
            vendor_extension_1: 0,
            configuration: ConfigurationStamp { date: 0, time: 0 },
            software: ConfigurationStamp { date: 0, time: 0 },
            ip: IpParameters::of(crate::NodeId(1)),
            host_name,
            vendor_extension_2: [0; 48],
        }
    );
}

/// Frames that were made to be refused, and one that must not be.
#[test]
fn cut_frames_are_refused_and_reserved_bits_are_not() {
    let cut_in_size = bytes("0200000000010200000000f088ab0301f0000100000001");
    let error = Frame::parse(&cut_in_size).unwrap_err();
    assert_eq!(error.to_string(), "Size at offset 22: 2 bytes expected, 1 found");

    let cut_behind_the_target = bytes("01111e0000030200000000f088ab05fff01d00000101");
    assert!(Frame::parse(&cut_behind_the_target).is_err());

    let reserved_bits = bytes(
        "01111e0000030200000000f088ab05fff01d00ff01012001000000000000000000000000000000000000000000000000000000000000",
    );
    let words = Frame::parse(&reserved_bits).unwrap().to_string();
    assert_eq!(words, "MN -> all: SoA, NMT_PRE_OPERATIONAL_1, IdentRequest for node 1, EA=0 ER=0");

    let unknown = bytes("0200000000010200000000f088ab0901f000010000");
    assert_eq!(Frame::parse(&unknown).unwrap().to_string(), "MN -> node 1: message type 0x09, 4 bytes");

    let other = bytes("0200000000010200000000f00800450000");
    assert_eq!(Frame::parse(&other), Err(FrameError::OtherProtocol(0x0800)));
}
