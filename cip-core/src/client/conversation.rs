//! One transaction after another with one server.

use heapless::Vec;
use link_core::{Frame, TxOutcome};

use super::channel::{Channel, Part};
use super::outcome::{Failure, StartError, TimerChange, Waits};
use crate::codec::{Wire, Writer};
use crate::fragment::{AckStatus, ExplicitReassembly, Fragment};
use crate::message::{AttributeRequest, BodyFormat, EmitError, Request};

/// The client's side of one [`Channel`] to a server; see the [module](super) text.
///
/// `N` is the longest body, from the service byte on, of a request and of a response.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Conversation<C: Channel, const N: usize> {
    pub(super) route: C,
    pub(super) waits: Waits,
    /// Of the present transaction, or of the last.
    pub(super) transaction: C::Transaction,
    pub(super) request: Vec<u8, N>,
    pub(super) tries: u8,
    pub(super) response: ExplicitReassembly<N>,
    pub(super) stage: Stage,
    /// As it is to be sent: the next transaction may begin, on another route, before it is.
    pub(super) acknowledge: Option<Acknowledge<C>>,
    in_flight: Option<Outgoing>,
    pub(super) timer: TimerChange,
}

/// The acknowledge of a fragment of the response.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Acknowledge<C: Channel> {
    pub(super) route: C,
    pub(super) transaction: C::Transaction,
    pub(super) count: u8,
    pub(super) status: AckStatus,
}

