//! Interfaces of a test's own, and what is waited for on them.

use std::process::Command;
use std::time::Duration;

use link_core::machine::Deadline;
use link_core::{ExtendedId, Frame, Input, Instant, LinkEvent, Port, StandardId, TxOutcome, TxToken};
use transport_socketcan::SocketCanPort;

/// A virtual interface that is gone at the end.
pub(crate) struct Interface(pub(crate) &'static str);

impl Interface {
    pub(crate) fn new(name: &'static str) -> Self {
        let interface = Self(name);
        interface.plug();
        interface
    }

    pub(crate) fn plug(&self) {
        ip(&["link", "add", self.0, "type", "vcan"]);
        self.set("up");
    }

    pub(crate) fn unplug(&self) {
        ip(&["link", "delete", self.0]);
    }

    pub(crate) fn set(&self, what: &str) {
        ip(&["link", "set", self.0, what]);
    }

    /// A port that has heard of the interface being up.
    pub(crate) fn port(&self) -> SocketCanPort {
        let mut port = SocketCanPort::open(self.0).unwrap();
        assert_eq!(input(&mut port), Input::Link(LinkEvent::Up));
        port
    }
}

impl Drop for Interface {
    fn drop(&mut self) {
        let _ = Command::new("ip").args(["link", "delete", self.0]).output();
    }
}

pub(crate) fn ip(arguments: &[&str]) {
    run("ip", arguments);
}

pub(crate) fn run(program: &str, arguments: &[&str]) {
    let output = Command::new(program).args(arguments).output().unwrap();
    assert!(output.status.success(), "{program} {arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
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
