//! The UCMM: open, close, every error, all groups and body formats (CIP Vol. 3). Client 2, server 63.

use super::bus::{Bus, MASTER, REQUEST, RESPONSE, UNCONNECTED, Ucmm, config, everything};
use crate::access::NetworkStatus;
use crate::slave::{Options, SlaveEvent};

/// UCMM requests of client 2, responses of server 63.
const ASK: u16 = 0x782;
const ANSWER: u16 = 0x77F;

impl Ucmm {
    #[track_caller]
    fn ucmm(&mut self, request: &[u8], response: &[u8]) {
        self.hears(ASK, &[&[0x3F], request].concat());
        self.sends(ANSWER, &[&[0x02], response].concat());
    }
}

/// The worked example of CIP Vol. 3 with this server: instance 6, Message ID 0.
#[test]
fn open_use_and_close() {
    let mut bus = Ucmm::ucmm_server();
    bus.ucmm(&[0x4B, 0x00, 0x31], &[0xCB, 0x00, 0x00, 0x06, 0x00]);
    bus.tells(SlaveEvent::NetworkStatus(NetworkStatus::SolidGreen));
    bus.hears(0x642, &[0x3F, 0x0E, 0x01, 0x01, 0x01]);
    bus.sends(0x63F, &[0x02, 0x8E, 0xE7, 0x03]);
    bus.hears(0x642, &[0x7F, 0x0E, 0x05, 0x06, 0x04]);
    bus.sends(0x63F, &[0x42, 0x8E, 0x3F, 0x06]);
    bus.hears(0x642, &[0x3F, 0x0E, 0x05, 0x06, 0x05]);
    bus.sends(0x63F, &[0x02, 0x8E, 0x42, 0x06]);
    bus.hears(0x642, &[0x3F, 0x0E, 0x05, 0x06, 0x06]);
    bus.sends(0x63F, &[0x02, 0x8E, 0x33]);
    // For another server.
    bus.hears(0x642, &[0x02, 0x0E, 0x01, 0x01, 0x01]);
    bus.sends_nothing();
    bus.ucmm(&[0x4C, 0x06, 0x00], &[0xCC]);
    bus.hears(0x642, &[0x3F, 0x0E, 0x01, 0x01, 0x01]);
    bus.sends_nothing();
    bus.tells(SlaveEvent::NetworkStatus(NetworkStatus::FlashingGreen));
}

#[test]
fn every_error() {
    let mut bus = Ucmm::ucmm_server();
    for ignored in [&[][..], &[0x3F], &[0xBF, 0x4B, 0, 0x31], &[0x3F, 0xCB, 0, 0x31], &[0x3E, 0x4B, 0, 0x31]]
    {
        bus.hears(ASK, ignored);
        bus.sends_nothing();
    }
    bus.ucmm(&[0x0E, 1, 1], &[0x94, 0x08, 0xFF]);
    bus.ucmm(&[0x4B], &[0x94, 0x13, 0xFF]);
    bus.ucmm(&[0x4B, 0], &[0x94, 0x13, 0xFF]);
    bus.ucmm(&[0x4C, 6], &[0x94, 0x13, 0xFF]);
    bus.ucmm(&[0x4B, 0, 0x31, 0], &[0x94, 0x15, 0xFF]);
    for select in [0x20, 0x40, 0xE0, 0x35, 0x3F] {
        bus.ucmm(&[0x4B, 0, select], &[0x94, 0x20, 0xFF]);
    }
    bus.ucmm(&[0x4C, 6, 0], &[0x94, 0x16, 0xFF]);
    bus.ucmm(&[0x4C, 1, 0], &[0x94, 0x16, 0xFF]);
    bus.ucmm(&[0x4C, 0xFF, 0xFF], &[0x94, 0x16, 0xFF]);
    let mut bus = bus.allocated(0x03);
    bus.ucmm(&[0x4C, 1, 0], &[0x94, 0x0C, 0xFF]);
    bus.ucmm(&[0x4C, 2, 0], &[0x94, 0x0C, 0xFF]);
    bus.ucmm(&[0x4C, 3, 0], &[0x94, 0x16, 0xFF]);
    // Three connections are all there are.
    for (id, instance) in [(0, 6), (1, 7), (2, 8)] {
        bus.ucmm(&[0x4B, 0, 0x30 | id], &[0xCB, 0, id, instance, 0]);
    }
    bus.ucmm(&[0x4B, 0, 0x33], &[0x94, 0x02, 0xFF]);
    // Nobody else closes them.
    bus.hears(0x785, &[0x3F, 0x4C, 7, 0]);
    bus.sends(ANSWER, &[0x05, 0x94, 0x0C, 0xFF]);
    bus.ucmm(&[0x4C, 7, 0], &[0xCC]);
    bus.ucmm(&[0x4B, 0, 0x33], &[0xCB, 0, 1, 7, 0]);
}

