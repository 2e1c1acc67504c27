//! Sizes, and what happens at their limits.

use super::*;

/// A growth is a decision: the documentation of [`Monitor`] names the size.
#[test]
#[cfg(target_pointer_width = "64")]
fn the_size_of_a_monitor_is_known() {
    assert_eq!(core::mem::size_of::<Monitor>(), 189_688);
}

#[test]
fn devices_beyond_the_store_push_out_the_quietest() {
    let mut monitor = SizedMonitor::<2, 16>::new(MonitorConfig::default());
    for serial in 1..=3 {
        let hello = Hello {
            source: oa(127),
            direction: Direction::Request,
            device: device(serial),
            port: PortByte::ZERO,
        };
        monitor.observe(Instant::from_millis(serial.into()), serial.into(), &hello.frame().unwrap());
    }
    assert_eq!(monitor.lost(), Lost { devices: 1, ..Lost::default() });
    let kept: Vec<_> = monitor.nodes().filter_map(|node| node.device).map(|device| device.serial).collect();
    assert_eq!(kept, [3, 2]);
}

#[test]
fn connections_beyond_the_store_push_out_the_quietest() {
    let mut monitor = SizedMonitor::<1, 16>::new(MonitorConfig::default());
    for (n, source) in [(1, 5), (2, 6)] {
        let id = Identifier::implicit(MessageId::default(), oa(source), InstanceId(7));
        monitor.observe(Instant::from_millis(n), n, &id.frame(&[1]).unwrap());
    }
    assert_eq!(monitor.lost(), Lost { connections: 1, ..Lost::default() });
    assert_eq!(monitor.connections().count(), 1);
}

#[test]
fn requests_beyond_the_store_push_out_the_oldest() {
    let mut bus = Bus::new();
    for transaction in 1..=5 {
        let framing = Framing::Complete { transaction };
        bus.connectionless(1, 67, Direction::Request, framing, &[0x0E, 1, 1, 1]);
    }
    assert_eq!(bus.monitor.lost().requests, 1);
    let framing = |transaction| Framing::Complete { transaction };
    let heard = bus.connectionless(1, 67, Direction::Response, framing(5), &[0x8E, 0x34, 0x12]);
    assert_eq!(heard.answers(), Some(5));
    let heard = bus.connectionless(1, 67, Direction::Response, framing(1), &[0x8E, 0x34, 0x12]);
    assert_eq!(heard.code(), Some("transaction_mismatch"));
}

#[test]
fn a_message_that_is_too_long_is_noted_and_counted() {
    let mut monitor = SizedMonitor::<2, 8>::new(MonitorConfig::default());
    let frame = |byte: u8, data: &[u8]| {
        let framing = Framing::Fragment(byte.into());
        Identifier::connectionless(route(1, 67, Direction::Response), framing).frame(data).unwrap()
    };
    assert_eq!(monitor.observe(Instant::ZERO, 1, &frame(0x00, &[1, 0x8E, 9, 1, 2, 3, 4, 5])).note, None);
    let reading = monitor.observe(Instant::ZERO, 2, &frame(0x81, &[1, 2, 3]));
    assert_eq!((reading.note, reading.message), (Some(Note::NotStored), None));
    assert_eq!(monitor.lost(), Lost { long_messages: 1, ..Lost::default() });
}
