//! Requests and responses on the explicit connection: every defect, fragments in both directions.

use core::time::Duration;

use cip_core::connection::ExplicitState;
use link_core::{Input, Machine, TxOutcome};

use super::bus::{Bus, G2o, MASTER, REQUEST, RESPONSE, UNCONNECTED, block, config};
use crate::Identifier;
use crate::slave::{Ignored, Options, SlaveEvent};

fn ignored(why: Ignored) -> SlaveEvent {
    SlaveEvent::Ignored { id: Identifier::new(REQUEST).unwrap(), why }
}

/// The order of checks, through the wire.
#[test]
fn which_error_for_which_defect() {
    let mut bus = G2o::g2o().allocated(0x03);
    for (request, why) in [
        (&[MASTER][..], Ignored::TooShort),
        (&[MASTER, 0x0E], Ignored::TooShort),
        (&[MASTER, 0x0E, 1], Ignored::TooShort),
        (&[MASTER, 0x8E, 1, 1, 1], Ignored::Response),
        (&[], Ignored::TooShort),
    ] {
        bus.events.clear();
        bus.hears(REQUEST, request);
        bus.sends_nothing();
        assert_eq!(bus.events, [ignored(why)], "{request:02X?}");
    }
    for (request, error) in [
        (&[0x0E, 0x64, 1, 1][..], 0x16), // class
        (&[0x0E, 1, 2, 1], 0x16),        // instance
        (&[0x0E, 5, 3, 1], 0x16),        // connection that is not allocated
        (&[0x33, 0x64, 1], 0x16),        // class before service
        (&[0x33, 1, 1], 0x08),           // service
        (&[0x08, 5, 0], 0x08),           // Create
        (&[0x10, 1, 1, 1, 0], 0x08),     // no attribute can be set: service before attribute
        (&[0x0E, 1, 1], 0x13),           // attribute missing
        (&[0x10, 5, 1], 0x13),
        (&[0x0E, 1, 1, 99], 0x14), // attribute
        (&[0x0E, 3, 1, 14], 0x14),
        (&[0x10, 5, 1, 1, 3], 0x0E),       // read-only
        (&[0x10, 5, 1, 9, 1], 0x13),       // short
        (&[0x10, 5, 1, 9, 1, 0, 0], 0x15), // long
        (&[0x0E, 1, 1, 1, 0], 0x15),       // Get with more data
        (&[0x10, 5, 1, 12, 0], 0x09),      // value
        (&[0x10, 3, 1, 3, 2], 0x09),
        (&[0x05, 5, 2], 0x0C),     // state
        (&[0x05, 1, 1, 99], 0x20), // service parameter
    ] {
        bus.asks(request, &[0x94, error, 0xFF]);
    }
    assert_eq!(bus.slave.counters().refused, 19);
}

#[test]
fn options_of_errors() {
    let mut config = config();
    config.options.insert(Options::ANSWER_SHORT_BODY);
    config.failures.group_2_only_failure = true;
    let mut bus: G2o = Bus::online(config, block()).allocated(0x01);
    bus.asks(&[0x0E, 1], &[0x94, 0x13, 0xFF]);
    bus.asks(&[0x33, 1, 1], &[0x94, 0x2A, 0xFF]);
    bus.asks_unconnected(9, &[0x4B], &[0x94, 0x13, 0xFF]);
}

/// The product name has 18 characters: 20 bytes of body, four fragments.
#[test]
fn a_response_in_fragments() {
    let mut bus = G2o::g2o().allocated(0x01);
    bus.hears(REQUEST, &[0x44, 0x0E, 1, 1, 7]);
    bus.sends(RESPONSE, &[0xC4, 0x00, 0x8E, 18, b'E', b'x', b'a', b'm']);
    bus.hears(REQUEST, &[0xC4, 0xC0, 0]);
    bus.sends(RESPONSE, &[0xC4, 0x41, b'p', b'l', b'e', b' ', b'B', b'l']);
    bus.hears(REQUEST, &[0xC4, 0xC0, 0]);
    bus.sends_nothing();
    bus.hears(REQUEST, &[0xC4, 0xC1, 0]);
    bus.sends(RESPONSE, &[0xC4, 0x42, b'o', b'c', b'k', b' ', b'2', b'I']);
    bus.hears(REQUEST, &[0xC4, 0xC2, 0]);
    bus.sends(RESPONSE, &[0xC4, 0x83, b'1', b'O']);
    bus.hears(REQUEST, &[0xC4, 0xC3, 0]);
    bus.sends_nothing();
    assert!(bus.slave.explicit.is_quiet());
}

