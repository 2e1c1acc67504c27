//! Nodes at the wrong bit rate, and clocks that are off.

use link_core::{BitRate, LinkCommand, LinkEvent, Mode, TxOutcome};
use transport_mock::Change;
use transport_mock::record::Outcome;

use crate::harness::{Bench, data};

fn rate(bench: &mut Bench, node: usize, bit_rate: BitRate, listen_only: bool) {
    bench.tell(node, |probe| probe.link(LinkCommand::SetMode(Mode { bit_rate, listen_only })));
    // The slow ones need some bits of theirs to join.
    bench.run_bits(200);
}

#[test]
fn a_listener_at_the_wrong_rate_reports_errors_and_harms_nobody() {
    for wrong in [BitRate::K125, BitRate::K250, BitRate::M1] {
        let mut bench = Bench::new(3);
        rate(&mut bench, 2, wrong, true);
        for n in 0..5 {
            bench.send(0, data(0x123, &[n, 0x55, 0xAA]));
            bench.run_bits(400);
        }
        assert_eq!(bench.probe(0).outcomes(), [TxOutcome::Sent; 5], "{wrong}");
        assert_eq!(bench.probe(1).frames().len(), 5, "{wrong}");
        assert!(bench.probe(2).frames().is_empty(), "{wrong}");
        let heard = bench.probe(2).link_events();
        assert!(heard.iter().any(|event| matches!(event, LinkEvent::BusError(_))), "{wrong}: {heard:?}");
        assert_eq!(bench.counters(0), (0, 0), "{wrong}");
    }
}

#[test]
fn a_normal_node_at_the_wrong_rate_destroys_what_it_hears() {
    for wrong in [BitRate::K125, BitRate::K250] {
        let mut bench = Bench::new(3);
        rate(&mut bench, 2, wrong, false);
        // A slow node may notice only after a frame what it was, so that its flag hits the next one.
        for n in 0..4 {
            bench.send(0, data(0x123, &[n, 2, 3]));
        }
        bench.run_bits(2_000);
        assert!(
            bench.frames.iter().any(|seen| matches!(seen.outcome, Outcome::Error(_))),
            "{wrong} {:#?}",
            bench.lines
        );
        let most = bench.counters.iter().map(|(.., counters)| counters.tec).max();
        assert!(most >= Some(8), "{wrong}: TEC {most:?}");
    }
}

#[test]
fn a_sender_at_the_wrong_rate_disturbs_all_others() {
    let mut bench = Bench::new(3);
    rate(&mut bench, 2, BitRate::K125, false);
    bench.send(2, data(0x123, &[1, 2, 3]));
    bench.run_bits(4_000);
    assert!(bench.probe(0).frames().is_empty() && bench.probe(1).frames().is_empty());
    assert!(bench.counters(2).0 >= 8);
    for node in 0..2 {
        let heard = bench.probe(node).link_events();
        assert!(heard.iter().any(|event| matches!(event, LinkEvent::BusError(_))), "node {node}: {heard:?}");
    }
}

#[test]
fn when_all_change_the_rate_all_is_well() {
    let mut bench = Bench::new(3);
    for node in 0..3 {
        rate(&mut bench, node, BitRate::K125, false);
    }
    bench.send(0, data(0x123, &[1]));
    bench.run_bits(1_000);
    assert_eq!(bench.probe(0).outcomes(), [TxOutcome::Sent]);
    let seen = &bench.frames[0];
    assert_eq!(seen.end.as_nanos() - seen.start.as_nanos(), u64::from(seen.frame.bit_len()) * 8_000);
}

#[test]
fn clocks_within_the_tolerance_understand_each_other_and_others_do_not() {
    // 0.4 % is in step by definition; 0.9 % apart is still within what resynchronisation can follow; 8 % is not.
    for (ppm, works) in
        [(4_000, true), (-4_000, true), (9_000, true), (-9_000, true), (80_000, false), (-80_000, false)]
    {
        let mut bench = Bench::new(3);
        let node = bench.id(0);
        bench.change(Change::SetClock(node, ppm));
        bench.run_bits(100);
        bench.send(0, data(0x0F1, &[0xFF, 0x00, 0xFF, 0x00]));
        bench.run_bits(300);
        let sent = bench.probe(0).outcomes() == [TxOutcome::Sent];
        assert_eq!(sent, works, "{ppm} ppm: {:#?}", bench.lines);
    }
}

#[test]
fn a_fast_clock_makes_short_waits() {
    use link_core::Instant;
    use std::time::Duration;
    use transport_mock::{BusConfig, Ignore, Network, NodeConfig, nodes};
    let mut network = Network::<()>::new(BusConfig::new(BitRate::K500, 1));
    let fast = NodeConfig { clock_ppm: 1_000, ..NodeConfig::named("fast") };
    network.add_silent(fast, nodes::Babbler::new(data(0x100, &[]), Duration::from_millis(100)));
    let listener = network.add_silent(NodeConfig::named("other"), nodes::Listener::new(100));
    network.run_until(Instant::from_millis(1_000), &mut Ignore);
    let at: Vec<Instant> =
        network.machine::<nodes::Listener>(listener).unwrap().frames().map(|(at, _)| *at).collect();
    let gap = at[2].as_nanos() - at[1].as_nanos();
    // 100 ms by its clock are 100 ms / 1.001.
    let expected = 100_000_000 * 1_000 / 1_001;
    assert!(gap.abs_diff(expected) <= 2_000, "{gap} for {expected}: the start waits for the next bit");
}

/// With a node at half the bit rate, the next attempt begins while that node still takes the last one for its own.
#[test]
fn an_attempt_that_the_next_one_overtakes_is_recorded_as_itself() {
    let mut bench = Bench::new(3);
    bench.change(Change::SetBitRate(bench.id(2), BitRate::K250));
    bench.run_bits(40);
    bench.send(0, data(0x100, &[1, 2, 3]));
    bench.send(1, data(0x101, &[0xFF; 8]));
    bench.send(2, data(0x0FF, &[]));
    bench.run_bits(200);
    assert_eq!(bench.frames[0].senders.len(), 3, "all three began the first one: {:#?}", bench.lines);
    for pair in bench.frames.windows(2) {
        assert!(pair[0].start < pair[0].end && pair[0].start < pair[1].start, "{:#?}", bench.lines);
    }
}

/// A listener at another rate takes the others out of step, and changes nothing about when their frames are over.
#[test]
fn a_listener_at_another_rate_does_not_change_the_length_of_a_frame() {
    let lengths = |other: BitRate, acknowledged: bool| {
        let mut bench = Bench::new(3);
        rate(&mut bench, 1, BitRate::K500, !acknowledged);
        rate(&mut bench, 2, other, true);
        bench.send(0, data(0x123, &[1, 2, 3]));
        bench.run_bits(200);
        let seen = &bench.frames[0];
        let error = bench.errors.iter().find(|error| error.sender).map(|error| error.at);
        let since = |at: link_core::Instant| at.as_nanos() - seen.start.as_nanos();
        (seen.outcome == Outcome::Ok, since(seen.end), error.map(since))
    };
    for acknowledged in [true, false] {
        let in_step = lengths(BitRate::K500, acknowledged);
        assert_eq!(in_step.0, acknowledged);
        assert_eq!(lengths(BitRate::K125, acknowledged), in_step);
        assert_eq!(lengths(BitRate::M1, acknowledged), in_step);
    }
}
