//! The states of the managing node, and how far it is with each node.

use core::fmt;

use crate::wire::NmtStateCode;

/// The NMT state of the managing node.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MnState {
    /// It was not started.
    Off,
    /// It listens whether there is another managing node.
    NotActive,
    /// The reduced cycle: only SoA. Nodes are identified and configured.
    PreOperational1,
    /// The cycle runs. Nodes get ready.
    PreOperational2,
    /// Every mandatory node is ready.
    ReadyToOperate,
    /// Nodes are started, and outputs count.
    Operational,
}

/// Why the managing node changes its state.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum MnCause {
    /// The application starts it.
    Start,
    /// The application stops it.
    Stop,
    /// SoC or SoA of another managing node was heard.
    OtherManagingNode,
    /// Nobody was heard for long enough.
    Quiet,
    /// Every mandatory node is configured.
    NodesConfigured,
    /// Every mandatory node is ready to operate.
    NodesReady,
    /// The cycle ran for long enough with all of them.
    CommunicationChecked,
}

/// How far the managing node is with a node.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum NodePhase {
    /// It is asked for an IdentResponse.
    Absent,
    /// Error signalling begins anew: StatusRequest with ER=1, until EC=1.
    Clearing,
    /// StatusRequest with ER=0, until EC=0.
    Signalling,
    /// Its objects are written.
    Configuring,
    /// It was told NMTResetConfiguration, and is asked for an IdentResponse again.
    Restarting,
    /// It waits for the cycle, and for `PreOperational2`.
    Configured,
    /// It is polled, and told NMTEnableReadyToOperate.
    #[cfg_attr(feature = "serde", serde(rename = "pre_operational_2"))]
    PreOperational2,
    /// It is polled, and waits for NMTStartNode.
    ReadyToOperate,
    /// It is polled, and its process data count.
    Operational,
    /// It was stopped by the application.
    Stopped,
    /// It is not the node of the plan, or does not take its configuration. It is tried again later.
    Refused,
}

/// Why the managing node is further with a node, or less far.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum NodeCause {
    /// An IdentResponse of the node of the plan.
    Identified,
    /// An IdentResponse of another device, or a configuration that is not taken.
    Mismatch,
    /// EC=1
    ExceptionClear,
    /// EC=0
    SignallingRuns,
    /// EC stays 1.
    SignallingStuck,
    /// Every object is written.
    Written,
    /// An object cannot be written.
    WriteRefused,
    /// The IdentResponse after NMTResetConfiguration does not show the configuration.
    NotTaken,
    /// The node shows the state.
    StateShown,
    /// NMTStopNode was sent.
    StopSent,
    /// It does not answer, shows a wrong state, or was restarted.
    Lost,
    /// It is reset: by the application, or because the managing node begins.
    Reset,
    /// It is tried again.
    Retry,
}

/// A transition: the row of a table.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Edge<S, C> {
    /// The state that is left.
    pub from: S,
    /// Why.
    pub cause: C,
    /// The state that is entered.
    pub to: S,
}

/// Every transition of the managing node.
///
/// | From | Cause | To |
/// |---|---|---|
/// | Off | start | NotActive |
/// | NotActive | quiet | PreOperational1 |
/// | PreOperational1 | nodes configured | PreOperational2 |
/// | PreOperational2 | nodes ready | ReadyToOperate |
/// | ReadyToOperate | communication checked | Operational |
/// | PreOperational1 | another managing node | NotActive |
/// | PreOperational2 | another managing node | NotActive |
/// | ReadyToOperate | another managing node | NotActive |
/// | Operational | another managing node | NotActive |
/// | NotActive | stop | Off |
/// | PreOperational1 | stop | Off |
/// | PreOperational2 | stop | Off |
/// | ReadyToOperate | stop | Off |
/// | Operational | stop | Off |
pub const MN_EDGES: &[Edge<MnState, MnCause>] = {
    use MnCause::*;
    use MnState::*;
    const fn edge(from: MnState, cause: MnCause, to: MnState) -> Edge<MnState, MnCause> {
        Edge { from, cause, to }
    }
    &[
        edge(Off, Start, NotActive),
        edge(NotActive, Quiet, PreOperational1),
        edge(PreOperational1, NodesConfigured, PreOperational2),
        edge(PreOperational2, NodesReady, ReadyToOperate),
        edge(ReadyToOperate, CommunicationChecked, Operational),
        edge(PreOperational1, OtherManagingNode, NotActive),
        edge(PreOperational2, OtherManagingNode, NotActive),
        edge(ReadyToOperate, OtherManagingNode, NotActive),
        edge(Operational, OtherManagingNode, NotActive),
        edge(NotActive, Stop, Off),
        edge(PreOperational1, Stop, Off),
        edge(PreOperational2, Stop, Off),
        edge(ReadyToOperate, Stop, Off),
        edge(Operational, Stop, Off),
    ]
};

