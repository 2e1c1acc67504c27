//! The state machine of an I/O connection, on the server's side.
//!
//! ```text
//!                  Allocate                EPR set, Apply
//! +-------------+           +-------------+            +-------------+  message, EPR set,
//! | NonExistent |---------->| Configuring |----------->| Established |  Reset, time-out with
//! +-------------+           +-------------+            +-------------+  action 2: stays
//!        ^                    |         ^                 |      |  ^
//!        |  Release, explicit |         | Allocate        |      |  | Reset
//!        |  connection gone   |         |                 |      v  |
//!        +--------------------+         |    time-out,    |   +----------+
//!        |                              +--- action 0 --------| TimedOut |
//!        +-- Release, time-out with action 1 -------------+   +----------+
//!        +-- Release -----------------------------------------------+
//! ```
//! From every state, the loss of the network leads to NonExistent.

use core::fmt;

use super::timing::Watchdog;
use super::{
    ConnectionState, PredefinedConnection, Settings, TimerResolution, TransportClassTrigger, WatchdogAction,
};
use crate::code::GeneralStatus;

/// The states of an I/O connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum IoState {
    /// Not allocated.
    NonExistent,
    /// Allocated; its expected packet rate is still to be set.
    Configuring,
    /// Data flow.
    Established,
    /// No message came in time.
    TimedOut,
}

/// What happens to an I/O connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum IoCause {
    /// Allocate.
    Allocated,
    /// Get_Attribute_Single, or Set_Attribute_Single of another attribute than the expected packet rate.
    Served,
    /// Set_Attribute_Single of the expected packet rate.
    PacketRateSet,
    /// Apply_Attributes.
    Applied,
    /// Reset.
    Reset,
    /// A valid I/O message.
    Message,
    /// No message came in time.
    WatchdogExpired,
    /// Release or Delete.
    Released,
    /// The explicit connection through which it was to be configured is gone.
    ExplicitGone,
    /// The node is no longer on line.
    NetworkLost,
}

/// A transition.
pub type IoEdge = link_core::Edge<IoState, IoCause>;

/// An instance of the Connection object for I/O, on the server's side. `K` is what its network calls a kind of connection:
/// it decides whether anything arrives whose absence could be noticed.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct IoConnection<K = PredefinedConnection> {
    kind: K,
    state: IoState,
    /// It follows from the kind, and is asked for with every message.
    consumes: bool,
    settings: Settings,
}

impl IoConnection {
    /// Not allocated.
    pub const NON_EXISTENT: Self = Self::non_existent(PredefinedConnection::Poll);
}

impl<K: Copy + Into<TransportClassTrigger>> IoConnection<K> {
    /// What attribute 12 can be.
    pub const ACTIONS: [WatchdogAction; 3] =
        [WatchdogAction::TRANSITION_TO_TIMED_OUT, WatchdogAction::AUTO_DELETE, WatchdogAction::AUTO_RESET];

    /// Not allocated; the kind has no meaning yet.
    pub const fn non_existent(kind: K) -> Self {
        Self { kind, state: IoState::NonExistent, consumes: true, settings: DEFAULTS }
    }

    /// Which kind of connection it is; without a meaning while it is non-existent.
    pub const fn kind(&self) -> K {
        self.kind
    }

    /// The state.
    pub const fn state(&self) -> IoState {
        self.state
    }

    /// What the client has set.
    pub const fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The same, to set what has no further consequence.
    pub const fn settings_mut(&mut self) -> &mut Settings {
        &mut self.settings
    }

    /// Allocates it with its defaults; 0x0B if it is allocated already. A connection that timed out counts as free.
    pub fn allocate(&mut self, kind: K) -> Result<(), GeneralStatus> {
        let _ = self.handle(IoCause::Allocated)?;
        self.promote(kind);
        self.settings = DEFAULTS;
        Ok(())
    }

    /// Another connection takes over the instance that is allocated already: poll is added where instance 2 was there for
    /// the direction to the slave only.
    pub fn promote(&mut self, kind: K) {
        self.kind = kind;
        // On a client without acknowledges nothing arrives whose absence could be noticed.
        let trigger: TransportClassTrigger = kind.into();
        self.consumes = trigger.is_server() || trigger.class() != 0;
    }

    /// Sets attribute 9: rounds it, stores it, and establishes the connection if it was being configured. Returns what is
    /// used from now on; 0x09 if it does not fit, or is less than the production inhibit time.
    pub fn set_packet_rate(
        &mut self,
        requested: u16,
        resolution: TimerResolution,
    ) -> Result<(u16, Watchdog), GeneralStatus> {
        if self.state == IoState::NonExistent {
            return Err(GeneralStatus::OBJECT_DOES_NOT_EXIST);
        }
        let used = self.settings.set_packet_rate(requested, resolution)?;
        Ok((used, self.handle(IoCause::PacketRateSet)?))
    }

