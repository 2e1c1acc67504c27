//! The short way of Get_Attribute_Single answers as the way of all requests.

use cip_core::message::AllocationChoice;
use cip_core::object::Identity;
use link_core::Machine;

use super::bus::*;
use crate::slave::{Application, IoKind, Parts};

/// The same device without the short way.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
struct Slow(Block);

impl Application for Slow {
    const IO: AllocationChoice = Block::IO;
    const PARTS: Parts = Parts::all().difference(Parts::FAST_WAYS);
    type Long = ();

    fn identity(&self) -> Identity<'_> {
        self.0.identity()
    }

    fn produced(&self, connection: IoKind) -> &[u8] {
        self.0.produced(connection)
    }

    fn consumed(&mut self, connection: IoKind) -> &mut [u8] {
        self.0.consumed(connection)
    }
}

/// Two slaves that must not be told apart.
struct Pair {
    fast: Bus<Block, 0>,
    slow: Bus<Slow, 0>,
}

impl Pair {
    fn allocated(choice: u8) -> Self {
        let fast = Bus::online(config(), block()).allocated(choice);
        let slow = Bus::online(config(), Slow(block())).allocated(choice);
        Self { fast, slow }
    }

    #[track_caller]
    fn hear(&mut self, id: u16, data: &[u8]) {
        self.fast.hears(id, data);
        self.slow.hears(id, data);
        self.agree(data);
    }

    fn wait(&mut self, millis: u64) {
        self.fast.wait(millis);
        self.slow.wait(millis);
        self.agree(&[]);
    }

    #[track_caller]
    fn agree(&mut self, after: &[u8]) {
        assert_eq!(self.fast.take_transmits(), self.slow.take_transmits(), "{after:02X?}");
        assert_eq!(self.fast.events, self.slow.events, "{after:02X?}");
        assert_eq!(self.fast.slave.counters(), self.slow.slave.counters(), "{after:02X?}");
        assert_eq!(self.fast.slave.deadline(), self.slow.slave.deadline(), "{after:02X?}");
    }

    /// Every attribute of every object, with every header that differs in kind.
    fn ask_everything(&mut self) {
        for header in [MASTER, MASTER | 0x40, MASTER | 0x80, MASTER + 1] {
            for class in 0..=6 {
                for instance in 0..=6 {
                    for attribute in 0..=20 {
                        self.wait(1);
                        self.hear(REQUEST, &[header, 0x0E, class, instance, attribute]);
                    }
                    self.hear(REQUEST, &[header, 0x0E, class, instance]);
                    self.hear(REQUEST, &[header, 0x0E, class, instance, 1, 0]);
                }
            }
        }
    }
}

#[test]
fn every_get_is_answered_as_without_the_short_way() {
    Pair::allocated(0x01).ask_everything();
    let mut pair = Pair::allocated(0x03);
    pair.ask_everything();
    pair.hear(REQUEST, &[MASTER, 0x10, 0x05, 0x02, 0x09, 0x4B, 0x00]);
    pair.ask_everything();
}

/// The explicit connection ends 10 s after the last message, whichever way it went.
#[test]
fn the_short_way_keeps_the_connection_alive() {
    let mut pair = Pair::allocated(0x01);
    for _ in 0..3 {
        pair.wait(9_999);
        pair.hear(REQUEST, &[MASTER, 0x0E, 0x01, 0x01, 0x01]);
    }
    pair.wait(10_000);
    pair.hear(REQUEST, &[MASTER, 0x0E, 0x01, 0x01, 0x01]);
    assert_eq!(pair.fast.slave.counters().ignored, 1);
}

/// A response in fragments is given up for a new request, and one that is not sent yet is replaced.
#[test]
fn a_short_request_while_something_is_in_progress() {
    let mut pair = Pair::allocated(0x01);
    pair.hear(REQUEST, &[MASTER, 0x0E, 0x01, 0x01, 0x07]);
    pair.hear(REQUEST, &[MASTER, 0x0E, 0x01, 0x01, 0x01]);
    (pair.fast.acknowledging, pair.slow.acknowledging) = (false, false);
    for attribute in 1..=3 {
        pair.hear(REQUEST, &[MASTER, 0x0E, 0x01, 0x01, attribute]);
    }
    // The first fragment of a request.
    pair.hear(REQUEST, &[MASTER | 0x80, 0x00, 0x0E, 0x01, 0x01, 0x01]);
    pair.hear(REQUEST, &[MASTER, 0x0E, 0x01, 0x01, 0x02]);
    pair.hear(POLL, &[0x01]);
    pair.wait(5_000);
}
