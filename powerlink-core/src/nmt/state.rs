//! The NMT states of a controlled node, and the transitions between them.

use core::fmt;

use crate::wire::{NmtCommandId, NmtStateCode};

/// An NMT state of a controlled node.
///
/// | State | Code | Cycle | Status LED |
/// |---|---|---|---|
/// | `Off` | 0x00 | | off |
/// | `Initialising` | 0x19 | | off |
/// | `ResetApplication` | 0x29 | | off |
/// | `ResetCommunication` | 0x39 | | off |
/// | `ResetConfiguration` | 0x79 | | off |
/// | `NotActive` | 0x1C | no | off |
/// | `PreOperational1` | 0x1D | no | single flash |
/// | `PreOperational2` | 0x5D | yes | double flash |
/// | `ReadyToOperate` | 0x6D | yes | triple flash |
/// | `Operational` | 0xFD | yes | on |
/// | `Stopped` | 0x4D | yes, without PRes | blinking |
/// | `BasicEthernet` | 0x1E | no | flickering |
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum NmtState {
    /// NMT_GS_OFF: without power.
    Off,
    /// NMT_GS_INITIALISING: the hardware is set up.
    Initialising,
    /// NMT_GS_RESET_APPLICATION: the objects of the application get their power-on values.
    ResetApplication,
    /// NMT_GS_RESET_COMMUNICATION: the objects of communication get their power-on values.
    ResetCommunication,
    /// NMT_GS_RESET_CONFIGURATION: the values of the objects become the active configuration.
    ResetConfiguration,
    /// NMT_CS_NOT_ACTIVE: listening for a managing node.
    NotActive,
    /// NMT_CS_PRE_OPERATIONAL_1: sends when invited, no cycle yet.
    PreOperational1,
    /// NMT_CS_PRE_OPERATIONAL_2: polled, process data do not count.
    PreOperational2,
    /// NMT_CS_READY_TO_OPERATE: told the managing node that it is ready.
    ReadyToOperate,
    /// NMT_CS_OPERATIONAL: process data count.
    Operational,
    /// NMT_CS_STOPPED: not polled.
    Stopped,
    /// NMT_CS_BASIC_ETHERNET: there is no managing node; plain Ethernet.
    BasicEthernet,
}

/// What can lead from one state to another.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Cause {
    /// Power is on.
    PowerOn,
    /// The application resets the node.
    LocalReset,
    /// Power is lost, or the application stops the node for good.
    SwitchOff,
    /// The work of an initialisation sub-state is done.
    Done,
    /// NMTSwReset
    SwReset,
    /// NMTResetNode
    ResetNode,
    /// NMTResetCommunication
    ResetCommunication,
    /// NMTResetConfiguration
    ResetConfiguration,
    /// NMTStartNode
    StartNode,
    /// NMTStopNode
    StopNode,
    /// NMTEnterPreOperational2
    #[cfg_attr(feature = "serde", serde(rename = "enter_pre_operational_2"))]
    EnterPreOperational2,
    /// NMTEnableReadyToOperate
    EnableReadyToOperate,
    /// The application is ready to operate.
    ApplicationReady,
    /// A SoC was received.
    Soc,
    /// A SoA was received.
    Soa,
    /// A PReq was received.
    Preq,
    /// A PRes was received.
    Pres,
    /// No POWERLINK frame in [`NmtState::NotActive`] for the time of 0x1F99.
    BasicEthernetTimeout,
    /// The threshold of an error counter was reached.
    CycleError,
    /// A frame had an invalid format.
    InternalError,
}

/// A transition.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Edge {
    /// Its name in EPSG DS 301, without `NMT_`.
    pub name: &'static str,
    /// The state that it leaves.
    pub from: NmtState,
    /// Why.
    pub cause: Cause,
    /// The state that it enters.
    pub to: NmtState,
}

impl NmtState {
    /// In the order of start-up.
    pub const ALL: [Self; 12] = [
        Self::Off,
        Self::Initialising,
        Self::ResetApplication,
        Self::ResetCommunication,
        Self::ResetConfiguration,
        Self::NotActive,
        Self::PreOperational1,
        Self::PreOperational2,
        Self::ReadyToOperate,
        Self::Operational,
        Self::Stopped,
        Self::BasicEthernet,
    ];

    /// As it stands in frames.
    #[must_use]
    pub const fn code(self) -> NmtStateCode {
        match self {
            Self::Off => NmtStateCode::OFF,
            Self::Initialising => NmtStateCode::INITIALISING,
            Self::ResetApplication => NmtStateCode::RESET_APPLICATION,
            Self::ResetCommunication => NmtStateCode::RESET_COMMUNICATION,
            Self::ResetConfiguration => NmtStateCode::RESET_CONFIGURATION,
            Self::NotActive => NmtStateCode::NOT_ACTIVE,
            Self::PreOperational1 => NmtStateCode::PRE_OPERATIONAL_1,
            Self::PreOperational2 => NmtStateCode::PRE_OPERATIONAL_2,
            Self::ReadyToOperate => NmtStateCode::READY_TO_OPERATE,
            Self::Operational => NmtStateCode::OPERATIONAL,
            Self::Stopped => NmtStateCode::STOPPED,
            Self::BasicEthernet => NmtStateCode::BASIC_ETHERNET,
        }
    }

