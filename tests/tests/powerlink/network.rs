//! Whole networks from power-up, in virtual time: nodes boot, exchange process data, are commanded, and their objects read.

use std::time::Duration;

use devicenet_tests::powerlink::{Event, Net, TEXT, config, plan};
use powerlink_core::NodeId;
use powerlink_core::dictionary::ObjectAddress;
use powerlink_core::managing::{Config, MnError, MnEvent, NodePhase, NodePlan};
use powerlink_core::nmt::NmtState;
use powerlink_core::wire::{
    AbortCode, Body, ConfigurationStamp, Flags, Frame, MessageType, NmtCommandId, NmtStateCode, NodeList,
};
use transport_mock::ethernet::{Record, SegmentConfig};

fn running(cns: u8) -> Net {
    let mut net = Net::new(cns);
    assert!(net.run_until_complete(5_000), "{}", net.trace());
    net.run(20);
    net.segment.take_records();
    net
}

/// The whole boot, to be read.
#[test]
fn one_node_boots() {
    let mut net = Net::new(1);
    assert!(net.run_until_complete(2_000), "{}", net.trace());
    net.run(11);
    assert_eq!(net.states(), [NmtState::Operational]);
    insta::assert_snapshot!(net.trace());
}

/// What the managing node and the nodes say of it.
#[test]
fn three_nodes_boot() {
    let mut net = Net::new(3);
    assert!(net.run_until_complete(2_000), "{}", net.trace());
    assert_eq!(net.states(), [NmtState::Operational; 3]);
    // The managing node's view, and what it commands.
    let trace = net.trace();
    let words: Vec<_> =
        trace.lines().filter(|line| line.contains("[MN]") || line.contains(": NMT")).collect();
    insta::assert_snapshot!(words.join("\n"));
}

#[test]
fn thirty_nodes_boot() {
    let mut net = Net::new(30);
    assert!(net.run_until_complete(10_000), "{}", net.trace());
    assert_eq!(net.states(), [NmtState::Operational; 30]);
    net.segment.take_records();
    net.run(100);
    let polls = net.segment.frames().filter(|frame| frame.bytes[14] == MessageType::PRES.0).count();
    assert_eq!(polls, 20 * 30, "everybody answers in each of twenty cycles");
    assert_eq!(net.mn(|mn, _| mn.counters().lost_pres), 0);
    assert_eq!(net.mn(|mn, _| mn.counters().cycles_exceeded), 0);
}

#[test]
fn process_data_go_both_ways() {
    let mut net = running(2);
    for value in [0x5A, 0xA5, 0x00, 0xFF] {
        net.mn(|mn, _| mn.set_outputs(NodeId(1), &[value]).unwrap());
        net.mn(|mn, _| mn.set_outputs(NodeId(2), &[!value]).unwrap());
        net.cn(1, |cn, _| cn.objects_mut().inputs = value.wrapping_add(1));
        net.cn(2, |cn, _| cn.objects_mut().inputs = value.wrapping_add(2));
        net.run(10);
        assert_eq!(net.cn(1, |cn, _| cn.objects().outputs), value);
        assert_eq!(net.cn(2, |cn, _| cn.objects().outputs), !value);
        net.mn(|mn, _| {
            assert_eq!(mn.inputs(NodeId(1)), Some(&[value.wrapping_add(1)][..]));
            assert_eq!(mn.inputs(NodeId(2)), Some(&[value.wrapping_add(2)][..]));
        });
    }
    let node = NodeId(1);
    let wrong = Err(MnError::OutputLength { node, len: 2, mapped: 1 });
    net.mn(|mn, _| assert_eq!(mn.set_outputs(node, &[0; 2]), wrong));
    net.mn(|mn, _| assert_eq!(mn.set_outputs(NodeId(9), &[]), Err(MnError::NoPlan(NodeId(9)))));
}

/// Outputs count with RD, and RD is there in operation only, once the application has given some.
#[test]
fn outputs_that_nobody_gave_do_not_count() {
    let mut net = Net::new(1);
    net.run_until_complete(2_000);
    net.run(50);
    let is_valid = |net: &Net| {
        let polls = net.segment.frames().filter_map(|frame| match Frame::parse(&frame.bytes).unwrap().body {
            Body::Preq(preq) => Some(preq.flags.contains(Flags::DATA_VALID)),
            _ => None,
        });
        polls.collect::<Vec<_>>()
    };
    assert!(is_valid(&net).iter().all(|valid| !valid));
    net.segment.take_records();
    net.mn(|mn, _| mn.set_outputs(NodeId(1), &[7]).unwrap());
    net.run(50);
    assert!(is_valid(&net).iter().all(|valid| *valid));
    assert_eq!(net.cn(1, |cn, _| cn.objects().outputs), 7);
}

