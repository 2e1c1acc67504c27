//! Moments that coincide, clocks that step back, slaves that are called late, controllers that refuse.

use core::time::Duration;

use cip_core::connection::ExplicitState;
use link_core::{Input, Instant, LinkEvent, TxOutcome, TxToken};

use super::bus::{
    Bus, CHECK, Full, G2o, MASTER, POLL, POLL_RESPONSE, REQUEST, RESPONSE, UNCONNECTED, block, config,
};
use crate::access::StateKind;
use crate::slave::SlaveEvent;

const ANSWER: [u8; 2] = [0x34, 0x12];

/// A slave that is called seconds late has missed nothing: both connections have timed out, in their order.
#[test]
fn polled_seconds_late() {
    let mut bus = G2o::g2o().established(0x03, &[2]);
    bus.hears(POLL, &[1]);
    bus.sends(POLL_RESPONSE, &ANSWER);
    bus.sleep(60_000);
    assert_eq!(bus.allocation(), (0, None));
    let states: std::vec::Vec<_> = bus
        .events
        .iter()
        .filter_map(|event| match event {
            SlaveEvent::Io { .. } => Some("io"),
            SlaveEvent::Explicit { .. } => Some("explicit"),
            _ => None,
        })
        .collect();
    assert_eq!(states, ["io", "explicit"]);
    // And one that is called late at its start gets on line all the same.
    let mut bus: G2o = Bus::dark(config(), block());
    bus.link(LinkEvent::Up);
    bus.sleep(60_000);
    assert_eq!(bus.slave.access().state().kind(), StateKind::WaitingDupMac);
    bus.sleep(60_000);
    assert_eq!(bus.slave.access().state().kind(), StateKind::OnLine);
}

#[test]
fn ticks_change_nothing_early_or_twice() {
    let mut bus = G2o::g2o().established(0x03, &[2]);
    bus.hears(POLL, &[1]);
    let before = bus.slave.clone();
    for _ in 0..3 {
        bus.input(Input::Tick);
    }
    assert_eq!(bus.slave, before);
}

#[test]
fn a_clock_that_steps_back() {
    let mut bus = G2o::g2o().established(0x03, &[2]);
    bus.hears(POLL, &[1]);
    bus.sends(POLL_RESPONSE, &ANSWER);
    let now = bus.now;
    bus.now = Instant::ZERO;
    bus.hears(POLL, &[2]);
    bus.sends(POLL_RESPONSE, &ANSWER);
    assert_eq!(bus.slave.node.timers.now(), now);
    bus.now = now;
    bus.wait(319);
    bus.is_state(2, 3);
    bus.wait(1);
    bus.is_state(2, 4);
}

/// Poll and bit-strobe end in the same tick, and with the last of them a deferred explicit connection.
#[test]
fn two_deadlines_in_one_tick() {
    let mut bus = Full::full().established(0x07, &[2, 3]);
    bus.asks(&[0x10, 5, 1, 12, 3], &[0x90]);
    for _ in 0..40 {
        bus.hears(POLL, &[1]);
        bus.hears(super::bus::STROBE, &[]);
        bus.skip();
        bus.skip();
        bus.wait(319);
    }
    assert_eq!(bus.slave.node.explicit.state(), ExplicitState::DeferredDelete);
    bus.events.clear();
    bus.wait(1);
    assert_eq!(bus.allocation(), (0, None));
    let ended: std::vec::Vec<_> = bus
        .events
        .iter()
        .filter_map(|event| match event {
            SlaveEvent::Io { connection, .. } => Some(connection.instance().0),
            SlaveEvent::Explicit { instance, .. } => Some(u16::from(*instance)),
            _ => None,
        })
        .collect();
    assert_eq!(ended, [2, 3, 1]);
}

/// The explicit connection and the last I/O connection end at the same moment: whichever is served first, both are gone.
#[test]
fn the_last_two_connections_at_once() {
    for action in [1, 3] {
        let mut bus = G2o::g2o().established(0x03, &[2]);
        bus.asks(&[0x10, 5, 1, 12, action], &[0x90]);
        bus.wait(9680);
        bus.hears(POLL, &[1]);
        bus.sends(POLL_RESPONSE, &ANSWER);
        bus.wait(319);
        assert_eq!(bus.allocation(), (0x03, Some(MASTER)));
        bus.wait(1);
        assert_eq!(bus.allocation(), (0, None), "action {action}");
    }
}

/// A node whose port delivers its own frames back: what it only sends it ignores.
#[test]
fn own_frames_are_ignored() {
    let mut bus = Full::full().established(0x07, &[2, 3]);
    let before = bus.slave.node.slots.clone();
    for id in [POLL_RESPONSE, super::bus::STROBE_RESPONSE, super::bus::COS, RESPONSE, 0x77F, 0x33F] {
        bus.hears(id, &[MASTER, 0x0E, 1, 1, 1]);
    }
    bus.sends_nothing();
    assert_eq!(bus.slave.node.slots, before);
    assert_eq!(bus.slave.counters().foreign, 6);
    assert_eq!(bus.events, []);
}

