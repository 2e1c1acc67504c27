//! The two indicators of a node: status (green) and error (red).

use core::fmt;
use core::time::Duration;

use crate::nmt::{Cause, NmtState};

/// How the status indicator shines.
///
/// | Pattern | State | Timing |
/// |---|---|---|
/// | off | initialisation, `NotActive` | |
/// | flickering | `BasicEthernet` | 50 ms on, 50 ms off |
/// | single flash | `PreOperational1` | 200 ms on, 1000 ms off |
/// | double flash | `PreOperational2` | on, off, on 200 ms each, 1000 ms off |
/// | triple flash | `ReadyToOperate` | three times 200 ms, 1000 ms off |
/// | on | `Operational` | |
/// | blinking | `Stopped` | 200 ms on, 200 ms off |
///
/// Source: Hilscher cifX manual DOC120205UM53EN, 8.12.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum StatusLed {
    /// Dark.
    Off,
    /// 10 Hz.
    Flickering,
    /// Once, then a pause.
    SingleFlash,
    /// Twice, then a pause.
    DoubleFlash,
    /// Three times, then a pause.
    TripleFlash,
    /// Lit.
    On,
    /// 2.5 Hz.
    Blinking,
}

impl StatusLed {
    /// The pattern of a state.
    #[must_use]
    pub const fn of(state: NmtState) -> Self {
        match state {
            NmtState::Off
            | NmtState::Initialising
            | NmtState::ResetApplication
            | NmtState::ResetCommunication
            | NmtState::ResetConfiguration
            | NmtState::NotActive => Self::Off,
            NmtState::PreOperational1 => Self::SingleFlash,
            NmtState::PreOperational2 => Self::DoubleFlash,
            NmtState::ReadyToOperate => Self::TripleFlash,
            NmtState::Operational => Self::On,
            NmtState::Stopped => Self::Blinking,
            NmtState::BasicEthernet => Self::Flickering,
        }
    }

    /// Whether it is lit, so long after the pattern began.
    ///
    /// ```
    /// use core::time::Duration;
    /// use powerlink_core::indicator::StatusLed;
    ///
    /// let lit = |millis| StatusLed::DoubleFlash.is_lit(Duration::from_millis(millis));
    /// assert_eq!([0, 199, 200, 400, 600, 1599, 1600].map(lit), [true, true, false, true, false, false, true]);
    /// ```
    #[must_use]
    pub fn is_lit(self, since: Duration) -> bool {
        let millis = since.as_millis();
        // Flashes of 200 ms with 200 ms between them, then a pause.
        let (place, flashes) = match self {
            Self::Off => return false,
            Self::On => return true,
            Self::Flickering => return millis % 100 < 50,
            Self::Blinking => return millis % 400 < 200,
            Self::SingleFlash => (millis % 1200, 1),
            Self::DoubleFlash => (millis % 1600, 2),
            Self::TripleFlash => (millis % 2000, 3),
        };
        place % 400 < 200 && place / 400 < flashes
    }

    /// In words.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Flickering => "flickering",
            Self::SingleFlash => "single flash",
            Self::DoubleFlash => "double flash",
            Self::TripleFlash => "triple flash",
            Self::On => "on",
            Self::Blinking => "blinking",
        }
    }
}

impl fmt::Display for StatusLed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// What a transition does to the error indicator; `None` if it stays as it is.
///
/// It goes off when the node starts anew, gets into `BasicEthernet` or `Operational`, and on by a cycle error and an
/// internal communication error.
#[must_use]
pub const fn error_led(cause: Cause, to: NmtState) -> Option<bool> {
    match (cause, to) {
        (Cause::CycleError | Cause::InternalError, _) => Some(true),
        (_, NmtState::Initialising | NmtState::BasicEthernet | NmtState::Operational) => Some(false),
        _ => None,
    }
}