#[test]
fn objects_are_read_and_written_in_one_part_and_in_many() {
    let mut net = running(2);
    let last = |net: &Net| {
        let events = net.segment.records().iter().rev().filter_map(|record| match record {
            Record::Event { event: Event::Mn(event), .. } => Some(*event),
            _ => None,
        });
        let mut events = events.filter(|event| !matches!(event, MnEvent::Inputs { .. }));
        events.next().unwrap_or_else(|| panic!("{}", net.trace()))
    };
    let node = NodeId(2);
    for len in [0, 1, 200, 240, 248] {
        let text: Vec<u8> = (0..len).map(|place| place as u8 ^ 0x5A).collect();
        net.mn(|mn, _| mn.sdo_write(node, TEXT, &text).unwrap());
        net.mn(|mn, _| assert_eq!(mn.sdo_read(node, TEXT), Err(MnError::Busy)));
        net.run(1_000);
        assert_eq!(last(&net), MnEvent::ObjectWritten { node, at: TEXT }, "{len} bytes");
        assert_eq!(net.cn(2, |cn, _| cn.objects().text.clone()), text);
        net.mn(|mn, _| mn.sdo_read(node, TEXT).unwrap());
        net.run(1_000);
        assert_eq!(last(&net), MnEvent::ObjectRead { node, at: TEXT, len });
        net.mn(|mn, _| assert_eq!(mn.sdo_data(), text));
    }
    // The other node, and what there is not.
    let vendor = ObjectAddress::new(0x1018, 1);
    net.mn(|mn, _| mn.sdo_read(NodeId(1), vendor).unwrap());
    net.run(500);
    assert_eq!(last(&net), MnEvent::ObjectRead { node: NodeId(1), at: vendor, len: 4 });
    net.mn(|mn, _| assert_eq!(mn.sdo_data(), [0x23, 0x01, 0, 0]));
    let nothing = ObjectAddress::new(0x2FFF, 0);
    net.mn(|mn, _| mn.sdo_write(NodeId(1), nothing, &[1]).unwrap());
    net.run(500);
    assert_eq!(last(&net), MnEvent::SdoFailed { node: NodeId(1), at: nothing, code: AbortCode::NO_OBJECT });
    // What is longer than the buffer.
    net.cn(1, |cn, _| cn.objects_mut().text = vec![1; 900]);
    net.mn(|mn, _| mn.sdo_read(NodeId(1), TEXT).unwrap());
    net.run(500);
    assert_eq!(last(&net), MnEvent::SdoFailed { node: NodeId(1), at: TEXT, code: AbortCode::OUT_OF_MEMORY });
    let long = net.mn(|mn, _| mn.sdo_write(NodeId(1), TEXT, &[0; 253]));
    assert_eq!(long, Err(MnError::Value { len: 253, room: 252 }));
    net.mn(|mn, _| mn.sdo_read(NodeId(1), vendor).unwrap());
    net.run(2_000);
    assert_eq!(last(&net), MnEvent::ObjectRead { node: NodeId(1), at: vendor, len: 4 });
    // A server closes a connection that is idle for 15 s; the client opens it again.
    net.run(20_000);
    net.mn(|mn, _| mn.sdo_read(NodeId(1), vendor).unwrap());
    net.run(2_000);
    assert_eq!(last(&net), MnEvent::ObjectRead { node: NodeId(1), at: vendor, len: 4 });
}

const RESETS: [NmtCommandId; 4] = [
    NmtCommandId::RESET_NODE,
    NmtCommandId::RESET_COMMUNICATION,
    NmtCommandId::RESET_CONFIGURATION,
    NmtCommandId::SW_RESET,
];

/// Whether a record is a command.
fn was_sent(record: &Record<Event>, command: NmtCommandId) -> bool {
    let Record::Frame(frame) = record else { return false };
    matches!(Frame::parse(&frame.bytes).unwrap().body, Body::NmtCommand(sent) if sent.command == command)
}