/// Remote frames and 29-bit identifiers are never obeyed.
#[test]
fn frames_that_are_not_devicenet() {
    let mut bus = G2o::g2o();
    let id = link_core::frame::standard_id(UNCONNECTED);
    bus.input(Input::Frame(link_core::Frame::remote(id, 6).unwrap()));
    let id = link_core::ExtendedId::new(UNCONNECTED.into()).unwrap();
    bus.input(Input::Frame(link_core::Frame::new(id, &[4, 0x4B, 3, 1, 1, 4]).unwrap()));
    bus.sends_nothing();
    assert_eq!(bus.slave.access().counters().foreign_frames, 2);
}

#[test]
fn answers_to_nothing_are_counted() {
    let mut bus = G2o::g2o();
    for token in [0, 1, 3, 8, 16, 64, 0x100, 0xFFFF] {
        bus.input(Input::TxDone(TxToken(token), TxOutcome::Sent));
    }
    let counted = bus.slave.counters().stray_tx_done + bus.slave.access().counters().stray_tx_done;
    assert_eq!(counted, 8);
}

/// A duplicate on line ends everything at once; what is in flight is withdrawn and nothing follows it.
#[test]
fn a_duplicate_while_everything_runs() {
    let mut bus = G2o::g2o().established(0x03, &[2]);
    bus.acknowledging = false;
    bus.hears(POLL, &[1]);
    bus.hears(REQUEST, &[MASTER, 0x0E, 1, 1, 7]);
    bus.hears(UNCONNECTED, &[MASTER, 0x4B, 3, 1, 1, 4]);
    bus.sends(POLL_RESPONSE, &ANSWER);
    bus.skip();
    bus.hears(CHECK, &[0x80, 0x34, 0x12, 1, 2, 3, 4]);
    assert_eq!(bus.slave.access().state().kind(), StateKind::CommFault);
    assert_eq!(bus.withdrawn.len(), 2);
    assert_eq!(bus.allocation(), (0, None));
    assert_eq!(bus.slave.application().outputs, [0]);
    bus.done(TxOutcome::Withdrawn);
    bus.done(TxOutcome::Sent);
    bus.hears(POLL, &[1]);
    bus.hears(UNCONNECTED, &[MASTER, 0x4B, 3, 1, 1, 4]);
    bus.wait(10_000);
    bus.sends_nothing();
}

/// After bus-off with BOI the node comes back without connections; the controller has dropped what it had.
#[test]
fn bus_off_and_back() {
    let mut bus = G2o::g2o().established(0x03, &[2]);
    bus.asks(&[0x10, 3, 1, 3, 1], &[0x90]);
    bus.acknowledging = false;
    bus.hears(POLL, &[1]);
    bus.skip();
    bus.link(LinkEvent::BusOff);
    assert_eq!(bus.withdrawn, []);
    bus.done(TxOutcome::Dropped);
    assert_eq!(bus.allocation(), (0, None));
    bus.acknowledging = true;
    bus.wait(100);
    bus.link(LinkEvent::Up);
    bus.wait(2000);
    bus.skip();
    bus.skip();
    let mut bus = bus.allocated(0x01);
    bus.asks(&[0x0E, 3, 1, 4], &[0x8E, 1]);
    bus.asks(&[0x10, 3, 1, 4, 9], &[0x90]);
    bus.asks(&[0x0E, 3, 1, 4], &[0x8E, 0]);
}

/// Histories of equal shape are equal once their age is taken away.
#[test]
fn time_can_be_shifted() {
    let early = G2o::g2o().established(0x03, &[2]);
    let mut late: G2o = Bus::dark(config(), block());
    late.now = Instant::from_millis(500);
    late.link(LinkEvent::Up);
    late.wait(2000);
    while late.skip_any() {}
    let mut late = late.established(0x03, &[2]);
    assert_ne!(early.slave, late.slave);
    late.slave.shift_time(Duration::from_millis(500));
    assert_eq!(early.slave, late.slave);
}

