//! Connection requests: every answer of the table in `connect`.

use super::bus::Bus;

/// The worked example of section 5 of the paper, as far as one device sees it.
#[test]
fn a_producer_is_set_up_by_one_request() {
    let mut bus = Bus::new();
    // P, 29-bit implicit, Message ID 0; instance 7, EPR 500 ms, action 0.
    bus.hears(0x1D86_0209, &[0x4B, 0xC0, 7, 0, 0xF4, 1, 0]);
    bus.sends(0x0086_0007, &[0x34, 0x12]);
    bus.sends(0x1D03_8609, &[0x4B, 0xC0, 0, 0xF4, 1]);
    assert_eq!(bus.told(), ["multicast, producing, 29 bits: Non-existent -> Established: Allocate"]);
    bus.wait(499);
    bus.is_silent();
    bus.wait(1);
    bus.sends(0x0086_0007, &[0x34, 0x12]);
}

#[test]
fn a_consumer_consumes_what_attribute_5_says() {
    let mut bus = Bus::explicit();
    // Instance 13, EPR 0, action 0.
    bus.connects(&[0x4B, 0xC0, 13, 0, 0, 0, 0], &[0x4B, 0xC0, 0, 0, 0]);
    // Until it is told: instance 7 of the requester.
    bus.asks(&[0x0E, 5, 13, 5], &[0x8E, 7, 0, 2, 0x80]);
    // OA 5, Message ID 2, instance 7.
    bus.asks(&[0x10, 5, 13, 5, 7, 0, 0x0A, 0x82], &[0x90]);
    bus.asks(&[0x0E, 5, 13, 5], &[0x8E, 7, 0, 0x0A, 0x82]);
    bus.hears(0x020A_0007, &[0x55]);
    assert_eq!(bus.node.application().outputs, [0x55]);
    bus.wait(3_600_000);
    assert_eq!(bus.state(13), 3);
}
