//! Leaving an address on purpose: Reset, and another operational address. The response goes out first.

use cip_core::message::ResetType;
use link_core::Instant;

use super::application::Application;
use super::event::{DeviceEvent, Ignored};
use super::machine::Device;
use super::slot::Body;
use crate::id::OperationalAddress;

/// What follows when the response has been sent.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) struct Departure {
    pub(super) why: Why,
    /// The connection that carries the response.
    pub(super) place: usize,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Why {
    Reset(ResetType),
    Address(OperationalAddress),
}

impl<A: Application, const MESSAGE: usize, const CONNECTIONS: usize> Device<A, MESSAGE, CONNECTIONS> {
    /// A node that is about to leave serves nobody: the response that is on its way is the last.
    pub(super) const fn check_departure(&self) -> Result<(), Ignored> {
        if self.departure.is_some() { Err(Ignored::Leaving) } else { Ok(()) }
    }

    /// Goes on if the response has been sent, or never will be.
    pub(super) fn follow_departure(&mut self, now: Instant) {
        let Some(departure) = &self.departure else { return };
        let is_sent = match self.slots.get(departure.place).map(|slot| &slot.body) {
            Some(Body::Explicit(explicit)) => explicit.transfer.is_quiet(),
            Some(Body::Free | Body::Io(_)) | None => true,
        };
        if is_sent {
            self.leave(now);
        }
    }

    pub(super) fn leave(&mut self, now: Instant) {
        match self.departure.take() {
            Some(Departure { why: Why::Address(address), .. }) => self.access.set_address(now, address),
            Some(Departure { why: Why::Reset(kind), .. }) => {
                self.start_anew(now);
                self.raise(DeviceEvent::Reset(kind));
            }
            None => {}
        }
    }

    /// Starts anew, as after a power cycle.
    pub fn reset(&mut self, now: Instant) {
        let now = self.advance(now);
        self.start_anew(now);
        self.follow(now);
    }

    /// Says Hello with another address, as an operator's command; over the network the link object does it.
    pub fn set_address(&mut self, now: Instant, address: OperationalAddress) {
        let now = self.advance(now);
        self.access.set_address(now, address);
        self.follow(now);
    }

    fn start_anew(&mut self, now: Instant) {
        self.acknowledge = self.settings.acknowledge;
        self.access.reset(now);
    }
}
