//! Whether there is an interface: it goes down, is unplugged, and comes back.

use core::time::Duration;
use std::io;

use link_core::LinkEvent;

use super::{Link, State};
use crate::error::Error;
use crate::interface::Interface;
use crate::socket::Socket;

impl Link {
    pub(super) fn go_down(&mut self) {
        self.take_the_rest();
        self.state = State::Down(self.now().saturating_add(LOOK_AGAIN_AFTER));
        (self.retry_at, self.restart_due) = (None, None);
        // What an interface without an echo has taken is sent already.
        self.answer();
        self.outbox.drop_all();
        self.tell(LinkEvent::Down);
    }

    /// Takes up work on an interface that is up.
    pub(super) fn begin(&mut self) {
        self.restart_is_told = false;
        let is_off = self.interface.is_bus_off();
        self.state = if is_off { State::BusOff } else { State::Up };
        self.tell(if is_off { LinkEvent::BusOff } else { LinkEvent::Up });
    }

    /// Whether the interface is there and up, so that the port works again.
    pub(super) fn look_for_the_interface(&mut self) -> Result<bool, Error> {
        let now = self.now();
        self.state = State::Down(now.saturating_add(LOOK_AGAIN_AFTER));
        if !self.interface.is_up() || self.renew().is_err() {
            return Ok(false);
        }
        self.begin();
        Ok(true)
    }

    /// Begins with a new socket: an interface that was unplugged comes back with another index, and one that went down has
    /// left an error in the old one.
    pub(super) fn renew(&mut self) -> Result<(), Error> {
        let has_echo = self.interface.has_echo();
        let socket = open(&self.interface, has_echo)?;
        if let Some(filters) = &self.filters {
            socket
                .set_filters(filters, &[])
                .map_err(|source| self.failed("cannot set the acceptance filter", source))?;
        }
        (self.socket, self.has_echo) = (socket, has_echo);
        self.generation = self.generation.wrapping_add(1);
        self.lost = 0;
        self.sent.clear();
        self.more = true;
        Ok(())
    }
}

/// A socket on an interface.
pub(super) fn open(interface: &Interface, has_echo: bool) -> Result<Socket, Error> {
    let name = || interface.name().to_owned();
    let Some(index) = interface.index() else {
        return Err(Error::NoInterface { name: name(), present: Interface::names() });
    };
    Socket::open(index, has_echo).map_err(|(what, source)| match source.raw_os_error() {
        Some(libc::EAFNOSUPPORT | libc::EPROTONOSUPPORT) => Error::NoSocketCan,
        _ => Error::Socket { name: name(), what, source },
    })
}

/// Down or unplugged.
pub(super) fn is_gone(error: &io::Error) -> bool {
    matches!(error.raw_os_error(), Some(libc::ENETDOWN | libc::ENODEV | libc::ENXIO))
}

/// How often an interface that is down is looked at.
const LOOK_AGAIN_AFTER: Duration = Duration::from_millis(100);
