//! A second manager on the bus.

use super::bus::*;
use crate::manager::{Config, DeviceState, ManagerEvent};
use crate::message::Roam;

fn told(bus: &Bus, serial_low: Option<u16>, yields: bool) -> usize {
    let event = ManagerEvent::SecondManager { serial_low, yields };
    bus.events.iter().filter(|other| **other == event).count()
}

/// Seen before it has asked for the first time, even while it says Hello: it is the second.
#[test]
fn who_sees_another_before_it_asks_is_the_second() {
    let mut joining = Bus::power_up(config(), [producer()]);
    joining.acknowledges();
    for mut bus in [joining, Bus::probing()] {
        bus.mini_who(0x9999);
        assert_eq!(told(&bus, Some(0x9999), true), 1);
        bus.mini_who(0x9999);
        assert_eq!(told(&bus, Some(0x9999), true), 1, "told once");
        let sent = bus.wait_on_the_bus(60_000);
        assert!(!sent.iter().any(|frame| frame.contains("remote") || frame.starts_with("1E")), "{sent:?}");
        bus.is(67, DeviceState::Idle);
        bus.manager.resume(bus.now);
        bus.is(67, DeviceState::Probing);
    }
    let mut bus = Bus::probing();
    bus.frame(Roam { target: STRANGER, requested: oa(9) }.frame().unwrap());
    assert_eq!(told(&bus, None, true), 1);
    assert!(!bus.manager.works());
}

/// Of two that work already, the one with the lower half serial number goes on. 0x0100 is this one's.
#[test]
fn of_two_that_work_one_goes_on() {
    for (other, yields) in [(0x00FF, true), (0x0100, false), (0x0101, false)] {
        let mut bus = Bus::missing();
        bus.mini_who(other);
        assert_eq!(told(&bus, Some(other), yields), 1, "{other:04X}");
        assert_eq!(bus.manager.works(), !yields, "{other:04X}");
    }
    // A ROAM does not tell whose it is.
    let mut bus = Bus::missing();
    bus.frame(Roam { target: STRANGER, requested: oa(9) }.frame().unwrap());
    assert_eq!(told(&bus, None, false), 1);
}

#[test]
fn it_takes_over_when_the_other_is_silent() {
    let mut bus = Bus::on_line(Config { takeover_after: 30_000, ..config() }, [producer()]);
    bus.mini_who(0x0001);
    bus.wait_on_the_bus(20_000);
    bus.mini_who(0x0001);
    bus.wait_on_the_bus(29_999);
    assert!(!bus.manager.works());
    bus.wait_on_the_bus(1);
    assert!(bus.manager.works());
    bus.is(67, DeviceState::Probing);
}

/// Its own work is given up in the middle of everything, and taken up again.
#[test]
fn work_is_left_and_taken_up_again() {
    for mut bus in
        [Bus::found(), Bus::assigned(), Bus::connecting(), Bus::running(), Bus::retrying(), Bus::lost()]
    {
        bus.manager.suspend(bus.now);
        bus.input(link_core::Input::Tick);
        bus.is(67, DeviceState::Idle);
        assert_eq!(bus.wait_on_the_bus(20_000).iter().filter(|frame| !frame.starts_with("1F03")).count(), 0);
        bus.manager.resume(bus.now);
        bus.wait_on_the_bus(3000);
        bus.is(67, DeviceState::Missing);
    }
}
