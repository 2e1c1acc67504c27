//! Two nodes with one node ID.

use std::time::Duration;

use devicenet_tests::powerlink::{Event, Net, Station, node_at};
use powerlink_core::managing::{MnEvent, NodePhase};
use powerlink_core::nmt::NmtState;
use powerlink_core::node::NodeEvent;
use powerlink_core::{MacAddress, NodeId};
use transport_mock::ethernet::{Record, StationConfig, StationId};

const FIRST: MacAddress = MacAddress([2, 0, 0, 0, 0, 1]);
const TWIN: MacAddress = MacAddress([2, 0, 0, 0, 0xAA, 1]);

/// Another node 1, which answers after so many microseconds; the first one takes 5.
fn twin(net: &mut Net, reaction: u64) -> StationId {
    let mut cn = node_at(TWIN, 1);
    cn.power_on(net.segment.now());
    let config = StationConfig { reaction: Duration::from_micros(reaction), ..StationConfig::named("twin") };
    net.segment.add(config, Station::Cn(Box::new(cn)))
}

/// Whom the managing node names, and whom the two of each other.
fn told(net: &Net) -> (Vec<MacAddress>, Vec<MacAddress>) {
    let (mut of_mn, mut of_nodes) = (Vec::new(), Vec::new());
    for record in net.segment.records() {
        match record {
            Record::Event { event: Event::Mn(MnEvent::AddressConflict { node, source }), .. } => {
                assert_eq!(*node, NodeId(1));
                of_mn.push(*source);
            }
            Record::Event { event: Event::Cn(NodeEvent::AddressConflict { source }), .. } => {
                of_nodes.push(*source);
            }
            _ => {}
        }
    }
    (of_mn, of_nodes)
}

/// Both answer the first IdentRequest. Whose answer comes first is the node; the other one is told, and does not disturb.
#[test]
fn of_two_that_start_together_the_first_to_answer_is_the_node() {
    for (reaction, is_first) in [(2, false), (20, true)] {
        let mut net = Net::new(2);
        let twin = twin(&mut net, reaction);
        assert!(net.run_until_complete(2_000), "{}", net.trace());
        net.run(1_000);
        let (of_mn, of_nodes) = told(&net);
        let other = if is_first { TWIN } else { FIRST };
        assert!(!of_mn.is_empty() && of_mn.iter().all(|&mac| mac == other), "{of_mn:?}");
        assert!(of_nodes.contains(&FIRST) && of_nodes.contains(&TWIN), "each of them hears the other");
        let (first, twin) = (net.id(1), net.segment.machine(twin));
        let is_operational =
            |station: &Station| matches!(station, Station::Cn(cn) if cn.state() == NmtState::Operational);
        assert_eq!(is_operational(net.segment.machine(first)), is_first);
        assert_eq!(is_operational(twin), !is_first);
        assert_eq!(net.states()[1], NmtState::Operational);
        let phases = net.mn(|mn, _| [1, 2].map(|number| mn.phase(NodeId(number))));
        assert_eq!(phases, [Some(NodePhase::Operational); 2], "{}", net.trace());
        assert!(net.mn(|mn, _| mn.counters().address_conflicts) > 0);
    }
}

/// One comes while the other runs: the process data go on without a cycle missed.
#[test]
fn one_that_comes_later_takes_nothing_over() {
    let mut net = Net::new(2);
    assert!(net.run_until_complete(2_000));
    net.segment.take_records();
    let lost = net.mn(|mn, _| mn.counters().lost_pres);
    twin(&mut net, 2);
    net.run(12_000);
    assert_eq!(net.states(), [NmtState::Operational; 2], "{}", net.trace());
    assert_eq!(net.mn(|mn, _| mn.counters().lost_pres), lost);
    let (of_mn, of_nodes) = told(&net);
    assert!(of_mn.contains(&TWIN) && of_nodes.contains(&FIRST), "{}", net.trace());
    assert!(!of_mn.contains(&FIRST));
}

/// The first one is taken away: once it is missed, the other one is the node.
#[test]
fn the_other_one_follows_when_the_first_is_gone() {
    let mut net = Net::new(2);
    let twin = twin(&mut net, 20);
    assert!(net.run_until_complete(2_000));
    net.segment.cut(net.id(1));
    net.run(200);
    assert!(net.run_until_complete(5_000), "{}", net.trace());
    let Station::Cn(cn) = net.segment.machine(twin) else { panic!("a node") };
    assert_eq!(cn.state(), NmtState::Operational);
}
