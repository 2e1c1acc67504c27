//! Whether the inputs of a node count: that they do not any more is told at once, and once.

use devicenet_tests::powerlink::{Event, Mn, Net, Station, config, plan};
use powerlink_core::NodeId;
use powerlink_core::managing::{Config, MnEvent, NodePhase};
use powerlink_core::wire::{Body, ErrorCode, Flags, Frame, MessageType, NmtCommandId, NmtStateCode};
use transport_mock::ethernet::{Fate, Passage, Record, SegmentConfig, nth};

use crate::edges::restarted;

const NODE: NodeId = NodeId(1);

/// In operation, with inputs of every node.
fn running(cns: u8) -> Net {
    let mut net = Net::new(cns);
    assert!(net.run_until_complete(10_000), "{}", net.trace());
    net.run(50);
    net.segment.take_records();
    net
}

/// What the managing node says, without inputs that still count.
fn said(net: &mut Net) -> Vec<MnEvent> {
    let mut had = true;
    let events = net.segment.take_records().into_iter().filter_map(|record| match record {
        Record::Event { event: Event::Mn(event), .. } => Some(event),
        _ => None,
    });
    let is_news = |event: &MnEvent| match event {
        MnEvent::Inputs { node: NODE, is_valid } => !(std::mem::replace(&mut had, *is_valid) && *is_valid),
        MnEvent::Inputs { is_valid, .. } => !is_valid,
        _ => true,
    };
    events.filter(is_news).collect()
}

const fn inputs(is_valid: bool) -> MnEvent {
    MnEvent::Inputs { node: NODE, is_valid }
}

fn is_pres(net: &Net) -> impl Fn(&Passage<'_>) -> bool + use<> {
    let (from, to) = (Some(net.id(1)), net.mn);
    move |passage| (passage.from, passage.to) == (from, to) && passage.bytes[14] == MessageType::PRES.0
}

/// Changes the next PRes on their way to the managing node.
fn spoil(net: &mut Net, mut left: u8, change: impl Fn(&mut [u8]) + 'static) {
    let is_pres = is_pres(net);
    net.segment.add_fault(move |passage| {
        if !is_pres(passage) || left == 0 {
            return Fate::Pass;
        }
        left -= 1;
        let mut bytes = passage.bytes.to_vec();
        change(&mut bytes);
        Fate::Replace(bytes)
    });
}

#[test]
fn with_the_first_pres_that_is_lost_there_are_none_and_with_the_next_there_are() {
    let mut net = running(1);
    net.segment.add_fault(nth(is_pres(&net), 3..4, Fate::Lose));
    net.run(50);
    assert_eq!(said(&mut net), [MnEvent::PresLost { node: NODE }, inputs(false), inputs(true)]);
}

#[test]
fn a_pres_without_rd_ends_them_once() {
    let mut net = running(1);
    spoil(&mut net, 5, |pres| pres[18] &= !Flags::DATA_VALID.bits());
    net.run(10);
    assert_eq!(net.mn(|mn, _| mn.inputs(NODE).map(<[u8]>::to_vec)), None);
    net.run(40);
    assert_eq!(said(&mut net), [inputs(false), inputs(true)]);
}

/// RD counts in `Operational` only: EPSG DS 301.
#[test]
fn a_pres_of_another_state_ends_them_once() {
    let mut net = running(1);
    spoil(&mut net, 2, |pres| pres[17] = NmtStateCode::READY_TO_OPERATE.0);
    net.run(50);
    assert_eq!(said(&mut net), [inputs(false), inputs(true)]);
}

/// The cable is cut: first the inputs are gone, then the node.
#[test]
fn a_node_that_is_lost_has_none() {
    let mut net = running(2);
    net.segment.cut(net.id(1));
    net.run(100);
    let lost = MnEvent::PresLost { node: NODE };
    let reason = ErrorCode::LOSS_OF_PRES_THRESHOLD;
    let events = said(&mut net);
    let events: Vec<_> =
        events.iter().filter(|event| !matches!(event, MnEvent::NodeChanged { .. })).collect();
    assert_eq!(events[..4], [&lost, &inputs(false), &lost, &MnEvent::NodeLost { node: NODE, reason }]);
    assert!(!events[4..].contains(&&inputs(false)), "{events:?}");
}

/// It was switched off and on, and says so in a StatusResponse: EC is 1.
#[test]
fn a_node_that_begins_anew_is_lost_with_a_reason() {
    let mut net = running(1);
    net.segment.inject(&restarted());
    net.run(1);
    let events = said(&mut net);
    let reason = ErrorCode::WRONG_STATE;
    assert_eq!(events[0], MnEvent::NodeLost { node: NODE, reason }, "{events:?}");
    assert!(matches!(events[1], MnEvent::NodeChanged { to: NodePhase::Absent, .. }), "{events:?}");
    assert_eq!(events[2], inputs(false), "{events:?}");
    // It has reset itself: it is asked who it is, and told nothing before.
    net.run(20);
    let first = net.segment.take_records().into_iter().find_map(|record| match record {
        Record::Frame(frame) => match Frame::parse(&frame.bytes).unwrap().body {
            Body::IdentResponse(_) => Some("asked"),
            Body::NmtCommand(_) => Some("told"),
            _ => None,
        },
        _ => None,
    });
    assert_eq!(first, Some("asked"));
}

#[test]
fn a_node_that_is_brought_out_of_operation_has_none() {
    use NmtCommandId as Command;
    for command in [Command::STOP_NODE, Command::ENTER_PRE_OPERATIONAL_2, Command::RESET_NODE] {
        for to_all in [false, true] {
            let mut net = running(1);
            net.mn(|mn, _| if to_all { mn.command_all(command) } else { mn.command(NODE, command) }.unwrap());
            net.run(100);
            let events = said(&mut net);
            let ends = events.iter().filter(|event| **event == inputs(false)).count();
            assert_eq!(ends, 1, "{command}: {events:?}");
        }
    }
}

/// More than there is room for in the queue of events.
#[test]
fn all_nodes_at_once_have_none_when_the_managing_node_stops() {
    let count = 32;
    let plans: Vec<_> = (1..=count).map(plan).collect();
    let mut net =
        Net::with(Config { cycle: 2 * config().cycle, ..config() }, &plans, SegmentConfig::default());
    assert!(net.run_until_complete(10_000), "{}", net.trace());
    net.run(50);
    net.segment.take_records();
    net.mn(Mn::stop);
    let ended: Vec<_> = said(&mut net)
        .into_iter()
        .filter_map(|event| match event {
            MnEvent::Inputs { node, is_valid: false } => Some(node.0),
            _ => None,
        })
        .collect();
    assert_eq!(ended, (1..=count).collect::<Vec<_>>());
    assert!(matches!(net.segment.machine(net.mn), Station::Mn(mn) if mn.inputs(NODE).is_none()));
}

/// It comes when its time is over: it is lost, and then late.
#[test]
fn a_late_pres_is_told_and_not_used() {
    let mut net = running(1);
    let late = Fate::Late(std::time::Duration::from_micros(300));
    net.segment.add_fault(nth(is_pres(&net), 0..1, late));
    net.run(6);
    let (lost, late) = (MnEvent::PresLost { node: NODE }, MnEvent::PresLate { node: NODE });
    let events = said(&mut net);
    assert_eq!(events[..3], [lost, inputs(false), late], "{events:?}");
    assert_eq!(net.mn(|mn, _| (mn.counters().lost_pres, mn.counters().late_pres)), (1, 1));
}
