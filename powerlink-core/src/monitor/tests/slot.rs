//! The asynchronous slot, and the handshake of error signalling.

use super::*;

#[test]
fn an_invitation_is_answered_by_its_target_once() {
    let mut network = Network::new();
    // Before the first SoA nobody knows.
    assert_eq!(network.status(1, Flags::empty()).problem, None);
    network.soa(RequestedService::STATUS_REQUEST, 1, false);
    assert_eq!(network.status(2, Flags::empty()).problem, Some(Problem::NotInvited));
    let answer = network.status(1, Flags::empty());
    assert_eq!((answer.problem, answer.request), (None, Some(2)));
    assert_eq!(network.status(1, Flags::empty()).problem, Some(Problem::NotInvited));
    network.soc(0);
    assert_eq!(network.status(1, Flags::empty()).problem, Some(Problem::NotInvited));
    network.soa(RequestedService::UNSPECIFIED_INVITE, 1, false);
    assert_eq!(network.status(1, Flags::empty()).problem, Some(Problem::NotInvited), "asked for another");
}

#[test]
fn a_request_without_answer_is_told_by_the_end_of_the_slot() {
    let mut network = Network::new();
    let ask = |network: &mut Network| network.soa(RequestedService::STATUS_REQUEST, 1, false).problem;
    let service = RequestedService::STATUS_REQUEST;
    let missing = Some(Problem::AnswerMissing { node: NodeId(1), service });
    assert_eq!(ask(&mut network), None);
    assert_eq!(ask(&mut network), None, "nobody knows whether there is a node");
    network.status(1, Flags::empty());
    assert_eq!(ask(&mut network), None);
    assert_eq!(ask(&mut network), missing);
    assert_eq!(network.soc(0).problem, missing);
    assert_eq!(network.monitor.node(NodeId(1)).unwrap().answers_missing, 2);
    // A node that was reset takes its time.
    network.command(255, NmtCommandId::RESET_NODE);
    ask(&mut network);
    assert_eq!(ask(&mut network), None);
    // An invitation need not be used.
    network.status(1, Flags::empty());
    network.soa(RequestedService::UNSPECIFIED_INVITE, 1, false);
    assert_eq!(network.soc(0).problem, None);
}

#[test]
fn ec_follows_er_with_one_response_of_delay() {
    let mut network = Network::new();
    let mut ask = |reset, clear| {
        network.soa(RequestedService::STATUS_REQUEST, 1, reset);
        network.status(1, if clear { Flags::EXCEPTION_CLEAR } else { Flags::empty() }).problem
    };
    assert_eq!(ask(true, true), None);
    assert_eq!(ask(false, true), None, "answered first, updated afterwards");
    assert_eq!(ask(false, false), None);
    assert_eq!(ask(true, false), None);
    assert_eq!(ask(true, false), Some(Problem::HandshakeNotAnswered { responses: 2 }));
    assert_eq!(ask(true, true), None);
}
