//! Allocate and Release: each check in its order, ownership, takeover (CIP Vol. 3, DeviceNet object).

use super::bus::{
    Bus, Full, G2o, MASTER, POLL, POLL_RESPONSE, REQUEST, RESPONSE, UNCONNECTED, block, config,
};
use crate::slave::{Ignored, Options, SlaveEvent};

const CONFLICT: [u8; 3] = [0x94, 0x0C, 0x01];
const INVALID: [u8; 3] = [0x94, 0x09, 0x02];
const NOT_OFFERED: [u8; 3] = [0x94, 0x02, 0x02];
const ALREADY: [u8; 3] = [0x94, 0x0B, 0x02];
const GRANTED: [u8; 2] = [0xCB, 0x00];
const RELEASED: [u8; 1] = [0xCC];

impl<A: crate::slave::Application, const DYNAMIC: usize> Bus<A, DYNAMIC> {
    #[track_caller]
    fn allocates(&mut self, choice: u8, master: u8, response: &[u8]) {
        self.asks_unconnected(master & 0x3F, &[0x4B, 3, 1, choice, master], response);
    }

    #[track_caller]
    fn releases(&mut self, choice: u8, master: u8, response: &[u8]) {
        self.asks_unconnected(master, &[0x4C, 3, 1, choice], response);
    }
}

#[test]
fn every_check_of_allocate() {
    let mut bus = G2o::g2o();
    bus.asks_unconnected(4, &[0x4B, 3, 1], &[0x94, 0x13, 0xFF]);
    bus.asks_unconnected(4, &[0x4B, 3, 1, 1], &[0x94, 0x13, 0xFF]);
    bus.asks_unconnected(4, &[0x4B, 3, 1, 1, 4, 0], &[0x94, 0x15, 0xFF]);
    bus.allocates(0x00, 4, &INVALID);
    bus.allocates(0x41, 4, &INVALID);
    bus.allocates(0x05, 4, &NOT_OFFERED);
    bus.allocates(0x02, 4, &INVALID);
    bus.allocates(0x81, 4, &INVALID);
    bus.allocates(0x01, 0x44, &INVALID);
    bus.allocates(0x01, 0xC4, &INVALID);
    assert_eq!(bus.allocation(), (0, None));
    bus.allocates(0x01, 4, &GRANTED);
    bus.allocates(0x01, 4, &ALREADY);
    bus.allocates(0x01, 5, &CONFLICT);
    bus.allocates(0x00, 5, &CONFLICT);
    bus.allocates(0x02, 4, &GRANTED);
    bus.allocates(0x02, 4, &ALREADY);
    assert_eq!(bus.allocation(), (0x03, Some(4)));
}

#[test]
fn checks_that_need_more_connections() {
    let mut bus = Full::full();
    bus.allocates(0x31, 4, &INVALID);
    bus.allocates(0x11, 4, &GRANTED);
    bus.allocates(0x20, 4, &ALREADY);
    bus.allocates(0x10, 4, &ALREADY);
    bus.allocates(0x40, 4, &INVALID);
    assert_eq!(bus.allocation(), (0x11, Some(4)));
    bus.releases(0x20, 4, &ALREADY);
    bus.releases(0x11, 4, &RELEASED);
    assert_eq!(bus.allocation(), (0, None));
}

/// The first condition that holds gives the answer.
#[test]
fn the_order_of_the_checks() {
    let mut bus = Full::full().allocated(0x11);
    for (choice, allocator, response) in [
        (0x00, 5, CONFLICT), // 1 before 2
        (0x40, 5, CONFLICT), // 1 before 3
        (0x51, 4, ALREADY),  // 6 of explicit
        (0xB0, 4, ALREADY),  // 6 before 7 and 8
        (0x80, 4, INVALID),  // 8
    ] {
        bus.allocates(choice, allocator, &response);
    }
    let mut bus = G2o::g2o();
    bus.allocates(0x44, 4, &INVALID); // 3 before 4
    bus.allocates(0x84, 4, &NOT_OFFERED); // 4 before 5 and 8
    bus.allocates(0x44, 0xFF, &INVALID);
}

#[test]
fn an_unsupported_choice_allocates_nothing() {
    let mut bus = G2o::g2o();
    bus.allocates(0x07, 4, &NOT_OFFERED);
    assert_eq!(bus.allocation(), (0, None));
    bus.hears(REQUEST, &[4, 0x0E, 1, 1, 1]);
    bus.sends_nothing();
    assert_eq!(
        bus.events,
        [SlaveEvent::Ignored { id: crate::Identifier::new(REQUEST).unwrap(), why: Ignored::NoConnection }]
    );
}