    /// Sets attribute 12: 0, 1 or 2; 0x09 for anything else.
    pub fn set_watchdog_action(&mut self, action: WatchdogAction) -> Result<(), GeneralStatus> {
        self.settings.set_watchdog_action(action, &Self::ACTIONS)
    }

    /// What [`handle`](Self::handle) does with a message, which is all that most connections ever meet.
    #[inline]
    pub fn message(&mut self) -> Watchdog {
        match self.state {
            IoState::Established => {
                self.enter(IoState::Established, IoCause::Message);
                self.watchdog(Watchdog::Start)
            }
            IoState::Configuring | IoState::TimedOut => {
                self.enter(self.state, IoCause::Message);
                Watchdog::Keep
            }
            IoState::NonExistent => Watchdog::Keep,
        }
    }

    /// The state machine. An error is the general status of the response to the service that was the cause; messages and
    /// time-outs that a state does not know change nothing.
    pub fn handle(&mut self, cause: IoCause) -> Result<Watchdog, GeneralStatus> {
        let (next, then) = match (self.state, cause) {
            (IoState::NonExistent | IoState::TimedOut, IoCause::Allocated) => {
                (IoState::Configuring, Watchdog::Stop)
            }
            (IoState::Configuring | IoState::Established, IoCause::Allocated) => {
                return Err(GeneralStatus::ALREADY_IN_REQUESTED_STATE);
            }
            (
                IoState::NonExistent,
                IoCause::Served
                | IoCause::PacketRateSet
                | IoCause::Applied
                | IoCause::Reset
                | IoCause::Released,
            ) => {
                self.enter(self.state, cause);
                return Err(GeneralStatus::OBJECT_DOES_NOT_EXIST);
            }
            (IoState::Configuring, IoCause::PacketRateSet | IoCause::Applied) => {
                (IoState::Established, Watchdog::StartFirst)
            }
            (IoState::Configuring, IoCause::Reset)
            | (IoState::Established | IoState::TimedOut, IoCause::Applied) => {
                self.enter(self.state, cause);
                return Err(GeneralStatus::OBJECT_STATE_CONFLICT);
            }
            (_, IoCause::Message) => return Ok(self.message()),
            (IoState::Established, IoCause::PacketRateSet | IoCause::Reset)
            | (IoState::TimedOut, IoCause::Reset) => (IoState::Established, Watchdog::Start),
            (IoState::Established, IoCause::WatchdogExpired) => match self.settings.watchdog_action {
                WatchdogAction::AUTO_DELETE => (IoState::NonExistent, Watchdog::Stop),
                WatchdogAction::AUTO_RESET => (IoState::Established, Watchdog::Start),
                _ => (IoState::TimedOut, Watchdog::Stop),
            },
            (
                IoState::Configuring | IoState::Established | IoState::TimedOut,
                IoCause::Released | IoCause::NetworkLost,
            )
            | (IoState::Configuring, IoCause::ExplicitGone) => (IoState::NonExistent, Watchdog::Stop),
            (IoState::Configuring | IoState::Established | IoState::TimedOut, IoCause::Served)
            | (IoState::TimedOut, IoCause::PacketRateSet) => (self.state, Watchdog::Keep),
            (
                IoState::NonExistent,
                IoCause::WatchdogExpired | IoCause::ExplicitGone | IoCause::NetworkLost,
            )
            | (IoState::Configuring | IoState::TimedOut, IoCause::WatchdogExpired)
            | (IoState::Established | IoState::TimedOut, IoCause::ExplicitGone) => return Ok(Watchdog::Keep),
        };
        self.enter(next, cause);
        Ok(self.watchdog(then))
    }

    /// The one door between states.
    fn enter(&mut self, next: IoState, cause: IoCause) {
        let edge = IoEdge { from: self.state, cause, to: next };
        debug_assert!(IO_EDGES.contains(&edge), "no transition {edge}");
        #[cfg(test)]
        super::tests::record_io(edge);
        self.state = next;
    }

    /// Where nothing arrives, nothing is waited for.
    #[inline]
    const fn watchdog(&self, then: Watchdog) -> Watchdog {
        match then {
            Watchdog::Start | Watchdog::StartFirst if !self.consumes => Watchdog::Stop,
            _ => then,
        }
    }
}

impl From<IoState> for ConnectionState {
    fn from(state: IoState) -> Self {
        match state {
            IoState::NonExistent => Self::NON_EXISTENT,
            IoState::Configuring => Self::CONFIGURING,
            IoState::Established => Self::ESTABLISHED,
            IoState::TimedOut => Self::TIMED_OUT,
        }
    }
}

