//! Automatic bit rate detection: listening, before anything is sent.
//!
//! The controller only listens (it neither acknowledges nor flags errors) at 125, 250 and 500 kbit/s in turn, one second
//! each, and less where an error tells that the rate is wrong. The first frame that is received without an error tells
//! the rate; then network access begins. If every node detects, none sends: one node, normally the master, must not.

use link_core::timers::TimerSet;
use link_core::{Input, Instant, LinkEvent, link::LinkCommandKind};

use super::application::Application;
use super::bit_rate;
use super::event::SlaveEvent;
use super::machine::{Errand, Slave};
use super::timer::Timer;

/// How far it is.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Detection {
    /// Not wanted, or done.
    Done,
    /// Waiting for the link to come up.
    Waiting,
    /// Waiting until the controller listens.
    Tuning,
    /// Listening.
    Listening,
    /// A rate was found; waiting until the controller takes part.
    Joining,
}

impl Detection {
    pub(super) const fn new(wanted: bool) -> Self {
        if wanted { Self::Waiting } else { Self::Done }
    }

    pub(super) const fn is_running(self) -> bool {
        !matches!(self, Self::Done)
    }

    /// The mode that the controller shall have.
    pub(super) const fn listens(self) -> bool {
        matches!(self, Self::Tuning | Self::Listening)
    }
}

impl<A: Application, const MESSAGE: usize, const DYNAMIC: usize> Slave<A, MESSAGE, DYNAMIC> {
    /// An input while the bit rate is being detected.
    #[inline(never)]
    pub(super) fn detect(&mut self, now: Instant, input: &Input) {
        self.look_for_errands();
        // A frame at the end of the second counts before it.
        match (self.detection, *input) {
            (Detection::Waiting, Input::Link(LinkEvent::Up)) => self.tune(),
            (Detection::Tuning, Input::Link(LinkEvent::ModeSet(mode))) if mode.listen_only => {
                self.detection = Detection::Listening;
                self.node.timers.set_after_millis(Timer::Heartbeat, LISTEN_MILLIS);
            }
            (Detection::Listening, Input::Frame(_)) => {
                self.node.timers.clear(Timer::Heartbeat);
                self.detection = Detection::Joining;
                self.errand = Errand::Mode;
                self.node.events.raise::<A>(SlaveEvent::BitRateDetected(self.node.port.active));
            }
            (Detection::Listening, Input::Link(LinkEvent::BusError(_))) => self.next_rate(),
            (Detection::Joining, Input::Link(LinkEvent::ModeSet(mode))) if !mode.listen_only => {
                self.end_detection(now);
            }
            // A port that cannot change its mode has the rate that it has.
            (_, Input::Link(LinkEvent::Refused(LinkCommandKind::SetMode))) => self.end_detection(now),
            (_, Input::Link(LinkEvent::Down)) => {
                self.node.timers.clear(Timer::Heartbeat);
                self.errand = Errand::Perhaps;
                self.detection = Detection::Waiting;
            }
            _ => {}
        }
        if self.detection == Detection::Listening
            && self.node.timers.at(Timer::Heartbeat).is_some_and(|at| at <= now)
        {
            self.next_rate();
        }
        if let Input::Link(event) = *input {
            self.note(event);
        }
    }

    fn next_rate(&mut self) {
        self.node.port.active = bit_rate::next(self.node.port.active);
        self.tune();
    }

    fn tune(&mut self) {
        self.node.timers.clear(Timer::Heartbeat);
        self.detection = Detection::Tuning;
        self.errand = Errand::Mode;
    }

    fn end_detection(&mut self, now: Instant) {
        self.node.timers.clear(Timer::Heartbeat);
        self.errand = Errand::Perhaps;
        self.detection = Detection::Done;
        self.node.port.stored = self.node.port.active;
        self.tell_access(now, &Input::Link(LinkEvent::Up));
    }
}

/// How long the controller listens at one bit rate.
const LISTEN_MILLIS: u32 = 1000;
