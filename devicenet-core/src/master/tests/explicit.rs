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

/// A request that may not be carried out twice is not repeated when only its response may have been lost.
#[test]
fn a_request_is_repeated_only_if_it_may_be() {
    for tries in [1, 2] {
        let mut bus =
            Bus::running(Config { interscan_delay: core::time::Duration::from_secs(60), ..config() });
        bus.sends("5FD:");
        bus.hears("3FF: 34 12");
        bus.command(|master, now| master.request_attribute(now, mac(63), &get(1), tries)).unwrap();
        for _ in 0..tries {
            bus.sends("5FC: 44 0E 01 01 01");
            for _ in 0..25 {
                bus.hears("3FF: 34 12");
                bus.wait(100);
            }
        }
        bus.sends("5FE: 04 4B 03 01 01 04");
        bus.hears("5FB: 04 94 0B 02");
        assert_eq!(bus.try_sends("5FC: 44 0E 01 01 01"), tries > 1);
    }
}

/// What was refused is no response.
#[test]
fn after_a_refused_request_there_is_no_response() {
    let mut bus = Bus::running(config());
    // As bytes they would pass for a response.
    let data = [0x8E, 1, 2];
    let request = Request::new(ServiceCode(0x32), ClassId(0x300), InstanceId(1), &data);
    bus.command(|master, now| master.request(now, mac(63), &request, 1)).unwrap_err();
    assert_eq!(bus.master.response(mac(63)), None);
}

/// With a UCMM-capable slave: the last fragment of a long answer is acknowledged before the connection is closed, and a
/// connection that is closed already is not closed again.
#[test]
fn a_connection_for_one_request() {
    let entry = ScanEntry::explicit_only(mac(63));
    let mut bus = Bus::online(Config { first_contact: FirstContact::Ucmm, ..config() }, &[entry]);
    for (request, response) in [
        ("784: 3F 4B 02 34", "77F: 04 CB 02 04 06 00"),
        ("704: 7F 0E 01 00 01 00 01", "73F: 44 8E BB 02"),
        ("704: 3F 0E 01 00 01 00 02", "73F: 04 8E 00 00"),
        ("704: 7F 0E 01 00 01 00 03", "73F: 44 8E 01 00"),
        ("784: 3F 4C 06 00", "77F: 04 CC"),
    ] {
        assert!(bus.master.filter().accepts(&super::bus::frame(response)), "{response}");
        bus.sends(request);
        bus.hears(response);
    }
    bus.is(63, SlaveState::Running, ScannerStatus::NORMAL);
    asks(&mut bus, 7);
    bus.sends("784: 7F 4B 02 34");
    bus.hears("77F: 44 CB 02 04 07 00");
    bus.sends("704: 3F 0E 01 00 01 00 07");
    bus.hears("73F: 84 00 8E 08 47 52 54 31");
    bus.sends("704: BF C0 00");
    bus.hears("73F: 84 81 2D 44 52 54");
    bus.tells("slave 63: response");
    bus.sends("704: BF C1 00");
    bus.sends("784: 7F 4C 07 00");
    bus.hears("77F: 44 CC");
    // Now nobody opens: there is nothing to close.
    asks(&mut bus, 1);
    for _ in 0..2 {
        bus.sends("784: 3F 4B 02 34");
        bus.wait(1000);
    }
    bus.tells("slave 63: request failed: no response: the node is absent, or its connection is gone");
    bus.sends_nothing();
}
