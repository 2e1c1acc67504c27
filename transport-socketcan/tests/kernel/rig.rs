//! Ports on interfaces of a test's own, and what is waited for on them.

use std::time::Duration;

use link_core::machine::Deadline;
use link_core::{ExtendedId, Frame, Input, Instant, LinkEvent, Port, StandardId, TxOutcome, TxToken};
use transport_socketcan::SocketCanPort;

pub(crate) use crate::real_kernel::{Interface, run};

impl Interface {
    /// A port that has heard of the interface being up.
    pub(crate) fn port(&self) -> SocketCanPort {
        let mut port = SocketCanPort::open(self.0).unwrap();
        assert_eq!(input(&mut port), Input::Link(LinkEvent::Up));
        port
    }
}

pub(crate) fn frame(id: u16, data: &[u8]) -> Frame {
    Frame::new(StandardId::new(id).unwrap(), data).unwrap()
}

pub(crate) fn extended(id: u32, data: &[u8]) -> Frame {
    Frame::new(ExtendedId::new(id).unwrap(), data).unwrap()
}

/// The next input with its moment; a test that waits for ten seconds has failed.
pub(crate) fn timed_input(port: &mut SocketCanPort) -> (Instant, Input) {
    let (at, input) = wait(port, Duration::from_secs(10));
    assert_ne!(input, Input::Tick, "nothing came");
    (at, input)
}

pub(crate) fn input(port: &mut SocketCanPort) -> Input {
    timed_input(port).1
}

/// What comes within the span, or a tick.
pub(crate) fn wait(port: &mut SocketCanPort, span: Duration) -> (Instant, Input) {
    let at = port.now() + span;
    port.wait(Some(Deadline { at, why: "the test" })).unwrap()
}

/// Nothing comes for a while.
pub(crate) fn silent(port: &mut SocketCanPort) {
    assert_eq!(wait(port, Duration::from_millis(50)).1, Input::Tick);
}

pub(crate) const fn sent(token: u16) -> Input {
    Input::TxDone(TxToken(token), TxOutcome::Sent)
}

pub(crate) const fn dropped(token: u16) -> Input {
    Input::TxDone(TxToken(token), TxOutcome::Dropped)
}
