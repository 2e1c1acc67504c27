//! One explicit connection as a pipe: a request in, in one frame or in fragments, and its response out.
//!
//! | What | Rule |
//! |---|---|
//! | fragment of a request | put together by [`ExplicitReceive`], its acknowledge goes out before anything else |
//! | complete request, or first fragment | aborts a response in progress |
//! | response of up to seven bytes | one frame |
//! | longer response | fragments paced by [`ExplicitTransmit`], 1000 ms for each acknowledge, two tries |
//!
//! It is told what arrives and hands out what is to be sent; the identifiers and the timers are its owner's business. The
//! timers have the present moment, and it is told which of them has run out.

use cip_core::codec::Writer;
use cip_core::fragment::{
    AckStatus, ExplicitOutcome, ExplicitReceive, ExplicitTransmit, FragmentByte, FragmentKind,
    TransmitOutcome,
};
use cip_core::transfer::{Message, Rules};
use link_core::Frame;
use link_core::timers::TimerSet;

use super::event::Ignored;
use super::timer::Timer;
use crate::id::Identifier;

/// The buffers and the progress of one explicit connection.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
// In this order the code is shortest, as in `Node`.
#[repr(C)]
pub(super) struct Transfer<const MESSAGE: usize> {
    receive: ExplicitReceive,
    transmit: ExplicitTransmit,
    acknowledge: Option<[u8; 3]>,
    stage: Stage,
    /// Of the response; its fragments have FRAG besides.
    header: u8,
    /// A request in fragments while it arrives, and the response after that: what begins a request aborts the response
    /// to the one before.
    message: Message<MESSAGE>,
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

/// A frame that is handed out.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Piece {
    /// Of a fragment of the request.
    Acknowledge,
    /// The response, or a fragment of it.
    Response,
}

impl<const MESSAGE: usize> Transfer<MESSAGE> {
    /// `limit`: the longest request, from the service byte on.
    pub(super) const fn new(limit: usize) -> Self {
        Self {
            message: Message::EMPTY,
            receive: ExplicitReceive::new(limit),
            transmit: ExplicitTransmit::new(),
            header: 0,
            stage: Stage::Idle,
            acknowledge: None,
        }
    }

    /// Takes the data field of a frame. `header`: its header, with the MAC ID that is in the header of what goes back. True if
    /// a request is complete now, which is to be [answered](Self::answer).
    pub(super) fn receive(
        &mut self,
        timers: &mut impl TimerSet<Timer>,
        rules: Rules,
        header: u8,
        field: &[u8],
    ) -> Result<bool, Ignored> {
        if header & FRAGMENT != 0 {
            return self.fragment(timers, rules, header, field);
        }
        self.abort(timers);
        self.forget(timers);
        Ok(true)
    }

    /// Answers the request that the data field of the last frame was, or was the end of. `serve` writes the response; an
    /// error: there is none.
    pub(super) fn answer(
        &mut self,
        header: u8,
        field: &[u8],
        serve: impl FnOnce(&[u8], &mut Writer<'_>) -> Result<(), Ignored>,
    ) -> Result<(), Ignored> {
        let reassembled;
        let request = if header & FRAGMENT != 0 {
            reassembled = self.message.clone();
            reassembled.body()
        } else {
            field.get(1..).unwrap_or_default()
        };
        let mut out = Writer::new(&mut self.message.bytes);
        let served = serve(request, &mut out);
        let len = out.len();
        served?;
        self.respond(header, len);
        Ok(())
    }

    /// No request has begun to arrive, nothing is remembered of one, and nothing is to be sent.
    #[inline]
    pub(super) const fn is_idle(&self) -> bool {
        matches!(self.stage, Stage::Idle) && self.receive.is_idle() && self.acknowledge.is_none()
    }

    /// Where a response goes while the connection is [idle](Self::is_idle).
    #[inline]
    pub(super) const fn writer(&mut self) -> Writer<'_> {
        Writer::new(&mut self.message.bytes)
    }

