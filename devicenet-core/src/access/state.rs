//! The states of network access, and the transitions between them.

use core::fmt;

use crate::message::NodeSelection;

/// A state with its data.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum State {
    /// No power, or no network power: waiting for the link to come up.
    NonExistent,
    /// A duplicate MAC ID check request is to be sent.
    SendingDupMac {
        /// Which of the two.
        request: CheckRequest,
        /// How far it is.
        stage: SendStage,
    },
    /// The request was on the bus; a second runs in which others may object.
    WaitingDupMac {
        /// Which of the two was sent.
        request: CheckRequest,
    },
    /// Normal operation.
    OnLine {
        /// A request of another node is to be answered.
        response_due: bool,
        /// The second own request, which Quick Connect puts off.
        second_request: SecondRequest,
    },
    /// Off line, silent.
    CommFault {
        /// Why.
        fault: Fault,
        /// What is going on in the offline connection set.
        offline: OfflineNode,
    },
}

/// Which of the two requests.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CheckRequest {
    /// At first none has been sent.
    First,
    /// One second after the first.
    Second,
}

/// How far the sending of a request is.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SendStage {
    /// To be handed to the controller, or with it.
    Queued {
        /// The controller has told that nobody acknowledges.
        unacknowledged: bool,
    },
    /// Waiting before the controller is restarted after bus-off.
    BackOff,
    /// Waiting for the controller to take part in the bus again.
    Restarting {
        /// It has been told to restart.
        commanded: bool,
    },
    /// The controller gave the request back; waiting before it is handed out again.
    GivenBack,
}

/// The second request under Quick Connect, where the node is on line after the first.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SecondRequest {
    /// Sent.
    Done,
    /// One second after the first.
    Waiting,
    /// To be handed to the controller, or with it.
    Queued,
}

/// Why a node is off line.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Fault {
    /// Another node uses the MAC ID. The controller takes part in the bus, the node does not.
    DuplicateMacId,
    /// The controller is off the bus: nothing can be heard.
    BusOff,
}

/// A faulted node in the offline connection set.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OfflineNode {
    /// The answer to Who.
    pub(super) who: WhoAnswer,
    /// The answer to Identify: byte 0 of the request.
    pub(super) identify: Option<NodeSelection>,
    /// The indicator flashes red and green.
    pub(super) indicating: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) enum WhoAnswer {
    None,
    Delayed,
    Due,
}

/// A state without its data.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum StateKind {
    /// No power, or no network power.
    NonExistent,
    /// A duplicate MAC ID check request is to be sent.
    SendingDupMac,
    /// A request was sent, others may object.
    WaitingDupMac,
    /// Normal operation.
    OnLine,
    /// Off line because of a duplicate MAC ID or of bus-off.
    CommFault,
}

/// Why a state was left, or why it was not.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Cause {
    /// The link came up: power-up, or network power is back.
    LinkUp,
    /// The link went down: network power lost.
    LinkDown,
    /// The application resets the node.
    Reset,
    /// The application sets the MAC ID.
    MacIdSet,
    /// A tool assigns a MAC ID through the offline connection set.
    MacIdAssigned,
    /// The check request was on the bus, and acknowledged.
    RequestSent,
    /// The same, with Quick Connect.
    QuickConnect,
    /// Nobody acknowledges the request.
    NotAcknowledged,
    /// The second in which others may object is over.
    WaitOver,
    /// Another node asks whether somebody uses this MAC ID.
    DuplicateRequest,
    /// Another node says that it uses this MAC ID.
    DuplicateResponse,
    /// Any other frame.
    OtherMessage,
    /// The controller went off the bus, and stays there.
    BusOff,
    /// The controller went off the bus, and is restarted because BOI says so.
    BusOffRestart,
}

/// A transition; its number is that of the row in the transition table of CIP Vol. 3.
pub type Edge = link_core::NumberedEdge<StateKind, Cause>;

