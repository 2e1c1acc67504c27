//! What a machine asks of its controller, and what happens to nodes.

use std::time::Duration;

use link_core::link::LinkCommandKind;
use link_core::{
    BitRate, Filter, FilterSet, Instant, LinkCommand, LinkEvent, Mode, TxOutcome, frame::standard_id,
};
use transport_mock::record::Outcome;
use transport_mock::{BusConfig, Change, Network, NodeConfig, Reaction, Record};

use crate::harness::{Bench, Probe, bits, data};

#[test]
fn a_mode_is_answered_and_drops_what_waits() {
    let mut bench = Bench::new(2);
    let listen = Mode { bit_rate: BitRate::K500, listen_only: true };
    bench.tell(0, |probe| {
        probe.send(data(0x100, &[]));
        probe.link(LinkCommand::SetMode(listen));
    });
    bench.run_bits(200);
    assert_eq!(bench.probe(0).outcomes(), [TxOutcome::Dropped]);
    assert!(bench.probe(0).link_events().contains(&LinkEvent::ModeSet(listen)));
    assert!(bench.frames.is_empty());

    // A listener hears, and does not acknowledge.
    bench.send(1, data(0x101, &[]));
    bench.run_bits(60);
    assert!(matches!(bench.frames[0].outcome, Outcome::Error(error) if error.sender));
    assert_eq!(bench.counters(0), (0, 0), "its counters rest");
}

#[test]
fn an_impossible_rate_is_refused() {
    let mut bench = Bench::new(1);
    let never = Mode { bit_rate: BitRate(0), listen_only: false };
    bench.tell(0, |probe| probe.link(LinkCommand::SetMode(never)));
    assert!(bench.probe(0).link_events().contains(&LinkEvent::Refused(LinkCommandKind::SetMode)));
    assert_eq!(bench.network.mode(bench.id(0)).bit_rate, BitRate::K500);
}

#[test]
fn a_filter_is_answered_and_keeps_frames_away() {
    let mut bench = Bench::new(3);
    let only: FilterSet = [Filter::exact(standard_id(0x101))].into_iter().collect();
    bench.tell(1, |probe| probe.link(LinkCommand::SetFilter(only)));
    for id in [0x100, 0x101, 0x102] {
        bench.send(0, data(id, &[]));
    }
    bench.run_bits(300);
    assert_eq!(bench.probe(1).frames(), [data(0x101, &[])]);
    assert_eq!(bench.probe(2).frames().len(), 3);
    assert!(bench.probe(1).link_events().contains(&LinkEvent::FilterSet));
    assert!(
        bench.frames.iter().all(|seen| seen.receivers == [1, 2]),
        "its controller acknowledges all the same"
    );
}

#[test]
fn a_withdrawn_frame_is_not_sent_and_one_on_the_bus_is() {
    let mut bench = Bench::new(3);
    bench.send(0, data(0x100, &[1]));
    let late = bench.send(1, data(0x200, &[2]));
    bench.run_bits(20);
    // The first is on the bus, and the second has lost arbitration.
    bench.tell(1, |probe| probe.withdraw(late));
    bench.tell(0, Probe::withdraw_last);
    bench.run_bits(200);
    assert_eq!(bench.probe(1).outcomes(), [TxOutcome::Withdrawn]);
    assert_eq!(bench.probe(0).outcomes(), [TxOutcome::Sent]);
    assert_eq!(bench.probe(2).frames(), [data(0x100, &[1])]);
}

#[test]
fn a_withdrawn_frame_that_meets_an_error_is_not_tried_again() {
    let mut bench = Bench::new(1);
    bench.send(0, data(0x100, &[1]));
    bench.run_bits(20);
    bench.tell(0, Probe::withdraw_last);
    assert!(bench.probe(0).outcomes().is_empty(), "it is on the bus");
    bench.run_bits(200);
    assert_eq!(bench.probe(0).outcomes(), [TxOutcome::Withdrawn]);
    assert_eq!(bench.frames.len(), 1);
}

