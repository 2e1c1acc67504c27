//! Frames of the cycle are lost, below and at the thresholds: who notices, and who does what.
//!
//! A lost frame counts 8, a good cycle takes 1 away, at 15 the node reacts: 0x1C0B for SoC, 0x1C0C for SoA, 0x1C0D for PReq, and
//! 0x1C09 of the managing node for PRes.

use devicenet_tests::powerlink::{Event, Net};
use powerlink_core::managing::MnEvent;
use powerlink_core::nmt::NmtState;
use powerlink_core::node::NodeEvent;
use powerlink_core::wire::{ErrorCode, MessageType};
use transport_mock::ethernet::{Fate, Record, nth};

/// Two nodes in operation.
fn running() -> Net {
    let mut net = Net::new(2);
    assert!(net.run_until_complete(2_000));
    net.run(50);
    net.segment.take_records();
    net
}

/// What both sides say of node 1 when some frames of a kind are lost: those of the managing node on their way to it, or its own
/// on their way to the managing node.
fn lose(kind: MessageType, numbers: std::ops::Range<u64>) -> Vec<String> {
    lose_every(kind, numbers, u64::MAX)
}

/// The same again and again, every so many frames.
fn lose_every(kind: MessageType, numbers: std::ops::Range<u64>, period: u64) -> Vec<String> {
    let mut net = running();
    let (mn, node) = (net.mn, net.id(1));
    let ends = if kind == MessageType::PRES { (node, mn) } else { (mn, node) };
    // A PReq passes both nodes: only that of node 1 is meant.
    let is_meant = move |bytes: &[u8]| bytes[14] == kind.0 && (kind != MessageType::PREQ || bytes[15] == 1);
    let mut seen = 0;
    net.segment.add_fault(move |passage| {
        if (passage.from, passage.to) != (Some(ends.0), ends.1) || !is_meant(passage.bytes) {
            return Fate::Pass;
        }
        seen += 1;
        if numbers.contains(&((seen - 1) % period)) { Fate::Lose } else { Fate::Pass }
    });
    net.run(if period == u64::MAX { 3_000 } else { 1_000 });
    assert_eq!(net.states(), [NmtState::Operational; 2], "both run in the end: {}", net.trace());
    let said = net.segment.records().iter().filter_map(|record| match record {
        Record::Event { station, event: Event::Cn(event), .. } => {
            assert_eq!(*station, node, "the other node goes on: {event}");
            match event {
                NodeEvent::Error(code) => Some(format!("node: {code}")),
                NodeEvent::ResetReason { reason, .. } => Some(format!("node is reset: {reason}")),
                NodeEvent::StateChanged { to: NmtState::PreOperational1, cause, .. } => {
                    Some(format!("node in PreOperational1: {cause}"))
                }
                _ => None,
            }
        }
        Record::Event { event: Event::Mn(MnEvent::NodeLost { node, reason }), .. } => {
            assert_eq!(node.0, 1);
            Some(format!("MN: {reason}"))
        }
        _ => None,
    });
    // Not the reset itself.
    said.filter(|line| !line.ends_with(": SoA") && !line.ends_with(": SoC")).collect()
}

/// One is forgiven, and so is one in ten cycles for ever.
#[test]
fn single_losses_change_nothing() {
    let kinds = [MessageType::SOC, MessageType::SOA, MessageType::PREQ, MessageType::PRES];
    for kind in kinds {
        assert_eq!(lose(kind, 0..1), [""; 0], "{kind}");
        assert_eq!(lose_every(kind, 0..1, 10), [""; 0], "{kind}");
    }
}

#[test]
fn two_losses_in_a_row_are_a_cycle_error() {
    assert_eq!(
        lose(MessageType::SOC, 0..2),
        [
            "node: loss of SoC threshold",
            "node in PreOperational1: cycle error",
            "MN: wrong NMT state",
            "node is reset: wrong NMT state"
        ]
    );
    assert_eq!(
        lose(MessageType::PREQ, 0..2),
        [
            "MN: loss of PRes threshold",
            "node: loss of PReq threshold",
            "node in PreOperational1: cycle error",
            "node is reset: loss of PRes threshold"
        ]
    );
    assert_eq!(
        lose(MessageType::PRES, 0..2),
        ["MN: loss of PRes threshold", "node is reset: loss of PRes threshold"]
    );
    assert_eq!(
        lose(MessageType::SOA, 0..2),
        [
            "node: loss of SoA threshold",
            "node in PreOperational1: cycle error",
            "MN: wrong NMT state",
            "node is reset: wrong NMT state"
        ]
    );
}

/// The second within eight good cycles is one too many, in the ninth it is not.
#[test]
fn the_memory_of_a_loss_is_as_long_as_the_rule_says() {
    let twice = |distance: u64| {
        let mut net = running();
        let (mn, node) = (net.mn, net.id(1));
        let is_pres = move |passage: &transport_mock::ethernet::Passage<'_>| {
            passage.from == Some(node) && passage.to == mn && passage.bytes[14] == MessageType::PRES.0
        };
        net.segment.add_fault(nth(is_pres, 0..1, Fate::Lose));
        net.segment.add_fault(nth(is_pres, distance..distance + 1, Fate::Lose));
        net.run(200);
        let is_lost = |record: &Record<Event>| {
            let reason = ErrorCode::LOSS_OF_PRES_THRESHOLD;
            matches!(record, Record::Event { event: Event::Mn(MnEvent::NodeLost { reason: why, .. }), .. } if *why == reason)
        };
        net.segment.records().iter().any(is_lost)
    };
    // 8 - 1 + 8 = 15 is the threshold; 8 - 2 + 8 is below.
    assert!(twice(1) && twice(2));
    assert!(!twice(3) && !twice(9));
}