impl IoState {
    /// The name in CIP Vol. 1.
    pub const fn name(self) -> &'static str {
        match self {
            Self::NonExistent => "Non-existent",
            Self::Configuring => "Configuring",
            Self::Established => "Established",
            Self::TimedOut => "Timed out",
        }
    }
}

impl IoCause {
    /// In words.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Allocated => "Allocate",
            Self::Served => "Get or Set",
            Self::PacketRateSet => "EPR set",
            Self::Applied => "Apply_Attributes",
            Self::Reset => "Reset",
            Self::Message => "message",
            Self::WatchdogExpired => "time-out",
            Self::Released => "Release or Delete",
            Self::ExplicitGone => "explicit connection gone",
            Self::NetworkLost => "network lost",
        }
    }
}

impl fmt::Display for IoState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl fmt::Display for IoCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Every transition of an I/O connection, those that leave the state as it is included.
///
/// | From | Cause | To | What happens |
/// |---|---|---|---|
/// | Non-existent | Allocate | Configuring | defaults |
/// | Non-existent | Get or Set | Non-existent | error 0x16, as for every other service |
/// | Non-existent | EPR set | Non-existent | |
/// | Non-existent | Apply_Attributes | Non-existent | |
/// | Non-existent | Reset | Non-existent | |
/// | Non-existent | Release or Delete | Non-existent | |
/// | Configuring | Get or Set | Configuring | |
/// | Configuring | EPR set | Established | the first time-out: T, at least 10 s |
/// | Configuring | Apply_Attributes | Established | the same |
/// | Configuring | Reset | Configuring | error 0x0C |
/// | Configuring | message | Configuring | ignored |
/// | Configuring | Release or Delete | Non-existent | |
/// | Configuring | explicit connection gone | Non-existent | |
/// | Established | message | Established | time-out T anew, consumed, answered |
/// | Established | Get or Set | Established | |
/// | Established | EPR set | Established | time-out T anew |
/// | Established | Reset | Established | time-out T anew |
/// | Established | Apply_Attributes | Established | error 0x0C |
/// | Established | time-out | Timed out | action 0 |
/// | Established | time-out | Non-existent | action 1 |
/// | Established | time-out | Established | action 2: time-out T anew |
/// | Established | Release or Delete | Non-existent | |
/// | Timed out | message | Timed out | ignored |
/// | Timed out | Get or Set | Timed out | |
/// | Timed out | EPR set | Timed out | stored |
/// | Timed out | Apply_Attributes | Timed out | error 0x0C |
/// | Timed out | Reset | Established | time-out T anew |
/// | Timed out | Allocate | Configuring | defaults |
/// | Timed out | Release or Delete | Non-existent | |
/// | Configuring | network lost | Non-existent | |
/// | Established | network lost | Non-existent | |
/// | Timed out | network lost | Non-existent | |
///
/// Source: CIP Vol. 1 and 3, Connection object, I/O state machine.
pub const IO_EDGES: &[IoEdge] = {
    use IoCause::*;
    use IoState::*;
    &[
        edge(NonExistent, Allocated, Configuring),
        edge(NonExistent, Served, NonExistent),
        edge(NonExistent, PacketRateSet, NonExistent),
        edge(NonExistent, Applied, NonExistent),
        edge(NonExistent, Reset, NonExistent),
        edge(NonExistent, Released, NonExistent),
        edge(Configuring, Served, Configuring),
        edge(Configuring, PacketRateSet, Established),
        edge(Configuring, Applied, Established),
        edge(Configuring, Reset, Configuring),
        edge(Configuring, Message, Configuring),
        edge(Configuring, Released, NonExistent),
        edge(Configuring, ExplicitGone, NonExistent),
        edge(Established, Message, Established),
        edge(Established, Served, Established),
        edge(Established, PacketRateSet, Established),
        edge(Established, Reset, Established),
        edge(Established, Applied, Established),
        edge(Established, WatchdogExpired, TimedOut),
        edge(Established, WatchdogExpired, NonExistent),
        edge(Established, WatchdogExpired, Established),
        edge(Established, Released, NonExistent),
        edge(TimedOut, Message, TimedOut),
        edge(TimedOut, Served, TimedOut),
        edge(TimedOut, PacketRateSet, TimedOut),
        edge(TimedOut, Applied, TimedOut),
        edge(TimedOut, Reset, Established),
        edge(TimedOut, Allocated, Configuring),
        edge(TimedOut, Released, NonExistent),
        edge(Configuring, NetworkLost, NonExistent),
        edge(Established, NetworkLost, NonExistent),
        edge(TimedOut, NetworkLost, NonExistent),
    ]
};

const fn edge(from: IoState, cause: IoCause, to: IoState) -> IoEdge {
    IoEdge { from, cause, to }
}

const DEFAULTS: Settings = Settings::new(0, WatchdogAction::TRANSITION_TO_TIMED_OUT);
