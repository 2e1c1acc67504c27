//! I/O connections made by Create.

use super::*;

impl Bus {
    /// Makes instance 6 at a slave, which produces and consumes what is named.
    fn create(&mut self, slave: u8, produced: u16, consumed: u16) {
        self.group2(slave, 4, &[0x01, 0x08, 5, 0]);
        self.group2(slave, 3, &[0x01, 0x88, 6, 0]);
        for (attribute, value) in [(4, produced), (5, consumed)] {
            let [low, high] = value.to_le_bytes();
            self.group2(slave, 4, &[0x01, 0x10, 5, 6, attribute, low, high]);
            assert_eq!(self.group2(slave, 3, &[0x01, 0x90]).problem, None);
        }
    }

    fn apply(&mut self, slave: u8) {
        self.group2(slave, 4, &[0x01, 0x0D, 5, 6]);
        self.group2(slave, 3, &[0x01, 0x8D]);
    }

    fn created(&self, slave: u8) -> ConnectionRecord {
        let is_created = |held: &ConnectionRecord| matches!(held.name, ConnectionName::Dynamic { .. });
        self.monitor.connections().find(|held| held.server == mac(slave) && is_created(held)).unwrap()
    }
}

/// Group 1 Message ID 5 of node 10.
const FROM_10: u16 = 5 << 6 | 10;

#[test]
fn one_slave_produces_for_another() {
    let mut bus = Bus::with_slave(10, 0x01);
    assert_eq!(bus.frame(FROM_10, &[7]).text, "I/O 10 -> ?  07 (assumed)");
    bus.create(10, FROM_10, 0xFFFF);
    assert_eq!(bus.created(10).state, ConnectionState::Configuring);
    bus.apply(10);
    assert_eq!(bus.frame(FROM_10, &[7]).text, "I/O 10 -> ?  07");
    bus.group2(11, 6, &[0x01, 0x4B, 3, 1, 0x01, 1]);
    bus.group2(11, 3, &[0x01, 0xCB, 0]);
    bus.create(11, 0xFFFF, FROM_10);
    bus.apply(11);
    assert_eq!(bus.frame(FROM_10, &[7]).text, "I/O 10 -> 11  07");
    assert_eq!((bus.created(10).frames, bus.created(11).frames), (2, 1));
    assert_eq!(bus.created(10).name.to_string(), "group 1 instance 6");
    let told = bus.frame(FROM_10, &[7]).dynamic.unwrap();
    assert_eq!((told.server, told.instance, told.group), (mac(10), Some(6.into()), 1));
    bus.group2(10, 4, &[0x01, 0x09, 5, 6]);
    bus.group2(10, 3, &[0x01, 0x89]);
    bus.group2(11, 4, &[0x01, 0x09, 5, 6]);
    bus.group2(11, 3, &[0x01, 0x89]);
    assert_eq!(bus.created(10).state, ConnectionState::NonExistent);
    assert_eq!(bus.frame(FROM_10, &[7]).text, "I/O 10 -> ?  07 (assumed)");
}

/// The rate does not establish it, and the size that was set says that its messages are fragmented.
#[test]
fn a_created_connection_is_configured_before_it_is_applied() {
    let mut bus = Bus::with_slave(10, 0x01);
    bus.create(10, FROM_10, 0xFFFF);
    bus.group2(10, 4, &[0x01, 0x10, 5, 6, 7, 9, 0]);
    bus.group2(10, 3, &[0x01, 0x90]);
    bus.establish(10, 6, 1000);
    assert_eq!(bus.created(10).state, ConnectionState::Configuring);
    bus.apply(10);
    assert_eq!(
        (bus.created(10).state, bus.created(10).produced_size),
        (ConnectionState::Established, Some(9))
    );
    bus.frame(FROM_10, &[0x00, 1, 2, 3, 4, 5, 6, 7]);
    let heard = bus.frame(FROM_10, &[0x81, 8, 9]);
    assert_eq!((heard.kind, heard.problem), (Kind::Io, None));
    assert_eq!(heard.message.as_deref(), Some(&[1, 2, 3, 4, 5, 6, 7, 8, 9][..]));
}

/// In Group 2 the MAC ID of the identifier is that of the producer, or of the consumer.
#[test]
fn io_of_group_2_is_told_from_the_predefined_set() {
    // Message ID 5 of node 10 is a poll command otherwise, and Message ID 0 of node 20 a bit-strobe command.
    let (to_10, from_20) = (0x405 | 10 << 3, 0x400 | 20 << 3);
    let mut bus = Bus::with_slave(10, 0x01);
    bus.create(10, 0xFFFF, to_10);
    bus.apply(10);
    let heard = bus.frame(to_10, &[1, 2]);
    assert_eq!((heard.kind, heard.text.as_str(), heard.problem), (Kind::Io, "I/O ? -> 10  01 02", None));
    bus.group2(20, 6, &[0x01, 0x4B, 3, 1, 0x01, 1]);
    bus.group2(20, 3, &[0x01, 0xCB, 0]);
    bus.create(20, from_20, 0xFFFF);
    bus.apply(20);
    assert_eq!(bus.frame(from_20, &[7]).text, "I/O 20 -> ?  07");
    assert_eq!((bus.created(10).frames, bus.created(20).frames), (1, 1));
    assert_eq!(bus.created(10).name.to_string(), "group 2 instance 6");
}

/// A message has told that the poll connection exists: whatever was created before is gone.
#[test]
fn the_predefined_set_has_its_identifiers_back() {
    let to_10 = 0x405 | 10 << 3;
    let mut bus = Bus::with_slave(10, 0x01);
    bus.create(10, 0xFFFF, to_10);
    bus.apply(10);
    assert_eq!(bus.frame(to_10, &[1]).kind, Kind::Io);
    bus.group2(10, 4, &[0x01, 0x4B, 3, 1, 0x02, 1]);
    bus.group2(10, 3, &[0x01, 0xCB, 0]);
    assert_eq!(bus.frame(to_10, &[1]).kind, Kind::PollCommand);
    assert_eq!(bus.group2(10, 4, &[0x01, 0x0E, 1, 1, 1]).kind, Kind::ExplicitRequest);
}

/// In Group 3 as well, where frames are explicit messages otherwise.
#[test]
fn io_of_group_3_has_no_header() {
    let mut bus = Bus::with_slave(10, 0x01);
    let from_10 = 0x600 | 2 << 6 | 10;
    bus.create(10, from_10, 0xFFFF);
    bus.apply(10);
    let heard = bus.frame(from_10, &[0x0B, 0x0E, 1, 1, 1]);
    assert_eq!((heard.kind, heard.text.as_str()), (Kind::Io, "I/O 10 -> ?  0B 0E 01 01 01"));
}
