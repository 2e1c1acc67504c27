//! Where a network stands in its file: what is wrong with the whole has a place there, too.

use core::ops::Range;
use core::time::Duration;

use powerlink_core::NodeId;
use powerlink_core::managing::{ConfigError, Direction};

use crate::scenario::{ScenarioError, Time};

/// The places of a file.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct Places {
    pub(super) file: String,
    pub(super) text: String,
    /// `cycle`, if the file has it.
    pub(super) cycle: Option<Range<usize>>,
    pub(super) nodes: Vec<NodePlaces>,
}

/// Those of a node.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct NodePlaces {
    pub(super) node: NodeId,
    pub(super) table: Range<usize>,
    pub(super) multiplexed_slot: Option<Range<usize>>,
    /// Each object in its PReq.
    pub(super) map_outputs: Vec<Range<usize>>,
    /// Each object in its PRes.
    pub(super) map_inputs: Vec<Range<usize>>,
    /// Each object that is written.
    pub(super) writes: Vec<Range<usize>>,
}

impl Places {
    /// What the managing node refuses, at its place.
    pub(crate) fn refuse(&self, error: &ConfigError) -> ScenarioError {
        let node = self.nodes.iter().find(|node| Some(node.node) == error.node());
        let place = node.map_or_else(|| self.cycle(), |node| node.place(error));
        ScenarioError::at(&self.file, &self.text, &place, words(error))
    }

    /// The cycle; where it has its default, the last node, which is one too many for it.
    fn cycle(&self) -> Range<usize> {
        let last = || self.nodes.last().map(|node| node.table.clone());
        self.cycle.clone().or_else(last).unwrap_or_default()
    }
}

impl NodePlaces {
    fn place(&self, error: &ConfigError) -> Range<usize> {
        let place = match *error {
            ConfigError::Mapping { direction, entry, .. } => self.mapped(direction).get(entry),
            ConfigError::TooManyMapped { direction, room, .. } => self.mapped(direction).get(room),
            ConfigError::Value { write, .. } => self.writes.get(write),
            ConfigError::MultiplexedSlot { .. } => self.multiplexed_slot.as_ref(),
            ConfigError::TooManyNodes { .. }
            | ConfigError::Node(_)
            | ConfigError::Twice(_)
            | ConfigError::DataLimit { .. }
            | ConfigError::CycleLength { .. }
            | ConfigError::Cycle { .. } => None,
        };
        place.unwrap_or(&self.table).clone()
    }

    fn mapped(&self, direction: Direction) -> &[Range<usize>] {
        match direction {
            Direction::Outputs => &self.map_outputs,
            Direction::Inputs => &self.map_inputs,
        }
    }
}

/// Times have the units of the file.
fn words(error: &ConfigError) -> String {
    match error {
        ConfigError::Cycle { cycle, needed } => {
            let needed =
                Duration::from_micros(needed.as_nanos().div_ceil(1_000).try_into().unwrap_or(u64::MAX));
            format!(
                "a cycle of {} is too short: it needs {} for its frames and waits (`wait_soc_preq`, each \
                 `pres_timeout`, `async_slot`)",
                Time(*cycle),
                Time(needed)
            )
        }
        ConfigError::CycleLength { cycle } => {
            format!("a cycle of {}; expected whole microseconds, at most 4294.967295s", Time(*cycle))
        }
        other => other.to_string(),
    }
}
