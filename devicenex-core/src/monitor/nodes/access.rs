//! Where a node stands on its way to the network.

use core::fmt;
use core::time::Duration;

use link_core::Instant;

use super::Node;

/// Where a node stands on its way to the network.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AccessState {
    /// Nothing was heard of it.
    Unknown,
    /// It has sent its first Hello.
    FirstHello,
    /// It has sent its second.
    SecondHello,
    /// It waits for an address.
    Standby,
    /// It takes part: it has sent something else, or nobody has objected for a second after its second Hello.
    OnLine,
    /// Two devices want the address, and none of them has it yet.
    Contested,
    /// Its device was heard with another address.
    OffLine,
}

impl AccessState {
    /// The name, the same for programs and for people.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Unknown => "unknown",
            Self::FirstHello => "first_hello",
            Self::SecondHello => "second_hello",
            Self::Standby => "standby",
            Self::OnLine => "online",
            Self::Contested => "contested",
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
    /// The node is there: it has sent something other than a Hello.
    pub(in crate::monitor) fn takes_part(&mut self, at: Instant) {
        let is_new = match self.access {
            AccessState::Unknown
            | AccessState::FirstHello
            | AccessState::SecondHello
            | AccessState::Standby
            | AccessState::OffLine => true,
            // A newcomer would have sent its second Hello by now: the owner has kept its address.
            AccessState::Contested => at.saturating_since(self.access_since) > SECOND_HELLO_WITHIN,
            AccessState::OnLine => false,
        };
        if is_new {
            self.rival = None;
            self.enter(AccessState::OnLine, at);
        }
    }

    pub(in crate::monitor) fn enter(&mut self, state: AccessState, at: Instant) {
        self.access = state;
        self.access_since = at;
    }

    /// The state at `now`: a wait after the second Hello the node is on line, or in Standby.
    pub(in crate::monitor) fn access_at(&self, now: Instant) -> AccessState {
        let waited = now.saturating_since(self.access_since);
        match self.access {
            AccessState::SecondHello if waited >= HELLO_WAIT && self.address.is_none() => {
                AccessState::Standby
            }
            AccessState::SecondHello if waited >= HELLO_WAIT => AccessState::OnLine,
            state => state,
        }
    }
}

/// The wait after each Hello **\[D\]**.
const HELLO_WAIT: Duration = Duration::from_secs(1);
/// The second Hello comes one second after the first was sent; a busy bus delays it.
pub(in crate::monitor) const SECOND_HELLO_WITHIN: Duration = Duration::from_secs(2);
