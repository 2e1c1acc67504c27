//! The waits of a connection.

use cip_core::connection::{ProductionTimer, Settings, Watchdog};
use cip_core::transfer::Wait;
use link_core::Timers;
use link_core::timers::TimerKey;

/// The waits of one connection; of the connectionless port, the last two.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Timer {
    /// Inactivity; while it is being configured, until it is given up.
    Watchdog,
    /// Transmission trigger.
    Trigger,
    /// Production inhibit.
    Inhibit,
    /// The acknowledge of a change of state or cyclic message, or of a fragment of a response.
    Acknowledge,
    /// The next fragment of a request.
    Reassembly,
}

pub(super) type Waits = Timers<Timer, 5>;

impl TimerKey<5> for Timer {
    const ALL: [Self; 5] =
        [Self::Watchdog, Self::Trigger, Self::Inhibit, Self::Acknowledge, Self::Reassembly];
    const WHY: [&'static str; 5] = [
        "time-out of a connection",
        "transmission trigger",
        "production inhibit time",
        "acknowledge of a message or a fragment",
        "next fragment",
    ];

    fn index(self) -> usize {
        match self {
            Self::Watchdog => 0,
            Self::Trigger => 1,
            Self::Inhibit => 2,
            Self::Acknowledge => 3,
            Self::Reassembly => 4,
        }
    }
}

impl From<Wait> for Timer {
    fn from(wait: Wait) -> Self {
        match wait {
            Wait::Acknowledge => Self::Acknowledge,
            Wait::Reassembly => Self::Reassembly,
        }
    }
}

impl From<ProductionTimer> for Timer {
    fn from(timer: ProductionTimer) -> Self {
        match timer {
            ProductionTimer::Trigger => Self::Trigger,
            ProductionTimer::Inhibit => Self::Inhibit,
            ProductionTimer::Acknowledge => Self::Acknowledge,
        }
    }
}

/// Does with the inactivity timer what a connection with these settings says.
pub(super) fn apply(timers: &mut Waits, settings: &Settings, watchdog: Watchdog) {
    watchdog.apply(timers, Timer::Watchdog, settings.expected_packet_rate(), settings.multiplier());
}
