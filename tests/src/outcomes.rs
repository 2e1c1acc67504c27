//! What becomes of nodes that are switched on with one MAC ID: the table of `docs/results.md`.

use core::fmt::Write as _;
use std::path::Path;

use devicenet_cli::scenario::{Scenario, StateName};
use devicenet_cli::simulate::{self, Settings, Summary};
use transport_mock::rng::Rng;

/// A line of the table.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// How many nodes have the MAC ID.
    pub nodes: usize,
    /// Whether another node is there, which acknowledges.
    pub bystander: bool,
    /// In which time they are switched on.
    pub start: Start,
}

/// When the nodes of a [`Case`] are switched on.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Start {
    /// All at the same moment, so that their requests begin in the same bit.
    SameBit,
    /// Each at a random moment of 10 ms.
    Within10ms,
    /// Each at a random moment of one second.
    Within1s,
}

impl Start {
    const ALL: [Self; 3] = [Self::SameBit, Self::Within10ms, Self::Within1s];

    const fn words(self) -> &'static str {
        match self {
            Self::SameBit => "in the same bit",
            Self::Within10ms => "within 10 ms",
            Self::Within1s => "within 1 s",
        }
    }

    const fn latest(self) -> &'static str {
        match self {
            Self::SameBit => "0s",
            Self::Within10ms => "10ms",
            Self::Within1s => "1s",
        }
    }
}

impl Case {
    /// Every line of the table.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let mut cases = Vec::new();
        for nodes in [2, 3, 10, 63] {
            for bystander in [true, false] {
                cases.extend(Start::ALL.map(|start| Self { nodes, bystander, start }));
            }
        }
        cases
    }

    /// The scenario with this seed, from which the serial numbers and the moments follow.
    #[must_use]
    pub fn scenario(&self, seed: u64) -> Scenario {
        let mut text = format!("[bus]\nduration = \"5s\"\nseed = {seed}\n");
        let mut rng = Rng::new(seed, SERIAL_NUMBERS);
        for node in 0..self.nodes {
            let serial = rng.next_u64() >> 32;
            let latest = self.start.latest();
            let _ = write!(
                text,
                "[[node]]\nname = \"twin-{node}\"\nprotocol = \"devicenet\"\nrole = \"access\"\nmac = 63\n\
                 identity = {{ vendor = 0x1234, serial = {serial} }}\n\
                 power_up = {{ min = \"0s\", max = \"{latest}\" }}\n"
            );
        }
        if self.bystander {
            text.push_str("[[node]]\nname = \"bystander\"\nrole = \"external\"\n");
        }
        Scenario::parse("case", &text, Path::new("")).unwrap_or_else(|error| unreachable!("{error}"))
    }

    /// What the runs with these seeds came to.
    #[must_use]
    pub fn outcome(&self, seeds: core::ops::RangeInclusive<u64>) -> Counted {
        let mut counted = Counted::default();
        for seed in seeds {
            counted.add(&simulate::outcome(&self.scenario(seed), Settings::default()).summary);
        }
        counted
    }
}

/// How many nodes came to what, in each of several runs.
#[derive(Clone, Debug, Default)]
pub struct Counted {
    /// On line.
    pub on_line: Vec<usize>,
    /// Off line because of a duplicate MAC ID.
    pub duplicate: Vec<usize>,
    /// Bus-off.
    pub bus_off: Vec<usize>,
    /// Still checking, which they do as long as nobody acknowledges.
    pub checking: Vec<usize>,
    /// Error frames.
    pub error_frames: Vec<usize>,
}

impl Counted {
    fn add(&mut self, summary: &Summary) {
        let twins = || summary.nodes.iter().filter(|node| node.state.is_some());
        let count = |state| twins().filter(|node| node.state == Some(state)).count();
        let bus_off = twins().filter(|node| node.bus_offs > 0).count();
        self.on_line.push(count(StateName::OnLine));
        self.bus_off.push(bus_off);
        self.duplicate.push(count(StateName::CommFault) - bus_off);
        self.checking.push(count(StateName::SendingDupMac) + count(StateName::WaitingDupMac));
        self.error_frames.push(summary.bus.errors as usize);
    }
}

/// The table in Markdown.
#[must_use]
pub fn table() -> String {
    let mut text = String::from(
        "| Nodes | Bystander | Switched on | On line | Duplicate fault | Bus-off | Still checking | Error frames |\n\
         |---|---|---|---|---|---|---|---|\n",
    );
    for case in Case::all() {
        let counted = case.outcome(1..=RUNS);
        let bystander = if case.bystander { "yes" } else { "no" };
        let _ = write!(text, "| {} | {bystander} | {} |", case.nodes, case.start.words());
        let columns = [
            &counted.on_line,
            &counted.duplicate,
            &counted.bus_off,
            &counted.checking,
            &counted.error_frames,
        ];
        for column in columns {
            let _ = write!(text, " {} |", range(column));
        }
        text.push('\n');
    }
    text
}

/// `1`, or `0 to 5 (mean 1.2)`.
fn range(counts: &[usize]) -> String {
    let (least, most) = (counts.iter().min().unwrap_or(&0), counts.iter().max().unwrap_or(&0));
    if least == most {
        return least.to_string();
    }
    // In tenths, rounded: integers are the same on every machine.
    let tenths = (counts.iter().sum::<usize>() * 20 / counts.len()).div_ceil(2);
    format!("{least} to {most} (mean {}.{})", tenths / 10, tenths % 10)
}

/// Runs of each case, with the seeds from 1.
pub const RUNS: u64 = 20;
/// The stream of random numbers that serial numbers are drawn from.
const SERIAL_NUMBERS: u64 = 63;
