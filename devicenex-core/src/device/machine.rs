//! The machine: what it is made of, and where each input goes.

use cip_core::connection::TimerResolution;
use cip_core::message::BodyFormat;
use cip_core::object::{AcknowledgeSettings, FailureOptions};
use cip_core::transfer::Rules;
use link_core::{Action, Deadline, Frame, Input, Instant, Machine, Queue, TxOutcome, TxToken};

use super::application::Application;
use super::connectionless::Port;
use super::departure::Departure;
use super::event::{Counters, DeviceEvent, Ignored};
use super::line::{self, Done, Line, Sent};
use super::slot::{Body, Slot};
use super::timer::Timer;
use crate::access::Access;
use crate::counter::{count, count_wide};
use crate::id::{Direction, Identifier, Layout, OperationalAddress, Route};

/// A device; see the [module](super) text.
///
/// `MESSAGE` is the longest explicit message, from the service byte on; `CONNECTIONS` is how many connections of any kind it
/// can have at once.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Device<A: Application, const MESSAGE: usize, const CONNECTIONS: usize> {
    pub(super) application: A,
    pub(super) access: Access,
    pub(super) slots: [Slot<A::Long, MESSAGE>; CONNECTIONS],
    pub(super) port: Port<MESSAGE>,
    /// Responses in one frame, of connection and connectionless requests.
    pub(super) answers: Queue<Frame, ANSWERS>,
    /// The one that is in flight.
    pub(super) answering: (Line, Option<Identifier>),
    pub(super) settings: Settings,
    pub(super) acknowledge: AcknowledgeSettings,
    pub(super) departure: Option<Departure>,
    pub(super) online: bool,
    /// What the node needs to hear has changed.
    pub(super) filter_changed: bool,
    pub(super) counters: Counters,
    pub(super) events: Queue<DeviceEvent, EVENTS>,
}

/// What was configured and never changes.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) struct Settings {
    pub(super) resolution: TimerResolution,
    pub(super) body_format: BodyFormat,
    pub(super) failures: FailureOptions,
    pub(super) rules: Rules,
    pub(super) configuring_time_out: u16,
    pub(super) acknowledged: bool,
    /// After a reset.
    pub(super) acknowledge: AcknowledgeSettings,
}

impl<A: Application, const MESSAGE: usize, const CONNECTIONS: usize> Device<A, MESSAGE, CONNECTIONS> {
    /// What [`max_in_flight`](link_core::Machine::max_in_flight) returns, for the size of a port.
    // The connections, network access, answers, the connectionless port.
    pub const MAX_IN_FLIGHT: usize = CONNECTIONS.saturating_add(3);

    pub(super) fn frame(&mut self, now: Instant, frame: &Frame) {
        if !self.online || frame.is_remote() {
            return self.access.input(now, Input::Frame(*frame));
        }
        let (id, field) = (Identifier::of_frame(frame), frame.data());
        match id.layout() {
            Layout::Hello { .. } | Layout::Roam { .. } | Layout::Reserved(_) => {
                self.access.input(now, Input::Frame(*frame));
            }
            Layout::Implicit { source, .. } | Layout::Standard { source, .. } => match self.check(source) {
                Ok(()) => self.implicit_frame(id, field),
                Err(why) => self.ignored(id, why),
            },
            Layout::Connection { route, transaction } => {
                self.obey(id, route, |device| device.connection_request(route, transaction, field));
            }
            Layout::Connectionless { route, framing } => {
                self.obey(id, route, |device| device.connectionless_frame(route, framing, field));
            }
            Layout::Explicit { message, route, framing } => {
                self.obey(id, route, |device| device.explicit_frame(message, route, framing, field));
            }
        }
    }

    /// A message from one node to another. Only requests are a server's business.
    fn obey(&mut self, id: Identifier, route: Route, request: impl FnOnce(&mut Self) -> Result<(), Ignored>) {
        if route.destination != self.access.address() || route.direction != Direction::Request {
            return count_wide(&mut self.counters.foreign);
        }
        if let Err(why) = self.check(route.source).and_then(|()| request(self)) {
            self.ignored(id, why);
        }
    }

    fn check(&self, source: OperationalAddress) -> Result<(), Ignored> {
        if source.is_none() || source == self.access.address() { Err(Ignored::Source) } else { Ok(()) }
    }

    pub(super) fn ignored(&mut self, id: Identifier, why: Ignored) {
        count(&mut self.counters.ignored);
        self.raise(DeviceEvent::Ignored { id, why });
    }

