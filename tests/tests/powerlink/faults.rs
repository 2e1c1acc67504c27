//! What goes wrong in a network, and how everybody comes back.

use std::time::Duration;

use devicenet_tests::powerlink::{Cn, Event, Mn, Net, Station, config, plan};
use powerlink_core::NodeId;
use powerlink_core::dictionary::ObjectAddress;
use powerlink_core::error::Symptom;
use powerlink_core::managing::{MnEvent, MnState, NodePhase, NodePlan, ObjectWrite};
use powerlink_core::nmt::NmtState;
use powerlink_core::node::NodeCounters;
use powerlink_core::wire::{AbortCode, Body, ErrorCode, Frame, MessageType, NmtCommandId};
use transport_mock::ethernet::{Fate, Keep, Passage, Record, SegmentConfig, StationConfig, StationId, nth};

fn running(cns: u8) -> Net {
    let mut net = Net::new(cns);
    assert!(net.run_until_complete(3_000), "{}", net.trace());
    net.run(20);
    net
}

/// What the managing node says, without process data.
fn said(net: &Net) -> Vec<MnEvent> {
    let events = net.segment.records().iter().filter_map(|record| match record {
        Record::Event { event: Event::Mn(event), .. } => Some(*event),
        _ => None,
    });
    events.filter(|event| !matches!(event, MnEvent::Inputs { .. })).collect()
}

#[test]
fn a_node_whose_cable_was_cut_comes_back_and_the_others_go_on() {
    let mut net = running(3);
    // The PReq of the others pass it by.
    let complaints = |cn: &mut Cn, _| NodeCounters { other_destinations: 0, ..*cn.counters() };
    net.segment.cut(net.id(1));
    net.run(500);
    assert_eq!(net.mn(|mn, _| mn.phase(NodeId(1))), Some(NodePhase::Absent));
    assert_eq!(net.mn(|mn, _| mn.inputs(NodeId(1)).map(<[u8]>::to_vec)), None);
    // Its own SoC supervision brought it out of operation.
    assert_eq!(net.states(), [NmtState::PreOperational1, NmtState::Operational, NmtState::Operational]);
    net.segment.plug(net.id(1));
    assert!(net.run_until_complete(1_000), "{}", net.trace());
    assert_eq!(net.states(), [NmtState::Operational; 3]);
    assert_eq!(net.cn(2, complaints), NodeCounters::default());
}

#[test]
fn a_short_interruption_is_no_loss() {
    let mut net = running(1);
    net.segment.cut(net.id(1));
    net.run(5);
    net.segment.plug(net.id(1));
    net.segment.take_records();
    net.run(200);
    assert_eq!(net.states(), [NmtState::Operational]);
    let (node, code) = (NodeId(1), ErrorCode::LOSS_OF_LINK);
    assert_eq!(
        said(&net),
        [MnEvent::PresLost { node }, MnEvent::NodeError { node, code }],
        "{}",
        net.trace()
    );
}

#[test]
fn without_a_managing_node_everybody_waits_and_with_a_new_one_everybody_starts() {
    let mut net = running(3);
    net.kill_mn();
    net.run(1_000);
    assert_eq!(net.states(), [NmtState::PreOperational1; 3]);
    net.restart_mn();
    assert!(net.run_until_complete(2_000), "{}", net.trace());
    assert_eq!(net.states(), [NmtState::Operational; 3]);
}

/// The nodes have not noticed yet, and are in operation when it begins anew.
#[test]
fn a_managing_node_that_begins_anew_at_once_resets_everybody() {
    let mut net = running(2);
    net.restart_mn();
    assert!(net.run_until_complete(2_000), "{}", net.trace());
    assert_eq!(net.states(), [NmtState::Operational; 2]);
}

#[test]
fn a_node_that_was_switched_off_and_on_comes_back() {
    let mut net = running(2);
    net.segment.take_records();
    net.restart_cn(1);
    net.run(100);
    assert_ne!(net.mn(|mn, _| mn.phase(NodeId(1))), Some(NodePhase::Operational));
    assert!(net.run_until_complete(2_000), "{}", net.trace());
    assert_eq!(net.states(), [NmtState::Operational; 2]);
    let lost = MnEvent::NodeLost { node: NodeId(1), reason: ErrorCode::WRONG_STATE };
    assert!(said(&net).contains(&lost), "{}", net.trace());
}

