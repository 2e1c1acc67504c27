//! Talks too much.

use std::convert::Infallible;
use std::time::Duration;

use link_core::{Action, Deadline, Frame, Input, Instant, LinkCommand, LinkEvent, Machine, Timers};

use super::{NextFrame, TOKEN};

/// Sends one frame again and again, whatever happens; after bus-off it resets its controller and goes on. For a node
/// that holds the bus dominant, use [`Fault::Babble`](crate::Fault::Babble).
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Babbler {
    frame: Frame,
    interval: Duration,
    in_flight: bool,
    reset: bool,
    timers: Timers<NextFrame, 1>,
}

impl Babbler {
    /// Sends `frame`, and again `interval` after it was sent; zero is back to back.
    #[must_use]
    pub const fn new(frame: Frame, interval: Duration) -> Self {
        Self { frame, interval, in_flight: false, reset: false, timers: Timers::new() }
    }
}

impl Machine for Babbler {
    type Event = Infallible;

    fn input(&mut self, now: Instant, input: Input) {
        let now = self.timers.advance(now);
        match input {
            Input::Link(LinkEvent::Up) => self.timers.set(NextFrame, now),
            Input::Link(LinkEvent::BusOff) => {
                self.reset = true;
                self.timers.clear_all();
            }
            Input::Link(LinkEvent::Down) => self.timers.clear_all(),
            Input::TxDone(_, outcome) => {
                self.in_flight = false;
                if outcome == link_core::TxOutcome::Sent {
                    self.timers.set_after(NextFrame, self.interval);
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
