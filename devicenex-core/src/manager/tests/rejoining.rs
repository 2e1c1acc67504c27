//! Another node has the address of the manager.

use std::vec::Vec;

use super::bus::*;
use crate::access::StateKind;
use crate::id::Direction;
use crate::manager::{Config, DeviceState, ManagerEvent};
use crate::message::Roam;

impl Bus {
    /// A stranger is on line with the address of the manager, and says so.
    fn displace(&mut self) {
        let own = self.manager.access().address().number();
        self.hello(own, Direction::Response, STRANGER);
        assert!(self.manager.access().address().is_none());
    }

    /// Until the controller has a Hello with an address, or for a minute.
    fn waits_for_hello(&mut self) -> u64 {
        for millis in 0..60_000 {
            if !self.manager.access().address().is_none() {
                return millis;
            }
            self.wait_on_the_bus(1);
        }
        60_000
    }

    fn tried(&self) -> Vec<u8> {
        let tried = self.events.iter().filter_map(|event| match event {
            ManagerEvent::Rejoins(address) => Some(address.number()),
            _ => None,
        });
        tried.collect()
    }
}

/// Its own once more, since whoever had it may have given it up as well; then it works again as after a restart.
#[test]
fn it_takes_its_own_address_back() {
    let mut bus = Bus::running();
    bus.events.clear();
    bus.displace();
    bus.is(67, DeviceState::Idle);
    // Two Hellos without an address, and ten seconds of silence.
    assert!((11_999..=12_001).contains(&bus.waits_for_hello()));
    assert_eq!(bus.tried(), [1]);
    assert!(!bus.manager.access().is_online());
    bus.wait_on_the_bus(2000);
    assert!(bus.manager.works());
    assert_eq!(bus.manager.access().address(), oa(1));
    bus.is(67, DeviceState::Probing);
    assert_eq!(
        bus.tells(),
        [
            "does nothing any more",
            "tries OA 1",
            "looks for all planned devices",
            "OA 67: Idle -> Probing: started"
        ]
    );
}

/// Whoever has it goes on having it: the next address, and not one that is planned.
#[test]
fn it_takes_the_next_address_that_is_free() {
    let mut near = producer();
    near.address = oa(2);
    near.identity.serial = Some(2);
    let mut bus = Bus::on_line(config(), [producer(), near]);
    for last in [1, 3, 4] {
        bus.displace();
        bus.waits_for_hello();
        assert_eq!(bus.tried().last(), Some(&last));
    }
    bus.wait_on_the_bus(2000);
    assert!(bus.manager.works());
    // The questions come from its new address now.
    let sent = bus.wait_on_the_bus(500);
    assert!(sent.is_empty() || sent.iter().all(|frame| !frame.starts_with("1C8602")), "{sent:?}");
    bus.manager.remove_device(oa(67)).unwrap();
    bus.manager.add_device(bus.now, producer()).unwrap();
    assert_eq!(bus.wait_on_the_bus(0)[0][..6], *"1C8608", "from OA 4 to OA 67");
    // Nobody else is planned there, nor at the address that it is to have.
    for address in [1, 4] {
        let plan = crate::manager::PlannedDevice { address: oa(address), ..producer() };
        let refused = bus.manager.add_device(bus.now, plan);
        assert_eq!(refused, Err(crate::manager::DatabaseError::OwnAddress(oa(address))));
    }
    bus.manager.reset(bus.now);
    bus.waits_for_hello();
    assert_eq!(bus.manager.access().address(), oa(1), "a restart begins anew");
}

/// From the last address to the first.
#[test]
fn it_goes_round() {
    let mut config = config();
    config.node.access.role =
        crate::access::Role::NetworkManager { address: oa(126), bit_rate: link_core::BitRate::K500 };
    let mut bus = Bus::on_line(config, []);
    for last in [126, 0] {
        bus.displace();
        bus.waits_for_hello();
        assert_eq!(bus.tried().last(), Some(&last));
    }
}

/// The answer to its Hello is as good as an announcement.
#[test]
fn it_is_refused_an_address_while_it_says_hello() {
    let mut bus = Bus::on_line(config(), []);
    bus.displace();
    bus.waits_for_hello();
    bus.wait_on_the_bus(500);
    bus.displace();
    bus.waits_for_hello();
    assert_eq!(bus.tried(), [1, 2]);
}

/// Another manager gives it an address: that one works. Where the address is planned, this one goes on to one that is not.
#[test]
fn it_obeys_another_manager() {
    for (given, then) in [(9, 9), (67, 1)] {
        let mut bus = Bus::on_line(config(), [producer()]);
        bus.displace();
        bus.wait_on_the_bus(2500);
        assert_eq!(bus.manager.access().state().kind(), StateKind::Standby);
        let device = bus.manager.access().config().device;
        bus.frame(Roam { target: device, requested: oa(given) }.frame().unwrap());
        bus.wait_on_the_bus(4001);
        assert_eq!(bus.manager.access().address(), oa(then));
        assert!(!bus.manager.works(), "the other works");
        bus.wait_on_the_bus(60_000);
        assert_eq!(bus.manager.access().address(), oa(then), "and keeps it");
    }
}

#[test]
fn it_waits_if_it_is_told_to() {
    let mut bus = Bus::on_line(Config { rejoin_after: 0, ..config() }, [producer()]);
    bus.displace();
    assert_eq!(bus.waits_for_hello(), 60_000);
    assert_eq!(bus.tried(), []);
    assert_eq!(bus.manager.access().state().kind(), StateKind::Standby);
}

/// One that leaves the work to another wants an address as well, and goes on leaving it.
#[test]
fn it_rejoins_without_work() {
    let mut bus = Bus::on_line(config(), [producer()]);
    bus.manager.suspend(bus.now);
    bus.displace();
    bus.waits_for_hello();
    bus.wait_on_the_bus(2000);
    assert!(bus.manager.access().is_online());
    assert!(!bus.manager.works());
}
