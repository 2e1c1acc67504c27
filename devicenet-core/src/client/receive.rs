//! What a frame from the bus means to a conversation.

use core::time::Duration;

use cip_core::code::ServiceCode;
use cip_core::codec::Wire;
use cip_core::fragment::{
    AckStatus, ExplicitOutcome, FragmentKind, explicit_fragment, is_fragmented_explicit,
};
use cip_core::message::Response;
use link_core::Frame;

use super::conversation::{Conversation, Sending, Stage};
use super::outcome::{Failure, Ignored, Progress, TimerChange};
use crate::id::Identifier;
use crate::message::{ExplicitFragment, ExplicitMessage, FragmentAcknowledge};

impl<const N: usize> Conversation<N> {
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
