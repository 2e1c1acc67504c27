//! Every transition of the managing node and of its nodes is taken by some network.

use std::collections::HashSet;

use devicenet_tests::powerlink::{Event, Net, config, plan};
use powerlink_core::dictionary::ObjectAddress;
use powerlink_core::ethernet::group;
use powerlink_core::managing::{MN_EDGES, MnEvent, NODE_EDGES, NodePlan, ObjectWrite};
use powerlink_core::wire::{
    AsyncRequest, Body, Flags, Frame, NmtCommandId, NmtStateCode, Soc, StatusResponse,
};
use powerlink_core::{MacAddress, NodeId};
use transport_mock::ethernet::{Fate, Record, SegmentConfig, rate};

/// What was taken, and in which networks.
#[derive(Default)]
struct Taken {
    mn: HashSet<String>,
    nodes: HashSet<String>,
}

impl Taken {
    fn take(&mut self, net: &mut Net) {
        for record in net.segment.take_records() {
            match record {
                Record::Event { event: Event::Mn(MnEvent::StateChanged { from, to, cause }), .. } => {
                    self.mn.insert(format!("| {from} | {cause} | {to} |"));
                }
                Record::Event { event: Event::Mn(MnEvent::NodeChanged { from, to, cause, .. }), .. } => {
                    self.nodes.insert(format!("| {from} | {cause} | {to} |"));
                }
                _ => {}
            }
        }
    }
}

/// A foreign managing node says one word, or the own one is stopped, or it resets all, at every moment of a boot.
fn interrupted(taken: &mut Taken, interrupt: impl Fn(&mut Net)) {
    for moment in (0..200).step_by(2) {
        let mut net = Net::new(1);
        net.run(moment);
        interrupt(&mut net);
        net.run(20);
        taken.take(&mut net);
    }
}

#[test]
fn every_edge_is_taken() {
    let mut taken = Taken::default();
    interrupted(&mut taken, |net| net.segment.inject(&foreign_soc()));
    interrupted(&mut taken, |net| net.mn(|mn, now| mn.stop(now)));
    interrupted(&mut taken, |net| {
        net.mn(|mn, _| mn.command(NodeId(1), NmtCommandId::RESET_COMMUNICATION).unwrap());
    });
    interrupted(&mut taken, |net| net.segment.inject(&restarted()));
    // Lost in other ways.
    for seed in 0..20 {
        let mut net = Net::new(2);
        net.run(seed);
        net.segment.add_fault(rate(seed, 0.5, Fate::Lose));
        net.run(1_500);
        taken.take(&mut net);
    }
    stopped(&mut taken);
    refused(&mut taken);
    stuck(&mut taken);
    stopped_in_the_handshake(&mut taken);
    let missed: Vec<_> =
        NODE_EDGES.iter().map(ToString::to_string).filter(|edge| !taken.nodes.contains(edge)).collect();
    assert_eq!(missed, [""; 0]);
    let missed: Vec<_> =
        MN_EDGES.iter().map(ToString::to_string).filter(|edge| !taken.mn.contains(edge)).collect();
    assert_eq!(missed, [""; 0]);
}

/// Stopped from every state, and lost or reset there.
fn stopped(taken: &mut Taken) {
    use NmtCommandId as Command;
    let orders: [&[Command]; 4] = [
        &[Command::STOP_NODE, Command::ENTER_PRE_OPERATIONAL_2, Command::STOP_NODE, Command::RESET_NODE],
        &[Command::ENTER_PRE_OPERATIONAL_2, Command::ENABLE_READY_TO_OPERATE, Command::START_NODE],
        &[Command::STOP_NODE],
        &[Command::ENTER_PRE_OPERATIONAL_2],
    ];
    for (number, orders) in orders.into_iter().enumerate() {
        let mut net = Net::new(1);
        net.run_until_complete(2_000);
        for order in orders {
            net.mn(|mn, _| mn.command(NodeId(1), *order).unwrap());
            net.run(200);
        }
        if number == 2 {
            net.segment.inject(&restarted());
        }
        net.run(100);
        taken.take(&mut net);
    }
}

/// Another device, another device on the way, an object that it does not have, and a managing node that is stopped then.
fn refused(taken: &mut Taken) {
    const WRITES: &[ObjectWrite<'_>] = &[ObjectWrite::new(ObjectAddress::new(0x2FFF, 0), &[1])];
    let mut net =
        Net::with(config(), &[NodePlan { vendor_id: Some(9), ..plan(1) }], SegmentConfig::default());
    net.run(800);
    net.mn(|mn, now| mn.stop(now));
    taken.take(&mut net);
    let mut net = Net::with(config(), &[NodePlan { writes: WRITES, ..plan(1) }], SegmentConfig::default());
    net.run(500);
    taken.take(&mut net);
    // The serial number, then 0x1F98/4, of the second IdentResponse.
    for offset in [56, 30] {
        let mut net = Net::new(1);
        let mut seen = 0;
        net.segment.add_fault(move |passage| {
            if !matches!(Frame::parse(passage.bytes).unwrap().body, Body::IdentResponse(_)) {
                return Fate::Pass;
            }
            seen += 1;
            let mut bytes = passage.bytes.to_vec();
            bytes[offset] ^= 0x80;
            if seen == 2 { Fate::Replace(bytes) } else { Fate::Pass }
        });
        net.run(500);
        taken.take(&mut net);
    }
}

/// EC stays what it was: set, then not set.
fn stuck(taken: &mut Taken) {
    for flags in [Flags::EXCEPTION_CLEAR, Flags::empty()] {
        let mut net = Net::new(1);
        net.segment.add_fault(move |passage| {
            if !matches!(Frame::parse(passage.bytes).unwrap().body, Body::StatusResponse(_)) {
                return Fate::Pass;
            }
            let mut bytes = passage.bytes.to_vec();
            bytes[18] = flags.bits();
            Fate::Replace(bytes)
        });
        net.run(500);
        taken.take(&mut net);
    }
}

/// A StatusResponse does not arrive, and the managing node is stopped while it asks again.
fn stopped_in_the_handshake(taken: &mut Taken) {
    for lost in [Flags::EXCEPTION_CLEAR, Flags::empty()] {
        for moment in 60..90 {
            let mut net = Net::new(1);
            net.segment.add_fault(move |passage| match Frame::parse(passage.bytes).unwrap().body {
                Body::StatusResponse(status) if status.flags == lost => Fate::Lose,
                _ => Fate::Pass,
            });
            net.run(moment);
            net.mn(|mn, now| mn.stop(now));
            taken.take(&mut net);
        }
    }
}

/// A SoC of a managing node that is not there.
fn foreign_soc() -> Vec<u8> {
    emitted(0x57, group::SOC, NodeId::MANAGING_NODE, Body::Soc(Soc::default()))
}

/// A StatusResponse of node 1, at its MAC address, with EC=1, as after a power cycle.
pub(crate) fn restarted() -> Vec<u8> {
    let status = StatusResponse {
        flags: Flags::EXCEPTION_CLEAR,
        request: AsyncRequest::NONE,
        state: NmtStateCode::PRE_OPERATIONAL_1,
        static_errors: [0; 8],
        entries: Default::default(),
    };
    emitted(1, group::ASND, NodeId(1), Body::StatusResponse(status))
}

fn emitted(mac: u8, destination: MacAddress, from: NodeId, body: Body<'_>) -> Vec<u8> {
    let (source, to) = (MacAddress([2, 0, 0, 0, 0, mac]), NodeId::BROADCAST);
    Frame { destination, source, to, from, body }.emit(&mut [0; 128]).unwrap().to_vec()
}
