//! What the machine does with what it hears: frames, answers to transmissions, link events.

use link_core::link::LinkCommandKind;
use link_core::{BusErrorKind, Frame, LinkEvent, Mode, TxOutcome, TxToken};

use super::config::Role;
use super::event::{AccessEvent, Outgoing, RoamRefusal};
use super::machine::{Access, Fate, InFlight, Timer};
use super::state::{Cause, Fault, HelloNumber, HelloStage, Restart, State};
use crate::counter::{count, count_wide};
use crate::id::{Direction, Identifier, Layout, OperationalAddress};
use crate::message::{Hello, MiniWho, Roam};

impl Access {
    pub(super) fn frame(&mut self, frame: &Frame) {
        match &mut self.state {
            State::DetectingBitRate { detector, .. } => {
                let step = detector.valid_frame();
                self.obey(step);
            }
            State::NonExistent | State::BusOff { .. } | State::Faulted { .. } => self.discard(),
            State::Hello { .. } | State::Standby { .. } | State::Online { .. } => self.listen(frame),
        }
    }

    fn listen(&mut self, frame: &Frame) {
        match Identifier::of_frame(frame).layout() {
            Layout::Hello { .. } if MiniWho::of_frame(frame).is_some() => self.mini_who(),
            Layout::Hello { source, .. } => match Hello::of_frame(frame) {
                Some(Ok(hello)) => self.hello(&hello),
                Some(Err(_)) if source == self.address => self.bad_frame(frame),
                // Of another address; or a remote frame that nobody defines.
                Some(Err(_)) | None => self.discard(),
            },
            Layout::Roam { .. } => match Roam::of_frame(frame) {
                Some(Ok(roam)) => self.roam(&roam),
                Some(Err(_)) => self.bad_frame(frame),
                // To another address than 127, or a remote frame.
                None => self.discard(),
            },
            // The business of other parts of the node.
            Layout::Connection { .. }
            | Layout::Connectionless { .. }
            | Layout::Explicit { .. }
            | Layout::Implicit { .. }
            | Layout::Standard { .. }
            | Layout::Reserved(_) => {
                if !matches!(self.state, State::Online { .. }) {
                    self.discard();
                }
            }
        }
    }

    fn hello(&mut self, hello: &Hello) {
        if hello.source != self.address {
            return;
        }
        if hello.device == self.config.device {
            count(&mut self.counters.own_identity);
            return self.raise(AccessEvent::OwnIdentity(*hello));
        }
        if self.address.is_none() {
            // Many have none.
            return;
        }
        match (hello.direction, &mut self.state) {
            (Direction::Request, State::Online { response_due }) => {
                if core::mem::replace(response_due, true) {
                    count(&mut self.counters.merged);
                }
                self.challenged(hello);
            }
            // Of two that join, the one with the lower identity keeps the address. It says so by its Hello *request*: a
            // response would drive away a third node that is on line with that address.
            (Direction::Request, State::Hello { answer_due, .. }) if self.config.device < hello.device => {
                // Even if its Hello is about to be sent: that one may be lost.
                if core::mem::replace(answer_due, true) {
                    count(&mut self.counters.merged);
                }
                self.challenged(hello);
            }
            (Direction::Request, State::Hello { .. }) => self.give_way(hello, Cause::HelloRequest),
            (Direction::Response, State::Hello { .. } | State::Online { .. }) => {
                self.give_way(hello, Cause::HelloResponse);
            }
            // It has no address there.
            (Direction::Request | Direction::Response, _) => {}
        }
    }

    fn challenged(&mut self, hello: &Hello) {
        count(&mut self.counters.challenges);
        self.stay(Cause::HelloRequest);
        self.raise(AccessEvent::Defended { against: hello.device });
    }

    fn give_way(&mut self, hello: &Hello, cause: Cause) {
        count(&mut self.counters.addresses_lost);
        self.raise(AccessEvent::AddressTaken { address: self.address, by: hello.device });
        self.address = OperationalAddress::NONE;
        let stage = match self.state {
            // The controller does not take part yet.
            State::Hello { stage: stage @ HelloStage::SettingMode { .. }, .. } => stage,
            _ => HelloStage::Queued { unacknowledged: false },
        };
        self.enter(State::Hello { number: HelloNumber::First, stage, answer_due: false }, cause);
    }

    fn mini_who(&mut self) {
        let State::Standby { hello_due } = &mut self.state else { return self.discard() };
        if core::mem::replace(hello_due, true) {
            count(&mut self.counters.merged);
        }
        count(&mut self.counters.mini_whos);
        self.stay(Cause::MiniWho);
    }

