//! The DeviceNet and the Connection object, attribute by attribute (CIP Vol. 3, classes 3 and 5).

use link_core::{BitRate, BusErrorKind, LinkEvent};

use super::bus::{Bus, Full, G2o, MASTER, REQUEST, block, config, everything};
use crate::access::{MacIdSource, StateKind};
use crate::slave::{Options, SlaveEvent, Switches};

#[test]
fn the_devicenet_object() {
    let mut bus = G2o::g2o().allocated(0x01);
    for (attribute, value) in
        [(1, &[63][..]), (2, &[0]), (3, &[0]), (4, &[0]), (5, &[0x01, MASTER]), (10, &[0])]
    {
        bus.asks(&[0x0E, 3, 1, attribute], &[&[0x8E], value].concat());
    }
    for absent in [6, 7, 8, 9, 11, 13, 14, 99, 100] {
        bus.asks(&[0x0E, 3, 1, absent], &[0x94, 0x14, 0xFF]);
    }
    bus.asks(&[0x0E, 3, 0, 1], &[0x8E, 2, 0]);
    bus.asks(&[0x0E, 3, 2, 1], &[0x94, 0x16, 0xFF]);
    bus.asks(&[0x10, 3, 0, 1, 2, 0], &[0x94, 0x08, 0xFF]);
    bus.asks(&[0x10, 3, 1, 5, 1, 4], &[0x94, 0x0E, 0xFF]);
    for attribute in [3, 10] {
        bus.asks(&[0x10, 3, 1, attribute, 2], &[0x94, 0x09, 0xFF]);
        bus.asks(&[0x10, 3, 1, attribute, 1], &[0x90]);
        bus.asks(&[0x0E, 3, 1, attribute], &[0x8E, 1]);
    }
    bus.tells(SlaveEvent::StoreQuickConnect(true));
}

#[test]
fn switches() {
    let mut config = config();
    config.access.mac_id_source = MacIdSource::Switches;
    config.bit_rate.from_switches = true;
    let mut bus: G2o = Bus::online(config.clone(), block()).allocated(0x01);
    bus.asks(&[0x0E, 3, 1, 8], &[0x94, 0x14, 0xFF]);
    bus.slave.set_switches(Switches { mac_id: 63, bit_rate: 0 });
    for (attribute, value) in [(6, 0), (7, 0), (8, 63), (9, 0)] {
        bus.asks(&[0x0E, 3, 1, attribute], &[0x8E, value]);
    }
    bus.slave.set_switches(Switches { mac_id: 99, bit_rate: 2 });
    for (attribute, value) in [(6, 1), (7, 1), (8, 99), (9, 2), (1, 63), (2, 0)] {
        bus.asks(&[0x0E, 3, 1, attribute], &[0x8E, value]);
    }
    for attribute in [1, 2, 6, 8] {
        bus.asks(&[0x10, 3, 1, attribute, 1], &[0x94, 0x0E, 0xFF]);
        bus.asks(&[0x10, 3, 1, attribute, 1, 1], &[0x94, 0x0E, 0xFF]);
    }
    // One of each.
    config.bit_rate.from_switches = false;
    let mut bus: G2o = Bus::online(config.clone(), block()).allocated(0x01);
    bus.asks(&[0x10, 3, 1, 1, 5], &[0x94, 0x0E, 0xFF]);
    bus.asks(&[0x10, 3, 1, 2, 1], &[0x90]);
    config.access.mac_id_source = MacIdSource::Software;
    config.bit_rate.from_switches = true;
    let mut bus: G2o = Bus::online(config, block()).allocated(0x01);
    bus.asks(&[0x10, 3, 1, 2, 1], &[0x94, 0x0E, 0xFF]);
    bus.asks(&[0x10, 3, 1, 1, 5], &[0x90]);
}