impl State {
    /// The state without its data.
    #[must_use]
    pub const fn kind(&self) -> StateKind {
        match self {
            Self::NonExistent => StateKind::NonExistent,
            Self::SendingDupMac { .. } => StateKind::SendingDupMac,
            Self::WaitingDupMac { .. } => StateKind::WaitingDupMac,
            Self::OnLine { .. } => StateKind::OnLine,
            Self::CommFault { .. } => StateKind::CommFault,
        }
    }

    /// The controller went off the bus, and has not come back.
    // Called from several places: in a small device a copy for each is too much.
    #[inline(never)]
    pub(super) const fn is_off_the_bus(&self) -> bool {
        match self {
            Self::SendingDupMac { stage, .. } => {
                matches!(stage, SendStage::BackOff | SendStage::Restarting { .. })
            }
            Self::CommFault { fault, .. } => matches!(fault, Fault::BusOff),
            Self::NonExistent | Self::WaitingDupMac { .. } | Self::OnLine { .. } => false,
        }
    }

    pub(super) const fn queued(request: CheckRequest) -> Self {
        Self::SendingDupMac { request, stage: SendStage::Queued { unacknowledged: false } }
    }

    pub(super) const fn on_line(second_request: SecondRequest) -> Self {
        Self::OnLine { response_due: false, second_request }
    }

    pub(super) const fn faulted(fault: Fault) -> Self {
        let offline = OfflineNode { who: WhoAnswer::None, identify: None, indicating: false };
        Self::CommFault { fault, offline }
    }
}

impl StateKind {
    /// The name in CIP Vol. 3.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::NonExistent => "NonExistent",
            Self::SendingDupMac => "SendingDupMac",
            Self::WaitingDupMac => "WaitingDupMac",
            Self::OnLine => "OnLine",
            Self::CommFault => "CommFault",
        }
    }
}

