//! The states of the cycle, and the transitions between them.

use core::fmt;

/// Where a controlled node is in the cycle (DLL_CS).
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum CycleState {
    /// There is no cycle in this NMT state, or the first SoC has not come.
    NonCyclic,
    /// After SoA, until the next cycle begins.
    WaitSoc,
    /// After SoC.
    WaitPreq,
    /// After the node's own PReq.
    WaitSoa,
}

/// What happens in a cycle.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum CycleEvent {
    /// SoC.
    Soc,
    /// PReq for this node.
    Preq,
    /// PRes of any node.
    Pres,
    /// SoA.
    Soa,
    /// An ASnd, or a frame of another protocol.
    Asnd,
    /// The time in which the next SoC must come is over.
    SocTimeout,
}

/// Whether the managing node polls the node.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CycleMode {
    /// `PreOperational2`, `ReadyToOperate`, `Operational`.
    Polled,
    /// `Stopped`.
    Stopped,
}

bitflags::bitflags! {
    /// Frames of the managing node that did not come.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
    #[cfg_attr(feature = "serde", derive(serde::Serialize))]
    pub struct Losses: u8 {
        /// SoC.
        const SOC = 0x01;
        /// PReq, if one was due.
        const PREQ = 0x02;
        /// SoA.
        const SOA = 0x04;
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Losses {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "Losses({=u8:#x})", self.bits());
    }
}

/// A transition of the cycle.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct CycleEdge {
    /// In which of the two tables.
    pub mode: CycleMode,
    /// The state that it leaves.
    pub from: CycleState,
    /// Why.
    pub event: CycleEvent,
    /// What is missing.
    pub losses: Losses,
    /// The state that it enters.
    pub to: CycleState,
}

impl CycleState {
    /// The name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::NonCyclic => "NonCyclic",
            Self::WaitSoc => "WaitSoc",
            Self::WaitPreq => "WaitPreq",
            Self::WaitSoa => "WaitSoa",
        }
    }
}

impl fmt::Display for CycleState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl fmt::Display for CycleEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Soc => "SoC",
            Self::Preq => "PReq",
            Self::Pres => "PRes",
            Self::Soa => "SoA",
            Self::Asnd => "ASnd",
            Self::SocTimeout => "SoC timeout",
        })
    }
}

impl fmt::Display for CycleMode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Polled => "polled",
            Self::Stopped => "stopped",
        })
    }
}

/// `SoC, SoA`
impl fmt::Display for Losses {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = [(Self::SOC, "SoC"), (Self::PREQ, "PReq"), (Self::SOA, "SoA")];
        let mut separator = "";
        for (loss, name) in names {
            if self.contains(loss) {
                write!(f, "{separator}{name}")?;
                separator = ", ";
            }
        }
        Ok(())
    }
}

/// `| polled | WaitSoa | SoC | SoA | WaitPreq |`
impl fmt::Display for CycleEdge {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { mode, from, event, losses, to } = self;
        write!(f, "| {mode} | {from} | {event} | {losses} | {to} |")
    }
}
