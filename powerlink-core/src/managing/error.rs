//! Configurations that cannot be, and what the application cannot have.

use core::fmt;
use core::time::Duration;

#[cfg(doc)]
use super::config::NodePlan;
use crate::NodeId;
use crate::dictionary::ObjectAddress;

/// Process data of a node, as the managing node sees them.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Direction {
    /// In its PReq: 0x1600 and 0x1F98/4.
    Outputs,
    /// In its PRes: 0x1A00 and 0x1F98/5.
    Inputs,
}

/// A managing node cannot be made so. [`node`](Self::node) tells whose plan it is about.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ConfigError {
    /// There are more plans than `N`.
    #[error("{plans} nodes: there is room for {room}, and {node} is the next")]
    TooManyNodes {
        /// The first without room.
        node: NodeId,
        /// How many there are.
        plans: usize,
        /// How many there may be.
        room: usize,
    },
    /// A node ID is not one of a controlled node.
    #[error("{0} is not a controlled node: use 1 to 239")]
    Node(NodeId),
    /// Two plans have the same node.
    #[error("{0} has two plans")]
    Twice(NodeId),
    /// Process data are too long, or too short for the limits of the protocol.
    #[error("{node}: {direction} of {limit} bytes: use 36 to {room}")]
    DataLimit {
        /// Which node.
        node: NodeId,
        /// Which of its limits.
        direction: Direction,
        /// What its plan says.
        limit: u16,
        /// What there is room for.
        room: usize,
    },
    /// The mapping needs more process data than the limit.
    #[error("{node}: {direction}: object {at} ends at byte {len}: the limit is {limit}")]
    Mapping {
        /// Which node.
        node: NodeId,
        /// Which mapping.
        direction: Direction,
        /// The place of the first entry beyond the limit, counted from 0.
        entry: usize,
        /// Its object.
        at: ObjectAddress,
        /// Where it ends, in bytes.
        len: usize,
        /// What the plan says.
        limit: u16,
    },
    /// A mapping has more objects than sub-indices.
    #[error("{node}: {direction}: {mapped} objects: a mapping has room for {room}")]
    TooManyMapped {
        /// Which node.
        node: NodeId,
        /// Which mapping.
        direction: Direction,
        /// How many there are.
        mapped: usize,
        /// How many have a sub-index: the place of the first one without, counted from 0.
        room: usize,
    },
    /// A value is longer than the SDO buffer.
    #[error("{node}: {at} has {len} bytes: there is room for {room}")]
    Value {
        /// Which node.
        node: NodeId,
        /// The place of the write, counted from 0.
        write: usize,
        /// The object.
        at: ObjectAddress,
        /// The length of the value.
        len: usize,
        /// The longest value.
        room: usize,
    },
    /// A multiplexed slot is not one of the multiplexed cycle.
    #[error("{node}: multiplexed slot {slot}: a multiplexed cycle has {cycles} cycles, counted from 0")]
    MultiplexedSlot {
        /// Which node.
        node: NodeId,
        /// The slot.
        slot: u8,
        /// The length of the multiplexed cycle.
        cycles: u8,
    },
    /// 0x1006 cannot say the cycle length.
    #[error("a cycle of {cycle:?}: use whole microseconds, up to 4294967295 (0x1006)")]
    CycleLength {
        /// What the configuration says.
        cycle: Duration,
    },
    /// Not everything fits into a cycle.
    #[error("a cycle of {cycle:?} is too short: it needs {needed:?}")]
    Cycle {
        /// What the configuration says.
        cycle: Duration,
        /// The longest that a cycle can take.
        needed: Duration,
    },
}

impl ConfigError {
    /// Whose plan it is about; `None` if it is about the cycle.
    #[must_use]
    pub const fn node(&self) -> Option<NodeId> {
        match *self {
            Self::Node(node)
            | Self::Twice(node)
            | Self::TooManyNodes { node, .. }
            | Self::DataLimit { node, .. }
            | Self::Mapping { node, .. }
            | Self::TooManyMapped { node, .. }
            | Self::Value { node, .. }
            | Self::MultiplexedSlot { node, .. } => Some(node),
            Self::CycleLength { .. } | Self::Cycle { .. } => None,
        }
    }
}

impl fmt::Display for Direction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Outputs => "outputs",
            Self::Inputs => "inputs",
        })
    }
}

/// Why the application cannot have what it asks for.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MnError {
    /// The node has no plan.
    #[error("{0} has no plan: give one to `ManagingNode::new`")]
    NoPlan(NodeId),
    /// Outputs are longer than 0x1F98/4 of the node.
    #[error("{node}: {len} bytes of outputs: the limit is {limit}")]
    TooLong {
        /// Which node.
        node: NodeId,
        /// What was given.
        len: usize,
        /// What its plan says.
        limit: u16,
    },
    /// Outputs are not as long as their mapping: the node would report shorter ones as an error, and not use longer ones.
    #[error("{node}: {len} bytes of outputs: the mapping has {mapped}")]
    OutputLength {
        /// Which node.
        node: NodeId,
        /// What was given.
        len: usize,
        /// What is mapped: [`NodePlan::output_len`].
        mapped: usize,
    },
    /// Another transfer of the application is under way.
    #[error("an object is being read or written: wait for `ObjectRead`, `ObjectWritten` or `SdoFailed`")]
    Busy,
    /// The value is longer than the buffer.
    #[error("a value of {len} bytes: there is room for {room}")]
    Value {
        /// The length of the value.
        len: usize,
        /// The longest value.
        room: usize,
    },
    /// Nobody answered yet, so that nothing can be read or written.
    #[error("{0} did not answer yet")]
    Absent(NodeId),
    /// It is no command for nodes.
    #[error("{0} is not a state command: use those of 0x21 to 0x2B")]
    Command(crate::wire::NmtCommandId),
}
