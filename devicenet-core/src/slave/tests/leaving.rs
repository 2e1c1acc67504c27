//! A node that leaves the network, and what its controller is told then.

use link_core::{FilterSet, LinkCommand, LinkEvent, TxOutcome};

use super::bus::{Bus, Full, MASTER, REQUEST};
use crate::slave::{Application, SlaveEvent};

/// The filters that the controller was told since it was looked at last.
fn filters<A: Application, const DYNAMIC: usize>(bus: &mut Bus<A, DYNAMIC>) -> std::vec::Vec<FilterSet> {
    let filter = |command| if let LinkCommand::SetFilter(filter) = command { Some(filter) } else { None };
    bus.links.drain(..).filter_map(filter).collect()
}

/// Once the response has gone, before anything else is told.
#[test]
fn it_is_off_line_at_once() {
    let mut bus = Full::full().established(0x03, &[2]);
    bus.acknowledging = false;
    bus.hears(REQUEST, &[MASTER, 0x05, 1, 1]);
    assert!(bus.slave.access().is_online());
    bus.done(TxOutcome::Sent);
    assert_eq!(bus.allocation(), (0, None));
    assert!(
        matches!(bus.events.as_slice(), [SlaveEvent::Reset(_), SlaveEvent::Io { .. }, ..]),
        "{:?}",
        bus.events
    );
}

/// That it restarts the node is no change that would be told besides.
#[test]
fn a_reset_is_told_as_a_reset_alone() {
    let mut bus = Full::full().allocated(0x01);
    bus.asks(&[0x05, 1, 1], &[0x85]);
    let is_change = |event: &SlaveEvent| matches!(event, SlaveEvent::Changed { .. });
    assert!(!bus.events.iter().any(is_change), "{:?}", bus.events);
}

/// One for the check, one for the slave on line, one when bus-off has ended that.
#[test]
fn every_filter_is_told_once() {
    let mut bus = Full::full();
    assert_eq!(filters(&mut bus).len(), 2);
    let mut bus = bus.established(0x03, &[2]);
    filters(&mut bus);
    bus.link(LinkEvent::BusOff);
    assert_eq!(filters(&mut bus), [bus.slave.access().filter()]);
}

/// Until then the controller hears more than the check needs.
#[test]
fn after_a_reset_the_filter_is_told_on_line() {
    let mut bus = Full::full().established(0x03, &[2]);
    filters(&mut bus);
    bus.asks(&[0x05, 1, 1], &[0x85]);
    assert_eq!(filters(&mut bus), []);
    bus.wait(2000);
    assert!(bus.slave.access().is_online());
    assert_eq!(filters(&mut bus).last(), Some(&bus.slave.filter()));
}

/// That of the check with the new one; what was set is told.
#[test]
fn a_new_mac_id_has_its_filter() {
    let mut bus = Full::full().established(0x03, &[2]);
    filters(&mut bus);
    bus.asks(&[0x10, 3, 1, 1, 5], &[0x90]);
    assert_eq!(filters(&mut bus), [bus.slave.access().filter()]);
    bus.tells(SlaveEvent::Changed {
        class: cip_core::code::ClassId(3),
        instance: cip_core::code::InstanceId(1),
        service: cip_core::code::ServiceCode::SET_ATTRIBUTE_SINGLE,
    });
}

/// The bit rate before the controller starts again, and what it is to hear once it runs.
#[test]
fn the_order_of_commands() {
    let mut bus = Full::full().allocated(0x01);
    bus.asks(&[0x10, 3, 1, 2, 2], &[0x90]);
    bus.link(LinkEvent::BusOff);
    bus.links.clear();
    bus.slave.reset(bus.now);
    bus.drain();
    assert!(
        matches!(
            bus.links.as_slice(),
            [LinkCommand::SetMode(_), LinkCommand::Reset, LinkCommand::SetFilter(_)]
        ),
        "{:?}",
        bus.links
    );
}
