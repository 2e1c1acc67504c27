//! Sends what was recorded elsewhere.

use std::convert::Infallible;
use std::time::Duration;

use link_core::{Action, Deadline, Frame, Input, Instant, LinkEvent, Machine, Timers};

use super::{NextFrame, TOKEN};

/// Sends recorded frames with the gaps of the recording.
///
/// A frame is requested at its time, or when the one before it was sent if that is later. The recording goes on while
/// the link is down or bus-off: frames whose time comes then are left out, and those that were dropped are not repeated.
#[derive(Clone, Debug)]
pub struct Replay<I> {
    frames: I,
    next: Option<(Instant, Frame)>,
    /// The moment of the recording that is power-up here.
    origin: Option<Instant>,
    /// Power-up.
    started: Option<Duration>,
    up: bool,
    in_flight: bool,
    timers: Timers<NextFrame, 1>,
}

impl<I: Iterator<Item = (Instant, Frame)>> Replay<I> {
    /// Sends `frames`, the first of them at power-up. Their times count from any zero and do not decrease.
    pub fn new(frames: impl IntoIterator<IntoIter = I>) -> Self {
        let mut frames = frames.into_iter();
        let next = frames.next();
        Self {
            frames,
            next,
            origin: next.map(|(at, _)| at),
            started: None,
            up: false,
            in_flight: false,
            timers: Timers::new(),
        }
    }

    /// Sends `frames` so that power-up is `origin` in their time: several nodes that send parts of one recording keep in
    /// step.
    pub fn since(origin: Instant, frames: impl IntoIterator<IntoIter = I>) -> Self {
        Self { origin: Some(origin), ..Self::new(frames) }
    }

    /// Whether all frames were sent.
    pub fn is_done(&self) -> bool {
        self.next.is_none() && !self.in_flight
    }

    fn plan(&mut self) {
        let (Some((at, _)), Some(origin), Some(started)) = (self.next, self.origin, self.started) else {
            return;
        };
        if !self.in_flight {
            self.timers.set(NextFrame, Instant::ZERO + started + at.saturating_since(origin));
        }
    }
}

impl<I: Iterator<Item = (Instant, Frame)>> Machine for Replay<I> {
    type Event = Infallible;

    fn input(&mut self, now: Instant, input: Input) {
        let now = self.timers.advance(now);
        match input {
            Input::Link(LinkEvent::Down | LinkEvent::BusOff) => self.up = false,
            Input::Link(LinkEvent::Up) => {
                self.up = true;
                self.started.get_or_insert(now.saturating_since(Instant::ZERO));
                self.plan();
            }
            Input::TxDone(..) => {
                self.in_flight = false;
                self.plan();
            }
            Input::Link(_) | Input::Frame(_) | Input::Tick => {}
        }
    }

    fn poll(&mut self, now: Instant) -> Option<Action<Infallible>> {
        loop {
            self.timers.take_expired(now)?;
            let (_, frame) = self.next?;
            self.next = self.frames.next();
            if self.up {
                self.in_flight = true;
                return Some(Action::Transmit(TOKEN, frame));
            }
            self.plan();
        }
    }

    fn deadline(&self) -> Option<Deadline> {
        self.timers.next()
    }

    fn max_in_flight(&self) -> usize {
        1
    }
}
