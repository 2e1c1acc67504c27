//! The asynchronous slot: who may send, and who does.

use link_core::Instant;

use super::{Answered, Kind, Problem, Reading};
use crate::NodeId;
use crate::wire::{Flags, RequestedService, Soa};

/// To whom the medium belongs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Slot {
    /// No SoA was seen yet.
    Unknown,
    /// The isochronous phase.
    Closed,
    Open(Invitation),
}

/// A SoA that waits for its answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Invitation {
    n: u64,
    at: Instant,
    service: RequestedService,
    pub(super) target: NodeId,
    /// ER
    pub(super) reset: bool,
    is_answered: bool,
}

impl Slot {
    pub(super) const fn open(&mut self, reading: &Reading<'_>, soa: &Soa) {
        *self = Self::Open(Invitation {
            n: reading.n,
            at: reading.at,
            service: soa.service,
            target: soa.target,
            reset: soa.flags.contains(Flags::EXCEPTION_RESET),
            is_answered: false,
        });
    }

    pub(super) const fn close(&mut self) {
        if let Self::Open(_) = self {
            *self = Self::Closed;
        }
    }

    /// A request that its target has to answer, and has not.
    pub(super) fn unanswered(&self) -> Option<(NodeId, RequestedService)> {
        let Self::Open(invitation) = self else { return None };
        let must =
            matches!(invitation.service, RequestedService::IDENT_REQUEST | RequestedService::STATUS_REQUEST);
        (must && !invitation.is_answered).then_some((invitation.target, invitation.service))
    }

    /// An ASnd was sent. Returns the invitation that it answers.
    pub(super) fn used(
        &mut self,
        reading: &mut Reading<'_>,
        sender: NodeId,
        sends_several: bool,
    ) -> Option<Invitation> {
        let invitation = match self {
            Self::Unknown => return None,
            Self::Open(invitation)
                if invitation.target == sender
                    && (sends_several || !invitation.is_answered)
                    && asks_for(invitation.service, reading.kind) =>
            {
                invitation
            }
            Self::Closed | Self::Open(_) => {
                reading.flag(Problem::NotInvited);
                return None;
            }
        };
        if matches!(reading.kind, Kind::AsndIdentResponse | Kind::AsndStatusResponse) {
            let latency = reading.at.saturating_since(invitation.at);
            reading.request = Some(Answered { n: invitation.n, latency });
        }
        invitation.is_answered = true;
        Some(*invitation)
    }
}

/// Whether a message may be sent in a slot for a service.
const fn asks_for(service: RequestedService, kind: Kind) -> bool {
    match service {
        RequestedService::NO_SERVICE => false,
        RequestedService::IDENT_REQUEST => matches!(kind, Kind::AsndIdentResponse),
        RequestedService::STATUS_REQUEST => matches!(kind, Kind::AsndStatusResponse),
        _ => !matches!(kind, Kind::AsndIdentResponse | Kind::AsndStatusResponse),
    }
}
