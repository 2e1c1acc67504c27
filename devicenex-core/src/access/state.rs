//! The states of network access, and the transitions between them.

use core::fmt;

use crate::bit_rate::Detector;

/// A state with its data.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum State {
    /// No power, or no network power: waiting for the link to come up.
    NonExistent,
    /// The bit rate of the bus is not known yet: the node listens, and sends nothing.
    DetectingBitRate {
        /// Which rate is being tried.
        detector: Detector,
        /// The controller has been told its mode.
        commanded: bool,
    },
    /// A Hello request is to be sent, or was, and others may object.
    Hello {
        /// Which of the two.
        number: HelloNumber,
        /// How far it is.
        stage: HelloStage,
        /// Another node wants the address, and gives way when it hears the request once more.
        answer_due: bool,
    },
    /// It has no address, and waits for one.
    Standby {
        /// A Mini-who is to be answered.
        hello_due: bool,
    },
    /// Normal operation.
    Online {
        /// The address is to be defended, or announced.
        response_due: bool,
    },
    /// The controller is off the bus.
    BusOff {
        /// Whether it is to come back.
        restart: Restart,
    },
    /// The controller does not do what it must.
    Faulted {
        /// What it does not do.
        fault: Fault,
    },
}

/// Which of the two Hello requests.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum HelloNumber {
    /// At first none has been sent.
    First,
    /// After the wait that follows the first.
    Second,
}

/// How far the sending of a Hello is.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum HelloStage {
    /// The controller is to leave listen-only mode, or to be given the rate.
    SettingMode {
        /// It has been told.
        commanded: bool,
    },
    /// To be handed to the controller, or with it.
    Queued {
        /// The controller has told that nobody acknowledges.
        unacknowledged: bool,
    },
    /// It was on the bus; others may object.
    Waiting,
    /// The controller gave it back; waiting before it is handed out again.
    GivenBack,
}

/// What happens after bus-off.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Restart {
    /// Nothing, until the application resets the node.
    Never,
    /// Waiting before the controller is restarted.
    BackOff,
    /// Waiting for the controller to take part in the bus again.
    Restarting {
        /// It has been told to restart.
        commanded: bool,
    },
}

/// What the controller does not do.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Fault {
    /// Its bit rate, or listen-only mode, cannot be set.
    Mode,
    /// It does not restart after bus-off.
    Restart,
}

/// A state without its data.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum StateKind {
    /// No power, or no network power.
    NonExistent,
    /// The bit rate of the bus is not known yet.
    DetectingBitRate,
    /// The first Hello is to be sent, or was.
    Hello1,
    /// The second Hello is to be sent, or was.
    Hello2,
    /// Without an address, waiting for one.
    Standby,
    /// Normal operation.
    Online,
    /// The controller is off the bus.
    BusOff,
    /// The controller does not do what it must.
    Faulted,
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
    /// The application sets the address.
    AddressSet,
    /// Enough valid frames were received at one bit rate.
    BitRateLocked,
    /// The time in which others may object is over.
    WaitOver,
    /// It is time to tell the address.
    AnnouncementDue,
    /// Another device wants the address of this one.
    HelloRequest,
    /// Another device has the address of this one.
    HelloResponse,
    /// Somebody looks for devices without an address.
    MiniWho,
    /// A network manager gives this device an address.
    Roam,
    /// The controller went off the bus.
    BusOff,
    /// The controller came back after bus-off.
    Restarted,
    /// The controller refuses what it must do.
    Refused,
}

/// A transition; its number is that of the row in [`EDGES`].
pub type Edge = link_core::NumberedEdge<StateKind, Cause>;

impl State {
    /// The state without its data.
    #[must_use]
    pub const fn kind(&self) -> StateKind {
        match self {
            Self::NonExistent => StateKind::NonExistent,
            Self::DetectingBitRate { .. } => StateKind::DetectingBitRate,
            Self::Hello { number: HelloNumber::First, .. } => StateKind::Hello1,
            Self::Hello { number: HelloNumber::Second, .. } => StateKind::Hello2,
            Self::Standby { .. } => StateKind::Standby,
            Self::Online { .. } => StateKind::Online,
            Self::BusOff { .. } => StateKind::BusOff,
            Self::Faulted { .. } => StateKind::Faulted,
        }
    }