/// Every transition of a node, as the managing node sees it.
///
/// | From | Cause | To |
/// |---|---|---|
/// | Absent | identified | Clearing |
/// | Absent | mismatch | Refused |
/// | Clearing | EC=1 | Signalling |
/// | Signalling | EC=0 | Configuring |
/// | Signalling | EC stays 1 | Clearing |
/// | Configuring | written | Restarting |
/// | Configuring | write refused | Refused |
/// | Restarting | identified | Configured |
/// | Restarting | configuration not taken | Clearing |
/// | Restarting | mismatch | Refused |
/// | Configured | state shown | PreOperational2 |
/// | PreOperational2 | state shown | ReadyToOperate |
/// | PreOperational2 | NMTStopNode sent | Stopped |
/// | ReadyToOperate | state shown | Operational |
/// | ReadyToOperate | NMTStopNode sent | Stopped |
/// | Operational | state shown | PreOperational2 |
/// | Operational | NMTStopNode sent | Stopped |
/// | Stopped | state shown | PreOperational2 |
/// | Refused | retry | Absent |
/// | Clearing | lost | Absent |
/// | Signalling | lost | Absent |
/// | Configuring | lost | Absent |
/// | Restarting | lost | Absent |
/// | Configured | lost | Absent |
/// | PreOperational2 | lost | Absent |
/// | ReadyToOperate | lost | Absent |
/// | Operational | lost | Absent |
/// | Stopped | lost | Absent |
/// | Clearing | reset | Absent |
/// | Signalling | reset | Absent |
/// | Configuring | reset | Absent |
/// | Restarting | reset | Absent |
/// | Configured | reset | Absent |
/// | PreOperational2 | reset | Absent |
/// | ReadyToOperate | reset | Absent |
/// | Operational | reset | Absent |
/// | Stopped | reset | Absent |
/// | Refused | reset | Absent |
pub const NODE_EDGES: &[Edge<NodePhase, NodeCause>] = {
    use NodeCause::*;
    use NodePhase::*;
    const fn edge(from: NodePhase, cause: NodeCause, to: NodePhase) -> Edge<NodePhase, NodeCause> {
        Edge { from, cause, to }
    }
    &[
        edge(Absent, Identified, Clearing),
        edge(Absent, Mismatch, Refused),
        edge(Clearing, ExceptionClear, Signalling),
        edge(Signalling, SignallingRuns, Configuring),
        edge(Signalling, SignallingStuck, Clearing),
        edge(Configuring, Written, Restarting),
        edge(Configuring, WriteRefused, Refused),
        edge(Restarting, Identified, Configured),
        edge(Restarting, NotTaken, Clearing),
        edge(Restarting, Mismatch, Refused),
        edge(Configured, StateShown, PreOperational2),
        edge(PreOperational2, StateShown, ReadyToOperate),
        edge(PreOperational2, StopSent, Stopped),
        edge(ReadyToOperate, StateShown, Operational),
        edge(ReadyToOperate, StopSent, Stopped),
        edge(Operational, StateShown, PreOperational2),
        edge(Operational, StopSent, Stopped),
        edge(Stopped, StateShown, PreOperational2),
        edge(Refused, Retry, Absent),
        edge(Clearing, Lost, Absent),
        edge(Signalling, Lost, Absent),
        edge(Configuring, Lost, Absent),
        edge(Restarting, Lost, Absent),
        edge(Configured, Lost, Absent),
        edge(PreOperational2, Lost, Absent),
        edge(ReadyToOperate, Lost, Absent),
        edge(Operational, Lost, Absent),
        edge(Stopped, Lost, Absent),
        edge(Clearing, Reset, Absent),
        edge(Signalling, Reset, Absent),
        edge(Configuring, Reset, Absent),
        edge(Restarting, Reset, Absent),
        edge(Configured, Reset, Absent),
        edge(PreOperational2, Reset, Absent),
        edge(ReadyToOperate, Reset, Absent),
        edge(Operational, Reset, Absent),
        edge(Stopped, Reset, Absent),
        edge(Refused, Reset, Absent),
    ]
};

