//! NMT commands, plain and with a list, to one node and to all.

use super::bench::*;
use crate::NodeId;
use crate::nmt::NmtState;
use crate::node::NodeEvent;
use crate::wire::{ErrorCode, Flags, NmtCommandId, NodeList, RequestedService};

#[test]
fn broadcast_commands_are_followed() {
    let mut bench = Bench::in_state(NmtState::ReadyToOperate, config());
    bench.command_to(NodeId::BROADCAST, NmtCommandId::START_NODE, &[]);
    bench.is(NmtState::Operational);
    bench.command_to(NodeId(2), NmtCommandId::STOP_NODE, &[]);
    bench.is(NmtState::Operational);
    bench.command_to(NodeId::BROADCAST, NmtCommandId::RESET_NODE, &[]);
    bench.is(NmtState::NotActive);
}

#[test]
fn extended_commands_are_for_the_nodes_of_their_list() {
    let mut bench = Bench::in_state(NmtState::ReadyToOperate, config());
    let mut list = NodeList::default();
    list.insert(NodeId(2));
    bench.command_to(NodeId::BROADCAST, NmtCommandId::START_NODE_EX, &list.0);
    bench.is(NmtState::ReadyToOperate);
    list.insert(NODE);
    bench.command_to(NodeId::BROADCAST, NmtCommandId::START_NODE_EX, &list.0);
    bench.is(NmtState::Operational);
}

#[test]
fn the_reason_of_a_reset_is_told() {
    let mut bench = Bench::in_state(NmtState::Operational, config());
    bench.command_to(NODE, NmtCommandId::RESET_NODE, &[0x43, 0x82]);
    let reason = ErrorCode::LOSS_OF_PRES_THRESHOLD;
    bench.tells(NodeEvent::ResetReason { command: NmtCommandId::RESET_NODE, reason });
    bench.is(NmtState::NotActive);
}

/// A reset of the configuration keeps what was downloaded; deeper ones bring back the power-on values.
#[test]
fn how_deep_a_reset_goes() {
    let cases = [
        (NmtCommandId::RESET_CONFIGURATION, 50_000, 9),
        (NmtCommandId::RESET_COMMUNICATION, 20_000, 9),
        (NmtCommandId::RESET_NODE, 20_000, 0),
        (NmtCommandId::SW_RESET, 20_000, 0),
    ];
    for (command, cycle_length, output) in cases {
        let mut bench = Bench::in_state(NmtState::PreOperational1, config());
        bench.sdo("00 01 00 00");
        bench.sdo("01 02 00 00");
        bench.sdo("02 06 00 00 00 03 00 01 08 00 00 00 06 10 00 00 50 c3 00 00");
        assert_eq!(bench.node.dictionary().values.cycle_length, 50_000);
        bench.node.objects_mut().output = 9;
        bench.command(command);
        bench.is(NmtState::NotActive);
        assert_eq!(bench.node.dictionary().values.cycle_length, cycle_length, "{command}");
        assert_eq!(bench.node.objects().output, output, "{command}");
    }
}

#[test]
fn start_may_need_valid_data() {
    for (needs, state) in [(false, NmtState::Operational), (true, NmtState::ReadyToOperate)] {
        let mut config = config();
        config.options.start_needs_valid_data = needs;
        let mut bench = Bench::in_state(NmtState::ReadyToOperate, config);
        bench.soc();
        bench.preq(Flags::empty(), &[1]);
        bench.soa();
        bench.command(NmtCommandId::START_NODE);
        bench.is(state);
    }
}

#[test]
fn an_nmt_request_waits_for_its_invitation_and_is_more_urgent_than_sdo() {
    let mut bench = Bench::in_state(NmtState::Operational, config());
    bench.sdo("00 01 00 00");
    bench.node.request_command(NmtCommandId::RESET_NODE, NODE).unwrap();
    bench.soc();
    bench.preq(Flags::empty(), &[1]);
    bench.says("node 1 -> all: PRes, NMT_OPERATIONAL, EN=0 RD=1, PR=7 RS=1, 1 bytes");
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

    let full = (0..9).filter(|_| bench.node.request_command(NmtCommandId::RESET_NODE, NODE).is_ok()).count();
    assert_eq!(full, 4);
}