    fn roam(&mut self, roam: &Roam) {
        let requested = roam.requested;
        if roam.target != self.config.device {
            return count(&mut self.counters.roams_for_others);
        }
        let obeys = match self.state {
            State::Standby { .. } => true,
            State::Hello { stage, .. } => {
                let takes_part = !matches!(stage, HelloStage::SettingMode { .. });
                self.config.early_roam && self.address.is_none() && takes_part
            }
            State::NonExistent
            | State::DetectingBitRate { .. }
            | State::Online { .. }
            | State::BusOff { .. }
            | State::Faulted { .. } => false,
        };
        let refusal = match (requested.is_none(), obeys) {
            (true, _) => Some(RoamRefusal::NoAddress),
            (false, false) => Some(RoamRefusal::NotInStandby),
            (false, true) => None,
        };
        if let Some(why) = refusal {
            count(&mut self.counters.roams_refused);
            return self.raise(AccessEvent::RoamRefused { requested, why });
        }
        count(&mut self.counters.roams);
        self.raise(AccessEvent::AddressAssigned { address: requested });
        self.rejoin(requested, Cause::Roam);
    }

    pub(super) fn tx_done(&mut self, token: TxToken, outcome: TxOutcome) {
        let Some(InFlight { what, fate }) = self.in_flight.filter(|_| token == Self::TOKEN) else {
            return count(&mut self.counters.stray_tx_done);
        };
        self.in_flight = None;
        match (fate, outcome) {
            (Fate::Unwanted | Fate::Abandoned, _) => {}
            (Fate::Wanted, TxOutcome::Sent) => self.sent(what),
            (Fate::Wanted, TxOutcome::Withdrawn | TxOutcome::Dropped | TxOutcome::Unknown) => {
                self.given_back(what, outcome);
            }
        }
    }

    fn sent(&mut self, what: Outgoing) {
        match (what, &mut self.state) {
            (Outgoing::Hello, State::Hello { stage, .. }) => {
                *stage = HelloStage::Waiting;
                self.timers.set_after_millis(Timer::Wait, self.hello_wait.into());
            }
            (Outgoing::HelloResponse, State::Online { .. }) => {
                count(&mut self.counters.responses);
                self.begin_announcement_wait();
            }
            (Outgoing::Hello | Outgoing::HelloAgain | Outgoing::HelloResponse, _) => {}
        }
    }

    fn given_back(&mut self, what: Outgoing, outcome: TxOutcome) {
        count(&mut self.counters.not_sent);
        self.raise(AccessEvent::NotSent { what, outcome });
        match (what, &mut self.state) {
            (Outgoing::Hello, State::Hello { stage, .. }) => *stage = HelloStage::GivenBack,
            (Outgoing::HelloAgain, State::Hello { answer_due: due, .. })
            | (Outgoing::Hello, State::Standby { hello_due: due })
            // Without it the other node gets on line too: its second request is its last.
            | (Outgoing::HelloResponse, State::Online { response_due: due }) => *due = true,
            // What another state wanted is gone with it.
            (Outgoing::Hello | Outgoing::HelloAgain | Outgoing::HelloResponse, _) => return,
        }
        self.timers.set_after_millis(Timer::BackOff, self.config.bus_off_back_off.into());
    }

    pub(super) fn link(&mut self, event: LinkEvent) {
        match event {
            LinkEvent::Up => self.up(),
            LinkEvent::Down => self.down(),
            LinkEvent::BusOff => self.bus_off(),
            LinkEvent::ModeSet(mode) => self.mode_set(mode),
            LinkEvent::BusError(kind) => self.bus_error(kind),
            LinkEvent::Overrun { lost } => {
                self.counters.frames_lost = self.counters.frames_lost.saturating_add(lost.max(1));
                self.raise(AccessEvent::FramesLost { count: lost });
            }
            LinkEvent::Refused(kind) => self.refused(kind),
            // The controller deals with them by itself.
            LinkEvent::ErrorWarning
            | LinkEvent::ErrorPassive
            | LinkEvent::ErrorActive
            | LinkEvent::Counters { .. }
            | LinkEvent::FilterSet => {}
        }
    }

