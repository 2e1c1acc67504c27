//! Both state machines, over the wire: every row of their tables is reached.

use std::cell::RefCell;
use std::collections::HashSet;

use cip_core::connection::{
    EXPLICIT_EDGES, ExplicitCause, ExplicitEdge, ExplicitState, IO_EDGES, IoCause, IoEdge, IoState,
};
use link_core::{LinkEvent, machine_laws};

use super::bus::Bus;

std::thread_local! {
    static IO: RefCell<HashSet<IoEdge>> = RefCell::default();
    static EXPLICIT: RefCell<HashSet<ExplicitEdge>> = RefCell::default();
}

pub(in crate::device) fn record_io(from: IoState, cause: IoCause, to: IoState) {
    IO.with_borrow_mut(|edges| edges.insert(IoEdge { from, cause, to }));
}

pub(in crate::device) fn record_message(state: IoState) {
    record_io(state, IoCause::Message, state);
}

pub(in crate::device) fn record_explicit(from: ExplicitState, cause: ExplicitCause, to: ExplicitState) {
    EXPLICIT.with_borrow_mut(|edges| edges.insert(ExplicitEdge { from, cause, to }));
}

/// Consumer 13 in each of its states, and how instance 1 sees it. Dynamic connections can be configured.
fn states() -> [(IoState, u8, Bus); 4] {
    let mut configuring = Bus::explicit();
    configuring.connects(&[0x4B, 0x40], &[0x4B, 0x40, 0, 128, 0]);
    configuring.asks(&[0x10, 5, 128, 3, 0x80], &[0x90]);
    let mut established = configuring.clone();
    established.asks(&[0x10, 5, 128, 9, 100, 0], &[0x90, 100, 0]);
    let mut timed_out = established.clone();
    timed_out.wait(10_000);
    [
        (IoState::NonExistent, 0, Bus::explicit()),
        (IoState::Configuring, 1, configuring),
        (IoState::Established, 3, established),
        (IoState::TimedOut, 4, timed_out),
    ]
}

/// What the manager says to instance 128, the cause that it is, and the answer in each state: 0 for success.
const SERVICES: [(&[u8], IoCause, [u8; 4]); 5] = [
    (&[0x0E, 5, 128, 7], IoCause::Served, [0x16, 0, 0, 0]),
    (&[0x10, 5, 128, 9, 80, 0], IoCause::PacketRateSet, [0x16, 0, 0, 0]),
    (&[0x0D, 5, 128], IoCause::Applied, [0x16, 0, 0x0C, 0x0C]),
    (&[0x05, 5, 128], IoCause::Reset, [0x16, 0x0C, 0, 0]),
    (&[0x09, 5, 128], IoCause::Released, [0x16, 0, 0, 0]),
];

#[test]
fn every_row_of_both_machines_is_reached() {
    for (column, (state, number, bus)) in states().into_iter().enumerate() {
        assert_eq!(bus.state(128), number);
        for (request, cause, answers) in SERVICES {
            let mut bus = bus.clone();
            bus.hears(0x1086_0205, request);
            let response = bus.sent.pop_back().unwrap();
            let expected = answers[column];
            if expected == 0 {
                assert_eq!(response.data()[0], request[0] | 0x80, "{cause} in {state}: {response}");
            } else {
                assert_eq!(response.data(), [0x94, expected, 0xFF], "{cause} in {state}");
            }
            // The object answers these by itself, before the machine is asked.
            if cause == IoCause::Served || state == IoState::NonExistent {
                assert_eq!(bus.state(128), number);
                record_io(state, cause, state);
            }
        }
        let mut message = bus.clone();
        message.hears(0x0002_C380, &[1]);
        assert_eq!(message.node.counters().consumed, u32::from(state == IoState::Established));
        let mut again = bus.clone();
        again.connects(&[0x4B, 0x40, 128, 0, 50, 0, 0], &[0x4B, 0x40, 0, 128, 0]);
        assert_eq!(again.state(128), 3);
        let mut lost = bus.clone();
        lost.link(LinkEvent::Down);
        assert_eq!(lost.node.connections().count(), 0);
        // The explicit connection ends: what is being configured ends with it.
        let mut gone = bus.clone();
        gone.asks(&[0x09, 5, 1], &[0x89]);
        assert_eq!(gone.state(128), if state == IoState::Configuring { 0 } else { number });
        // So it does when nobody cares for it.
        let mut forgotten = bus.clone();
        forgotten.wait(10_000);
        let later = match state {
            IoState::NonExistent | IoState::Configuring => 0,
            IoState::Established | IoState::TimedOut => 4,
        };
        assert_eq!(forgotten.state(128), later);
    }
    for (action, state) in [(0, 4), (1, 0), (2, 3)] {
        let [.., (_, _, mut bus), _] = states();
        bus.asks(&[0x10, 5, 128, 12, action], &[0x90]);
        bus.wait(10_000);
        assert_eq!(bus.state(128), state);
    }
    // Without an explicit connection, which would end first.
    let mut configuring = Bus::new();
    configuring.connects(&[0x4B, 0x40], &[0x4B, 0x40, 0, 128, 0]);
    configuring.link(LinkEvent::Down);
    walk_explicit();
    IO.with_borrow(|taken| machine_laws::every_edge_was_taken(IO_EDGES, taken, |edge| *edge));
    EXPLICIT.with_borrow(|taken| machine_laws::every_edge_was_taken(EXPLICIT_EDGES, taken, |edge| *edge));
}