impl MnState {
    /// What stands in its frames.
    #[must_use]
    pub const fn code(self) -> NmtStateCode {
        match self {
            Self::Off => NmtStateCode::OFF,
            Self::NotActive => NmtStateCode::NOT_ACTIVE,
            Self::PreOperational1 => NmtStateCode::PRE_OPERATIONAL_1,
            Self::PreOperational2 => NmtStateCode::PRE_OPERATIONAL_2,
            Self::ReadyToOperate => NmtStateCode::READY_TO_OPERATE,
            Self::Operational => NmtStateCode::OPERATIONAL,
        }
    }

    /// Whether it sends at all.
    #[must_use]
    pub const fn is_active(self) -> bool {
        !matches!(self, Self::Off | Self::NotActive)
    }

    /// Whether there are SoC and polls.
    #[must_use]
    pub const fn is_cyclic(self) -> bool {
        matches!(self, Self::PreOperational2 | Self::ReadyToOperate | Self::Operational)
    }

    const fn name(self) -> &'static str {
        match self {
            Self::Off => "Off",
            Self::NotActive => "NotActive",
            Self::PreOperational1 => "PreOperational1",
            Self::PreOperational2 => "PreOperational2",
            Self::ReadyToOperate => "ReadyToOperate",
            Self::Operational => "Operational",
        }
    }
}

impl MnCause {
    const fn name(self) -> &'static str {
        match self {
            Self::Start => "start",
            Self::Stop => "stop",
            Self::OtherManagingNode => "another managing node",
            Self::Quiet => "quiet",
            Self::NodesConfigured => "nodes configured",
            Self::NodesReady => "nodes ready",
            Self::CommunicationChecked => "communication checked",
        }
    }
}

impl NodePhase {
    /// Whether the node is polled, unless it is served in the asynchronous phase only.
    #[must_use]
    pub const fn is_polled(self) -> bool {
        matches!(self, Self::PreOperational2 | Self::ReadyToOperate | Self::Operational)
    }

    /// Whether the node has its configuration.
    #[must_use]
    pub const fn is_configured(self) -> bool {
        matches!(self, Self::Configured | Self::Stopped) || self.is_polled()
    }

    const fn name(self) -> &'static str {
        match self {
            Self::Absent => "Absent",
            Self::Clearing => "Clearing",
            Self::Signalling => "Signalling",
            Self::Configuring => "Configuring",
            Self::Restarting => "Restarting",
            Self::Configured => "Configured",
            Self::PreOperational2 => "PreOperational2",
            Self::ReadyToOperate => "ReadyToOperate",
            Self::Operational => "Operational",
            Self::Stopped => "Stopped",
            Self::Refused => "Refused",
        }
    }
}

impl NodeCause {
    const fn name(self) -> &'static str {
        match self {
            Self::Identified => "identified",
            Self::Mismatch => "mismatch",
            Self::ExceptionClear => "EC=1",
            Self::SignallingRuns => "EC=0",
            Self::SignallingStuck => "EC stays 1",
            Self::Written => "written",
            Self::WriteRefused => "write refused",
            Self::NotTaken => "configuration not taken",
            Self::StateShown => "state shown",
            Self::StopSent => "NMTStopNode sent",
            Self::Lost => "lost",
            Self::Reset => "reset",
            Self::Retry => "retry",
        }
    }
}

macro_rules! displayed {
    ($($Type:ty),*) => {$(
        impl fmt::Display for $Type {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.pad(self.name())
            }
        }
    )*};
}

displayed!(MnState, MnCause, NodePhase, NodeCause);

/// As in readings of frames: `NMT_PRE_OPERATIONAL_2`.
#[cfg(feature = "serde")]
impl serde::Serialize for MnState {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(&self.code())
    }
}

/// `| Off | start | NotActive |`
impl<S: fmt::Display, C: fmt::Display> fmt::Display for Edge<S, C> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "| {} | {} | {} |", self.from, self.cause, self.to)
    }
}
