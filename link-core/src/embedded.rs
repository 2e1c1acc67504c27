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

use crate::drive::Port;
use crate::frame::Frame;
use crate::link::{LinkCommand, LinkCommandKind, LinkEvent};
use crate::machine::{Deadline, Input, TxOutcome, TxToken};
use crate::queue::Queue;
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

/// A [`Port`] with room for `N` frames in flight, at most 127: at least the machine's
/// [`max_in_flight`](crate::Machine::max_in_flight), which each machine has as a constant too.
///
/// | machine | `MAX_IN_FLIGHT` |
/// |---|---|
/// | network access, of DeviceNet and of DeviceNeX | 1 |
/// | the offline recovery tool | 2 |
/// | a Group 2 Only server | 6 |
/// | a slave with the UCMM and `DYNAMIC` connections | 7 + `DYNAMIC` |
/// | a DeviceNet master | 12 |
/// | a DeviceNeX device with `CONNECTIONS` | 3 + `CONNECTIONS` |
/// | a DeviceNeX manager | 7 |
///
/// ```
/// use link_core::embedded::{Driver, EmbeddedPort};
/// # struct Slave;
/// # impl Slave { const MAX_IN_FLIGHT: usize = 6; }
///
/// fn port<D: Driver>(driver: D) -> EmbeddedPort<D, { Slave::MAX_IN_FLIGHT }> {
///     EmbeddedPort::new(driver)
/// }
/// ```
#[derive(Debug)]
pub struct EmbeddedPort<D, const N: usize> {
    driver: D,
    /// In a mailbox or waiting for one, in the order in which they came: so frames of one identifier keep theirs, and a
    /// displaced one goes before the younger ones.
    frames: Queue<Pending, N>,
    /// Answers that the machine has not got yet; until then they count as in flight.
    answers: Queue<(TxToken, TxOutcome), N>,
    /// Commands that the driver cannot carry out, of which the machine has not heard yet.
    refused: Queue<LinkCommandKind, MAX_REFUSED>,
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
    in_mailbox: bool,
}

impl<D: Driver, const N: usize> EmbeddedPort<D, N> {
    /// A port on a driver whose first [`event`](Driver::event) will be [`LinkEvent::Up`], also if it takes part in the bus
    /// already. Without it no machine ever starts.
    pub const fn new(driver: D) -> Self {
        Self { driver, frames: Queue::new(), answers: Queue::new(), refused: Queue::new() }
    }

    /// The driver, for what is not the port's business.
    pub const fn driver(&mut self) -> &mut D {
        &mut self.driver
    }

    fn in_flight(&self) -> usize {
        self.frames.len().saturating_add(self.answers.len())
    }

    /// Puts waiting frames into mailboxes while there are any to be had.
    fn fill_mailboxes(&mut self) -> Result<(), EmbeddedError<D::Error>> {
        // A frame goes in once, and comes out again at most once. The bound is for a driver that displaces a frame for
        // a less urgent one, which would never end.
        for _ in 0..N.saturating_mul(2) {
            let Some(pending) = self.most_urgent() else { break };
            let Some(frame) = pending.frame.to_can::<D::Frame>() else {
                // The driver's frame type cannot hold it, so it will never be sent.
                self.settle(pending.token, TxOutcome::Dropped)?;
                continue;
            };
            match self.driver.transmit(&frame) {
                Ok(displaced) => {
                    if let Some(displaced) = displaced {
                        let displaced = self.in_mailbox_as(displaced.id(), displaced.is_remote_frame());
                        self.mark(displaced, false);
                    }
                    self.mark(Some(pending.token), true);
                }
                Err(nb::Error::WouldBlock) => break,
                Err(nb::Error::Other(error)) => return Err(EmbeddedError::Driver(error)),
            }
        }
        Ok(())
    }

    /// The frame to go into a mailbox next; of equals, the oldest.
    fn most_urgent(&self) -> Option<Pending> {
        self.frames
            .iter()
            .filter(|pending| !pending.in_mailbox && !self.is_in_mailbox(&pending.frame))
            .min_by_key(|pending| pending.frame.arbitration_key())
            .copied()
    }

    /// Whether a frame of this identifier and kind is in a mailbox.
    fn is_in_mailbox(&self, frame: &Frame) -> bool {
        self.frames
            .iter()
            .any(|other| other.in_mailbox && other.frame.arbitration_key() == frame.arbitration_key())
    }

    /// Which frame it is that a mailbox names so.
    fn in_mailbox_as(&self, id: Id, remote: bool) -> Option<TxToken> {
        let mut in_mailboxes = self.frames.iter().filter(|pending| pending.in_mailbox);
        let is_it = |frame: &Frame| (frame.id(), frame.is_remote()) == (id, remote);
        in_mailboxes.find(|pending| is_it(&pending.frame)).map(|pending| pending.token)
    }

    fn mark(&mut self, token: Option<TxToken>, in_mailbox: bool) {
        if let Some(pending) = self.frames.find_mut(|pending| Some(pending.token) == token) {
            pending.in_mailbox = in_mailbox;
        }
    }

    /// Takes a frame, and answers it. One that is not there has its answer on the way.
    fn settle(&mut self, token: TxToken, outcome: TxOutcome) -> Result<(), EmbeddedError<D::Error>> {
        match self.frames.pop_where(|pending| pending.token == token) {
            Some(pending) => self.answer(pending.token, outcome),
            None => Ok(()),
        }
    }

    fn answer(&mut self, token: TxToken, outcome: TxOutcome) -> Result<(), EmbeddedError<D::Error>> {
        self.answers.push((token, outcome)).map_err(|_| EmbeddedError::TooManyInFlight)
    }

    /// Takes note of what the driver has sent.
    fn confirm_sent(&mut self) -> Result<(), EmbeddedError<D::Error>> {
        while let Some((id, remote)) = self.driver.sent() {
            if let Some(token) = self.in_mailbox_as(id, remote) {
                self.settle(token, TxOutcome::Sent)?;
            }
        }
        Ok(())
    }

    /// The controller went away, and with it whatever it had.
    fn drop_all(&mut self) -> Result<(), EmbeddedError<D::Error>> {
        while let Some(pending) = self.frames.pop() {
            self.answer(pending.token, TxOutcome::Dropped)?;
        }
        Ok(())
    }

    fn next_input(&mut self) -> Result<Option<Input>, EmbeddedError<D::Error>> {
        self.confirm_sent()?;
        if self.answers.is_empty() {
            let refused = self.refused.pop().map(LinkEvent::Refused);
            if let Some(event) = refused.or_else(|| self.driver.event()) {
                return self.link(event).map(Some);
            }
            self.fill_mailboxes()?;
        }
        if let Some((token, outcome)) = self.answers.pop() {
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
        let pending = Pending { token, frame, in_mailbox: false };
        self.frames.push(pending).map_err(|_| EmbeddedError::TooManyInFlight)?;
        self.fill_mailboxes()
    }

    fn withdraw(&mut self, token: TxToken) -> Result<(), Self::Error> {
        let pending = self.frames.iter().find(|pending| pending.token == token);
        if pending.is_some_and(|pending| pending.in_mailbox && !self.driver.abort(&pending.frame)) {
            return Ok(());
        }
        self.settle(token, TxOutcome::Withdrawn)
    }

    fn command(&mut self, command: LinkCommand) -> Result<(), Self::Error> {
        // What was sent before the command was sent, whatever the command does.
        self.confirm_sent()?;
        if !self.driver.command(&command) {
            return self.refused.push(command.kind()).map_err(|_| EmbeddedError::TooManyRefused);
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
