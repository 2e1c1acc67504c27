//! What the error counters of a controller make of it.

use transport_mock::{Counters, ErrorState};

use crate::scenario::EventName;

/// What part a controller takes by its error counters.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) enum Level {
    Active,
    Warning,
    Passive,
    BusOff,
}

impl Level {
    /// What a controller becomes when its counters change; `None` when it stays what it was. What drops below 96 is not
    /// told: no controller reports it.
    pub(super) fn entered(before: Counters, now: Counters) -> Option<Self> {
        match (before.state(), now.state()) {
            (ErrorState::Active, ErrorState::Active) => {
                (now.warning() && !before.warning()).then_some(Self::Warning)
            }
            (_, ErrorState::Active) => Some(Self::Active),
            (ErrorState::Passive, ErrorState::Passive) | (ErrorState::BusOff, ErrorState::BusOff) => None,
            (_, ErrorState::Passive) => Some(Self::Passive),
            (_, ErrorState::BusOff) => Some(Self::BusOff),
        }
    }

    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Active => "error-active",
            Self::Warning => "error warning",
            Self::Passive => "error-passive",
            Self::BusOff => "bus-off",
        }
    }

    pub(super) const fn event(self) -> EventName {
        match self {
            Self::Active => EventName::ErrorActive,
            Self::Warning => EventName::ErrorWarning,
            Self::Passive => EventName::ErrorPassive,
            Self::BusOff => EventName::BusOff,
        }
    }
}
