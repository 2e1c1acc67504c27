#![allow(
    clippy::arithmetic_side_effects,
    clippy::as_conversions,
    clippy::expect_used,
    clippy::panic,
    missing_docs,
    reason = "a benchmark on a host"
)]
//! How many instructions a controlled node takes from a PReq to its PRes, counted by callgrind.
//!
//! `scripts/instructions` runs it, and fails when the budget is exceeded.

#[path = "../../link-core/benches/callgrind/mod.rs"]
mod callgrind;

use core::time::Duration;
use std::process::ExitCode;

use link_core::Instant;
use link_core::codec::Writer;
use link_core::ethernet::{Action, Input, MAX_FRAME, MacAddress, Machine};
use powerlink_core::dictionary::{Access, Device, Entry, Mappable, ObjectAddress, ObjectSet, ObjectType};
use powerlink_core::ethernet::group;
use powerlink_core::nmt::NmtState;
use powerlink_core::node::{Config, DefaultMapping};
use powerlink_core::pdo::MappingEntry;
use powerlink_core::wire::{
    AbortCode, Body, Flags, Frame, Identity, NmtCommand, NmtCommandId, NmtStateCode, POWERLINK_V2,
    PdoVersion, Preq, RequestedService, Soa, Soc,
};
use powerlink_core::{ControlledNode, NodeId};

fn main() -> ExitCode {
    if let Some((name, count)) = callgrind::asked() {
        let case = CASES.iter().find(|case| case.name == name).expect("a case");
        repeat(case, count);
        return ExitCode::SUCCESS;
    }
    println!("| Cycle | PReq in to PRes out | Budget | With SoC, SoA, events and deadline |");
    println!("|---|---|---|---|");
    let mut exceeded = false;
    for case in CASES {
        let answer = callgrind::collected(case.name, "*preq_in_to_pres_out*");
        let whole = callgrind::collected(case.name, "*whole_cycle*");
        exceeded |= case.budget.is_some_and(|budget| answer > budget);
        let budget = case.budget.map_or_else(|| "-".into(), |budget| budget.to_string());
        println!("| {} | {answer} | {budget} | {whole} |", case.words);
    }
    ExitCode::from(u8::from(exceeded))
}

/// What is in PReq and PRes.
struct Case {
    name: &'static str,
    words: &'static str,
    mapping: DefaultMapping,
    budget: Option<u64>,
}

const CASES: &[Case] = &[
    Case {
        name: "poll",
        words: "8 bytes in each direction: four objects of 16 bits",
        mapping: DefaultMapping { receive: &OUTPUTS, transmit: &INPUTS },
        budget: Some(400),
    },
    Case {
        name: "poll-1",
        words: "8 bytes in each direction: one object of 64 bits",
        mapping: DefaultMapping { receive: &[LONG_OUTPUT], transmit: &[LONG_INPUT] },
        budget: Some(400),
    },
    Case {
        name: "poll-empty",
        words: "nothing is mapped",
        mapping: DefaultMapping { receive: &[], transmit: &[] },
        budget: None,
    },
];

const INPUTS: [MappingEntry; 4] = [entry(0x6401, 1), entry(0x6401, 2), entry(0x6401, 3), entry(0x6401, 4)];
const OUTPUTS: [MappingEntry; 4] = [entry(0x6411, 1), entry(0x6411, 2), entry(0x6411, 3), entry(0x6411, 4)];
const LONG_INPUT: MappingEntry =
    MappingEntry { object: ObjectAddress::new(0x6020, 1), offset: 0, length: 64 };
const LONG_OUTPUT: MappingEntry =
    MappingEntry { object: ObjectAddress::new(0x6220, 1), offset: 0, length: 64 };

const fn entry(index: u16, sub: u8) -> MappingEntry {
    MappingEntry { object: ObjectAddress::new(index, sub), offset: 16 * (sub as u16 - 1), length: 16 }
}

fn repeat(case: &Case, count: u64) {
    let (mut node, mut now) = operational(case);
    for _ in 0..count {
        now = now.saturating_add(CYCLE);
        whole_cycle(&mut node, now, &frames(case.mapping.receive.is_empty()));
    }
}

/// From the PReq to the PRes.
#[inline(never)]
fn preq_in_to_pres_out(node: &mut Node, now: Instant, preq: &[u8], buffer: &mut [u8; MAX_FRAME]) {
    node.input(now, Input::Frame(preq));
    match node.poll(now, buffer) {
        Some(Action::Transmit(pres)) => {
            std::hint::black_box(pres);
        }
        action => panic!("no answer: {action:?}"),
    }
}

/// The same with the rest of the cycle, as a driver goes through it.
#[inline(never)]
fn whole_cycle(node: &mut Node, now: Instant, [soc, preq, soa]: &[Vec<u8>; 3]) {
    let mut buffer = [0; MAX_FRAME];
    node.input(now, Input::Frame(soc));
    drain(node, now, &mut buffer);
    preq_in_to_pres_out(node, now, preq, &mut buffer);
    drain(node, now, &mut buffer);
    node.input(now, Input::Frame(soa));
    drain(node, now, &mut buffer);
    std::hint::black_box(node.deadline());
}

