//! The cheap path tells the same story as the exact one, line by line and to the nanosecond.

use std::collections::BTreeSet;
use std::time::Duration;

use link_core::frame::{extended_id, standard_id};
use link_core::{BitRate, Filter, FilterSet, Frame, Id, Input, Instant, LinkCommand, Mode};
use proptest::prelude::*;
use transport_mock::{BusConfig, Change, Counters, Fault, FaultId, NodeId, Reaction, Scope, Which};

use crate::harness::{BIT, Bench, Probe};

const NODES: usize = 5;

#[derive(Clone, Debug)]
enum Step {
    Send(usize, Frame),
    Withdraw(usize),
    Reset(usize),
    Power(usize, bool),
    Cable(usize, bool),
    Cycle(usize),
    ListenOnly(usize, bool),
    Mode(usize, Mode),
    Filter(usize, u16),
    Recovers(usize),
    Answers(usize, Frame),
    Rate(usize, u32),
    Clock(usize, i32),
    React(usize, u64),
    Fault(u32, FaultStep),
    Repair(u32),
    Split(usize, usize),
    Join,
}

#[derive(Clone, Debug)]
enum FaultStep {
    Flips(Option<usize>),
    FlipBit(u64, u32, Option<usize>),
    Spoil(usize),
    Overrun(usize),
    Bursts,
    Babble,
}

fn any_frame() -> impl Strategy<Value = Frame> {
    // Few identifiers, so that nodes often want the same.
    let id = prop_oneof![
        4 => (0x100..0x104_u16).prop_map(|raw| Id::from(standard_id(raw))),
        1 => (0..3_u32).prop_map(|raw| Id::from(extended_id(0x100 << 18 | raw))),
    ];
    prop_oneof![
        6 => (id.clone(), prop::collection::vec(prop_oneof![Just(0), Just(1), Just(0xFF)], 0..3))
            .prop_map(|(id, bytes)| Frame::new(id, &bytes).unwrap()),
        1 => (id.clone(), 8..16_u8, any::<[u8; 8]>())
            .prop_map(|(id, dlc, bytes)| Frame::with_dlc(id, dlc, bytes).unwrap()),
        1 => (id, 0..2_u8).prop_map(|(id, dlc)| Frame::remote(id, dlc).unwrap()),
    ]
}

fn any_fault() -> impl Strategy<Value = FaultStep> {
    let node = 0..NODES;
    let who = prop::option::of(node.clone());
    prop_oneof![
        who.clone().prop_map(FaultStep::Flips),
        (0..3_u64, 0..60_u32, who).prop_map(|(frame, bit, who)| FaultStep::FlipBit(frame, bit, who)),
        node.clone().prop_map(FaultStep::Spoil),
        node.prop_map(FaultStep::Overrun),
        Just(FaultStep::Bursts),
        Just(FaultStep::Babble),
    ]
}

fn any_step() -> impl Strategy<Value = Step> {
    let node = 0..NODES;
    prop_oneof![
        20 => (node.clone(), any_frame()).prop_map(|(node, frame)| Step::Send(node, frame)),
        3 => node.clone().prop_map(Step::Withdraw),
        2 => node.clone().prop_map(Step::Reset),
        1 => (node.clone(), any::<bool>()).prop_map(|(node, on)| Step::Power(node, on)),
        1 => (node.clone(), any::<bool>()).prop_map(|(node, on)| Step::Cable(node, on)),
        1 => node.clone().prop_map(Step::Cycle),
        1 => (node.clone(), any::<bool>()).prop_map(|(node, on)| Step::ListenOnly(node, on)),
        1 => (node.clone(), any::<bool>()).prop_map(|(node, listen_only)| {
            Step::Mode(node, Mode { bit_rate: BitRate::K500, listen_only })
        }),
        1 => (node.clone(), 0..4_u16).prop_map(|(node, mask)| Step::Filter(node, mask)),
        1 => node.clone().prop_map(Step::Recovers),
        1 => (node.clone(), any_frame()).prop_map(|(node, frame)| Step::Answers(node, frame)),
        1 => (node.clone(), prop_oneof![3 => Just(500_000), 1 => Just(250_000), 1 => Just(1_000_000)])
            .prop_map(|(node, rate)| Step::Rate(node, rate)),
        1 => (node.clone(), prop_oneof![3 => Just(0), 1 => -30_000..30_000])
            .prop_map(|(node, ppm)| Step::Clock(node, ppm)),
        1 => (node.clone(), 0..200_u64).prop_map(|(node, micros)| Step::React(node, micros)),
        1 => (0..2_u32, any_fault()).prop_map(|(id, fault)| Step::Fault(id, fault)),
        2 => (0..2_u32).prop_map(Step::Repair),
        1 => (node.clone(), node).prop_map(|(one, other)| Step::Split(one, other)),
        1 => Just(Step::Join),
    ]
}

