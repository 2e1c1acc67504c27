//! What a frame of a CAN bus means.

use core::fmt;

use devicenet_core::doctor::Severity;
use devicenet_core::monitor::{Kind, Reading};
use devicenex_core::monitor as nex;

use super::outside::Outside;
use super::sheets::Note;

/// What a frame means.
#[allow(
    clippy::large_enum_variant,
    reason = "there is one at a time, on the stack, and it is nearly always the large one"
)]
pub(super) enum Meaning<'a> {
    /// A classic frame, as the monitor of DeviceNet reads it.
    Read(Reading<'a>),
    /// The same, as that of DeviceNeX does.
    Nex(nex::Reading<'a>),
    /// What no monitor is asked about.
    Outside(Outside),
}

impl Meaning<'_> {
    /// The MAC ID or operational address of the sender, where it is known.
    pub(super) fn source(&self) -> Option<u8> {
        match self {
            Self::Read(reading) => reading.src.map(u8::from),
            Self::Nex(reading) => reading.src.map(u8::from),
            Self::Outside(_) => None,
        }
    }

    pub(super) fn reading(&self) -> Option<&Reading<'_>> {
        match self {
            Self::Read(reading) => Some(reading),
            Self::Nex(_) | Self::Outside(_) => None,
        }
    }

    pub(super) fn kind(&self) -> &'static str {
        match self {
            Self::Read(reading) => reading.kind.name(),
            Self::Nex(reading) => reading.kind.name(),
            Self::Outside(_) => Kind::Foreign.name(),
        }
    }

    pub(super) fn has_problem(&self) -> bool {
        match self {
            Self::Read(reading) => reading.problem.is_some(),
            Self::Nex(reading) => reading.problem.is_some(),
            Self::Outside(_) => true,
        }
    }

    /// What its problem says of the network. What stands outside, the rules of the doctor judge.
    pub(super) fn severity(&self) -> Severity {
        match self {
            Self::Read(reading) => reading.problem.as_ref().map_or(Severity::Info, Severity::of),
            Self::Nex(reading) => match reading.problem {
                Some(nex::Problem::Flaw(flaw)) => Severity::of_flaw(&flaw),
                // A device that comes back finds its address given to its spare.
                Some(nex::Problem::AddressTaken { .. }) | None => Severity::Info,
                // No rule judges what becomes of the others.
                Some(_) => Severity::Warning,
            },
            Self::Outside(_) => Severity::Info,
        }
    }

    /// Its problem in words.
    pub(super) fn problem(&self) -> String {
        match self {
            Self::Read(reading) => reading.problem.map(|problem| problem.to_string()).unwrap_or_default(),
            Self::Nex(reading) => reading.problem.map(|problem| problem.to_string()).unwrap_or_default(),
            Self::Outside(outside) => outside.to_string(),
        }
    }

    /// A stable name for the kind of its problem.
    pub(super) fn problem_code(&self) -> Option<&'static str> {
        match self {
            Self::Read(reading) => reading.problem.map(|problem| problem.code()),
            Self::Nex(reading) => reading.problem.map(|problem| problem.code()),
            Self::Outside(outside) => Some(outside.code()),
        }
    }
}

impl fmt::Display for Meaning<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read(reading) => reading.fmt(f),
            Self::Nex(reading) => reading.fmt(f),
            Self::Outside(outside) => outside.fmt(f),
        }
    }
}

/// The words of a frame, and what its values are.
pub(super) struct Noted<'a>(pub(super) &'a Meaning<'a>, pub(super) Option<Note<'a>>);

impl fmt::Display for Noted<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)?;
        self.1.as_ref().map_or(Ok(()), |note| note.fmt(f))
    }
}
