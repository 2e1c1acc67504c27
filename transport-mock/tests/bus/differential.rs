//! The cheap path tells the same story as the exact one, line by line and to the nanosecond.

use std::time::Duration;

use link_core::frame::{extended_id, standard_id};
use link_core::{BitRate, Filter, Frame, Id, Instant, LinkCommand};
use proptest::prelude::*;
use transport_mock::{BusConfig, Change, Counters, Fault, FaultId, NodeId, Reaction, Scope, Which};

use crate::harness::{Bench, Probe};

const NODES: usize = 5;

#[derive(Clone, Debug)]
enum Step {
    Send(usize, Frame),
    Withdraw(usize),
    Reset(usize),
    Power(usize, bool),
    Cable(usize, bool),
    ListenOnly(usize, bool),
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
        1 => id.prop_map(|id| Frame::remote(id, 1).unwrap()),
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
        1 => (node.clone(), any::<bool>()).prop_map(|(node, on)| Step::ListenOnly(node, on)),
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

fn run(steps: &[(u64, Step)], force_exact: bool) -> (Vec<String>, Vec<Counters>) {
    let config = BusConfig { force_exact, shared: None, ..BusConfig::new(BitRate::K500, 7) };
    let mut bench = Bench::with(config, NODES);
    for (wait, step) in steps {
        let until = bench.network.now().as_nanos() + wait;
        bench.run_until(Instant::from_nanos(until));
        act(&mut bench, step);
    }
    bench.run_bits(3_000);
    let counters = (0..NODES).map(|node| bench.network.counters(bench.id(node))).collect();
    (bench.lines, counters)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn both_paths_tell_the_same_story(
        steps in prop::collection::vec((prop_oneof![Just(0_u64), 0..20_000_u64, 0..400_000_u64], any_step()), 1..60)
    ) {
        let (cheap, cheap_counters) = run(&steps, false);
        let (exact, exact_counters) = run(&steps, true);
        if let Some(place) = cheap.iter().zip(&exact).position(|(cheap, exact)| cheap != exact) {
            let context = place.saturating_sub(4)..(place + 3).min(cheap.len()).min(exact.len());
            prop_assert!(
                false,
                "line {place}:\ncheap {:#?}\nexact {:#?}",
                &cheap[context.clone()],
                &exact[context]
            );
        }
        prop_assert_eq!(cheap.len(), exact.len());
        prop_assert_eq!(cheap_counters, exact_counters);
    }
}