#[test]
fn a_node_that_is_not_the_one_of_the_plan_is_refused_and_tried_again() {
    let checks = [
        (NodePlan { device_type: Some(9), ..plan(1) }, ErrorCode::BOOT_DEVICE_TYPE),
        (NodePlan { vendor_id: Some(9), ..plan(1) }, ErrorCode::BOOT_VENDOR_ID),
        (NodePlan { product_code: Some(9), ..plan(1) }, ErrorCode::BOOT_PRODUCT_CODE),
        (NodePlan { revision: Some(9), ..plan(1) }, ErrorCode::BOOT_REVISION),
        (NodePlan { serial_number: Some(9), ..plan(1) }, ErrorCode::BOOT_SERIAL),
    ];
    for (plan, reason) in checks {
        let mut net = Net::with(config(), &[plan], SegmentConfig::default());
        net.run(1_500);
        let refused = MnEvent::NodeRefused { node: NodeId(1), reason };
        assert!(said(&net).iter().filter(|event| **event == refused).count() > 1, "{}", net.trace());
        // A mandatory node is missing: the cycle does not begin.
        assert_eq!(net.mn(|mn, _| mn.state()), MnState::PreOperational1);
        assert_eq!(net.states(), [NmtState::PreOperational1]);
    }
}

/// A command for it does not take away the moment when it is asked again.
#[test]
fn a_refused_node_that_is_commanded_is_tried_again() {
    let missing = NodePlan { vendor_id: Some(9), ..plan(1) };
    let refused = MnEvent::NodeRefused { node: NodeId(1), reason: ErrorCode::BOOT_VENDOR_ID };
    for command in [
        |mn: &mut Mn| mn.command(NodeId(1), NmtCommandId::START_NODE),
        |mn: &mut Mn| mn.command_all(NmtCommandId::START_NODE),
    ] {
        let mut net = Net::with(config(), &[missing], SegmentConfig::default());
        net.run(300);
        assert_eq!(net.mn(|mn, _| mn.phase(NodeId(1))), Some(NodePhase::Refused));
        assert_eq!(net.mn(|mn, _| command(mn)), Ok(()));
        net.run(1_000);
        assert!(said(&net).iter().filter(|event| **event == refused).count() > 1, "{}", net.trace());
    }
}

#[test]
fn an_optional_node_keeps_nobody_waiting() {
    let missing = NodePlan { is_mandatory: false, vendor_id: Some(9), ..plan(1) };
    let mut net = Net::with(config(), &[missing, plan(2)], SegmentConfig::default());
    net.run(1_000);
    assert_eq!(net.mn(|mn, _| mn.state()), MnState::Operational);
    assert_eq!(net.states()[1], NmtState::Operational);
}

