//! What a controller can be in the middle of, and what a bit can lead to.

use link_core::wire::Field;
use link_core::{BusErrorKind, Frame};

/// What a controller does in a bit, between frames and in them.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Phase {
    /// No power, cut off, or bus-off and not reset.
    Off,
    /// Waits for `left` sequences of 11 recessive bits, and has seen `run` bits of one: 1 sequence after a start, 128
    /// after bus-off.
    Joining { left: u16, run: u16 },
    /// The bus is free.
    Idle,
    /// Sends or receives.
    Frame,
    /// Six dominant bits, of which `sent` are done: an active error flag or an overload flag.
    Flag { sent: u8, overload: bool },
    /// A passive error flag: over when six equal bits were seen.
    PassiveFlag { run: u8, last: bool },
    /// After its flag, until the others have ended theirs; `dominant` bits were seen of eight that count as an error.
    AfterFlag { dominant: u8, first: bool, overload: bool },
    /// Error or overload delimiter: eight recessive bits.
    Delimiter { seen: u8 },
    /// Three recessive bits.
    Intermission { seen: u8 },
    /// Eight bits more, for an error-passive controller that has sent.
    Suspend { left: u8 },
}

impl Phase {
    /// Nothing that was begun is unfinished: the controller could sleep until the next start of frame.
    pub(crate) const fn is_quiet(self) -> bool {
        matches!(self, Self::Off | Self::Joining { .. } | Self::Idle | Self::Suspend { .. })
    }

    /// It is occupied with a frame or an error.
    pub(crate) const fn is_busy(self) -> bool {
        !self.is_quiet() && !matches!(self, Self::Intermission { .. })
    }
}

/// What a sampled bit led to.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Effect {
    /// Nothing to tell.
    None,
    /// Another's start of frame. If `may_join`, a frame that was waiting is sent from its first identifier bit on.
    StartOfFrame { may_join: bool },
    /// A frame was received.
    Received(Frame),
    /// The own frame was sent and acknowledged.
    Sent,
    /// Sent recessive and saw dominant in the arbitration field.
    LostArbitration { bit: u32 },
    /// An error was detected.
    Error(Detected),
    /// The bus was recessive for as long as [`Phase::Joining`] asked.
    Joined,
}

/// An error as one controller sees it.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) struct Detected {
    pub(crate) kind: BusErrorKind,
    /// Bits since the start of frame, 0 being that; `None` in a delimiter, a flag, or between frames.
    pub(crate) place: Option<(u32, Field)>,
    /// It was the sender of the frame.
    pub(crate) sender: bool,
    /// How it flags the error.
    pub(crate) flag: Flag,
}

/// How a controller tells the others of an error.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Flag {
    /// Six dominant bits: every other controller sees an error too.
    Active,
    /// Six recessive bits: nobody sees them.
    Passive,
    /// None: it only listens.
    None,
}
