//! A node whose frames come from outside: a live interface, a user interface, a test.

use std::collections::VecDeque;
use std::convert::Infallible;
use std::time::Duration;

use link_core::timers::TimerKey;
use link_core::{
    Action, Deadline, Frame, Input, Instant, LinkCommand, LinkEvent, Machine, Timers, TxOutcome,
};

use super::TOKEN;

/// Two mailboxes. The driver puts frames into one by [`inject`](Self::inject), within a
/// [`command`](crate::Network::command), and takes what happened out of the other.
///
/// Neither grows without bound. A frame that was injected has its place until the driver has taken the answer to it;
/// when [`CAPACITY`](Self::CAPACITY) have, or as many as [`with_capacity`](Self::with_capacity) says, the next is refused.
/// Of what happened on the bus as many are kept, and what comes then is counted and told as [`LinkEvent::Overrun`], where
/// it is missing. The answers to frames and the news that the controller left the bus or takes part again are never lost.
///
/// Every frame has an owner of any type `T`, and every injected frame comes back to its owner exactly once, as
/// [`ExternalEvent::Done`]: when it was sent, or when the link goes down or bus-off, which loses all that wait. Add the
/// node with [`NodeConfig::own_power`](crate::NodeConfig::own_power), so that this holds without power too.
///
/// ```
/// # use link_core::{BitRate, Frame, Instant, TxOutcome, frame::standard_id};
/// # use transport_mock::nodes::{External, ExternalEvent, Listener};
/// # use transport_mock::{BusConfig, Ignore, Network, NodeConfig};
/// let mut network = Network::<()>::new(BusConfig::new(BitRate::K125, 1));
/// let config = NodeConfig { own_power: true, ..NodeConfig::named("outside") };
/// let outside = network.add_silent(config, External::<char>::new());
/// network.add_silent(NodeConfig::named("other"), Listener::new(1));
/// network.run_until(Instant::from_millis(1), &mut Ignore);
///
/// let frame = Frame::new(standard_id(0x123), &[1, 2, 3]).unwrap();
/// network.command(outside, |outside: &mut External<char>, now| outside.inject(now, 'a', frame).unwrap());
/// network.run_until(Instant::from_millis(2), &mut Ignore);
/// let take = |outside: &mut External<char>, _| std::iter::from_fn(|| outside.take()).last();
/// let last = network.command(outside, take).flatten();
/// let done = ExternalEvent::Done { owner: 'a', frame, outcome: TxOutcome::Sent };
/// assert!(last.is_some_and(|(_, event)| event == done));
/// ```
#[derive(Clone, Debug)]
pub struct External<T = ()> {
    outgoing: VecDeque<(T, Frame)>,
    in_flight: Option<(T, Frame)>,
    incoming: VecDeque<(Instant, ExternalEvent<T>)>,
    /// How many answers to frames are in `incoming`.
    answers: usize,
    capacity: usize,
    up: bool,
    restart_after: Option<Duration>,
    timers: Timers<Restart, 1>,
}

/// As many frames as an [`External`] node takes wait to be sent, or their answers to be taken.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
#[error("no more frames can wait to be sent; take what became of the others first")]
pub struct TooManyFrames;

/// What happened at an [`External`] node.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ExternalEvent<T = ()> {
    /// A frame of another node was received.
    Received(Frame),
    /// This is what became of an injected frame.
    Done {
        /// Who injected it.
        owner: T,
        /// What was injected.
        frame: Frame,
        /// Whether it was sent.
        outcome: TxOutcome,
    },
    /// Something happened below the frame.
    Link(LinkEvent),
}

impl<T> Default for External<T> {
    fn default() -> Self {
        Self {
            outgoing: VecDeque::new(),
            in_flight: None,
            incoming: VecDeque::new(),
            answers: 0,
            capacity: Self::CAPACITY,
            up: false,
            restart_after: None,
            timers: Timers::new(),
        }
    }
}

impl<T> External<T> {
    /// Frames without an answer, and things that happened, that a node keeps unless it is told otherwise.
    pub const CAPACITY: usize = 1024;

    /// A node that stays away after bus-off.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// A node that resets its controller so long after bus-off, as a SocketCAN interface with `restart-ms` does.
    #[must_use]
    pub fn with_restart(self, after: Duration) -> Self {
        Self { restart_after: Some(after), ..self }
    }

    /// A node that keeps so many frames without an answer, and things that happened.
    #[must_use]
    pub fn with_capacity(self, capacity: usize) -> Self {
        Self { capacity, ..self }
    }