#[test]
fn a_sender_that_loses_power_leaves_a_broken_frame() {
    let mut bench = Bench::new(3);
    bench.send(0, data(0x100, &[0; 8]));
    bench.run_bits(40);
    let node = bench.id(0);
    bench.change(Change::PowerOff(node));
    bench.run_bits(100);
    assert!(bench.probe(1).frames().is_empty());
    assert!(matches!(bench.frames[0].outcome, Outcome::Error(_)));
    assert_eq!(bench.counters(1).1, 1);
    bench.change(Change::PowerOn(node));
    bench.run_bits(100);
    assert_eq!(bench.probe(0).link_events(), [LinkEvent::Up], "it starts as it was added");
}

#[test]
fn a_cut_cable_is_told_and_a_plugged_one_too() {
    let mut bench = Bench::new(2);
    let node = bench.id(0);
    bench.send(0, data(0x100, &[]));
    bench.change(Change::Cut(node));
    bench.run_bits(100);
    assert_eq!(bench.probe(0).link_events(), [LinkEvent::Up, LinkEvent::Down]);
    assert_eq!(bench.probe(0).outcomes(), [TxOutcome::Dropped]);
    assert_eq!(bench.network.error_state(node), None);
    bench.tell(0, |probe| probe.link(LinkCommand::Reset));
    assert!(bench.probe(0).link_events().contains(&LinkEvent::Refused(LinkCommandKind::Reset)));

    bench.change(Change::Plug(node));
    bench.run_bits(20);
    bench.send(0, data(0x100, &[]));
    bench.run_bits(100);
    assert_eq!(bench.probe(0).outcomes(), [TxOutcome::Dropped, TxOutcome::Sent]);
}

#[test]
fn what_is_kept_without_power_is_up_to_the_node() {
    let mut network = Network::<std::convert::Infallible>::new(BusConfig::new(BitRate::K500, 1));
    let forgets = network.add(NodeConfig::named("forgets"), Probe::default());
    let remembers = network.add_with_memory(
        NodeConfig::named("remembers"),
        Probe::default(),
        |old: &Probe, fresh: &mut Probe| fresh.recovers = old.recovers,
    );
    network.run_until(Instant::from_millis(1), &mut transport_mock::Ignore);
    for node in [forgets, remembers] {
        network.command(node, |probe: &mut Probe, _| probe.recovers = true);
        network.apply(Change::PowerCycle(node));
    }
    assert!(!network.machine::<Probe>(forgets).unwrap().recovers);
    assert!(network.machine::<Probe>(remembers).unwrap().recovers);
}

#[test]
fn a_switch_that_is_turned_without_power_is_read_at_power_up() {
    let mut network = Network::<std::convert::Infallible>::new(BusConfig::new(BitRate::K500, 1));
    let node = network.add_with_memory(
        NodeConfig { power_up: None, ..NodeConfig::named("node") },
        Probe::default(),
        |old: &Probe, fresh: &mut Probe| fresh.recovers = old.recovers,
    );
    let turn = |probe: &mut Probe| probe.recovers = true;
    assert_eq!(network.command(node, |probe: &mut Probe, _| turn(probe)), None, "nobody is there to obey");
    assert_eq!(network.alter_memory(node, turn), Some(()));
    network.apply(Change::PowerOn(node));
    assert!(network.machine::<Probe>(node).unwrap().recovers);
    assert_eq!(network.alter_memory(node, turn), None, "with power, a command does it");
}

/// What the old life of a node had asked for is no business of the new one.
#[test]
fn a_node_that_starts_anew_is_told_nothing_of_before() {
    let mut bench = Bench::new(2);
    let node = bench.id(0);
    bench.send(0, data(0x100, &[]));
    bench.change(Change::Call(Box::new(move |network| {
        // All at one moment: nobody was told of the cut when the power goes.
        for change in [Change::Cut(node), Change::PowerCycle(node), Change::Plug(node)] {
            network.apply(change);
        }
    })));
    bench.run_bits(20);
    assert_eq!(bench.probe(0).outcomes(), []);
    assert_eq!(bench.probe(0).link_events(), [LinkEvent::Up]);
}

