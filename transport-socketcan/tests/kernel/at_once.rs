//! Interfaces that echo nothing, as virtual ones: a frame is on the bus when the interface has taken it.

use link_core::{Input, LinkEvent, Port, TxToken};

use crate::rig::{Interface, dropped, frame, input, sent, silent};

#[test]
#[ignore = "needs vcan"]
fn a_frame_is_sent_at_once_and_in_the_order_of_its_coming() {
    let bus = Interface::new("vcan70");
    let (mut one, mut other) = (bus.port(), bus.port());
    assert!(!one.interface().has_echo());
    for (token, id) in [(1, 0x600), (2, 0x500), (3, 0x100)] {
        one.transmit(TxToken(token), frame(id, &[])).unwrap();
    }
    assert_eq!([1, 2, 3].map(|_| input(&mut one)), [sent(1), sent(2), sent(3)]);
    silent(&mut one);
    let ids = [0x600, 0x500, 0x100].map(|id| Input::Frame(frame(id, &[])));
    assert_eq!([1, 2, 3].map(|_| input(&mut other)), ids);
}

/// Two nodes with one MAC ID send the same duplicate MAC ID check: neither may take the other's for its own.
#[test]
#[ignore = "needs vcan"]
fn a_twins_identical_frame_is_not_the_echo() {
    let bus = Interface::new("vcan71");
    let (mut one, mut twin) = (bus.port(), bus.port());
    let check = frame(0x52F, &[0, 0x34, 0x12, 0x45, 0x23, 0, 0]);
    twin.transmit(TxToken(1), check).unwrap();
    one.transmit(TxToken(2), check).unwrap();
    assert_eq!(input(&mut one), sent(2));
    assert_eq!(input(&mut one), Input::Frame(check), "the twin's");
    assert_eq!(input(&mut twin), sent(1));
    assert_eq!(input(&mut twin), Input::Frame(check));
}

#[test]
#[ignore = "needs vcan"]
fn what_was_sent_before_the_interface_went_down_is_told_before_that() {
    let bus = Interface::new("vcan73");
    let mut port = bus.port();
    port.transmit(TxToken(1), frame(0x100, &[])).unwrap();
    bus.set("down");
    port.transmit(TxToken(2), frame(0x100, &[])).unwrap();
    assert_eq!([1, 2, 3].map(|_| input(&mut port)), [sent(1), Input::Link(LinkEvent::Down), dropped(2)]);
}

/// It could go on for ever without looking into its socket.
#[test]
#[ignore = "needs vcan"]
fn who_always_has_something_to_send_hears_the_others() {
    let bus = Interface::new("vcan72");
    let (mut one, mut other) = (bus.port(), bus.port());
    other.transmit(TxToken(0), frame(0x200, &[])).unwrap();
    // The kernel may deliver the frame when it has time.
    let is_heard = (1..=5000).any(|token| {
        one.transmit(TxToken(token), frame(0x100, &[])).unwrap();
        input(&mut one) == Input::Frame(frame(0x200, &[]))
    });
    assert!(is_heard);
}
