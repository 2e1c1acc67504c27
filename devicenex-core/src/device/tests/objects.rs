//! What the objects of a device say and take.

use super::bus::Bus;
use crate::access::StateKind;

/// Attribute by attribute: the number, and the value.
#[track_caller]
fn has(bus: &mut Bus, instance: u8, attributes: &[(u8, &[u8])]) {
    for (attribute, value) in attributes {
        bus.sent.clear();
        bus.hears(0x1086_0205, &[0x0E, 5, instance, *attribute]);
        let frames: std::vec::Vec<u8> = match bus.sent.len() {
            1 => bus.sent[0].data().to_vec(),
            _ => panic!("{:?}", bus.trace()),
        };
        let (read, whole) = (&frames[..], [&[0x8E], *value].concat());
        // Nine bytes are a fragment more than a frame holds: its first part says enough.
        if whole.len() > 8 {
            assert_eq!(read, [&[5], &whole[..7]].concat(), "attribute {attribute}");
        } else {
            assert_eq!(read, whole, "attribute {attribute}");
        }
    }
    bus.sent.clear();
}

#[test]
fn attributes_of_connections() {
    let mut bus = Bus::explicit();
    bus.connects(&[0x4B, 0xC2, 3, 0, 100, 0, 0], &[0x4B, 0xC2, 0, 100, 0]);
    bus.connects(&[0x4B, 0x83, 2, 0, 0, 0, 2], &[0x4B, 0x83, 0, 0, 0]);
    bus.connects(&[0x4B, 0xC2, 9, 0, 0, 0, 0], &[0x4B, 0xC2, 0, 0, 0]);
    bus.connects(&[0x4B, 0xC2, 13, 0, 0, 0, 0], &[0x4B, 0xC2, 0, 0, 0]);
    bus.connects(&[0x4B, 0xC2, 7, 0, 0, 0, 0], &[0x4B, 0xC2, 0, 0, 0]);
    has(
        &mut bus,
        1,
        &[
            (1, &[3]),
            (2, &[0]),
            (3, &[0x83]),
            // 10000 0000001 1 1000011 0 00000000; 10000 1000011 0 0000001 0 00000000
            (4, &[0x00, 0x86, 0x03, 0x90]),
            (5, &[0x00, 0x02, 0x86, 0x90]),
            (6, &[0x55]),
            (7, &[40, 0]),
            (8, &[40, 0]),
            (9, &[0, 0]),
            (12, &[1]),
            (13, &[0, 0]),
            (14, &[]),
            (15, &[0, 0]),
            (16, &[]),
            (17, &[0, 0]),
            (18, &[0]),
        ],
    );
    has(
        &mut bus,
        3,
        &[
            (1, &[3]),
            (2, &[1]),
            (3, &[0x82]),
            (4, &[0x03, 0x00, 0x86, 0x82]),
            (5, &[0x03, 0xC3, 0x02, 0x82]),
            (6, &[0x44]),
            (7, &[2, 0]),
            (8, &[1, 0]),
            (9, &[100, 0]),
            (12, &[0]),
            (13, &[6, 0]),
            (14, &[0x20, 0x04, 0x24, 0x01, 0x30, 0x03]),
            (15, &[6, 0]),
            (16, &[0x20, 0x04, 0x24, 0x64, 0x30, 0x03]),
        ],
    );
    // Group 1, Message ID 3, of OA 67 and of OA 1.
    has(&mut bus, 2, &[(4, &[0xC3, 0x01, 0, 0]), (5, &[0x81, 0x01, 0, 0]), (6, &[0x00]), (12, &[2])]);
    has(
        &mut bus,
        9,
        &[
            (3, &[0x12]),
            (4, &[0x09, 0x00, 0x86, 0x82]),
            (5, &[0x09, 0xC3, 0x03, 0x82]),
            (8, &[0, 0]),
            (15, &[4, 0]),
            (16, &[0x20, 0x2B, 0x24, 0x01]),
        ],
    );
    has(
        &mut bus,
        13,
        &[
            (3, &[0x80]),
            (4, &[0xFF; 4]),
            (5, &[0x07, 0x00, 0x02, 0x82]),
            (6, &[0xF4]),
            (7, &[0, 0]),
            (13, &[0, 0]),
        ],
    );
    has(&mut bus, 7, &[(3, &[0x10]), (5, &[0xFF; 4]), (6, &[0x4F]), (8, &[0, 0]), (15, &[0, 0])]);
    bus.asks(&[0x0E, 5, 3, 10], &[0x94, 0x14, 0xFF]);
    bus.asks(&[0x0E, 5, 5, 1], &[0x94, 0x16, 0xFF]);
    bus.asks(&[0x0E, 5, 0, 1], &[0x8E, 1, 0]);
    // In ascending order.
    bus.hears(0x1086_0205, &[0x11, 5, 0, 6]);
    bus.sends(0x1003_8700, &[5, 0x91, 6, 1, 0, 2, 0, 3]);
}

