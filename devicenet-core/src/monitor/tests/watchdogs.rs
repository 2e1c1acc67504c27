//! Watchdogs of connections, and what they do.

use super::*;

#[test]
fn polls_that_stop_time_the_connection_out_after_four_packet_rates() {
    let mut bus = Bus::with_slave(10, 0x03);
    bus.establish(10, 2, 100);
    bus.group2(10, 5, &[1]);
    bus.group1(15, 10, &[2]);
    bus.wait(398).group2(10, 5, &[1]);
    assert_eq!(bus.state(10, Predefined::Poll), ConnectionState::Established);
    bus.group1(15, 10, &[2]);
    let heard = bus.wait(400).group2(10, 5, &[1]);
    assert_eq!(heard.note, Some(Note::NoConnection(ConnectionState::TimedOut)));
    assert!(heard.assumed, "a frame could be missing");
    assert_eq!(heard.problem, None);
    let record = bus.connection(10, Predefined::Poll);
    assert_eq!((record.state, record.assumed), (ConnectionState::TimedOut, true));
    // It answers: a frame was missing.
    assert_eq!(bus.group1(15, 10, &[2]).problem, None);
    assert_eq!(bus.state(10, Predefined::Poll), ConnectionState::Established);
}

/// Attribute 18 is a code: 0 for four times the expected packet rate, each one more for twice as long, from 8 on reserved.
#[test]
fn the_time_out_is_that_of_the_multiplier() {
    let mut bus = Bus::with_slave(10, 0x03);
    let time_out = |bus: &Bus| bus.connection(10, Predefined::Poll).time_out.map(|time| time.as_millis());
    assert_eq!(time_out(&bus), None, "a new connection has a rate of 0");
    bus.establish(10, 2, 100);
    assert_eq!(time_out(&bus), Some(400));
    for (multiplier, millis) in [(1, 800), (7, 51_200), (8, 400), (255, 400)] {
        bus.group2(10, 4, &[0x01, 0x10, 5, 2, 18, multiplier]);
        bus.group2(10, 3, &[0x01, 0x90]);
        assert_eq!(time_out(&bus), Some(millis), "{multiplier}");
    }
    // It is read, and the watchdog follows it.
    bus.group2(10, 4, &[0x01, 0x0E, 5, 2, 18]);
    bus.group2(10, 3, &[0x01, 0x8E, 1]);
    assert_eq!(time_out(&bus), Some(800));
    bus.group2(10, 5, &[1]);
    assert_eq!(bus.wait(790).group2(10, 5, &[1]).note, None);
    let heard = bus.wait(800).group2(10, 5, &[1]);
    assert_eq!(heard.note, Some(Note::NoConnection(ConnectionState::TimedOut)));
    bus.establish(10, 2, 0);
    assert_eq!(time_out(&bus), None, "no watchdog");
}

#[test]
fn the_first_poll_may_take_ten_seconds() {
    let mut bus = Bus::with_slave(10, 0x03);
    bus.establish(10, 2, 100);
    assert_eq!(bus.wait(9_900).group2(10, 5, &[1]).note, None);
    let mut bus = Bus::with_slave(10, 0x03);
    bus.establish(10, 2, 100);
    assert!(bus.wait(10_100).group2(10, 5, &[1]).note.is_some());
}

#[test]
fn the_explicit_connection_is_deleted_ten_seconds_after_its_last_message() {
    let mut bus = Bus::with_slave(10, 0x01);
    bus.wait(9_990).group2(10, 4, &[0x01, 0x0E, 1, 1, 1]);
    bus.group2(10, 3, &[0x01, 0x8E, 0x34, 0x12]);
    let heard = bus.wait(10_000).group2(10, 4, &[0x01, 0x0E, 1, 1, 1]);
    assert_eq!(heard.note, Some(Note::NoConnection(ConnectionState::NonExistent)));
    assert!(heard.assumed);
}