#[test]
fn others_may_close_where_that_is_allowed() {
    let mut config = config();
    config.options.remove(Options::CLOSE_BY_OWNER_ONLY | Options::UNCONNECTED_PORT);
    let mut bus: Ucmm = Bus::online(config, everything());
    bus.ucmm(&[0x4B, 0, 0x31], &[0xCB, 0, 0, 6, 0]);
    bus.hears(0x785, &[0x3F, 0x4C, 6, 0]);
    bus.sends(ANSWER, &[0x05, 0xCC]);
    bus.hears(UNCONNECTED, &[4, 0x4B, 3, 1, 1, 4]);
    bus.sends_nothing();
}

#[test]
fn node_ping() {
    let mut bus = Ucmm::ucmm_server();
    bus.ucmm(&[0x4B, 0, 0xF0], &[0xCB, 0, 0, 0, 0]);
    assert!(!bus.slave.node.is_any_open());
}

/// Groups 1 and 2: where requests and responses are, and whose MAC ID the headers carry.
#[test]
fn the_other_groups() {
    let mut bus = Ucmm::ucmm_server();
    bus.ucmm(&[0x4B, 0, 0x05], &[0xCB, 0, 0x00, 6, 0]);
    bus.hears(0x142, &[0x3F, 0x0E, 1, 1, 1]);
    bus.sends(0x03F, &[0x02, 0x8E, 0xE7, 0x03]);
    bus.hears(0x142, &[0x3F, 0x0E, 5, 6, 6]);
    bus.sends(0x03F, &[0x02, 0x8E, 0x00]);
    bus.ucmm(&[0x4B, 0, 0x10], &[0xCB, 0, 0x01, 7, 0]);
    bus.hears(0x5F8, &[0x02, 0x0E, 1, 1, 1]);
    bus.sends(0x5F9, &[0x02, 0x8E, 0xE7, 0x03]);
    bus.hears(0x5F8, &[0x3F, 0x0E, 1, 1, 1]);
    bus.sends_nothing();
    // The predefined set takes what it needs of group 2: poll 5, explicit 3 and 4.
    let mut bus = bus.allocated(0x03);
    bus.ucmm(&[0x4B, 0, 0x10], &[0x94, 0x02, 0x01]);
    bus.hears(REQUEST, &[MASTER, 0x0E, 1, 1, 1]);
    bus.sends(RESPONSE, &[MASTER, 0x8E, 0xE7, 0x03]);
}

#[test]
fn group_2_identifiers_that_are_taken_cannot_be_allocated() {
    let mut bus = Ucmm::ucmm_server();
    for (messages, instance) in [(0x01, 6), (0x23, 7), (0x45, 8)] {
        bus.ucmm(&[0x4B, 0, 0x10], &[0xCB, 0, messages, instance, 0]);
    }
    bus.asks_unconnected(4, &[0x4B, 3, 1, 1, 4], &[0x94, 0x02, 0x04]);
    assert_eq!(bus.allocation(), (0, None));
    bus.ucmm(&[0x4C, 7, 0], &[0xCC]);
    bus.ucmm(&[0x4C, 8, 0], &[0xCC]);
    bus.asks_unconnected(4, &[0x4B, 3, 1, 3, 4], &[0xCB, 0]);
}

#[test]
fn body_formats() {
    for (format, request) in [
        (0, &[0x0E, 1, 1, 1][..]),
        (1, &[0x0E, 1, 1, 0, 1]),
        (2, &[0x0E, 1, 0, 1, 0, 1]),
        (3, &[0x0E, 1, 0, 1, 1]),
    ] {
        let mut bus = Ucmm::ucmm_server();
        bus.ucmm(&[0x4B, format, 0x31], &[0xCB, format, 0, 6, 0]);
        bus.hears(0x642, &[&[0x3F], request].concat());
        bus.sends(0x63F, &[0x02, 0x8E, 0xE7, 0x03]);
    }
    let mut bus = Ucmm::ucmm_server();
    bus.ucmm(&[0x4B, 4, 0x31], &[0xCB, 4, 0, 6, 0]);
    bus.hears(0x642, &[0xBF, 0x00, 0x0E, 0x03, 0x20, 0x01, 0x24, 0x01]);
    bus.sends(0x63F, &[0x82, 0xC0, 0]);
    bus.hears(0x642, &[0xBF, 0x81, 0x30, 0x01]);
    bus.sends(0x63F, &[0x82, 0xC1, 0]);
    bus.sends(0x63F, &[0x02, 0x8E, 0xE7, 0x03]);
    bus.hears(0x642, &[0x3F, 0x0E, 0x01, 0x20, 0x64]);
    bus.sends(0x63F, &[0x02, 0x94, 0x16, 0xFF]);
    bus.hears(0x642, &[0x3F, 0x0E, 0x01, 0xFF, 0xFF]);
    bus.sends(0x63F, &[0x02, 0x94, 0x04, 0xFF]);
    // A reserved one.
    bus.ucmm(&[0x4B, 0x09, 0x32], &[0xCB, 0, 1, 7, 0]);
}

