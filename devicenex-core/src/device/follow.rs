//! What follows from an input before anything is sent: on line or off, departures, outputs at rest.

use cip_core::connection::{ExplicitCause, IoCause};
use link_core::Instant;

use super::application::Application;
use super::machine::Device;
use super::slot::{Body, Slot};
use crate::access::StateKind;

impl<A: Application, const MESSAGE: usize, const CONNECTIONS: usize> Device<A, MESSAGE, CONNECTIONS> {
    /// What follows from an input before anything is sent.
    pub(super) fn follow(&mut self, now: Instant) {
        self.follow_access(now);
        if self.departure.is_some() {
            self.follow_departure(now);
            self.follow_access(now);
        }
        self.slots.iter_mut().filter(|slot| slot.is_done()).for_each(Slot::free);
        self.follow_modes();
    }

    fn follow_access(&mut self, now: Instant) {
        if self.online != self.access.is_online() {
            self.online = self.access.is_online();
            if self.online { self.filter_changed = true } else { self.go_offline(now) }
        }
    }

    /// All connections are gone **\[D\]**: their identifiers have the address in them.
    fn go_offline(&mut self, now: Instant) {
        let dropped = matches!(self.access.state().kind(), StateKind::NonExistent | StateKind::BusOff);
        for place in 0..CONNECTIONS {
            let Some(slot) = self.slots.get_mut(place) else { return };
            if let Body::Explicit(explicit) = &mut slot.body {
                explicit.transfer.clear(&mut slot.timers);
            }
            slot.line.abandon(dropped);
            // One of them is it; the other changes nothing.
            let _ = self.io_step(place, IoCause::NetworkLost);
            let _ = self.explicit_step(place, ExplicitCause::NetworkLost);
        }
        self.port.pipe.clear(&mut self.port.timers);
        self.port.line.abandon(dropped);
        self.answers.clear();
        self.answering.0.abandon(dropped);
        // Network access has its own.
        self.filter_changed = false;
        // What was accepted is carried out all the same.
        self.leave(now);
    }

    /// Puts outputs to rest.
    fn follow_modes(&mut self) {
        for slot in &mut self.slots {
            if core::mem::take(&mut slot.news.rest)
                && let Some((connection, mode)) = slot.news.mode
            {
                self.application.rest(connection, mode);
            }
        }
    }
}
