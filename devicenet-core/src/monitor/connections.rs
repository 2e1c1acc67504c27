//! What is known of a connection.

use core::fmt;
use core::time::Duration;

use cip_core::code::InstanceId;
use link_core::Instant;

use super::pairing::Seen;
use crate::id::MacId;

/// The connections of the predefined master/slave connection set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Predefined {
    /// Instance 1: explicit messages.
    Explicit,
    /// Instance 2: poll; also the master's direction of COS/cyclic.
    Poll,
    /// Instance 3: bit-strobe.
    BitStrobe,
    /// Instance 4: change of state or cyclic.
    CosCyclic,
    /// Instance 5: multicast poll.
    MulticastPoll,
}

impl Predefined {
    /// All five, in the order of their instances.
    pub const ALL: [Self; 5] =
        [Self::Explicit, Self::Poll, Self::BitStrobe, Self::CosCyclic, Self::MulticastPoll];

    /// The instance of the Connection object.
    #[must_use]
    pub const fn instance(self) -> InstanceId {
        InstanceId(match self {
            Self::Explicit => 1,
            Self::Poll => 2,
            Self::BitStrobe => 3,
            Self::CosCyclic => 4,
            Self::MulticastPoll => 5,
        })
    }

    /// The connection of an instance 1-5.
    #[must_use]
    pub const fn from_instance(instance: InstanceId) -> Option<Self> {
        match instance.0 {
            1 => Some(Self::Explicit),
            2 => Some(Self::Poll),
            3 => Some(Self::BitStrobe),
            4 => Some(Self::CosCyclic),
            5 => Some(Self::MulticastPoll),
            _ => None,
        }
    }

    /// The name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Explicit => "explicit",
            Self::Poll => "poll",
            Self::BitStrobe => "bit-strobe",
            Self::CosCyclic => "COS/cyclic",
            Self::MulticastPoll => "multicast poll",
        }
    }
}

impl fmt::Display for Predefined {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The state of a connection, as far as the traffic tells it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ConnectionState {
    /// Nothing was seen that tells it.
    Unknown,
    /// Not allocated, or released, deleted, timed out with auto delete.
    NonExistent,
    /// Allocated; no expected packet rate yet.
    Configuring,
    /// A connection made by Create that waits for the identifier it consumes.
    WaitingForConnectionId,
    /// In use.
    Established,
    /// Its watchdog has expired.
    TimedOut,
    /// An explicit connection whose watchdog has expired while I/O goes on (watchdog action 3).
    DeferredDelete,
}

impl ConnectionState {
    /// All states, in the order of their bits in [`ConnectionRecord::states_seen`].
    pub const ALL: [Self; 7] = [
        Self::Unknown,
        Self::NonExistent,
        Self::Configuring,
        Self::WaitingForConnectionId,
        Self::Established,
        Self::TimedOut,
        Self::DeferredDelete,
    ];

    /// The machine-readable name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Unknown => "unknown",
            Self::NonExistent => "non_existent",
            Self::Configuring => "configuring",
            Self::WaitingForConnectionId => "waiting_for_connection_id",
            Self::Established => "established",
            Self::TimedOut => "timed_out",
            Self::DeferredDelete => "deferred_delete",
        }
    }

    /// The state of the number in attribute 1 of the Connection object.
    #[must_use]
    pub const fn from_attribute(value: u8) -> Option<Self> {
        match value {
            0 => Some(Self::NonExistent),
            1 => Some(Self::Configuring),
            2 => Some(Self::WaitingForConnectionId),
            3 => Some(Self::Established),
            4 => Some(Self::TimedOut),
            5 => Some(Self::DeferredDelete),
            _ => None,
        }
    }

    const fn bit(self) -> u8 {
        match self {
            Self::Unknown => 0x01,
            Self::NonExistent => 0x02,
            Self::Configuring => 0x04,
            Self::WaitingForConnectionId => 0x08,
            Self::Established => 0x10,
            Self::TimedOut => 0x20,
            Self::DeferredDelete => 0x40,
        }
    }
}

impl fmt::Display for ConnectionState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Unknown => "unknown",
            Self::NonExistent => "non-existent",
            Self::Configuring => "configuring",
            Self::WaitingForConnectionId => "waiting for connection ID",
            Self::Established => "established",
            Self::TimedOut => "timed out",
            Self::DeferredDelete => "deferred delete",
        })
    }
}

