//! One explicit connection as a pipe: a request in, in one frame or in fragments, and its response out.
//!
//! | What | Rule |
//! |---|---|
//! | fragment of a request | put together by [`ExplicitReassembly`], its acknowledge goes out before anything else |
//! | complete request, or first fragment | aborts a response in progress |
//! | response of up to seven bytes | one frame |
//! | longer response | fragments paced by [`ExplicitTransmit`], 1000 ms for each acknowledge, two tries |
//!
//! It is told what arrives and hands out what is to be sent; the identifiers are its owner's business.

use core::hash::{Hash, Hasher};

use cip_core::codec::Writer;
use cip_core::fragment::{
    AckStatus, ExplicitOutcome, ExplicitReassembly, ExplicitTransmit, FragmentByte, FragmentKind,
    TransmitOutcome,
};
use heapless::Vec;
use link_core::timers::TimerKey;
use link_core::{Deadline, Instant, Timers};

use super::event::Ignored;
use crate::id::MacId;
use crate::message::ExplicitHeader;

/// The buffers and the progress of one explicit connection.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Transfer<const MESSAGE: usize> {
    reassembly: ExplicitReassembly<MESSAGE>,
    response: Response<MESSAGE>,
    transmit: ExplicitTransmit,
    /// Of the response, and of its fragments.
    header: u8,
    stage: Stage,
    acknowledge: Option<[u8; 3]>,
    timers: Timers<Timer, 2>,
}

/// A response from the service byte on. What earlier ones have left behind its end is no part of it.
#[derive(Clone, Debug)]
struct Response<const N: usize> {
    bytes: [u8; N],
    len: usize,
}

/// How far the present frame of the response is.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
enum Stage {
    /// Nothing is to be sent.
    Idle,
    /// To be handed to the controller.
    Due,
    /// The same, for the second time: the acknowledge of the first may still come.
    Again,
    /// With the controller.
    Handed,
    /// A fragment was sent, and is to be acknowledged.
    Sent,
}

/// What a frame on the connection is.
pub(super) enum Incoming {
    /// A request that was answered.
    Answered,
    /// Part of something.
    Taken,
    /// Not to be obeyed.
    Ignored(Ignored),
}

/// A frame that is handed out.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Piece {
    /// Of a fragment of the request.
    Acknowledge,
    /// The response, or a fragment of it.
    Response,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
enum Timer {
    /// A fragment of the response waits for its acknowledge.
    Acknowledge,
    /// What arrived of a request is dropped, or the last one forgotten.
    Reassembly,
}

impl TimerKey<2> for Timer {
    const ALL: [Self; 2] = [Self::Acknowledge, Self::Reassembly];

    fn index(self) -> usize {
        match self {
            Self::Acknowledge => 0,
            Self::Reassembly => 1,
        }
    }

    fn why(self) -> &'static str {
        match self {
            Self::Acknowledge => "acknowledge of a fragment",
            Self::Reassembly => "next fragment",
        }
    }
}

/// What the owner decides about fragments.
#[derive(Clone, Copy)]
pub(super) struct Rules {
    /// In ms.
    pub(super) receive_time_out: u16,
    pub(super) reacknowledge_last: bool,
}

impl<const MESSAGE: usize> Transfer<MESSAGE> {
    /// `limit`: the longest request, from the service byte on.
    pub(super) const fn new(limit: usize) -> Self {
        Self {
            reassembly: ExplicitReassembly::new(limit),
            response: Response { bytes: [0; MESSAGE], len: 0 },
            transmit: ExplicitTransmit::new(),
            header: 0,
            stage: Stage::Idle,
            acknowledge: None,
            timers: Timers::new(),
        }
    }

