//! The interface and its controller.

use core::fmt;

use link_core::LinkEvent;

/// How the interface takes part in the bus.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(in crate::live::monitor) enum LinkState {
    Down,
    ErrorActive,
    ErrorWarning,
    ErrorPassive,
    BusOff,
}

impl LinkState {
    /// The state after an event; `None` if it tells nothing of it.
    pub(super) const fn after(event: LinkEvent) -> Option<Self> {
        match event {
            LinkEvent::Up | LinkEvent::ErrorActive => Some(Self::ErrorActive),
            LinkEvent::Down => Some(Self::Down),
            LinkEvent::ErrorWarning => Some(Self::ErrorWarning),
            LinkEvent::ErrorPassive => Some(Self::ErrorPassive),
            LinkEvent::BusOff => Some(Self::BusOff),
            LinkEvent::BusError(_)
            | LinkEvent::Counters { .. }
            | LinkEvent::Overrun { .. }
            | LinkEvent::ModeSet(_)
            | LinkEvent::FilterSet
            | LinkEvent::Refused(_) => None,
        }
    }

    /// For programs.
    pub(in crate::live::monitor) const fn name(self) -> &'static str {
        match self {
            Self::Down => "down",
            Self::ErrorActive => "error_active",
            Self::ErrorWarning => "error_warning",
            Self::ErrorPassive => "error_passive",
            Self::BusOff => "bus_off",
        }
    }
}

impl fmt::Display for LinkState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Down => "down",
            Self::ErrorActive => "up, error-active",
            Self::ErrorWarning => "up, error warning",
            Self::ErrorPassive => "up, error-passive",
            Self::BusOff => "bus-off",
        })
    }
}