/// Every command to one of two nodes: the other does not notice.
#[test]
fn a_node_is_where_it_is_commanded() {
    use NmtState::{Operational, PreOperational2, Stopped};
    let mut net = running(2);
    let mut command = |command, state| {
        net.mn(|mn, _| mn.command(NodeId(1), command).unwrap());
        net.run(100);
        assert_eq!(net.states(), [state, Operational], "{command}: {}", net.trace());
        assert!(net.mn(|mn, _| mn.is_complete()), "{command}: {}", net.trace());
        assert!(net.segment.take_records().iter().any(|record| was_sent(record, command)), "{command}");
    };
    command(NmtCommandId::STOP_NODE, Stopped);
    command(NmtCommandId::START_NODE, Operational);
    command(NmtCommandId::ENTER_PRE_OPERATIONAL_2, PreOperational2);
    // It is ready for a moment, and brought back to where it is to be.
    command(NmtCommandId::ENABLE_READY_TO_OPERATE, PreOperational2);
}

#[test]
fn a_node_that_is_held_stays_there_until_it_is_started() {
    let mut net = running(2);
    let (hold, stop, start) =
        (NmtCommandId::ENTER_PRE_OPERATIONAL_2, NmtCommandId::STOP_NODE, NmtCommandId::START_NODE);
    let after = |net: &mut Net, command| {
        net.mn(|mn, _| mn.command(NodeId(2), command).unwrap());
        net.run(300);
        net.states()[1]
    };
    assert_eq!(after(&mut net, hold), NmtState::PreOperational2);
    assert_eq!(after(&mut net, stop), NmtState::Stopped);
    assert_eq!(after(&mut net, hold), NmtState::PreOperational2);
    assert_eq!(after(&mut net, start), NmtState::Operational);
    assert_eq!(after(&mut net, stop), NmtState::Stopped);
    // It stays stopped over a reset of the node.
    net.restart_cn(2);
    net.run(8_000);
    assert_eq!(net.states()[1], NmtState::Stopped, "{}", net.trace());
    assert_eq!(after(&mut net, start), NmtState::Operational);
}

#[test]
fn a_reset_node_comes_back() {
    for reset in RESETS {
        let mut net = running(2);
        net.mn(|mn, _| mn.command(NodeId(1), reset).unwrap());
        net.run(10);
        assert_ne!(net.states()[0], NmtState::Operational, "{reset}");
        assert!(net.run_until_complete(2_000), "{reset}: {}", net.trace());
        assert_eq!(net.states(), [NmtState::Operational; 2]);
    }
}

#[test]
fn all_nodes_and_some_of_them_are_commanded_by_one_frame() {
    use NmtState::{Operational, PreOperational2, Stopped};
    let mut net = running(3);
    let mut some = NodeList::default();
    some.insert(NodeId(1));
    some.insert(NodeId(3));
    for (command, state) in
        [(NmtCommandId::STOP_NODE, Stopped), (NmtCommandId::ENTER_PRE_OPERATIONAL_2, PreOperational2)]
    {
        net.mn(|mn, _| mn.command_list(command, some).unwrap());
        net.run(100);
        assert_eq!(net.states(), [state, Operational, state], "{command}: {}", net.trace());
        net.mn(|mn, _| mn.command_all(NmtCommandId::START_NODE).unwrap());
        assert!(net.run_until_complete(500), "{}", net.trace());
        net.mn(|mn, _| mn.command_all(command).unwrap());
        net.run(100);
        assert_eq!(net.states(), [state; 3], "{command}: {}", net.trace());
        net.mn(|mn, _| mn.command_all(NmtCommandId::START_NODE).unwrap());
        assert!(net.run_until_complete(500), "{}", net.trace());
    }
    for reset in RESETS {
        net.mn(|mn, _| mn.command_list(reset, some).unwrap());
        net.run(10);
        assert_eq!(net.states()[1], Operational, "{reset}");
        assert_ne!(net.states()[0], Operational, "{reset}");
        assert!(net.run_until_complete(2_000), "{reset}: {}", net.trace());
        net.mn(|mn, _| mn.command_all(reset).unwrap());
        net.run(10);
        assert!(net.states().iter().all(|state| *state != Operational), "{reset}");
        assert!(net.run_until_complete(2_000), "{reset}: {}", net.trace());
    }
    let publish = NmtCommandId::PUBLISH_TIME;
    net.mn(|mn, _| assert_eq!(mn.command_all(publish), Err(MnError::Command(publish))));
}

