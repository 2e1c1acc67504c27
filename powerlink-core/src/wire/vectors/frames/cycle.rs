//! SoC, SoA, PReq and PRes.

use std::vec::Vec;

use super::super::super::*;
use super::{CN, MN, OLD_MN, Vector, frame};
use crate::ethernet::group;
use crate::{MacAddress, NodeId};

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
    ]
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
