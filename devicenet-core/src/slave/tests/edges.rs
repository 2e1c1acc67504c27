//! Both state machines, over the wire: every row of their tables is reached.

use std::cell::RefCell;
use std::vec::Vec;

use cip_core::connection::{
    EXPLICIT_EDGES, ExplicitCause, ExplicitEdge, ExplicitState, IO_EDGES, IoCause, IoEdge, IoState,
};
use link_core::LinkEvent;

use super::bus::{CHECK, G2o, MASTER, POLL, REQUEST, UNCONNECTED, Ucmm};

std::thread_local! {
    static IO: RefCell<Vec<IoEdge>> = const { RefCell::new(Vec::new()) };
    static EXPLICIT: RefCell<Vec<ExplicitEdge>> = const { RefCell::new(Vec::new()) };
}

pub(in crate::slave) fn record_io(from: IoState, cause: IoCause, to: IoState) {
    IO.with_borrow_mut(|edges| edges.push(IoEdge { from, cause, to }));
}

pub(in crate::slave) fn record_explicit(from: ExplicitState, cause: ExplicitCause, to: ExplicitState) {
    EXPLICIT.with_borrow_mut(|edges| edges.push(ExplicitEdge { from, cause, to }));
}

/// Poll in each of its states.
fn states() -> [(IoState, G2o); 4] {
    let mut timed_out = established();
    timed_out.hears(POLL, &[1]);
    timed_out.skip();
    timed_out.wait(320);
    [
        (IoState::NonExistent, G2o::g2o().allocated(0x01)),
        (IoState::Configuring, G2o::g2o().allocated(0x03)),
        (IoState::Established, established()),
        (IoState::TimedOut, timed_out),
    ]
}

fn established() -> G2o {
    let mut bus = G2o::g2o().established(0x03, &[2]);
    bus.asks(&[0x10, 5, 1, 12, 3], &[0x90]);
    bus
}

/// What the master says to instance 2, the cause that it is, and the answer in each state: 0 for success.
const SERVICES: [(&[u8], IoCause, [u8; 4]); 5] = [
    (&[0x0E, 5, 2, 7], IoCause::Served, [0x16, 0, 0, 0]),
    (&[0x10, 5, 2, 9, 80, 0], IoCause::PacketRateSet, [0x16, 0, 0, 0]),
    (&[0x0D, 5, 2], IoCause::Applied, [0x16, 0, 0x0C, 0x0C]),
    (&[0x05, 5, 2], IoCause::Reset, [0x16, 0x0C, 0, 0]),
    (&[0x09, 5, 2], IoCause::Released, [0x16, 0, 0, 0]),
];

#[test]
fn every_row_of_both_machines_is_reached() {
    for (column, (state, bus)) in states().into_iter().enumerate() {
        for (request, cause, answers) in SERVICES {
            let mut bus = bus.clone();
            bus.hears(REQUEST, &[&[MASTER], request].concat());
            let response = bus.response();
            let expected = answers[column];
            if expected == 0 {
                assert_eq!(response[1], request[0] | 0x80, "{cause} in {state}: {response:02X?}");
            } else {
                assert_eq!(response[1..], [0x94, expected, 0xFF], "{cause} in {state}");
            }
            // The object answers these by itself, before the machine is asked.
            if cause == IoCause::Served || state == IoState::NonExistent {
                assert_eq!(bus.slave.node.io(crate::slave::IoKind::Poll).state(), state);
                record_io(state, cause, state);
            }
        }
        let mut message = bus.clone();
        message.hears(POLL, &[1]);
        let mut allocated = bus.clone();
        allocated.hears(UNCONNECTED, &[MASTER, 0x4B, 3, 1, 2, MASTER]);
        let mut gone = bus.clone();
        gone.hears(UNCONNECTED, &[MASTER, 0x4C, 3, 1, 1]);
        let mut lost = bus.clone();
        lost.link(LinkEvent::Down);
        assert_eq!(lost.allocation(), (0, None));
        let mut duplicate = bus.clone();
        duplicate.hears(CHECK, &[0x80, 1, 2, 3, 4, 5, 6]);
        assert_eq!(duplicate.allocation(), (0, None));
    }
    for action in [0, 1, 2] {
        let mut bus = established();
        bus.asks(&[0x10, 5, 2, 12, action], &[0x90]);
        bus.wait(10_000);
    }
    walk_explicit();
    IO.with_borrow(|reached| {
        for edge in IO_EDGES {
            assert!(reached.contains(edge), "{edge}");
        }
    });
    EXPLICIT.with_borrow(|reached| {
        for edge in EXPLICIT_EDGES {
            assert!(reached.contains(edge), "{edge}");
        }
    });
}

fn walk_explicit() {
    for action in [1, 3] {
        let mut bus = established();
        bus.asks(&[0x05, 5, 1], &[0x85]);
        bus.asks(&[0x10, 5, 1, 9, 0xC4, 0x09], &[0x90, 0xC4, 0x09]);
        bus.asks(&[0x10, 5, 1, 12, action], &[0x90]);
        // Without I/O, and with.
        let mut alone = bus.clone();
        alone.asks(&[0x09, 5, 2], &[0x89]);
        alone.wait(10_000);
        let mut deferred = bus.clone();
        for _ in 0..40 {
            deferred.hears(POLL, &[1]);
            deferred.skip();
            deferred.wait(300);
        }
        if action == 1 {
            assert_eq!(deferred.slave.node.explicit.state(), ExplicitState::NonExistent);
            continue;
        }
        assert_eq!(deferred.slave.node.explicit.state(), ExplicitState::DeferredDelete);
        let mut released = deferred.clone();
        released.asks_unconnected(MASTER, &[0x4C, 3, 1, 1], &[0xCC]);
        let mut lost = deferred.clone();
        lost.link(LinkEvent::BusOff);
        deferred.clone().wait(1000);
        deferred.is_state(1, 3);
    }
    // Only another explicit connection can set the packet rate of one that is deferred.
    let mut bus = Ucmm::ucmm_server().established(0x03, &[2]);
    bus.asks(&[0x10, 5, 1, 12, 3], &[0x90]);
    for _ in 0..40 {
        bus.hears(POLL, &[1]);
        bus.skip();
        bus.wait(300);
    }
    bus.hears(0x782, &[63, 0x4B, 0, 0x31]);
    bus.sends(0x77F, &[2, 0xCB, 0, 0, 6, 0]);
    bus.hears(0x642, &[63, 0x10, 5, 1, 9, 100, 0]);
    bus.sends(0x63F, &[2, 0x90, 100, 0]);
    bus.hears(0x642, &[63, 0x05, 5, 1]);
    bus.sends(0x63F, &[2, 0x94, 0x0C, 0xFF]);
    assert_eq!(bus.slave.node.explicit.state(), ExplicitState::DeferredDelete);
}