/// One second for each acknowledge, two transmissions, then silence.
#[test]
fn a_fragment_that_is_not_acknowledged() {
    let mut bus = G2o::g2o().allocated(0x01);
    let first = [4, 0x0E, 1, 1, 7];
    let fragment = [0x84, 0x00, 0x8E, 18, b'E', b'x', b'a', b'm'];
    bus.hears(REQUEST, &first);
    bus.sends(RESPONSE, &fragment);
    bus.wait(999);
    bus.sends_nothing();
    bus.wait(1);
    bus.sends(RESPONSE, &fragment);
    bus.events.clear();
    bus.wait(999);
    assert_eq!(bus.events, []);
    bus.wait(1);
    assert_eq!(bus.events, [SlaveEvent::ResponseAbandoned { instance: 1 }]);
    bus.wait(3000);
    bus.sends_nothing();
    // The acknowledge comes after the second transmission.
    bus.hears(REQUEST, &first);
    bus.sends(RESPONSE, &fragment);
    bus.wait(1000);
    bus.sends(RESPONSE, &fragment);
    bus.hears(REQUEST, &[0x84, 0xC0, 0]);
    bus.sends(RESPONSE, &[0x84, 0x41, b'p', b'l', b'e', b' ', b'B', b'l']);
}

#[test]
fn a_response_is_given_up() {
    for give_up in [
        &[0x84, 0xC0, 1][..],               // too much data
        &[0x84, 0xC0, 7],                   // reserved status
        &[4, 0x0E, 1, 1, 1],                // a complete request
        &[0x84, 0x00, 0x0E, 1, 1, 1, 0, 0], // the first fragment of one
    ] {
        let mut bus = G2o::g2o().allocated(0x01);
        bus.hears(REQUEST, &[4, 0x0E, 1, 1, 7]);
        bus.sends(RESPONSE, &[0x84, 0x00, 0x8E, 18, b'E', b'x', b'a', b'm']);
        bus.hears(REQUEST, give_up);
        match give_up[0] {
            4 => bus.sends(RESPONSE, &[4, 0x8E, 0xE7, 0x03]),
            _ if give_up[1] == 0 => bus.sends(RESPONSE, &[0x84, 0xC0, 0]),
            _ => {}
        }
        bus.wait(5000);
        bus.sends_nothing();
    }
}

/// Ten bytes of body in two fragments, as Omron and others send them; the acknowledge of the last one goes before the
/// response.
#[test]
fn a_request_in_fragments() {
    let mut bus = G2o::g2o().allocated(0x01);
    bus.hears(REQUEST, &[0x84, 0x00, 0x10, 0x04, 0x66, 0x03, 0x01, 0x02]);
    bus.sends(RESPONSE, &[0x84, 0xC0, 0x00]);
    bus.hears(REQUEST, &[0x84, 0x81, 0x03, 0x04, 0x05, 0x06]);
    bus.sends(RESPONSE, &[0x84, 0xC1, 0x00]);
    bus.sends(RESPONSE, &[0x04, 0x94, 0x16, 0xFF]);
    bus.sends_nothing();
    // The last fragment again, within a second: its acknowledge was lost. It is not processed again.
    bus.wait(999);
    bus.hears(REQUEST, &[0x84, 0x81, 0x03, 0x04, 0x05, 0x06]);
    bus.sends(RESPONSE, &[0x84, 0xC1, 0x00]);
    bus.sends_nothing();
    bus.wait(1);
    bus.hears(REQUEST, &[0x84, 0x81, 0x03, 0x04, 0x05, 0x06]);
    bus.sends_nothing();
}

#[test]
fn fragments_lost_repeated_and_out_of_order() {
    let mut bus = G2o::g2o().allocated(0x01);
    let first = [0x84, 0x00, 0x0E, 0x01, 0x01, 0x01, 0, 0];
    let ack = |bus: &mut G2o, count: u8| bus.sends(RESPONSE, &[0x84, 0xC0 | count, 0]);
    // Middle and last without a first; a first with a count.
    for fragment in [[0x84, 0x41, 1], [0x84, 0x81, 1], [0x84, 0x3F, 1], [0x84, 0x01, 1]] {
        bus.hears(REQUEST, &fragment);
        bus.sends_nothing();
    }
    // A middle fragment repeated, then one left out.
    bus.hears(REQUEST, &first);
    ack(&mut bus, 0);
    bus.hears(REQUEST, &[0x84, 0x41, 0]);
    ack(&mut bus, 1);
    bus.hears(REQUEST, &[0x84, 0x41, 0]);
    ack(&mut bus, 1);
    bus.hears(REQUEST, &[0x84, 0x83, 0]);
    bus.sends_nothing();
    bus.hears(REQUEST, &[0x84, 0x82, 0]);
    bus.sends_nothing();
    // An unfragmented message in between.
    bus.hears(REQUEST, &first);
    ack(&mut bus, 0);
    bus.asks(&[0x0E, 1, 1, 1], &[0x8E, 0xE7, 0x03]);
    bus.hears(REQUEST, &[0x84, 0x81, 0]);
    bus.sends_nothing();
    // A pause of three seconds.
    bus.hears(REQUEST, &first);
    ack(&mut bus, 0);
    bus.wait(2999);
    bus.hears(REQUEST, &[0x84, 0x41, 0]);
    ack(&mut bus, 1);
    bus.wait(3000);
    bus.hears(REQUEST, &[0x84, 0x82, 0]);
    bus.sends_nothing();
}

