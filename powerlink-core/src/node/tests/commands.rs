//! NMT commands, plain and with a list, to one node and to all.

use core::time::Duration;
use std::string::ToString;

use super::bench::*;
use crate::NodeId;
use crate::nmt::NmtState;
use crate::node::NodeEvent;
use crate::wire::{ErrorCode, Flags, NmtCommandId, NodeList};

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

/// A PReq before the cycle was lost says nothing of the one that begins.
#[test]
fn start_needs_valid_data_of_this_cycle() {
    let mut config = config();
    config.options.start_needs_valid_data = true;
    let mut bench = Bench::in_state(NmtState::ReadyToOperate, config);
    bench.cycle();
    bench.wait(Duration::from_secs(1));
    bench.is(NmtState::PreOperational1);
    bench.soc();
    bench.command(NmtCommandId::ENABLE_READY_TO_OPERATE);
    bench.command(NmtCommandId::START_NODE);
    bench.is(NmtState::ReadyToOperate);
    bench.preq(Flags::DATA_VALID, &[1]);
    bench.command(NmtCommandId::START_NODE);
    bench.is(NmtState::Operational);
}

#[test]
fn requests_for_commands_have_their_limits() {
    let mut bench = Bench::in_state(NmtState::Operational, config());
    let count = (0..9).filter(|_| bench.node.request_command(NmtCommandId::RESET_NODE, NODE).is_ok()).count();
    assert_eq!(count, 4);
    let full = bench.node.request_command(NmtCommandId::RESET_NODE, NODE).unwrap_err();
    assert_eq!(
        full.to_string(),
        "too many NMT requests wait for an invitation: try again after the next SoA"
    );
    let list = bench.node.request_command(NmtCommandId::STOP_NODE_EX, NODE).unwrap_err();
    assert_eq!(list.to_string(), "NMTStopNodeEx needs a list of nodes: ask for NMTStopNode of each node");
    let mut bench = Bench::listening(config());
    let silent = bench.node.request_command(NmtCommandId::RESET_NODE, NODE).unwrap_err();
    assert_eq!(silent.to_string(), "not possible in NotActive");
    bench.says_nothing();
}

/// EPSG DS 301 and replays against openPOWERLINK 2.7.2, through frames: a row a command, a column a state, `.` for ignored. A
/// reset ends in `NotActive`, whatever its depth.
#[test]
fn every_command_in_every_state() {
    use NmtState::*;
    const STATES: [NmtState; 7] =
        [NotActive, PreOperational1, PreOperational2, ReadyToOperate, Operational, Stopped, BasicEthernet];
    const ROWS: [(NmtCommandId, &str); 8] = [
        (NmtCommandId::START_NODE, ". . . OP . . ."),
        (NmtCommandId::STOP_NODE, ". . ST ST ST . ."),
        (NmtCommandId::ENTER_PRE_OPERATIONAL_2, ". . . . P2 P2 ."),
        (NmtCommandId::ENABLE_READY_TO_OPERATE, ". . RO . . . ."),
        (NmtCommandId::RESET_NODE, "NA NA NA NA NA NA NA"),
        (NmtCommandId::RESET_COMMUNICATION, "NA NA NA NA NA NA NA"),
        (NmtCommandId::RESET_CONFIGURATION, "NA NA NA NA NA NA NA"),
        (NmtCommandId::SW_RESET, "NA NA NA NA NA NA NA"),
    ];
    let mut list = NodeList::default();
    list.insert(NODE);
    for (plain, row) in ROWS {
        let extended = NmtCommandId(plain.0 + 0x20);
        for (from, expected) in STATES.into_iter().zip(row.split(' ')) {
            let to = match expected {
                "OP" => Operational,
                "ST" => Stopped,
                "P2" => PreOperational2,
                "RO" => ReadyToOperate,
                "NA" => NotActive,
                _ => from,
            };
            for (command, node, data) in [
                (plain, NODE, &[][..]),
                (plain, NodeId::BROADCAST, &[]),
                (extended, NODE, &list.0),
                (extended, NodeId::BROADCAST, &list.0),
            ] {
                let mut bench = Bench::in_state(from, config());
                bench.command_to(node, command, data);
                assert_eq!(bench.node.state(), to, "{command} to {node} in {from}");
                let is_ignored = expected == ".";
                assert_eq!(
                    bench.node.counters().commands_ignored,
                    u32::from(is_ignored),
                    "{command} in {from}"
                );
            }
        }
    }
}

/// What a controlled node does not follow, for others and of others: nothing changes in any state.
#[test]
fn commands_that_nobody_follows() {
    for state in [NmtState::PreOperational1, NmtState::Operational, NmtState::Stopped] {
        let mut bench = Bench::in_state(state, config());
        let followed = |number| matches!(number, 0x21..=0x24 | 0x28..=0x2B | 0x41..=0x44 | 0x48..=0x4B);
        for number in (0..=u8::MAX).filter(|&number| !followed(number)) {
            bench.command(NmtCommandId(number));
        }
        assert_eq!(bench.node.counters().commands_ignored, 240);
        bench.command_to(NodeId(2), NmtCommandId::RESET_NODE, &[]);
        bench.command_of(NodeId(7), NmtCommandId::RESET_NODE);
        bench.is(state);
        bench.says_nothing();
    }
}

/// A reset that comes during another one: the initialisation begins again where the deeper of the two does.
#[test]
fn a_reset_may_come_during_the_initialisation() {
    let mut bench = Bench::in_state(NmtState::Operational, config());
    bench.command_undrained(NmtCommandId::RESET_CONFIGURATION);
    bench.is(NmtState::ResetConfiguration);
    bench.command_undrained(NmtCommandId::START_NODE);
    bench.is(NmtState::ResetConfiguration);
    for (command, state) in [
        (NmtCommandId::RESET_COMMUNICATION, NmtState::ResetCommunication),
        (NmtCommandId::RESET_NODE, NmtState::ResetApplication),
        (NmtCommandId::RESET_COMMUNICATION, NmtState::ResetApplication),
        (NmtCommandId::SW_RESET, NmtState::Initialising),
        (NmtCommandId::RESET_NODE, NmtState::Initialising),
    ] {
        bench.command_undrained(command);
        bench.is(state);
    }
    bench.drain();
    bench.is(NmtState::NotActive);
    bench.says_nothing();
}