    /// Sends a frame. Frames that are injected one after the other go in that order; the bus sees one at a time. While
    /// the node takes no part in the bus, the frame comes back as [`TxOutcome::Dropped`] at once.
    ///
    /// # Errors
    /// [`TooManyFrames`] when there is no room for it; it is not sent.
    pub fn inject(&mut self, now: Instant, owner: T, frame: Frame) -> Result<(), TooManyFrames> {
        self.timers.advance(now);
        let unanswered = self.outgoing.len() + usize::from(self.in_flight.is_some());
        if unanswered + self.answers >= self.capacity {
            return Err(TooManyFrames);
        }
        if self.up {
            self.outgoing.push_back((owner, frame));
        } else {
            self.tell_done(owner, frame, TxOutcome::Dropped);
        }
        Ok(())
    }

    /// The next thing that happened, and when.
    pub fn take(&mut self) -> Option<(Instant, ExternalEvent<T>)> {
        let next = self.incoming.pop_front()?;
        if matches!(next.1, ExternalEvent::Done { .. }) {
            self.answers -= 1;
        }
        Some(next)
    }

    /// Whether the controller takes part in the bus.
    #[must_use]
    pub const fn is_up(&self) -> bool {
        self.up
    }

    /// Keeps what happened, or counts what there is no room for.
    fn tell(&mut self, event: ExternalEvent<T>) {
        let lost = match event {
            ExternalEvent::Done { .. }
            | ExternalEvent::Link(LinkEvent::Up | LinkEvent::Down | LinkEvent::BusOff) => 0,
            ExternalEvent::Link(LinkEvent::Overrun { lost }) => lost.max(1),
            ExternalEvent::Received(_) | ExternalEvent::Link(_) => 1,
        };
        let now = self.timers.now();
        if lost == 0 || self.incoming.len() - self.answers < self.capacity {
            self.incoming.push_back((now, event));
        } else if let Some((_, ExternalEvent::Link(LinkEvent::Overrun { lost: before }))) =
            self.incoming.back_mut()
        {
            *before = before.saturating_add(lost);
        } else {
            self.incoming.push_back((now, ExternalEvent::Link(LinkEvent::Overrun { lost })));
        }
    }

    fn tell_done(&mut self, owner: T, frame: Frame, outcome: TxOutcome) {
        self.answers += 1;
        self.tell(ExternalEvent::Done { owner, frame, outcome });
    }

    /// What waits is lost. What is in flight is answered from below.
    fn leave(&mut self) {
        self.up = false;
        self.timers.clear_all();
        for (owner, frame) in std::mem::take(&mut self.outgoing) {
            self.tell_done(owner, frame, TxOutcome::Dropped);
        }
    }
}

impl<T: Clone> Machine for External<T> {
    type Event = Infallible;

    fn input(&mut self, now: Instant, input: Input) {
        self.timers.advance(now);
        match input {
            Input::Frame(frame) => self.tell(ExternalEvent::Received(frame)),
            Input::TxDone(_, outcome) => {
                if let Some((owner, frame)) = self.in_flight.take() {
                    self.tell_done(owner, frame, outcome);
                }
            }
            Input::Link(event) => {
                self.tell(ExternalEvent::Link(event));
                match event {
                    LinkEvent::Up => self.up = true,
                    LinkEvent::Down => self.leave(),
                    LinkEvent::BusOff => {
                        self.leave();
                        if let Some(after) = self.restart_after {
                            self.timers.set_after(Restart, after);
                        }
                    }
                    LinkEvent::ErrorWarning
                    | LinkEvent::ErrorPassive
                    | LinkEvent::ErrorActive
                    | LinkEvent::BusError(_)
                    | LinkEvent::Counters { .. }
                    | LinkEvent::Overrun { .. }
                    | LinkEvent::ModeSet(_)
                    | LinkEvent::FilterSet
                    | LinkEvent::Refused(_) => {}
                }
            }
            Input::Tick => {}
        }
    }

    fn poll(&mut self, now: Instant) -> Option<Action<Infallible>> {
        if self.timers.take_expired(now).is_some() {
            return Some(Action::Link(LinkCommand::Reset));
        }
        if self.in_flight.is_some() || !self.up {
            return None;
        }
        let (owner, frame) = self.outgoing.pop_front()?;
        self.in_flight = Some((owner, frame));
        Some(Action::Transmit(TOKEN, frame))
    }

    fn deadline(&self) -> Option<Deadline> {
        if self.up && self.in_flight.is_none() && !self.outgoing.is_empty() {
            return Some(Deadline::now(self.timers.now()));
        }
        self.timers.next()
    }

    fn max_in_flight(&self) -> usize {
        1
    }
}

/// The controller is reset.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
struct Restart;

impl TimerKey<1> for Restart {
    const ALL: [Self; 1] = [Self];
    const WHY: [&'static str; 1] = ["restart after bus-off"];

    fn index(self) -> usize {
        0
    }
}
