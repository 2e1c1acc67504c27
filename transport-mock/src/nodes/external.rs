//! A node whose frames come from outside: a live interface, a user interface, a test.

use std::collections::VecDeque;
use std::convert::Infallible;

use link_core::{Action, Deadline, Frame, Input, Instant, LinkEvent, Machine, TxOutcome};

use super::TOKEN;

/// Two mailboxes. The driver puts frames into one by [`inject`](Self::inject), within a
/// [`command`](crate::Network::command), and takes what happened out of the other.
///
/// Neither grows without bound. A frame that was injected has its place until the driver has taken the answer to it;
/// when [`CAPACITY`](Self::CAPACITY) have, the next is refused. Of what happened on the bus as many are kept, and what
/// comes then is counted and told as [`LinkEvent::Overrun`], where it is missing. The answers to frames and the news
/// that the controller left the bus or takes part again are never lost.
///
/// ```
/// # use link_core::{BitRate, Frame, Instant, frame::standard_id};
/// # use transport_mock::{BusConfig, Ignore, Network, NodeConfig, nodes::{External, Listener}};
/// let mut network = Network::<()>::new(BusConfig::new(BitRate::K125, 1));
/// let outside = network.add_silent(NodeConfig::named("outside"), External::default());
/// network.add_silent(NodeConfig::named("other"), Listener::new(1));
/// network.run_until(Instant::from_millis(1), &mut Ignore);
///
/// let frame = Frame::new(standard_id(0x123), &[1, 2, 3]).unwrap();
/// network.command(outside, |outside: &mut External, _| outside.inject(frame).unwrap());
/// network.run_until(Instant::from_millis(2), &mut Ignore);
/// let sent = network.command(outside, |outside: &mut External, _| outside.take()).flatten();
/// assert!(sent.is_some());
/// ```
#[derive(Clone, Debug, Default)]
pub struct External {
    outgoing: VecDeque<Frame>,
    in_flight: Option<Frame>,
    incoming: VecDeque<(Instant, ExternalEvent)>,
    /// How many answers to frames are in `incoming`.
    answers: usize,
    up: bool,
    now: Instant,
}

/// As many frames as an [`External`] node takes wait to be sent, or their answers to be taken.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
#[error("{} frames wait to be sent; take what became of them first", External::CAPACITY)]
pub struct TooManyFrames;

/// What happened at an [`External`] node.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ExternalEvent {
    /// A frame of another node was received.
    Received(Frame),
    /// This is what became of an injected frame.
    Done(Frame, TxOutcome),
    /// Something happened below the frame.
    Link(LinkEvent),
}

impl External {
    /// Frames without an answer, and things that happened, that a node keeps.
    pub const CAPACITY: usize = 1024;

    /// Sends a frame. Frames that are injected one after the other go in that order; the bus sees one at a time.
    pub fn inject(&mut self, frame: Frame) -> Result<(), TooManyFrames> {
        let unanswered = self.outgoing.len() + usize::from(self.in_flight.is_some());
        if unanswered + self.answers >= Self::CAPACITY {
            return Err(TooManyFrames);
        }
        self.outgoing.push_back(frame);
        Ok(())
    }

    /// The next thing that happened, and when.
    pub fn take(&mut self) -> Option<(Instant, ExternalEvent)> {
        let next = self.incoming.pop_front()?;
        if matches!(next.1, ExternalEvent::Done(..)) {
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
    fn keep(&mut self, now: Instant, event: ExternalEvent) {
        let lost = match event {
            ExternalEvent::Done(..) => {
                self.answers += 1;
                0
            }
            ExternalEvent::Link(LinkEvent::Up | LinkEvent::Down | LinkEvent::BusOff) => 0,
            ExternalEvent::Link(LinkEvent::Overrun { lost }) => lost.max(1),
            ExternalEvent::Received(_) | ExternalEvent::Link(_) => 1,
        };
        if lost == 0 || self.incoming.len() - self.answers < Self::CAPACITY {
            return self.incoming.push_back((now, event));
        }
        if let Some((_, ExternalEvent::Link(LinkEvent::Overrun { lost: before }))) = self.incoming.back_mut()
        {
            *before = before.saturating_add(lost);
        } else {
            self.incoming.push_back((now, ExternalEvent::Link(LinkEvent::Overrun { lost })));
        }
    }
}

impl Machine for External {
    type Event = Infallible;

    fn input(&mut self, now: Instant, input: Input) {
        self.now = self.now.max(now);
        let event = match input {
            Input::Frame(frame) => ExternalEvent::Received(frame),
            Input::TxDone(_, outcome) => {
                let Some(frame) = self.in_flight.take() else { return };
                ExternalEvent::Done(frame, outcome)
            }
            Input::Link(event) => {
                match event {
                    LinkEvent::Up => self.up = true,
                    LinkEvent::Down | LinkEvent::BusOff => self.up = false,
                    _ => {}
                }
                ExternalEvent::Link(event)
            }
            Input::Tick => return,
        };
        self.keep(now, event);
    }

    fn poll(&mut self, _: Instant) -> Option<Action<Infallible>> {
        if self.in_flight.is_some() || !self.up {
            return None;
        }
        self.in_flight = Some(self.outgoing.pop_front()?);
        Some(Action::Transmit(TOKEN, self.in_flight?))
    }

    fn deadline(&self) -> Option<Deadline> {
        let pending = self.up && self.in_flight.is_none() && !self.outgoing.is_empty();
        pending.then(|| Deadline::now(self.now))
    }

    fn max_in_flight(&self) -> usize {
        1
    }
}
