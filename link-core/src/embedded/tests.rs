//! A port on a controller with three mailboxes.

use core::convert::Infallible;
use core::ops::ControlFlow;
use core::time::Duration;
extern crate std;
use std::collections::VecDeque;
use std::vec::Vec;

use super::*;
use crate::frame::standard_id;
use crate::machine::{Action, Machine};
use crate::timers::{TimerKey, Timers};

/// A controller with three mailboxes that sends the most urgent frame, and a bus that is free when the test says so.
#[derive(Default)]
struct ThreeMailboxes {
    now: Instant,
    mailboxes: Vec<Frame>,
    on_the_bus: Vec<Frame>,
    sent: VecDeque<(Id, bool)>,
    received: VecDeque<Frame>,
    events: VecDeque<LinkEvent>,
    commands: Vec<LinkCommand>,
    receive_error: Option<embedded_can_types::ErrorKind>,
    /// Breaks the contract: a new frame displaces the first, however urgent that is.
    displaces_any: bool,
}

impl ThreeMailboxes {
    fn bus_is_free_for(&mut self, frames: usize) {
        for _ in 0..frames {
            let Some(place) =
                (0..self.mailboxes.len()).min_by_key(|&place| self.mailboxes[place].arbitration_key())
            else {
                return;
            };
            let frame = self.mailboxes.remove(place);
            self.on_the_bus.push(frame);
            self.sent.push_back((frame.id(), frame.is_remote()));
        }
    }
}

impl Can for ThreeMailboxes {
    type Frame = Frame;
    type Error = embedded_can_types::ErrorKind;

    fn transmit(&mut self, frame: &Frame) -> nb::Result<Option<Frame>, Self::Error> {
        if let (true, Some(first)) = (self.displaces_any, self.mailboxes.first_mut()) {
            return Ok(Some(core::mem::replace(first, *frame)));
        }
        if self.mailboxes.len() < 3 {
            self.mailboxes.push(*frame);
            return Ok(None);
        }
        let least = (0..3).max_by_key(|&place| self.mailboxes[place].arbitration_key()).unwrap();
        if self.mailboxes[least].arbitration_key() <= frame.arbitration_key() {
            return Err(nb::Error::WouldBlock);
        }
        Ok(Some(core::mem::replace(&mut self.mailboxes[least], *frame)))
    }

    fn receive(&mut self) -> nb::Result<Frame, Self::Error> {
        match self.receive_error.take() {
            Some(error) => Err(nb::Error::Other(error)),
            None => self.received.pop_front().ok_or(nb::Error::WouldBlock),
        }
    }
}

impl Driver for ThreeMailboxes {
    fn now(&mut self) -> Instant {
        self.now
    }
    fn sent(&mut self) -> Option<(Id, bool)> {
        self.sent.pop_front()
    }
    fn abort(&mut self, frame: &Frame) -> bool {
        let place = self.mailboxes.iter().position(|other| other == frame);
        place.map(|place| self.mailboxes.remove(place)).is_some()
    }
    fn event(&mut self) -> Option<LinkEvent> {
        self.events.pop_front()
    }
    fn command(&mut self, command: &LinkCommand) -> bool {
        self.commands.push(command.clone());
        if matches!(command, LinkCommand::Reset) {
            self.mailboxes.clear();
        }
        !matches!(command, LinkCommand::SetMode(_))
    }
    fn as_event(&self, error: &Self::Error) -> Option<LinkEvent> {
        matches!(error, embedded_can_types::ErrorKind::Other).then_some(LinkEvent::BusOff)
    }
    fn idle(&mut self, until: Option<Instant>) {
        self.bus_is_free_for(1);
        self.now = until.unwrap_or(self.now).max(self.now);
    }
}

fn frame(id: u16) -> Frame {
    Frame::new(standard_id(id), &[]).unwrap()
}

fn port_with(ids: &[u16]) -> EmbeddedPort<ThreeMailboxes, 5> {
    let mut port = EmbeddedPort::new(ThreeMailboxes::default());
    for &id in ids {
        port.transmit(TxToken(id), frame(id)).unwrap();
    }
    port
}

#[track_caller]
fn assert_next(port: &mut EmbeddedPort<ThreeMailboxes, 5>, expected: Input) {
    let due = Deadline::now(port.now());
    assert_eq!(port.wait(Some(due)).unwrap().1, expected);
}

#[test]
fn a_displaced_frame_is_queued_again_and_sent_in_its_turn() {
    let mut port = port_with(&[0x10, 0x30, 0x20, 0x05, 0x25]);
    assert_eq!(port.driver().mailboxes, [0x10, 0x05, 0x20].map(frame));
    for _ in 0..5 {
        port.driver().bus_is_free_for(1);
        let due = Deadline::now(port.now());
        assert!(matches!(port.wait(Some(due)).unwrap().1, Input::TxDone(_, TxOutcome::Sent)));
        // The answer was taken first; the free mailbox is filled by the next call.
        assert_next(&mut port, Input::Tick);
    }
    assert_eq!(port.driver().on_the_bus, [0x05, 0x10, 0x20, 0x25, 0x30].map(frame));
}

