//! A [`Port`] on an `embedded_can` driver, for microcontrollers.
//!
//! `embedded_can` says how to hand a frame to a mailbox and how to take one from a receive queue. It does not say when a
//! frame was *sent*, which is what protocols time their waits by; nor does it know bus-off, filters or the time. A firmware
//! adds these in [`Driver`], a few lines over its CAN peripheral.
//!
//! The port keeps at most `N` frames: those in mailboxes, and those for which there is no mailbox yet. A frame that a
//! driver displaces from its mailbox for a more urgent one is queued again.

use embedded_can_types::Id;
use embedded_can_types::nb::Can;
use heapless::{Deque, Vec};

use crate::drive::Port;
use crate::frame::Frame;
use crate::link::{LinkCommand, LinkEvent};
use crate::machine::{Deadline, Input, TxOutcome, TxToken};
use crate::time::Instant;

/// A CAN peripheral: `embedded_can`'s trait, and what it leaves out.
pub trait Driver: Can {
    /// The present moment, from a timer of the chip.
    fn now(&mut self) -> Instant;

    /// A frame that a mailbox reports as sent and acknowledged, each once: its identifier, and whether it was a remote
    /// frame.
    fn sent(&mut self) -> Option<(Id, bool)>;

    /// Asks the mailbox that holds this frame to give it up. `true`: it will not be sent. `false`: it is on the bus, and
    /// [`sent`](Self::sent) will tell.
    fn abort(&mut self, frame: &Frame) -> bool;

    /// The next thing that happened below the frame.
    fn event(&mut self) -> Option<LinkEvent>;

    /// Carries out a command; its answer comes by [`event`](Self::event). `false` where the peripheral cannot.
    fn command(&mut self, command: &LinkCommand) -> bool;

    /// Whether an error of [`Can`] is an event of the bus, such as a receive overrun, and which. `None` ends the drive
    /// loop.
    fn as_event(&self, error: &Self::Error) -> Option<LinkEvent> {
        let _ = error;
        None
    }

    /// Sleeps until an interrupt, at most until `until`; it may return early.
    fn idle(&mut self, until: Option<Instant>);
}

/// A [`Port`] with room for `N` frames in flight: at least the machine's
/// [`max_in_flight`](crate::Machine::max_in_flight).
#[derive(Debug)]
pub struct EmbeddedPort<D, const N: usize> {
    driver: D,
    /// Waiting for a mailbox, the most urgent last.
    waiting: Vec<Pending, N>,
    /// In a mailbox.
    mailboxes: Vec<Pending, N>,
    /// Answers that the machine has not got yet; until then they count as in flight.
    answers: Deque<(TxToken, TxOutcome), N>,
    refused: Option<LinkEvent>,
}

/// Why an [`EmbeddedPort`] gave up.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum EmbeddedError<E> {
    /// The driver failed.
    #[error("the CAN driver failed: {0:?}")]
    Driver(E),
    /// The machine has more frames in flight than the port has room for.
    #[error("more frames in flight than the port was made for: raise N to the machine's max_in_flight")]
    TooManyInFlight,
}

#[derive(Clone, Copy, Debug)]
struct Pending {
    token: TxToken,
    frame: Frame,
}

impl<D: Driver, const N: usize> EmbeddedPort<D, N> {
    /// A port on a driver that takes part in the bus already, or will say so by [`LinkEvent::Up`].
    pub const fn new(driver: D) -> Self {
        Self { driver, waiting: Vec::new(), mailboxes: Vec::new(), answers: Deque::new(), refused: None }
    }

    /// The driver, for what is not the port's business.
    pub const fn driver(&mut self) -> &mut D {
        &mut self.driver
    }

    fn in_flight(&self) -> usize {
        self.waiting.len().saturating_add(self.mailboxes.len()).saturating_add(self.answers.len())
    }

    /// Puts waiting frames into mailboxes while there are any to be had.
    fn fill_mailboxes(&mut self) -> Result<(), EmbeddedError<D::Error>> {
        while let Some(&pending) = self.waiting.last() {
            let Some(frame) = pending.frame.to_can::<D::Frame>() else {
                // The driver's frame type cannot hold it, so it will never be sent.
                self.waiting.pop();
                self.answer(pending.token, TxOutcome::Dropped)?;
                continue;
            };
            match self.driver.transmit(&frame) {
                Ok(displaced) => {
                    self.waiting.pop();
                    if let Some(displaced) = displaced {
                        self.queue_again(&displaced)?;
                    }
                    self.mailboxes.push(pending).map_err(|_| EmbeddedError::TooManyInFlight)?;
                }
                Err(nb::Error::WouldBlock) => break,
                Err(nb::Error::Other(error)) => return Err(EmbeddedError::Driver(error)),
            }
        }
        Ok(())
    }

    fn queue_again(&mut self, displaced: &D::Frame) -> Result<(), EmbeddedError<D::Error>> {
        let Some(displaced) = Frame::from_can(displaced) else { return Ok(()) };
        let Some(place) = self.mailboxes.iter().position(|pending| pending.frame == displaced) else {
            return Ok(());
        };
        let pending = self.mailboxes.swap_remove(place);
        self.enqueue(pending)
    }

