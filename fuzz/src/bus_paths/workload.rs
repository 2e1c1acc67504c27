//! A bus, its nodes, what they say and what is done to them, read from bytes.
//!
//! | Bytes | Content |
//! |---|---|
//! | 0 | seed of the faults |
//! | 1 | bits 2-0 number of nodes less one, modulo 6, bits 4-3 bit rate |
//! | 2 | duration, 500 bits and 25 for each count |
//! | then for each node | two bytes, see [`node`] |
//! | then | items, see [`item`] |

use core::time::Duration;

use arbitrary::{Result, Unstructured};
use link_core::frame::standard_id;
use link_core::{BitRate, Filter, FilterSet, Instant};
use transport_mock::{Change, Fault, FaultId, Network, NodeConfig, NodeId, Reaction, Scope, Which};

use super::talker::{Planned, Talker};
use crate::input;

pub(super) struct Workload {
    pub(super) bit_rate: BitRate,
    pub(super) seed: u64,
    pub(super) end: Instant,
    nodes: Vec<Node>,
    changes: Vec<Intent>,
    bit: Duration,
    /// All nodes have the bit rate of the bus, exact clocks and one segment, all the time: bits are in step.
    pub(super) in_step: bool,
    /// All nodes have the bit rate of the bus and clocks that CAN tolerates: nobody samples on its own.
    pub(super) one_rate: bool,
}

struct Node {
    config: NodeConfig,
    restarts: bool,
    plan: Vec<Planned>,
}

/// A change before it knows its node: which of the sixteen, and its argument.
#[derive(Clone, Copy, Debug)]
struct Intent {
    at: Instant,
    which: u8,
    argument: u8,
}

impl Workload {
    pub(super) fn read(input: &mut Unstructured<'_>) -> Result<Self> {
        let (seed, bus, duration): (u8, u8, u8) =
            (input.arbitrary()?, input.arbitrary()?, input.arbitrary()?);
        let bit_rate = bit_rate(bus >> 3);
        let bit = bit_rate.bit_time_nanos().expect("not zero");
        let end = Instant::from_nanos((500 + 25 * u64::from(duration)) * bit);
        let mut workload = Self {
            bit_rate,
            seed: seed.into(),
            end,
            nodes: Vec::new(),
            changes: Vec::new(),
            bit: Duration::from_nanos(bit),
            in_step: true,
            one_rate: true,
        };
        for index in 0..=(bus & 0x07) % 6 {
            let node = node(index, bit, input)?;
            workload.in_step &= node.config.bit_rate.is_none() && node.config.clock_ppm == 0;
            workload.one_rate &= node.config.bit_rate.is_none() && is_tolerated(node.config.clock_ppm);
            workload.nodes.push(node);
        }
        let mut at = Instant::ZERO;
        let mut items = 0;
        while !input.is_empty() && items < MOST_ITEMS {
            at += Duration::from_nanos(u64::from(input.arbitrary::<u8>()?) * 4 * bit);
            item(&mut workload, at, bit, input)?;
            items += 1;
        }
        Ok(workload)
    }

    /// Nothing is done to the nodes or the wire.
    pub(super) fn is_undisturbed(&self) -> bool {
        self.changes.is_empty()
    }

    /// Puts the nodes on a network and schedules the changes.
    pub(super) fn install(&self, network: &mut Network<()>) {
        let ids: Vec<NodeId> = self
            .nodes
            .iter()
            .map(|node| {
                let talker = Talker::new(node.plan.clone(), node.restarts);
                network.add_silent(node.config.clone(), talker)
            })
            .collect();
        for (number, intent) in self.changes.iter().enumerate() {
            let change = change(*intent, self.bit, &ids, number);
            network.schedule(intent.at, change);
        }
    }
}

/// Byte 0: bit 0 only listens, bit 1 restarts after bus-off, bits 3-2 clock (exact, exact, +100 ppm, -1 %), bit 4 another bit
/// rate, bit 5 300 us of reaction, bit 6 hears only identifiers below 0x400, bit 7 gets power later. Byte 1: how much
/// later, in 16 bits.
fn node(index: u8, bit: u64, input: &mut Unstructured<'_>) -> Result<Node> {
    let (options, later): (u8, u8) = (input.arbitrary()?, input.arbitrary()?);
    let mut config = NodeConfig::named(format!("node-{index}"));
    config.listen_only = options & 0x01 != 0;
    config.clock_ppm = [0, 0, 100, -10_000][usize::from(options >> 2 & 3)];
    if options & 0x10 != 0 {
        config.bit_rate = Some(bit_rate(later));
    }
    if options & 0x20 != 0 {
        config.reaction = Reaction::Fixed(Duration::from_micros(300));
    }
    if options & 0x40 != 0 {
        config.filter = FilterSet::from_iter([Filter::standard(standard_id(0), 0x400)]);
    }
    if options & 0x80 != 0 {
        config.power_up = Some(Instant::from_nanos(u64::from(later) * 16 * bit));
    }
    Ok(Node { config, restarts: options & 0x02 != 0, plan: Vec::new() })
}

