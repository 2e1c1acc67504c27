//! A master brings a Group 2 Only server up, exchanges data and releases it: master MAC ID 4, slave MAC ID 63, 10 ms
//! resolution. Computed by hand from the rules of CIP Vol. 3; a failing line means that the code is wrong.

use link_core::LinkEvent;

use super::bus::{Bus, G2o, POLL, POLL_RESPONSE, REQUEST, RESPONSE, UNCONNECTED, block, config};

#[test]
fn bring_up_exchange_and_release() {
    let mut bus: G2o = Bus::dark(config(), block());
    bus.link(LinkEvent::Up);
    bus.sends(0x5FF, &[0x00, 0xE7, 0x03, 0x44, 0x33, 0x22, 0x11]);
    bus.wait(1000);
    bus.sends(0x5FF, &[0x00, 0xE7, 0x03, 0x44, 0x33, 0x22, 0x11]);
    bus.wait(1000);
    for _ in 0..2 {
        bus.hears(0x784, &[0x3F, 0x4B, 0x00, 0x31]);
        bus.sends_nothing();
        bus.wait(1000);
    }
    let exchange: [(u16, &[u8], u16, &[u8]); 13] = [
        (UNCONNECTED, &[0x04, 0x4B, 0x03, 0x01, 0x01, 0x04], RESPONSE, &[0x04, 0xCB, 0x00]),
        (REQUEST, &[0x44, 0x10, 0x05, 0x01, 0x0C, 0x03], RESPONSE, &[0x44, 0x90]),
        (REQUEST, &[0x04, 0x0E, 0x01, 0x01, 0x01], RESPONSE, &[0x04, 0x8E, 0xE7, 0x03]),
        (REQUEST, &[0x44, 0x0E, 0x01, 0x01, 0x02], RESPONSE, &[0x44, 0x8E, 0x07, 0x00]),
        (REQUEST, &[0x04, 0x0E, 0x01, 0x01, 0x03], RESPONSE, &[0x04, 0x8E, 0x2A, 0x00]),
        (REQUEST, &[0x44, 0x4B, 0x03, 0x01, 0x02, 0x04], RESPONSE, &[0x44, 0xCB, 0x00]),
        (REQUEST, &[0x04, 0x0E, 0x05, 0x02, 0x07], RESPONSE, &[0x04, 0x8E, 0x02, 0x00]),
        (REQUEST, &[0x44, 0x0E, 0x05, 0x02, 0x08], RESPONSE, &[0x44, 0x8E, 0x01, 0x00]),
        (REQUEST, &[0x04, 0x10, 0x05, 0x02, 0x09, 0x4B, 0x00], RESPONSE, &[0x04, 0x90, 0x50, 0x00]),
        (POLL, &[0x03], POLL_RESPONSE, &[0x34, 0x12]),
        (POLL, &[], POLL_RESPONSE, &[0x34, 0x12]),
        (REQUEST, &[0x44, 0x4C, 0x03, 0x01, 0x03], RESPONSE, &[0x44, 0xCC]),
        (UNCONNECTED, &[0x04, 0x4B, 0x03, 0x01, 0x01, 0x04], RESPONSE, &[0x04, 0xCB, 0x00]),
    ];
    for (id, request, answer_id, answer) in exchange {
        bus.hears(id, request);
        bus.sends(answer_id, answer);
        bus.sends_nothing();
    }
}

/// If the polls stop: 320 ms after the last one instance 2 has timed out; 10 s after the last explicit message nothing
/// is left.
#[test]
fn what_happens_when_the_master_goes_away() {
    let mut bus = G2o::g2o().established(0x03, &[2]);
    bus.asks(&[0x10, 5, 1, 12, 3], &[0x90]);
    bus.hears(POLL, &[1]);
    bus.sends(POLL_RESPONSE, &[0x34, 0x12]);
    bus.wait(319);
    assert_eq!(bus.allocation(), (0x03, Some(4)));
    bus.wait(1);
    assert_eq!(bus.allocation(), (0x01, Some(4)));
    bus.wait(9679);
    assert_eq!(bus.allocation(), (0x01, Some(4)));
    bus.wait(1);
    assert_eq!(bus.allocation(), (0x00, None));
}

/// 10 s after the packet rate was set, if there was never a poll.
#[test]
fn what_happens_when_the_master_never_polls() {
    let mut bus = G2o::g2o().established(0x03, &[2]);
    bus.wait(9999);
    assert_eq!(bus.allocation(), (0x03, Some(4)));
    bus.wait(1);
    assert_eq!(bus.allocation(), (0x00, None));
}