#[test]
fn what_can_be_set() {
    let mut bus = Bus::explicit();
    for instance in [3, 7, 9, 13] {
        bus.connects(&[0x4B, 0xC2, instance, 0, 100, 0, 0], &[0x4B, 0xC2, 0, 100, 0]);
    }
    bus.connects(&[0x4B, 0x40], &[0x4B, 0x40, 0, 128, 0]);
    const READ_ONLY: [u8; 3] = [0x94, 0x0E, 0xFF];
    const INVALID: [u8; 3] = [0x94, 0x09, 0xFF];
    for (request, response) in [
        (&[0x10, 5, 1, 9, 75, 0][..], &[0x90, 80, 0][..]),
        (&[0x10, 5, 1, 9, 0xFF, 0xFF], &INVALID),
        (&[0x10, 5, 1, 9, 75], &[0x94, 0x13, 0xFF]),
        (&[0x10, 5, 1, 9, 75, 0, 0], &[0x94, 0x15, 0xFF]),
        (&[0x10, 5, 1, 12, 3], &[0x90]),
        (&[0x10, 5, 1, 12, 0], &INVALID),
        (&[0x10, 5, 1, 18, 1], &[0x90]),
        (&[0x10, 5, 1, 18, 8], &INVALID),
        (&[0x10, 5, 1, 17, 0, 0], &READ_ONLY),
        (&[0x10, 5, 1, 3, 0x83], &READ_ONLY),
        (&[0x10, 5, 1, 5, 0, 0, 0, 0x80], &READ_ONLY),
        (&[0x10, 5, 1, 1, 3], &READ_ONLY),
        (&[0x10, 5, 3, 9, 200, 0], &[0x90, 200, 0]),
        (&[0x10, 5, 3, 12, 2], &[0x90]),
        (&[0x10, 5, 3, 12, 3], &INVALID),
        (&[0x10, 5, 3, 17, 200, 0], &[0x90]),
        (&[0x10, 5, 3, 9, 100, 0], &INVALID),
        (&[0x10, 5, 3, 18, 7], &[0x90]),
        (&[0x10, 5, 3, 3, 0x82], &READ_ONLY),
        (&[0x10, 5, 3, 5, 3, 0, 0x0A, 0x80], &READ_ONLY),
        (&[0x10, 5, 3, 14, 0x20, 4, 0x24], &READ_ONLY),
        (&[0x10, 5, 3, 4, 0, 0, 0, 0], &READ_ONLY),
        (&[0x10, 5, 7, 3, 0x12], &READ_ONLY),
        (&[0x10, 5, 9, 3, 0x10], &[0x90]),
        (&[0x10, 5, 9, 3, 0x00], &INVALID),
        (&[0x10, 5, 9, 3], &[0x94, 0x13, 0xFF]),
        (&[0x10, 5, 13, 5, 7, 0, 0x0A], &[0x94, 0x13, 0xFF]),
        (&[0x10, 5, 13, 5, 7, 0, 0x0A, 0x80], &[0x90]),
        // An acknowledge, 11 bits, OA 127, the own address, an explicit identifier, none at all.
        (&[0x10, 5, 13, 5, 7, 0, 0x0B, 0x80], &INVALID),
        (&[0x10, 5, 13, 5, 5, 1, 0, 0], &INVALID),
        (&[0x10, 5, 13, 5, 7, 0, 0xFE, 0x80], &INVALID),
        (&[0x10, 5, 13, 5, 7, 0, 0x86, 0x80], &INVALID),
        (&[0x10, 5, 13, 5, 0, 2, 0x0A, 0x90], &INVALID),
        (&[0x10, 5, 13, 5, 7, 0, 0x0A, 0xC0], &INVALID),
        (&[0x10, 5, 128, 3, 0x83], &INVALID),
        (&[0x10, 5, 128, 3, 0x80], &[0x90]),
        (&[0x10, 5, 128, 5, 5, 1, 0, 0], &[0x90]),
        (&[0x0E, 5, 128, 5], &[0x8E, 5, 1, 0, 0]),
        // As by default again.
        (&[0x10, 5, 128, 5, 0xFF, 0xFF, 0xFF, 0xFF], &[0x90]),
        (&[0x0E, 5, 128, 5], &[0x8E, 0x80, 0xC3, 0x02, 0x80]),
        (&[0x0D, 5, 128], &[0x8D]),
        // Established: too late.
        (&[0x10, 5, 128, 3, 0x80], &[0x94, 0x0C, 0xFF]),
        (&[0x10, 5, 128, 5, 5, 1, 0, 0], &[0x94, 0x0C, 0xFF]),
    ] {
        bus.forget();
        bus.asks(request, response);
        let changed = request[0] != 0x0E && response[0] == request[0] | 0x80;
        let told = bus.told().iter().any(|line| line.ends_with("done"));
        assert_eq!(told, changed, "{request:02X?}");
    }
}

