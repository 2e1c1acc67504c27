//! Talks too much.

use std::convert::Infallible;
use std::time::Duration;

use link_core::{
    Action, Deadline, Frame, Input, Instant, LinkCommand, LinkEvent, Machine, Timers, TxOutcome,
};

use super::{NextFrame, TOKEN};

/// Sends one frame again and again, whatever happens; after bus-off it resets its controller and goes on. For a node
/// that holds the bus dominant, use [`Fault::Babble`](crate::Fault::Babble).
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Babbler {
    frame: Frame,
    interval: Duration,
    up: bool,
    in_flight: bool,
    reset: bool,
    timers: Timers<NextFrame, 1>,
}

impl Babbler {
    /// Sends `frame` every `interval`, from the request of one to the request of the next, so that they begin at that
    /// distance where the bus is free. What the bus delays beyond it goes as soon as it can, and the next is counted
    /// from there; zero is back to back.
    #[must_use]
    pub const fn new(frame: Frame, interval: Duration) -> Self {
        Self { frame, interval, up: false, in_flight: false, reset: false, timers: Timers::new() }
    }
}

impl Machine for Babbler {
    type Event = Infallible;

    fn input(&mut self, now: Instant, input: Input) {
        let now = self.timers.advance(now);
        match input {
            Input::Link(LinkEvent::Up) => {
                self.up = true;
                self.timers.set(NextFrame, now);
            }
            Input::Link(event @ (LinkEvent::BusOff | LinkEvent::Down)) => {
                self.up = false;
                self.reset = event == LinkEvent::BusOff;
                self.timers.clear_all();
            }
            Input::TxDone(_, outcome) => {
                self.in_flight = false;
                match outcome {
                    // The next is planned already.
                    TxOutcome::Sent => {}
                    // Another mode. If that is listen-only, it is dropped again at once.
                    TxOutcome::Dropped | TxOutcome::Withdrawn | TxOutcome::Unknown if self.up => {
                        self.timers.set_after(NextFrame, self.interval.max(AFTER_DROP));
                    }
                    TxOutcome::Dropped | TxOutcome::Withdrawn | TxOutcome::Unknown => {}
                }
            }
            Input::Link(_) | Input::Frame(_) | Input::Tick => {}
        }
    }

    fn poll(&mut self, now: Instant) -> Option<Action<Infallible>> {
        if std::mem::take(&mut self.reset) {
            return Some(Action::Link(LinkCommand::Reset));
        }
        if self.in_flight {
            return None;
        }
        self.timers.take_expired(now)?;
        self.timers.set_after(NextFrame, self.interval);
        self.in_flight = true;
        Some(Action::Transmit(TOKEN, self.frame))
    }

    fn deadline(&self) -> Option<Deadline> {
        if self.reset {
            return Some(Deadline::now(self.timers.now()));
        }
        self.timers.next().filter(|_| !self.in_flight)
    }

    fn max_in_flight(&self) -> usize {
        1
    }
}

const AFTER_DROP: Duration = Duration::from_millis(1);
