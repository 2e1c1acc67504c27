//! A bus that is split, and joined again.

use link_core::{LinkEvent, TxOutcome};
use transport_mock::{Change, ErrorState, Fault, FaultId, Scope};

use crate::harness::{Bench, data};

#[test]
fn each_segment_is_a_bus_of_its_own() {
    let mut bench = Bench::new(4);
    let apart = vec![bench.id(2), bench.id(3)];
    bench.change(Change::Split(apart));
    bench.run_bits(20);
    // At the same time, with the same identifier.
    bench.send(0, data(0x100, &[1]));
    bench.send(2, data(0x100, &[2]));
    bench.run_bits(100);
    assert_eq!(bench.probe(1).frames(), [data(0x100, &[1])]);
    assert_eq!(bench.probe(3).frames(), [data(0x100, &[2])]);
    assert_eq!(bench.frames[0].start, bench.frames[1].start);

    bench.change(Change::Join);
    bench.run_bits(20);
    bench.send(0, data(0x100, &[3]));
    bench.run_bits(100);
    assert!((1..4).all(|node| bench.probe(node).frames().last() == Some(&data(0x100, &[3]))));
}

#[test]
fn a_node_that_is_left_alone_is_not_acknowledged_until_it_is_joined() {
    let mut bench = Bench::new(3);
    let apart = bench.id(0);
    bench.change(Change::Split(vec![apart]));
    bench.send(0, data(0x100, &[1]));
    bench.run_bits(10_000);
    assert_eq!(bench.network.error_state(apart), Some(ErrorState::Passive));
    assert!(bench.probe(0).link_events().contains(&LinkEvent::ErrorPassive));
    assert!(bench.probe(0).outcomes().is_empty());
    bench.change(Change::Join);
    bench.run_bits(1_000);
    assert_eq!(bench.probe(0).outcomes(), [TxOutcome::Sent]);
}

#[test]
fn a_cable_that_breaks_under_a_frame_leaves_a_sender_without_acknowledgement() {
    let mut bench = Bench::new(3);
    bench.send(0, data(0x100, &[0; 8]));
    bench.run_bits(30);
    let apart = bench.id(0);
    bench.change(Change::Split(vec![apart]));
    bench.run_bits(150);
    assert!(bench.probe(1).frames().is_empty());
    assert!(bench.counters(0).0 >= 8);
    assert_eq!(bench.counters(1).1, 1, "a stuff error: the line went silent");
    bench.change(Change::Join);
    bench.run_bits(1_000);
    assert_eq!(bench.probe(1).frames(), [data(0x100, &[0; 8])]);
}

/// The bits of the slow node lie between those of the others, whose segment is disturbed as well.
#[test]
fn a_disturbed_segment_does_not_begin_before_the_present_bit_of_another() {
    let mut bench = Bench::new(2);
    bench.change(Change::SetClock(bench.id(0), -10_000));
    bench.change(Change::Split(vec![bench.id(0)]));
    bench.run_bits(10);
    let flip = Fault::FlipBit { frame: 0, bit: 0, scope: Scope::Bus };
    bench.change(Change::FaultOn(FaultId(1), flip));
    bench.run_bits(20);
    bench.send(1, data(0x000, &[]));
    bench.send(0, data(0x001, &[]));
    bench.run_bits(400);
    assert!(bench.frames.is_sorted_by_key(|seen| seen.end), "{:#?}", bench.lines);
}