#[test]
fn an_assembly_is_selected() {
    let mut bus = Bus::explicit();
    bus.connects(&[0x4B, 0x40], &[0x4B, 0x40, 0, 128, 0]);
    // Nine and more bytes come in fragments.
    let mut select = |attribute: u8, path: &[u8], answer: &[u8]| {
        let body = [&[0x10, 5, 128, attribute], path].concat();
        bus.hears(0x1086_0300, &[&[9], &body[..7]].concat());
        bus.hears(0x1086_0381, &body[7..]);
        bus.sends_besides(0x1003_8609, answer);
        bus.forget();
    };
    select(14, &[0x20, 0x04, 0x24, 0x02, 0x30, 0x03], &[0x90]);
    // No assembly; one that is not there; one that is too long; not the device's choice.
    select(14, &[0x20, 0x04, 0x24, 0x0A, 0x30, 0x03], &[0x94, 0x09, 0xFF]);
    select(14, &[0x20, 0x01, 0x24, 0x01, 0x30, 0x03], &[0x94, 0x09, 0xFF]);
    select(14, &[0x20, 0x04, 0x24, 0x05, 0x30, 0x03], &[0x94, 0x09, 0xFF]);
    select(16, &[0x20, 0x04, 0x24, 0x01, 0x30, 0x03], &[0x94, 0x09, 0xFF]);
    bus.asks(&[0x0E, 5, 128, 7], &[0x8E, 16, 0]);
    bus.asks(&[0x0D, 5, 128], &[0x8D]);
    bus.hears(0x1086_0300, &[9, 0x10, 5, 128, 14, 0x20, 0x04, 0x24]);
    bus.hears(0x1086_0381, &[0x01, 0x30, 0x03]);
    bus.sends_besides(0x1003_8609, &[0x94, 0x0C, 0xFF]);
}

#[test]
fn services_of_connections() {
    let mut bus = Bus::explicit();
    bus.connects(&[0x4B, 0xC2, 13, 0, 100, 0, 0], &[0x4B, 0xC2, 0, 100, 0]);
    bus.wait(10_000);
    assert_eq!(bus.state(13), 4);
    for (request, response) in [
        (&[0x05, 5, 13][..], &[0x85][..]),
        (&[0x0D, 5, 13], &[0x94, 0x0C, 0xFF]),
        (&[0x0D, 5, 1], &[0x94, 0x08, 0xFF]),
        (&[0x05, 5, 13, 0], &[0x94, 0x15, 0xFF]),
        (&[0x09, 5, 13, 0], &[0x94, 0x15, 0xFF]),
        (&[0x4B, 5, 13], &[0x94, 0x08, 0xFF]),
        (&[0x05, 5, 3], &[0x94, 0x16, 0xFF]),
        (&[0x05, 5, 0], &[0x85]),
        (&[0x09, 5, 13], &[0x89]),
        (&[0x09, 5, 13], &[0x94, 0x16, 0xFF]),
    ] {
        bus.asks(request, response);
    }
    bus.connects(&[0x4B, 0x40], &[0x4B, 0x40, 0, 128, 0]);
    bus.asks(&[0x09, 5, 0], &[0x89]);
    assert_eq!(bus.node.connections().count(), 0);
}