/// As an IAI controller does it: open with 16/16, allocate poll through it, set the packet rate, close, poll.
#[test]
fn allocation_through_an_opened_connection() {
    let mut bus = Ucmm::ucmm_server();
    bus.ucmm(&[0x4B, 2, 0x31], &[0xCB, 2, 0, 6, 0]);
    bus.hears(0x642, &[0x3F, 0x4B, 3, 0, 1, 0, 0x02, 2]);
    bus.sends(0x63F, &[0x02, 0xCB, 0x02]);
    assert_eq!(bus.allocation(), (0x02, Some(2)));
    let mut left = bus.clone();
    bus.hears(0x642, &[0xBF, 0x00, 0x10, 5, 0, 2, 0, 9]);
    bus.sends(0x63F, &[0x82, 0xC0, 0]);
    bus.hears(0x642, &[0xBF, 0x81, 100, 0]);
    bus.sends(0x63F, &[0x82, 0xC1, 0]);
    bus.sends(0x63F, &[0x02, 0x90, 100, 0]);
    bus.ucmm(&[0x4C, 6, 0], &[0xCC]);
    assert_eq!(bus.allocation(), (0x02, Some(2)));
    bus.hears(super::bus::POLL, &[1]);
    bus.sends(super::bus::POLL_RESPONSE, &[0x34, 0x12]);
    // What is still being configured goes with the connection.
    left.ucmm(&[0x4C, 6, 0], &[0xCC]);
    assert_eq!(left.allocation(), (0, None));
}

#[test]
fn connections_time_out_one_by_one() {
    let mut bus = Ucmm::ucmm_server();
    bus.ucmm(&[0x4B, 0, 0x31], &[0xCB, 0, 0, 6, 0]);
    bus.wait(1);
    bus.ucmm(&[0x4B, 0, 0x32], &[0xCB, 0, 1, 7, 0]);
    bus.wait(9998);
    assert!(bus.slave.node.is_open(0));
    bus.wait(1);
    assert!(!bus.slave.node.is_open(0) && bus.slave.node.is_open(1));
    bus.hears(0x682, &[0x3F, 0x10, 5, 7, 9, 0, 0]);
    bus.sends(0x67F, &[0x02, 0x90, 0, 0]);
    bus.wait(1_000_000);
    assert!(bus.slave.node.is_open(1));
}

/// Attribute 18 counts there as well: 2500 ms times 8.
#[test]
fn a_timeout_multiplier() {
    let mut bus = Ucmm::ucmm_server();
    bus.ucmm(&[0x4B, 0x00, 0x31], &[0xCB, 0x00, 0x00, 0x06, 0x00]);
    bus.hears(0x642, &[0x3F, 0x10, 0x05, 0x06, 18, 1]);
    bus.sends(0x63F, &[0x02, 0x90]);
    bus.hears(0x642, &[0x3F, 0x0E, 0x01, 0x01, 0x01]);
    bus.sends(0x63F, &[0x02, 0x8E, 0xE7, 0x03]);
    bus.wait(19_999);
    assert!(bus.slave.node.is_any_open());
    bus.wait(1);
    assert!(!bus.slave.node.is_any_open());
}

/// A client that has restarted opens with the Message ID that it has used before.
#[test]
fn a_forgotten_connection_makes_way() {
    let mut bus = Ucmm::ucmm_server();
    for _ in 0..5 {
        bus.ucmm(&[0x4B, 0, 0x31], &[0xCB, 0, 0, 6, 0]);
    }
}

/// The name in fragments to two clients at once.
#[test]
fn two_clients() {
    let mut bus = Ucmm::ucmm_server();
    bus.ucmm(&[0x4B, 0, 0x31], &[0xCB, 0, 0, 6, 0]);
    bus.hears(0x785, &[0x3F, 0x4B, 0, 0x31]);
    bus.sends(ANSWER, &[0x05, 0xCB, 0, 1, 7, 0]);
    bus.hears(0x642, &[0x3F, 0x0E, 1, 1, 7]);
    bus.sends(0x63F, &[0x82, 0x00, 0x8E, 18, b'E', b'x', b'a', b'm']);
    bus.hears(0x645, &[0x3F, 0x0E, 1, 1, 7]);
    bus.sends(0x67F, &[0x85, 0x00, 0x8E, 18, b'E', b'x', b'a', b'm']);
    bus.hears(0x642, &[0xBF, 0xC0, 0]);
    bus.sends(0x63F, &[0x82, 0x41, b'p', b'l', b'e', b' ', b'B', b'l']);
    bus.hears(0x645, &[0xBF, 0xC0, 0]);
    bus.sends(0x67F, &[0x85, 0x41, b'p', b'l', b'e', b' ', b'B', b'l']);
    bus.wait(1000);
    bus.sends(0x63F, &[0x82, 0x41, b'p', b'l', b'e', b' ', b'B', b'l']);
    bus.sends(0x67F, &[0x85, 0x41, b'p', b'l', b'e', b' ', b'B', b'l']);
    bus.wait(1000);
    bus.tells(SlaveEvent::ResponseAbandoned { instance: 6 });
    bus.tells(SlaveEvent::ResponseAbandoned { instance: 7 });
}
