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
        match self.access().state().kind() {
            // It was given one that it has to give away itself.
            StateKind::Online if self.place(self.own()).is_some() => self.rejoin(),
            StateKind::Standby if self.timers.at(Timer::Rejoin).is_some() => {}
            StateKind::Standby => self.timers.set_after_millis(Timer::Rejoin, wait),
            StateKind::NonExistent
            | StateKind::DetectingBitRate
            | StateKind::Hello1
            | StateKind::Hello2
            | StateKind::Online
            | StateKind::BusOff
            | StateKind::Faulted => self.timers.clear(Timer::Rejoin),
        }
    }

    /// Says Hello with the address that it was configured with, or with the next one that is free, as far as it knows. If
    /// somebody has that too, the answer to the Hello says so.
    pub(super) fn rejoin(&mut self) {
        let first = self.config.node.access.first_address();
        let next = match self.tried {
            None => Some(first),
            Some(last) => {
                let after = OperationalAddress::all().filter(|address| *address > last);
                let before = OperationalAddress::all().filter(|address| *address <= last);
                after.chain(before).find(|&address| self.is_free(address))
            }
        };
        let Some(address) = next else { return };
        self.tried = Some(address);
        self.raise(ManagerEvent::Rejoins(address));
        self.node.set_address(self.timers.now(), address);
    }
}
