//! The states of a slave as its master sees them, and the transitions between them.

use core::fmt;

use super::scan_list::IoInstance;

/// [`SlaveState`] with its data.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Stage {
    /// The master is not on line.
    Offline,
    /// Until the next attempt.
    Waiting,
    /// Its explicit connection is being allocated or opened.
    Contacting(Contact),
    /// What stands before the I/O.
    Configuring(Step),
    /// Its I/O runs.
    Running,
}

/// The ways to an explicit connection.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Contact {
    /// Allocate on the unconnected port. `released`: what an earlier life of this master left was released before.
    Allocate { released: bool },
    /// Release of everything at once.
    ReleaseAll,
    /// Release of one bit of the choice after another: the slave refused all at once.
    ReleaseOne { bit: u8 },
    /// Open with the UCMM.
    Open,
}

/// What is asked over the explicit connection, in this order.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Step {
    WatchdogAction,
    Vendor,
    DeviceType,
    ProductCode,
    Revision,
    /// `released`: what an earlier life of this master left was released before.
    AllocateIo {
        released: bool,
    },
    /// Of all I/O connections at once, or of one after another.
    ReleaseIo {
        bit: Option<u8>,
    },
    ProducedSize(IoInstance),
    ConsumedSize(IoInstance),
    /// The attribute write that begins there.
    Write(u16),
    InhibitTime(IoInstance),
    PacketRate(IoInstance),
    /// A connection that the UCMM opened is closed again.
    Close,
}

/// Where the master is with a slave.
///
/// ```text
///            on line        retry due            answered
/// +---------+       +---------+      +------------+      +-------------+        +---------+
/// | Offline |------>| Waiting |----->| Contacting |----->| Configuring |------->| Running |
/// +---------+       +---------+      +------------+      +-------------+        +---------+
///                       ^   ^  no answer | ^ stale           |   refused,           | slave
///                       |   +------------+ | connections     |   wrong device       | lost
///                       |                  +-----+           |                      |
///                       +----------------------------------------------------------+
/// ```
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum SlaveState {
    /// The master is not on line.
    Offline,
    /// Until the next attempt.
    Waiting,
    /// Its explicit connection is being allocated or opened.
    Contacting,
    /// Its identity is checked, its connections are set up.
    Configuring,
    /// Its I/O runs.
    Running,
}

/// Why a slave's state changed.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Cause {
    /// The master is on line.
    MasterOnLine,
    /// The master is no longer on line.
    MasterOffLine,
    /// The pause is over.
    RetryDue,
    /// The slave started anew, and is on line soon: its duplicate MAC ID check was heard.
    CheckHeard,
    /// The explicit connection exists.
    Connected,
    /// Nobody answered.
    NoAnswer,
    /// It is another master's: it says so, or lets that master allocate it.
    OwnedByAnother,
    /// It answered with an error that cannot be worked around.
    Refused,
    /// Not the device that the key asks for.
    KeyMismatch,
    /// Other sizes than the scan list's.
    SizeMismatch,
    /// Every connection is established.
    Established,
    /// Nothing was received for four times the expected packet rate.
    TimedOut,
    /// The application wants it to start anew.
    Commanded,
}

/// A transition.
pub type Edge = link_core::Edge<SlaveState, Cause>;

impl Stage {
    pub(super) const fn state(&self) -> SlaveState {
        match self {
            Self::Offline => SlaveState::Offline,
            Self::Waiting => SlaveState::Waiting,
            Self::Contacting(_) => SlaveState::Contacting,
            Self::Configuring(_) => SlaveState::Configuring,
            Self::Running => SlaveState::Running,
        }
    }
}

impl fmt::Display for SlaveState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Offline => "Offline",
            Self::Waiting => "Waiting",
            Self::Contacting => "Contacting",
            Self::Configuring => "Configuring",
            Self::Running => "Running",
        })
    }
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::MasterOnLine => "master on line",
            Self::MasterOffLine => "master off line",
            Self::RetryDue => "retry due",
            Self::CheckHeard => "duplicate MAC ID check heard",
            Self::Connected => "explicit connection",
            Self::NoAnswer => "no answer",
            Self::OwnedByAnother => "owned by another master",
            Self::Refused => "refused",
            Self::KeyMismatch => "electronic key mismatch",
            Self::SizeMismatch => "size mismatch",
            Self::Established => "connections established",
            Self::TimedOut => "timed out",
            Self::Commanded => "commanded",
        })
    }
}

/// Every transition, in the order of the start-up sequence. Debug builds check each step against it.
///
/// | From | Cause | To |
/// |---|---|---|
/// | Offline | master on line | Waiting |
/// | Waiting | retry due | Contacting |
/// | Waiting | duplicate MAC ID check heard | Waiting |
/// | Contacting | explicit connection | Configuring |
/// | Contacting | duplicate MAC ID check heard | Waiting |
/// | Contacting | no answer | Waiting |
/// | Contacting | owned by another master | Waiting |
/// | Contacting | refused | Waiting |
/// | Configuring | no answer | Waiting |
/// | Configuring | owned by another master | Waiting |
/// | Configuring | refused | Waiting |
/// | Configuring | electronic key mismatch | Waiting |
/// | Configuring | size mismatch | Waiting |
/// | Configuring | duplicate MAC ID check heard | Waiting |
/// | Configuring | connections established | Running |
/// | Running | timed out | Waiting |
/// | Running | duplicate MAC ID check heard | Waiting |
/// | Running | owned by another master | Waiting |
/// | Waiting | commanded | Waiting |
/// | Contacting | commanded | Waiting |
/// | Configuring | commanded | Waiting |
/// | Running | commanded | Waiting |
/// | Waiting | master off line | Offline |
/// | Contacting | master off line | Offline |
/// | Configuring | master off line | Offline |
/// | Running | master off line | Offline |
pub const EDGES: &[Edge] = {
    use Cause::*;
    use SlaveState::*;
    &[
        edge(Offline, MasterOnLine, Waiting),
        edge(Waiting, RetryDue, Contacting),
        edge(Waiting, CheckHeard, Waiting),
        edge(Contacting, Connected, Configuring),
        edge(Contacting, CheckHeard, Waiting),
        edge(Contacting, NoAnswer, Waiting),
        edge(Contacting, OwnedByAnother, Waiting),
        edge(Contacting, Refused, Waiting),
        edge(Configuring, NoAnswer, Waiting),
        edge(Configuring, OwnedByAnother, Waiting),
        edge(Configuring, Refused, Waiting),
        edge(Configuring, KeyMismatch, Waiting),
        edge(Configuring, SizeMismatch, Waiting),
        edge(Configuring, CheckHeard, Waiting),
        edge(Configuring, Established, Running),
        edge(Running, TimedOut, Waiting),
        edge(Running, CheckHeard, Waiting),
        edge(Running, OwnedByAnother, Waiting),
        edge(Waiting, Commanded, Waiting),
        edge(Contacting, Commanded, Waiting),
        edge(Configuring, Commanded, Waiting),
        edge(Running, Commanded, Waiting),
        edge(Waiting, MasterOffLine, Offline),
        edge(Contacting, MasterOffLine, Offline),
        edge(Configuring, MasterOffLine, Offline),
        edge(Running, MasterOffLine, Offline),
    ]
};

const fn edge(from: SlaveState, cause: Cause, to: SlaveState) -> Edge {
    Edge { from, cause, to }
}