    fn enqueue(&mut self, pending: Pending) -> Result<(), EmbeddedError<D::Error>> {
        let key = pending.frame.arbitration_key();
        // Behind those of equal urgency, so that frames of one identifier keep their order.
        let place = self.waiting.iter().take_while(|other| other.frame.arbitration_key() > key).count();
        self.waiting.insert(place, pending).map_err(|_| EmbeddedError::TooManyInFlight)
    }

    fn answer(&mut self, token: TxToken, outcome: TxOutcome) -> Result<(), EmbeddedError<D::Error>> {
        self.answers.push_back((token, outcome)).map_err(|_| EmbeddedError::TooManyInFlight)
    }

    fn confirm(&mut self, (id, remote): (Id, bool)) -> Result<(), EmbeddedError<D::Error>> {
        let place = self
            .mailboxes
            .iter()
            .position(|Pending { frame, .. }| (frame.id(), frame.is_remote()) == (id, remote));
        let Some(place) = place else { return Ok(()) };
        let pending = self.mailboxes.remove(place);
        self.answer(pending.token, TxOutcome::Sent)
    }

    /// The controller went away, and with it whatever it had.
    fn drop_all(&mut self) -> Result<(), EmbeddedError<D::Error>> {
        while let Some(pending) = self.mailboxes.pop().or_else(|| self.waiting.pop()) {
            self.answer(pending.token, TxOutcome::Dropped)?;
        }
        Ok(())
    }

    fn next_input(&mut self) -> Result<Option<Input>, EmbeddedError<D::Error>> {
        while let Some(sent) = self.driver.sent() {
            self.confirm(sent)?;
        }
        if let Some((token, outcome)) = self.answers.pop_front() {
            return Ok(Some(Input::TxDone(token, outcome)));
        }
        if let Some(event) = self.refused.take().or_else(|| self.driver.event()) {
            if matches!(event, LinkEvent::BusOff | LinkEvent::Down | LinkEvent::ModeSet(_)) {
                self.drop_all()?;
            }
            return Ok(Some(Input::Link(event)));
        }
        self.fill_mailboxes()?;
        match self.driver.receive() {
            Ok(frame) => Ok(Frame::from_can(&frame).map(Input::Frame)),
            Err(nb::Error::WouldBlock) => Ok(None),
            Err(nb::Error::Other(error)) => match self.driver.as_event(&error) {
                Some(event) => Ok(Some(Input::Link(event))),
                None => Err(EmbeddedError::Driver(error)),
            },
        }
    }
}

impl<D: Driver, const N: usize> Port for EmbeddedPort<D, N> {
    type Error = EmbeddedError<D::Error>;

    fn now(&mut self) -> Instant {
        self.driver.now()
    }

    fn transmit(&mut self, token: TxToken, frame: Frame) -> Result<(), Self::Error> {
        if self.in_flight() >= N {
            return Err(EmbeddedError::TooManyInFlight);
        }
        self.enqueue(Pending { token, frame })?;
        self.fill_mailboxes()
    }

    fn withdraw(&mut self, token: TxToken) -> Result<(), Self::Error> {
        if let Some(place) = self.waiting.iter().position(|pending| pending.token == token) {
            self.waiting.remove(place);
            return self.answer(token, TxOutcome::Withdrawn);
        }
        let Some(place) = self.mailboxes.iter().position(|pending| pending.token == token) else {
            // Its answer is on the way.
            return Ok(());
        };
        let aborted = self.mailboxes.get(place).is_some_and(|pending| self.driver.abort(&pending.frame));
        if aborted {
            self.mailboxes.remove(place);
            self.answer(token, TxOutcome::Withdrawn)?;
        }
        Ok(())
    }

    fn command(&mut self, command: LinkCommand) -> Result<(), Self::Error> {
        if matches!(command, LinkCommand::Reset | LinkCommand::SetMode(_)) {
            self.drop_all()?;
        }
        if !self.driver.command(&command) {
            self.refused = Some(LinkEvent::Refused(command.kind()));
        }
        Ok(())
    }

    fn wait(&mut self, deadline: Option<Deadline>) -> Result<(Instant, Input), Self::Error> {
        loop {
            if let Some(input) = self.next_input()? {
                return Ok((self.driver.now(), input));
            }
            let now = self.driver.now();
            if deadline.is_some_and(|deadline| deadline.at <= now) {
                return Ok((now, Input::Tick));
            }
            self.driver.idle(deadline.map(|deadline| deadline.at));
        }
    }
}

#[cfg(test)]
mod tests {
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
            self.received.pop_front().ok_or(nb::Error::WouldBlock)
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
            !matches!(command, LinkCommand::SetMode(_))
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
        fn index(self) -> usize {
            0
        }
        fn why(self) -> &'static str {
            "wait"
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
}
