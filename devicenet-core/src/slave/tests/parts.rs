//! A slave without the parts that one may do without.

use cip_core::message::AllocationChoice;
use cip_core::object::Identity;
use link_core::frame::standard_id;
use link_core::{Action, FilterSet, Frame, Input, Instant, LinkEvent, Machine};

use super::bus::{Block, device};
use crate::MacId;
use crate::access::Fault;
use crate::slave::{Application, Config, Group2OnlyServer, InvalidSlave, IoKind, Options, Parts};

#[derive(Clone, PartialEq, Eq, Hash, Debug)]
struct Small(Block);

impl Application for Small {
    const IO: AllocationChoice = Block::IO;
    const PARTS: Parts = Parts::empty();
    type Long = ();

    fn identity(&self) -> Identity<'_> {
        self.0.identity()
    }

    fn produced(&self, connection: IoKind) -> &[u8] {
        self.0.produced(connection)
    }

    fn consumed(&mut self, connection: IoKind) -> &mut [u8] {
        self.0.consumed(connection)
    }
}

/// Of a configuration.
type Change = fn(&mut Config);

fn block() -> Block {
    Block { device: device(), inputs: [0; 2], outputs: [0] }
}

#[test]
fn what_is_left_out_cannot_be_configured() {
    let refused = |change: Change| {
        let mut config = Config::new(&device(), MacId::DEFAULT);
        change(&mut config);
        Group2OnlyServer::<Small>::new(config, Small(block())).err()
    };
    assert_eq!(refused(|_| {}), None);
    let cases: [(Change, Parts); 3] = [
        (|config| config.bit_rate.detect = true, Parts::BIT_RATE_DETECTION),
        (|config| config.heartbeat_interval = Some(0), Parts::HEARTBEAT),
        (|config| config.options.insert(Options::SHUTDOWN_MESSAGE), Parts::SHUTDOWN_MESSAGE),
    ];
    for (change, part) in cases {
        assert_eq!(refused(change), Some(InvalidSlave::PartLeftOut(part)));
    }
}

/// A node that a duplicate keeps off line hears the offline connection set only if it has that part.
#[test]
fn without_the_offline_set_a_fault_is_silence() {
    let config = Config::new(&device(), MacId::DEFAULT);
    let mut small = Group2OnlyServer::<Small>::new(config.clone(), Small(block())).unwrap();
    assert_eq!(answers_to_who(&mut small), 0);
    assert_eq!(small.access().filter(), FilterSet::none());
    let mut complete = Group2OnlyServer::<Block>::new(config, block()).unwrap();
    assert_eq!(answers_to_who(&mut complete), 1);
}

/// How often a node that is faulted by a duplicate answers the question who is there.
fn answers_to_who<A: Application>(slave: &mut Group2OnlyServer<A>) -> usize {
    let frame = |id, data: &[u8]| Input::Frame(Frame::new(standard_id(id), data).unwrap());
    slave.handle(Instant::ZERO, Input::Link(LinkEvent::Up)).for_each(drop);
    // Another node has MAC ID 63: its duplicate MAC ID check response.
    slave.handle(Instant::ZERO, frame(0x5FF, &[0x80, 1, 0, 2, 0, 0, 0])).for_each(drop);
    assert_eq!(slave.access().fault(), Some(Fault::DuplicateMacId));
    // The request was with the controller.
    let given_back = Input::TxDone(crate::access::Access::TOKEN, link_core::TxOutcome::Withdrawn);
    slave.handle(Instant::ZERO, given_back).for_each(drop);
    // Who, every node; the delay is the port number, 0.
    let actions = slave.handle(Instant::ZERO, frame(0x7ED, &[0x3F, 0x4B, 0x00]));
    actions.filter(|action| matches!(action, Action::Transmit(..))).count()
}
