//! Tables, sizes, and configurations that cannot be. Networks are tested on the simulated segment.

mod held_up;

use core::time::Duration;

use link_core::ethernet::{Action, Input, Machine};
use link_core::machine_laws;

use super::*;
use crate::dictionary::ObjectAddress;
use crate::pdo::MappingEntry;
use crate::{MacAddress, NodeId};

const MAC: MacAddress = MacAddress([2, 0, 0, 0, 0, 0xF0]);

#[test]
fn the_text_shows_the_tables_as_they_are() {
    let text = include_str!("state.rs");
    let (network, nodes) = text.split_once("/// Every transition of a node").unwrap();
    machine_laws::text_shows(network, "| From | Cause | To |", MN_EDGES);
    machine_laws::text_shows(nodes, "| From | Cause | To |", NODE_EDGES);
    machine_laws::edges_are_distinct(MN_EDGES, |edge| (edge.from, edge.cause, edge.to));
    machine_laws::edges_are_distinct(NODE_EDGES, |edge| (edge.from, edge.cause, edge.to));
}

#[test]
fn a_plan_that_cannot_be_is_refused() {
    let plan = NodePlan::new(NodeId(1));
    let make = |plans: &[NodePlan<'_>]| ManagingNode::<2>::new(Config::new(MAC), plans).map(|_| ());
    assert_eq!(make(&[plan, NodePlan::new(NodeId(2))]), Ok(()));
    let node = NodeId(1);
    assert_eq!(make(&[NodePlan::new(NodeId(240))]), Err(ConfigError::Node(NodeId(240))));
    assert_eq!(make(&[plan, plan]), Err(ConfigError::Twice(node)));
    let three = [1, 2, 3].map(|number| NodePlan::new(NodeId(number)));
    assert_eq!(make(&three), Err(ConfigError::TooManyNodes { node: NodeId(3), plans: 3, room: 2 }));
    assert_eq!(
        make(&[NodePlan { pres_limit: 37, ..plan }]),
        Err(ConfigError::DataLimit { node, direction: Direction::Inputs, limit: 37, room: 36 })
    );
    assert_eq!(
        make(&[NodePlan { preq_limit: 35, ..plan }]),
        Err(ConfigError::DataLimit { node, direction: Direction::Outputs, limit: 35, room: 36 })
    );
    let (object, direction) = (ObjectAddress::new(0x6000, 1), Direction::Inputs);
    let far = [0, 288, 296].map(|offset| MappingEntry { object, offset, length: 8 });
    assert_eq!(
        make(&[NodePlan { inputs: &far, ..plan }]),
        Err(ConfigError::Mapping { node, direction, entry: 1, at: object, len: 37, limit: 36 })
    );
    let (at, value) = (ObjectAddress::new(0x2000, 0), [0; 253]);
    let long = [ObjectWrite::new(at, &value)];
    assert_eq!(
        make(&[NodePlan { writes: &long, ..plan }]),
        Err(ConfigError::Value { node, write: 0, at, len: 253, room: 252 })
    );
    assert_eq!(
        make(&[NodePlan { multiplexed_slot: Some(0), ..plan }]),
        Err(ConfigError::MultiplexedSlot { node, slot: 0, cycles: 0 })
    );
    let slow = NodePlan { pres_timeout: Duration::from_millis(20), ..plan };
    assert!(matches!(make(&[slow]), Err(ConfigError::Cycle { .. })));
}

/// 0x1600 and 0x1A00 have the sub-indices 0x01 to 0xFE.
#[test]
fn a_mapping_has_at_most_254_objects() {
    let (node, object) = (NodeId(1), ObjectAddress::new(0x6000, 1));
    let entries: std::vec::Vec<_> =
        (0..280).map(|offset| MappingEntry { object, offset, length: 1 }).collect();
    let make = |outputs: usize, inputs: usize| {
        let (outputs, inputs) = (&entries[..outputs], &entries[..inputs]);
        ManagingNode::<1>::new(Config::new(MAC), &[NodePlan { outputs, inputs, ..NodePlan::new(node) }])
            .map(|_| ())
    };
    assert_eq!(make(254, 254), Ok(()));
    for mapped in [255, 256, 280] {
        let too_many = |direction| Err(ConfigError::TooManyMapped { node, direction, mapped, room: 254 });
        assert_eq!(make(mapped, 0), too_many(Direction::Outputs));
        assert_eq!(make(0, mapped), too_many(Direction::Inputs));
    }
}

/// 0x1006 counts microseconds in 32 bits.
#[test]
fn a_cycle_has_whole_microseconds() {
    let make = |cycle| {
        let made = ManagingNode::<1>::new(Config { cycle, ..Config::new(MAC) }, &[]);
        made.map(|_| ()).map_err(|error| (error, error.node()))
    };
    let most = Duration::from_micros(u32::MAX.into());
    for cycle in [Duration::from_micros(20_001), most] {
        assert_eq!(make(cycle), Ok(()));
    }
    for cycle in [Duration::from_nanos(20_000_500), most + Duration::from_micros(1)] {
        assert_eq!(make(cycle), Err((ConfigError::CycleLength { cycle }, None)));
    }
}

/// What is mapped is set, all of it; where the plan maps nothing, the node knows.
#[test]
fn outputs_are_as_long_as_their_mapping() {
    let byte =
        |sub| MappingEntry { object: ObjectAddress::new(0x6200, sub), offset: 8 * u16::from(sub), length: 8 };
    let (outputs, node) = ([byte(0), byte(1)], NodeId(1));
    let plans = [NodePlan { outputs: &outputs, ..NodePlan::new(node) }, NodePlan::new(NodeId(2))];
    let mut mn = ManagingNode::<2>::new(Config::new(MAC), &plans).unwrap();
    assert_eq!(mn.set_outputs(node, &[1, 2]), Ok(()));
    for len in [0, 1, 3, 37] {
        let wrong = Err(MnError::OutputLength { node, len, mapped: 2 });
        assert_eq!(mn.set_outputs(node, &[0; 37][..len]), wrong);
    }
    for len in [0, 1, 36] {
        assert_eq!(mn.set_outputs(NodeId(2), &[0; 36][..len]), Ok(()));
    }
    let too_long = Err(MnError::TooLong { node: NodeId(2), len: 37, limit: 36 });
    assert_eq!(mn.set_outputs(NodeId(2), &[0; 37]), too_long);
}

/// EPSG DS 301 at 100 Mbit/s: SoC, 1 us, PReq and PRes of 60 bytes with 25 us between, SoA, 100 us, an ASnd of 314 bytes.
#[test]
fn the_shortest_cycle_is_what_its_frames_take() {
    let plans = [NodePlan::new(NodeId(1))];
    let (shortest, async_frame) = (6_720, (314 + 24) * 80);
    let nanos = shortest + 1_000 + shortest + 25_000 + shortest + shortest + 100_000 + async_frame;
    assert_eq!(Config::new(MAC).needed(&plans), Duration::from_nanos(nanos));
}

/// What another node costs; mostly process data in both directions and the plan.
#[test]
fn a_node_costs_what_it_needs() {
    let grows = size_of::<ManagingNode<'static, 2>>() - size_of::<ManagingNode<'static, 1>>();
    assert!(grows <= 480, "{grows} bytes");
}

/// Two that send at the same moment, again and again: what one sends, the other hears only when it has sent as well. That with the
/// lower MAC address goes on, the other listens.
#[test]
fn two_that_begin_at_once_do_not_give_way_to_each_other_for_ever() {
    let other = MacAddress([2, 0, 0, 0, 0, 0xF1]);
    for macs in [[MAC, other], [other, MAC]] {
        let mut now = link_core::Instant::ZERO;
        let mut nodes = macs.map(|mac| ManagingNode::<1>::new(Config::new(mac), &[]).unwrap());
        nodes.iter_mut().for_each(|node| node.start(now));
        while now < link_core::Instant::from_millis(5_000) {
            nodes.iter_mut().for_each(|node| node.input(now, Input::Tick));
            let [one, two] = nodes.each_mut().map(|node| sent(node, now));
            let [first, second] = &mut nodes;
            two.iter().for_each(|bytes| first.input(now, Input::Frame(bytes)));
            one.iter().for_each(|bytes| second.input(now, Input::Frame(bytes)));
            now = nodes.iter().filter_map(|node| Some(node.deadline()?.at)).min().unwrap().max(now);
        }
        let states = nodes.map(|node| node.state());
        let (one, two) = (MnState::Operational, MnState::NotActive);
        assert_eq!(states, if macs == [MAC, other] { [one, two] } else { [two, one] });
    }
}

fn sent(node: &mut ManagingNode<'_, 1>, now: link_core::Instant) -> std::vec::Vec<std::vec::Vec<u8>> {
    let (mut buffer, mut frames) = ([0; link_core::ethernet::MAX_FRAME], std::vec::Vec::new());
    while let Some(action) = node.poll(now, &mut buffer) {
        if let Action::Transmit(bytes) = action {
            frames.push(bytes.to_vec());
        }
    }
    frames
}
