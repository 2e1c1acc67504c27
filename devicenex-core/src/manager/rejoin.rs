//! A manager whose address another node has: it takes one that is free, and goes on.

use super::event::ManagerEvent;
use super::machine::Manager;
use super::timer::Timer;
use crate::access::StateKind;
use crate::id::OperationalAddress;

impl<const DEVICES: usize, const CONNECTIONS: usize> Manager<DEVICES, CONNECTIONS> {
    /// Begins or ends the wait in which another manager may give it an address.
    pub(super) fn follow_address(&mut self) {
        let wait = self.config.rejoin_after;
        if wait == 0 {
            return;
        }
        let state = self.access().state().kind();
        let has_none = state == StateKind::Standby;
        // One that it was given, and that it has to give away itself.
        let is_planned = state == StateKind::Online && self.place(self.own()).is_some();
        if is_planned {
            self.rejoin();
        } else if !has_none {
            self.timers.clear(Timer::Rejoin);
        } else if self.timers.at(Timer::Rejoin).is_none() {
            self.timers.set_after_millis(Timer::Rejoin, wait);
        }
    }

    /// Says Hello with the address that it was configured with, or with the next one that is free, as far as it knows. If
    /// somebody has that too, the answer to the Hello says so.
    pub(super) fn rejoin(&mut self) {
        let is_free =
            |address: &OperationalAddress| self.place(*address).is_none() && !self.strangers.has(*address);
        let first = self.config.node.access.first_address();
        let next = match self.tried {
            None => Some(first),
            Some(last) => {
                let after = OperationalAddress::all().filter(|address| *address > last);
                let before = OperationalAddress::all().filter(|address| *address <= last);
                after.chain(before).find(is_free)
            }
        };
        let Some(address) = next else { return };
        self.tried = Some(address);
        self.raise(ManagerEvent::Rejoins(address));
        self.node.set_address(self.timers.now(), address);
    }
}