/// Stored at once, in use after the next reset; it reads as stored, or by option as in use.
#[test]
fn the_bit_rate() {
    for (active, reads) in [(false, 2), (true, 0)] {
        let mut config = config();
        config.options.set(Options::READ_ACTIVE_BIT_RATE, active);
        let mut bus: G2o = Bus::online(config, block()).allocated(0x01);
        bus.asks(&[0x10, 3, 1, 2, 3], &[0x94, 0x09, 0xFF]);
        bus.asks(&[0x10, 3, 1, 2, 2], &[0x90]);
        bus.tells(SlaveEvent::StoreBitRate(BitRate::K500));
        bus.asks(&[0x0E, 3, 1, 2], &[0x8E, reads]);
        bus.links.clear();
        bus.asks(&[0x05, 1, 1], &[0x85]);
        let mode = link_core::Mode { bit_rate: BitRate::K500, listen_only: false };
        assert_eq!(bus.links.first(), Some(&link_core::LinkCommand::SetMode(mode)));
    }
}

#[test]
fn diagnostic_counters() {
    let mut bus = G2o::g2o().allocated(0x01);
    bus.link(LinkEvent::BusError(BusErrorKind::Bit));
    bus.link(LinkEvent::BusError(BusErrorKind::Bit));
    bus.link(LinkEvent::BusError(BusErrorKind::Crc));
    bus.link(LinkEvent::Overrun { lost: 3 });
    bus.link(LinkEvent::Counters { tec: 8, rec: 1 });
    let read = |bus: &mut G2o| {
        bus.hears(REQUEST, &[MASTER, 0x0E, 3, 1, 12]);
        let mut body = std::vec::Vec::new();
        for count in 0..6_u8 {
            let fragment = bus.response();
            assert_eq!(fragment[1] & 0x3F, count);
            body.extend_from_slice(&fragment[2..]);
            bus.hears(REQUEST, &[MASTER | 0x80, 0xC0 | count, 0]);
        }
        bus.sends_nothing();
        assert_eq!((body.len(), body[0]), (35, 0x8E));
        body[1..].chunks(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect::<std::vec::Vec<_>>()
    };
    let expected = [0x07FC, 0, 0, 2, 0, 0, 0, 1, 3, 0, 1, 8, 0, 0, 0, 0, 0];
    assert_eq!(read(&mut bus), expected);
    bus.asks(&[0x10, 3, 1, 12, 0, 0], &[0x90]);
    assert!(read(&mut bus)[1..].iter().all(|counter| *counter == 0));
}

/// What a Set is answered in each state: 0 for success (CIP Vol. 3, access rules of predefined connections).
#[test]
fn access_to_the_connection_object() {
    let io: [(&[u8], u8, u8); 17] = [
        (&[1, 3], 0x0E, 0x0E),
        (&[2, 1], 0x0E, 0x0E),
        (&[3, 0x82], 0x0E, 0x0E),
        (&[4, 0, 0], 0x0E, 0x0E),
        (&[5, 0, 0], 0x0E, 0x0E),
        (&[6, 1], 0x0E, 0x0E),
        (&[7, 2, 0], 0x0E, 0x0E),
        (&[8, 1, 0], 0x0E, 0x0E),
        (&[12, 2], 0, 0),
        (&[12, 3], 0x09, 0x09),
        (&[13, 6, 0], 0x0E, 0x0E),
        (&[14, 0x20, 4, 0x24, 2, 0x30, 3], 0, 0x0C),
        (&[15, 6, 0], 0x0E, 0x0E),
        (&[16, 0x20, 4, 0x24, 2, 0x30, 3], 0x09, 0x0C),
        (&[17, 10, 0], 0, 0),
        (&[18, 1], 0, 0),
        (&[10, 0, 0, 0, 0], 0x14, 0x14),
    ];
    for (set, configuring, established) in io {
        let states = [
            (Full::full().allocated(0x03), configuring),
            (Full::full().established(0x03, &[2]), established),
        ];
        for (mut bus, expected) in states {
            bus.sets(2, set, expected);
        }
    }
    for (set, expected) in [
        (&[1, 3][..], 0x0E),
        (&[5, 0, 0], 0x0E),
        (&[9, 100, 0], 0),
        (&[12, 1], 0),
        (&[12, 3], 0),
        (&[12, 0], 0x09),
        (&[12, 2], 0x09),
        (&[14, 0x20], 0x0E),
        (&[17, 10, 0], 0x0E),
        (&[18, 8], 0x09),
    ] {
        Full::full().allocated(0x01).sets(1, set, expected);
    }
}

impl Full {
    /// Set_Attribute_Single, in fragments if it must be.
    #[track_caller]
    fn sets(&mut self, instance: u8, set: &[u8], expected: u8) {
        let body = [&[0x10, 5, instance], set].concat();
        if body.len() <= 7 {
            self.hears(REQUEST, &[&[MASTER], &body[..]].concat());
        } else {
            self.hears(REQUEST, &[&[MASTER | 0x80, 0], &body[..6]].concat());
            self.skip();
            self.hears(REQUEST, &[&[MASTER | 0x80, 0x81], &body[6..]].concat());
            self.skip();
        }
        let response = self.response();
        match expected {
            0 => assert_eq!(response[1], 0x90, "{set:02X?}: {response:02X?}"),
            error => assert_eq!(response[1..], [0x94, error, 0xFF], "{set:02X?}"),
        }
    }
}

/// Defaults after allocation, as the manuals print them; identifiers of slave 63 and master 4.
#[test]
fn defaults_after_allocation() {
    let mut bus = Full::full().allocated(0x1F);
    type Value = (u8, &'static [u8]);
    let expected: [(u8, [Value; 7]); 5] = [
        (
            1,
            [
                (1, &[3]),
                (2, &[0]),
                (3, &[0x83]),
                (4, &[0xFB, 5]),
                (5, &[0xFC, 5]),
                (6, &[0x21]),
                (9, &[0xC4, 9]),
            ],
        ),
        (
            2,
            [
                (1, &[1]),
                (2, &[1]),
                (3, &[0x82]),
                (4, &[0xFF, 3]),
                (5, &[0xFD, 5]),
                (6, &[0x01]),
                (9, &[0, 0]),
            ],
        ),
        (
            3,
            [
                (1, &[1]),
                (2, &[1]),
                (3, &[0x82]),
                (4, &[0xBF, 3]),
                (5, &[0x20, 4]),
                (6, &[0x02]),
                (9, &[0, 0]),
            ],
        ),
        (
            4,
            [
                (1, &[1]),
                (2, &[1]),
                (3, &[0x12]),
                (4, &[0x7F, 3]),
                (5, &[0xFA, 5]),
                (6, &[0x01]),
                (9, &[0, 0]),
            ],
        ),
        (
            5,
            [
                (1, &[1]),
                (2, &[1]),
                (3, &[0x82]),
                (4, &[0x3F, 3]),
                (5, &[0x21, 4]),
                (6, &[0x02]),
                (9, &[0, 0]),
            ],
        ),
    ];
    for (instance, attributes) in expected {
        for (attribute, value) in attributes {
            bus.asks(&[0x0E, 5, instance, attribute], &[&[0x8E], value].concat());
        }
        bus.asks(&[0x0E, 5, instance, 12], &[0x8E, u8::from(instance == 1)]);
        bus.asks(&[0x0E, 5, instance, 17], &[0x8E, 0, 0]);
        bus.asks(&[0x0E, 5, instance, 18], &[0x8E, 0]);
    }
    bus.asks(&[0x0E, 5, 4, 16], &[0x8E, 0x20, 0x2B, 0x24, 0x01]);
    bus.asks(&[0x0E, 5, 1, 13], &[0x8E, 0, 0]);
    bus.asks(&[0x0E, 5, 0, 1], &[0x8E, 1, 0]);
    bus.asks(&[0x11, 5, 0, 2], &[0x91, 2, 1, 0, 2, 0]);
}

#[test]
fn a_path_selects_another_assembly_and_the_size_follows() {
    let mut bus = Full::full().allocated(0x03);
    bus.sets(2, &[14, 0x20, 4, 0x24, 3, 0x30, 3], 0);
    bus.asks(&[0x0E, 5, 2, 7], &[0x8E, 24, 0]);
    // 72 bytes are more than there is memory for.
    bus.sets(2, &[14, 0x20, 4, 0x24, 9, 0x30, 3], 0x09);
    bus.asks(&[0x0E, 5, 2, 7], &[0x8E, 24, 0]);
    bus.sets(2, &[14, 0x20, 5, 0x24, 2, 0x30, 3], 0x09);
}

#[test]
fn the_packet_rate() {
    let mut bus = G2o::g2o().allocated(0x03);
    bus.asks(&[0x10, 5, 2, 17, 200, 0], &[0x90]);
    bus.asks(&[0x10, 5, 2, 9, 100, 0], &[0x94, 0x09, 0xFF]);
    bus.asks(&[0x10, 5, 2, 9, 0xFB, 0xFF], &[0x94, 0x09, 0xFF]);
    bus.is_state(2, 1);
    // 3594 becomes 3600: Konvolucio.
    bus.asks(&[0x10, 5, 2, 9, 0x0A, 0x0E], &[0x90, 0x10, 0x0E]);
    bus.asks(&[0x0E, 5, 2, 9], &[0x8E, 0x10, 0x0E]);
    bus.asks(&[0x10, 5, 2, 17, 0x11, 0x0E], &[0x94, 0x09, 0xFF]);
    // The multiplier: 16 times 3600 ms.
    bus.asks(&[0x10, 5, 1, 9, 0, 0], &[0x90, 0, 0]);
    bus.asks(&[0x10, 5, 2, 18, 2], &[0x90]);
    bus.hears(super::bus::POLL, &[1]);
    bus.skip();
    bus.wait(57_599);
    bus.is_state(2, 3);
    bus.wait(1);
    bus.is_state(2, 4);
}

#[test]
fn options_of_the_connection_object() {
    let mut config = config();
    config.options.insert(Options::ANSWER_INHIBIT_TIME | Options::READ_NON_EXISTENT_STATE);
    config.resolution = cip_core::connection::TimerResolution::new(2).unwrap();
    let mut bus: G2o = Bus::online(config, block()).allocated(0x03);
    bus.asks(&[0x10, 5, 2, 17, 5, 0], &[0x90, 5, 0]);
    bus.asks(&[0x10, 5, 2, 9, 75, 0], &[0x90, 76, 0]);
    bus.asks(&[0x0E, 5, 3, 1], &[0x8E, 0]);
    bus.asks(&[0x0E, 5, 3, 2], &[0x94, 0x14, 0xFF]);
    bus.asks(&[0x0E, 5, 6, 1], &[0x94, 0x16, 0xFF]);
}

/// Services of the class reach every instance.
#[test]
fn reset_and_delete_of_the_class() {
    let mut bus = G2o::g2o().established(0x03, &[2]);
    bus.wait(9000);
    bus.asks(&[0x05, 5, 0], &[0x85]);
    bus.wait(319);
    bus.is_state(2, 3);
    bus.wait(1);
    bus.is_state(2, 4);
    bus.asks(&[0x05, 5, 0, 1], &[0x94, 0x15, 0xFF]);
    bus.asks(&[0x09, 5, 0], &[0x89]);
    assert_eq!(bus.allocation(), (0, None));
    assert_eq!(bus.slave.access().state().kind(), StateKind::OnLine);
}

#[test]
fn identity_says_whether_it_is_owned() {
    let mut bus: Full = Bus::online(config(), everything()).allocated(0x01);
    bus.asks(&[0x0E, 1, 1, 5], &[0x8E, 1, 0]);
    bus.slave.application_mut().status = cip_core::identity::IdentityStatus::CONFIGURED;
    bus.asks(&[0x0E, 1, 1, 5], &[0x8E, 5, 0]);
    bus.asks(&[0x10, 1, 1, 10, 1], &[0x94, 0x08, 0xFF]);
}
