//! What has to be there for a managing node to start a node, learned against that of openPOWERLINK 2.7.2.
//!
//! | A controlled node must | Test |
//! |---|---|
//! | answer an IdentRequest with 176 bytes, in every state from `PreOperational1` on, `Stopped` too | [`an_ident_response_has_176_bytes_in_every_state`] |
//! | answer a StatusRequest with 72 bytes or more and the right EC: a shorter one is dropped, and the node reset for ever | [`a_status_response_has_72_bytes_in_every_state_and_ec_follows_er`], [`a_status_response_with_all_the_errors_that_it_can_tell`] |
//! | serve objects in every state: 0x1006 is written even where the configuration is the right one | [`the_cycle_length_is_written_in_every_state`] |
//! | ask for the asynchronous slot in PRes, StatusResponse and IdentResponse (RS, PR), and send one frame when invited | [`what_waits_is_told_and_one_frame_goes_out_when_invited`], [`a_pres_asks_for_the_slot`], [`without_a_pres_the_responses_ask_for_the_slot`], [`requests_are_counted`], [`seven_frames_are_seven_or_more`] |
//! | answer a PReq in `PreOperational2`, `ReadyToOperate` and `Operational`, in time | [`a_poll_is_answered_in_three_states`] |
//! | follow NMT commands, to itself and to all | [`commands_are_followed_from_unicast_and_broadcast`] |
//! | accept frames that nobody padded, as virtual links deliver them | [`unpadded_frames_are_accepted`] |
//!
//! A managing node waits 25 µs for a PRes by the specification, 200 µs in the demonstration of openPOWERLINK. What of that the node
//! takes is held by `benches/instructions.rs`: the instructions from the PReq to the PRes, with a budget.

use super::bench::*;
use crate::NodeId;
use crate::nmt::NmtState;
use crate::node::NodeEvent;
use crate::wire::{EntryType, ErrorCode, ErrorEntry, Flags, NmtCommandId, RequestedService};

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
            "node 1 -> all: IdentResponse, {}, vendor 0x00000123, product 0x00000007, revision 1.0, PR=0 RS=0",
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

