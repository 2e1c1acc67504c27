//! What the machine sends. It follows from the state; there is no queue.

use link_core::{Action, Frame, LinkCommand};

use super::event::{AccessEvent, Outgoing};
use super::extent::{Complete, Extent};
use super::machine::{Access, Fate, InFlight, Timer};
use super::state::{SecondRequest, SendStage, State, WhoAnswer};
use crate::id::Identifier;
use crate::message::{self, Direction, DuplicateMacCheck, IdentifyResponse, WhoResponse};

impl Access {
    /// Whether it has something to tell. A step to another state always is.
    #[inline]
    pub(crate) const fn has_news(&self) -> bool {
        !self.events.is_empty()
    }

    /// Whether there is anything to do. On line there mostly is not, and that is seen quickly.
    pub(crate) fn has_output(&self) -> bool {
        self.has_output_except_transmit::<Complete>() || self.wants_to_transmit::<Complete>()
    }

    pub(crate) fn has_output_except_transmit<P: Extent>(&self) -> bool {
        (P::EVENTS && self.has_news())
            || self.must_withdraw()
            || self.must_restart_controller()
            || self.must_set_filter::<P>()
    }

    pub(crate) fn wants_to_transmit<P: Extent>(&self) -> bool {
        self.wanted::<P>().is_some()
    }

    /// All that [`poll`](link_core::Machine::poll) does but hand out frames, so that a node can put others before them.
    /// `event`: what becomes of its events in those of the node.
    pub(crate) fn poll_except_transmit<P: Extent, E>(
        &mut self,
        event: impl FnOnce(AccessEvent) -> E,
    ) -> Option<Action<E>> {
        if let Some(action) = self.command() {
            return Some(action);
        }
        if self.take_filter_change::<P>() {
            return Some(Action::Link(LinkCommand::SetFilter(self.filter_within::<P>())));
        }
        self.news::<P>().map(|told| Action::Event(event(told)))
    }

    /// Withdraws its frame, or restarts the controller.
    pub(crate) fn command<E>(&mut self) -> Option<Action<E>> {
        if self.must_withdraw() {
            self.in_flight.as_mut()?.fate = Fate::Abandoned;
            return Some(Action::Withdraw(Self::TOKEN));
        }
        if let State::SendingDupMac {
            stage: SendStage::Restarting { commanded: commanded @ false }, ..
        } = &mut self.state
        {
            *commanded = true;
            return Some(Action::Link(LinkCommand::Reset));
        }
        None
    }

    /// The next event.
    pub(crate) fn news<P: Extent>(&mut self) -> Option<AccessEvent> {
        if P::EVENTS { self.events.pop() } else { None }
    }

    fn must_withdraw(&self) -> bool {
        self.in_flight.is_some_and(|in_flight| in_flight.fate == Fate::Unwanted)
    }

    const fn must_restart_controller(&self) -> bool {
        matches!(self.state, State::SendingDupMac { stage: SendStage::Restarting { commanded: false }, .. })
    }

    fn must_set_filter<P: Extent>(&self) -> bool {
        self.state != State::NonExistent && self.told != Some(self.listening::<P>())
    }

    /// Whether the port must be told the filter; from now on it has been.
    pub(crate) fn take_filter_change<P: Extent>(&mut self) -> bool {
        let change = self.must_set_filter::<P>();
        if change {
            self.told = Some(self.listening::<P>());
        }
        change
    }

    /// The frame to send now. It follows from the state.
    fn wanted<P: Extent>(&self) -> Option<Outgoing> {
        if self.in_flight.is_some() {
            return None;
        }
        match self.state {
            // What the controller gave back has to wait.
            State::OnLine { .. } if self.timers.at(Timer::BackOffOrIdentify).is_some() => None,
            State::SendingDupMac { stage: SendStage::Queued { .. }, .. } => Some(Outgoing::CheckRequest),
            State::OnLine { response_due: true, .. } => Some(Outgoing::CheckResponse),
            State::OnLine { second_request: SecondRequest::Queued, .. } if P::QUICK_CONNECT => {
                Some(Outgoing::CheckRequest)
            }
            State::CommFault { offline, .. } if P::OFFLINE_SET && offline.identify.is_some() => {
                Some(Outgoing::IdentifyResponse)
            }
            State::CommFault { offline, .. } if P::OFFLINE_SET && offline.who == WhoAnswer::Due => {
                Some(Outgoing::WhoResponse)
            }
            State::NonExistent
            | State::SendingDupMac { .. }
            | State::WaitingDupMac { .. }
            | State::OnLine { .. }
            | State::CommFault { .. } => None,
        }
    }

    /// The next frame, if one is to be handed out.
    pub(crate) fn transmit<P: Extent, E>(&mut self) -> Option<Action<E>> {
        let what = self.wanted::<P>()?;
        let frame = self.take::<P>(what)?;
        self.in_flight = Some(InFlight { what, fate: Fate::Wanted });
        Some(Action::Transmit(Self::TOKEN, frame))
    }

    /// Builds the frame, and notes that it needs not be sent again.
    fn take<P: Extent>(&mut self, what: Outgoing) -> Option<Frame> {
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
            (Outgoing::WhoResponse, State::CommFault { offline, .. }) if P::OFFLINE_SET => {
                offline.who = WhoAnswer::None;
                message::frame(answers, &WhoResponse { port, device })
            }
            (Outgoing::IdentifyResponse, State::CommFault { offline, .. }) if P::OFFLINE_SET => {
                let nodes = offline.identify.take()?;
                message::frame(answers, &IdentifyResponse { nodes })
            }
            (Outgoing::CheckResponse | Outgoing::WhoResponse | Outgoing::IdentifyResponse, _) => None,
        }
    }
}