#[test]
fn a_node_asks_for_commands_and_gets_them_or_is_told_no() {
    let mut net = running(2);
    net.cn(1, |cn, _| cn.request_command(NmtCommandId::STOP_NODE, NodeId(2)).unwrap());
    net.run(100);
    assert_eq!(net.states(), [NmtState::Operational, NmtState::Stopped]);
    net.cn(1, |cn, _| cn.request_command(NmtCommandId::PUBLISH_TIME, NodeId(2)).unwrap());
    net.segment.take_records();
    net.run(100);
    assert!(net.trace().contains("MN -> node 1: NMTInvalidService"), "{}", net.trace());
}

/// A node with the right stamp is not written again, but for the cycle length.
#[test]
fn a_node_that_has_its_configuration_keeps_it() {
    let stamp = ConfigurationStamp { date: 15_000, time: 42 };
    let plan = NodePlan { configuration: Some(stamp), ..plan(1) };
    let mut net = Net::with(config(), &[plan], SegmentConfig::default());
    assert!(net.run_until_complete(2_000), "{}", net.trace());
    let written = |net: &Net| net.trace().lines().filter(|line| line.contains(" written")).count();
    assert_eq!(written(&net), 10);
    assert_eq!(net.cn(1, |cn, _| cn.dictionary().values.configuration), stamp);
    net.segment.take_records();
    net.mn(|mn, _| mn.command(NodeId(1), NmtCommandId::RESET_CONFIGURATION).unwrap());
    net.run(20);
    assert!(net.run_until_complete(2_000), "{}", net.trace());
    assert_eq!(written(&net), 2, "0x1006, and the managing node says so: {}", net.trace());
    // A reset of the node takes the configuration away.
    net.mn(|mn, _| mn.command(NodeId(1), NmtCommandId::RESET_NODE).unwrap());
    net.segment.take_records();
    net.run(20);
    assert!(net.run_until_complete(2_000), "{}", net.trace());
    assert_eq!(written(&net), 10);
}

/// Two nodes in every cycle, four in one of two each.
#[test]
fn multiplexed_nodes_are_polled_in_their_cycle() {
    let config = Config { multiplexed_cycles: 2, ..config() };
    let slot = |number: u8, slot| NodePlan { multiplexed_slot: slot, ..plan(number) };
    let plans = [
        slot(1, None),
        slot(2, None),
        slot(3, Some(0)),
        slot(4, Some(0)),
        slot(5, Some(1)),
        slot(6, Some(1)),
    ];
    let mut net = Net::with(config, &plans, SegmentConfig::default());
    assert!(net.run_until_complete(5_000), "{}", net.trace());
    net.segment.take_records();
    net.run(1_000);
    assert_eq!(net.states(), [NmtState::Operational; 6]);
    let polls = |node: u8| {
        let polls = net.segment.frames().filter(|frame| frame.bytes[14] == MessageType::PREQ.0);
        polls.filter(|frame| frame.bytes[15] == node).count()
    };
    assert_eq!([1, 2, 3, 4, 5, 6].map(polls), [200, 200, 100, 100, 100, 100]);
    assert!(!net.trace().contains("loss of"), "{}", net.trace());
}

#[test]
fn a_node_of_the_asynchronous_phase_only_is_never_polled() {
    let plans = [NodePlan { is_async_only: true, ..plan(1) }, plan(2)];
    let mut net = Net::with(config(), &plans, SegmentConfig::default());
    assert!(net.run_until_complete(3_000), "{}", net.trace());
    net.run(1_000);
    assert_eq!(net.states(), [NmtState::Operational; 2]);
    let is_poll = |bytes: &[u8]| bytes[14] == MessageType::PREQ.0 && bytes[15] == 1;
    assert!(!net.segment.frames().any(|frame| is_poll(&frame.bytes)));
}

/// A cycle that does not hold everybody is refused, one that does is kept to the nanosecond.
#[test]
fn the_cycle_is_as_long_as_it_is_said_to_be() {
    let mut net = running(3);
    net.run(1_000);
    let starts: Vec<_> = net
        .segment
        .frames()
        .filter(|frame| frame.bytes[14] == MessageType::SOC.0)
        .map(|frame| frame.start)
        .collect();
    for pair in starts.windows(2) {
        assert_eq!(pair[1].saturating_since(pair[0]), Duration::from_millis(5));
    }
    let states = net.segment.frames().filter_map(|frame| match Frame::parse(&frame.bytes).unwrap().body {
        Body::Soa(soa) => Some(soa.state),
        _ => None,
    });
    assert!(states.into_iter().all(|state| state == NmtStateCode::OPERATIONAL));
    assert_eq!(net.mn(|mn, _| mn.phase(NodeId(3))), Some(NodePhase::Operational));
}