/// 13 entries at most, as openPOWERLINK has them: the frame grows by 20 bytes for each from the third on, and never has less than 72.
#[test]
fn a_status_response_with_all_the_errors_that_it_can_tell() {
    for (entries, len) in [(0, 72), (2, 72), (3, 92), (8, 192), (13, 292), (14, 292)] {
        let mut config = config();
        config.options.status_entries = entries;
        let mut bench = Bench::in_state(NmtState::PreOperational1, config);
        for er in [Flags::EXCEPTION_RESET, Flags::empty()] {
            bench.invite(RequestedService::STATUS_REQUEST, NODE, er);
        }
        // The first is told at once; the others wait until it is acknowledged.
        for code in 0x4001..=0x400E {
            let (kind, code) = (EntryType::POWERLINK_EVENT, ErrorCode(code));
            let entry = ErrorEntry { kind, code, ..ErrorEntry::default() };
            bench.node.report_error(bench.now, entry).unwrap();
        }
        bench.forget();
        bench.asks(RequestedService::STATUS_REQUEST);
        assert_eq!((bench.last.len(), bench.last[34], bench.last[54]), (72, 1, 0));
        bench.invite(RequestedService::STATUS_REQUEST, NODE, Flags::EXCEPTION_ACKNOWLEDGE);
        assert_eq!(bench.last.len(), len, "{entries} entries");
        let told = (len - 32) / 20;
        let codes: std::vec::Vec<u8> = (0..told).map(|at| bench.last[34 + 20 * at]).collect();
        assert_eq!(codes, (2..).take(told).collect::<std::vec::Vec<u8>>(), "the oldest first");
        assert_eq!(bench.node.counters().errors_untold, 0, "the first is told, 13 wait");
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

/// SDO waits (PR=3), then NMT requests as well (PR=7): the most urgent is told.
#[test]
fn a_pres_asks_for_the_slot() {
    for state in [NmtState::PreOperational2, NmtState::ReadyToOperate, NmtState::Operational] {
        let mut bench = Bench::in_state(state, config());
        let (code, rd) = (state.code(), u8::from(state == NmtState::Operational));
        let cycle = |request: &str, service: RequestedService, bench: &mut Bench| {
            bench.soc();
            bench.preq(Flags::empty(), &[1]);
            bench.says(&std::format!("node 1 -> all: PRes, {code}, EN=0 RD={rd}, {request}, 1 byte"));
            bench.asks(service);
        };
        cycle("PR=0 RS=0", RequestedService::NO_SERVICE, &mut bench);
        bench.sdo("00 01 00 00");
        cycle("PR=3 RS=1", RequestedService::NO_SERVICE, &mut bench);
        for count in 1..=4 {
            bench.node.request_command(NmtCommandId::STOP_NODE, NODE).unwrap();
            cycle(&std::format!("PR=7 RS={count}"), RequestedService::NO_SERVICE, &mut bench);
        }
        for count in (1..=4).rev() {
            cycle(&std::format!("PR=7 RS={count}"), RequestedService::NMT_REQUEST_INVITE, &mut bench);
            bench.says("node 1 -> MN: NMTRequest, NMTStopNode for node 1");
        }
        cycle("PR=3 RS=1", RequestedService::UNSPECIFIED_INVITE, &mut bench);
        bench.says("node 1 -> MN: SDO, rcon=1/0 scon=1/0");
        cycle("PR=0 RS=0", RequestedService::UNSPECIFIED_INVITE, &mut bench);
        bench.says_nothing();
    }
}

/// In `PreOperational1` and `Stopped` there is no PRes.
#[test]
fn without_a_pres_the_responses_ask_for_the_slot() {
    for state in [NmtState::PreOperational1, NmtState::Stopped] {
        let mut bench = Bench::in_state(state, config());
        let asks = |request: &str, bench: &mut Bench| {
            let code = state.code();
            bench.asks(RequestedService::STATUS_REQUEST);
            bench.says(&std::format!("node 1 -> all: StatusResponse, {code}, EC=1 EN=0, {request}"));
            bench.asks(RequestedService::IDENT_REQUEST);
            bench.says(&std::format!(
                "node 1 -> all: IdentResponse, {code}, vendor 0x00000123, product 0x00000007, revision 1.0, {request}"
            ));
        };
        asks("PR=0 RS=0", &mut bench);
        bench.sdo("00 01 00 00");
        asks("PR=3 RS=1", &mut bench);
        bench.node.request_command(NmtCommandId::RESET_NODE, NODE).unwrap();
        bench.node.request_command(NmtCommandId::RESET_NODE, NODE).unwrap();
        asks("PR=7 RS=2", &mut bench);
        bench.asks(RequestedService::NMT_REQUEST_INVITE);
        bench.says("node 1 -> MN: NMTRequest, NMTResetNode for node 1");
        asks("PR=7 RS=1", &mut bench);
    }
}

/// The answers to two clients wait at once, and each invitation sends one.
#[test]
fn requests_are_counted() {
    let mut bench = Bench::in_state(NmtState::PreOperational1, config());
    bench.sdo("00 01 00 00");
    bench.sdo_of(NodeId::DIAGNOSTIC, "00 01 00 00");
    for (request, client) in [("PR=3 RS=2", "MN"), ("PR=3 RS=1", "diagnostic device")] {
        bench.asks(RequestedService::STATUS_REQUEST);
        bench.says(&std::format!(
            "node 1 -> all: StatusResponse, NMT_PRE_OPERATIONAL_1, EC=1 EN=0, {request}"
        ));
        bench.asks(RequestedService::UNSPECIFIED_INVITE);
        bench.says(&std::format!("node 1 -> {client}: SDO, rcon=1/0 scon=1/0"));
    }
    bench.asks(RequestedService::UNSPECIFIED_INVITE);
    bench.says_nothing();
}

/// RS has three bits: four segments for each of two clients are told as 7, and the fewer that wait after them as what they are.
#[test]
fn seven_frames_are_seven_or_more() {
    let mut config = config();
    config.values.async_mtu = 300;
    let mut bench = Bench::in_state(NmtState::PreOperational1, config);
    bench.node.objects_mut().long = std::vec![0x5A; 2000];
    for client in [NodeId::MANAGING_NODE, NodeId::DIAGNOSTIC] {
        bench.opens_connection(client);
    }
    for client in [NodeId::MANAGING_NODE, NodeId::DIAGNOSTIC] {
        bench.sdo_of(client, "02 06 00 00 00 01 00 02 04 00 00 00 00 20 00 00");
    }
    bench.forget();
    for waiting in (0..=8).rev() {
        bench.asks(RequestedService::STATUS_REQUEST);
        let (priority, count) = (if waiting == 0 { 0 } else { 3 }, waiting.min(7));
        bench.says(&std::format!(
            "node 1 -> all: StatusResponse, NMT_PRE_OPERATIONAL_1, EC=1 EN=0, PR={priority} RS={count}"
        ));
        bench.asks(RequestedService::UNSPECIFIED_INVITE);
        bench.forget();
    }
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

/// Each from a state in which it leads to another one; a reset ends in `NotActive`.
#[test]
fn commands_are_followed_from_unicast_and_broadcast() {
    use NmtState::{NotActive, Operational, PreOperational2, ReadyToOperate, Stopped};
    let commands = [
        (NmtCommandId::START_NODE, ReadyToOperate, Operational),
        (NmtCommandId::STOP_NODE, Operational, Stopped),
        (NmtCommandId::ENTER_PRE_OPERATIONAL_2, Operational, PreOperational2),
        (NmtCommandId::ENABLE_READY_TO_OPERATE, PreOperational2, ReadyToOperate),
        (NmtCommandId::RESET_NODE, Operational, NotActive),
        (NmtCommandId::RESET_COMMUNICATION, Operational, NotActive),
        (NmtCommandId::RESET_CONFIGURATION, Operational, NotActive),
        (NmtCommandId::SW_RESET, Operational, NotActive),
    ];
    for (command, from, to) in commands {
        for (node, state) in [(NODE, to), (NodeId::BROADCAST, to), (NodeId(2), from)] {
            let mut bench = Bench::in_state(from, config());
            bench.command_to(node, command, &[]);
            assert_eq!(bench.node.state(), state, "{command} to {node}");
        }
    }
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