/// The buffer of the test slave has 64 bytes: eleven fragments are too many by two bytes.
#[test]
fn a_request_that_is_too_long() {
    let mut bus = G2o::g2o().allocated(0x01);
    for count in 0..10_u8 {
        let kind = if count == 0 { 0x00 } else { 0x40 };
        bus.hears(REQUEST, &[0x84, kind | count, 0x33, 1, 1, 0, 0, 0]);
        bus.sends(RESPONSE, &[0x84, 0xC0 | count, 0]);
    }
    let mut fits = bus.clone();
    bus.hears(REQUEST, &[0x84, 0x80 | 10, 0, 0, 0, 0, 0]);
    bus.sends(RESPONSE, &[0x84, 0xCA, 1]);
    bus.sends_nothing();
    fits.hears(REQUEST, &[0x84, 0x80 | 10, 0, 0, 0, 0]);
    fits.sends(RESPONSE, &[0x84, 0xCA, 0]);
    fits.sends(RESPONSE, &[4, 0x94, 0x08, 0xFF]);
}

/// Every message counts, acknowledges and fragments too.
#[test]
fn every_message_keeps_the_connection() {
    let mut bus = G2o::g2o().allocated(0x01);
    for message in [&[4, 0x0E, 1, 1, 1][..], &[0x84, 0x00, 0, 0, 0, 0, 0, 0], &[0x84, 0xC0, 0], &[4]] {
        bus.wait(9999);
        bus.hears(REQUEST, message);
    }
    bus.wait(9999);
    assert_eq!(bus.slave.node.explicit.state(), ExplicitState::Established);
    bus.wait(1);
    assert_eq!(bus.slave.node.explicit.state(), ExplicitState::NonExistent);
}

#[test]
fn the_explicit_connection_begins_with_2500_ms_and_ends_after_10_s() {
    let mut bus = G2o::g2o().allocated(0x01);
    bus.asks(&[0x0E, 5, 1, 9], &[0x8E, 0xC4, 0x09]);
    bus.asks(&[0x10, 5, 1, 9, 0x01, 0x00], &[0x90, 10, 0]);
    bus.wait(39);
    bus.is_state(1, 3);
    bus.asks(&[0x10, 5, 1, 9, 0, 0], &[0x90, 0, 0]);
    bus.wait(1_000_000);
    bus.is_state(1, 3);
}

/// With action 3 it waits for the end of the I/O; a message revives it.
#[test]
fn deferred_delete() {
    let mut bus = G2o::g2o().established(0x03, &[2]);
    bus.asks(&[0x10, 5, 1, 12, 3], &[0x90]);
    let poll = |bus: &mut G2o, times: u32| {
        for _ in 0..times {
            bus.hears(super::bus::POLL, &[1]);
            bus.sends(super::bus::POLL_RESPONSE, &[0x34, 0x12]);
            bus.wait(200);
        }
    };
    poll(&mut bus, 51);
    assert_eq!(bus.slave.node.explicit.state(), ExplicitState::DeferredDelete);
    assert_eq!(bus.allocation(), (0x03, Some(MASTER)));
    bus.is_state(1, 3);
    poll(&mut bus, 51);
    assert_eq!(bus.slave.node.explicit.state(), ExplicitState::DeferredDelete);
    bus.wait(320);
    assert_eq!(bus.slave.node.explicit.state(), ExplicitState::NonExistent);
    assert_eq!(bus.allocation(), (0, None));
}

#[test]
fn responses_that_the_controller_gives_back() {
    let mut bus = G2o::g2o().allocated(0x01);
    bus.acknowledging = false;
    bus.hears(REQUEST, &[4, 0x0E, 1, 1, 1]);
    bus.done(TxOutcome::Dropped);
    bus.tells(SlaveEvent::NotSent { id: Identifier::new(RESPONSE).unwrap(), outcome: TxOutcome::Dropped });
    bus.sends(RESPONSE, &[4, 0x8E, 0xE7, 0x03]);
    bus.wait(5000);
    bus.sends_nothing();
    // A fragment is sent again after the acknowledge time.
    let fragment = [0x84, 0x00, 0x8E, 18, b'E', b'x', b'a', b'm'];
    bus.hears(REQUEST, &[4, 0x0E, 1, 1, 7]);
    bus.sends(RESPONSE, &fragment);
    bus.done(TxOutcome::Dropped);
    bus.wait(1000);
    bus.sends(RESPONSE, &fragment);
    assert_eq!(bus.slave.counters().not_sent, 2);
}