#[test]
fn sent_means_sent_and_not_put_into_a_mailbox() {
    let mut port = port_with(&[0x10]);
    assert_next(&mut port, Input::Tick);
    port.driver().bus_is_free_for(1);
    assert_next(&mut port, Input::TxDone(TxToken(0x10), TxOutcome::Sent));
    assert_next(&mut port, Input::Tick);
}

#[test]
fn frames_of_one_identifier_keep_their_order() {
    let mut port = port_with(&[0x01, 0x02, 0x03]);
    for (token, byte) in [(8, 0xAA), (9, 0xBB)] {
        port.transmit(TxToken(token), Frame::new(standard_id(0x40), &[byte]).unwrap()).unwrap();
    }
    let mut answers = Vec::new();
    while answers.len() < 5 {
        if let Input::TxDone(token, _) = port.wait(None).unwrap().1 {
            answers.push(token.0);
        }
    }
    assert_eq!(answers, [1, 2, 3, 8, 9]);
    let data: Vec<&[u8]> = port.driver.on_the_bus[3..].iter().map(Frame::data).collect();
    assert_eq!(data, [&[0xAA], &[0xBB]]);
}

fn frame_of_0x40(byte: u8) -> Frame {
    Frame::new(standard_id(0x40), &[byte]).unwrap()
}

#[test]
fn two_frames_of_one_identifier_are_never_in_mailboxes_at_a_time() {
    let mut port = port_with(&[]);
    for (token, byte) in [(8, 0xAA), (9, 0xBB)] {
        port.transmit(TxToken(token), frame_of_0x40(byte)).unwrap();
    }
    port.transmit(TxToken(0x50), frame(0x50)).unwrap();
    assert_eq!(port.driver().mailboxes, [frame_of_0x40(0xAA), frame(0x50)]);
}

#[test]
fn a_displaced_frame_goes_before_the_younger_ones_of_its_identifier() {
    let mut port = port_with(&[0x01, 0x02]);
    for (token, byte) in [(8, 0xAA), (9, 0xBB)] {
        port.transmit(TxToken(token), frame_of_0x40(byte)).unwrap();
    }
    port.transmit(TxToken(0x10), frame(0x10)).unwrap();
    assert!(!port.driver().mailboxes.contains(&frame_of_0x40(0xAA)), "displaced");
    let mut answers = Vec::new();
    while answers.len() < 5 {
        if let Input::TxDone(token, _) = port.wait(None).unwrap().1 {
            answers.push(token.0);
        }
    }
    assert_eq!(answers, [0x01, 0x02, 0x10, 8, 9]);
    assert_eq!(port.driver.on_the_bus[3..], [frame_of_0x40(0xAA), frame_of_0x40(0xBB)]);
}

#[test]
fn a_driver_that_displaces_urgent_frames_does_not_keep_the_port_busy_for_ever() {
    let mut port = port_with(&[]);
    port.driver().displaces_any = true;
    for id in [0x10, 0x20] {
        port.transmit(TxToken(id), frame(id)).unwrap();
    }
    assert_eq!(port.frames.iter().map(|pending| pending.in_mailbox).collect::<Vec<_>>(), [true, false]);
}

#[test]
fn withdrawal_reaches_the_queue_and_the_mailbox_but_not_the_bus() {
    let mut port = port_with(&[0x10, 0x20, 0x30, 0x40]);
    port.withdraw(TxToken(0x40)).unwrap();
    assert_next(&mut port, Input::TxDone(TxToken(0x40), TxOutcome::Withdrawn));
    port.withdraw(TxToken(0x20)).unwrap();
    assert_next(&mut port, Input::TxDone(TxToken(0x20), TxOutcome::Withdrawn));
    port.driver().bus_is_free_for(1);
    port.withdraw(TxToken(0x10)).unwrap();
    assert_next(&mut port, Input::TxDone(TxToken(0x10), TxOutcome::Sent));
}

#[test]
fn bus_off_drops_everything_and_says_so_for_each() {
    let mut port = port_with(&[0x10, 0x20, 0x30, 0x40]);
    port.driver().events.push_back(LinkEvent::BusOff);
    assert_next(&mut port, Input::Link(LinkEvent::BusOff));
    let mut dropped = Vec::new();
    for _ in 0..4 {
        let due = Deadline::now(port.now());
        match port.wait(Some(due)).unwrap().1 {
            Input::TxDone(token, TxOutcome::Dropped) => dropped.push(token.0),
            other => panic!("{other:?}"),
        }
    }
    dropped.sort_unstable();
    assert_eq!(dropped, [0x10, 0x20, 0x30, 0x40]);
}

#[test]
fn what_the_peripheral_cannot_do_is_refused_in_words() {
    use crate::link::{BitRate, LinkCommandKind, Mode};
    let mut port = port_with(&[]);
    port.command(LinkCommand::SetMode(Mode { bit_rate: BitRate::K125, listen_only: true })).unwrap();
    assert_next(&mut port, Input::Link(LinkEvent::Refused(LinkCommandKind::SetMode)));
}

