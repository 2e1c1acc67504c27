//! What has to be there for a managing node to start a node, learned against that of openPOWERLINK 2.7.2.
//!
//! | A controlled node must | Test |
//! |---|---|
//! | answer an IdentRequest with 176 bytes, in every state from `PreOperational1` on, `Stopped` too | [`an_ident_response_has_176_bytes_in_every_state`] |
//! | answer a StatusRequest with 72 bytes or more and the right EC: a shorter one is dropped, and the node reset for ever | [`a_status_response_has_72_bytes_in_every_state_and_ec_follows_er`] |
//! | serve objects in every state: 0x1006 is written even where the configuration is the right one | [`the_cycle_length_is_written_in_every_state`] |
//! | ask for the asynchronous slot in PRes and StatusResponse (RS, PR), and send one frame when invited | [`what_waits_is_told_and_one_frame_goes_out_when_invited`] |
//! | answer a PReq in `PreOperational2`, `ReadyToOperate` and `Operational` | [`a_poll_is_answered_in_three_states`] |
//! | follow NMT commands, to itself and to all | [`commands_are_followed_from_unicast_and_broadcast`] |
//! | accept frames that nobody padded, as virtual links deliver them | [`unpadded_frames_are_accepted`] |

use super::bench::*;
use crate::NodeId;
use crate::nmt::NmtState;
use crate::node::NodeEvent;
use crate::wire::{Flags, NmtCommandId, RequestedService};

const ANSWERING: [NmtState; 5] = [
    NmtState::PreOperational1,
    NmtState::PreOperational2,
    NmtState::ReadyToOperate,
    NmtState::Operational,
    NmtState::Stopped,
];
const SILENT: [NmtState; 2] = [NmtState::NotActive, NmtState::BasicEthernet];

#[test]
fn an_ident_response_has_176_bytes_in_every_state() {
    for state in ANSWERING {
        let mut bench = Bench::in_state(state, config());
        bench.asks(RequestedService::IDENT_REQUEST);
        bench.says(&std::format!(
            "node 1 -> all: IdentResponse, {}, vendor 0x00000123, product 0x00000007, revision 0x00010000, PR=0 RS=0",
            state.code()
        ));
        assert_eq!(bench.last.len(), 176);
    }
    for state in SILENT {
        let mut bench = Bench::in_state(state, config());
        bench.asks(RequestedService::IDENT_REQUEST);
        bench.says_nothing();
        bench.is(NmtState::PreOperational1);
        bench.asks(RequestedService::IDENT_REQUEST);
        assert_eq!(bench.last.len(), 176);
    }
}

#[test]
fn a_status_response_has_72_bytes_in_every_state_and_ec_follows_er() {
    for state in ANSWERING {
        let mut bench = Bench::in_state(state, config());
        for (er, ec) in [(false, 1), (true, 1), (true, 1), (false, 0), (false, 0)] {
            if state.is_cyclic() {
                bench.soc();
                bench.preq(Flags::empty(), &[0]);
                bench.forget();
            }
            let flags = if er { Flags::EXCEPTION_RESET } else { Flags::empty() };
            bench.invite(RequestedService::STATUS_REQUEST, NODE, flags);
            bench.says(&std::format!(
                "node 1 -> all: StatusResponse, {}, EC={ec} EN=0, PR=0 RS=0",
                state.code()
            ));
            assert_eq!(bench.last.len(), 72);
        }
    }
}

#[test]
fn the_cycle_length_is_written_in_every_state() {
    for state in ANSWERING {
        let mut bench = Bench::in_state(state, config());
        assert_eq!(bench.writes(0x1006, 0, &50_000_u32.to_le_bytes()), Ok(()));
        assert_eq!(bench.reads(0x1006, 0), Ok(std::vec![0x50, 0xC3, 0, 0]));
        bench.is(state);
    }
}

