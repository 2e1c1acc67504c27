//! What the machine does with what it hears: frames, answers to transmissions, link events.

use link_core::link::LinkCommandKind;
use link_core::{BusErrorKind, Frame, LinkEvent, TxOutcome, TxToken};

use super::config::BusOffWhileChecking;
use super::event::Outgoing;
use super::extent::Extent;
use super::machine::{Access, Fate, InFlight, Listening, Timer};
use super::pending::{Heard, Lost, Pending};
use super::state::{Cause, CheckRequest, Fault, SecondRequest, SendStage, State};
use crate::id::Identifier;
use crate::message::{Direction, DuplicateMacCheck, Wire};

impl Access {
    pub(super) fn frame<P: Extent>(&mut self, frame: &Frame) {
        let Some(id) = Identifier::of_frame(frame) else {
            P::count_wide(&mut self.counters.foreign_frames);
            return;
        };
        if self.state.is_off_the_bus() {
            // Received before bus-off, and delivered after it: the check begins anew anyhow.
            return self.discard::<P>();
        }
        match (self.state, self.listening::<P>()) {
            (State::NonExistent, _) => self.discard::<P>(),
            (_, Listening::Check(mac)) if id == Identifier::duplicate_mac_check(mac) => {
                self.check::<P>(id, frame.data())
            }
            (_, Listening::OfflineSet)
                if P::OFFLINE_SET && id == Identifier::COMMUNICATION_FAULTED_REQUEST =>
            {
                self.communication_faulted::<P>(frame.data());
            }
            // Other frames are the business of other parts of the node.
            (State::OnLine { .. }, _) => {}
            (State::CommFault { .. }, _) => self.discard::<P>(),
            (State::SendingDupMac { .. } | State::WaitingDupMac { .. }, _) => {
                self.stay(Cause::OtherMessage);
                self.discard::<P>();
            }
        }
    }

    /// A frame on the identifier of the own check.
    fn check<P: Extent>(&mut self, id: Identifier, data: &[u8]) {
        let check = DuplicateMacCheck::parse(data);
        let kept = self.hear::<P>(|| check.map_or_else(|_| Heard::malformed(id, data), Heard::Check));
        if check.is_err() {
            self.bad_frame::<P>(kept);
            if P::CHOICES && !self.config.accept_bad_dlc {
                return;
            }
        }
        // Without a first byte it is taken for a request, which is answered on line instead of obeyed.
        let direction = data.first().map_or(Direction::Request, |&byte| Direction::of(byte));
        let cause = match direction {
            Direction::Request => Cause::DuplicateRequest,
            Direction::Response => Cause::DuplicateResponse,
        };
        if let State::OnLine { response_due, .. } = &mut self.state
            && direction == Direction::Request
        {
            if *response_due {
                P::count(&mut self.counters.requests_merged);
            }
            *response_due = true;
            P::count(&mut self.counters.challenges);
            self.stay(cause);
            self.raise_heard::<P>(kept, Pending::Challenged);
            return;
        }
        P::count(&mut self.counters.duplicates);
        self.raise_heard::<P>(kept, Pending::Duplicate { direction });
        self.enter::<P>(State::faulted(Fault::DuplicateMacId), cause);
    }

    pub(super) fn tx_done<P: Extent>(&mut self, token: TxToken, outcome: TxOutcome) {
        let Some(InFlight { what, fate }) = self.in_flight.filter(|_| token == Self::TOKEN) else {
            P::count(&mut self.counters.stray_tx_done);
            return;
        };
        self.in_flight = None;
        match (fate, outcome) {
            (Fate::Unwanted | Fate::Abandoned, _) => {}
            (Fate::Wanted, TxOutcome::Sent) => self.sent::<P>(what),
            (Fate::Wanted, TxOutcome::Withdrawn | TxOutcome::Dropped | TxOutcome::Unknown) => {
                self.given_back::<P>(what, outcome);
            }
        }
    }

    fn sent<P: Extent>(&mut self, what: Outgoing) {
        match (what, &mut self.state) {
            (Outgoing::CheckRequest, State::SendingDupMac { request: CheckRequest::First, .. })
                if P::QUICK_CONNECT && self.quick_connect.active =>
            {
                self.enter::<P>(State::on_line(SecondRequest::Waiting), Cause::QuickConnect);
            }
            (Outgoing::CheckRequest, State::SendingDupMac { request, .. }) => {
                let request = *request;
                self.enter::<P>(State::WaitingDupMac { request }, Cause::RequestSent);
            }
            (Outgoing::CheckRequest, State::OnLine { second_request, .. }) if P::QUICK_CONNECT => {
                *second_request = SecondRequest::Done;
                self.stay(Cause::RequestSent);
            }
            (Outgoing::CheckResponse, _) => P::count(&mut self.counters.responses),
            (Outgoing::CheckRequest | Outgoing::WhoResponse | Outgoing::IdentifyResponse, _) => {}
        }
    }

    fn given_back<P: Extent>(&mut self, what: Outgoing, outcome: TxOutcome) {
        P::count(&mut self.counters.not_sent);
        self.raise::<P>(Pending::NotSent { what, outcome });
        match (what, &mut self.state) {
            (Outgoing::CheckRequest, State::SendingDupMac { stage, .. }) => *stage = SendStage::GivenBack,
            // Still queued.
            (Outgoing::CheckRequest, State::OnLine { .. }) if P::QUICK_CONNECT => {}
            // Without it the other node gets on line too: its second request is its last.
            (Outgoing::CheckResponse, State::OnLine { response_due, .. }) => {
                if core::mem::replace(response_due, true) {
                    P::count(&mut self.counters.requests_merged);
                }
            }
            // The tool repeats its question. What another state wanted is gone with it.
            (
                Outgoing::CheckRequest
                | Outgoing::CheckResponse
                | Outgoing::WhoResponse
                | Outgoing::IdentifyResponse,
                _,
            ) => return,
        }
        self.timers.set_after_millis(Timer::BackOffOrIdentify, self.config.bus_off_back_off.into());
    }

