//! openPOWERLINK 2.7.2 boots its controlled node. Every frame is read and written again, and our node gets the requests that
//! theirs got.

use link_core::Instant;
use link_core::codec::Writer;
use link_core::ethernet::{Action, Input, Machine};
use powerlink_core::dictionary::{Access, Device, Entry, Mappable, ObjectAddress, ObjectSet, ObjectType};
use powerlink_core::ethernet::{MAX_FRAME, MIN_FRAME};
use powerlink_core::nmt::NmtState;
use powerlink_core::node::{Config, NodeEvent};
use powerlink_core::wire::{AbortCode, Body, Frame, Identity};
use powerlink_core::{ControlledNode, MacAddress, NodeId};

use crate::recording::frames;

#[test]
fn every_frame_is_read_and_written_again() {
    let recorded = frames("boot.pcap");
    assert_eq!(recorded.len(), 640);
    for (number, (_, bytes)) in (1..).zip(&recorded) {
        let frame = Frame::parse(bytes).unwrap_or_else(|error| panic!("frame {number}: {error}"));
        assert!(!matches!(frame.body, Body::Other(..) | Body::OtherAsnd(..)), "frame {number}: {frame}");
        let mut buffer = [0xA5; MAX_FRAME];
        let mut padded = bytes.clone();
        padded.resize(bytes.len().max(MIN_FRAME), 0);
        assert_eq!(frame.emit(&mut buffer).unwrap(), padded, "frame {number}: {frame}");
    }
}

/// The digital inputs and outputs of the recorded node, after CiA 401.
#[derive(Clone, Debug, Default)]
struct DigitalIo {
    inputs: u8,
    outputs: u8,
}

impl ObjectSet for DigitalIo {
    const ENTRIES: &'static [Entry] = &[
        Entry::new(0x6000, 1, "inputs", ObjectType::Unsigned(1), Access::ReadOnly).mapped(Mappable::Transmit),
        Entry::new(0x6200, 1, "outputs", ObjectType::Unsigned(1), Access::ReadWrite)
            .mapped(Mappable::Receive),
    ];

    fn read(&self, at: ObjectAddress, out: &mut Writer<'_>) -> Result<(), AbortCode> {
        let value = if at.index == 0x6000 { self.inputs } else { self.outputs };
        out.u8(value).map_err(|_| AbortCode::OUT_OF_MEMORY)
    }

    fn write(&mut self, _: ObjectAddress, data: &[u8]) -> Result<(), AbortCode> {
        self.outputs = *data.first().ok_or(AbortCode::LENGTH)?;
        Ok(())
    }

    fn restore(&mut self) {
        self.outputs = 0;
    }
}

/// A node with the identity of the recorded one.
fn node() -> ControlledNode<DigitalIo> {
    let identity = Identity { vendor_id: 0, product_code: 0, revision: 0x0002_0007, serial_number: 0 };
    let device = Device { device_type: 0x000F_0191, ..Device::new(identity) };
    let mut config = Config::new(NodeId(1), MacAddress([2, 0, 0, 0, 0, 1]), device).unwrap();
    config.values.async_mtu = 1500;
    // As theirs does.
    config.options.clears_before_answer = false;
    config.values.host_name[..11].copy_from_slice(b"01-ffffffff");
    let mut node = ControlledNode::new(config, DigitalIo::default()).unwrap();
    node.power_on(Instant::ZERO);
    node
}

/// All that a node does now.
fn drain(node: &mut ControlledNode<DigitalIo>, now: Instant) -> (Vec<Vec<u8>>, Vec<NodeEvent>) {
    let (mut sent, mut events) = (Vec::new(), Vec::new());
    let mut buffer = [0xA5; MAX_FRAME];
    while let Some(action) = node.poll(now, &mut buffer) {
        match action {
            Action::Transmit(bytes) => sent.push(bytes.to_vec()),
            Action::Event(event) => events.push(event),
        }
    }
    (sent, events)
}

#[test]
fn our_node_in_the_place_of_theirs_becomes_operational() {
    let recorded = frames("boot.pcap");
    let mut node = node();
    drain(&mut node, Instant::ZERO);
    let (mut ours, mut states, mut compared) = (None, Vec::new(), 0);
    for (number, (now, bytes)) in (1..).zip(&recorded) {
        let frame = Frame::parse(bytes).unwrap();
        if frame.from != NodeId::MANAGING_NODE {
            let ours: Vec<u8> =
                ours.take().unwrap_or_else(|| panic!("frame {number}, {frame}: we say nothing"));
            assert_eq!(comparable(&ours), comparable(bytes), "frame {number}: {frame}");
            compared += 1;
            continue;
        }
        // Their node takes long to reset: meanwhile ours answers alone.
        let is_early = ours.take().is_some();
        assert!(!is_early || RESETS.iter().any(|reset| reset.contains(&number)), "frame {number}");
        node.input(*now, Input::Frame(bytes));
        let (sent, events) = drain(&mut node, *now);
        assert!(sent.len() <= 1, "frame {number}: one answer at most");
        ours = sent.into_iter().next();
        for event in events {
            match event {
                NodeEvent::StateChanged { to, .. } => states.push((number, to)),
                NodeEvent::BadFrame(_) | NodeEvent::BufferTooShort | NodeEvent::Error(_) => {
                    panic!("frame {number}: {event}")
                }
                _ => {}
            }
        }
    }
    // The events of the recording: reset, configuration, first SoC, enabled, started. The frames that show the new state
    // are one poll behind.
    assert_eq!(
        states,
        [
            (1, NmtState::PreOperational1),
            (12, NmtState::ResetApplication),
            (12, NmtState::ResetCommunication),
            (12, NmtState::ResetConfiguration),
            (12, NmtState::NotActive),
            (13, NmtState::PreOperational1),
            (388, NmtState::ResetConfiguration),
            (388, NmtState::NotActive),
            (389, NmtState::PreOperational1),
            (491, NmtState::PreOperational2),
            (515, NmtState::ReadyToOperate),
            (545, NmtState::Operational),
        ]
    );
    assert_eq!(compared, ANSWERS);
    assert_eq!(node.dictionary().values.cycle_length, 20_000);
}

/// A frame without what two right nodes may do differently: PR, RS and the state of an IdentResponse or StatusResponse, which
/// theirs renews at SoA only; the features of an IdentResponse; the inputs of the application.
fn comparable(bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    match Frame::parse(&bytes).unwrap().body {
        Body::IdentResponse(_) => {
            bytes[19..21].fill(0);
            bytes[24..28].fill(0);
        }
        Body::StatusResponse(_) => bytes[19..21].fill(0),
        Body::Pres(_) => bytes[24..].fill(0),
        _ => {}
    }
    bytes
}

/// All frames of their node.
const ANSWERS: usize = 111;
/// The frames between a reset and their node's first IdentResponse after it.
const RESETS: [std::ops::RangeInclusive<usize>; 2] = [1..=113, 388..=489];