#[test]
fn each_refused_command_is_answered() {
    use crate::link::{BitRate, LinkCommandKind, Mode};
    let mut port = port_with(&[]);
    for listen_only in [true, false] {
        port.command(LinkCommand::SetMode(Mode { bit_rate: BitRate::K125, listen_only })).unwrap();
    }
    for _ in 0..2 {
        assert_next(&mut port, Input::Link(LinkEvent::Refused(LinkCommandKind::SetMode)));
    }
    assert_next(&mut port, Input::Tick);
}

#[test]
fn a_refused_mode_drops_no_frame() {
    use crate::link::{BitRate, LinkCommandKind, Mode};
    let mut port = port_with(&[0x10]);
    port.command(LinkCommand::SetMode(Mode { bit_rate: BitRate::K125, listen_only: true })).unwrap();
    assert_next(&mut port, Input::Link(LinkEvent::Refused(LinkCommandKind::SetMode)));
    port.driver().bus_is_free_for(1);
    assert_next(&mut port, Input::TxDone(TxToken(0x10), TxOutcome::Sent));
}

#[test]
fn what_was_sent_before_a_reset_was_sent() {
    let mut port = port_with(&[0x10, 0x20]);
    port.driver().bus_is_free_for(1);
    port.command(LinkCommand::Reset).unwrap();
    assert_next(&mut port, Input::TxDone(TxToken(0x10), TxOutcome::Sent));
    assert_next(&mut port, Input::TxDone(TxToken(0x20), TxOutcome::Dropped));
}

#[test]
fn bus_off_reported_as_a_receive_error_drops_what_was_in_flight() {
    let mut port = port_with(&[0x10]);
    port.driver().receive_error = Some(embedded_can_types::ErrorKind::Other);
    assert_next(&mut port, Input::Link(LinkEvent::BusOff));
    assert_next(&mut port, Input::TxDone(TxToken(0x10), TxOutcome::Dropped));
}

#[test]
fn bus_off_and_a_command_leave_room_for_every_answer() {
    let mut port = port_with(&[1, 2, 3, 4, 5]);
    port.driver().bus_is_free_for(2);
    port.driver().mailboxes.clear();
    port.driver().events.push_back(LinkEvent::BusOff);
    port.command(LinkCommand::Reset).unwrap();
    let outcome = |id| if id <= 2 { TxOutcome::Sent } else { TxOutcome::Dropped };
    let mut answers = Vec::new();
    for _ in 0..5 {
        let due = Deadline::now(port.now());
        match port.wait(Some(due)).unwrap().1 {
            Input::TxDone(token, told) => answers.push((token.0, told)),
            other => panic!("{other:?}"),
        }
    }
    answers.sort_unstable_by_key(|&(token, _)| token);
    assert_eq!(answers, [1, 2, 3, 4, 5].map(|id| (id, outcome(id))));
    assert_next(&mut port, Input::Link(LinkEvent::BusOff));
}

#[test]
fn too_many_frames_are_an_error_and_not_lost() {
    let mut port = port_with(&[1, 2, 3, 4, 5]);
    assert_eq!(port.transmit(TxToken(6), frame(6)), Err(EmbeddedError::TooManyInFlight));
}

/// Sends a frame, waits 10 ms from its transmission, and tells.
#[derive(Default)]
struct Once {
    timers: Timers<Wait, 1>,
    stage: u8,
}

#[derive(Clone, Copy, Debug)]
struct Wait;
impl TimerKey<1> for Wait {
    const ALL: [Self; 1] = [Self];
    const WHY: [&'static str; 1] = ["wait"];
    fn index(self) -> usize {
        0
    }
}

impl Machine for Once {
    type Event = &'static str;
    fn input(&mut self, now: Instant, input: Input) {
        self.timers.advance(now);
        if matches!(input, Input::TxDone(_, TxOutcome::Sent)) {
            self.timers.set_after(Wait, Duration::from_millis(10));
        }
    }
    fn poll(&mut self, now: Instant) -> Option<Action<Self::Event>> {
        if self.stage == 0 {
            self.stage = 1;
            return Some(Action::Transmit(TxToken(0), frame(0x52F)));
        }
        self.timers.take_expired(now).map(|Wait| Action::Event("over"))
    }
    fn deadline(&self) -> Option<Deadline> {
        if self.stage == 0 { Some(Deadline::now(Instant::ZERO)) } else { self.timers.next() }
    }
    fn max_in_flight(&self) -> usize {
        1
    }
}

#[test]
fn the_run_loop_carries_a_machine_to_its_event() {
    let mut port = EmbeddedPort::<_, 1>::new(ThreeMailboxes::default());
    let ended =
        crate::drive(&mut Once::default(), &mut port, |_, now, event| ControlFlow::Break((now, event)));
    assert_eq!(ended, Ok((Instant::from_millis(10), "over")));
    assert_eq!(port.driver().on_the_bus, [frame(0x52F)]);
}

/// A driver without errors of its own is a driver too.
#[test]
fn errors_name_their_remedy() {
    let error: EmbeddedError<Infallible> = EmbeddedError::TooManyInFlight;
    assert!(std::format!("{error}").contains("max_in_flight"));
}
