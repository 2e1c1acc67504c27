//! One transaction after another with one server.

use core::time::Duration;

use cip_core::code::ServiceCode;
use cip_core::codec::{Wire, Writer};
use cip_core::fragment::{
    AckStatus, ExplicitOutcome, ExplicitReassembly, FragmentKind, explicit_fragment, is_fragmented_explicit,
};
use cip_core::message::{AttributeRequest, BodyFormat, EmitError, Request, Response};
use heapless::Vec;
use link_core::{Frame, TxOutcome};

use super::outcome::{Failure, Ignored, Progress, StartError, TimerChange, Waits};
use super::route::Route;
use crate::id::Identifier;
use crate::message::{self, ExplicitFragment, ExplicitMessage, FragmentAcknowledge};

/// The client's side of one explicit connection, of an unconnected port or of the UCMM; see the [module](super) text.
///
/// `N` is the longest body, from the service byte on, of a request and of a response.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Conversation<const N: usize> {
    route: Route,
    waits: Waits,
    /// Of the present transaction, or of the last.
    xid: bool,
    request: Vec<u8, N>,
    tries: u8,
    response: ExplicitReassembly<N>,
    stage: Stage,
    /// As it is to be sent: the next transaction may begin, on another route, before it is.
    acknowledge: Option<(Identifier, FragmentAcknowledge)>,
    in_flight: Option<Outgoing>,
    timer: TimerChange,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
