//! Polls and states.

use core::time::Duration;

use super::*;

#[test]
fn a_pres_that_does_not_come_is_told_by_the_next_frame_of_the_managing_node() {
    let mut network = Network::new();
    network.preq(1, &[]);
    assert_eq!(network.preq(2, &[]).problem, Some(Problem::PresMissing { node: NodeId(1) }));
    assert_eq!(network.pres(2, NmtStateCode::PRE_OPERATIONAL_2).request, Some(2));
    let late = network.pres(1, NmtStateCode::PRE_OPERATIONAL_2);
    assert_eq!(late.problem, Some(Problem::PresLate { after: Some(Duration::from_millis(3)) }));
    assert_eq!(network.pres(2, NmtStateCode::PRE_OPERATIONAL_2).problem, Some(Problem::PresWithoutPreq));
    assert_eq!(network.soa(RequestedService::NO_SERVICE, 0, false).problem, None);
    let node = network.monitor.node(NodeId(1)).unwrap();
    assert_eq!((node.polls, node.pres_missing, node.pres_late, node.mac), (1, 1, 1, Some(mac(1))));
}

/// How late is not known.
#[test]
fn a_late_pres_after_a_clock_was_set_back() {
    let mut network = Network::new();
    network.at = Instant::from_millis(10);
    network.preq(1, &[]);
    network.preq(2, &[]);
    network.at = Instant::ZERO;
    let late = network.pres(1, NmtStateCode::PRE_OPERATIONAL_2);
    assert_eq!(late.problem, Some(Problem::PresLate { after: None }));
    assert_eq!(late.note, Some(Note::ClockBack { by: Duration::from_millis(11) }));
}

/// A capture that starts in the middle of a cycle, and PRes chaining, which knows no PReq.
#[test]
fn a_pres_of_a_node_that_was_never_polled_is_no_problem() {
    let mut network = Network::new();
    assert_eq!(network.pres(1, NmtStateCode::OPERATIONAL).problem, None);
    assert_eq!(network.pres(1, NmtStateCode::OPERATIONAL).problem, None);
}

#[test]
fn states_need_the_commands_that_lead_there() {
    let mut network = Network::new();
    let poll = |network: &mut Network, state| {
        network.preq(1, &[]);
        network.pres(1, state).problem
    };
    let before = NmtStateCode::PRE_OPERATIONAL_2;
    assert_eq!(poll(&mut network, NmtStateCode::PRE_OPERATIONAL_1), None);
    assert_eq!(poll(&mut network, before), None, "with any SoC");
    assert_eq!(poll(&mut network, NmtStateCode::PRE_OPERATIONAL_1), None, "after a cycle error");
    assert_eq!(poll(&mut network, before), None);
    assert_eq!(
        poll(&mut network, NmtStateCode::READY_TO_OPERATE),
        Some(Problem::StateCannotFollow { before })
    );
    network.command(1, NmtCommandId::START_NODE);
    assert_eq!(poll(&mut network, NmtStateCode::OPERATIONAL), None);
    network.command(2, NmtCommandId::STOP_NODE);
    assert_eq!(
        poll(&mut network, NmtStateCode::STOPPED),
        Some(Problem::StateCannotFollow { before: NmtStateCode::OPERATIONAL })
    );
    let node = network.monitor.node(NodeId(1)).unwrap();
    let states: Vec<_> = node.history.iter().map(|change| (change.n, change.state)).collect();
    assert_eq!(states[0], (2, NmtStateCode::PRE_OPERATIONAL_1));
    assert_eq!((states.len(), states[6].1, node.forgotten), (7, NmtStateCode::STOPPED, 0));
}

/// What was commanded before the capture began is not known.
#[test]
fn the_first_change_of_state_is_believed() {
    let mut network = Network::new();
    assert_eq!(network.pres(1, NmtStateCode::PRE_OPERATIONAL_2).problem, None);
    assert_eq!(network.pres(1, NmtStateCode::READY_TO_OPERATE).problem, None);
}

#[test]
fn a_history_keeps_the_last_states() {
    let mut network = Network::new();
    for _ in 0..10 {
        network.pres(1, NmtStateCode::PRE_OPERATIONAL_1);
        network.pres(1, NmtStateCode::PRE_OPERATIONAL_2);
    }
    let node = network.monitor.node(NodeId(1)).unwrap();
    assert_eq!((node.history.len(), node.forgotten), (MAX_HISTORY, 4));
    assert_eq!(node.history.last().unwrap().n, 20);
}

#[test]
fn more_process_data_than_the_node_takes() {
    let mut network = Network::new();
    network.soa(RequestedService::IDENT_REQUEST, 1, false);
    let mut bytes = [0; 158];
    (bytes[12], bytes[14]) = (36, 1);
    let ident = IdentResponse::parse(&bytes).unwrap();
    assert_eq!(network.send(255, 1, Body::IdentResponse(ident)).problem, None);
    assert_eq!(network.preq(1, &[0; 36]).problem, None);
    let node = NodeId(1);
    assert_eq!(
        network.pres(1, NmtStateCode::PRE_OPERATIONAL_2).problem,
        Some(Problem::SizeOver { node, limit: 1, size: 2 })
    );
    // Vector 64 of the protocol: 37 bytes with a limit of 36.
    assert_eq!(network.preq(1, &[0; 37]).problem, Some(Problem::SizeOver { node, limit: 36, size: 37 }));
}
