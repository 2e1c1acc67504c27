//! The tool against a tester that plays faulted nodes and other tools by hand.

use std::string::{String, ToString};
use std::vec::Vec;

use link_core::{Action, BusErrorKind, Frame, Input, Instant, LinkEvent, Machine, TxOutcome, TxToken};

use super::*;
use crate::access;
use crate::id::{Identifier, MacId};
use crate::message::{DelayOffset, DeviceIdentity, NodeSelection, PortNumber};

struct Bus {
    tool: OfflineTool,
    now: Instant,
    in_flight: Option<(TxToken, Frame)>,
    withdrawals: usize,
    events: Vec<String>,
}

fn mac(number: u8) -> MacId {
    MacId::new(number).unwrap()
}

/// The faulted device of the specification's examples: vendor 6, serial number 0x05060708.
const DEVICE: DeviceIdentity = DeviceIdentity { vendor: cip_core::code::VendorId(6), serial: 0x0506_0708 };

#[track_caller]
fn frame(text: &str) -> Frame {
    let (id, data) = text.split_once(':').unwrap();
    let data: Vec<u8> = data.split_whitespace().map(|byte| u8::from_str_radix(byte, 16).unwrap()).collect();
    Identifier::new(u16::from_str_radix(id, 16).unwrap()).unwrap().frame(&data).unwrap()
}

impl Bus {
    /// Tool 5 of a fictitious vendor, on line.
    fn online() -> Self {
        let device = DeviceIdentity { vendor: 0x1234.into(), serial: 0x0000_2345 };
        let access = access::Config::new(device, PortNumber::ZERO, mac(5));
        let tool = OfflineTool::new(Config::new(access));
        let mut bus = Self { tool, now: Instant::ZERO, in_flight: None, withdrawals: 0, events: Vec::new() };
        bus.input(Input::Link(LinkEvent::Up));
        assert_eq!(bus.tool.claim(bus.now), Err(CommandError::NotOnLine));
        for _ in 0..2 {
            bus.sends("42F: 00 34 12 45 23 00 00");
            bus.wait(1000);
        }
        assert!(bus.tool.access().is_online());
        bus
    }

    fn owner() -> Self {
        let mut bus = Self::online();
        bus.command(|tool, now| tool.claim(now)).unwrap();
        for _ in 0..2 {
            bus.sends("7EF: 05 4B 34 12 45 23 00 00");
            bus.wait(1000);
        }
        assert_eq!(bus.tool.state(), ToolState::Owner);
        bus.events.clear();
        bus
    }

    fn input(&mut self, input: Input) {
        self.tool.input(self.now, input);
        self.drain();
    }

    fn command<T>(&mut self, command: impl FnOnce(&mut OfflineTool, Instant) -> T) -> T {
        let result = command(&mut self.tool, self.now);
        self.drain();
        result
    }

    #[track_caller]
    fn hears(&mut self, text: &str) {
        self.input(Input::Frame(frame(text)));
    }

    fn wait(&mut self, millis: u64) {
        let until = self.now + core::time::Duration::from_millis(millis);
        while let Some(deadline) = self.tool.deadline().filter(|deadline| deadline.at <= until) {
            self.now = self.now.max(deadline.at);
            self.input(Input::Tick);
        }
        self.now = until;
    }

    #[track_caller]
    fn sends(&mut self, expected: &str) {
        let (token, sent) = self.in_flight.take().expect(expected);
        assert_eq!(sent, frame(expected), "{sent}");
        self.input(Input::TxDone(token, TxOutcome::Sent));
    }

    #[track_caller]
    fn tells(&mut self, expected: &[&str]) {
        assert_eq!(core::mem::take(&mut self.events), expected);
    }

    fn drain(&mut self) {
        while let Some(action) = self.tool.poll(self.now) {
            match action {
                Action::Transmit(token, frame) => {
                    assert!(self.in_flight.is_none(), "two frames in flight");
                    self.in_flight = Some((token, frame));
                }
                Action::Withdraw(_) => self.withdrawals += 1,
                Action::Link(_) => {}
                Action::Event(ToolEvent::Access(_)) => {}
                Action::Event(event) => self.events.push(event.to_string()),
            }
        }
        assert_ne!(self.tool.deadline().map(|deadline| deadline.why), Some("output pending"));
    }
}