    // In line, the function around it needs more registers than a Cortex-M0 has.
    #[inline(never)]
    pub(super) fn link<P: Extent>(&mut self, event: LinkEvent) {
        match event {
            LinkEvent::Up => self.up::<P>(),
            LinkEvent::Down if self.state != State::NonExistent => {
                self.enter::<P>(State::NonExistent, Cause::LinkDown);
            }
            LinkEvent::BusOff => self.bus_off::<P>(),
            LinkEvent::ModeSet(_) => self.queue_again(),
            LinkEvent::BusError(BusErrorKind::Ack) => self.not_acknowledged::<P>(),
            LinkEvent::Overrun { lost } => {
                if P::COUNTERS {
                    self.counters.frames_lost = self.counters.frames_lost.saturating_add(lost.max(1));
                }
                self.raise::<P>(Pending::FramesLost { count: lost.to_le_bytes() });
            }
            LinkEvent::Refused(kind) => self.refused::<P>(kind),
            // Without power already; or what the controller deals with by itself.
            LinkEvent::Down
            | LinkEvent::ErrorWarning
            | LinkEvent::ErrorPassive
            | LinkEvent::ErrorActive
            | LinkEvent::BusError(_)
            | LinkEvent::Counters { .. }
            | LinkEvent::FilterSet => {}
        }
    }

    fn up<P: Extent>(&mut self) {
        self.told = None;
        match &mut self.state {
            State::NonExistent => {
                if P::QUICK_CONNECT {
                    self.quick_connect.active = self.quick_connect.stored;
                }
                self.restart::<P>(Cause::LinkUp);
            }
            State::SendingDupMac { stage: stage @ SendStage::Restarting { .. }, .. } => {
                *stage = SendStage::Queued { unacknowledged: false };
            }
            State::SendingDupMac { .. } | State::OnLine { .. } => self.queue_again(),
            State::WaitingDupMac { .. } | State::CommFault { .. } => {}
        }
    }

    /// The controller is ready again for what it gave back.
    pub(super) fn queue_again(&mut self) {
        match &mut self.state {
            State::SendingDupMac { stage: stage @ SendStage::GivenBack, .. } => {
                *stage = SendStage::Queued { unacknowledged: false };
            }
            State::OnLine { .. } => {}
            State::NonExistent
            | State::SendingDupMac { .. }
            | State::WaitingDupMac { .. }
            | State::CommFault { .. } => return,
        }
        self.timers.clear(Timer::BackOffOrIdentify);
    }

    fn bus_off<P: Extent>(&mut self) {
        // Told twice, or told of a controller that the node does not use.
        if self.state.is_off_the_bus() || self.state == State::NonExistent {
            return;
        }
        self.bus_off_counter = self.bus_off_counter.saturating_add(1);
        let restarts = self.bus_off_interrupt
            && match self.state {
                State::OnLine { .. } => true,
                State::SendingDupMac { .. } | State::WaitingDupMac { .. } => {
                    P::CHOICES && self.config.bus_off_while_checking == BusOffWhileChecking::FollowInterrupt
                }
                State::NonExistent | State::CommFault { .. } => false,
            };
        if restarts {
            let next = State::SendingDupMac { request: CheckRequest::First, stage: SendStage::BackOff };
            self.enter::<P>(next, Cause::BusOffRestart);
        } else {
            self.enter::<P>(State::faulted(Fault::BusOff), Cause::BusOff);
        }
    }

    fn not_acknowledged<P: Extent>(&mut self) {
        if let State::SendingDupMac { stage: SendStage::Queued { unacknowledged }, .. } = &mut self.state {
            P::count_wide(&mut self.counters.unacknowledged);
            let first = !core::mem::replace(unacknowledged, true);
            self.stay(Cause::NotAcknowledged);
            if first {
                self.raise::<P>(Pending::NotAcknowledged);
            }
        }
    }

    fn refused<P: Extent>(&mut self, kind: LinkCommandKind) {
        P::count(&mut self.counters.refused);
        self.raise::<P>(Pending::LinkRefused(kind));
        let restarting =
            matches!(self.state, State::SendingDupMac { stage: SendStage::Restarting { .. }, .. });
        if restarting && kind == LinkCommandKind::Reset {
            self.enter::<P>(State::faulted(Fault::BusOff), Cause::BusOff);
        }
    }

    fn discard<P: Extent>(&mut self) {
        P::count_wide(&mut self.counters.discarded);
    }

    /// `kept`: whether what the frame said [was kept](super::pending::Events::hear).
    pub(super) fn bad_frame<P: Extent>(&mut self, kept: Result<(), Lost>) {
        P::count(&mut self.counters.bad_frames);
        self.raise_heard::<P>(kept, Pending::BadFrame);
    }

    /// An event that tells what the frame said.
    /// Keeps what a frame said for the events that tell of it.
    pub(super) fn hear<P: Extent>(&mut self, heard: impl FnOnce() -> Heard) -> Result<(), Lost> {
        if P::EVENTS { self.events.hear(heard()) } else { Ok(()) }
    }

    fn raise_heard<P: Extent>(&mut self, kept: Result<(), Lost>, event: Pending) {
        match kept {
            Ok(()) => self.raise::<P>(event),
            Err(Lost) => P::count(&mut self.counters.events_lost),
        }
    }
}
