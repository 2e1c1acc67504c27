//! A [`Port`] on an `embedded_can` driver, for microcontrollers.
//!
//! `embedded_can` says how to hand a frame to a mailbox and how to take one from a receive queue. It does not say when a
//! frame was *sent*, which is what protocols time their waits by; nor does it know bus-off, filters or the time. A firmware
//! adds these in [`Driver`], a few lines over its CAN peripheral.
//!
//! The port keeps at most `N` frames: those in mailboxes, and those for which there is no mailbox yet. A frame that a
//! driver displaces from its mailbox for a more urgent one is queued again. Two frames of one identifier are never in
//! mailboxes at a time: a controller may send them in either order, and nobody could tell which of them was sent.

use embedded_can_types::nb::Can;
use embedded_can_types::{Frame as _, Id};
use heapless::{Deque, Vec};

use crate::drive::Port;
use crate::frame::Frame;
use crate::link::{LinkCommand, LinkCommandKind, LinkEvent};
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

    /// The next thing that happened below the frame. The first is [`LinkEvent::Up`], once the peripheral takes part in the
    /// bus, though nobody has asked for it: a machine is without power until then. When it tells of
    /// [`LinkEvent::BusOff`] or [`LinkEvent::Down`], the mailboxes are empty.
    fn event(&mut self) -> Option<LinkEvent>;

    /// Carries out a command; its answer comes by [`event`](Self::event). [`LinkCommand::Reset`] and
    /// [`LinkCommand::SetMode`] empty the mailboxes. `false` where the peripheral cannot; then nothing has changed.
    ///
    /// A [`LinkCommand::SetFilter`] may repeat the filters that are in force. A driver for which setting them is dear, or
    /// loses frames, keeps the last [`FilterSet`](crate::FilterSet) and compares; [`LinkEvent::FilterSet`] is the answer
    /// all the same.
    fn command(&mut self, command: &LinkCommand) -> bool;

    /// Whether an error of [`Can::receive`] is an event of the bus, such as a receive overrun, and which. `None` ends
    /// the drive loop, and so does every error of [`Can::transmit`].
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
    /// Commands that the driver cannot carry out, of which the machine has not heard yet.
    refused: Deque<LinkCommandKind, MAX_REFUSED>,
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
    /// The machine repeats commands that the driver refuses, and does not wait for the answers.
    #[error(
        "more than {MAX_REFUSED} refused commands without a wait: take the answer to a command before the next"
    )]
    TooManyRefused,
}

#[derive(Clone, Copy, Debug)]
struct Pending {
    token: TxToken,
    frame: Frame,
}

impl<D: Driver, const N: usize> EmbeddedPort<D, N> {
    /// A port on a driver that takes part in the bus already, or will say so by [`LinkEvent::Up`].
    pub const fn new(driver: D) -> Self {
        Self {
            driver,
            waiting: Vec::new(),
            mailboxes: Vec::new(),
            answers: Deque::new(),
            refused: Deque::new(),
        }
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
        // A frame goes in once, and comes out again at most once. The bound is for a driver that displaces a frame for
        // a less urgent one, which would never end.
        for _ in 0..N.saturating_mul(2) {
            let Some(place) = self.waiting.iter().rposition(|pending| !self.is_in_mailbox(&pending.frame))
            else {
                break;
            };
            let Some(&pending) = self.waiting.get(place) else { break };
            let Some(frame) = pending.frame.to_can::<D::Frame>() else {
                // The driver's frame type cannot hold it, so it will never be sent.
                self.waiting.remove(place);
                self.answer(pending.token, TxOutcome::Dropped)?;
                continue;
            };
            match self.driver.transmit(&frame) {
                Ok(displaced) => {
                    self.waiting.remove(place);
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

    /// Whether a frame of this identifier and kind is in a mailbox.
    fn is_in_mailbox(&self, frame: &Frame) -> bool {
        self.mailboxes.iter().any(|other| other.frame.arbitration_key() == frame.arbitration_key())
    }

    fn take_from_mailbox(&mut self, id: Id, remote: bool) -> Option<Pending> {
        let place = self
            .mailboxes
            .iter()
            .position(|Pending { frame, .. }| (frame.id(), frame.is_remote()) == (id, remote))?;
        Some(self.mailboxes.swap_remove(place))
    }

    fn queue_again(&mut self, displaced: &D::Frame) -> Result<(), EmbeddedError<D::Error>> {
        let Some(pending) = self.take_from_mailbox(displaced.id(), displaced.is_remote_frame()) else {
            return Ok(());
        };
        let key = pending.frame.arbitration_key();
        // Before those of equal urgency, which are younger.
        let place = self.waiting.iter().take_while(|other| other.frame.arbitration_key() >= key).count();
        self.waiting.insert(place, pending).map_err(|_| EmbeddedError::TooManyInFlight)
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

    /// Takes note of what the driver has sent.
    fn confirm_sent(&mut self) -> Result<(), EmbeddedError<D::Error>> {
        while let Some((id, remote)) = self.driver.sent() {
            if let Some(pending) = self.take_from_mailbox(id, remote) {
                self.answer(pending.token, TxOutcome::Sent)?;
            }
        }
        Ok(())
    }

    /// The controller went away, and with it whatever it had.
    fn drop_all(&mut self) -> Result<(), EmbeddedError<D::Error>> {
        while let Some(pending) = self.mailboxes.pop().or_else(|| self.waiting.pop()) {
            self.answer(pending.token, TxOutcome::Dropped)?;
        }
        Ok(())
    }

    fn next_input(&mut self) -> Result<Option<Input>, EmbeddedError<D::Error>> {
        self.confirm_sent()?;
        if self.answers.is_empty() {
            let refused = self.refused.pop_front().map(LinkEvent::Refused);
            if let Some(event) = refused.or_else(|| self.driver.event()) {
                return self.link(event).map(Some);
            }
            self.fill_mailboxes()?;
        }
        if let Some((token, outcome)) = self.answers.pop_front() {
            return Ok(Some(Input::TxDone(token, outcome)));
        }
        loop {
            match self.driver.receive() {
                Ok(frame) => match Frame::from_can(&frame) {
                    Some(frame) => return Ok(Some(Input::Frame(frame))),
                    // Not a classic frame. There may be others behind it, and no interrupt for them.
                    None => continue,
                },
                Err(nb::Error::WouldBlock) => return Ok(None),
                Err(nb::Error::Other(error)) => {
                    let event = self.driver.as_event(&error).ok_or(EmbeddedError::Driver(error))?;
                    return self.link(event).map(Some);
                }
            }
        }
    }

    fn link(&mut self, event: LinkEvent) -> Result<Input, EmbeddedError<D::Error>> {
        if matches!(event, LinkEvent::BusOff | LinkEvent::Down | LinkEvent::ModeSet(_)) {
            self.drop_all()?;
        }
        Ok(Input::Link(event))
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
        // What was sent before the command was sent, whatever the command does.
        self.confirm_sent()?;
        if !self.driver.command(&command) {
            return self.refused.push_back(command.kind()).map_err(|_| EmbeddedError::TooManyRefused);
        }
        if matches!(command, LinkCommand::Reset | LinkCommand::SetMode(_)) {
            self.drop_all()?;
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

/// More than there are kinds of commands, each of which a machine gives once and then awaits its answer.
const MAX_REFUSED: usize = 4;

#[cfg(test)]
mod tests;
