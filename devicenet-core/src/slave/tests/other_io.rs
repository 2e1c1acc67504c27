//! Bit-strobe, change of state, cyclic, multicast poll (CIP Vol. 3, I/O messaging).

use link_core::{LinkCommand, TxOutcome};

use super::bus::{
    Bus, COS, COS_ACK, Full, MASTER, MULTICAST, MULTICAST_RESPONSE, POLL, POLL_RESPONSE, REQUEST, RESPONSE,
    STROBE, STROBE_RESPONSE, UNCONNECTED, config, everything,
};
use crate::MacId;
use crate::slave::{IoKind, IoMode, Slave, SlaveEvent};

const DATA: [u8; 2] = [0x34, 0x12];

impl Full {
    fn changes(&mut self, inputs: [u8; 2]) {
        self.slave.application_mut().inputs = inputs.to_vec();
        self.slave.inputs_changed(self.now);
        self.drain();
    }

    /// Change of state with this many ms of EPR and inhibit time.
    fn producing(choice: u8, rate: u8, inhibit: u8) -> Self {
        let mut bus = Self::full().allocated(choice);
        bus.asks(&[0x10, 5, 4, 17, inhibit, 0], &[0x90]);
        bus.hears(REQUEST, &[MASTER, 0x10, 5, 4, 9, rate, 0]);
        // The lower identifier wins: the first message goes before the response.
        bus.sends(COS, &DATA);
        bus.sends(RESPONSE, &[MASTER, 0x90, rate, 0]);
        bus
    }

    #[track_caller]
    fn acknowledged(&mut self) {
        self.hears(COS_ACK, &[]);
        self.sends_nothing();
    }
}

/// The answer does not depend on the bit; bit n % 8 of byte n / 8 is that of node n.
#[test]
fn bit_strobe() {
    let mut bus = Full::full().established(0x05, &[3]);
    bus.hears(STROBE, &[0, 0, 0, 0, 0, 0, 0, 0x80]);
    bus.sends(STROBE_RESPONSE, &DATA);
    assert_eq!(bus.slave.application().outputs[1], [1]);
    bus.hears(STROBE, &[0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x7F]);
    bus.sends(STROBE_RESPONSE, &DATA);
    assert_eq!(bus.slave.application().outputs[1], [0]);
    bus.hears(STROBE, &[]);
    bus.sends(STROBE_RESPONSE, &DATA);
    assert_eq!(bus.slave.node.mode(IoKind::BitStrobe), IoMode::Idle);
    for len in 1..8 {
        bus.hears(STROBE, &[0; 8][..len]);
        bus.sends_nothing();
    }
    // Of another master.
    bus.hears(STROBE + 8, &[0; 8]);
    bus.sends_nothing();
    bus.asks(&[0x0E, 5, 3, 5], &[0x8E, 0x20, 0x04]);
    bus.asks(&[0x0E, 5, 3, 8], &[0x8E, 8, 0]);
}

#[test]
fn bit_positions() {
    for (mac, byte, bit) in [(0, 0, 0x01), (7, 0, 0x80), (8, 1, 0x01), (63, 7, 0x80)] {
        let mut config = config();
        config.access.mac_id = MacId::new(mac).unwrap();
        let mut bus: Full = Bus::online(config, everything());
        let own = u16::from(mac) * 8;
        bus.hears(0x406 + own, &[9, 0x4B, 3, 1, 5, 9]);
        bus.hears(0x404 + own, &[9, 0x10, 5, 3, 9, 80, 0]);
        let mut command = [0; 8];
        command[byte] = bit;
        bus.hears(0x448, &command);
        assert_eq!(bus.slave.application().outputs[1], [1], "MAC ID {mac}");
        command[byte] = !bit;
        bus.hears(0x448, &command);
        assert_eq!(bus.slave.application().outputs[1], [0], "MAC ID {mac}");
    }
}

