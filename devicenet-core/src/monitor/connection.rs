//! What is known of a connection, and its watchdog.

use core::time::Duration;

use cip_core::code::InstanceId;
use cip_core::monitor::Seen;
use link_core::Instant;

use super::connections::{ConnectionState, Predefined};

/// Which way a message of a connection goes, seen from the server (slave).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Flow {
    /// From the client to the server.
    Consumed,
    /// From the server to the client.
    Produced,
}

impl Flow {
    pub(super) const fn opposite(self) -> Self {
        match self {
            Self::Consumed => Self::Produced,
            Self::Produced => Self::Consumed,
        }
    }
}

/// Whether an I/O direction whose size is unknown is taken to be fragmented.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Guess {
    /// No reason to think so.
    Plain,
    /// The last frame could be a first fragment: first byte 0 and eight bytes.
    Candidate,
    /// A first fragment was followed by its continuation.
    Fragmented,
}

/// One direction of an I/O connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Side {
    pub(super) size: Option<u16>,
    pub(super) guess: Guess,
    /// The instance that the connection path names, as a rule an assembly.
    pub(super) path: Option<InstanceId>,
    /// A frame of this direction was seen.
    pub(super) heard: bool,
    /// Where a message begins is known: a fragment that does not belong to one is wrong.
    pub(super) known: bool,
}

/// The record of a connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Connection {
    pub(super) state: ConnectionState,
    /// The state is inferred, or rests on a clock that a missing frame would have stopped.
    pub(super) assumed: bool,
    pub(super) states_seen: u8,
    pub(super) epr: Option<u16>,
    pub(super) watchdog_action: Option<u8>,
    /// Attribute 18: the watchdog is EPR x 4 x 2^n.
    pub(super) multiplier: u8,
    pub(super) inhibit: Option<u16>,
    pub(super) consumed: Side,
    pub(super) produced: Side,
    /// What last restarted the watchdog.
    pub(super) active: Instant,
    /// Nothing was consumed since the connection was established: the watchdog has at least ten seconds.
    pub(super) fresh: bool,
    /// The command or message that waits for its response or acknowledge.
    pub(super) waiting: Option<Seen>,
    /// That command has a length which the slave may ignore.
    pub(super) excused: bool,
    /// At least one command was answered.
    pub(super) answers: bool,
    pub(super) frames: u64,
    pub(super) bytes: u64,
}

impl Side {
    pub(super) const NEW: Self =
        Self { size: None, guess: Guess::Plain, path: None, heard: false, known: false };
}

impl Connection {
    pub(super) const NEW: Self = Self {
        state: ConnectionState::Unknown,
        assumed: true,
        states_seen: 0,
        epr: None,
        watchdog_action: None,
        multiplier: 0,
        inhibit: None,
        consumed: Side::NEW,
        produced: Side::NEW,
        active: Instant::ZERO,
        fresh: false,
        waiting: None,
        excused: false,
        answers: false,
        frames: 0,
        bytes: 0,
    };

    pub(super) fn side(&mut self, flow: Flow) -> &mut Side {
        match flow {
            Flow::Consumed => &mut self.consumed,
            Flow::Produced => &mut self.produced,
        }
    }

    /// Enters a state that a message has told.
    pub(super) fn enter(&mut self, state: ConnectionState, at: Instant) {
        if state == ConnectionState::Established && self.state != ConnectionState::Established {
            self.fresh = true;
            if !self.assumed {
                // What was sent before was ignored.
                self.waiting = None;
            }
        }
        self.set(state, false);
        self.active = at;
    }

    /// Enters a state that is only inferred.
    pub(super) fn infer(&mut self, state: ConnectionState, at: Instant) {
        self.set(state, true);
        self.active = at;
    }

    /// A successful allocation: the defaults of the predefined set. Sizes and paths of the device stay.
    pub(super) fn allocate(&mut self, connection: Predefined, at: Instant) {
        self.waiting = None;
        self.answers = false;
        self.multiplier = 0;
        if connection == Predefined::Explicit {
            self.epr = Some(EXPLICIT_EPR);
            self.watchdog_action = Some(ACTION_AUTO_DELETE);
            self.enter(ConnectionState::Established, at);
            self.fresh = false;
        } else {
            self.epr = Some(0);
            self.watchdog_action = Some(ACTION_TIMED_OUT);
            self.enter(ConnectionState::Configuring, at);
        }
    }