#[test]
fn a_switch_stays_where_it_is_without_power_and_a_command_does_not() {
    let mut bench = Bench::new(2);
    let node = bench.id(0);
    let fast = Mode { bit_rate: BitRate::M1, listen_only: true };
    bench.tell(0, |probe| probe.link(LinkCommand::SetMode(fast)));
    bench.change(Change::SetBitRate(node, BitRate::K250));
    bench.change(Change::SetBitRate(node, BitRate(0)));
    bench.run_bits(1);
    assert_eq!(bench.network.mode(node), Mode { bit_rate: BitRate::K250, listen_only: true });
    bench.change(Change::PowerCycle(node));
    bench.run_bits(1);
    assert_eq!(bench.network.mode(node), Mode { bit_rate: BitRate::K250, listen_only: false });
}

#[test]
fn a_reaction_takes_its_time() {
    let delay = Duration::from_micros(100);
    for (reaction, least, most) in [
        (Reaction::Immediate, 0, 1),
        (Reaction::Fixed(delay), 50, 51),
        (Reaction::Uniform(delay, 2 * delay), 50, 101),
    ] {
        let mut bench = Bench::new(2);
        let node = bench.id(0);
        bench.change(Change::SetReaction(node, reaction));
        bench.run_bits(1);
        for _ in 0..20 {
            let asked = bench.network.now();
            bench.send(0, data(0x100, &[]));
            bench.run_bits(300);
            let waited = bits(asked, bench.frames.last().unwrap().start);
            assert!((least..=most).contains(&waited), "{reaction:?}: {waited} bits");
        }
    }
}

#[test]
fn a_node_joins_after_eleven_recessive_bits() {
    let mut network = Network::<()>::new(BusConfig::new(BitRate::K500, 1));
    let mut eager = Probe::default();
    eager.send(data(0x100, &[]));
    network.add_silent(
        NodeConfig { power_up: Some(Instant::from_micros(101)), ..NodeConfig::named("eager") },
        eager,
    );
    network.add_silent(NodeConfig::named("other"), Probe::default());
    let mut starts = Vec::new();
    network.run_until(Instant::from_millis(1), &mut |record: &transport_mock::Record<'_, ()>| {
        if let transport_mock::Record::Frame(frame) = record {
            starts.push(frame.start);
        }
    });
    // The next bit begins at 102 us.
    assert_eq!(starts, [Instant::from_micros(102 + 11 * 2)]);
}

/// In the order of cause and effect, all at the moment of the change.
#[test]
fn the_power_goes_and_with_it_the_frame_and_the_counters() {
    let mut network = Network::<std::convert::Infallible>::new(BusConfig::new(BitRate::K500, 1));
    let node = network.add(NodeConfig::named("alone"), Probe::default());
    network.run_until(Instant::from_millis(1), &mut transport_mock::Ignore);
    network.command(node, |probe: &mut Probe, _| probe.send(data(0x100, &[])));
    // In the middle of an attempt that nobody will acknowledge, after others.
    let off = Instant::from_micros(2_100);
    network.schedule(off, Change::PowerOff(node));
    network.schedule(Instant::from_millis(5), Change::PowerOn(node));
    let mut seen = Vec::new();
    network.run_until(Instant::from_millis(6), &mut |record: &Record<'_, _>| match record {
        Record::Change { at, .. } => seen.push((*at, "change")),
        Record::Frame(frame) if frame.end >= off => seen.push((frame.end, "frame")),
        Record::Counters { at, counters, .. } if counters.tec == 0 => seen.push((*at, "counters")),
        _ => {}
    });
    assert_eq!(
        seen,
        [(off, "change"), (off, "frame"), (off, "counters"), (Instant::from_millis(5), "change")]
    );
}
