//! Time: that of the network, jitter of SoC, collisions and checksums.

use core::time::Duration;

use link_core::ethernet::LinkEvent;

use super::bench::*;
use crate::error::Symptom;
use crate::nmt::NmtState;
use crate::node::NodeEvent;
use crate::wire::{ErrorCode, NetTime, Soc};

/// The time of the SoCs of openPOWERLINK's managing node: RelativeTime grows by the cycle time, in µs.
#[test]
fn the_time_of_the_network_is_that_of_the_last_soc_and_stamps_errors() {
    let mut bench = Bench::in_state(NmtState::Operational, config());
    let net_time = NetTime { seconds: 1_795_311_704, nanoseconds: 274_446_333 };
    bench.soc_with(Soc { net_time, relative_time: 20_000, ..Soc::default() });
    assert_eq!((bench.node.net_time(), bench.node.relative_time()), (net_time, 20_000));
    bench.link(LinkEvent::Down);
    let entry = *bench.node.dictionary().history().next().unwrap();
    assert_eq!((entry.code, entry.time), (ErrorCode::LOSS_OF_LINK, net_time));
    assert_eq!(entry.kind.0, 0x3002, "a history entry: an event of POWERLINK occurred");
}

/// 0x1C13 is 2000 ns at power-on: the distance of two SoCs may differ from the cycle length by so much.
#[test]
fn jitter_is_counted_from_its_range_on() {
    for (offset, expected) in [(0_i64, 0), (2_000, 0), (2_001, 1), (-2_000, 0), (-2_001, 1), (90_000, 1)] {
        let mut bench = Bench::in_state(NmtState::Operational, config());
        bench.soc();
        let before = bench.node.dictionary().counters.of(Symptom::SocJitter).cumulative;
        bench.soa();
        let distance = i64::try_from(CYCLE).unwrap() * 1_000_000 + offset;
        bench.wait(Duration::from_nanos(distance.try_into().unwrap()));
        bench.soc();
        let counted = bench.node.dictionary().counters.of(Symptom::SocJitter).cumulative - before;
        assert_eq!(counted, expected, "{offset} ns");
        bench.is(NmtState::Operational);
    }
}

#[test]
fn too_much_jitter_is_a_cycle_error_only_where_that_is_chosen() {
    for (reacts, state) in [(false, NmtState::Operational), (true, NmtState::PreOperational1)] {
        let mut config = config();
        config.options.reacts_to_jitter = reacts;
        let mut bench = Bench::in_state(NmtState::Operational, config);
        bench.cycle();
        for _ in 0..2 {
            bench.wait(Duration::from_micros(50));
            bench.is(NmtState::Operational);
            bench.cycle();
        }
        bench.is(state);
        let event = NodeEvent::Error(ErrorCode::JITTER_THRESHOLD);
        assert_eq!(bench.events.contains(&event), reacts);
        if reacts {
            // The SoC that was too late has done its work; the next one begins a cycle.
            bench.soc();
            bench.is(NmtState::PreOperational2);
            bench.soa();
            assert_eq!(bench.node.dictionary().counters.of(Symptom::LossOfSoa).cumulative, 0);
        }
    }
}

/// The managing node has another cycle than the node was told at power-on: 40 ms for 20.
#[test]
fn jitter_is_not_judged_while_the_cycle_length_may_be_unknown() {
    let mut config = config();
    config.options.reacts_to_jitter = true;
    let mut bench = Bench::in_state(NmtState::PreOperational2, config);
    for _ in 0..10 {
        bench.cycle();
        bench.wait(Duration::from_millis(CYCLE));
    }
    bench.is(NmtState::PreOperational2);
    assert_eq!(bench.node.dictionary().counters.of(Symptom::SocJitter).cumulative, 0);
}

#[test]
fn collisions_count_and_checksums_lead_to_a_reaction() {
    for (event, symptom, reacts_to_collisions, state) in [
        (LinkEvent::Collision, Symptom::Collision, false, NmtState::Operational),
        (LinkEvent::Collision, Symptom::Collision, true, NmtState::PreOperational1),
        (LinkEvent::CrcError, Symptom::Crc, false, NmtState::PreOperational1),
    ] {
        let mut config = config();
        config.options.reacts_to_collisions = reacts_to_collisions;
        let mut bench = Bench::in_state(NmtState::Operational, config);
        // One in ten cycles does nothing.
        for _ in 0..10 {
            bench.link(event);
            (0..10).for_each(|_| bench.cycle());
        }
        bench.is(NmtState::Operational);
        bench.link(event);
        bench.link(event);
        bench.is(state);
        assert_eq!(bench.node.dictionary().counters.of(symptom).cumulative, 12);
    }
}