    /// All attributes were set at once. No layout is known of that: what they are is to be learned again.
    pub(super) fn forget(&mut self) {
        self.epr = None;
        self.watchdog_action = None;
        self.multiplier = 0;
        self.inhibit = None;
        for side in [&mut self.consumed, &mut self.produced] {
            side.size = None;
            side.path = None;
        }
    }

    /// Its watchdog was started anew, with its whole time but not with the ten seconds of a new connection: Reset.
    pub(super) fn restart(&mut self, at: Instant) {
        self.enter(ConnectionState::Established, at);
        self.fresh = false;
    }

    /// Every connection was reset: it has restarted if it is one that can.
    pub(super) fn reset(&mut self, at: Instant) {
        if matches!(self.state, ConnectionState::Established | ConnectionState::TimedOut) {
            self.restart(at);
        }
    }

    /// The connection is gone.
    pub(super) fn end(&mut self, at: Instant) {
        self.waiting = None;
        self.enter(ConnectionState::NonExistent, at);
    }

    /// The connection must be gone, though no message has told. A slave that takes part in it shows that it is not.
    pub(super) fn lapse(&mut self) {
        self.waiting = None;
        self.set(ConnectionState::NonExistent, true);
    }

    /// A message that restarts the watchdog was seen.
    pub(super) fn touch(&mut self, at: Instant) {
        self.active = at;
        self.fresh = false;
    }

    /// How long its peers wait for each other once it is in use; `None` without a watchdog.
    pub(super) fn time_out(&self) -> Option<Duration> {
        let epr = self.epr.filter(|&epr| epr != 0)?;
        let factor = 4_u32.checked_shl(u32::from(self.multiplier.min(7))).unwrap_or(4);
        Some(Duration::from_millis(u64::from(epr)).saturating_mul(factor))
    }

    /// The time of the watchdog as it runs now; `None` without a watchdog.
    pub(super) fn watchdog(&self) -> Option<Duration> {
        let time = self.time_out()?;
        Some(if self.fresh { time.max(PRE_CONSUMPTION) } else { time })
    }

    /// Lets the watchdog expire if it must have by `now`. `io_alive` says whether I/O of the same set is established.
    pub(super) fn settle(&mut self, now: Instant, explicit: bool, io_alive: bool) {
        if self.state == ConnectionState::DeferredDelete && !io_alive {
            self.set(ConnectionState::NonExistent, true);
        }
        if self.state != ConnectionState::Established {
            return;
        }
        let Some(time) = self.watchdog() else { return };
        if now.saturating_since(self.active) <= time {
            return;
        }
        let state = match (self.watchdog_action, explicit) {
            (Some(ACTION_AUTO_DELETE), _) => ConnectionState::NonExistent,
            (Some(ACTION_AUTO_RESET), _) => return,
            (Some(ACTION_DEFERRED_DELETE), true) if io_alive => ConnectionState::DeferredDelete,
            (_, true) => ConnectionState::NonExistent,
            (_, false) => ConnectionState::TimedOut,
        };
        self.waiting = None;
        self.set(state, true);
    }

    /// True if a command would be answered, as far as the recording tells.
    pub(super) fn is_alive(&self) -> bool {
        self.state == ConnectionState::Established || (self.state == ConnectionState::Unknown && self.answers)
    }

    fn set(&mut self, state: ConnectionState, assumed: bool) {
        self.state = state;
        self.assumed = assumed;
        self.states_seen |= state.bit();
    }
}

/// The expected packet rate of a new explicit connection, in milliseconds.
pub(super) const EXPLICIT_EPR: u16 = 2500;
/// A consumer waits at least this long for its first message.
const PRE_CONSUMPTION: Duration = Duration::from_secs(10);
const ACTION_TIMED_OUT: u8 = 0;
pub(super) const ACTION_AUTO_DELETE: u8 = 1;
const ACTION_AUTO_RESET: u8 = 2;
const ACTION_DEFERRED_DELETE: u8 = 3;