enum Stage {
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
enum Sending {
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

impl<const N: usize> Conversation<N> {
    /// A conversation in which nothing was said yet.
    #[must_use]
    pub const fn new(route: Route, waits: Waits) -> Self {
        Self {
            route,
            waits,
            // The first transaction has XID 0.
            xid: true,
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
    pub const fn route(&self) -> &Route {
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
    pub fn reroute(&mut self, route: Route, waits: Waits) {
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

    /// Starts a transaction whose body, from the service byte on, is given as bytes.
    pub fn start_body(&mut self, body: &[u8], tries: u8) -> Result<(), StartError> {
        self.ready()?;
        if body.is_empty() {
            return Err(StartError::Empty);
        }
        self.request = Vec::from_slice(body).map_err(|_| StartError::TooLong { capacity: N })?;
        self.xid = !self.xid;
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
        if let Some((id, acknowledge)) = self.acknowledge.take() {
            self.in_flight = Some(Outgoing::Acknowledge);
            return message::frame(id, &acknowledge);
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
        if let Stage::Requesting { attempt, progress: progress @ Sending::HandedOut, .. } = &mut self.stage {
            if is_fragmented_explicit(&self.request) {
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

    /// Takes a frame from the bus.
    pub fn frame<'a>(&'a mut self, frame: &'a Frame) -> Progress<'a> {
        let data = frame.data();
        let Some(&header) = data.first() else { return Progress::NotMine };
        if Identifier::of_frame(frame) != Some(self.route.response())
            || header & HEADER_MAC != self.route.client().number()
        {
            return Progress::NotMine;
        }
        if header & HEADER_FRAGMENTED == 0 {
            return match ExplicitMessage::parse(data) {
                Ok(message) => self.complete(message),
                Err(_) => Progress::Ignored(Ignored::Malformed),
            };
        }
        if let Ok(acknowledge) = FragmentAcknowledge::parse(data) {
            return self.acknowledged(acknowledge);
        }
        match ExplicitFragment::parse(data) {
            Ok(fragment) => self.fragment(fragment),
            Err(_) => Progress::Ignored(Ignored::Malformed),
        }
    }

    fn complete<'a>(&mut self, message: ExplicitMessage<'a>) -> Progress<'a> {
        let Ok(response) = Response::parse(message.body) else {
            return Progress::Ignored(Ignored::Malformed);
        };
        if let Err(ignored) = self.expects(message.xid).and_then(|()| self.answers(&response)) {
            return Progress::Ignored(ignored);
        }
        self.response.discard();
        self.stage = Stage::Idle;
        self.timer = TimerChange::Clear;
        Progress::Response(response)
    }

    fn acknowledged(&mut self, acknowledge: FragmentAcknowledge) -> Progress<'static> {
        let Stage::Requesting { attempt, fragment, repeated, progress } = self.stage else {
            return Progress::Ignored(Ignored::Unexpected);
        };
        if !is_fragmented_explicit(&self.request) || (progress == Sending::Due && !repeated) {
            return Progress::Ignored(Ignored::Unexpected);
        }
        if acknowledge.xid != self.xid {
            return Progress::Ignored(Ignored::Stale);
        }
        let sent = explicit_fragment(&self.request, fragment).map(|sent| sent.byte.count());
        if sent != Some(acknowledge.count()) {
            return Progress::Ignored(Ignored::OtherAcknowledge);
        }
        if acknowledge.status != AckStatus::Success {
            return Progress::Failed(self.fail(Failure::RequestTooLong));
        }
        let next = fragment.saturating_add(1);
        if explicit_fragment(&self.request, next).is_some() {
            self.stage =
                Stage::Requesting { attempt, fragment: next, repeated: false, progress: Sending::Due };
            self.timer = TimerChange::Clear;
        } else {
            self.stage = Stage::Awaiting { attempt };
            self.timer = TimerChange::Set(self.waits.response);
        }
        Progress::Pending
    }

    fn fragment(&mut self, fragment: ExplicitFragment<'_>) -> Progress<'_> {
        let (attempt, most) = match (self.stage, self.expects(fragment.xid)) {
            (Stage::Idle, Err(Ignored::Unexpected))
                if self.response.remembers_completed() && fragment.fragment.kind != FragmentKind::First =>
            {
                (0, 0)
            }
            (_, Err(ignored)) => return Progress::Ignored(ignored),
            (Stage::Idle, Ok(())) => (0, 0),
            (Stage::Requesting { attempt, .. } | Stage::Awaiting { attempt }, Ok(())) => (attempt, 0),
            (Stage::Receiving { attempt, most }, Ok(())) => (attempt, most),
        };
        let asked = self.asked();
        let before = self.response.received();
        let mac = self.route.header(true, fragment.xid).mac;
        let outcome = self.response.fragment(fragment.xid, fragment.fragment, fragment.body);
        if let Some(status) = outcome.ack() {
            let acknowledge = FragmentAcknowledge::new(fragment.xid, mac, fragment.fragment.count(), status);
            self.acknowledge = Some((self.route.request(), acknowledge));
        }
        match outcome {
            ExplicitOutcome::Stored | ExplicitOutcome::Repeated => {
                let received = match fragment.fragment.kind {
                    FragmentKind::First => fragment.body.len(),
                    _ if outcome == ExplicitOutcome::Repeated => before,
                    _ => before.saturating_add(fragment.body.len()),
                };
                // Only what is new prolongs the wait: a server that repeats itself is not waited for for ever.
                if received > most {
                    self.timer = TimerChange::Set(self.waits.next_fragment);
                }
                self.stage = Stage::Receiving { attempt, most: most.max(received) };
                Progress::Pending
            }
            ExplicitOutcome::RepeatedLast => Progress::Pending,
            ExplicitOutcome::Complete(body) => {
                self.stage = Stage::Idle;
                self.timer = TimerChange::Set(REPETITION);
                match Response::parse(body) {
                    Ok(response) if is_answer(asked, &response) => Progress::Response(response),
                    Ok(_) | Err(_) => Progress::Failed(Failure::Malformed),
                }
            }
            ExplicitOutcome::TooLong => {
                self.stage = Stage::Idle;
                self.timer = TimerChange::Clear;
                Progress::Failed(Failure::ResponseTooLong)
            }
            ExplicitOutcome::OutOfSequence { .. }
            | ExplicitOutcome::IgnoredNoFirst
            | ExplicitOutcome::InvalidFirst { .. }
            | ExplicitOutcome::Acknowledge => Progress::Ignored(Ignored::OutOfSequence),
        }
    }

    /// Whether a response with that transaction ID can come now.
    fn expects(&self, xid: bool) -> Result<(), Ignored> {
        let asked = match self.stage {
            Stage::Idle => false,
            // The acknowledge of the last fragment may be lost, and even its `TxDone` be late: the response proves both.
            Stage::Requesting { attempt, fragment, repeated, progress } => {
                let sent = progress != Sending::Due || repeated;
                let last = !is_fragmented_explicit(&self.request)
                    || explicit_fragment(&self.request, fragment)
                        .is_some_and(|part| part.byte.kind == FragmentKind::Last);
                // Or it answers an earlier attempt.
                sent && last || attempt > 1
            }
            Stage::Awaiting { .. } | Stage::Receiving { .. } => true,
        };
        match (asked, xid == self.xid) {
            (true, true) => Ok(()),
            (true, false) => Err(Ignored::Stale),
            (false, _) => Err(Ignored::Unexpected),
        }
    }

    fn answers(&self, response: &Response<'_>) -> Result<(), Ignored> {
        if is_answer(self.asked(), response) { Ok(()) } else { Err(Ignored::OtherService) }
    }

    fn asked(&self) -> Option<ServiceCode> {
        self.request.first().map(|&byte| ServiceCode::split(byte).0)
    }

    fn ready(&self) -> Result<(), StartError> {
        if self.is_busy() { Err(StartError::Busy) } else { Ok(()) }
    }

    fn request_from_the_start(&mut self, attempt: u8) {
        self.stage = Stage::Requesting { attempt, fragment: 0, repeated: false, progress: Sending::Due };
        self.timer = TimerChange::Clear;
    }

    fn request_frame(&self, fragment: usize) -> Option<Frame> {
        let (xid, mac) = (self.xid, self.route.header(false, self.xid).mac);
        if !is_fragmented_explicit(&self.request) {
            let message = ExplicitMessage { xid, mac, body: &self.request };
            return message::frame(self.route.request(), &message);
        }
        let part = explicit_fragment(&self.request, fragment)?;
        let message = ExplicitFragment { xid, mac, fragment: part.byte, body: part.data };
        message::frame(self.route.request(), &message)
    }

    fn fail(&mut self, failure: Failure) -> Failure {
        self.stage = Stage::Idle;
        self.response.discard();
        self.timer = TimerChange::Clear;
        failure
    }
}

fn is_answer(asked: Option<ServiceCode>, response: &Response<'_>) -> bool {
    match response {
        Response::Success { service, .. } => Some(*service) == asked,
        Response::Error { .. } => true,
    }
}

/// How long the last fragment of a complete response is acknowledged again.
const REPETITION: Duration = Duration::from_secs(1);
const HEADER_MAC: u8 = 0x3F;
const HEADER_FRAGMENTED: u8 = 0x80;
