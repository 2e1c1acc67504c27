//! The state of a connection.

use core::fmt;

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
    /// All states, in the order of their bits in a record of the states seen.
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

    /// Its bit in a record of the states seen.
    #[must_use]
    pub const fn bit(self) -> u8 {
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
