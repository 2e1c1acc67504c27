//! What is in flight: two lanes with one frame each, beside the manager's own node.
//!
//! | Lane | Token | Frames |
//! |---|---|---|
//! | addresses | 0x1001 | Mini-who, ROAM |
//! | requests | 0x1002 | requests, fragments and acknowledges; every device in its turn |

use link_core::{Action, TxToken};

use super::event::ManagerEvent;
use crate::id::OperationalAddress;

#[derive(Clone, PartialEq, Eq, Hash, Debug, Default)]
pub(super) struct Lanes {
    pub(super) addresses: Lane,
    pub(super) requests: Lane,
    /// The places in the database whose turn it is.
    pub(super) roam_turn: usize,
    pub(super) request_turn: usize,
}

#[derive(Clone, PartialEq, Eq, Hash, Debug, Default)]
pub(super) struct Lane {
    pub(super) carries: Option<Carried>,
    withdrawal: Withdrawal,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
enum Withdrawal {
    #[default]
    None,
    Due,
    /// Its `TxDone` tells what came of it.
    Told,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Carried {
    /// What nobody wants to know about any more.
    Abandoned,
    MiniWho,
    /// To the device that shall have that address.
    Roam(OperationalAddress),
    Request(OperationalAddress),
    /// Of the application.
    Talk,
}

impl Lane {
    /// Its frame is no longer wanted.
    pub(super) fn withdraw(&mut self) {
        if self.carries.is_some() && self.withdrawal == Withdrawal::None {
            self.withdrawal = Withdrawal::Due;
        }
    }

    /// What it carried: the controller is done with it.
    pub(super) fn take(&mut self) -> Option<Carried> {
        self.withdrawal = Withdrawal::None;
        self.carries.take()
    }
}

impl Lanes {
    /// The number of frames in flight at most.
    pub(super) const COUNT: usize = 2;

    /// Whether a token is of a lane, and not of the node that the manager is.
    pub(super) const fn own(token: TxToken) -> bool {
        token.0 >= ADDRESSES.0
    }

    pub(super) fn lane(&mut self, token: TxToken) -> Option<&mut Lane> {
        match token {
            ADDRESSES => Some(&mut self.addresses),
            REQUESTS => Some(&mut self.requests),
            _ => None,
        }
    }

    /// Nothing that is in flight is wanted any more.
    pub(super) fn abandon(&mut self) {
        if self.addresses.carries.is_some() {
            self.addresses.carries = Some(Carried::Abandoned);
        }
        self.addresses.withdraw();
        // Conversations wait for their frames.
        self.requests.withdraw();
    }

    /// A device is no longer in the database: nobody waits for what it was to be sent.
    pub(super) fn forget(&mut self, address: OperationalAddress) {
        for lane in [&mut self.addresses, &mut self.requests] {
            if lane.carries == Some(Carried::Request(address)) || lane.carries == Some(Carried::Roam(address))
            {
                lane.carries = Some(Carried::Abandoned);
                lane.withdraw();
            }
        }
    }

    pub(super) fn withdraw(&mut self) -> Option<Action<ManagerEvent>> {
        let lanes = [(ADDRESSES, &mut self.addresses), (REQUESTS, &mut self.requests)];
        let (token, lane) = lanes.into_iter().find(|(_, lane)| lane.withdrawal == Withdrawal::Due)?;
        lane.withdrawal = Withdrawal::Told;
        Some(Action::Withdraw(token))
    }

    pub(super) fn must_withdraw(&self) -> bool {
        [&self.addresses, &self.requests].iter().any(|lane| lane.withdrawal == Withdrawal::Due)
    }
}

pub(super) const ADDRESSES: TxToken = TxToken(0x1001);
pub(super) const REQUESTS: TxToken = TxToken(0x1002);