/// Any frame at all, in any state: nothing panics, nothing goes out that must not (the bus looks), time goes on.
#[test]
fn noise() {
    let mut seed = 0x2545_F491_4F6C_DD1D_u64;
    let mut next = move || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        seed
    };
    let ids = [
        REQUEST,
        UNCONNECTED,
        POLL,
        super::bus::STROBE,
        super::bus::COS_ACK,
        super::bus::MULTICAST,
        0x784,
        0x644,
        CHECK,
    ];
    let mut bus = super::bus::Ucmm::ucmm_server().established(0x0F, &[2, 3, 5]);
    let mut requests = 0;
    for round in 0..30_000_u32 {
        if round % 16 == 0 {
            bus.hears(UNCONNECTED, &[MASTER, 0x4B, 3, 1, 0x0F, MASTER]);
            for instance in [2, 3, 5] {
                bus.hears(REQUEST, &[MASTER, 0x10, 5, instance, 9, 80, 0]);
            }
            bus.hears(0x784, &[63, 0x4B, 0, 0x31]);
        }
        let random = next().to_le_bytes();
        let id = match random[0] {
            0..=250 => ids[usize::from(random[0]) % (ids.len() - 1)],
            _ => u16::from_le_bytes([random[1], random[2]]) & 0x7FF,
        };
        let mut data = next().to_le_bytes();
        if random[3] & 3 != 0 {
            data[0] = data[0] & 0xC0 | if id == 0x784 || id == 0x644 { 63 } else { MASTER };
        }
        if random[3] & 12 != 0 {
            data[1] = [0x0E, 0x10, 0x4B, 0x4C, 0x05, 0x09, 0x0D, 0x11][usize::from(random[4]) & 7];
            data[2] = 1 + (random[4] >> 3) % 5;
            data[3] = (random[5] & 7) + 1;
        }
        bus.hears(id, &data[..usize::from(random[6]) % 9]);
        bus.wait(u64::from(random[7]) % 64);
        while bus.skip_any() {}
        bus.events.clear();
        bus.links.clear();
        // A tool has set its MAC ID, or reset it, or a duplicate was heard.
        if !bus.slave.access().is_online() {
            requests += u32::from(bus.slave.counters().requests);
            bus = super::bus::Ucmm::ucmm_server().established(0x0F, &[2, 3, 5]);
        }
    }
    assert!(requests > 1000, "{requests} {:?}", bus.slave.counters());
}

/// A change shows here first: the smallest slave, with explicit messages of 32 bytes.
#[test]
#[cfg(target_pointer_width = "64")]
fn the_size_of_the_machine() {
    let application = size_of::<super::bus::Block>();
    assert_eq!(size_of::<crate::slave::Group2OnlyServer<super::bus::Block>>() - application, 672);
}

/// Attribute 5 is told whenever it changes, also when a connection that timed out is reset.
#[test]
fn a_reset_connection_is_allocated_again() {
    let mut bus = G2o::g2o().established(0x03, &[2]);
    bus.hears(POLL, &[1]);
    bus.sends(POLL_RESPONSE, &ANSWER);
    bus.wait(320);
    bus.events.clear();
    bus.asks(&[0x05, 5, 2], &[0x85]);
    let choice = cip_core::message::AllocationChoice::from_bits_retain(0x03);
    bus.tells(SlaveEvent::Allocation { choice, master: crate::MacId::new(MASTER) });
}

/// What timed out stays readable when nobody owns the slave any more; data do not flow for nobody.
#[test]
fn a_connection_of_nobody_cannot_be_reset() {
    let mut bus = super::bus::Ucmm::ucmm_server().established(0x03, &[2]);
    bus.hears(POLL, &[1]);
    bus.skip();
    bus.wait(320);
    bus.asks(&[0x4C, 3, 1, 1], &[0xCC]);
    assert_eq!(bus.allocation(), (0, None));
    // A client of the UCMM, with Message ID 0 of group 3.
    bus.hears(0x785, &[0x3F, 0x4B, 0, 0x30]);
    bus.skip();
    bus.hears(0x605, &[0x3F, 0x05, 5, 2]);
    bus.sends(0x63F, &[0x05, 0x94, 0x0C, 0xFF]);
    bus.hears(0x605, &[0x3F, 0x0E, 5, 2, 1]);
    bus.sends(0x63F, &[0x05, 0x8E, 4]);
}

/// A frame of a connection that has ended is with the controller still: what becomes of it is nothing to the next one.
#[test]
fn a_late_frame_of_an_old_connection() {
    let mut bus = Full::full().established(0x11, &[2]);
    bus.acknowledging = false;
    bus.hears(REQUEST, &[MASTER, 0x10, 5, 4, 9, 80, 0]);
    bus.sends(super::bus::COS, &ANSWER);
    bus.skip();
    bus.hears(REQUEST, &[MASTER, 0x4C, 3, 1, 0x10]);
    bus.hears(UNCONNECTED, &[MASTER, 0x4B, 3, 1, 0x10, MASTER]);
    bus.hears(REQUEST, &[MASTER, 0x10, 5, 4, 9, 80, 0]);
    bus.done(TxOutcome::Sent);
    assert_eq!(
        bus.slave.node.timers.at(crate::slave::timer::Timer::Acknowledge),
        None,
        "nothing was sent yet"
    );
    bus.sends(super::bus::COS, &ANSWER);
}
