//! The states of the tool, and the transitions between them.

use core::fmt;

use crate::id::MacId;
use crate::message::{DelayOffset, DeviceIdentity, NodeSelection};

/// Where the tool is.
///
/// ```text
///          claim              not answered within two waits
/// +------+       +----------+                              +-------+
/// | Idle |------>| Claiming |----------------------------->| Owner |
/// +------+       +----------+                              +-------+
///    ^  answered, released |     released, another owner       |
///    +---------------------+-----------------------------------+
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum State {
    /// The offline connection set is not wanted, or another tool's, or the tool is not on line.
    Idle,
    /// An ownership request is on its way, or is being waited for.
    Claiming { request: Request, sending: Sending },
    /// The set is this tool's.
    Owner { task: Task, sending: Sending },
}

/// Which of the two ownership requests.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Request {
    First,
    Second,
}

/// Where the message of a state is.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Sending {
    /// To be handed out.
    Due,
    HandedOut,
    /// Its controller met another node with the same identifier: later.
    BackingOff,
    /// On the bus; its consequences are waited for.
    Sent,
}

/// What the owner does.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Task {
    None,
    Who(DelayOffset),
    Identify(NodeSelection),
    IdentifyDevice(DeviceIdentity),
    ChangeMacId { device: DeviceIdentity, mac: MacId, checks: u8 },
}

/// [`OfflineTool`](super::OfflineTool)'s state without its data.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum ToolState {
    /// Without the offline connection set.
    Idle,
    /// Asking whether it has an owner.
    Claiming,
    /// Owner of it.
    Owner,
}

/// Why the state changed.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Cause {
    /// The application wants the set.
    Claimed,
    /// The second request is due.
    WaitOver,
    /// Nobody answered two requests.
    Unanswered,
    /// Another tool owns it, or claimed it first.
    OwnedByAnother,
    /// The application needs it no more.
    Released,
    /// The tool is no longer on line.
    OffLine,
}

/// A transition.
pub type Edge = link_core::Edge<ToolState, Cause>;

impl State {
    pub(super) const fn kind(&self) -> ToolState {
        match self {
            Self::Idle => ToolState::Idle,
            Self::Claiming { .. } => ToolState::Claiming,
            Self::Owner { .. } => ToolState::Owner,
        }
    }

    pub(super) const fn sending(&self) -> Option<Sending> {
        match self {
            Self::Idle | Self::Owner { task: Task::None, .. } => None,
            Self::Claiming { sending, .. } | Self::Owner { sending, .. } => Some(*sending),
        }
    }

    pub(super) const fn sending_mut(&mut self) -> Option<&mut Sending> {
        match self {
            Self::Idle | Self::Owner { task: Task::None, .. } => None,
            Self::Claiming { sending, .. } | Self::Owner { sending, .. } => Some(sending),
        }
    }
}

impl fmt::Display for ToolState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Idle => "Idle",
            Self::Claiming => "Claiming",
            Self::Owner => "Owner",
        })
    }
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Claimed => "claimed",
            Self::WaitOver => "wait over",
            Self::Unanswered => "nobody owns it",
            Self::OwnedByAnother => "owned by another tool",
            Self::Released => "released",
            Self::OffLine => "off line",
        })
    }
}

/// Every transition, in the order of the sequence. Debug builds check each step against it.
///
/// | From | Cause | To |
/// |---|---|---|
/// | Idle | claimed | Claiming |
/// | Claiming | wait over | Claiming |
/// | Claiming | nobody owns it | Owner |
/// | Claiming | owned by another tool | Idle |
/// | Owner | owned by another tool | Idle |
/// | Claiming | released | Idle |
/// | Owner | released | Idle |
/// | Claiming | off line | Idle |
/// | Owner | off line | Idle |
pub const EDGES: &[Edge] = {
    use Cause::*;
    use ToolState::*;
    &[
        edge(Idle, Claimed, Claiming),
        edge(Claiming, WaitOver, Claiming),
        edge(Claiming, Unanswered, Owner),
        edge(Claiming, OwnedByAnother, Idle),
        edge(Owner, OwnedByAnother, Idle),
        edge(Claiming, Released, Idle),
        edge(Owner, Released, Idle),
        edge(Claiming, OffLine, Idle),
        edge(Owner, OffLine, Idle),
    ]
};

const fn edge(from: ToolState, cause: Cause, to: ToolState) -> Edge {
    Edge { from, cause, to }
}