#[test]
fn the_link_object() {
    let mut bus = Bus::explicit();
    bus.connects(&[0x4B, 0xC2, 13, 0, 0, 0, 0], &[0x4B, 0xC2, 0, 0, 0]);
    for (request, response) in [
        (&[0x0E, 3, 1, 1][..], &[0x8E, 67][..]),
        (&[0x0E, 3, 1, 2], &[0x8E, 2]),
        (&[0x0E, 3, 1, 3], &[0x8E, 0]),
        (&[0x0E, 3, 1, 4], &[0x8E, 0]),
        (&[0x0E, 3, 1, 5], &[0x8E, 2, 1, 13]),
        (&[0x0E, 3, 1, 6], &[0x8E, 0xE8, 0x03]),
        (&[0x0E, 3, 1, 7], &[0x94, 0x14, 0xFF]),
        (&[0x0E, 3, 2, 1], &[0x94, 0x16, 0xFF]),
        (&[0x0E, 3, 0, 1], &[0x8E, 1, 0]),
        (&[0x10, 3, 1, 2, 1], &[0x94, 0x0E, 0xFF]),
        (&[0x10, 3, 1, 5, 1], &[0x94, 0x0E, 0xFF]),
        (&[0x10, 3, 1, 3, 1], &[0x90]),
        (&[0x0E, 3, 1, 3], &[0x8E, 1]),
        (&[0x10, 3, 1, 3, 2], &[0x94, 0x09, 0xFF]),
        (&[0x10, 3, 1, 4, 0], &[0x90]),
        (&[0x10, 3, 1, 4, 1], &[0x94, 0x09, 0xFF]),
        (&[0x10, 3, 1, 6, 0xF4, 0x01], &[0x90]),
        (&[0x0E, 3, 1, 6], &[0x8E, 0xF4, 0x01]),
        (&[0x10, 3, 1, 6, 0, 0], &[0x94, 0x09, 0xFF]),
        (&[0x10, 3, 1, 6, 1], &[0x94, 0x13, 0xFF]),
        (&[0x10, 3, 1, 1, 128], &[0x94, 0x09, 0xFF]),
        (&[0x10, 3, 1, 1], &[0x94, 0x13, 0xFF]),
        (&[0x4B, 3, 1, 1, 1], &[0x94, 0x08, 0xFF]),
    ] {
        bus.asks(request, response);
    }
    assert_eq!(bus.node.access().state().kind(), StateKind::Online);
}

#[test]
fn other_objects() {
    let mut bus = Bus::explicit();
    // Owned as soon as there is an I/O connection.
    bus.asks(&[0x0E, 1, 1, 5], &[0x8E, 0, 0]);
    bus.connects(&[0x4B, 0xC2, 9, 0, 0, 0, 0], &[0x4B, 0xC2, 0, 0, 0]);
    for (request, response) in [
        (&[0x0E, 1, 1, 5][..], &[0x8E, 1, 0][..]),
        (&[0x0E, 2, 1, 1], &[0x94, 0x14, 0xFF]),
        (&[0x0E, 0x2B, 1, 1], &[0x8E, 16, 0]),
        (&[0x10, 0x2B, 1, 1, 30, 0], &[0x90, 30, 0]),
        (&[0x0E, 0x2B, 1, 3], &[0x8E, 9, 0]),
        (&[0x10, 0x2B, 1, 3, 11, 0], &[0x94, 0x0C, 0xFF]),
        (&[0x10, 0x2B, 1, 3, 4, 0], &[0x94, 0x09, 0xFF]),
        (&[0x0E, 4, 1, 3], &[0x94, 0x16, 0xFF]),
    ] {
        bus.asks(request, response);
    }
    // The acknowledge timer is used.
    bus.node.inputs_changed(bus.now);
    bus.drain();
    bus.forget();
    bus.wait(29);
    bus.is_silent();
    bus.wait(1);
    bus.sends(0x0286_0009, &[0x34, 0x12]);
}