#[test]
fn a_node_that_refuses_its_configuration_is_not_started() {
    const WRITES: &[ObjectWrite<'_>] = &[ObjectWrite::new(ObjectAddress::new(0x2FFF, 0), &[1])];
    let mut net = Net::with(config(), &[NodePlan { writes: WRITES, ..plan(1) }], SegmentConfig::default());
    net.run(1_000);
    let (node, code) = (NodeId(1), AbortCode::NO_OBJECT);
    let events = said(&net);
    assert!(
        events.contains(&MnEvent::ConfigurationAborted { node, at: ObjectAddress::new(0x2FFF, 0), code }),
        "{}",
        net.trace()
    );
    assert!(events.contains(&MnEvent::NodeRefused { node, reason: ErrorCode::BOOT_CONFIGURATION }));
    assert_ne!(net.states(), [NmtState::Operational]);
}

#[test]
fn what_may_fail_may_fail() {
    const LOAD: &[ObjectWrite<'_>] =
        &[ObjectWrite { may_fail: true, ..ObjectWrite::new(ObjectAddress::new(0x1011, 1), b"load") }];
    let mut net = Net::with(config(), &[NodePlan { writes: LOAD, ..plan(1) }], SegmentConfig::default());
    assert!(net.run_until_complete(2_000), "{}", net.trace());
}

#[test]
fn a_node_that_never_answers_is_waited_for_and_taken_when_it_comes() {
    let mut net = Net::new(2);
    net.segment.cut(net.id(1));
    net.run(2_000);
    assert_eq!(net.mn(|mn, _| mn.state()), MnState::PreOperational1);
    assert_eq!(net.mn(|mn, _| mn.phase(NodeId(2))), Some(NodePhase::Configured));
    net.segment.plug(net.id(1));
    assert!(net.run_until_complete(1_000), "{}", net.trace());
}

#[test]
fn a_node_that_answers_polls_only_is_lost() {
    let mut net = running(1);
    let (mn, node) = (net.mn, net.id(1));
    net.segment.add_fault(move |passage| {
        let is_asnd = passage.from == Some(node) && passage.bytes[14] == MessageType::ASND.0;
        if is_asnd && passage.to == mn { Fate::Lose } else { Fate::Pass }
    });
    net.segment.take_records();
    net.run(6_000);
    let lost = MnEvent::NodeLost { node: NodeId(1), reason: ErrorCode::NO_STATUS_RESPONSE };
    assert!(said(&net).contains(&lost), "{}", net.trace());
    net.segment.clear_faults();
    assert!(net.run_until_complete(2_000), "{}", net.trace());
}

#[test]
fn without_a_managing_node_a_node_settles_for_plain_ethernet_until_one_comes() {
    let mut net = Net::new(2);
    net.kill_mn();
    net.run(4_999);
    assert_eq!(net.states(), [NmtState::NotActive; 2]);
    net.run(2);
    assert_eq!(net.states(), [NmtState::BasicEthernet; 2]);
    assert_eq!(net.segment.frames().count(), 0);
    net.restart_mn();
    assert!(net.run_until_complete(2_000), "{}", net.trace());
}

/// Frames as a virtual link delivers them: SoC of 36 bytes, SoA of 23, the others as long as what they say.
#[test]
fn unpadded_frames_are_as_good_as_padded_ones() {
    let mut net = Net::new(3);
    net.segment.add_fault(|passage| {
        let frame = Frame::parse(passage.bytes).unwrap();
        let len = match frame.body {
            Body::Soc(_) => 36,
            Body::Soa(_) => 23,
            Body::Preq(preq) => 24 + preq.data.len(),
            Body::Pres(pres) => 24 + pres.data.len(),
            Body::NmtCommand(_) => 20,
            Body::Sdo(sdo) => 22 + sdo.command.map_or(0, |command| 8 + command.data.len()),
            _ => return Fate::Pass,
        };
        Fate::Replace(passage.bytes[..len].to_vec())
    });
    assert!(net.run_until_complete(2_000), "{}", net.trace());
    net.run(200);
    for number in 1..=3 {
        assert_eq!(net.cn(number, |cn, _| cn.counters().bad_frames), 0);
    }
    assert_eq!(net.mn(|mn, _| (mn.counters().bad_frames, mn.counters().lost_pres)), (0, 0));
}

#[test]
fn frames_that_arrive_twice_or_with_errors_do_no_harm() {
    let mut net = Net::new(2);
    let mut number = 0_u32;
    net.segment.add_fault(move |_| {
        number += 1;
        match number % 40 {
            7 => Fate::Corrupt,
            n if n % 3 == 0 => Fate::Twice,
            _ => Fate::Pass,
        }
    });
    net.run(3_000);
    net.segment.clear_faults();
    assert!(net.run_until_complete(2_000), "{}", net.trace());
}

/// Node 2 says something in every cycle or so; the managing node waits for node 1, whose answers get lost.
#[test]
fn sdo_of_others_does_not_put_off_the_time_out_of_a_transfer() {
    let mut net = running(2);
    let (mn, node) = (net.mn, net.id(1));
    net.segment.add_fault(move |passage| {
        let is_sdo = passage.bytes[14] == MessageType::ASND.0 && passage.bytes[17] == 0x05;
        if is_sdo && passage.from == Some(node) && passage.to == mn { Fate::Lose } else { Fate::Pass }
    });
    let at = ObjectAddress::new(0x1018, 1);
    net.mn(|mn, _| mn.sdo_read(NodeId(1), at).unwrap());
    net.segment.take_records();
    let mut frame = [0; 60];
    frame[..20].copy_from_slice(&[
        0x01, 0x11, 0x1E, 0, 0, 4, 2, 0, 0, 0, 0, 2, 0x88, 0xAB, 0x06, 240, 2, 0x05, 0x02, 0x06,
    ]);
    for _ in 0..100 {
        net.run(20);
        net.segment.inject(&frame);
    }
    let failed = MnEvent::SdoFailed { node: NodeId(1), at, code: AbortCode::TIME_OUT };
    assert!(said(&net).contains(&failed), "{}", net.trace());
}

/// Another managing node of the same nodes, which begins now. Its MAC address differs from the first one's (0xF0) in the last
/// byte.
fn second_managing_node(net: &mut Net, last: u8) -> StationId {
    let mac = powerlink_core::MacAddress([2, 0, 0, 0, 0, last]);
    let config = powerlink_core::managing::Config { mac, ..config() };
    let mut mn = powerlink_core::managing::ManagingNode::new(config, &[plan(1), plan(2)]).unwrap();
    mn.start(net.segment.now());
    net.segment.add(StationConfig::named("second"), Station::Mn(Box::new(mn)))
}

fn state(net: &Net, station: StationId) -> MnState {
    match net.segment.machine(station) {
        Station::Mn(mn) => mn.state(),
        Station::Cn(_) | Station::Dead => MnState::Off,
    }
}

/// Two managing nodes that begin at the same moment: that with the lower MAC address goes on, the other one listens.
#[test]
fn of_two_managing_nodes_at_the_same_moment_the_lower_address_goes_on() {
    for last in [0xEF, 0xF1] {
        let mut net = Net::new(2);
        let second = second_managing_node(&mut net, last);
        net.run(2_000);
        let states = [net.mn, second].map(|station| state(&net, station));
        let first_goes_on = last > 0xF0;
        let (one, other) = (MnState::Operational, MnState::NotActive);
        assert_eq!(states, if first_goes_on { [one, other] } else { [other, one] }, "{}", net.trace());
        assert_eq!(net.states(), [NmtState::Operational; 2]);
    }
}

/// Two that began apart and are joined while both send: one of them goes on, whatever their addresses.
#[test]
fn two_networks_that_are_joined_have_one_managing_node() {
    for last in [0xEF, 0xF1] {
        for apart in 300..310 {
            let mut net = Net::new(2);
            let second = second_managing_node(&mut net, last);
            net.segment.cut(second);
            net.run(apart);
            assert_eq!(state(&net, second), MnState::PreOperational1, "nobody answers it");
            net.segment.plug(second);
            net.run(2_000);
            let states = [net.mn, second].map(|station| state(&net, station));
            for expected in [MnState::NotActive, MnState::Operational] {
                assert!(states.contains(&expected), "{last:02X}, {apart} ms: {}", net.trace());
            }
            assert_eq!(net.states(), [NmtState::Operational; 2]);
        }
    }
}

/// The cable of a node that is not polled is cut for so long, at any place of a cycle of 5 ms. What each error counter counts by
/// it is at most one.
#[test]
fn a_node_that_is_not_polled_forgives_one_short_interruption() {
    let plans = [NodePlan { is_async_only: true, ..plan(1) }, plan(2)];
    let mut net =
        Net::with(config(), &plans, SegmentConfig { keep: Keep::Nothing, ..SegmentConfig::default() });
    assert!(net.run_until_complete(3_000), "{}", net.trace());
    net.run(100);
    let counted =
        |cn: &mut Cn, _| Symptom::ALL.map(|symptom| cn.dictionary().counters.of(symptom).cumulative);
    for span in [1, 10, 100, 1_000, 4_000] {
        for place in (0..5_000).step_by(50) {
            net.segment.run_for(Duration::from_micros(place));
            let before = net.cn(1, counted);
            net.segment.cut(net.id(1));
            net.segment.run_for(Duration::from_micros(span));
            net.segment.plug(net.id(1));
            net.run(100);
            let new: Vec<_> =
                net.cn(1, counted).iter().zip(before).map(|(after, before)| after - before).collect();
            assert_eq!(net.states(), [NmtState::Operational; 2], "{span} us at {place}: {new:?}");
            let lost_preq = Symptom::ALL.iter().position(|&symptom| symptom == Symptom::LossOfPreq);
            let is_one = |(at, &count): (usize, &u32)| Some(at) == lost_preq || count <= 1;
            assert!(new.iter().enumerate().all(is_one), "{span} us at {place}: {new:?}");
        }
    }
}

/// A second one within eight good cycles is one too many, as for a polled node.
#[test]
fn a_node_that_is_not_polled_leaves_operation_after_two_lost_socs() {
    let plans = [NodePlan { is_async_only: true, ..plan(1) }, plan(2)];
    for (distance, stays) in [(1, false), (2, false), (3, true), (9, true)] {
        let mut net = Net::with(config(), &plans, SegmentConfig::default());
        assert!(net.run_until_complete(3_000), "{}", net.trace());
        net.run(100);
        let node = net.id(1);
        let is_soc =
            move |passage: &Passage<'_>| passage.to == node && passage.bytes[14] == MessageType::SOC.0;
        net.segment.add_fault(nth(is_soc, 0..1, Fate::Lose));
        net.segment.add_fault(nth(is_soc, distance..distance + 1, Fate::Lose));
        net.segment.take_records();
        net.run(100);
        let left = net.trace().contains("cycle error");
        assert_eq!(left, !stays, "{distance} cycles apart: {}", net.trace());
    }
}

/// Two managing nodes: one gives way, and takes over when the other is gone.
#[test]
fn there_is_one_managing_node_at_a_time() {
    let mut net = running(2);
    let second = second_managing_node(&mut net, 0xF1);
    net.run(1_000);
    assert_eq!(state(&net, second), MnState::NotActive);
    assert_eq!(net.states(), [NmtState::Operational; 2]);
    net.kill_mn();
    let took_over = net.segment.run_while(
        Duration::from_secs(3),
        |segment| !matches!(segment.machine(second), Station::Mn(mn) if mn.is_complete()),
    );
    assert!(took_over, "{}", net.trace());
    assert_eq!(net.states(), [NmtState::Operational; 2]);
}
