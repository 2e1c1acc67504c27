//! Implicit messages that are longer than a frame.

use link_core::TxOutcome;

use super::bus::Bus;

/// Ten bytes out, ten in: one byte of each frame says which part it is.
#[test]
fn long_messages_are_fragmented() {
    let long = |station: &mut super::bus::Station| {
        station.inputs = (1..=10).collect();
        station.outputs = std::vec![0; 10];
    };
    let mut bus = Bus::with(|_| {}, long);
    bus.connects(&[0x4B, 0xC2, 3, 0, 0, 0, 0], &[0x4B, 0xC2, 0, 0, 0]);
    bus.hears(0x0202_C303, &[0x00, 1, 2, 3, 4, 5, 6, 7]);
    bus.is_silent();
    bus.hears(0x0202_C303, &[0x81, 8, 9, 10]);
    assert_eq!(bus.node.application().outputs, [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]);
    bus.sends(0x0286_0003, &[0x00, 1, 2, 3, 4, 5, 6, 7]);
    bus.sends(0x0286_0003, &[0x81, 8, 9, 10]);
    bus.told();
    for (frame, why) in [
        (&[0x81, 8, 9, 10][..], "fragment out of order"),
        (&[0x3F, 1], "wrong length"),
        (&[0xC0, 0], "fragment out of order"),
        (&[0x02, 0], "fragment out of order"),
    ] {
        bus.hears(0x0202_C303, frame);
        assert_eq!(bus.told(), [std::format!("0202C303 ignored: {why}")]);
        bus.is_silent();
    }
    // Idle.
    bus.hears(0x0202_C303, &[]);
    assert_eq!(bus.told(), ["polled, 29 bits: idle"]);
    // The data may change between two fragments: a message is of one moment.
    bus.forget();
    bus.stuck = true;
    bus.hears(0x0202_C303, &[]);
    bus.node.application_mut().inputs = std::vec![0xEE; 10];
    bus.unstick();
    bus.sends(0x0286_0003, &[0x00, 1, 2, 3, 4, 5, 6, 7]);
    bus.sends(0x0286_0003, &[0x81, 8, 9, 10]);
    // The rest of a message whose beginning was lost is of no use.
    bus.outcome = TxOutcome::Dropped;
    bus.hears(0x0202_C303, &[]);
    bus.outcome = TxOutcome::Sent;
    bus.is_silent();
    bus.hears(0x0202_C303, &[]);
    bus.sends(0x0286_0003, &[0x00, 0xEE, 0xEE, 0xEE, 0xEE, 0xEE, 0xEE, 0xEE]);
    bus.sends(0x0286_0003, &[0x81, 0xEE, 0xEE, 0xEE]);
}
