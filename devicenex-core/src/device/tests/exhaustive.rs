//! Everything that two connections can come to, by requests, messages, time and the loss of the address.

use core::time::Duration;
use link_core::machine_laws::reachable;
use link_core::{Action, Input, Instant, LinkEvent, Machine, TxOutcome};

use super::bus::{Bus, Station, frame};
use crate::device::{Counters, Device};

/// Two connections, and the present is always zero.
type Node = Device<Station, 8, 2>;

#[derive(Clone, Copy, Debug)]
enum Step {
    /// A consumer (instance 13), EPR 2500 ms, with this action.
    Consumer(u8),
    /// A cyclic producer with acknowledges (instance 11), EPR 2500 ms.
    Producer,
    /// What the consumer consumes.
    Message,
    /// The acknowledge of what the producer produced.
    Acknowledge,
    /// The next deadline.
    Time,
    /// The link is lost and comes back; the address is kept.
    Link,
}

const STEPS: [Step; 8] = [
    Step::Consumer(0),
    Step::Consumer(1),
    Step::Consumer(2),
    Step::Producer,
    Step::Message,
    Step::Acknowledge,
    Step::Time,
    Step::Link,
];

fn step(node: &Node, step: Step) -> Option<Node> {
    let mut node = node.clone();
    let mut now = Instant::ZERO;
    match step {
        Step::Consumer(action) => hears(&mut node, 0x1D86_0209, &[0x4B, 0xC0, 13, 0, 0xC4, 0x09, action]),
        Step::Producer => hears(&mut node, 0x1D86_0209, &[0x4B, 0xC0, 11, 0, 0xC4, 0x09, 0]),
        Step::Message => hears(&mut node, 0x0002_0007, &[1]),
        Step::Acknowledge => hears(&mut node, 0x0003_C30B, &[]),
        Step::Time => {
            now = node.deadline()?.at;
            node.input(now, Input::Tick);
        }
        Step::Link => {
            node.input(now, Input::Link(LinkEvent::Down));
            drain(&mut node, now);
            assert_eq!(node.connections().count(), 0);
            return None;
        }
    }
    drain(&mut node, now);
    let deadline = node.deadline().map(|deadline| deadline.at);
    assert!(deadline.is_none_or(|at| at > now), "nothing is overdue");
    // An established consumer that can time out waits for something.
    let waits = node.connections().any(|one| one.state.0 == 3);
    assert!(!waits || deadline.is_some());
    node.shift_time(now.saturating_since(Instant::ZERO));
    node.counters = Counters::default();
    node.application.rests.clear();
    Some(node)
}

fn hears(node: &mut Node, id: u32, data: &[u8]) {
    node.input(Instant::ZERO, Input::Frame(frame(id, data)));
}

fn drain(node: &mut Node, now: Instant) {
    while let Some(action) = node.poll(now) {
        if let Action::Transmit(token, _) = action {
            node.input(now, Input::TxDone(token, TxOutcome::Sent));
        }
    }
}

#[test]
fn two_connections_come_to_an_end() {
    let bus = Bus::new();
    let mut config = crate::device::Config::new(
        &super::bus::identity(),
        crate::message::PortByte::ZERO,
        crate::access::Role::Device,
    );
    config.access.announcement = 0;
    // So that every wait is a multiple of it.
    config.acknowledge.timer = 2500;
    let mut start = Node::new(config, super::bus::station()).unwrap();
    start.access = bus.node.access;
    start.online = true;
    start.shift_time(Duration::MAX);
    drain(&mut start, Instant::ZERO);
    let worlds = reachable(start, &STEPS, step, 100_000);
    let has = |states: &[u8]| {
        worlds.iter().any(|node| node.connections().map(|one| one.state.0).eq(states.iter().copied()))
    };
    for states in [&[][..], &[3], &[4], &[3, 3], &[3, 4], &[4, 4]] {
        assert!(has(states), "{states:?} of {}", worlds.len());
    }
}