#[test]
fn the_filter_follows_the_strobe() {
    let mut bus = Full::full().allocated(0x01);
    bus.links.clear();
    bus.asks(&[0x4B, 3, 1, 4, MASTER], &[0xCB, 0]);
    let accepts = |bus: &Full, id| {
        let frame = link_core::Frame::new(link_core::frame::standard_id(id), &[]).unwrap();
        match bus.links.last() {
            Some(LinkCommand::SetFilter(filter)) => filter.accepts(&frame),
            other => panic!("{other:?}"),
        }
    };
    assert!(accepts(&bus, STROBE) && accepts(&bus, REQUEST) && accepts(&bus, UNCONNECTED));
    bus.asks(&[0x4C, 3, 1, 4], &[0xCC]);
    assert!(!accepts(&bus, STROBE));
}

#[test]
fn change_of_state_sends_at_once_on_change_and_at_the_packet_rate() {
    let mut bus = Full::producing(0x11, 100, 0);
    bus.acknowledged();
    bus.wait(50);
    bus.changes([1, 1]);
    bus.sends(COS, &[1, 1]);
    bus.acknowledged();
    bus.wait(99);
    bus.sends_nothing();
    bus.wait(1);
    bus.sends(COS, &[1, 1]);
}

#[test]
fn changes_wait_for_the_inhibit_time() {
    let mut bus = Full::producing(0x11, 100, 30);
    bus.acknowledged();
    bus.wait(10);
    bus.changes([1, 1]);
    bus.changes([2, 2]);
    bus.sends_nothing();
    bus.wait(19);
    bus.sends_nothing();
    bus.wait(1);
    bus.sends(COS, &[2, 2]);
    bus.acknowledged();
    bus.wait(99);
    bus.sends_nothing();
    bus.wait(1);
    bus.sends(COS, &[2, 2]);
    // At the end of the inhibit time, and without a change, nothing is sent.
    bus.acknowledged();
    bus.wait(30);
    bus.sends_nothing();
    bus.changes([3, 3]);
    bus.sends(COS, &[3, 3]);
}

/// 16 ms for the acknowledge, one retry, with the present data.
#[test]
fn change_of_state_without_an_acknowledge() {
    let mut bus = Full::producing(0x11, 100, 0);
    bus.wait(15);
    bus.sends_nothing();
    bus.slave.application_mut().inputs = std::vec![9, 9];
    bus.wait(1);
    bus.sends(COS, &[9, 9]);
    bus.events.clear();
    bus.wait(15);
    assert_eq!(bus.events, []);
    bus.wait(1);
    assert_eq!(bus.events, [SlaveEvent::NotAcknowledged]);
    bus.sends_nothing();
    // The next one as usual: 100 ms after the last production, which a repetition is not.
    bus.wait(67);
    bus.sends_nothing();
    bus.wait(1);
    bus.sends(COS, &[9, 9]);
}

#[test]
fn a_new_message_replaces_one_that_waits_for_its_acknowledge() {
    let mut bus = Full::producing(0x11, 200, 0);
    bus.wait(16);
    bus.sends(COS, &DATA);
    bus.changes([1, 1]);
    bus.sends(COS, &[1, 1]);
    bus.wait(16);
    bus.sends(COS, &[1, 1]);
    bus.acknowledged();
    bus.wait(100);
    bus.sends_nothing();
}

#[test]
fn the_acknowledge_handler_is_obeyed() {
    let mut bus = Full::full().allocated(0x11);
    bus.asks(&[0x10, 0x2B, 1, 1, 50, 0], &[0x90, 50, 0]);
    bus.asks(&[0x10, 0x2B, 1, 2, 0], &[0x90]);
    bus.asks(&[0x10, 0x2B, 1, 1, 0, 0], &[0x94, 0x09, 0xFF]);
    bus.hears(REQUEST, &[MASTER, 0x10, 5, 4, 9, 200, 0]);
    bus.sends(COS, &DATA);
    bus.sends(RESPONSE, &[MASTER, 0x90, 200, 0]);
    bus.asks(&[0x10, 0x2B, 1, 3, 4, 0], &[0x94, 0x0C, 0xFF]);
    bus.events.clear();
    bus.wait(49);
    assert_eq!(bus.events, []);
    bus.wait(1);
    assert_eq!(bus.events, [SlaveEvent::NotAcknowledged], "no retries");
}