fn drain(node: &mut Node, now: Instant, buffer: &mut [u8; MAX_FRAME]) {
    while let Some(action) = node.poll(now, buffer) {
        std::hint::black_box(&action);
    }
}

/// A node that is polled.
fn operational(case: &Case) -> (Node, Instant) {
    let identity = Identity { vendor_id: 0x0123, product_code: 7, revision: 1, serial_number: 42 };
    let mut config = Config::new(NodeId(1), MAC, Device::new(identity)).expect("a controlled node");
    config.mapping = case.mapping;
    config.values.cycle_length = 1000;
    let mut node = Node::new(config, Block::default()).expect("a valid node");
    let (mut now, mut buffer) = (Instant::from_millis(1), [0; MAX_FRAME]);
    node.power_on(now);
    let [soc, preq, soa] = frames(case.mapping.receive.is_empty());
    let command = |id| bytes(group::ASND, Body::NmtCommand(NmtCommand { command: id, data: &[] }));
    let commands = [NmtCommandId::ENABLE_READY_TO_OPERATE, NmtCommandId::START_NODE].map(command);
    drain(&mut node, now, &mut buffer);
    let cycle = [&soc, &preq, &soa];
    let start = [&soa].into_iter().chain(cycle).chain([&commands[0]]).chain(cycle).chain([&commands[1]]);
    for frame in start {
        if *frame == soc {
            now = now.saturating_add(CYCLE);
        }
        node.input(now, Input::Frame(frame));
        drain(&mut node, now, &mut buffer);
    }
    assert_eq!(node.state(), NmtState::Operational);
    (node, now)
}

/// SoC, PReq and SoA of a cycle.
fn frames(is_empty: bool) -> [Vec<u8>; 3] {
    let data: &[u8] = if is_empty { &[] } else { &[1, 2, 3, 4, 5, 6, 7, 8] };
    let preq = Preq { flags: Flags::DATA_VALID, pdo_version: PdoVersion(0), data };
    let soa = Soa {
        state: NmtStateCode::OPERATIONAL,
        flags: Flags::empty(),
        service: RequestedService::NO_SERVICE,
        target: NodeId::NONE,
        version: POWERLINK_V2,
    };
    [
        bytes(group::SOC, Body::Soc(Soc::default())),
        bytes(MAC, Body::Preq(preq)),
        bytes(group::SOA, Body::Soa(soa)),
    ]
}

fn bytes(destination: MacAddress, body: Body<'_>) -> Vec<u8> {
    let source = MacAddress([2, 0, 0, 0, 0, 0xF0]);
    let frame = Frame { destination, source, to: NodeId(1), from: NodeId::MANAGING_NODE, body };
    frame.emit(&mut [0; MAX_FRAME]).expect("short").to_vec()
}

type Node = ControlledNode<Block>;

/// Four analogue inputs and outputs of 16 bits, after CiA 401, and a row of 64 digital ones.
#[derive(Clone, PartialEq, Eq, Hash, Debug, Default)]
struct Block {
    inputs: [u16; 4],
    outputs: [u16; 4],
    long_input: u64,
    long_output: u64,
}

impl ObjectSet for Block {
    const ENTRIES: &'static [Entry] = &[
        Entry::new(0x6020, 1, "inputs", ObjectType::Unsigned(8), Access::ReadOnly).mapped(Mappable::Transmit),
        Entry::new(0x6220, 1, "outputs", ObjectType::Unsigned(8), Access::ReadWrite)
            .mapped(Mappable::Receive),
        Entry::new(0x6401, 1, "analogue input", ObjectType::Unsigned(2), Access::ReadOnly)
            .up_to_sub(4)
            .mapped(Mappable::Transmit),
        Entry::new(0x6411, 1, "analogue output", ObjectType::Unsigned(2), Access::ReadWrite)
            .up_to_sub(4)
            .mapped(Mappable::Receive),
    ];

    fn read(&self, at: ObjectAddress, out: &mut Writer<'_>) -> Result<(), AbortCode> {
        let place = usize::from(at.sub.wrapping_sub(1));
        match at.index {
            0x6401 => out.u16(self.inputs.get(place).copied().unwrap_or(0)),
            0x6411 => out.u16(self.outputs.get(place).copied().unwrap_or(0)),
            0x6220 => out.u64(self.long_output),
            _ => out.u64(self.long_input),
        }
        .map_err(|_| AbortCode::OUT_OF_MEMORY)
    }

    fn write(&mut self, at: ObjectAddress, data: &[u8]) -> Result<(), AbortCode> {
        if at.index == 0x6220 {
            self.long_output = u64::from_le_bytes(*data.first_chunk().ok_or(AbortCode::LENGTH)?);
            return Ok(());
        }
        let place = usize::from(at.sub.wrapping_sub(1));
        let output = self.outputs.get_mut(place).ok_or(AbortCode::NO_SUB_INDEX)?;
        *output = u16::from_le_bytes(*data.first_chunk().ok_or(AbortCode::LENGTH)?);
        Ok(())
    }

    fn restore(&mut self) {
        *self = Self::default();
    }
}

const MAC: MacAddress = MacAddress([2, 0, 0, 0, 0, 1]);
const CYCLE: Duration = Duration::from_millis(1);