    pub(super) const fn hello(number: HelloNumber, answer_due: bool) -> Self {
        Self::Hello { number, stage: HelloStage::Queued { unacknowledged: false }, answer_due }
    }
}

impl StateKind {
    /// The name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::NonExistent => "NonExistent",
            Self::DetectingBitRate => "DetectingBitRate",
            Self::Hello1 => "Hello1",
            Self::Hello2 => "Hello2",
            Self::Standby => "Standby",
            Self::Online => "Online",
            Self::BusOff => "BusOff",
            Self::Faulted => "Faulted",
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
            Self::AddressSet => "address set",
            Self::BitRateLocked => "bit rate locked",
            Self::WaitOver => "wait over",
            Self::AnnouncementDue => "announcement due",
            Self::HelloRequest => "Hello request",
            Self::HelloResponse => "Hello response",
            Self::MiniWho => "Mini-who",
            Self::Roam => "ROAM",
            Self::BusOff => "bus-off",
            Self::Restarted => "restarted",
            Self::Refused => "refused",
        }
    }
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Every transition. Debug builds check each step against it.
///
/// | Row | From | Cause | To |
/// |---|---|---|---|
/// | 1 | NonExistent | link up | DetectingBitRate |
/// | 1 | NonExistent | link up | Hello1 |
/// | 2 | DetectingBitRate | bit rate locked | Hello1 |
/// | 3 | Hello1 | wait over | Hello2 |
/// | 4 | Hello2 | wait over | Standby |
/// | 5 | Hello2 | wait over | Online |
/// | 6 | Hello1 | Hello response | Hello1 |
/// | 6 | Hello2 | Hello response | Hello1 |
/// | 7 | Hello1 | Hello request | Hello1 |
/// | 7 | Hello2 | Hello request | Hello1 |
/// | 7 | Hello2 | Hello request | Hello2 |
/// | 8 | Standby | Mini-who | Standby |
/// | 9 | Standby | ROAM | Hello1 |
/// | 9 | Hello1 | ROAM | Hello1 |
/// | 9 | Hello2 | ROAM | Hello1 |
/// | 10 | Online | Hello request | Online |
/// | 10 | Online | announcement due | Online |
/// | 11 | Online | Hello response | Hello1 |
/// | 12 | DetectingBitRate | bus-off | BusOff |
/// | 12 | Hello1 | bus-off | BusOff |
/// | 12 | Hello2 | bus-off | BusOff |
/// | 12 | Standby | bus-off | BusOff |
/// | 12 | Online | bus-off | BusOff |
/// | 12 | Faulted | bus-off | BusOff |
/// | 13 | BusOff | restarted | DetectingBitRate |
/// | 13 | BusOff | restarted | Hello1 |
/// | 14 | DetectingBitRate | refused | Faulted |
/// | 14 | Hello1 | refused | Faulted |
/// | 14 | BusOff | refused | Faulted |
/// | 15 | DetectingBitRate | reset | DetectingBitRate |
/// | 15 | Hello1 | reset | DetectingBitRate |
/// | 15 | Hello1 | reset | Hello1 |
/// | 15 | Hello2 | reset | DetectingBitRate |
/// | 15 | Hello2 | reset | Hello1 |
/// | 15 | Standby | reset | DetectingBitRate |
/// | 15 | Standby | reset | Hello1 |
/// | 15 | Online | reset | DetectingBitRate |
/// | 15 | Online | reset | Hello1 |
/// | 15 | Faulted | reset | DetectingBitRate |
/// | 15 | Faulted | reset | Hello1 |
/// | 15 | BusOff | reset | BusOff |
/// | 15 | Faulted | reset | BusOff |
/// | 16 | Hello1 | address set | Hello1 |
/// | 16 | Hello2 | address set | Hello1 |
/// | 16 | Standby | address set | Hello1 |
/// | 16 | Online | address set | Hello1 |
/// | 17 | DetectingBitRate | link down | NonExistent |
/// | 17 | Hello1 | link down | NonExistent |
/// | 17 | Hello2 | link down | NonExistent |
/// | 17 | Standby | link down | NonExistent |
/// | 17 | Online | link down | NonExistent |
/// | 17 | BusOff | link down | NonExistent |
/// | 17 | Faulted | link down | NonExistent |
///
/// Row 1, 13, 15: a network manager does not detect the bit rate, it sets it **\[P\]**. Rows 2 to 5, 6, 8, 9: paper 3.3,
/// 4.1 to 4.3 **\[P\]**; in `Hello1` and `Hello2` a ROAM is obeyed only with
/// [`Config::early_roam`](super::Config::early_roam). Row 7: of two nodes that join with one address, the one with the lower
/// identity keeps it and says Hello once more, the other gives way **\[D\]**. Row 10: the address is defended **\[P\]**, and
/// told from time to time **\[D\]**. Row 11: two segments were joined **\[D\]**. Row 12, 13: once, if BOI says so **\[D\]**.
pub const EDGES: &[Edge] = {
    use StateKind::*;
    &[
        edge(1, NonExistent, Cause::LinkUp, DetectingBitRate),
        edge(1, NonExistent, Cause::LinkUp, Hello1),
        edge(2, DetectingBitRate, Cause::BitRateLocked, Hello1),
        edge(3, Hello1, Cause::WaitOver, Hello2),
        edge(4, Hello2, Cause::WaitOver, Standby),
        edge(5, Hello2, Cause::WaitOver, Online),
        edge(6, Hello1, Cause::HelloResponse, Hello1),
        edge(6, Hello2, Cause::HelloResponse, Hello1),
        edge(7, Hello1, Cause::HelloRequest, Hello1),
        edge(7, Hello2, Cause::HelloRequest, Hello1),
        edge(7, Hello2, Cause::HelloRequest, Hello2),
        edge(8, Standby, Cause::MiniWho, Standby),
        edge(9, Standby, Cause::Roam, Hello1),
        edge(9, Hello1, Cause::Roam, Hello1),
        edge(9, Hello2, Cause::Roam, Hello1),
        edge(10, Online, Cause::HelloRequest, Online),
        edge(10, Online, Cause::AnnouncementDue, Online),
        edge(11, Online, Cause::HelloResponse, Hello1),
        edge(12, DetectingBitRate, Cause::BusOff, BusOff),
        edge(12, Hello1, Cause::BusOff, BusOff),
        edge(12, Hello2, Cause::BusOff, BusOff),
        edge(12, Standby, Cause::BusOff, BusOff),
        edge(12, Online, Cause::BusOff, BusOff),
        edge(12, Faulted, Cause::BusOff, BusOff),
        edge(13, BusOff, Cause::Restarted, DetectingBitRate),
        edge(13, BusOff, Cause::Restarted, Hello1),
        edge(14, DetectingBitRate, Cause::Refused, Faulted),
        edge(14, Hello1, Cause::Refused, Faulted),
        edge(14, BusOff, Cause::Refused, Faulted),
        edge(15, DetectingBitRate, Cause::Reset, DetectingBitRate),
        edge(15, Hello1, Cause::Reset, DetectingBitRate),
        edge(15, Hello1, Cause::Reset, Hello1),
        edge(15, Hello2, Cause::Reset, DetectingBitRate),
        edge(15, Hello2, Cause::Reset, Hello1),
        edge(15, Standby, Cause::Reset, DetectingBitRate),
        edge(15, Standby, Cause::Reset, Hello1),
        edge(15, Online, Cause::Reset, DetectingBitRate),
        edge(15, Online, Cause::Reset, Hello1),
        edge(15, Faulted, Cause::Reset, DetectingBitRate),
        edge(15, Faulted, Cause::Reset, Hello1),
        edge(15, BusOff, Cause::Reset, BusOff),
        edge(15, Faulted, Cause::Reset, BusOff),
        edge(16, Hello1, Cause::AddressSet, Hello1),
        edge(16, Hello2, Cause::AddressSet, Hello1),
        edge(16, Standby, Cause::AddressSet, Hello1),
        edge(16, Online, Cause::AddressSet, Hello1),
        edge(17, DetectingBitRate, Cause::LinkDown, NonExistent),
        edge(17, Hello1, Cause::LinkDown, NonExistent),
        edge(17, Hello2, Cause::LinkDown, NonExistent),
        edge(17, Standby, Cause::LinkDown, NonExistent),
        edge(17, Online, Cause::LinkDown, NonExistent),
        edge(17, BusOff, Cause::LinkDown, NonExistent),
        edge(17, Faulted, Cause::LinkDown, NonExistent),
    ]
};

const fn edge(number: u8, from: StateKind, cause: Cause, to: StateKind) -> Edge {
    Edge { number, from, cause, to }
}