/// The watchdog of instance 4 lives on acknowledges.
#[test]
fn a_master_that_does_not_acknowledge_is_lost() {
    let mut bus = Full::producing(0x11, 100, 0);
    bus.acknowledged();
    bus.events.clear();
    bus.wait(399);
    assert_eq!(bus.slave.node.io(IoKind::ChangeOfState).state(), cip_core::connection::IoState::Established);
    bus.wait(1);
    assert_eq!(bus.slave.node.io(IoKind::ChangeOfState).state(), cip_core::connection::IoState::TimedOut);
    assert_eq!(bus.allocation(), (0x01, Some(MASTER)));
    while bus.skip_any() {}
    bus.wait(1000);
    bus.sends_nothing();
}

#[test]
fn acknowledges_are_suppressed() {
    let mut bus = Full::producing(0x51, 100, 0);
    assert_eq!(bus.allocation(), (0x51, Some(MASTER)));
    bus.asks(&[0x0E, 5, 4, 5], &[0x8E, 0xFF, 0xFF]);
    bus.asks(&[0x0E, 5, 2, 4], &[0x8E, 0xFF, 0xFF]);
    bus.asks(&[0x0E, 5, 2, 3], &[0x8E, 0x80]);
    bus.asks(&[0x0E, 5, 2, 6], &[0x8E, 0xF1]);
    bus.asks(&[0x0E, 5, 4, 15], &[0x8E, 0, 0]);
    // Neither retries nor a time-out; the explicit connection shall not end meanwhile.
    bus.asks(&[0x10, 5, 1, 9, 0, 0], &[0x90, 0, 0]);
    for _ in 0..100 {
        bus.wait(99);
        bus.sends_nothing();
        bus.wait(1);
        bus.sends(COS, &DATA);
    }
    bus.hears(COS_ACK, &[]);
    bus.tells(SlaveEvent::Ignored {
        id: crate::Identifier::new(COS_ACK).unwrap(),
        why: crate::slave::Ignored::NoConnection,
    });
    // The master's messages are consumed, not answered, and loss of them is noticed.
    bus.asks(&[0x10, 5, 2, 9, 100, 0], &[0x90, 100, 0]);
    bus.hears(POLL, &[7]);
    bus.sends_nothing();
    assert_eq!(bus.slave.application().outputs[0], [7]);
    bus.wait(400);
    assert_eq!(bus.slave.node.mode(IoKind::Poll), IoMode::Fault);
}

/// With acknowledges, and without poll, the master's messages are acknowledged without data.
#[test]
fn messages_of_the_master() {
    let mut bus = Full::producing(0x11, 100, 0);
    bus.acknowledged();
    bus.asks(&[0x10, 5, 2, 9, 100, 0], &[0x90, 100, 0]);
    bus.asks(&[0x0E, 5, 2, 7], &[0x8E, 0, 0]);
    bus.hears(POLL, &[7]);
    bus.sends(POLL_RESPONSE, &[]);
    assert_eq!(bus.slave.application().outputs[0], [7]);
    // Poll is added: from now on with data.
    bus.asks(&[0x4B, 3, 1, 2, MASTER], &[0xCB, 0]);
    assert_eq!(bus.allocation(), (0x13, Some(MASTER)));
    bus.hears(POLL, &[8]);
    bus.sends(POLL_RESPONSE, &DATA);
    bus.asks(&[0x4C, 3, 1, 2], &[0xCC]);
    bus.hears(POLL, &[9]);
    bus.sends(POLL_RESPONSE, &[]);
    bus.asks(&[0x4C, 3, 1, 0x10], &[0xCC]);
    bus.hears(POLL, &[9]);
    bus.sends_nothing();
    assert_eq!(bus.allocation(), (0x01, Some(MASTER)));
}

#[test]
fn cyclic_sends_at_the_packet_rate_only() {
    let mut bus = Full::producing(0x21, 100, 0);
    bus.acknowledged();
    bus.asks(&[0x0E, 5, 4, 3], &[0x8E, 0x02]);
    for _ in 0..3 {
        bus.changes([5, 5]);
        bus.wait(99);
        bus.sends_nothing();
        bus.wait(1);
        bus.sends(COS, &[5, 5]);
        bus.acknowledged();
    }
}