/// What the server sends does not restart its watchdog: here it answers late.
#[test]
fn responses_do_not_prolong_the_explicit_connection() {
    let mut bus = Bus::with_slave(10, 0x01);
    bus.group2(10, 4, &[0x01, 0x0E, 1, 1, 1]);
    bus.wait(5_000).group2(10, 3, &[0x01, 0x8E, 0x34, 0x12]);
    bus.wait(4_990).group2(11, 5, &[]);
    assert_eq!(bus.state(10, Predefined::Explicit), ConnectionState::Established);
    bus.wait(10).group2(11, 5, &[]);
    assert_eq!(bus.state(10, Predefined::Explicit), ConnectionState::NonExistent);
}

#[test]
fn the_ten_seconds_are_for_a_connection_that_was_configured() {
    // The packet rate is set again; Reset of the instance; Reset of the class.
    let again: [(&[u8], &[u8]); 3] = [
        (&[0x01, 0x10, 5, 2, 9, 100, 0], &[0x01, 0x90, 100, 0]),
        (&[0x01, 0x05, 5, 2], &[0x01, 0x85]),
        (&[0x01, 0x05, 5, 0], &[0x01, 0x85]),
    ];
    for (request, response) in again {
        let mut bus = Bus::with_slave(10, 0x03);
        bus.establish(10, 2, 100);
        if request.get(1) == Some(&0x05) {
            bus.group2(10, 5, &[]);
            bus.wait(500);
        }
        bus.group2(10, 4, request);
        bus.group2(10, 3, response);
        assert_eq!(bus.state(10, Predefined::Poll), ConnectionState::Established, "{request:02X?}");
        bus.wait(402).group2(11, 5, &[]);
        assert_eq!(bus.state(10, Predefined::Poll), ConnectionState::TimedOut, "{request:02X?}");
    }
}

#[test]
fn deferred_delete_waits_for_the_io() {
    let mut bus = Bus::with_slave(10, 0x03);
    bus.group2(10, 4, &[0x01, 0x10, 5, 1, 12, 3]);
    bus.group2(10, 3, &[0x01, 0x90]);
    assert_eq!(bus.connection(10, Predefined::Explicit).watchdog_action, Some(3));
    bus.establish(10, 2, 1000);
    for _ in 0..12 {
        bus.wait(1000).group2(10, 5, &[1]);
        bus.group1(15, 10, &[2]);
    }
    assert_eq!(bus.state(10, Predefined::Explicit), ConnectionState::DeferredDelete);
    let heard = bus.group2(10, 4, &[0x01, 0x0E, 1, 1, 1]);
    assert_eq!((heard.note, heard.problem), (None, None));
    assert_eq!(bus.state(10, Predefined::Explicit), ConnectionState::Established);
}

#[test]
fn packet_rate_zero_never_times_out() {
    let mut bus = Bus::with_slave(10, 0x03);
    bus.establish(10, 2, 0);
    bus.establish(10, 1, 0);
    assert_eq!(bus.wait(1_000_000).group2(10, 5, &[1]).note, None);
    assert_eq!(bus.group2(10, 4, &[0x01, 0x0E, 1, 1, 1]).note, None);
}

#[test]
fn deferred_delete_ends_with_the_io() {
    let mut bus = Bus::with_slave(10, 0x03);
    bus.group2(10, 4, &[0x01, 0x10, 5, 1, 12, 3]);
    bus.group2(10, 3, &[0x01, 0x90]);
    bus.establish(10, 2, 1000);
    for _ in 0..12 {
        bus.wait(1000).group2(10, 5, &[1]);
        bus.group1(15, 10, &[2]);
    }
    bus.wait(5000).group2(11, 5, &[]);
    assert_eq!(bus.state(10, Predefined::Poll), ConnectionState::TimedOut);
    assert_eq!(bus.state(10, Predefined::Explicit), ConnectionState::NonExistent);
}
