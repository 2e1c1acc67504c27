//! The state machine of an explicit connection, on the server's side.
//!
//! ```text
//!                  Allocate, Open                  time-out with action 3,
//! +-------------+                +-------------+   I/O established    +----------------+
//! | NonExistent |--------------->| Established |--------------------->| DeferredDelete |
//! +-------------+                +-------------+<---------------------+----------------+
//!        ^                            |               message               |
//!        |   time-out, Release,       |                                     |
//!        |   Delete, Close            |          last I/O connection gone,  |
//!        +----------------------------+----------Release, Delete------------+
//! ```
//! From every state, the loss of the network leads to NonExistent.

use core::fmt;

use super::timing::Watchdog;
use super::{ConnectionState, EXPLICIT_PACKET_RATE, Settings, TimerResolution, WatchdogAction};
use crate::code::GeneralStatus;

/// The states of an explicit connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ExplicitState {
    /// Neither allocated nor opened.
    NonExistent,
    /// Messages flow.
    Established,
    /// It timed out, and waits for the end of the I/O connections of the set.
    DeferredDelete,
}

/// What happens to an explicit connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ExplicitCause {
    /// Allocate, or Open of the UCMM.
    Opened,
    /// A valid message: a request, a fragment, an acknowledge.
    Message,
    /// Set_Attribute_Single of the expected packet rate.
    PacketRateSet,
    /// Reset.
    Reset,
    /// No message came in time.
    WatchdogExpired {
        /// An I/O connection of the predefined set is established.
        io_established: bool,
    },
    /// The last I/O connection of the set has ceased to be established.
    IoEnded,
    /// Release, Delete or Close.
    Released,
    /// The node is no longer on line.
    NetworkLost,
}

/// A transition.
pub type ExplicitEdge = link_core::Edge<ExplicitState, ExplicitCause>;

/// An instance of the Connection object for explicit messages, on the server's side.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ExplicitConnection {
    state: ExplicitState,
    settings: Settings,
}

impl ExplicitConnection {
    /// Neither allocated nor opened.
    pub const NON_EXISTENT: Self = Self { state: ExplicitState::NonExistent, settings: DEFAULTS };
    /// What attribute 12 can be.
    pub const ACTIONS: [WatchdogAction; 2] = [WatchdogAction::AUTO_DELETE, WatchdogAction::DEFERRED_DELETE];

    /// The state.
    pub const fn state(&self) -> ExplicitState {
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

    /// Sets attribute 9: rounds it, stores it, and lets the watchdog run anew. Returns what is used from now on; 0x09 if
    /// it does not fit.
    pub fn set_packet_rate(
        &mut self,
        requested: u16,
        resolution: TimerResolution,
    ) -> Result<(u16, Watchdog), GeneralStatus> {
        if self.state == ExplicitState::NonExistent {
            return Err(GeneralStatus::OBJECT_DOES_NOT_EXIST);
        }
        let used = self.settings.set_packet_rate(requested, resolution)?;
        Ok((used, self.handle(ExplicitCause::PacketRateSet)?))
    }

    /// Sets attribute 12: 1 or 3; 0x09 for anything else.
    pub fn set_watchdog_action(&mut self, action: WatchdogAction) -> Result<(), GeneralStatus> {
        self.settings.set_watchdog_action(action, &Self::ACTIONS)
    }

    /// What [`handle`](Self::handle) does with a message, which is all that most connections ever meet.
    #[inline]
    pub fn message(&mut self) -> Watchdog {
        match self.state {
            ExplicitState::Established | ExplicitState::DeferredDelete => {
                self.enter(ExplicitState::Established, ExplicitCause::Message);
                Watchdog::Start
            }
            ExplicitState::NonExistent => Watchdog::Keep,
        }
    }

    /// The state machine. An error is the general status of the response to the service that was the cause; messages and
    /// time-outs that a state does not know change nothing.
    // As a call it returns two registers; in line they are put together and taken apart.
    #[inline(never)]
    pub fn handle(&mut self, cause: ExplicitCause) -> Result<Watchdog, GeneralStatus> {
        use ExplicitCause as Cause;
        use ExplicitState as State;
        let (next, then) = match (self.state, cause) {
            (State::NonExistent, Cause::Opened) => {
                self.settings = DEFAULTS;
                (State::Established, Watchdog::Start)
            }
            (State::Established | State::DeferredDelete, Cause::Opened) => {
                return Err(GeneralStatus::ALREADY_IN_REQUESTED_STATE);
            }
            (State::Established, Cause::Message | Cause::PacketRateSet | Cause::Reset)
            | (State::DeferredDelete, Cause::Message) => (State::Established, Watchdog::Start),
            (State::Established, Cause::WatchdogExpired { io_established: true })
                if self.settings.watchdog_action == WatchdogAction::DEFERRED_DELETE =>
            {
                (State::DeferredDelete, Watchdog::Stop)
            }
            (State::Established, Cause::WatchdogExpired { .. } | Cause::Released | Cause::NetworkLost)
            | (State::DeferredDelete, Cause::IoEnded | Cause::Released | Cause::NetworkLost) => {
                (State::NonExistent, Watchdog::Stop)
            }
            (State::NonExistent, Cause::PacketRateSet | Cause::Reset | Cause::Released) => {
                return Err(GeneralStatus::OBJECT_DOES_NOT_EXIST);
            }
            // Served through another connection: what arrives on this one has established it again by then.
            (State::DeferredDelete, Cause::PacketRateSet) => (self.state, Watchdog::Keep),
            (State::DeferredDelete, Cause::Reset) => return Err(GeneralStatus::OBJECT_STATE_CONFLICT),
            (
                State::NonExistent,
                Cause::Message | Cause::WatchdogExpired { .. } | Cause::IoEnded | Cause::NetworkLost,
            )
            | (State::Established, Cause::IoEnded)
            | (State::DeferredDelete, Cause::WatchdogExpired { .. }) => return Ok(Watchdog::Keep),
        };
        self.enter(next, cause);
        Ok(then)
    }

    /// The one door between states.
    fn enter(&mut self, next: ExplicitState, cause: ExplicitCause) {
        let edge = ExplicitEdge { from: self.state, cause, to: next };
        debug_assert!(EXPLICIT_EDGES.contains(&edge), "no transition {edge}");
        #[cfg(test)]
        super::tests::record_explicit(edge);
        self.state = next;
    }
}

impl From<ExplicitState> for ConnectionState {
    fn from(state: ExplicitState) -> Self {
        match state {
            ExplicitState::NonExistent => Self::NON_EXISTENT,
            ExplicitState::Established => Self::ESTABLISHED,
            ExplicitState::DeferredDelete => Self::DEFERRED_DELETE,
        }
    }
}

impl ExplicitState {
    /// The name in CIP Vol. 1.
    pub const fn name(self) -> &'static str {
        match self {
            Self::NonExistent => "Non-existent",
            Self::Established => "Established",
            Self::DeferredDelete => "Deferred delete",
        }
    }
}

