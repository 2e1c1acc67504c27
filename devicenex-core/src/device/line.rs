//! What may be in flight: each conversation is a line with at most one frame.

use link_core::{TxOutcome, TxToken};

use crate::access::Access;

/// One conversation.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) struct Line {
    in_flight: Option<(Sent, Fate)>,
}

/// A frame that was handed to the controller.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Sent {
    /// The acknowledge of a fragment: nobody waits for it.
    Acknowledge,
    /// A response, or a fragment of one.
    Response,
    /// An implicit message, or a fragment of one.
    Implicit,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
enum Fate {
    /// Its `TxDone` is being waited for.
    Wanted,
    /// It must be withdrawn.
    Unwanted,
    /// It has been withdrawn, or the controller drops it by itself.
    Abandoned,
}

/// What became of the frame of a line.
pub(super) struct Done {
    pub(super) what: Sent,
    /// Somebody waits for it still.
    pub(super) wanted: bool,
    /// It was given back although nobody asked for it.
    pub(super) given_back: bool,
}

impl Line {
    pub(super) const IDLE: Self = Self { in_flight: None };

    pub(super) const fn is_free(&self) -> bool {
        self.in_flight.is_none()
    }

    pub(super) const fn begin(&mut self, what: Sent) {
        self.in_flight = Some((what, Fate::Wanted));
    }

    /// What it belonged to is gone. If it was `dropped`, the controller has it no longer.
    pub(super) const fn abandon(&mut self, dropped: bool) {
        if let Some((_, fate)) = &mut self.in_flight {
            *fate = match *fate {
                Fate::Wanted | Fate::Unwanted if !dropped => Fate::Unwanted,
                Fate::Wanted | Fate::Unwanted | Fate::Abandoned => Fate::Abandoned,
            };
        }
    }

    pub(super) const fn must_withdraw(&self) -> bool {
        matches!(self.in_flight, Some((_, Fate::Unwanted)))
    }

    /// Whether the frame is to be withdrawn; asked once.
    pub(super) const fn take_withdrawal(&mut self) -> bool {
        let must = self.must_withdraw();
        if must {
            self.abandon(true);
        }
        must
    }

    /// The frame is with the controller no longer; `None` if there was none.
    pub(super) fn done(&mut self, outcome: TxOutcome) -> Option<Done> {
        let (what, fate) = self.in_flight.take()?;
        let wanted = fate == Fate::Wanted;
        Some(Done { what, wanted, given_back: wanted && outcome != TxOutcome::Sent })
    }
}

/// The token of connection and other responses that take one frame.
pub(super) const ANSWERS: TxToken = TxToken(1);
/// The token of connectionless responses in fragments.
pub(super) const CONNECTIONLESS: TxToken = TxToken(2);

/// The token of a connection, by its place.
pub(super) fn token(place: u8) -> TxToken {
    const { assert!(Access::TOKEN.0 == 0, "tokens are told apart by their number") };
    TxToken(u16::from(place).saturating_add(FIRST_CONNECTION))
}

/// The place of the connection of a token.
pub(super) fn place_of(token: TxToken) -> Option<usize> {
    token.0.checked_sub(FIRST_CONNECTION).map(usize::from)
}

const FIRST_CONNECTION: u16 = 0x100;