#[test]
fn what_waits_is_told_and_one_frame_goes_out_when_invited() {
    let mut bench = Bench::in_state(NmtState::Operational, config());
    bench.sdo("00 01 00 00");
    bench.node.request_command(NmtCommandId::RESET_NODE, NODE).unwrap();
    bench.soc();
    bench.preq(Flags::empty(), &[1]);
    bench.says("node 1 -> all: PRes, NMT_OPERATIONAL, EN=0 RD=1, PR=7 RS=1, 1 byte");
    bench.asks(RequestedService::NMT_REQUEST_INVITE);
    bench.says("node 1 -> MN: NMTRequest, NMTResetNode for node 1");
    bench.asks(RequestedService::NMT_REQUEST_INVITE);
    bench.says_nothing();
    bench.asks(RequestedService::STATUS_REQUEST);
    bench.says("node 1 -> all: StatusResponse, NMT_OPERATIONAL, EC=1 EN=0, PR=3 RS=1");
    bench.asks(RequestedService::UNSPECIFIED_INVITE);
    bench.says("node 1 -> MN: SDO, rcon=1/0 scon=1/0");
    bench.asks(RequestedService::UNSPECIFIED_INVITE);
    bench.says_nothing();
    bench.asks(RequestedService::STATUS_REQUEST);
    bench.says("node 1 -> all: StatusResponse, NMT_OPERATIONAL, EC=1 EN=0, PR=0 RS=0");
}

#[test]
fn a_poll_is_answered_in_three_states() {
    for state in ANSWERING {
        let mut bench = Bench::in_state(state, config());
        bench.node.objects_mut().input = 0x5A;
        bench.soc();
        let polled = bench.node.state();
        bench.preq(Flags::DATA_VALID, &[0x77]);
        if !polled.answers_poll() {
            bench.says_nothing();
            continue;
        }
        let is_operational = polled == NmtState::Operational;
        let rd = u8::from(is_operational);
        bench.says(&std::format!("node 1 -> all: PRes, {}, EN=0 RD={rd}, PR=0 RS=0, 1 byte", polled.code()));
        assert_eq!((bench.last.len(), bench.last[24]), (60, 0x5A));
        let is_taken = polled != NmtState::PreOperational2;
        assert_eq!(bench.node.objects().output, if is_taken { 0x77 } else { 0 }, "{state}");
        assert_eq!(
            bench.events.contains(&NodeEvent::ProcessData { channel: 0, is_valid: true }),
            is_operational
        );
    }
}

#[test]
fn commands_are_followed_from_unicast_and_broadcast() {
    let mut bench = Bench::in_state(NmtState::ReadyToOperate, config());
    bench.command_to(NodeId::BROADCAST, NmtCommandId::START_NODE, &[]);
    bench.is(NmtState::Operational);
    bench.command_to(NODE, NmtCommandId::ENTER_PRE_OPERATIONAL_2, &[]);
    bench.is(NmtState::PreOperational2);
    bench.command_to(NODE, NmtCommandId::ENABLE_READY_TO_OPERATE, &[]);
    bench.is(NmtState::ReadyToOperate);
    bench.command_to(NodeId::BROADCAST, NmtCommandId::START_NODE, &[]);
    bench.is(NmtState::Operational);
    bench.command_to(NodeId(2), NmtCommandId::STOP_NODE, &[]);
    bench.is(NmtState::Operational);
    bench.command_to(NodeId::BROADCAST, NmtCommandId::RESET_NODE, &[]);
    bench.is(NmtState::NotActive);
}

#[test]
fn unpadded_frames_are_accepted() {
    let mut bench = Bench::listening(config());
    let soa: &[u8] =
        &[1, 0x11, 0x1E, 0, 0, 3, 2, 0, 0, 0, 0, 0xF0, 0x88, 0xAB, 5, 255, 240, 0x1D, 0, 0, 1, 1, 0x20];
    assert_eq!(soa.len(), 23);
    bench.bytes(soa);
    bench.is(NmtState::PreOperational1);
    bench.bytes(soa);
    assert_eq!(bench.last.len(), 176);
    let mut soc = [0; 36];
    soc[..17].copy_from_slice(&[1, 0x11, 0x1E, 0, 0, 1, 2, 0, 0, 0, 0, 0xF0, 0x88, 0xAB, 1, 255, 240]);
    bench.bytes(&soc);
    bench.is(NmtState::PreOperational2);
    let mut preq = [0; 25];
    preq[..24].copy_from_slice(&[
        2, 0, 0, 0, 0, 1, 2, 0, 0, 0, 0, 0xF0, 0x88, 0xAB, 3, 1, 240, 0, 1, 0, 0, 0, 1, 0,
    ]);
    bench.forget();
    bench.bytes(&preq);
    bench.says("node 1 -> all: PRes, NMT_PRE_OPERATIONAL_2, EN=0 RD=0, PR=0 RS=0, 1 byte");
}