#[test]
fn with_a_packet_rate_of_0_only_changes_are_sent() {
    let mut bus = Full::producing(0x11, 0, 0);
    bus.acknowledged();
    bus.wait(9000);
    bus.sends_nothing();
    bus.changes([1, 2]);
    bus.sends(COS, &[1, 2]);
}

/// The master acknowledges before the controller reports; what changes meanwhile is not lost.
#[test]
fn a_change_while_the_message_is_with_the_controller() {
    let mut bus = Full::producing(0x11, 100, 0);
    bus.acknowledged();
    bus.acknowledging = false;
    bus.changes([1, 1]);
    bus.sends(COS, &[1, 1]);
    bus.changes([2, 2]);
    bus.sends_nothing();
    bus.done(TxOutcome::Sent);
    bus.sends(COS, &[2, 2]);
}

#[test]
fn change_of_state_in_fragments() {
    let mut application = everything();
    application.inputs = (1..=9).collect();
    let mut bus: Full = Bus::online(config(), application).allocated(0x11);
    bus.hears(REQUEST, &[MASTER, 0x10, 5, 4, 9, 100, 0]);
    bus.sends(COS, &[0x00, 1, 2, 3, 4, 5, 6, 7]);
    bus.sends(COS, &[0x81, 8, 9]);
    bus.sends(RESPONSE, &[MASTER, 0x90, 100, 0]);
}

#[test]
fn multicast_poll() {
    let mut bus = Full::full().allocated(0x09);
    bus.asks(&[0x0E, 5, 5, 5], &[0x8E, 0x21, 0x04]);
    bus.asks(&[0x10, 5, 5, 5, 0x20, 0x04], &[0x94, 0x09, 0xFF]);
    bus.asks(&[0x10, 5, 5, 5, 0x21, 0x08], &[0x94, 0x09, 0xFF]);
    bus.asks(&[0x10, 5, 5, 5, 0x51, 0x04], &[0x90]);
    bus.asks(&[0x10, 5, 5, 9, 80, 0], &[0x90, 80, 0]);
    bus.asks(&[0x10, 5, 5, 5, 0x21, 0x04], &[0x94, 0x0E, 0xFF]);
    bus.hears(MULTICAST, &[1]);
    bus.sends_nothing();
    bus.hears(0x451, &[1]);
    bus.sends(MULTICAST_RESPONSE, &DATA);
    bus.hears(0x451, &[]);
    bus.sends(MULTICAST_RESPONSE, &DATA);
    assert_eq!(bus.slave.node.mode(IoKind::MulticastPoll), IoMode::Idle);
    bus.hears(0x451, &[1, 2]);
    bus.sends_nothing();
}

/// The lowest identifier goes first when several answers wait.
#[test]
fn the_order_of_answers() {
    let mut bus = Full::full().established(0x0F, &[2, 3, 5]);
    bus.acknowledging = false;
    bus.slave.input(bus.now, frame(REQUEST, &[MASTER, 0x0E, 1, 1, 1]));
    bus.slave.input(bus.now, frame(POLL, &[1]));
    bus.slave.input(bus.now, frame(STROBE, &[]));
    bus.slave.input(bus.now, frame(MULTICAST, &[1]));
    bus.drain();
    for id in [MULTICAST_RESPONSE, STROBE_RESPONSE, POLL_RESPONSE] {
        bus.sends(id, &DATA);
    }
    bus.sends(RESPONSE, &[MASTER, 0x8E, 0xE7, 0x03]);
}

fn frame(id: u16, data: &[u8]) -> link_core::Input {
    link_core::Input::Frame(link_core::Frame::new(link_core::frame::standard_id(id), data).unwrap())
}

use link_core::Machine;

#[test]
fn sizes_are_checked_when_the_slave_is_made() {
    let mut application = everything();
    application.inputs = std::vec![0; 33];
    let made = Slave::<_, 64, 0>::new(config(), application);
    assert_eq!(
        made.err().map(|error| std::format!("{error}")),
        Some("poll has 33 bytes, and there is room for 32: let Application::Long be Fragmented<33>".into())
    );
    assert!(Slave::<_, 7, 0>::new(config(), super::bus::block()).is_err());
    assert!(Slave::<_, 8, 17>::new(config(), super::bus::block()).is_err());
}
