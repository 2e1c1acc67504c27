//! What is in flight: three lanes with one frame each.
//!
//! | Lane | Token | Frames |
//! |---|---|---|
//! | answers | 0x1001 | acknowledges of change-of-state and cyclic messages, output data outside of the scan |
//! | scan | 0x1002 | bit-strobe, multicast poll and poll commands |
//! | explicit | 0x1003 | requests, fragments and acknowledges; every slave in its turn |

use link_core::{Action, TxToken};

use super::event::MasterEvent;
use crate::id::MacId;

/// What is in flight.
#[derive(Clone, PartialEq, Eq, Hash, Debug, Default)]
pub(super) struct Lanes {
    pub(super) answers: Lane,
    pub(super) scan: Lane,
    pub(super) explicit: Lane,
    /// The explicit lane carries a request to an unconnected port, which another master may send as well.
    pub(super) contested: bool,
    /// It was taken back after a collision, and is wanted again.
    pub(super) taken_back: bool,
    /// The MAC ID whose turn it is in the explicit lane, and among the answers; or the next one that has something to send.
    pub(super) turn: u8,
    pub(super) answer_turn: u8,
}

#[derive(Clone, PartialEq, Eq, Hash, Debug, Default)]
pub(super) struct Lane {
    pub(super) carries: Option<Carried>,
    pub(super) withdrawal: Withdrawal,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub(super) enum Withdrawal {
    #[default]
    None,
    Due,
    /// Its `TxDone` tells what came of it.
    Told,
}

/// Who may send the next explicit message.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Turn {
    Slave(MacId),
    /// The device at MAC ID 63 that may replace a slave.
    Candidate,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Carried {
    /// What nobody wants to know about any more.
    Abandoned,
    Acknowledge,
    Output {
        slave: MacId,
        fragment: usize,
    },
    BitStrobe,
    Multicast {
        fragment: usize,
    },
    Poll {
        slave: MacId,
        fragment: usize,
    },
    Explicit {
        slave: MacId,
    },
    /// To the device at MAC ID 63 that may replace a slave.
    Candidate,
}

impl Lane {
    pub(super) const fn withdraw(&mut self) {
        if let Withdrawal::None = self.withdrawal {
            self.withdrawal = Withdrawal::Due;
        }
    }
}

impl Lanes {
    /// The number of frames in flight at most.
    pub(super) const COUNT: usize = 3;

    /// Whether a token is of a lane, and not of the node that the master is.
    pub(super) const fn own(token: TxToken) -> bool {
        token.0 >= ANSWERS.0
    }

    /// Nothing that is in flight is wanted any more.
    pub(super) fn abandon(&mut self) {
        for lane in [&mut self.answers, &mut self.scan, &mut self.explicit] {
            match lane.carries {
                // The conversation waits for its frame.
                Some(Carried::Explicit { .. } | Carried::Candidate) => lane.withdraw(),
                Some(_) => {
                    lane.carries = Some(Carried::Abandoned);
                    lane.withdraw();
                }
                None => {}
            }
        }
    }

    /// Whether a command of the scan is in flight.
    pub(super) const fn carries_command(&self) -> bool {
        self.scan.carries.is_some()
    }

    pub(super) const fn carries_explicit(&self) -> bool {
        self.explicit.carries.is_some()
    }

    /// Takes back a request that may collide with another master's; true if there is one.
    pub(super) const fn take_back(&mut self) -> bool {
        let takes = self.contested && !self.taken_back && self.explicit.carries.is_some();
        if takes {
            self.taken_back = true;
            self.explicit.withdraw();
        }
        takes
    }

    pub(super) fn withdraw(&mut self) -> Option<Action<MasterEvent>> {
        let lanes = [(ANSWERS, &mut self.answers), (SCAN, &mut self.scan), (EXPLICIT, &mut self.explicit)];
        let (token, lane) = lanes.into_iter().find(|(_, lane)| lane.withdrawal == Withdrawal::Due)?;
        lane.withdrawal = Withdrawal::Told;
        Some(Action::Withdraw(token))
    }

    pub(super) fn must_withdraw(&self) -> bool {
        [&self.answers, &self.scan, &self.explicit].iter().any(|lane| lane.withdrawal == Withdrawal::Due)
    }
}

pub(super) const ANSWERS: TxToken = TxToken(0x1001);
pub(super) const SCAN: TxToken = TxToken(0x1002);
pub(super) const EXPLICIT: TxToken = TxToken(0x1003);