/// Every service for a connection that is being configured says that somebody is there.
#[test]
fn a_connection_may_be_configured_slowly() {
    let mut bus = Bus::explicit();
    bus.connects(&[0x4B, 0x40], &[0x4B, 0x40, 0, 128, 0]);
    for _ in 0..3 {
        bus.wait(9_999);
        bus.asks(&[0x10, 5, 128, 12, 2], &[0x90]);
    }
    assert_eq!(bus.state(128), 1);
    let mut for_ever = Bus::with(|config| config.configuring_time_out = 0, |_| {});
    for_ever.connects(&[0x4B, 0x40], &[0x4B, 0x40, 0, 128, 0]);
    for_ever.wait(3_600_000);
    assert_eq!(for_ever.state(128), 1);
}

fn walk_explicit() {
    for action in [1, 3] {
        let mut bus = Bus::explicit();
        bus.asks(&[0x05, 5, 1], &[0x85]);
        bus.asks(&[0x10, 5, 1, 9, 0xC4, 0x09], &[0x90, 0xC4, 0x09]);
        bus.asks(&[0x10, 5, 1, 12, action], &[0x90]);
        let mut alone = bus.clone();
        alone.wait(10_000);
        assert_eq!(alone.state(1), 0);
        // With an I/O connection that never times out; that of another node does not count.
        bus.hears(0x1D86_0409, &[0x4B, 0xC0, 7, 0, 0, 0, 0]);
        let mut others = bus.clone();
        others.wait(10_000);
        assert_eq!(others.state(1), 0);
        bus.connects(&[0x4B, 0xC0, 3, 0, 0, 0, 0], &[0x4B, 0xC0, 0, 0, 0]);
        bus.wait(10_000);
        if action == 1 {
            assert_eq!(bus.state(1), 0);
            continue;
        }
        assert_eq!(bus.state(1), 5);
        let mut lost = bus.clone();
        lost.link(LinkEvent::BusOff);
        // A message establishes it again.
        let mut message = bus.clone();
        message.asks(&[0x0E, 3, 1, 1], &[0x8E, 67]);
        assert_eq!(message.state(1), 3);
        // Another connection, of another node, can do the rest.
        bus.hears(0x1D86_0409, &[0x4B, 0x50]);
        bus.forget();
        for (request, response) in
            [(&[0x10, 5, 1, 9, 100, 0][..], &[0x90, 100, 0][..]), (&[0x05, 5, 1], &[0x94, 0x0C, 0xFF])]
        {
            bus.hears(0x1086_0405, request);
            bus.sends(0x1005_8605, response);
        }
        for request in [[0x09, 5, 1], [0x09, 5, 3]] {
            let mut bus = bus.clone();
            bus.hears(0x1086_0405, &request);
            bus.sends(0x1005_8605, &[0x89]);
            assert_eq!(bus.state(1), 0);
        }
    }
}