impl ExplicitCause {
    /// In words.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Opened => "Allocate or Open",
            Self::Message => "message",
            Self::PacketRateSet => "EPR set",
            Self::Reset => "Reset",
            Self::WatchdogExpired { io_established: true } => "time-out, I/O established",
            Self::WatchdogExpired { io_established: false } => "time-out, no I/O established",
            Self::IoEnded => "last I/O connection gone",
            Self::Released => "Release, Delete or Close",
            Self::NetworkLost => "network lost",
        }
    }
}

impl fmt::Display for ExplicitState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl fmt::Display for ExplicitCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Every transition of an explicit connection, those that leave the state as it is included.
///
/// | From | Cause | To | What happens |
/// |---|---|---|---|
/// | Non-existent | Allocate or Open | Established | EPR 2500, action 1, time-out 10 s |
/// | Established | message | Established | time-out anew |
/// | Established | EPR set | Established | time-out anew |
/// | Established | Reset | Established | time-out anew |
/// | Established | time-out, I/O established | Non-existent | action 1 |
/// | Established | time-out, I/O established | Deferred delete | action 3 |
/// | Established | time-out, no I/O established | Non-existent | either action |
/// | Established | Release, Delete or Close | Non-existent | the response goes out |
/// | Deferred delete | message | Established | processed, time-out anew |
/// | Deferred delete | EPR set | Deferred delete | through another connection |
/// | Deferred delete | last I/O connection gone | Non-existent | |
/// | Deferred delete | Release, Delete or Close | Non-existent | |
/// | Established | network lost | Non-existent | |
/// | Deferred delete | network lost | Non-existent | |
///
/// Source: CIP Vol. 1 and 3, Connection object, explicit messaging state machine.
pub const EXPLICIT_EDGES: &[ExplicitEdge] = {
    use ExplicitCause::*;
    use ExplicitState::*;
    &[
        edge(NonExistent, Opened, Established),
        edge(Established, Message, Established),
        edge(Established, PacketRateSet, Established),
        edge(Established, Reset, Established),
        edge(Established, WatchdogExpired { io_established: true }, NonExistent),
        edge(Established, WatchdogExpired { io_established: true }, DeferredDelete),
        edge(Established, WatchdogExpired { io_established: false }, NonExistent),
        edge(Established, Released, NonExistent),
        edge(DeferredDelete, Message, Established),
        edge(DeferredDelete, PacketRateSet, DeferredDelete),
        edge(DeferredDelete, IoEnded, NonExistent),
        edge(DeferredDelete, Released, NonExistent),
        edge(Established, NetworkLost, NonExistent),
        edge(DeferredDelete, NetworkLost, NonExistent),
    ]
};

const fn edge(from: ExplicitState, cause: ExplicitCause, to: ExplicitState) -> ExplicitEdge {
    ExplicitEdge { from, cause, to }
}

const DEFAULTS: Settings = Settings::new(EXPLICIT_PACKET_RATE, WatchdogAction::AUTO_DELETE);
