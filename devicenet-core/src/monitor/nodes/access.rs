//! Where a node stands on its way to the network.

use core::fmt;
use core::time::Duration;

use link_core::Instant;

use super::super::dup_mac::SECOND_CHECK_WITHIN;
use super::Node;

/// Where a node stands on its way to the network.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AccessState {
    /// Nothing was heard of it.
    Unknown,
    /// It has sent its first duplicate MAC ID check request.
    FirstCheck,
    /// It has sent its second.
    SecondCheck,
    /// It takes part: it has sent something else, or nobody has objected for a second after the second check.
    OnLine,
    /// Two devices claim the MAC ID, and none of them has it yet.
    SuspectedDuplicate,
    /// It has told on the offline connection set that it has a communication fault.
    Faulted,
    /// It has said that it goes off line, by Device Shutdown, or its device was heard with another MAC ID.
    OffLine,
}

impl AccessState {
    /// The name, the same for programs and for people.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Unknown => "unknown",
            Self::FirstCheck => "first_check",
            Self::SecondCheck => "second_check",
            Self::OnLine => "online",
            Self::SuspectedDuplicate => "suspected_duplicate",
            Self::Faulted => "comm_fault",
            Self::OffLine => "offline",
        }
    }
}

impl fmt::Display for AccessState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Node {
    /// The node is there: it has sent something other than a check.
    pub(in crate::monitor) fn takes_part(&mut self, at: Instant) {
        let is_new = match self.access {
            AccessState::Unknown | AccessState::FirstCheck | AccessState::SecondCheck => true,
            // It was repaired, or another device has the MAC ID: a faulted one is silent.
            AccessState::OffLine | AccessState::Faulted => true,
            // A newcomer would have checked a second time by now: the owner has kept its MAC ID.
            AccessState::SuspectedDuplicate => at.saturating_since(self.access_since) > SECOND_CHECK_WITHIN,
            AccessState::OnLine => false,
        };
        if is_new {
            if self.access == AccessState::SuspectedDuplicate {
                self.check = None;
            }
            // Of two devices the one that was there before goes on.
            self.half_checked = self.access == AccessState::FirstCheck && self.rival.is_none();
            self.access = AccessState::OnLine;
            self.access_since = at;
        }
    }

    /// It has said that it goes off line, or must have gone.
    pub(in crate::monitor) fn goes_off_line(&mut self, at: Instant) {
        self.access = AccessState::OffLine;
        self.access_since = at;
    }

    /// The access state at `now`: a second after the second check the node is on line.
    pub(in crate::monitor) fn access_at(&self, now: Instant) -> AccessState {
        let waited = now.saturating_since(self.access_since);
        match self.access {
            AccessState::SecondCheck if waited >= CHECK_TIME => AccessState::OnLine,
            state => state,
        }
    }
}

/// The wait after each duplicate MAC ID check request.
const CHECK_TIME: Duration = Duration::from_secs(1);