    /// So many bytes were written while it was idle: they are a response in one frame.
    #[inline]
    pub(super) fn respond_whole(&mut self, header: u8, len: usize) {
        self.message.set_len(len);
        self.header = header & !FRAGMENT;
        self.stage = Stage::Due;
    }

    /// So many bytes were written to the message: they are the response.
    #[inline]
    fn respond(&mut self, header: u8, len: usize) {
        self.respond_whole(header, len);
        self.transmit.start(self.message.body());
    }

    /// Takes a fragment; true if the request is complete.
    #[inline(never)]
    fn fragment(
        &mut self,
        timers: &mut impl TimerSet<Timer>,
        rules: Rules,
        header: u8,
        field: &[u8],
    ) -> Result<bool, Ignored> {
        let [_, byte, data @ ..] = field else { return Err(Ignored::TooShort) };
        let fragment = FragmentByte::from(*byte);
        match fragment.kind {
            FragmentKind::Acknowledge => {
                return self.acknowledged(timers, fragment.count(), data).map(|()| false);
            }
            FragmentKind::First => self.abort(timers),
            FragmentKind::Middle | FragmentKind::Last => {}
        }
        let outcome = self.receive.fragment(&mut self.message.bytes, header & XID != 0, fragment, data);
        if let Some(status) = outcome.ack() {
            let acknowledge = FragmentByte::new(FragmentKind::Acknowledge, fragment.count());
            self.acknowledge = Some([header, acknowledge.into(), status.into()]);
        }
        match outcome {
            ExplicitOutcome::Complete(request) => {
                let len = request.len();
                self.message.set_len(len);
                if rules.reacknowledge_last {
                    timers.set_after_millis(Timer::Reassembly, REACKNOWLEDGE_MILLIS);
                } else {
                    self.forget(timers);
                }
                return Ok(true);
            }
            ExplicitOutcome::Stored | ExplicitOutcome::Repeated => {
                self.message.set_len(self.receive.received().into());
                timers.set_after_millis(Timer::Reassembly, rules.receive_time_out.into());
            }
            ExplicitOutcome::RepeatedLast => {}
            ExplicitOutcome::TooLong => timers.clear(Timer::Reassembly),
            ExplicitOutcome::OutOfSequence { .. }
            | ExplicitOutcome::IgnoredNoFirst
            | ExplicitOutcome::InvalidFirst { .. } => {
                if !self.receive.remembers_completed() {
                    timers.clear(Timer::Reassembly);
                }
                return Err(Ignored::FragmentOrder);
            }
            ExplicitOutcome::Acknowledge => return Err(Ignored::StrayAcknowledge),
        }
        Ok(false)
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

    /// The next frame, if it is a response that needs no other.
    #[inline]
    pub(super) fn take_whole(&mut self, id: Identifier) -> Option<Frame> {
        if self.stage != Stage::Due || self.acknowledge.is_some() || self.transmit.is_sending() {
            return None;
        }
        self.stage = Stage::Handed;
        let [a, b, c, d, e, f, g] = *self.message.bytes.first_chunk()?;
        let len = usize::from(self.message.len()).saturating_add(1);
        id.frame_of([self.header, a, b, c, d, e, f, g], len)
    }

    /// The next frame, under the identifier of the connection.
    pub(super) fn take(&mut self, id: Identifier) -> Option<(Piece, Frame)> {
        let mut frame = id.empty_frame();
        Some((self.write(&mut frame)?, frame))
    }

    /// Appends the data field of the next frame.
    pub(super) fn write(&mut self, frame: &mut Frame) -> Option<Piece> {
        if let Some(acknowledge) = self.acknowledge.take() {
            frame.append(&acknowledge)?;
            return Some(Piece::Acknowledge);
        }
        if !matches!(self.stage, Stage::Due | Stage::Again) {
            return None;
        }
        self.stage = Stage::Handed;
        let data = match self.transmit.fragment(self.message.body()) {
            Some(fragment) => {
                frame.append(&[self.header | FRAGMENT, fragment.byte.into()])?;
                fragment.data
            }
            None => {
                frame.append(&[self.header])?;
                self.message.body()
            }
        };
        frame.append(data)?;
        Some(Piece::Response)
    }

    /// The frame that was handed out is with the controller no longer: sent, or given back.
    pub(super) fn handed(&mut self, timers: &mut impl TimerSet<Timer>, piece: Piece) {
        if piece != Piece::Response || self.stage != Stage::Handed {
            return;
        }
        if self.transmit.is_sending() {
            self.stage = Stage::Sent;
            timers.set_after_millis(Timer::FragmentAcknowledge, ACKNOWLEDGE_MILLIS);
        } else {
            self.stage = Stage::Idle;
        }
    }

    /// Nothing more of a request has arrived in time, or the last one is old enough to be forgotten.
    pub(super) fn reassembly_over(&mut self) {
        if self.receive.is_receiving() {
            self.receive.discard();
        } else {
            self.receive.forget_completed();
        }
    }

    /// The acknowledge of a fragment has not come in time; true if the response was given up.
    pub(super) fn not_acknowledged(&mut self) -> bool {
        match self.transmit.time_out() {
            TransmitOutcome::Send => self.stage = Stage::Again,
            TransmitOutcome::Abandoned => {
                self.stage = Stage::Idle;
                return true;
            }
            TransmitOutcome::Complete | TransmitOutcome::Refused(_) | TransmitOutcome::Ignored => {}
        }
        false
    }

    /// The connection is gone. A response in one frame, and the acknowledge before it, still go out: they may belong to the
    /// request that ended it.
    pub(super) fn close(&mut self, timers: &mut impl TimerSet<Timer>) {
        self.forget(timers);
        if self.transmit.is_sending() {
            self.abort(timers);
        }
    }

    /// Nothing goes out any more.
    pub(super) fn clear(&mut self, timers: &mut impl TimerSet<Timer>) {
        self.close(timers);
        self.acknowledge = None;
        self.abort(timers);
    }

    fn acknowledged(
        &mut self,
        timers: &mut impl TimerSet<Timer>,
        count: u8,
        data: &[u8],
    ) -> Result<(), Ignored> {
        let &status = data.first().ok_or(Ignored::TooShort)?;
        // A fragment that was never handed out cannot have been received.
        if self.stage == Stage::Due {
            return Err(Ignored::StrayAcknowledge);
        }
        match self.transmit.acknowledge(self.message.body(), count, AckStatus::from(status)) {
            TransmitOutcome::Ignored => Err(Ignored::StrayAcknowledge),
            outcome => {
                self.go_on(timers, outcome);
                Ok(())
            }
        }
    }

    #[inline(always)]
    fn go_on(&mut self, timers: &mut impl TimerSet<Timer>, outcome: TransmitOutcome) {
        timers.clear(Timer::FragmentAcknowledge);
        self.stage = match outcome {
            TransmitOutcome::Send => Stage::Due,
            TransmitOutcome::Complete | TransmitOutcome::Refused(_) | TransmitOutcome::Abandoned => {
                Stage::Idle
            }
            TransmitOutcome::Ignored => self.stage,
        };
    }

    /// The response in progress.
    // Called from several places: in a small device a copy for each is too much.
    #[inline(never)]
    fn abort(&mut self, timers: &mut impl TimerSet<Timer>) {
        // Where there is none nothing is waited for.
        if self.stage != Stage::Idle {
            self.go_on(timers, TransmitOutcome::Abandoned);
            self.transmit.abort();
        }
    }

    /// What has arrived of a request, or the last one.
    // Called from several places: in a small device a copy for each is too much.
    #[inline(never)]
    fn forget(&mut self, timers: &mut impl TimerSet<Timer>) {
        // Where nothing is remembered no timer runs.
        if !self.receive.is_idle() {
            self.receive.discard();
            timers.clear(Timer::Reassembly);
        }
    }
}

/// FRAG and XID, in the header.
const FRAGMENT: u8 = 0x80;
const XID: u8 = 0x40;
/// T_ack: how long a fragment of a response waits for its acknowledge.
const ACKNOWLEDGE_MILLIS: u32 = 1000;
/// How long the last fragment of a request is known again.
const REACKNOWLEDGE_MILLIS: u32 = 1000;
