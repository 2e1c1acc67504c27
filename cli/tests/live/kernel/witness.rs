//! Somebody who only looks on.

use link_core::machine::Deadline;
use link_core::{Frame, Input, LinkEvent, Port as _};
use transport_socketcan::SocketCanPort;

use super::process::PATIENCE;

/// A socket that hears everything on an interface, from now on.
pub(crate) struct Witness(SocketCanPort);

impl Witness {
    pub(crate) fn on(bus: &str) -> Self {
        Self(SocketCanPort::open_listen_only(bus).unwrap())
    }

    /// Waits until it has seen enough.
    #[track_caller]
    pub(crate) fn until(&mut self, what: &str, mut is_enough: impl FnMut(&Frame) -> bool) {
        let deadline = Deadline { at: self.0.now() + PATIENCE, why: "the test" };
        loop {
            match self.0.wait(Some(deadline)).unwrap() {
                (_, Input::Frame(frame)) if is_enough(&frame) => return,
                (now, _) if now >= deadline.at => panic!("not seen: {what}"),
                (_, Input::Link(LinkEvent::Overrun { lost })) => panic!("{lost:?} frames were not seen"),
                _ => {}
            }
        }
    }
}