    /// Takes the data field of a frame. `peer` is the MAC ID in the header of what goes back. `serve` writes the response to a complete request, or returns false
    /// if there is to be none.
    pub(super) fn receive(
        &mut self,
        now: Instant,
        rules: Rules,
        peer: MacId,
        field: &[u8],
        serve: impl FnOnce(&[u8], &mut Writer<'_>) -> Result<(), Ignored>,
    ) -> Incoming {
        self.timers.advance(now);
        let Some((&header, body)) = field.split_first() else {
            return Incoming::Ignored(Ignored::TooShort);
        };
        let header = ExplicitHeader { mac: peer, ..ExplicitHeader::from(header) };
        if !header.fragmented {
            self.abort();
            self.forget();
            return self.answer(header, body, serve);
        }
        let Some((&byte, data)) = body.split_first() else {
            return Incoming::Ignored(Ignored::TooShort);
        };
        let fragment = FragmentByte::from(byte);
        match fragment.kind {
            FragmentKind::Acknowledge => return self.acknowledged(fragment.count(), data),
            FragmentKind::First => self.abort(),
            FragmentKind::Middle | FragmentKind::Last => {}
        }
        let outcome = self.reassembly.fragment(header.xid, fragment, data);
        if let Some(status) = outcome.ack() {
            let acknowledge = FragmentByte::new(FragmentKind::Acknowledge, fragment.count());
            self.acknowledge = Some([header.into(), acknowledge.into(), status.into()]);
        }
        match outcome {
            ExplicitOutcome::Complete(request) => {
                self.timers.clear(Timer::Acknowledge);
                let served = respond(&mut self.response, request, serve);
                if rules.reacknowledge_last {
                    self.timers.set_after_millis(Timer::Reassembly, REACKNOWLEDGE_MILLIS);
                } else {
                    self.forget();
                }
                self.begin(header, served)
            }
            ExplicitOutcome::Stored | ExplicitOutcome::Repeated => {
                self.timers.set_after_millis(Timer::Reassembly, rules.receive_time_out.into());
                Incoming::Taken
            }
            ExplicitOutcome::RepeatedLast => Incoming::Taken,
            ExplicitOutcome::TooLong => {
                self.timers.clear(Timer::Reassembly);
                Incoming::Taken
            }
            ExplicitOutcome::OutOfSequence { .. }
            | ExplicitOutcome::IgnoredNoFirst
            | ExplicitOutcome::InvalidFirst { .. } => {
                if !self.reassembly.remembers_completed() {
                    self.timers.clear(Timer::Reassembly);
                }
                Incoming::Ignored(Ignored::FragmentOrder)
            }
            ExplicitOutcome::Acknowledge => Incoming::Ignored(Ignored::StrayAcknowledge),
        }
    }

    /// Nothing is left to be sent of a response.
    pub(super) fn is_quiet(&self) -> bool {
        self.stage == Stage::Idle
    }

    /// Whether a frame is to be handed out.
    pub(super) fn is_due(&self) -> bool {
        self.acknowledge.is_some() || matches!(self.stage, Stage::Due | Stage::Again)
    }

    /// Whether that frame is an acknowledge.
    pub(super) const fn must_acknowledge(&self) -> bool {
        self.acknowledge.is_some()
    }

    /// The data field of the next frame.
    pub(super) fn take(&mut self) -> Option<(Piece, Vec<u8, 8>)> {
        let mut field = Vec::new();
        if let Some(acknowledge) = self.acknowledge.take() {
            field.extend_from_slice(&acknowledge).ok()?;
            return Some((Piece::Acknowledge, field));
        }
        if !matches!(self.stage, Stage::Due | Stage::Again) {
            return None;
        }
        self.stage = Stage::Handed;
        match self.transmit.fragment(self.response.body()) {
            Some(fragment) => {
                let mut header = ExplicitHeader::from(self.header);
                header.fragmented = true;
                field.extend_from_slice(&[header.into(), fragment.byte.into()]).ok()?;
                field.extend_from_slice(fragment.data).ok()?;
            }
            None => {
                field.push(self.header).ok()?;
                field.extend_from_slice(self.response.body()).ok()?;
            }
        }
        Some((Piece::Response, field))
    }

    /// The frame that was handed out is with the controller no longer: sent, or given back.
    pub(super) fn handed(&mut self, now: Instant, piece: Piece) {
        self.timers.advance(now);
        if piece != Piece::Response || self.stage != Stage::Handed {
            return;
        }
        if self.transmit.is_sending() {
            self.stage = Stage::Sent;
            self.timers.set_after_millis(Timer::Acknowledge, ACKNOWLEDGE_MILLIS);
        } else {
            self.stage = Stage::Idle;
        }
    }

    /// Whether a timer has run out.
    pub(super) fn is_over(&mut self, now: Instant) -> bool {
        self.timers.is_due(now)
    }

    /// Serves every wait that is over at `until`; true if a response was given up.
    pub(super) fn expire(&mut self, now: Instant, until: Instant) -> bool {
        self.timers.advance(now);
        let mut abandoned = false;
        while let Some(timer) = self.timers.take_expired(until) {
            match timer {
                Timer::Reassembly if self.reassembly.is_receiving() => self.reassembly.discard(),
                Timer::Reassembly => self.reassembly.forget_completed(),
                Timer::Acknowledge => {
                    let outcome = self.transmit.time_out();
                    abandoned |= outcome == TransmitOutcome::Abandoned;
                    self.go_on(outcome);
                    if self.stage == Stage::Due {
                        self.stage = Stage::Again;
                    }
                }
            }
        }
        abandoned
    }

    /// The connection is gone. A response in one frame, and the acknowledge before it, still go out: they may belong to the
    /// request that ended it.
    pub(super) fn close(&mut self) {
        self.forget();
        if self.transmit.is_sending() {
            self.abort();
        }
    }

    /// Nothing goes out any more.
    pub(super) fn clear(&mut self) {
        self.close();
        self.acknowledge = None;
        self.abort();
    }

    pub(super) fn deadline(&self) -> Option<Deadline> {
        self.timers.next()
    }

    pub(super) fn shift_time(&mut self, span: core::time::Duration) {
        self.timers.shift(span);
    }

    fn answer(
        &mut self,
        header: ExplicitHeader,
        request: &[u8],
        serve: impl FnOnce(&[u8], &mut Writer<'_>) -> Result<(), Ignored>,
    ) -> Incoming {
        let served = respond(&mut self.response, request, serve);
        self.begin(header, served)
    }

    fn begin(&mut self, header: ExplicitHeader, served: Result<(), Ignored>) -> Incoming {
        if let Err(why) = served {
            return Incoming::Ignored(why);
        }
        self.header = ExplicitHeader::complete(header.xid, header.mac).into();
        self.stage = Stage::Due;
        self.transmit.start(self.response.body());
        Incoming::Answered
    }

    fn acknowledged(&mut self, count: u8, data: &[u8]) -> Incoming {
        let Some(&status) = data.first() else { return Incoming::Ignored(Ignored::TooShort) };
        // A fragment that was never handed out cannot have been received.
        if self.stage == Stage::Due {
            return Incoming::Ignored(Ignored::StrayAcknowledge);
        }
        match self.transmit.acknowledge(self.response.body(), count, AckStatus::from(status)) {
            TransmitOutcome::Ignored => Incoming::Ignored(Ignored::StrayAcknowledge),
            outcome => {
                self.go_on(outcome);
                Incoming::Taken
            }
        }
    }

    fn go_on(&mut self, outcome: TransmitOutcome) {
        self.timers.clear(Timer::Acknowledge);
        self.stage = match outcome {
            TransmitOutcome::Send => Stage::Due,
            TransmitOutcome::Complete | TransmitOutcome::Refused(_) | TransmitOutcome::Abandoned => {
                Stage::Idle
            }
            TransmitOutcome::Ignored => self.stage,
        };
    }

    fn abort(&mut self) {
        self.transmit.abort();
        self.timers.clear(Timer::Acknowledge);
        self.stage = Stage::Idle;
    }

    fn forget(&mut self) {
        self.reassembly.discard();
        self.timers.clear(Timer::Reassembly);
    }
}

fn respond<const N: usize>(
    response: &mut Response<N>,
    request: &[u8],
    serve: impl FnOnce(&[u8], &mut Writer<'_>) -> Result<(), Ignored>,
) -> Result<(), Ignored> {
    let mut out = Writer::new(&mut response.bytes);
    let served = serve(request, &mut out);
    response.len = out.len();
    served
}

impl<const N: usize> Response<N> {
    fn body(&self) -> &[u8] {
        self.bytes.get(..self.len).unwrap_or_default()
    }
}

impl<const N: usize> PartialEq for Response<N> {
    fn eq(&self, other: &Self) -> bool {
        self.body() == other.body()
    }
}

impl<const N: usize> Eq for Response<N> {}

impl<const N: usize> Hash for Response<N> {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.body().hash(state);
    }
}

/// T_ack: how long a fragment of a response waits for its acknowledge.
const ACKNOWLEDGE_MILLIS: u32 = 1000;
/// How long the last fragment of a request is known again.
const REACKNOWLEDGE_MILLIS: u32 = 1000;
