//! What somebody does to the network while it runs.

use std::fmt;
use std::time::Duration;

use link_core::{BitRate, Mode};

use crate::bus::{Fault, FaultId};
use crate::network::{Network, NodeId};

/// Something that is done to the network at a certain time.
#[non_exhaustive]
pub enum Change<E> {
    /// The cable of a node is unplugged: it loses the bus and network power, and its machine gets
    /// [`LinkEvent::Down`](link_core::LinkEvent::Down). To leave it alone on a piece of cable, use [`Split`](Self::Split).
    Cut(NodeId),
    /// The cable is plugged again: the controller starts anew, and the machine gets
    /// [`LinkEvent::Up`](link_core::LinkEvent::Up).
    Plug(NodeId),
    /// The node loses its power: it stops in the middle of whatever it does.
    PowerOff(NodeId),
    /// The node starts, as it was added, with what its `on_power_up` hook keeps.
    PowerOn(NodeId),
    /// Off, and on at the same moment.
    PowerCycle(NodeId),
    /// The controller restarts with another bit rate, as by a switch that the machine does not read. It keeps it without
    /// power.
    SetBitRate(NodeId, BitRate),
    /// The controller restarts in another mode, and keeps it without power.
    SetListenOnly(NodeId, bool),
    /// The node's clock is fast (positive) or slow by so many parts per million from now on.
    SetClock(NodeId, i32),
    /// The time that the node needs from an input to the first frame that follows from it.
    SetReaction(NodeId, Reaction),
    /// Something begins to be wrong.
    FaultOn(FaultId, Fault),
    /// It is repaired.
    FaultOff(FaultId),
    /// These nodes are cut off together, on a segment of their own.
    Split(Vec<NodeId>),
    /// All segments are joined again.
    Join,
    /// Anything else.
    Call(Call<E>),
}

/// What [`Change::Call`] calls.
pub type Call<E> = Box<dyn FnOnce(&mut Network<E>)>;

/// How long a node takes from an input to the first frame that follows from it.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum Reaction {
    /// No time.
    #[default]
    Immediate,
    /// Always the same.
    Fixed(Duration),
    /// Anything from the first to the last, with equal probability.
    Uniform(Duration, Duration),
}

/// What was done, for the record.
#[derive(Clone, Copy, PartialEq, Debug)]
#[non_exhaustive]
pub enum ChangeKind<'a> {
    /// [`Change::Cut`]
    Cut(NodeId),
    /// [`Change::Plug`]
    Plug(NodeId),
    /// [`Change::PowerOff`]
    PowerOff(NodeId),
    /// [`Change::PowerOn`]
    PowerOn(NodeId),
    /// The controller has another mode: by a [`Change`], or because its machine wanted it.
    Mode(NodeId, Mode),
    /// [`Change::SetClock`]
    Clock(NodeId, i32),
    /// [`Change::SetReaction`]
    Reaction(NodeId, Reaction),
    /// [`Change::FaultOn`]
    FaultOn(FaultId, Fault),
    /// [`Change::FaultOff`]
    FaultOff(FaultId),
    /// [`Change::Split`]
    Split(&'a [NodeId]),
    /// [`Change::Join`]
    Join,
}

impl<E> fmt::Debug for Change<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cut(node) => write!(f, "Cut({node})"),
            Self::Plug(node) => write!(f, "Plug({node})"),
            Self::PowerOff(node) => write!(f, "PowerOff({node})"),
            Self::PowerOn(node) => write!(f, "PowerOn({node})"),
            Self::PowerCycle(node) => write!(f, "PowerCycle({node})"),
            Self::SetBitRate(node, rate) => write!(f, "SetBitRate({node}, {rate})"),
            Self::SetListenOnly(node, on) => write!(f, "SetListenOnly({node}, {on})"),
            Self::SetClock(node, ppm) => write!(f, "SetClock({node}, {ppm} ppm)"),
            Self::SetReaction(node, reaction) => write!(f, "SetReaction({node}, {reaction:?})"),
            Self::FaultOn(id, fault) => write!(f, "FaultOn({}, {fault:?})", id.0),
            Self::FaultOff(id) => write!(f, "FaultOff({})", id.0),
            Self::Split(nodes) => write!(f, "Split({nodes:?})"),
            Self::Join => f.write_str("Join"),
            Self::Call(_) => f.write_str("Call"),
        }
    }
}
