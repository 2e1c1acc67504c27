//! The contract between a protocol core and whatever drives it.

use crate::frame::Frame;
use crate::link::{LinkCommand, LinkEvent};
use crate::time::Instant;

/// What a machine is told.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Input {
    /// A frame of *another* node was received. A port never delivers a machine's own frames back.
    Frame(Frame),
    /// What became of an [`Action::Transmit`]. Each is answered exactly once.
    TxDone(TxToken, TxOutcome),
    /// Something happened below the frame.
    Link(LinkEvent),
    /// Time has passed. Early or repeated ticks change nothing.
    Tick,
}

/// What a machine wants done.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum Action<E> {
    /// Send a frame. The token comes back in [`Input::TxDone`]; a machine does not use it again before that.
    Transmit(TxToken, Frame),
    /// Do not send it after all, if it is not on the bus yet. Answered by the [`Input::TxDone`] of that token, which
    /// tells who was faster.
    Withdraw(TxToken),
    /// A wish to the controller.
    Link(LinkCommand),
    /// Something that the application may want to know.
    Event(E),
}

impl<E> Action<E> {
    /// The action as one of a machine with other events: for a machine that answers the events of another itself, and
    /// passes on all else.
    ///
    /// # Errors
    /// The event, which cannot be passed on.
    ///
    /// ```
    /// use link_core::{Action, TxToken};
    ///
    /// let withdraw: Action<u8> = Action::Withdraw(TxToken(1));
    /// assert_eq!(withdraw.without_event::<char>(), Ok(Action::Withdraw(TxToken(1))));
    /// assert_eq!(Action::Event(7).without_event::<char>(), Err(7));
    /// ```
    pub fn without_event<F>(self) -> Result<Action<F>, E> {
        Ok(match self {
            Self::Transmit(token, frame) => Action::Transmit(token, frame),
            Self::Withdraw(token) => Action::Withdraw(token),
            Self::Link(command) => Action::Link(command),
            Self::Event(event) => return Err(event),
        })
    }

    /// The same action with another type of event.
    pub fn map_event<F>(self, convert: impl FnOnce(E) -> F) -> Action<F> {
        match self {
            Self::Transmit(token, frame) => Action::Transmit(token, frame),
            Self::Withdraw(token) => Action::Withdraw(token),
            Self::Link(command) => Action::Link(command),
            Self::Event(event) => Action::Event(convert(event)),
        }
    }
}

impl<E> Action<Option<E>> {
    /// The same action, unless it is an event that is none.
    pub fn transpose(self) -> Option<Action<E>> {
        Some(match self {
            Self::Transmit(token, frame) => Action::Transmit(token, frame),
            Self::Withdraw(token) => Action::Withdraw(token),
            Self::Link(command) => Action::Link(command),
            Self::Event(event) => Action::Event(event?),
        })
    }
}

/// Names a conversation of one machine that may have one frame in flight.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TxToken(pub u16);

/// What became of a frame that was to be sent.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum TxOutcome {
    /// It was on the bus, and another node acknowledged it.
    Sent,
    /// It was withdrawn before it was sent.
    Withdrawn,
    /// It will never be sent: the controller went off the bus, was reset, or changed its mode.
    Dropped,
    /// Nobody can tell what became of it, though the controller takes part in the bus: the transport has lost the answer. It
    /// may have been sent; if the machine sends it again, it may be on the bus twice.
    Unknown,
}

/// A moment by which a machine must be called, and why.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Deadline {
    /// Call [`Machine::input`] with [`Input::Tick`] at this moment at the latest.
    pub at: Instant,
    /// What is being waited for, in words.
    pub why: &'static str,
}

impl Deadline {
    /// Output is pending: drain it now.
    #[must_use]
    pub const fn now(now: Instant) -> Self {
        Self { at: now, why: "output pending" }
    }

    /// The earlier one of two that there may be; of equals, the first.
    #[must_use]
    pub fn earlier(one: Option<Self>, other: Option<Self>) -> Option<Self> {
        match (one, other) {
            (Some(first), Some(second)) => Some(if second.at < first.at { second } else { first }),
            (first, second) => first.or(second),
        }
    }
}

/// A protocol core: frames and ticks in, actions out; no clock, no socket, no queue.
///
/// The order of calls:
///
/// 1. call [`input`](Self::input), or a command of the concrete machine;
/// 2. call [`poll`](Self::poll) until it returns `None`, and carry out what it returns;
/// 3. wait for the next input, until [`deadline`](Self::deadline) at the latest, and begin again.
///
/// [`handle`](Self::handle) does 1 and 2 in a way that cannot be got wrong. The trait can be used as
/// `dyn Machine<Event = E>`, so that machines of different protocols share a bus.
pub trait Machine {
    /// What it tells the application.
    type Event: core::fmt::Debug;

    /// Takes note of something. Never fails, never blocks, and does a bounded amount of work.
    fn input(&mut self, now: Instant, input: Input);

    /// The next thing to do, or `None` when there is nothing more for now.
    fn poll(&mut self, now: Instant) -> Option<Action<Self::Event>>;

    /// When it must be called next; a moment that has passed while output is pending.
    fn deadline(&self) -> Option<Deadline>;

    /// The greatest number of frames that it ever has in flight at once. A transport sizes its queue by this.
    fn max_in_flight(&self) -> usize;

    /// Feeds one input and returns the actions that follow from it.
    ///
    /// The iterator borrows the machine, so nothing else can happen to it before the actions are drained. Dropping
    /// it early loses nothing: the rest stays pending, and [`deadline`](Self::deadline) says so.
    fn handle(&mut self, now: Instant, input: Input) -> Actions<'_, Self>
    where
        Self: Sized,
    {
        self.input(now, input);
        Actions { machine: self, now }
    }
}

/// The actions that are pending in a machine.
#[must_use = "a machine's actions must be carried out"]
#[derive(Debug)]
pub struct Actions<'a, M> {
    machine: &'a mut M,
    now: Instant,
}

impl<'a, M: Machine> Actions<'a, M> {
    /// What is pending in `machine`, for example after a command.
    pub fn of(machine: &'a mut M, now: Instant) -> Self {
        Self { machine, now }
    }
}

impl<M: Machine> Iterator for Actions<'_, M> {
    type Item = Action<M::Event>;

    fn next(&mut self) -> Option<Self::Item> {
        self.machine.poll(self.now)
    }
}

impl<M: Machine + ?Sized> Machine for &mut M {
    type Event = M::Event;

    fn input(&mut self, now: Instant, input: Input) {
        (**self).input(now, input);
    }

    fn poll(&mut self, now: Instant) -> Option<Action<Self::Event>> {
        (**self).poll(now)
    }

    fn deadline(&self) -> Option<Deadline> {
        (**self).deadline()
    }

    fn max_in_flight(&self) -> usize {
        (**self).max_in_flight()
    }
}