fn scope(who: Option<NodeId>) -> Scope {
    who.map_or(Scope::Bus, Scope::Node)
}

fn act(bench: &mut Bench, step: &Step) {
    let id = |node: usize| bench.id(node);
    let micros = Duration::from_micros;
    match step.clone() {
        Step::Send(node, frame) => command(bench, node, |probe| _ = probe.send(frame)),
        Step::Withdraw(node) => command(bench, node, Probe::withdraw_last),
        Step::Reset(node) => command(bench, node, |probe| probe.link(LinkCommand::Reset)),
        Step::Power(node, true) => bench.change(Change::PowerOn(id(node))),
        Step::Power(node, false) => bench.change(Change::PowerOff(id(node))),
        Step::Cable(node, true) => bench.change(Change::Plug(id(node))),
        Step::Cable(node, false) => bench.change(Change::Cut(id(node))),
        Step::Cycle(node) => bench.change(Change::PowerCycle(id(node))),
        Step::Mode(node, mode) => command(bench, node, |probe| probe.link(LinkCommand::SetMode(mode))),
        Step::Filter(node, mask) => {
            let filters: FilterSet =
                [Filter::standard(standard_id(0x100), 0x7FC | mask), Filter::ALL_EXTENDED]
                    .into_iter()
                    .collect();
            command(bench, node, |probe| probe.link(LinkCommand::SetFilter(filters)));
        }
        Step::Recovers(node) => command(bench, node, |probe| probe.recovers = true),
        Step::Answers(node, frame) => command(bench, node, |probe| probe.answer = Some(frame)),
        Step::ListenOnly(node, on) => bench.change(Change::SetListenOnly(id(node), on)),
        Step::Rate(node, rate) => bench.change(Change::SetBitRate(id(node), BitRate(rate))),
        Step::Clock(node, ppm) => bench.change(Change::SetClock(id(node), ppm)),
        Step::React(node, most) => {
            bench.change(Change::SetReaction(id(node), Reaction::Uniform(micros(0), micros(most))));
        }
        Step::Fault(number, fault) => {
            let fault = match fault {
                FaultStep::Flips(who) => Fault::BitFlips { rate: 0.005, scope: scope(who.map(id)) },
                FaultStep::FlipBit(frame, bit, who) => {
                    Fault::FlipBit { frame, bit, scope: scope(who.map(id)) }
                }
                FaultStep::Spoil(node) => {
                    Fault::SpoiltEnd { receiver: id(node), filter: None, which: Which::Share(0.5) }
                }
                FaultStep::Overrun(node) => Fault::Overrun {
                    receiver: id(node),
                    filter: Some(Filter::standard(standard_id(0x100), 0x7FE)),
                    which: Which::Next(3),
                },
                FaultStep::Bursts => {
                    Fault::Bursts { gap: micros(500), length: micros(40), scope: Scope::Bus }
                }
                FaultStep::Babble => Fault::Babble { pull: micros(20), every: micros(700) },
            };
            bench.change(Change::FaultOn(FaultId(number), fault));
        }
        Step::Repair(number) => bench.change(Change::FaultOff(FaultId(number))),
        Step::Split(one, other) => bench.change(Change::Split(vec![id(one), id(other)])),
        Step::Join => bench.change(Change::Join),
    }
}

fn command(bench: &mut Bench, node: usize, act: impl FnOnce(&mut Probe)) {
    let id = bench.id(node);
    bench.network.command(id, |probe: &mut Probe, _| act(probe));
}

/// What came of the steps, as anybody could see it.
#[derive(PartialEq, Debug)]
struct Story {
    lines: Vec<String>,
    counters: Vec<Counters>,
    /// What each machine was told since its last power-up.
    inputs: Vec<Vec<(Instant, Input)>>,
}

