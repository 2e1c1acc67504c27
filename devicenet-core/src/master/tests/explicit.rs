//! The application's explicit requests.

use cip_core::code::{AttributeId, ClassId, InstanceId, ServiceCode};
use cip_core::message::{AttributeRequest, Request};

use super::super::*;
use super::bus::{Bus, config, mac};
use crate::client::StartError;
use std::string::ToString;

fn get(attribute: u16) -> AttributeRequest<'static> {
    AttributeRequest::get(ClassId::IDENTITY, InstanceId(1), AttributeId(attribute))
}

#[track_caller]
fn asks(bus: &mut Bus, attribute: u16) {
    bus.command(|master, now| master.request_attribute(now, mac(63), &get(attribute), 1)).unwrap();
}

#[test]
fn a_request_beside_the_scan() {
    let mut bus = Bus::running(config());
    asks(&mut bus, 6);
    let busy = bus.command(|master, now| master.request_attribute(now, mac(63), &get(6), 1));
    assert_eq!(busy, Err(CommandError::Busy));
    bus.sends("5FD:");
    bus.sends("5FC: 44 0E 01 01 06");
    bus.hears("3FF: 34 12");
    assert_eq!(bus.master.response(mac(63)), None);
    bus.hears("5FB: 44 8E 44 33 22 11");
    bus.tells("slave 63: response");
    let response = bus.master.response(mac(63)).unwrap();
    assert_eq!(response.to_string(), "Get_Attribute_Single ok, data 44 33 22 11");
}

#[test]
fn a_long_answer() {
    let mut bus = Bus::running(config());
    asks(&mut bus, 7);
    bus.sends("5FD:");
    bus.sends("5FC: 44 0E 01 01 07");
    bus.hears("5FB: C4 00 8E 08 47 52 54 31");
    bus.sends("5FC: 44 C0 00".replace("44 C0", "C4 C0").as_str());
    bus.hears("5FB: C4 81 2D 44 52 54");
    bus.tells("slave 63: response");
    bus.sends("5FC: C4 C1 00");
    let response = bus.master.response(mac(63)).unwrap();
    assert_eq!(response.to_string(), "Get_Attribute_Single ok, data 08 47 52 54 31 2D 44 52 54");
}

/// The explicit connection timed out ten seconds after the last message on it: the owner allocates it again.
#[test]
fn a_connection_that_timed_out_is_made_anew() {
    let mut bus = Bus::running(Config { interscan_delay: core::time::Duration::from_secs(60), ..config() });
    bus.sends("5FD:");
    bus.hears("3FF: 34 12");
    asks(&mut bus, 1);
    bus.sends("5FC: 44 0E 01 01 01");
    for _ in 0..25 {
        bus.hears("3FF: 34 12");
        bus.wait(100);
    }
    bus.sends("5FE: 04 4B 03 01 01 04");
    bus.hears("5FB: 04 CB 00");
    bus.sends("5FC: 44 0E 01 01 01");
    bus.hears("5FB: 44 8E E7 03");
    bus.tells("slave 63: response");
    // The I/O was not touched.
    bus.is(63, SlaveState::Running, ScannerStatus::NORMAL);
}

#[test]
fn a_slave_that_does_not_answer() {
    let mut bus = Bus::running(Config { interscan_delay: core::time::Duration::from_secs(60), ..config() });
    bus.sends("5FD:");
    asks(&mut bus, 1);
    bus.sends("5FC: 44 0E 01 01 01");
    for _ in 0..25 {
        bus.hears("3FF: 34 12");
        bus.wait(100);
    }
    for _ in 0..2 {
        bus.sends("5FE: 04 4B 03 01 01 04");
        for _ in 0..10 {
            bus.hears("3FF: 34 12");
            bus.wait(100);
        }
    }
    bus.tells("slave 63: request failed: no response: the node is absent, or its connection is gone");
    assert_eq!(bus.master.response(mac(63)), None);
    assert_eq!(bus.master.slave_counters(mac(63)).unwrap().explicit_failed, 1);
}

#[test]
fn a_request_of_a_slave_that_is_lost_fails_with_it() {
    let mut bus = Bus::running(config());
    asks(&mut bus, 1);
    bus.sends("5FD:");
    bus.sends("5FC: 44 0E 01 01 01");
    bus.wait(320);
    bus.tells("slave 63: request failed: no response: the node is absent, or its connection is gone");
    let refused = bus.command(|master, now| master.request_attribute(now, mac(63), &get(1), 1));
    assert_eq!(refused, Err(CommandError::NotRunning));
}

#[test]
fn requests_that_cannot_be_sent() {
    let mut bus = Bus::running(config());
    let long = [0; 40];
    let request = Request::new(ServiceCode(0x32), ClassId(0x64), InstanceId(1), &long);
    let refused = bus.command(|master, now| master.request(now, mac(63), &request, 1));
    assert_eq!(refused, Err(CommandError::Request(StartError::TooLong { capacity: 32 })));
    let request = Request::new(ServiceCode(0x32), ClassId(0x300), InstanceId(1), &[]);
    let refused = bus.command(|master, now| master.request(now, mac(63), &request, 1)).unwrap_err();
    assert!(matches!(refused, CommandError::Request(StartError::NotAddressable(_))));
    asks(&mut bus, 1);
}
