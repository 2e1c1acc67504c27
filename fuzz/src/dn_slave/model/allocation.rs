//! Allocate and Release, from their tables.

use devicenet_core::slave::Options;

use super::connections::{BITS, CHANGE, Connection, Kind, MULTICAST, POLLED, Parent, STROBED, State};
use super::{BOTH, COS, CYCLIC, EXPLICIT, Model, POLL, STROBE, SUPPRESSION};

/// The way on which a request came.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Door {
    Unconnected,
    Predefined,
    Dynamic(usize),
}

/// General status and additional code.
pub(super) type Refusal = (u8, u8);

impl Model {
    pub(super) fn allocate(&mut self, door: Door, requester: u8, data: &[u8]) -> Result<Vec<u8>, Refusal> {
        let [choice, allocator] = match *data {
            [choice, allocator] => [choice, allocator],
            _ => return Err((if data.len() < 2 { 0x13 } else { 0x15 }, 0xFF)),
        };
        let connections = choice & !(SUPPRESSION | 0x80);
        let allocated = self.choice();
        let for_another = self.options.contains(Options::ALLOCATE_FOR_ONESELF_ONLY) && allocator != requester;
        let checks = [
            (self.master.is_some_and(|master| master != allocator), (0x0C, 0x01)),
            (choice == 0, (0x09, 0x02)),
            (choice & SUPPRESSION != 0 && choice & BOTH == 0, (0x09, 0x02)),
            // Every connection is supported.
            (door == Door::Unconnected && choice & EXPLICIT == 0 && !self.explicit.exists(), (0x09, 0x02)),
            (
                allocated & connections != 0 || (allocated & BOTH != 0 && connections & BOTH != 0),
                (0x0B, 0x02),
            ),
            (connections & BOTH == BOTH, (0x09, 0x02)),
            (choice & 0x80 != 0 || allocator > 63 || for_another, (0x09, 0x02)),
            (self.message_ids(choice) & self.dynamic_message_ids() != 0, (0x02, 0x04)),
        ];
        if let Some((_, refusal)) = checks.into_iter().find(|(holds, _)| *holds) {
            return Err(refusal);
        }
        let format = match door {
            Door::Dynamic(at) => self.dynamic[at].format,
            Door::Unconnected | Door::Predefined => 0,
        };
        if self.master.is_none() {
            self.release_timed_out();
            (self.held, self.group) = (0, allocator);
        }
        self.master = Some(allocator);
        self.parent = match door {
            Door::Dynamic(at) if choice & EXPLICIT == 0 && !self.explicit.exists() => Parent::Dynamic(at),
            _ => Parent::Predefined,
        };
        self.create(choice);
        Ok(vec![format])
    }

    fn create(&mut self, choice: u8) {
        let acknowledged = choice & SUPPRESSION == 0;
        if choice & EXPLICIT != 0 {
            self.explicit = Connection::explicit(self.now);
        }
        let second = matches!(self.io[POLLED].state, State::Configuring | State::Established);
        if choice & POLL != 0 && second {
            self.kinds[POLLED] = Kind::Polled;
        } else if choice & POLL != 0 {
            self.allocate_io(POLLED, Kind::Polled);
        } else if choice & BOTH != 0 && !second {
            self.held &= !POLL;
            self.allocate_io(POLLED, if acknowledged { Kind::Polled } else { Kind::ConsumeOnly });
        }
        if choice & STROBE != 0 {
            self.allocate_io(STROBED, Kind::Polled);
        }
        if choice & COS != 0 {
            self.allocate_io(CHANGE, Kind::Change { acknowledged });
        }
        if choice & CYCLIC != 0 {
            self.allocate_io(CHANGE, Kind::Cyclic { acknowledged });
        }
        if choice & BITS[MULTICAST] != 0 {
            self.allocate_io(MULTICAST, Kind::Polled);
        }
        if choice & BOTH != 0 {
            self.held &= !(BOTH | SUPPRESSION);
        }
        self.held |= choice;
    }

    pub(super) fn release(&mut self, requester: u8, data: &[u8]) -> Result<Vec<u8>, Refusal> {
        let [mut choice] = match *data {
            [choice] => [choice],
            _ => return Err((if data.is_empty() { 0x13 } else { 0x15 }, 0xFF)),
        };
        let by_owner_only = self.options.contains(Options::RELEASE_BY_OWNER_ONLY);
        if by_owner_only && self.master.is_some_and(|master| master != requester) {
            return Err((0x0C, 0x01));
        }
        if self.options.contains(Options::RELEASE_IGNORES_BIT_6) {
            choice &= !SUPPRESSION;
        }
        if choice == 0 || choice & (SUPPRESSION | 0x80) != 0 {
            return Err((0x09, 0x02));
        }
        if choice & !self.held != 0 {
            return Err((0x0B, 0x02));
        }
        let remaining = self.held & !choice;
        if choice & EXPLICIT != 0 {
            self.explicit.end();
        }
        for (at, bits) in BITS.into_iter().enumerate().filter(|(at, _)| *at != POLLED) {
            if choice & bits != 0 {
                self.remove_io(at);
            }
        }
        // Instance 2 serves poll, and the direction to the slave of change of state and cyclic.
        if remaining & (POLL | BOTH) == 0 {
            if choice & (POLL | BOTH) != 0 {
                self.remove_io(POLLED);
            }
        } else if choice & POLL != 0 {
            let acknowledged = remaining & SUPPRESSION == 0;
            self.kinds[POLLED] = if acknowledged { Kind::Polled } else { Kind::ConsumeOnly };
        }
        self.held = remaining;
        Ok(Vec::new())
    }

    /// The Group 2 Message IDs that a choice needs, as bits.
    pub(super) fn message_ids(&self, choice: u8) -> u8 {
        let mut ids = 0;
        for (bits, needed) in [(EXPLICIT, 0x18), (POLL | BOTH, 0x20)] {
            if choice & bits != 0 {
                ids |= needed;
            }
        }
        if choice & BOTH != 0 && choice & SUPPRESSION == 0 { ids | 0x04 } else { ids }
    }
}
