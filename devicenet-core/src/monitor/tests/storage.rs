//! Sizes, and what happens at their limits.

use super::*;

/// A growth is a decision: the documentation of [`Monitor`] names the size.
#[test]
#[cfg(target_pointer_width = "64")]
fn the_size_of_a_monitor_is_known() {
    assert_eq!(core::mem::size_of::<Monitor>(), 104_720);
}

fn frame(id: u16, data: &[u8]) -> Frame {
    Identifier::new(id).unwrap().frame(data).unwrap()
}

#[test]
fn a_message_that_is_too_long_is_noted_and_counted() {
    let mut monitor = SizedMonitor::<2, 8>::new(MonitorConfig::default());
    assert_eq!(
        monitor.observe(Instant::ZERO, 1, &frame(0x453, &[0x81, 0x00, 0x8E, 9, 1, 2, 3, 4])).note,
        None
    );
    let reading = monitor.observe(Instant::ZERO, 2, &frame(0x453, &[0x81, 0x41, 1, 2, 3, 4, 5, 6]));
    assert_eq!((reading.note, reading.message), (Some(Note::NotStored), None));
    assert_eq!(monitor.lost(), Lost { long_messages: 1, ..Lost::default() });
}

#[test]
fn a_message_for_which_there_is_no_room_pushes_out_the_oldest() {
    let mut monitor = SizedMonitor::<1, 16>::new(MonitorConfig::default());
    monitor.observe(Instant::ZERO, 1, &frame(0x453, &[0x81, 0x00, 0x8E, 9, 1, 2, 3, 4]));
    monitor.observe(Instant::ZERO, 2, &frame(0x45B, &[0x81, 0x00, 0x8E, 9, 1, 2, 3, 4]));
    assert_eq!(monitor.lost(), Lost { evicted_messages: 1, ..Lost::default() });
    let reading = monitor.observe(Instant::ZERO, 3, &frame(0x45B, &[0x81, 0x81, 5]));
    assert_eq!(reading.message.map(|message| message.data), Some(&[0x8E, 9, 1, 2, 3, 4, 5][..]));
}

#[test]
fn connections_beyond_the_store_push_out_the_quietest() {
    let mut monitor = SizedMonitor::<1, 16>::new(MonitorConfig::default());
    for (n, server) in [(1, 20_u8), (3, 21)] {
        let at = Instant::from_millis(n);
        monitor.observe(at, n, &frame(0x782, &[server, 0x4B, 0x00, 0x31]));
        let id = 0x740 | u16::from(server);
        assert_eq!(
            monitor.observe(at, n + 1, &frame(id, &[0x02, 0xCB, 0x00, 0x02, 0x07, 0x00])).problem,
            None
        );
    }
    assert_eq!(monitor.lost(), Lost { connections: 1, ..Lost::default() });
    assert_eq!(monitor.connections().count(), 1);
}

#[test]
fn requests_of_many_clients_push_out_the_oldest() {
    let mut bus = Bus::new();
    for client in 1..=5 {
        bus.group2(10, 6, &[client, 0x4B, 3, 1, 1, client]);
    }
    assert_eq!(bus.monitor.lost().requests, 1);
    assert!(bus.group2(10, 3, &[1, 0xCB, 0]).request.is_none());
    assert_eq!(bus.group2(10, 3, &[5, 0x94, 0x0C, 0x01]).answers(), Some(5));
}