#[test]
fn unanswered_twice_the_set_is_owned() {
    let mut bus = Bus::online();
    let who = |tool: &mut OfflineTool, now| tool.who(now, DelayOffset::SERIAL);
    assert_eq!(bus.command(who), Err(CommandError::NotOwner));
    bus.command(|tool, now| tool.claim(now)).unwrap();
    bus.sends("7EF: 05 4B 34 12 45 23 00 00");
    bus.wait(999);
    assert_eq!(bus.in_flight, None);
    bus.wait(1);
    bus.sends("7EF: 05 4B 34 12 45 23 00 00");
    bus.wait(999);
    assert_eq!(bus.tool.state(), ToolState::Claiming);
    bus.wait(1);
    bus.tells(&[
        "Idle -> Claiming: claimed",
        "Claiming -> Claiming: wait over",
        "Claiming -> Owner: nobody owns it",
    ]);
}

/// Any ownership response will do: the bytes of the examples, or none at all.
#[test]
fn an_answer_means_that_another_owns_it() {
    for response in ["7EE: 01 CB 06 00 08 07 06 05", "7EE:"] {
        let mut bus = Bus::online();
        bus.command(|tool, now| tool.claim(now)).unwrap();
        bus.sends("7EF: 05 4B 34 12 45 23 00 00");
        bus.hears(response);
        bus.tells(&["Idle -> Claiming: claimed", "Claiming -> Idle: owned by another tool"]);
        bus.wait(10_000);
        assert_eq!(bus.in_flight, None);
    }
}

#[test]
fn the_owner_defends_the_set() {
    let mut bus = Bus::owner();
    bus.hears("7EF: 01 4B 06 00 08 07 06 05");
    bus.sends("7EE: 05 CB 34 12 45 23 00 00");
    bus.hears("7EF: 01 4B");
    assert_eq!(bus.in_flight, None);
    assert_eq!((bus.tool.counters().defended, bus.tool.counters().ignored), (1, 1));
    // Somebody else thinks that he is the owner.
    bus.hears("7EE: 01 CB 06 00 08 07 06 05");
    assert_eq!(bus.tool.state(), ToolState::Idle);
}

#[test]
fn of_two_that_claim_at_once_the_first_on_the_bus_wins() {
    let mut bus = Bus::online();
    bus.command(|tool, now| tool.claim(now)).unwrap();
    // The other was faster: its request comes while ours waits for the bus.
    bus.hears("7EF: 01 4B 06 00 08 07 06 05");
    bus.sends("7EF: 05 4B 34 12 45 23 00 00");
    assert_eq!(bus.in_flight, None, "no defence");
    bus.hears("7EE: 01 CB 06 00 08 07 06 05");
    assert_eq!(bus.tool.state(), ToolState::Idle);

    bus.command(|tool, now| tool.claim(now)).unwrap();
    bus.sends("7EF: 05 4B 34 12 45 23 00 00");
    bus.hears("7EF: 01 4B 06 00 08 07 06 05");
    bus.sends("7EE: 05 CB 34 12 45 23 00 00");
    bus.wait(1000);
    bus.sends("7EF: 05 4B 34 12 45 23 00 00");
    bus.wait(1000);
    assert_eq!(bus.tool.state(), ToolState::Owner);
}

/// Two frames with one identifier and other data destroy each other until both controllers are off the bus.
#[test]
fn a_collision_is_backed_off_from() {
    let mut bus = Bus::online();
    bus.command(|tool, now| tool.claim(now)).unwrap();
    bus.input(Input::Link(LinkEvent::BusError(BusErrorKind::Bit)));
    assert_eq!(bus.withdrawals, 1);
    let (token, _) = bus.in_flight.take().unwrap();
    bus.input(Input::TxDone(token, TxOutcome::Withdrawn));
    assert_eq!(bus.in_flight, None);
    // 10 ms and ten for each of the low six bits of the serial number 0x2345.
    bus.wait(59);
    assert_eq!(bus.in_flight, None);
    bus.wait(1);
    bus.sends("7EF: 05 4B 34 12 45 23 00 00");
    assert_eq!(bus.tool.counters().collisions, 1);
    // A missing acknowledge is no collision.
    let mut alone = Bus::online();
    alone.command(|tool, now| tool.claim(now)).unwrap();
    alone.input(Input::Link(LinkEvent::BusError(BusErrorKind::Ack)));
    assert_eq!(alone.withdrawals, 0);
}