/// A change if bit 7 is set: bits 3-0 say which, and an argument follows; the nodes take turns. Else a frame of the node
/// that bits 2-0 say, given up after so many bits as another byte says if bit 3 is set.
fn item(workload: &mut Workload, at: Instant, bit: u64, input: &mut Unstructured<'_>) -> Result<()> {
    let head: u8 = input.arbitrary()?;
    if head & 0x80 != 0 {
        let which = head & 0x0F;
        workload.in_step &= ![SET_BIT_RATE, SET_CLOCK, SPLIT_OR_JOIN].contains(&which);
        let argument: u8 = input.arbitrary()?;
        workload.one_rate &= which != SET_BIT_RATE && (which != SET_CLOCK || is_tolerated(clock(argument)));
        workload.changes.push(Intent { at, which, argument });
        return Ok(());
    }
    let bits = |count: u8| Duration::from_nanos(u64::from(count) * 4 * bit);
    let given_up_after = if head & 0x08 == 0 { None } else { Some(bits(input.arbitrary()?)) };
    let frame = input::frame(input)?;
    let index = usize::from(head & 0x07) % workload.nodes.len();
    let node = &mut workload.nodes[index];
    // A node that only listens says nothing.
    if !node.config.listen_only {
        node.plan.push(Planned { at, frame, given_up_after });
    }
    Ok(())
}

/// The change, of the node whose turn it is; three faults have names.
fn change(
    Intent { which, argument, .. }: Intent,
    bit: Duration,
    ids: &[NodeId],
    number: usize,
) -> Change<()> {
    let node = ids[number % ids.len()];
    let fault = FaultId(number as u32 % 3);
    let bits = |count: u8| bit * u32::from(count);
    let scope = if argument & 1 == 0 { Scope::Bus } else { Scope::Node(node) };
    let (receiver, filter) = (node, None);
    let chosen = match argument & 3 {
        0 => Which::All,
        1 => Which::Share(0.5),
        _ => Which::Next(u32::from(argument >> 2)),
    };
    let fault_on = |what| Change::FaultOn(fault, what);
    match which {
        0 => Change::Cut(node),
        1 => Change::Plug(node),
        2 => Change::PowerOff(node),
        3 => Change::PowerOn(node),
        4 => Change::PowerCycle(node),
        SET_BIT_RATE => Change::SetBitRate(node, bit_rate(argument)),
        SET_CLOCK => Change::SetClock(node, clock(argument)),
        7 => Change::SetReaction(node, Reaction::Uniform(Duration::ZERO, bits(argument))),
        8 => fault_on(Fault::BitFlips { rate: f64::from(argument) / 4096.0, scope }),
        9 => {
            fault_on(Fault::FlipBit { frame: u64::from(argument & 3), bit: u32::from(argument >> 1), scope })
        }
        10 => fault_on(Fault::Bursts { gap: bits(argument) * 4, length: bits(argument >> 4), scope }),
        11 => fault_on(Fault::Babble { pull: bits(argument >> 3), every: bits(argument) * 2 }),
        12 => fault_on(Fault::SpoiltEnd { receiver, filter, which: chosen }),
        13 => fault_on(Fault::Overrun { receiver, filter, which: chosen }),
        14 => Change::FaultOff(fault),
        SPLIT_OR_JOIN if argument & 1 == 0 => Change::Split(ids.iter().copied().step_by(2).collect()),
        _ => Change::Join,
    }
}

fn clock(argument: u8) -> i32 {
    [0, 50, -3_900, 20_000][usize::from(argument & 3)]
}

/// Controllers stay in step on the wire.
fn is_tolerated(ppm: i32) -> bool {
    ppm.abs() <= 4_000
}

fn bit_rate(bits: u8) -> BitRate {
    [BitRate::K125, BitRate::K250, BitRate::K500, BitRate::M1][usize::from(bits & 3)]
}

const SET_BIT_RATE: u8 = 5;
const SET_CLOCK: u8 = 6;
const SPLIT_OR_JOIN: u8 = 15;
const MOST_ITEMS: usize = 64;