    fn up(&mut self) {
        self.told = None;
        match self.state {
            State::NonExistent => {
                self.restarts_left = self.config.bus_off_restarts;
                self.start(Cause::LinkUp);
            }
            State::BusOff { restart: Restart::Restarting { .. } } => self.start(Cause::Restarted),
            State::Hello { .. } | State::Standby { .. } | State::Online { .. } => self.queue_again(),
            // A controller that comes back by itself after bus-off: nobody asked for it.
            State::DetectingBitRate { .. } | State::BusOff { .. } | State::Faulted { .. } => {}
        }
    }

    fn down(&mut self) {
        if self.state == State::NonExistent {
            return;
        }
        if !self.config.keep_address {
            self.address = self.config.first_address();
        }
        self.enter(State::NonExistent, Cause::LinkDown);
    }

    fn bus_off(&mut self) {
        match self.state {
            // Told twice, or told of a controller that the node does not use.
            State::NonExistent | State::BusOff { .. } | State::Faulted { fault: Fault::Restart } => return,
            State::DetectingBitRate { .. }
            | State::Hello { .. }
            | State::Standby { .. }
            | State::Online { .. }
            | State::Faulted { fault: Fault::Mode } => {}
        }
        self.bus_off_counter = self.bus_off_counter.saturating_add(1);
        let restart = match self.restarts_left.checked_sub(1) {
            Some(left) if self.bus_off_interrupt => {
                self.restarts_left = left;
                Restart::BackOff
            }
            Some(_) | None => Restart::Never,
        };
        self.enter(State::BusOff { restart }, Cause::BusOff);
    }

    fn mode_set(&mut self, mode: Mode) {
        if let State::DetectingBitRate { detector, .. } = &mut self.state {
            let step = detector.mode_set(mode);
            return self.obey(step);
        }
        let active = self.active_mode();
        if let State::Hello { stage: stage @ HelloStage::SettingMode { .. }, .. } = &mut self.state {
            if Some(mode) == active {
                *stage = HelloStage::Queued { unacknowledged: false };
            }
            return;
        }
        self.queue_again();
    }

    fn bus_error(&mut self, kind: BusErrorKind) {
        match &mut self.state {
            State::DetectingBitRate { detector, .. } => {
                count_wide(&mut self.counters.detection_errors);
                let step = detector.error();
                self.obey(step);
            }
            State::Hello { stage: HelloStage::Queued { unacknowledged }, .. }
                if kind == BusErrorKind::Ack =>
            {
                count_wide(&mut self.counters.unacknowledged);
                if !core::mem::replace(unacknowledged, true) {
                    self.raise(AccessEvent::NotAcknowledged);
                }
            }
            State::NonExistent
            | State::Hello { .. }
            | State::Standby { .. }
            | State::Online { .. }
            | State::BusOff { .. }
            | State::Faulted { .. } => {}
        }
    }

    fn refused(&mut self, kind: LinkCommandKind) {
        count(&mut self.counters.refused);
        self.raise(AccessEvent::LinkRefused(kind));
        let takes_rate_of_link = self.takes_rate_of_link();
        let is_device = self.config.role == Role::Device;
        match (kind, &mut self.state) {
            (LinkCommandKind::SetMode, State::DetectingBitRate { detector, .. }) if takes_rate_of_link => {
                let step = detector.listen_at_rate_of_link();
                self.obey(step);
            }
            // A device was listening at that rate: what is refused is the end of listening.
            (
                LinkCommandKind::SetMode,
                State::Hello { stage: stage @ HelloStage::SettingMode { .. }, .. },
            ) if takes_rate_of_link && !is_device => {
                self.bit_rate = None;
                *stage = HelloStage::Queued { unacknowledged: false };
            }
            (
                LinkCommandKind::SetMode,
                State::DetectingBitRate { .. } | State::Hello { stage: HelloStage::SettingMode { .. }, .. },
            ) => self.enter(State::Faulted { fault: Fault::Mode }, Cause::Refused),
            (LinkCommandKind::Reset, State::BusOff { restart: Restart::Restarting { .. } }) => {
                self.enter(State::Faulted { fault: Fault::Restart }, Cause::Refused);
            }
            // Frames are sorted by their identifier anyhow; or nobody waits for it any more.
            (LinkCommandKind::SetMode | LinkCommandKind::SetFilter | LinkCommandKind::Reset, _) => {}
        }
    }

    fn discard(&mut self) {
        count_wide(&mut self.counters.discarded);
    }

    fn bad_frame(&mut self, frame: &Frame) {
        count(&mut self.counters.bad_frames);
        self.raise(AccessEvent::BadFrame(*frame));
    }
}
