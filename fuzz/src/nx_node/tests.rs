//! The operations do what they say, and the oracle sees it.

use super::*;
use devicenex_core::access::StateKind;
use devicenex_core::message::ConnectionInstance;

/// Two bytes in, one byte out.
const PLAIN: [u8; 3] = [2, 1, 0];
const SENT: [u8; 1] = [10];
/// Explicit connection, EPR 0, action 1.
const EXPLICIT: [u8; 6] = [5, 0, 1, 0, 0, 1];
/// Polled with 29 bits, EPR 100 ms, action 0.
const POLLED: [u8; 6] = [5, 0, 3, 100, 0, 0];
/// One byte for the second connection.
const POLL: [u8; 4] = [9, 1, 1, 0xA5];

fn after(ops: &[&[u8]]) -> Node {
    let bytes = [&PLAIN[..], &ops.concat()].concat();
    run(&bytes);
    let mut input = Unstructured::new(&bytes);
    let (config, station, _) = station::config(&mut input).unwrap();
    let mut node = Node::new(config, station, false);
    node.bring_up();
    while !input.is_empty() {
        node.apply(ops::op(&mut input).unwrap());
    }
    node
}

fn states(node: &Node) -> Vec<(u16, u8)> {
    let mut states: Vec<_> =
        node.device.connections().map(|one| (one.instance.number().0, one.state.0)).collect();
    states.sort_unstable();
    states
}

#[test]
fn a_device_is_polled() {
    let node = after(&[&EXPLICIT, &SENT, &POLLED, &SENT, &POLL]);
    assert_eq!(states(&node), [(1, 3), (3, 3)]);
    assert_eq!((&node.device.application().outputs[..], node.in_flight.len()), (&[0xA5][..], 1));
}

#[test]
fn a_device_loses_its_peer_and_its_address() {
    let node = after(&[&EXPLICIT, &SENT, &POLLED, &SENT, &POLL, &SENT, &[0, 0xC1]]);
    assert_eq!((states(&node), &node.device.application().outputs[..]), (vec![(1, 3), (3, 4)], &[0][..]));
    // A Hello response of another with the own address.
    let node = after(&[&EXPLICIT, &SENT, &POLLED, &SENT, &[0x8E, 9]]);
    assert_eq!(states(&node), []);
    assert!(node.device.access().address().is_none());
}

#[test]
fn what_is_asked_in_fragments_is_answered() {
    let node =
        after(&[&EXPLICIT, &SENT, &[15, 0, 0x2B, 12, 0x10, 5, 3, 14, 0x20, 4, 0x24, 1, 0x30, 3, 0, 0]]);
    assert_eq!((node.device.counters().requests, node.device.counters().refused), (1, 1));
    assert_eq!(node.in_flight.len(), 0);
}

#[test]
fn a_connection_is_seen_through_the_machine() {
    let node = after(&[&POLLED]);
    let one = node.device.connections().next().unwrap();
    assert_eq!(one.instance, ConnectionInstance::of(cip_core::code::InstanceId(3)));
    assert_eq!(node.device.access().state().kind(), StateKind::Online);
}
