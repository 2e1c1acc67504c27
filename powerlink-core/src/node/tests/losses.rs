//! Lost frames around each threshold: a symptom adds 8, a good cycle takes 1 away.
//!
//! | Threshold | Symptoms in a row until the reaction |
//! |---|---|
//! | 0 | never |
//! | 1 to 8 | 1 |
//! | 9 to 16 | 2 |
//! | 17 to 24 | 3 |
//! | 80, as openPOWERLINK's demo configures it | 10 |

use core::time::Duration;

use link_core::ethernet::{Input, Machine};

use super::bench::*;
use crate::error::Symptom;
use crate::nmt::NmtState;
use crate::node::NodeEvent;
use crate::wire::Flags;

const CYCLE_TIME: Duration = Duration::from_millis(CYCLE);
const REACTIONS: [(u32, Option<usize>); 9] = [
    (0, None),
    (1, Some(1)),
    (8, Some(1)),
    (9, Some(2)),
    (15, Some(2)),
    (16, Some(2)),
    (17, Some(3)),
    (24, Some(3)),
    (80, Some(10)),
];

/// A cycle without one of its frames; without a SoC there is silence.
fn without(bench: &mut Bench, symptom: Symptom) {
    if symptom != Symptom::LossOfSoc {
        bench.soc();
        if symptom == Symptom::LossOfSoa {
            bench.preq(Flags::DATA_VALID, &[0]);
        } else {
            bench.soa();
        }
    }
    bench.wait(CYCLE_TIME);
}

/// A node in operation with a threshold that the managing node wrote: it counts at once.
fn with_threshold(symptom: Symptom, threshold: u32) -> Bench {
    let mut bench = Bench::in_state(NmtState::PreOperational1, config());
    assert_eq!(bench.writes(symptom.object(), 3, &threshold.to_le_bytes()), Ok(()));
    bench.goes_to(NmtState::Operational);
    bench.cycle();
    bench
}

#[test]
fn symptoms_in_a_row_around_each_threshold() {
    const MANY: usize = 30;
    for symptom in [Symptom::LossOfSoc, Symptom::LossOfPreq, Symptom::LossOfSoa] {
        for (threshold, reaction) in REACTIONS {
            let mut bench = with_threshold(symptom, threshold);
            let mut count = 0;
            while bench.node.state() == NmtState::Operational && count < MANY {
                without(&mut bench, symptom);
                count += 1;
            }
            // That there was no SoA is noticed at the next SoC.
            let late = usize::from(symptom == Symptom::LossOfSoa);
            assert_eq!(count, reaction.map_or(MANY, |reaction| reaction + late), "{symptom} {threshold}");
            assert_eq!(bench.node.state() == NmtState::PreOperational1, reaction.is_some());
            assert_eq!(bench.events.contains(&NodeEvent::Error(symptom.code())), reaction.is_some());
            assert_eq!(bench.node.error_led(), reaction.is_some());
            let counter = bench.node.dictionary().counters.of(symptom);
            assert_eq!(counter.cumulative, u32::try_from(count - late).unwrap(), "{symptom} {threshold}");
            assert!(threshold == 0 || counter.threshold_count == 0, "it begins anew");
        }
    }
}

/// A node that is called late has missed every SoC that was due since, whenever it is called: 20.1 ms, 40.1 ms and so on behind the
/// last one.
#[test]
fn a_node_that_is_called_late_misses_as_many_socs() {
    let late = Duration::from_micros(100);
    for (missed, elapsed) in [
        (0, CYCLE_TIME + late - Duration::from_nanos(1)),
        (1, CYCLE_TIME + late),
        (1, CYCLE_TIME * 2 + late - Duration::from_nanos(1)),
        (2, CYCLE_TIME * 2 + late),
        (7, CYCLE_TIME * 7 + Duration::from_millis(19)),
        (9, CYCLE_TIME * 9 + late),
    ] {
        let mut bench = with_threshold(Symptom::LossOfSoc, 80);
        bench.soc();
        bench.now += elapsed;
        bench.node.input(bench.now, Input::Tick);
        bench.drain();
        assert_eq!(bench.node.dictionary().counters.of(Symptom::LossOfSoc).cumulative, missed, "{elapsed:?}");
        bench.is(NmtState::Operational);
        // The next one keeps to the same cycle.
        let next = bench.node.deadline().unwrap().at;
        assert_eq!(next.saturating_since(bench.now) + elapsed, CYCLE_TIME * (missed + 1) + late);
    }
    // However late, one step; what is behind the threshold is not counted.
    for (threshold, missed) in [(0, 180_000_000 - 1), (15, 2), (80, 10)] {
        let mut bench = with_threshold(Symptom::LossOfSoc, threshold);
        bench.soc();
        bench.now += CYCLE_TIME * 180_000_000;
        bench.node.input(bench.now, Input::Tick);
        bench.drain();
        assert_eq!(bench.node.dictionary().counters.of(Symptom::LossOfSoc).cumulative, missed);
        assert_eq!(bench.node.state() == NmtState::PreOperational1, threshold > 0);
        assert!(bench.node.deadline().is_none_or(|deadline| deadline.at > bench.now));
    }
}

