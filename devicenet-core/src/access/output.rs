//! What the machine sends. It follows from the state; there is no queue.

use link_core::{Action, Frame, LinkCommand};

use super::event::{AccessEvent, Outgoing};
use super::machine::{Access, Fate, InFlight, Timer};
use super::state::{SecondRequest, SendStage, State, WhoAnswer};
use crate::id::Identifier;
use crate::message::{self, Direction, DuplicateMacCheck, IdentifyResponse, WhoResponse};

impl Access {
    pub(crate) fn has_output(&self) -> bool {
        !self.events.is_empty()
            || self.must_withdraw()
            || self.must_restart_controller()
            || self.must_set_filter()
            || self.wanted().is_some()
    }

    fn must_withdraw(&self) -> bool {
        self.in_flight.is_some_and(|in_flight| in_flight.fate == Fate::Unwanted)
    }

    pub(super) fn withdraw(&mut self) -> Option<Action<AccessEvent>> {
        if !self.must_withdraw() {
            return None;
        }
        self.in_flight.as_mut()?.fate = Fate::Abandoned;
        Some(Action::Withdraw(Self::TOKEN))
    }

    const fn must_restart_controller(&self) -> bool {
        matches!(self.state, State::SendingDupMac { stage: SendStage::Restarting { commanded: false }, .. })
    }

    pub(super) fn restart_controller(&mut self) -> Option<Action<AccessEvent>> {
        let State::SendingDupMac { stage: SendStage::Restarting { commanded: commanded @ false }, .. } =
            &mut self.state
        else {
            return None;
        };
        *commanded = true;
        Some(Action::Link(LinkCommand::Reset))
    }

    fn must_set_filter(&self) -> bool {
        self.state != State::NonExistent && self.told != Some(self.listening())
    }

    pub(super) fn set_filter(&mut self) -> Option<Action<AccessEvent>> {
        if !self.must_set_filter() {
            return None;
        }
        self.told = Some(self.listening());
        Some(Action::Link(LinkCommand::SetFilter(self.filter())))
    }

    /// The frame to send now. It follows from the state.
    fn wanted(&self) -> Option<Outgoing> {
        if self.in_flight.is_some() {
            return None;
        }
        match self.state {
            // What the controller gave back has to wait.
            State::OnLine { .. } if self.timers.at(Timer::BackOff).is_some() => None,
            State::SendingDupMac { stage: SendStage::Queued { .. }, .. } => Some(Outgoing::CheckRequest),
            State::OnLine { response_due: true, .. } => Some(Outgoing::CheckResponse),
            State::OnLine { second_request: SecondRequest::Queued, .. } => Some(Outgoing::CheckRequest),
            State::CommFault { offline, .. } if offline.identify.is_some() => {
                Some(Outgoing::IdentifyResponse)
            }
            State::CommFault { offline, .. } if offline.who == WhoAnswer::Due => Some(Outgoing::WhoResponse),
            State::NonExistent
            | State::SendingDupMac { .. }
            | State::WaitingDupMac { .. }
            | State::OnLine { .. }
            | State::CommFault { .. } => None,
        }
    }

    /// The next frame, if one is to be handed out.
    pub(crate) fn transmit<const OFFLINE_SET: bool>(&mut self) -> Option<Action<AccessEvent>> {
        let what = self.wanted()?;
        let frame = self.take::<OFFLINE_SET>(what)?;
        self.in_flight = Some(InFlight { what, fate: Fate::Wanted });
        Some(Action::Transmit(Self::TOKEN, frame))
    }

    /// Builds the frame, and notes that it needs not be sent again.
    fn take<const OFFLINE_SET: bool>(&mut self, what: Outgoing) -> Option<Frame> {
        let (port, device) = (self.config.port, self.config.device);
        let own_check = Identifier::duplicate_mac_check(self.mac_id);
        let answers = Identifier::COMMUNICATION_FAULTED_RESPONSE;
        match (what, &mut self.state) {
            (Outgoing::CheckRequest, _) => {
                let direction = Direction::Request;
                message::frame(own_check, &DuplicateMacCheck { direction, port, device })
            }
            (Outgoing::CheckResponse, State::OnLine { response_due, .. }) => {
                *response_due = false;
                let direction = Direction::Response;
                message::frame(own_check, &DuplicateMacCheck { direction, port, device })
            }
            (Outgoing::WhoResponse, State::CommFault { offline, .. }) if OFFLINE_SET => {
                offline.who = WhoAnswer::None;
                message::frame(answers, &WhoResponse { port, device })
            }
            (Outgoing::IdentifyResponse, State::CommFault { offline, .. }) if OFFLINE_SET => {
                let nodes = offline.identify.take()?;
                message::frame(answers, &IdentifyResponse { nodes })
            }
            (Outgoing::CheckResponse | Outgoing::WhoResponse | Outgoing::IdentifyResponse, _) => None,
        }
    }
}