impl<C: Channel> Acknowledge<C> {
    fn frame(&self) -> Option<Frame> {
        let Self { count, status, .. } = *self;
        self.route.frame(self.transaction, Part::Acknowledge { count, status })
    }
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Stage {
    Idle,
    Requesting {
        attempt: u8,
        fragment: usize,
        repeated: bool,
        progress: Sending,
    },
    Awaiting {
        attempt: u8,
    },
    /// `most`: the most bytes of the response that were there at once.
    Receiving {
        attempt: u8,
        most: usize,
    },
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Sending {
    Due,
    HandedOut,
    OnTheBus,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
enum Outgoing {
    Acknowledge,
    Request,
    /// What was cancelled.
    Nothing,
}

impl<C: Channel, const N: usize> Conversation<C, N> {
    /// A conversation in which nothing was said yet.
    #[must_use]
    pub const fn new(route: C, waits: Waits) -> Self {
        Self {
            route,
            waits,
            transaction: C::BEFORE_FIRST,
            request: Vec::new(),
            tries: 0,
            response: ExplicitReassembly::new(N),
            stage: Stage::Idle,
            acknowledge: None,
            in_flight: None,
            timer: TimerChange::Keep,
        }
    }

    /// Where it takes place.
    #[must_use]
    pub const fn route(&self) -> &C {
        &self.route
    }

    /// True from the start of a transaction to its response or failure.
    #[must_use]
    pub const fn is_busy(&self) -> bool {
        !matches!(self.stage, Stage::Idle)
    }

    /// True while a frame waits for its [`tx_done`](Self::tx_done).
    #[must_use]
    pub const fn is_in_flight(&self) -> bool {
        self.in_flight.is_some()
    }

    /// True while a frame waits for its [`tx_done`](Self::tx_done) that belongs to a cancelled transaction.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.in_flight == Some(Outgoing::Nothing)
    }

    /// Whether [`poll`](Self::poll) has a frame.
    #[must_use]
    pub const fn has_output(&self) -> bool {
        self.in_flight.is_none()
            && (self.acknowledge.is_some()
                || matches!(self.stage, Stage::Requesting { progress: Sending::Due, .. }))
    }

    /// Goes on over another route, for example over the connection that the UCMM opened. The transaction ID goes on as
    /// well, so that a late response of the old route is not taken for one of the new.
    ///
    /// A transaction under way is [cancelled](Self::cancel); the acknowledge of a response that is complete is still
    /// sent, on the old route.
    pub fn reroute(&mut self, route: C, waits: Waits) {
        if self.is_busy() {
            self.cancel();
        } else {
            self.response.discard();
            self.timer = TimerChange::Clear;
        }
        self.route = route;
        self.waits = waits;
    }

    /// Starts a transaction, which is tried `tries` times; more than once only for services that may be carried out
    /// twice.
    pub fn start(&mut self, request: &Request<'_>, tries: u8) -> Result<(), StartError> {
        self.start_with(|format, out| request.emit(format, out), tries)
    }

    /// Starts a transaction that reads or writes one attribute.
    pub fn start_attribute(&mut self, request: &AttributeRequest<'_>, tries: u8) -> Result<(), StartError> {
        self.start_with(|format, out| request.emit(format, out), tries)
    }

    fn start_with(
        &mut self,
        emit: impl FnOnce(BodyFormat, &mut Writer<'_>) -> Result<(), EmitError>,
        tries: u8,
    ) -> Result<(), StartError> {
        self.ready()?;
        let mut buffer = [0; N];
        let mut out = Writer::new(&mut buffer);
        emit(self.route.format(), &mut out).map_err(|error| match error {
            EmitError::Full(_) => StartError::TooLong { capacity: N },
            EmitError::NotAddressable(_) | EmitError::Service(_) => StartError::NotAddressable(error),
        })?;
        self.start_body(out.written(), tries)
    }

    /// Starts a transaction whose body is a message of the network.
    pub fn start_message<'a>(&mut self, message: &impl Wire<'a>, tries: u8) -> Result<(), StartError> {
        self.start_with(|_, out| Ok(message.emit(out)?), tries)
    }

    /// Starts a transaction whose body, from the service byte on, is given as bytes.
    pub fn start_body(&mut self, body: &[u8], tries: u8) -> Result<(), StartError> {
        self.ready()?;
        if body.is_empty() {
            return Err(StartError::Empty);
        }
        self.request = Vec::from_slice(body).map_err(|_| StartError::TooLong { capacity: N })?;
        self.transaction = C::after(self.transaction);
        self.tries = tries;
        self.response.discard();
        self.request_from_the_start(1);
        Ok(())
    }

    /// Ends the transaction without a result. What is in flight stays so until its [`tx_done`](Self::tx_done): the
    /// owner may withdraw it.
    pub fn cancel(&mut self) {
        self.stage = Stage::Idle;
        self.response.discard();
        self.acknowledge = None;
        if self.in_flight.is_some() {
            self.in_flight = Some(Outgoing::Nothing);
        }
        self.timer = TimerChange::Clear;
    }

    /// What is to be done with the timer since the last call.
    #[must_use]
    pub fn take_timer(&mut self) -> TimerChange {
        core::mem::take(&mut self.timer)
    }

    /// The next frame. It is in flight until [`tx_done`](Self::tx_done).
    pub fn poll(&mut self) -> Option<Frame> {
        if self.in_flight.is_some() {
            return None;
        }
        if let Some(acknowledge) = self.acknowledge.take() {
            self.in_flight = Some(Outgoing::Acknowledge);
            return acknowledge.frame();
        }
        let Stage::Requesting { fragment, progress: progress @ Sending::Due, .. } = &mut self.stage else {
            return None;
        };
        *progress = Sending::HandedOut;
        let fragment = *fragment;
        self.in_flight = Some(Outgoing::Request);
        self.request_frame(fragment)
    }

    /// What became of the frame that was handed out last.
    ///
    /// A frame that was given back unsent is treated as one that was lost: it is repeated when the wait for its answer
    /// is over.
    pub fn tx_done(&mut self, _outcome: TxOutcome) {
        if self.in_flight.take() != Some(Outgoing::Request) {
            return;
        }
        let fragmented = self.is_fragmented();
        if let Stage::Requesting { attempt, progress: progress @ Sending::HandedOut, .. } = &mut self.stage {
            if fragmented {
                *progress = Sending::OnTheBus;
                self.timer = TimerChange::Set(self.waits.acknowledge);
            } else {
                self.stage = Stage::Awaiting { attempt: *attempt };
                self.timer = TimerChange::Set(self.waits.response);
            }
        }
    }

    /// The frame that was handed out last was taken back by the owner, who will want it again: [`poll`](Self::poll) has it
    /// once more, and it counts as one attempt.
    pub fn taken_back(&mut self) {
        if self.in_flight.take() != Some(Outgoing::Request) {
            return;
        }
        if let Stage::Requesting { progress: progress @ Sending::HandedOut, .. } = &mut self.stage {
            *progress = Sending::Due;
        }
    }

    /// The timer that the owner keeps is over. Returns why the transaction has failed, if it has.
    pub fn timer_expired(&mut self) -> Option<Failure> {
        match &mut self.stage {
            Stage::Idle => {
                self.response.forget_completed();
                None
            }
            Stage::Requesting { repeated: true, progress: Sending::OnTheBus, .. } => {
                Some(self.fail(Failure::NotAcknowledged))
            }
            Stage::Requesting { repeated, progress: progress @ Sending::OnTheBus, .. } => {
                *repeated = true;
                *progress = Sending::Due;
                None
            }
            // No wait runs before the frame is on the bus.
            Stage::Requesting { .. } => None,
            Stage::Awaiting { attempt } | Stage::Receiving { attempt, .. } => {
                let attempt = *attempt;
                if attempt >= self.tries {
                    return Some(self.fail(Failure::NoResponse));
                }
                self.response.discard();
                self.request_from_the_start(attempt.saturating_add(1));
                None
            }
        }
    }

    fn ready(&self) -> Result<(), StartError> {
        if self.is_busy() { Err(StartError::Busy) } else { Ok(()) }
    }

    fn request_from_the_start(&mut self, attempt: u8) {
        self.stage = Stage::Requesting { attempt, fragment: 0, repeated: false, progress: Sending::Due };
        self.timer = TimerChange::Clear;
    }

    fn request_frame(&self, fragment: usize) -> Option<Frame> {
        let part = if self.is_fragmented() {
            Part::Fragment(self.cut(fragment)?)
        } else {
            Part::Complete(&self.request)
        };
        self.route.frame(self.transaction, part)
    }

    /// Whether the request is sent in fragments.
    pub(super) fn is_fragmented(&self) -> bool {
        C::is_fragmented(&self.request)
    }

    /// A fragment of the request, counted from 0.
    pub(super) fn cut(&self, fragment: usize) -> Option<Fragment<'_>> {
        C::cut(&self.request, fragment)
    }

    pub(super) fn fail(&mut self, failure: Failure) -> Failure {
        self.stage = Stage::Idle;
        self.response.discard();
        self.timer = TimerChange::Clear;
        failure
    }
}