/// The second symptom counts while the first is not made good: after one good cycle 7 + 8 is the threshold of 15, after two it
/// is not.
#[test]
fn good_cycles_between_two_symptoms() {
    for symptom in [Symptom::LossOfSoc, Symptom::LossOfPreq, Symptom::LossOfSoa] {
        for good in 0..4 {
            // A cycle that has a SoA ends with it.
            let lose = |bench: &mut Bench| {
                if symptom == Symptom::LossOfSoc {
                    bench.preq(Flags::DATA_VALID, &[0]);
                    bench.soa();
                    bench.wait(CYCLE_TIME);
                } else {
                    without(bench, symptom);
                }
            };
            let mut bench = with_threshold(symptom, 15);
            lose(&mut bench);
            (0..good).for_each(|_| bench.cycle());
            lose(&mut bench);
            bench.soc();
            let reacts = !matches!(bench.node.state(), NmtState::Operational);
            // The good cycle that begins with the notice of a lost SoA is not one without the symptom.
            let late = i32::from(symptom == Symptom::LossOfSoa);
            assert_eq!(reacts, good <= 1 + late, "{symptom}, {good} good cycles");
        }
    }
}

/// What a stopped node sees of a cycle: a PReq is neither due nor answered, and nothing of a good cycle is missing.
#[test]
fn a_stopped_node_that_is_still_polled() {
    let mut bench = Bench::in_state(NmtState::Stopped, config());
    for _ in 0..20 {
        bench.cycle();
    }
    bench.says_nothing();
    bench.is(NmtState::Stopped);
    let lost = |bench: &Bench, symptom| bench.node.dictionary().counters.of(symptom).cumulative;
    assert_eq!(
        [Symptom::LossOfSoc, Symptom::LossOfPreq, Symptom::LossOfSoa].map(|one| lost(&bench, one)),
        [0; 3]
    );
    // A PReq before the SoC shows that the SoC got lost.
    bench.preq(Flags::DATA_VALID, &[0]);
    assert_eq!(lost(&bench, Symptom::LossOfSoc), 1);
    bench.says_nothing();
}

/// A poll at the very moment at which the SoC is missed once too often: the PRes is that of the polled node, then the node goes.
#[test]
fn a_poll_at_the_moment_of_a_reaction_is_answered_first() {
    let mut bench = with_threshold(Symptom::LossOfSoc, 1);
    bench.soc();
    bench.forget();
    bench.now += CYCLE_TIME + Duration::from_micros(100);
    bench.preq(Flags::DATA_VALID, &[0]);
    bench.says("node 1 -> all: PRes, NMT_OPERATIONAL, EN=0 RD=1, PR=0 RS=0, 1 byte");
    bench.is(NmtState::PreOperational1);
}

/// The answer to a frame goes out before the next frame, or not at all.
#[test]
fn answers_that_nobody_fetched_are_not_sent_later() {
    let mut bench = Bench::in_state(NmtState::Operational, config());
    bench.soc();
    bench.preq_undrained();
    bench.command(crate::wire::NmtCommandId::STOP_NODE);
    bench.is(NmtState::Stopped);
    bench.says_nothing();
    assert_eq!(bench.node.counters().not_sent, 1);
}
