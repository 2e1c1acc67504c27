//! The connections of a network: their names, their states, and what a summary says of them.

use core::fmt;
use core::time::Duration;

use cip_core::code::InstanceId;
use cip_core::monitor::{Connection, ConnectionState};

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

/// Which connection a record is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ConnectionName {
    /// One of the predefined set.
    Predefined(Predefined),
    /// Opened by UCMM, or made by Create.
    Dynamic {
        /// The instance at the server; `None` if the response to Open was not seen.
        instance: Option<InstanceId>,
        /// The message group, 1-3; of a connection made by Create, that of the identifier named last.
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

/// The connection opened by UCMM, or made by Create, that a frame is on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DynamicConnection {
    /// Who has the instance: it answers, whichever way the frame goes.
    pub server: MacId,
    /// Who has opened or made it.
    pub client: MacId,
    /// The instance at the server; `None` if the response to Open was not seen.
    pub instance: Option<InstanceId>,
    /// The message group, 1-3, as in [`ConnectionName::Dynamic`].
    pub group: u8,
    /// Its state at the frame.
    pub state: ConnectionState,
}

/// What is known of a connection: a copy for a summary.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ConnectionRecord {
    /// The slave, or the server of a dynamic connection.
    pub server: MacId,
    /// The master, or the client; `None` if neither an allocation nor an answer to it was seen.
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
    /// How long its peers wait for each other before they give up: four times the expected packet rate, or as attribute 18
    /// says. `None` if the rate is not known, or is 0, which is no watchdog.
    pub time_out: Option<Duration>,
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

    /// `None` if neither a state nor a frame of it was seen.
    pub(super) fn of(
        name: ConnectionName,
        server: MacId,
        client: Option<MacId>,
        connection: &Connection,
    ) -> Option<Self> {
        let is_known = connection.states_seen != 0 || connection.frames != 0;
        is_known.then_some(Self {
            server,
            client,
            name,
            state: connection.state,
            assumed: connection.assumed,
            states_seen: connection.states_seen,
            epr: connection.epr,
            time_out: connection.time_out(),
            watchdog_action: connection.watchdog_action,
            inhibit: connection.inhibit,
            consumed_size: connection.consumed.size,
            produced_size: connection.produced.size,
            consumed_path: connection.consumed.path,
            produced_path: connection.produced.path,
            frames: connection.frames,
            bytes: connection.bytes,
        })
    }
}