#[test]
fn a_faulted_node_is_found_and_given_a_mac_id() {
    let mut bus = Bus::owner();
    bus.command(|tool, now| tool.who(now, DelayOffset::SERIAL)).unwrap();
    bus.sends("7ED: 3F 4B 03");
    let busy = bus.command(|tool, now| tool.who(now, DelayOffset::SERIAL));
    assert_eq!(busy, Err(CommandError::Busy));
    bus.wait(80);
    bus.hears("7EC: 00 06 00 08 07 06 05");
    bus.wait(2920);
    bus.tells(&["found vendor 6, serial 0x05060708", "Who: 1 answer"]);
    bus.command(|tool, now| tool.change_mac_id(now, DEVICE, mac(3))).unwrap();
    bus.sends("7ED: 03 4D 06 00 08 07 06 05");
    bus.wait(1);
    bus.hears("41F: 00 06 00 08 07 06 05");
    bus.wait(1000);
    bus.hears("41F: 00 06 00 08 07 06 05");
    bus.wait(1500);
    let last = bus.events.pop().unwrap();
    assert!(last.ends_with("is on line with MAC ID 3"), "{last}");
}

#[test]
fn a_mac_id_that_is_taken() {
    let mut bus = Bus::owner();
    bus.command(|tool, now| tool.change_mac_id(now, DEVICE, mac(3))).unwrap();
    bus.sends("7ED: 03 4D 06 00 08 07 06 05");
    bus.hears("41F: 00 06 00 08 07 06 05");
    bus.hears("41F: 80 34 12 99 99 00 00");
    let last = bus.events.pop().unwrap();
    assert!(last.ends_with("has not MAC ID 3: another node has it"), "{last}");
    bus.command(|tool, now| tool.change_mac_id(now, DEVICE, mac(4))).unwrap();
    bus.sends("7ED: 04 4D 06 00 08 07 06 05");
    bus.wait(3000);
    let last = bus.events.pop().unwrap();
    assert!(last.ends_with("has not MAC ID 4: it does not react"), "{last}");
}

#[test]
fn identify() {
    let mut bus = Bus::owner();
    bus.command(|tool, now| tool.identify(now, NodeSelection::MacId(mac(63)))).unwrap();
    bus.sends("7ED: 7F 4C");
    bus.hears("7EC: 7F CC");
    bus.hears("7EC: 00 06 00 08 07 06 05");
    bus.wait(1000);
    bus.tells(&["Identify: at least one node answers", "Identify: done"]);
    assert_eq!(bus.tool.counters().ignored, 1, "a Who response that nobody asked for");
    bus.command(|tool, now| tool.identify_device(now, DEVICE)).unwrap();
    bus.sends("7ED: 3F 4C 06 00 08 07 06 05");
    bus.wait(1000);
    bus.tells(&["Identify: no answer"]);
}

#[test]
fn released_the_set_is_not_defended() {
    let mut bus = Bus::owner();
    bus.command(|tool, now| tool.who(now, DelayOffset::SERIAL)).unwrap();
    bus.command(|tool, now| {
        tool.release(now);
    });
    assert_eq!(bus.withdrawals, 1);
    let (token, _) = bus.in_flight.take().unwrap();
    bus.input(Input::TxDone(token, TxOutcome::Withdrawn));
    bus.hears("7EF: 01 4B 06 00 08 07 06 05");
    assert_eq!(bus.in_flight, None);
}

#[test]
fn off_line_the_set_is_lost() {
    let mut bus = Bus::owner();
    bus.hears("42F: 80 34 12 99 99 00 00");
    bus.tells(&["Owner -> Idle: off line"]);
}