#[test]
fn every_check_of_release() {
    let mut bus = G2o::g2o();
    bus.releases(0x01, 4, &ALREADY);
    let mut bus = bus.allocated(0x03);
    bus.releases(0x03, 5, &CONFLICT);
    bus.releases(0x00, 4, &INVALID);
    bus.releases(0x80, 4, &INVALID);
    bus.releases(0x05, 4, &NOT_OFFERED);
    bus.asks_unconnected(4, &[0x4C, 3, 1], &[0x94, 0x13, 0xFF]);
    bus.asks_unconnected(4, &[0x4C, 3, 1, 1, 4], &[0x94, 0x15, 0xFF]);
    assert_eq!(bus.allocation(), (0x03, Some(4)));
    // Bit 6 is printed by a manual: ICP DAS.
    bus.releases(0x42, 4, &RELEASED);
    assert_eq!(bus.allocation(), (0x01, Some(4)));
    bus.releases(0x03, 4, &ALREADY);
    assert_eq!(bus.allocation(), (0x01, Some(4)), "nothing is released");
    bus.releases(0x01, 4, &RELEASED);
    assert_eq!(bus.allocation(), (0, None));
}

#[test]
fn options_of_allocate_and_release() {
    let mut config = config();
    config.options.remove(Options::RELEASE_IGNORES_BIT_6 | Options::RELEASE_BY_OWNER_ONLY);
    config.options.insert(Options::ALLOCATE_FOR_ONESELF_ONLY);
    let mut bus: G2o = Bus::online(config, block());
    bus.asks_unconnected(5, &[0x4B, 3, 1, 1, 4], &INVALID);
    let mut bus = bus.allocated(0x03);
    bus.releases(0x41, 4, &INVALID);
    bus.releases(0x03, 9, &RELEASED);
    assert_eq!(bus.allocation(), (0, None));
    // By default the header need not be the allocator's.
    let mut bus = G2o::g2o();
    bus.asks_unconnected(5, &[0x4B, 3, 1, 1, 4], &GRANTED);
    assert_eq!(bus.allocation(), (0x01, Some(4)));
}

#[test]
fn the_unconnected_port() {
    let mut bus = G2o::g2o();
    for ignored in [
        &[][..],
        &[4],
        &[0x84, 0x4B, 3, 1, 1, 4],
        &[0x84, 0x00, 0x4B, 3, 1, 1, 4],
        &[4, 0xCB, 3, 1, 1, 4],
        &[4, 0x94, 0x02, 0x03],
        &[4, 0x4B, 3],
        &[4, 0x4B],
    ] {
        bus.hears(UNCONNECTED, ignored);
        bus.sends_nothing();
    }
    assert_eq!(bus.slave.counters().ignored, 8);
    bus.asks_unconnected(4, &[0x0E, 1, 1, 7], &[0x94, 0x02, 0x03]);
    bus.asks_unconnected(4, &[0x0E, 3, 1, 5], &[0x94, 0x02, 0x03]);
    bus.asks_unconnected(4, &[0x4D, 3, 1], &[0x94, 0x02, 0x03]);
    bus.asks_unconnected(4, &[0x4B, 4, 1, 1, 4], &[0x94, 0x16, 0xFF]);
    bus.asks_unconnected(4, &[0x4B, 3, 2, 1, 4], &[0x94, 0x16, 0xFF]);
    bus.asks_unconnected(4, &[0x4B, 3, 0, 1, 4], &[0x94, 0x16, 0xFF]);
    // The XID is copied.
    bus.hears(UNCONNECTED, &[0x44, 0x4B, 3, 1, 1, 4]);
    bus.sends(RESPONSE, &[0x44, 0xCB, 0]);
    assert_eq!(bus.allocation(), (0x01, Some(4)));
    // And it stays open: a second master learns that there is a first.
    bus.allocates(0x01, 5, &CONFLICT);
}

/// Requests in quick succession are processed in their order; one too many is not carried out.
#[test]
fn requests_at_once() {
    let mut bus = G2o::g2o();
    bus.acknowledging = false;
    for request in
        [[4, 0x4B, 3, 1, 1, 4], [5, 0x4B, 3, 1, 1, 5], [4, 0x4B, 3, 1, 2, 4], [4, 0x4B, 3, 1, 2, 4]]
    {
        bus.hears(UNCONNECTED, &request);
    }
    bus.hears(UNCONNECTED, &[4, 0x4C, 3, 1, 3]);
    assert_eq!(bus.allocation(), (0x03, Some(4)), "the Release found no room for its answer");
    bus.tells(SlaveEvent::Ignored { id: crate::Identifier::new(UNCONNECTED).unwrap(), why: Ignored::Busy });
    bus.acknowledging = true;
    bus.done(link_core::TxOutcome::Sent);
    bus.sends(RESPONSE, &[4, 0xCB, 0]);
    bus.sends(RESPONSE, &[5, 0x94, 0x0C, 0x01]);
    bus.sends(RESPONSE, &[4, 0xCB, 0]);
    bus.sends(RESPONSE, &[4, 0x94, 0x0B, 0x02]);
    bus.sends_nothing();
}

#[test]
fn two_messages_only_before_allocation() {
    let mut bus = Full::full();
    for id in (0..0x7F0_u16).filter(|id| *id != UNCONNECTED && *id != super::bus::CHECK) {
        for data in [&[4, 0x0E, 1, 1, 1][..], &[0x3F, 0x0E, 1, 1, 1], &[]] {
            bus.hears(id, data);
        }
    }
    bus.sends_nothing();
    bus.hears(super::bus::CHECK, &[0, 0x34, 0x12, 1, 0, 0, 0]);
    bus.sends(super::bus::CHECK, &[0x80, 0xE7, 0x03, 0x44, 0x33, 0x22, 0x11]);
    bus.allocates(0x01, 4, &GRANTED);
}

