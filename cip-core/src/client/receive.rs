//! What a frame from the bus means to a conversation.

use core::time::Duration;

use link_core::Frame;

use super::channel::{Channel, Heard};
use super::conversation::{Acknowledge, Conversation, Sending, Stage};
use super::outcome::{Failure, Ignored, Progress, TimerChange};
use crate::code::ServiceCode;
use crate::fragment::{AckStatus, ExplicitOutcome, Fragment, FragmentKind};
use crate::message::Response;

impl<C: Channel, const N: usize> Conversation<C, N> {
    /// Takes a frame from the bus.
    pub fn frame<'a>(&'a mut self, frame: &'a Frame) -> Progress<'a> {
        match self.route.hear(frame) {
            None => Progress::NotMine,
            Some(Ok(Heard::Complete { transaction, body })) => self.complete(transaction, body),
            Some(Ok(Heard::Fragment { transaction, fragment })) => self.fragment(transaction, fragment),
            Some(Ok(Heard::Acknowledge { transaction, count, status })) => {
                self.acknowledged(transaction, count, status)
            }
            Some(Err(_)) => Progress::Ignored(Ignored::Malformed),
        }
    }

    fn complete<'a>(&mut self, transaction: C::Transaction, body: &'a [u8]) -> Progress<'a> {
        let Ok(response) = self.route.response(body) else {
            return Progress::Ignored(Ignored::Malformed);
        };
        if let Err(ignored) = self.expects(Some(transaction)).and_then(|()| self.answers(&response)) {
            return Progress::Ignored(ignored);
        }
        self.response.discard();
        self.stage = Stage::Idle;
        self.timer = TimerChange::Clear;
        Progress::Response(response)
    }

    fn acknowledged(
        &mut self,
        transaction: Option<C::Transaction>,
        count: u8,
        status: AckStatus,
    ) -> Progress<'static> {
        let Stage::Requesting { attempt, fragment, repeated, progress } = self.stage else {
            return Progress::Ignored(Ignored::Unexpected);
        };
        if !self.is_fragmented() || (progress == Sending::Due && !repeated) {
            return Progress::Ignored(Ignored::Unexpected);
        }
        if !self.is_current(transaction) {
            return Progress::Ignored(Ignored::Stale);
        }
        if self.cut(fragment).map(|sent| sent.byte.count()) != Some(count) {
            return Progress::Ignored(Ignored::OtherAcknowledge);
        }
        if status != AckStatus::Success {
            return Progress::Failed(self.fail(Failure::RequestTooLong));
        }
        let next = fragment.saturating_add(1);
        if self.cut(next).is_some() {
            self.stage =
                Stage::Requesting { attempt, fragment: next, repeated: false, progress: Sending::Due };
            self.timer = TimerChange::Clear;
        } else {
            self.stage = Stage::Awaiting { attempt };
            self.timer = TimerChange::Set(self.waits.response);
        }
        Progress::Pending
    }

    fn fragment(&mut self, transaction: Option<C::Transaction>, fragment: Fragment<'_>) -> Progress<'_> {
        let kind = fragment.byte.kind;
        let (attempt, most) = match (self.stage, self.expects(transaction)) {
            (Stage::Idle, Err(Ignored::Unexpected))
                if self.response.remembers_completed() && kind != FragmentKind::First =>
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
        let outcome = self.response.fragment(C::xid(transaction), fragment.byte, fragment.data);
        if let Some(status) = outcome.ack() {
            self.acknowledge = Some(Acknowledge {
                route: self.route.clone(),
                transaction: transaction.unwrap_or(self.transaction),
                count: fragment.byte.count(),
                status,
            });
        }
        match outcome {
            ExplicitOutcome::Stored | ExplicitOutcome::Repeated => {
                let received = match kind {
                    FragmentKind::First => fragment.data.len(),
                    _ if outcome == ExplicitOutcome::Repeated => before,
                    _ => before.saturating_add(fragment.data.len()),
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
                match self.route.response(body) {
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
    fn expects(&self, transaction: Option<C::Transaction>) -> Result<(), Ignored> {
        let asked = match self.stage {
            Stage::Idle => false,
            // The acknowledge of the last fragment may be lost, and even its `TxDone` be late: the response proves both.
            Stage::Requesting { attempt, fragment, repeated, progress } => {
                let sent = progress != Sending::Due || repeated;
                let last = !self.is_fragmented()
                    || self.cut(fragment).is_some_and(|part| part.byte.kind == FragmentKind::Last);
                // Or it answers an earlier attempt.
                sent && last || attempt > 1
            }
            Stage::Awaiting { .. } | Stage::Receiving { .. } => true,
        };
        match (asked, self.is_current(transaction)) {
            (true, true) => Ok(()),
            (true, false) => Err(Ignored::Stale),
            (false, _) => Err(Ignored::Unexpected),
        }
    }

    /// What carries no transaction ID goes with what did.
    fn is_current(&self, transaction: Option<C::Transaction>) -> bool {
        transaction.is_none_or(|transaction| transaction == self.transaction)
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