    /// NMT_GS_POWERED: all but `Off`.
    #[must_use]
    pub const fn is_powered(self) -> bool {
        !matches!(self, Self::Off)
    }

    /// NMT_GS_INITIALISATION: sub-states that end by themselves.
    #[must_use]
    pub const fn is_initialisation(self) -> bool {
        matches!(
            self,
            Self::Initialising | Self::ResetApplication | Self::ResetCommunication | Self::ResetConfiguration
        )
    }

    /// NMT_GS_COMMUNICATING: powered, and not in initialisation.
    #[must_use]
    pub const fn is_communicating(self) -> bool {
        self.is_powered() && !self.is_initialisation()
    }

    /// NMT_CS_EPL_MODE: a managing node decides when the node sends.
    #[must_use]
    pub const fn is_powerlink_mode(self) -> bool {
        self.is_cyclic() || matches!(self, Self::PreOperational1)
    }

    /// Whether the managing node runs the full cycle with the node.
    #[must_use]
    pub const fn is_cyclic(self) -> bool {
        self.answers_poll() || matches!(self, Self::Stopped)
    }

    /// Whether a PReq is answered by a PRes.
    #[must_use]
    pub const fn answers_poll(self) -> bool {
        matches!(self, Self::PreOperational2 | Self::ReadyToOperate | Self::Operational)
    }

    /// The name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Off => "Off",
            Self::Initialising => "Initialising",
            Self::ResetApplication => "ResetApplication",
            Self::ResetCommunication => "ResetCommunication",
            Self::ResetConfiguration => "ResetConfiguration",
            Self::NotActive => "NotActive",
            Self::PreOperational1 => "PreOperational1",
            Self::PreOperational2 => "PreOperational2",
            Self::ReadyToOperate => "ReadyToOperate",
            Self::Operational => "Operational",
            Self::Stopped => "Stopped",
            Self::BasicEthernet => "BasicEthernet",
        }
    }
}

impl fmt::Display for NmtState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// As in readings of frames: `NMT_PRE_OPERATIONAL_2`.
#[cfg(feature = "serde")]
impl serde::Serialize for NmtState {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(&self.code())
    }
}

impl Cause {
    /// All of them.
    pub const ALL: [Self; 20] = [
        Self::PowerOn,
        Self::LocalReset,
        Self::SwitchOff,
        Self::Done,
        Self::SwReset,
        Self::ResetNode,
        Self::ResetCommunication,
        Self::ResetConfiguration,
        Self::StartNode,
        Self::StopNode,
        Self::EnterPreOperational2,
        Self::EnableReadyToOperate,
        Self::ApplicationReady,
        Self::Soc,
        Self::Soa,
        Self::Preq,
        Self::Pres,
        Self::BasicEthernetTimeout,
        Self::CycleError,
        Self::InternalError,
    ];

    /// What a command asks for, plain or extended; `None` if a controlled node does not follow it.
    #[must_use]
    pub const fn of_command(command: NmtCommandId) -> Option<Self> {
        Some(match command.plain() {
            NmtCommandId::START_NODE => Self::StartNode,
            NmtCommandId::STOP_NODE => Self::StopNode,
            NmtCommandId::ENTER_PRE_OPERATIONAL_2 => Self::EnterPreOperational2,
            NmtCommandId::ENABLE_READY_TO_OPERATE => Self::EnableReadyToOperate,
            NmtCommandId::RESET_NODE => Self::ResetNode,
            NmtCommandId::RESET_COMMUNICATION => Self::ResetCommunication,
            NmtCommandId::RESET_CONFIGURATION => Self::ResetConfiguration,
            NmtCommandId::SW_RESET => Self::SwReset,
            _ => return None,
        })
    }

    /// In words.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::PowerOn => "power on",
            Self::LocalReset => "local reset",
            Self::SwitchOff => "switch off",
            Self::Done => "done",
            Self::SwReset => "NMTSwReset",
            Self::ResetNode => "NMTResetNode",
            Self::ResetCommunication => "NMTResetCommunication",
            Self::ResetConfiguration => "NMTResetConfiguration",
            Self::StartNode => "NMTStartNode",
            Self::StopNode => "NMTStopNode",
            Self::EnterPreOperational2 => "NMTEnterPreOperational2",
            Self::EnableReadyToOperate => "NMTEnableReadyToOperate",
            Self::ApplicationReady => "application ready",
            Self::Soc => "SoC",
            Self::Soa => "SoA",
            Self::Preq => "PReq",
            Self::Pres => "PRes",
            Self::BasicEthernetTimeout => "basic Ethernet timeout",
            Self::CycleError => "cycle error",
            Self::InternalError => "internal communication error",
        }
    }
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// `| CT2 | NotActive | SoA | PreOperational1 |`
impl fmt::Display for Edge {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "| {} | {} | {} | {} |", self.name, self.from, self.cause, self.to)
    }
}
