//! What is known of a connection, and its watchdog.

use core::time::Duration;

use link_core::Instant;

use super::{ConnectionState, Flaw, Remark, Remarks, Seen};
use crate::code::InstanceId;
use crate::connection::{TimeoutMultiplier, time_out};

/// Which way a message of a connection goes, seen from the server (slave).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Flow {
    /// From the client to the server.
    Consumed,
    /// From the server to the client.
    Produced,
}

impl Flow {
    /// The other way.
    #[must_use]
    pub const fn opposite(self) -> Self {
        match self {
            Self::Consumed => Self::Produced,
            Self::Produced => Self::Consumed,
        }
    }
}

/// Whether an I/O direction whose size is unknown is taken to be fragmented.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Guess {
    /// No reason to think so.
    Plain,
    /// The last frame could be a first fragment: first byte 0 and eight bytes.
    Candidate,
    /// The message under way was followed by a middle fragment, after its first one was taken for a message of its own.
    Begun,
    /// A first fragment was followed by its continuation.
    Fragmented,
}

/// One direction of an I/O connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Side {
    /// The connection size in bytes.
    pub size: Option<u16>,
    /// Whether it is taken to be fragmented, as long as the size is unknown.
    pub guess: Guess,
    /// The instance that the connection path names, as a rule an assembly.
    pub path: Option<InstanceId>,
    /// A frame of this direction was seen.
    pub heard: bool,
    /// Where a message begins is known: a fragment that does not belong to one is wrong.
    pub known: bool,
}

/// The record of a connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Connection {
    /// The state.
    pub state: ConnectionState,
    /// The state is inferred, or rests on a clock that a missing frame would have stopped.
    pub assumed: bool,
    /// The states it has been in, by [`ConnectionState::bit`].
    pub states_seen: u8,
    /// The expected packet rate that the server uses, in milliseconds.
    pub epr: Option<u16>,
    /// Attribute 12.
    pub watchdog_action: Option<u8>,
    /// Attribute 18.
    pub multiplier: u8,
    /// Attribute 17, in milliseconds.
    pub inhibit: Option<u16>,
    /// What the server consumes.
    pub consumed: Side,
    /// What the server produces.
    pub produced: Side,
    /// What last restarted the watchdog.
    pub active: Instant,
    /// Nothing was consumed since the connection was established: the watchdog has at least ten seconds.
    pub fresh: bool,
    /// The command or message that waits for its response or acknowledge.
    pub waiting: Option<Seen>,
    /// That command has a length which the slave may ignore.
    pub excused: bool,
    /// At least one command was answered.
    pub answers: bool,
    /// Frames in both directions.
    pub frames: u64,
    /// Data bytes in both directions.
    pub bytes: u64,
}

impl Side {
    /// A direction of which nothing is known.
    pub const NEW: Self = Self { size: None, guess: Guess::Plain, path: None, heard: false, known: false };
}

