//! Ports at the ends of a test's own cable, and what is waited for on them.

use std::time::Duration;

use link_core::ethernet::{Input, LinkEvent, MacAddress, Port as _};
use link_core::machine::Deadline;
use transport_ethernet::{EthernetPort, Options};

pub(crate) use crate::namespace::Cable;

/// IEEE 802, local experimental EtherType 1.
pub(crate) const ETHERTYPE: u16 = 0x88B5;
pub(crate) const GROUP: MacAddress = MacAddress([0x03, 0, 0, 0, 0, 0x42]);

/// A copy of an input.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) enum Heard {
    Frame(Vec<u8>),
    Link(LinkEvent),
    Nothing,
}

pub(crate) const OPTIONS: Options<'static> =
    Options { ethertype: ETHERTYPE, groups: &[GROUP], answer_within: None };

/// A port that has heard of the link being up.
pub(crate) fn port(name: &str, options: Options<'_>) -> EthernetPort {
    let mut port = EthernetPort::open(name, options).unwrap();
    assert_eq!(heard(&mut port), Heard::Link(LinkEvent::Up));
    port
}

pub(crate) fn frame(payload: &[u8]) -> Vec<u8> {
    frame_of(ETHERTYPE, payload)
}

pub(crate) fn frame_of(ethertype: u16, payload: &[u8]) -> Vec<u8> {
    [&GROUP.0[..], &[0x02, 0, 0, 0, 0, 0x01], &ethertype.to_be_bytes(), payload].concat()
}

/// What comes within the span.
pub(crate) fn wait(port: &mut EthernetPort, span: Duration) -> Heard {
    let at = port.now() + span;
    match port.wait(Some(Deadline { at, why: "the test" })).unwrap().1 {
        Input::Frame(bytes) => Heard::Frame(bytes.to_vec()),
        Input::Link(event) => Heard::Link(event),
        Input::Tick => Heard::Nothing,
    }
}

/// What comes next; a test that waits for twenty seconds has failed.
#[track_caller]
pub(crate) fn heard(port: &mut EthernetPort) -> Heard {
    let heard = wait(port, Duration::from_secs(20));
    assert_ne!(heard, Heard::Nothing, "nothing came");
    heard
}

/// Nothing has come.
#[track_caller]
pub(crate) fn silent(port: &mut EthernetPort) {
    assert_eq!(wait(port, Duration::ZERO), Heard::Nothing);
}