    pub(super) fn raise(&mut self, event: DeviceEvent) {
        if self.events.push(event).is_err() {
            count(&mut self.counters.events_lost);
        }
    }

    /// The present moment, as the device was told it.
    pub(super) fn advance(&mut self, now: Instant) -> Instant {
        self.access.advance(now);
        for slot in &mut self.slots {
            slot.timers.advance(now);
        }
        self.port.timers.advance(now)
    }

    fn tx_done(&mut self, now: Instant, token: TxToken, outcome: TxOutcome) {
        let done = match token {
            Access::TOKEN => return self.access.input(now, Input::TxDone(token, outcome)),
            line::ANSWERS => self.answer_done(outcome),
            line::CONNECTIONLESS => self.port_done(outcome),
            token => self.connection_done(token, outcome),
        };
        if done.is_none() {
            count(&mut self.counters.stray_tx_done);
        }
    }

    fn connection_done(&mut self, token: TxToken, outcome: TxOutcome) -> Option<()> {
        let own = self.access.address();
        let place = line::place_of(token)?;
        let slot = self.slots.get_mut(place)?;
        let Done { what, wanted, given_back } = slot.line.done(outcome)?;
        let id = slot.produced(own);
        match (&mut slot.body, what) {
            (Body::Explicit(explicit), Sent::Response) => explicit.transfer.handed(&mut slot.timers),
            (Body::Io(_), Sent::Implicit) if wanted => self.implicit_done(place, outcome == TxOutcome::Sent),
            (Body::Free | Body::Explicit(_) | Body::Io(_), _) => {}
        }
        if let Some(id) = id.filter(|_| given_back) {
            self.not_sent(id, outcome);
        }
        Some(())
    }

    pub(super) fn not_sent(&mut self, id: Identifier, outcome: TxOutcome) {
        count(&mut self.counters.not_sent);
        self.raise(DeviceEvent::NotSent { id, outcome });
    }

    /// Serves every wait that is over at `until`, the one that ended first before the others.
    fn expire(&mut self, until: Instant) {
        self.access.expire(until);
        while let Some((place, timer)) = self.take_expired(until) {
            match place {
                Some(place) => self.connection_wait_over(place, timer),
                None => self.port_wait_over(timer),
            }
        }
    }

    /// The connection, or the port, whose wait ended first.
    fn take_expired(&mut self, until: Instant) -> Option<(Option<usize>, Timer)> {
        let slots = self.slots.iter().enumerate();
        let ends = slots.filter_map(|(place, slot)| Some((slot.timers.next()?.at, place)));
        let first = ends.min().filter(|&(at, _)| at <= until);
        let port = self.port.timers.next().map(|wait| wait.at).filter(|&at| at <= until);
        match first {
            Some((at, place)) if port.is_none_or(|port| at <= port) => {
                let timer = self.slots.get_mut(place)?.timers.take_expired(until)?;
                Some((Some(place), timer))
            }
            Some(_) | None => Some((None, self.port.timers.take_expired(until)?)),
        }
    }
}

impl<A: Application, const MESSAGE: usize, const CONNECTIONS: usize> Machine
    for Device<A, MESSAGE, CONNECTIONS>
{
    type Event = DeviceEvent;

    fn input(&mut self, now: Instant, input: Input) {
        let now = self.advance(now);
        // A wait that ended before this moment ended before this input; one that ends now ends after it.
        self.expire(now.preceding());
        self.follow(now);
        match input {
            Input::Frame(frame) => self.frame(now, &frame),
            Input::TxDone(token, outcome) => self.tx_done(now, token, outcome),
            Input::Link(_) | Input::Tick => self.access.input(now, input),
        }
        self.follow(now);
        self.expire(now);
        self.follow(now);
    }

    fn poll(&mut self, now: Instant) -> Option<Action<DeviceEvent>> {
        self.advance(now);
        self.output()
    }

    fn deadline(&self) -> Option<Deadline> {
        if self.has_output() {
            return Some(Deadline::now(self.port.timers.now()));
        }
        let first = Deadline::earlier(self.access.next_wait(), self.port.timers.next());
        self.slots.iter().fold(first, |first, slot| Deadline::earlier(first, slot.timers.next()))
    }

    fn max_in_flight(&self) -> usize {
        Self::MAX_IN_FLIGHT
    }
}

/// How many responses in one frame can wait: no request is carried out whose answer would be lost.
pub(super) const ANSWERS: usize = 4;
/// What one input in time can raise, besides what each connection keeps for itself.
const EVENTS: usize = 8;