impl Connection {
    /// A connection of which nothing is known.
    pub const NEW: Self = Self {
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

    /// One of its directions.
    pub fn side(&mut self, flow: Flow) -> &mut Side {
        match flow {
            Flow::Consumed => &mut self.consumed,
            Flow::Produced => &mut self.produced,
        }
    }

    /// Enters a state that a message has told.
    pub fn enter(&mut self, state: ConnectionState, at: Instant) {
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
    pub fn infer(&mut self, state: ConnectionState, at: Instant) {
        self.set(state, true);
        self.active = at;
    }

    /// The server has made it for explicit messages: it is established at once.
    pub fn open(&mut self, at: Instant) {
        self.remake();
        self.epr = Some(EXPLICIT_EPR);
        self.watchdog_action = Some(ACTION_AUTO_DELETE);
        self.enter(ConnectionState::Established, at);
        self.fresh = false;
    }

    /// The server has made it for I/O, with the defaults of a predefined connection. Sizes and paths of the device stay.
    pub fn allocate(&mut self, at: Instant) {
        self.remake();
        self.epr = Some(0);
        self.watchdog_action = Some(ACTION_TIMED_OUT);
        self.enter(ConnectionState::Configuring, at);
    }

    /// All attributes were set at once. No layout is known of that: what they are is to be learned again.
    pub fn forget(&mut self) {
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
    pub fn restart(&mut self, at: Instant) {
        self.enter(ConnectionState::Established, at);
        self.fresh = false;
    }

    /// Every connection was reset: it has restarted if it is one that can.
    pub fn reset(&mut self, at: Instant) {
        if matches!(self.state, ConnectionState::Established | ConnectionState::TimedOut) {
            self.restart(at);
        }
    }

    /// The connection is gone.
    pub fn end(&mut self, at: Instant) {
        self.waiting = None;
        self.enter(ConnectionState::NonExistent, at);
    }

    /// The connection must be gone, though no message has told. A slave that takes part in it shows that it is not.
    pub fn lapse(&mut self) {
        self.waiting = None;
        self.set(ConnectionState::NonExistent, true);
    }

    /// A message that restarts the watchdog was seen.
    pub fn touch(&mut self, at: Instant) {
        self.active = at;
        self.fresh = false;
    }

    /// How long its peers wait for each other once it is in use; `None` without a watchdog.
    #[must_use]
    pub fn time_out(&self) -> Option<Duration> {
        time_out(self.epr?, TimeoutMultiplier(self.multiplier))
            .map(|millis| Duration::from_millis(millis.into()))
    }

    /// The time of the watchdog as it runs now; `None` without a watchdog.
    #[must_use]
    pub fn watchdog(&self) -> Option<Duration> {
        let time = self.time_out()?;
        Some(if self.fresh { time.max(PRE_CONSUMPTION) } else { time })
    }

    /// Lets the watchdog expire if it must have by `now`. `io_alive` says whether I/O of the same set is established.
    pub fn settle(&mut self, now: Instant, explicit: bool, io_alive: bool) {
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
    #[must_use]
    pub fn is_alive(&self) -> bool {
        self.state == ConnectionState::Established || (self.state == ConnectionState::Unknown && self.answers)
    }

    /// A frame of an explicit connection.
    pub fn explicit(&mut self, reading: &mut impl Remarks, flow: Flow, at: Instant) {
        match (self.state, flow) {
            // The server's watchdog is restarted by what it receives.
            (ConnectionState::Established, Flow::Consumed) => self.touch(at),
            // The server takes it while I/O goes on.
            (ConnectionState::DeferredDelete, Flow::Consumed) => self.enter(ConnectionState::Established, at),
            (ConnectionState::NonExistent | ConnectionState::TimedOut, Flow::Consumed) => {
                self.is_missing(reading);
            }
            (ConnectionState::Unknown, _) => self.active = at,
            _ => {}
        }
    }

    /// A frame wants the connection, which is not established.
    pub fn is_missing(&self, reading: &mut impl Remarks) {
        reading.remark(Remark::NoConnection(self.state));
        if self.assumed {
            reading.remark(Remark::Assumed);
        }
    }

    /// The server takes part in the connection: it is established, whatever was seen before.
    pub fn prove(&mut self, reading: &mut impl Remarks, at: Instant) {
        if self.state == ConnectionState::Established {
            return;
        }
        if !self.assumed {
            reading.remark(Remark::NoConnection(self.state));
            reading.remark(Remark::Assumed);
        }
        self.infer(ConnectionState::Established, at);
    }

    /// A frame answers the command or message that waits, which is returned. Without one it is wrong if the other side was
    /// `heard`.
    pub fn answer(&mut self, reading: &mut impl Remarks, heard: bool, at: Instant) -> Option<Seen> {
        let Some(waiting) = self.waiting.take() else {
            reading.remark(if heard { Remark::Flaw(Flaw::UnexpectedIoResponse) } else { Remark::Assumed });
            return None;
        };
        reading.remark(Remark::Answers(waiting.answered(at)));
        self.answers = true;
        Some(waiting)
    }

    /// Counts a frame of the connection.
    pub fn count(&mut self, bytes: usize) {
        self.frames = self.frames.saturating_add(1);
        self.bytes = self.bytes.saturating_add(u64::try_from(bytes).unwrap_or_default());
    }

    fn remake(&mut self) {
        self.waiting = None;
        self.answers = false;
        self.multiplier = 0;
    }

    fn set(&mut self, state: ConnectionState, assumed: bool) {
        self.state = state;
        self.assumed = assumed;
        self.states_seen |= state.bit();
    }
}

/// The expected packet rate of a new explicit connection, in milliseconds.
const EXPLICIT_EPR: u16 = 2500;
/// A consumer waits at least this long for its first message.
const PRE_CONSUMPTION: Duration = Duration::from_secs(10);
const ACTION_TIMED_OUT: u8 = 0;
const ACTION_AUTO_DELETE: u8 = 1;
const ACTION_AUTO_RESET: u8 = 2;
const ACTION_DEFERRED_DELETE: u8 = 3;