/// `pauses`: the run is broken off that often, in nanoseconds, and taken up again.
fn run(steps: &[(u64, Step)], force_exact: bool, pauses: Option<u64>) -> Story {
    run_seen(steps, force_exact, pauses, true)
}

/// Without `seen` nobody wants records, which are then not put together.
fn run_seen(steps: &[(u64, Step)], force_exact: bool, pauses: Option<u64>, seen: bool) -> Story {
    let config = BusConfig { force_exact, shared: None, ..BusConfig::new(BitRate::K500, 7) };
    let mut bench = Bench::with(config, NODES);
    bench.watched = seen;
    for (wait, step) in steps {
        run_until(&mut bench, *wait, pauses);
        act(&mut bench, step);
    }
    run_until(&mut bench, 3_000 * BIT, pauses);
    let nodes = 0..NODES;
    // Whatever still waits is answered now.
    nodes.clone().for_each(|node| bench.change(Change::Cut(bench.id(node))));
    bench.run_bits(1);
    Story {
        counters: nodes.clone().map(|node| bench.network.counters(bench.id(node))).collect(),
        inputs: nodes.map(|node| bench.probe(node).log.clone()).collect(),
        lines: bench.lines,
    }
}

fn run_until(bench: &mut Bench, wait: u64, pauses: Option<u64>) {
    let end = bench.network.now().as_nanos() + wait;
    while let Some(pause) = pauses
        && bench.network.now().as_nanos() + pause < end
    {
        bench.run_until(Instant::from_nanos(bench.network.now().as_nanos() + pause));
    }
    bench.run_until(Instant::from_nanos(end));
}

/// Compares by lines first, which tell more.
fn same(one: &Story, other: &Story) -> Result<(), TestCaseError> {
    if let Some(place) = one.lines.iter().zip(&other.lines).position(|(one, other)| one != other) {
        let context = place.saturating_sub(4)..(place + 3).min(one.lines.len()).min(other.lines.len());
        let (one, other) = (&one.lines[context.clone()], &other.lines[context]);
        return Err(TestCaseError::fail(format!("line {place}:\n{one:#?}\n{other:#?}")));
    }
    prop_assert_eq!(one, other);
    Ok(())
}

/// Every frame that a machine has asked for is answered once.
fn every_request_has_one_answer(lines: &[String]) -> Result<(), TestCaseError> {
    let mut waiting = BTreeSet::new();
    for line in lines {
        let words: Vec<&str> = line.split_whitespace().collect();
        match *words.as_slice() {
            [_, "node", node, "requests", token, ..] => {
                prop_assert!(waiting.insert((node.to_owned(), token.to_owned())), "{} twice", line);
            }
            [_, "node", node, "done", token, _] => {
                prop_assert!(waiting.remove(&(node.to_owned(), token.to_owned())), "{} unasked", line);
            }
            _ => {
                // Without power a machine forgets what it has asked for.
                if let Some((_, node)) = line.split_once("PowerOff(NodeId(") {
                    let node = node.trim_end_matches(')');
                    waiting.retain(|(other, _)| other != node);
                }
            }
        }
    }
    prop_assert!(waiting.is_empty(), "without an answer: {:?}", waiting);
    Ok(())
}

// The number of cases is set by `PROPTEST_CASES`.
proptest! {
    #[test]
    fn both_paths_tell_the_same_story(
        steps in prop::collection::vec((prop_oneof![Just(0_u64), 0..20_000_u64, 0..400_000_u64], any_step()), 1..60)
    ) {
        let cheap = run(&steps, false, None);
        same(&cheap, &run(&steps, true, None))?;
        every_request_has_one_answer(&cheap.lines)?;
        let unseen = run_seen(&steps, false, None, false);
        prop_assert_eq!((unseen.counters, unseen.inputs), (cheap.counters, cheap.inputs));
    }

    /// A driver that follows the wall clock stops wherever it likes.
    #[test]
    fn where_a_run_is_broken_off_makes_no_difference(
        steps in prop::collection::vec((0..400_000_u64, any_step()), 1..30),
        force_exact in any::<bool>(),
        pause in 500..50_000_u64,
    ) {
        same(&run(&steps, force_exact, None), &run(&steps, force_exact, Some(pause)))?;
    }
}