#[test]
fn a_foreign_master_is_ignored() {
    let mut bus = G2o::g2o().allocated(0x01);
    bus.hears(REQUEST, &[5, 0x0E, 1, 1, 1]);
    bus.sends_nothing();
    bus.wait(9000);
    bus.hears(REQUEST, &[5, 0x0E, 1, 1, 1]);
    bus.wait(1000);
    assert_eq!(bus.allocation(), (0, None), "nor does it keep the connection alive");
}

/// Ownership stays as long as an I/O connection is established, and ends when all have timed out.
#[test]
fn takeover_after_a_time_out() {
    let mut bus = G2o::g2o().established(0x03, &[2]);
    bus.asks(&[0x4C, 3, 1, 1], &[0xCC]);
    assert_eq!(bus.allocation(), (0x02, Some(MASTER)), "the I/O runs on, and holds the slave");
    bus.hears(POLL, &[1]);
    bus.sends(POLL_RESPONSE, &[0x34, 0x12]);
    bus.hears(REQUEST, &[4, 0x0E, 1, 1, 1]);
    bus.sends_nothing();
    bus.allocates(0x01, 9, &CONFLICT);
    bus.wait(320);
    assert_eq!(bus.allocation(), (0, None));
    bus.allocates(0x03, 9, &GRANTED);
    assert_eq!(bus.allocation(), (0x03, Some(9)));
}

/// The owner allocates the explicit connection again while its I/O runs.
#[test]
fn the_owner_comes_back_for_its_explicit_connection() {
    let mut bus = G2o::g2o().established(0x03, &[2]);
    for _ in 0..101 {
        bus.hears(POLL, &[1]);
        bus.sends(POLL_RESPONSE, &[0x34, 0x12]);
        bus.wait(100);
    }
    assert_eq!(bus.allocation(), (0x02, Some(MASTER)));
    bus.allocates(0x01, MASTER, &GRANTED);
    bus.is_state(2, 3);
}

/// A master that has restarted releases first.
#[test]
fn the_same_master_again() {
    let mut bus = G2o::g2o().allocated(0x03);
    bus.allocates(0x03, MASTER, &ALREADY);
    bus.releases(0x03, MASTER, &RELEASED);
    bus.allocates(0x03, MASTER, &GRANTED);
}

/// I/O that is being configured does not hold the slave.
#[test]
fn configuring_ends_with_the_explicit_connection() {
    let mut bus = G2o::g2o().allocated(0x03);
    bus.wait(10_000);
    assert_eq!(bus.allocation(), (0, None));
    bus.tells(SlaveEvent::Allocation { choice: cip_core::message::AllocationChoice::empty(), master: None });
    let mut config = config();
    config.options.remove(Options::DROP_CONFIGURING_WITH_EXPLICIT);
    let mut bus: Full = Bus::online(config, super::bus::everything());
    bus = bus.established(0x07, &[2]);
    bus.asks(&[0x4C, 3, 1, 1], &[0xCC]);
    assert_eq!(bus.allocation(), (0x06, Some(MASTER)), "the strobe is still being configured");
}

#[test]
fn a_timed_out_connection_can_be_released_and_allocated() {
    let mut bus = G2o::g2o().established(0x03, &[2]);
    bus.hears(POLL, &[1]);
    bus.sends(POLL_RESPONSE, &[0x34, 0x12]);
    bus.wait(320);
    assert_eq!(bus.allocation(), (0x01, Some(MASTER)));
    bus.is_state(2, 4);
    let mut again = bus.clone();
    again.releases(0x02, MASTER, &RELEASED);
    again.asks(&[0x0E, 5, 2, 1], &[0x94, 0x16, 0xFF]);
    bus.allocates(0x02, MASTER, &GRANTED);
    bus.is_state(2, 1);
}

/// Without the option, what has timed out is gone with the ownership.
#[test]
fn timed_out_connections_can_go_with_the_ownership() {
    for (keep, state) in [(true, 4), (false, 0)] {
        let mut config = config();
        config.options.set(Options::KEEP_TIMED_OUT, keep);
        let mut bus: G2o = Bus::online(config, block()).established(0x03, &[2]);
        bus.asks(&[0x4C, 3, 1, 1], &[0xCC]);
        bus.wait(10_000);
        assert_eq!(bus.allocation(), (0, None));
        let found = cip_core::connection::ConnectionState::from(
            bus.slave.node.io(crate::slave::IoKind::Poll).state(),
        );
        assert_eq!(found.0, state);
        bus.allocates(0x01, 9, &GRANTED);
        bus.hears(REQUEST, &[9, 0x0E, 5, 2, 1]);
        bus.sends(RESPONSE, &[9, 0x94, 0x16, 0xFF]);
    }
}