impl fmt::Display for StateKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl Cause {
    /// In words.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::LinkUp => "link up",
            Self::LinkDown => "link down",
            Self::Reset => "reset",
            Self::MacIdSet => "MAC ID set",
            Self::MacIdAssigned => "MAC ID assigned",
            Self::RequestSent => "request sent",
            Self::QuickConnect => "request sent, Quick Connect",
            Self::NotAcknowledged => "not acknowledged",
            Self::WaitOver => "wait over",
            Self::DuplicateRequest => "duplicate MAC ID request",
            Self::DuplicateResponse => "duplicate MAC ID response",
            Self::OtherMessage => "other message",
            Self::BusOff => "bus-off",
            Self::BusOffRestart => "bus-off, BOI",
        }
    }
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Every transition, in the order of the table of CIP Vol. 3. Debug builds check each step against it.
///
/// | Row | From | Cause | To |
/// |---|---|---|---|
/// | 1 | NonExistent | link up | SendingDupMac |
/// | 1 | SendingDupMac | reset | SendingDupMac |
/// | 1 | WaitingDupMac | reset | SendingDupMac |
/// | 1 | OnLine | reset | SendingDupMac |
/// | 1 | SendingDupMac | MAC ID set | SendingDupMac |
/// | 1 | WaitingDupMac | MAC ID set | SendingDupMac |
/// | 1 | OnLine | MAC ID set | SendingDupMac |
/// | 2 | SendingDupMac | request sent | WaitingDupMac |
/// | 2 | SendingDupMac | request sent, Quick Connect | OnLine |
/// | 2 | OnLine | request sent | OnLine |
/// | 3 | SendingDupMac | not acknowledged | SendingDupMac |
/// | 4 | WaitingDupMac | wait over | SendingDupMac |
/// | 4 | OnLine | wait over | OnLine |
/// | 5 | WaitingDupMac | wait over | OnLine |
/// | 6 | SendingDupMac | duplicate MAC ID request | CommFault |
/// | 6 | SendingDupMac | duplicate MAC ID response | CommFault |
/// | 6 | WaitingDupMac | duplicate MAC ID request | CommFault |
/// | 6 | WaitingDupMac | duplicate MAC ID response | CommFault |
/// | 7 | SendingDupMac | bus-off | CommFault |
/// | 7 | WaitingDupMac | bus-off | CommFault |
/// | 7 | SendingDupMac | bus-off, BOI | SendingDupMac |
/// | 7 | WaitingDupMac | bus-off, BOI | SendingDupMac |
/// | 8 | SendingDupMac | other message | SendingDupMac |
/// | 8 | WaitingDupMac | other message | WaitingDupMac |
/// | 9 | OnLine | duplicate MAC ID request | OnLine |
/// | 10 | OnLine | duplicate MAC ID response | CommFault |
/// | 11 | OnLine | bus-off | CommFault |
/// | 11 | CommFault | bus-off | CommFault |
/// | 12 | OnLine | bus-off, BOI | SendingDupMac |
/// | 13 | CommFault | MAC ID assigned | SendingDupMac |
/// | 14 | CommFault | reset | SendingDupMac |
/// | 14 | CommFault | MAC ID set | SendingDupMac |
/// | 15 | SendingDupMac | link down | NonExistent |
/// | 15 | WaitingDupMac | link down | NonExistent |
/// | 15 | OnLine | link down | NonExistent |
/// | 15 | CommFault | link down | NonExistent |
///
/// Rows that the published table words more widely are spelt out: "reset" and "MAC ID changed" of row 1 for each state
/// that is not faulted, and the restart after bus-off while checking, which happens only with
/// [`FollowInterrupt`](super::BusOffWhileChecking::FollowInterrupt). Under Quick Connect the node is on line while the
/// steps of rows 4 and 2 are done. A node that is faulted by a duplicate can go off the bus as well (row 11).
pub const EDGES: &[Edge] = {
    use Cause::*;
    use StateKind::*;
    &[
        edge(1, NonExistent, LinkUp, SendingDupMac),
        edge(1, SendingDupMac, Reset, SendingDupMac),
        edge(1, WaitingDupMac, Reset, SendingDupMac),
        edge(1, OnLine, Reset, SendingDupMac),
        edge(1, SendingDupMac, MacIdSet, SendingDupMac),
        edge(1, WaitingDupMac, MacIdSet, SendingDupMac),
        edge(1, OnLine, MacIdSet, SendingDupMac),
        edge(2, SendingDupMac, RequestSent, WaitingDupMac),
        edge(2, SendingDupMac, QuickConnect, OnLine),
        edge(2, OnLine, RequestSent, OnLine),
        edge(3, SendingDupMac, NotAcknowledged, SendingDupMac),
        edge(4, WaitingDupMac, WaitOver, SendingDupMac),
        edge(4, OnLine, WaitOver, OnLine),
        edge(5, WaitingDupMac, WaitOver, OnLine),
        edge(6, SendingDupMac, DuplicateRequest, CommFault),
        edge(6, SendingDupMac, DuplicateResponse, CommFault),
        edge(6, WaitingDupMac, DuplicateRequest, CommFault),
        edge(6, WaitingDupMac, DuplicateResponse, CommFault),
        edge(7, SendingDupMac, BusOff, CommFault),
        edge(7, WaitingDupMac, BusOff, CommFault),
        edge(7, SendingDupMac, BusOffRestart, SendingDupMac),
        edge(7, WaitingDupMac, BusOffRestart, SendingDupMac),
        edge(8, SendingDupMac, OtherMessage, SendingDupMac),
        edge(8, WaitingDupMac, OtherMessage, WaitingDupMac),
        edge(9, OnLine, DuplicateRequest, OnLine),
        edge(10, OnLine, DuplicateResponse, CommFault),
        edge(11, OnLine, BusOff, CommFault),
        edge(11, CommFault, BusOff, CommFault),
        edge(12, OnLine, BusOffRestart, SendingDupMac),
        edge(13, CommFault, MacIdAssigned, SendingDupMac),
        edge(14, CommFault, Reset, SendingDupMac),
        edge(14, CommFault, MacIdSet, SendingDupMac),
        edge(15, SendingDupMac, LinkDown, NonExistent),
        edge(15, WaitingDupMac, LinkDown, NonExistent),
        edge(15, OnLine, LinkDown, NonExistent),
        edge(15, CommFault, LinkDown, NonExistent),
    ]
};

const fn edge(number: u8, from: StateKind, cause: Cause, to: StateKind) -> Edge {
    Edge { number, from, cause, to }
}