/// Which way a message of a connection goes, seen from the server (slave).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Flow {
    /// From the client to the server.
    Consumed,
    /// From the server to the client.
    Produced,
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
    /// At least one command was answered.
    pub(super) answers: bool,
    pub(super) frames: u64,
    pub(super) bytes: u64,
}

impl Side {
    const NEW: Self = Self { size: None, guess: Guess::Plain, path: None, heard: false, known: false };
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

    /// The connection is gone.
    pub(super) fn end(&mut self, at: Instant) {
        self.waiting = None;
        self.enter(ConnectionState::NonExistent, at);
    }

    /// A message that restarts the watchdog was seen.
    pub(super) fn touch(&mut self, at: Instant) {
        self.active = at;
        self.fresh = false;
    }

    /// The watchdog time; `None` without a watchdog.
    pub(super) fn watchdog(&self) -> Option<Duration> {
        let epr = self.epr.filter(|&epr| epr != 0)?;
        let factor = 4_u32.checked_shl(u32::from(self.multiplier.min(7))).unwrap_or(4);
        let time = Duration::from_millis(u64::from(epr)).saturating_mul(factor);
        Some(if self.fresh { time.max(PRE_CONSUMPTION) } else { time })
    }

    /// Lets the watchdog expire if it must have by `now`. `io_alive` says whether I/O of the same set is established.
    pub(super) fn settle(&mut self, now: Instant, explicit: bool, io_alive: bool) {
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

/// Which connection a record is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ConnectionName {
    /// One of the predefined set.
    Predefined(Predefined),
    /// Opened by UCMM.
    Dynamic {
        /// The instance at the server; `None` if the response to Open was not seen.
        instance: Option<InstanceId>,
        /// The message group, 1-3.
        group: u8,
    },
}

impl fmt::Display for ConnectionName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Predefined(connection) => fmt::Display::fmt(connection, f),
            Self::Dynamic { instance: Some(instance), group } => write!(f, "group {group} {instance}"),
            Self::Dynamic { instance: None, group } => write!(f, "group {group}"),
        }
    }
}

/// What is known of a connection: a copy for a summary.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ConnectionRecord {
    /// The slave, or the server of a dynamic connection.
    pub server: MacId,
    /// The master, or the client; `None` if the allocation was not seen.
    pub client: Option<MacId>,
    /// Which connection.
    pub name: ConnectionName,
    /// The state at the time of the last frame observed.
    pub state: ConnectionState,
    /// The state is inferred and not told by a message.
    pub assumed: bool,
    /// The states it has been in: bit n for `ConnectionState::ALL[n]`.
    pub states_seen: u8,
    /// The expected packet rate that the server uses, in milliseconds.
    pub epr: Option<u16>,
    /// Attribute 12.
    pub watchdog_action: Option<u8>,
    /// Attribute 17, in milliseconds.
    pub inhibit: Option<u16>,
    /// Bytes of I/O data that the server consumes.
    pub consumed_size: Option<u16>,
    /// Bytes of I/O data that the server produces.
    pub produced_size: Option<u16>,
    /// The instance in the consumed connection path.
    pub consumed_path: Option<InstanceId>,
    /// The instance in the produced connection path.
    pub produced_path: Option<InstanceId>,
    /// Frames in both directions.
    pub frames: u64,
    /// Data bytes in both directions.
    pub bytes: u64,
}

impl ConnectionRecord {
    /// The states it has been in.
    pub fn states(&self) -> impl Iterator<Item = ConnectionState> + use<> {
        let seen = self.states_seen;
        ConnectionState::ALL.into_iter().filter(move |state| seen & state.bit() != 0)
    }

    pub(super) fn of(
        name: ConnectionName,
        server: MacId,
        client: Option<MacId>,
        connection: &Connection,
    ) -> Self {
        Self {
            server,
            client,
            name,
            state: connection.state,
            assumed: connection.assumed,
            states_seen: connection.states_seen,
            epr: connection.epr,
            watchdog_action: connection.watchdog_action,
            inhibit: connection.inhibit,
            consumed_size: connection.consumed.size,
            produced_size: connection.produced.size,
            consumed_path: connection.consumed.path,
            produced_path: connection.produced.path,
            frames: connection.frames,
            bytes: connection.bytes,
        }
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