/// The client is faster than the controller's report.
#[test]
fn an_acknowledge_before_its_fragment_is_reported_as_sent() {
    let mut bus = G2o::g2o().allocated(0x01);
    bus.acknowledging = false;
    bus.hears(REQUEST, &[4, 0x0E, 1, 1, 7]);
    bus.sends(RESPONSE, &[0x84, 0x00, 0x8E, 18, b'E', b'x', b'a', b'm']);
    bus.hears(REQUEST, &[0x84, 0xC0, 0]);
    bus.sends_nothing();
    bus.done(TxOutcome::Sent);
    bus.sends(RESPONSE, &[0x84, 0x41, b'p', b'l', b'e', b' ', b'B', b'l']);
}

/// The time for an acknowledge is over, and it comes before the second copy was fetched: there is no second copy.
#[test]
fn a_late_acknowledge_of_the_first_copy() {
    let mut bus = G2o::g2o().allocated(0x01);
    bus.hears(REQUEST, &[4, 0x0E, 1, 1, 7]);
    bus.sends(RESPONSE, &[0x84, 0x00, 0x8E, 18, b'E', b'x', b'a', b'm']);
    bus.now += Duration::from_millis(1000);
    bus.slave.input(bus.now, Input::Tick);
    bus.hears(REQUEST, &[0x84, 0xC0, 0]);
    bus.sends(RESPONSE, &[0x84, 0x41, b'p', b'l', b'e', b' ', b'B', b'l']);
    bus.sends_nothing();
}

/// They share a line, on which a response is still with the controller when both come.
#[test]
fn an_acknowledge_goes_before_an_unconnected_answer() {
    fn check<const DYNAMIC: usize>() {
        let mut bus = Bus::<_, DYNAMIC>::online(config(), block()).allocated(0x01);
        bus.acknowledging = false;
        bus.hears(REQUEST, &[4, 0x0E, 1, 1, 1]);
        bus.sends(RESPONSE, &[4, 0x8E, 0xE7, 0x03]);
        bus.hears(UNCONNECTED, &[5, 0x4B, 3, 1, 1, 5]);
        bus.hears(REQUEST, &[0x84, 0x00, 0x0E]);
        bus.sends_nothing();
        bus.done(TxOutcome::Sent);
        bus.sends(RESPONSE, &[0x84, 0xC0, 0]);
        bus.sends_nothing();
        bus.done(TxOutcome::Sent);
        bus.sends(RESPONSE, &[5, 0x94, 0x0C, 0x01]);
        bus.done(TxOutcome::Sent);
        bus.sends_nothing();
    }
    check::<0>();
    check::<3>();
}

/// The response to the first is still with the controller when the second comes: it goes out, and then the other.
#[test]
fn a_request_while_the_response_is_in_flight() {
    let mut bus = G2o::g2o().allocated(0x01);
    bus.acknowledging = false;
    bus.hears(REQUEST, &[4, 0x0E, 1, 1, 1]);
    bus.hears(REQUEST, &[4, 0x0E, 1, 1, 2]);
    bus.hears(REQUEST, &[4, 0x0E, 1, 1, 3]);
    bus.sends(RESPONSE, &[4, 0x8E, 0xE7, 0x03]);
    bus.sends_nothing();
    bus.done(TxOutcome::Sent);
    bus.sends(RESPONSE, &[4, 0x8E, 0x2A, 0x00]);
    bus.done(TxOutcome::Sent);
    bus.sends_nothing();
}

/// A Release in fragments, which nobody needs, is acknowledged and answered although it ends the connection.
#[test]
fn the_last_request_is_answered() {
    for request in [&[0x4C, 3, 1, 1][..], &[0x09, 5, 1]] {
        let mut bus = G2o::g2o().allocated(0x01);
        bus.hears(REQUEST, &[0x84, 0x00, request[0]]);
        bus.sends(RESPONSE, &[0x84, 0xC0, 0]);
        bus.hears(REQUEST, &[&[0x84, 0x81], &request[1..]].concat());
        bus.sends(RESPONSE, &[0x84, 0xC1, 0]);
        bus.sends(RESPONSE, &[4, request[0] | 0x80]);
        assert_eq!(bus.allocation(), (0, None));
        bus.hears(REQUEST, &[4, 0x0E, 1, 1, 1]);
        bus.sends_nothing();
    }
}
