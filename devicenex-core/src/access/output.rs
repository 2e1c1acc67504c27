//! What the machine sends. It follows from the state; there is no queue.

use link_core::{Action, Deadline, Frame, Instant, LinkCommand, Mode};

use super::event::{AccessEvent, Outgoing};
use super::machine::{Access, Fate, InFlight, Timer};
use super::state::{HelloStage, Restart, State};
use crate::id::Direction;
use crate::message::Hello;

impl Access {
    /// Whether there is anything to do.
    pub(crate) fn has_output(&self) -> bool {
        self.must_withdraw()
            || self.must_restart_controller()
            || self.mode_to_set().is_some()
            || self.must_set_filter()
            || !self.events.is_empty()
            || self.wanted().is_some()
    }

    /// Whether the port must be told another filter, which it counts as told then: the node has one of its own.
    pub(crate) fn take_filter_change(&mut self) -> bool {
        let must = self.must_set_filter();
        if must {
            self.told = Some(self.listening());
        }
        must
    }

    /// The present moment, for a node that hears of it by other ways than its inputs.
    pub(crate) fn advance(&mut self, now: Instant) {
        self.timers.advance(now);
    }

    /// The next wait that ends, whatever is to be done before.
    pub(crate) fn next_wait(&self) -> Option<Deadline> {
        self.timers.next()
    }

    /// All that [`poll`](link_core::Machine::poll) does but hand out frames.
    pub(crate) fn poll_except_transmit(&mut self) -> Option<Action<AccessEvent>> {
        if self.must_withdraw() {
            self.in_flight.as_mut()?.fate = Fate::Abandoned;
            return Some(Action::Withdraw(Self::TOKEN));
        }
        if let State::BusOff { restart: Restart::Restarting { commanded: commanded @ false } } =
            &mut self.state
        {
            *commanded = true;
            return Some(Action::Link(LinkCommand::Reset));
        }
        if let Some(mode) = self.mode_to_set() {
            if let State::DetectingBitRate { commanded, .. }
            | State::Hello { stage: HelloStage::SettingMode { commanded }, .. } = &mut self.state
            {
                *commanded = true;
            }
            return Some(Action::Link(LinkCommand::SetMode(mode)));
        }
        if self.must_set_filter() {
            self.told = Some(self.listening());
            return Some(Action::Link(LinkCommand::SetFilter(self.filter())));
        }
        self.events.pop().map(Action::Event)
    }

    /// The next frame, if one is to be handed out.
    pub(crate) fn transmit(&mut self) -> Option<Action<AccessEvent>> {
        let what = self.wanted()?;
        let frame = self.take(what)?;
        self.in_flight = Some(InFlight { what, fate: Fate::Wanted });
        Some(Action::Transmit(Self::TOKEN, frame))
    }

    fn must_withdraw(&self) -> bool {
        self.in_flight.is_some_and(|in_flight| in_flight.fate == Fate::Unwanted)
    }

    const fn must_restart_controller(&self) -> bool {
        matches!(self.state, State::BusOff { restart: Restart::Restarting { commanded: false } })
    }

    /// The mode that the controller must be told.
    fn mode_to_set(&self) -> Option<Mode> {
        match &self.state {
            State::DetectingBitRate { detector, commanded: false } => detector.mode(),
            State::Hello { stage: HelloStage::SettingMode { commanded: false }, .. } => self.active_mode(),
            State::NonExistent
            | State::DetectingBitRate { .. }
            | State::Hello { .. }
            | State::Standby { .. }
            | State::Online { .. }
            | State::BusOff { .. }
            | State::Faulted { .. } => None,
        }
    }

    fn must_set_filter(&self) -> bool {
        self.state != State::NonExistent && self.told != Some(self.listening())
    }

    /// The frame to send now. It follows from the state.
    fn wanted(&self) -> Option<Outgoing> {
        // What the controller gave back has to wait.
        if self.in_flight.is_some() || self.timers.at(Timer::BackOff).is_some() {
            return None;
        }
        match self.state {
            State::Hello { stage: HelloStage::Queued { .. }, .. } | State::Standby { hello_due: true } => {
                Some(Outgoing::Hello)
            }
            State::Hello { stage: HelloStage::Waiting, answer_due: true, .. } => Some(Outgoing::HelloAgain),
            State::Online { response_due: true } => Some(Outgoing::HelloResponse),
            State::NonExistent
            | State::DetectingBitRate { .. }
            | State::Hello { .. }
            | State::Standby { .. }
            | State::Online { .. }
            | State::BusOff { .. }
            | State::Faulted { .. } => None,
        }
    }

    /// Builds the frame, and notes that it needs not be sent again.
    fn take(&mut self, what: Outgoing) -> Option<Frame> {
        let direction = match what {
            Outgoing::Hello | Outgoing::HelloAgain => Direction::Request,
            Outgoing::HelloResponse => Direction::Response,
        };
        if let State::Hello { stage: HelloStage::Waiting, answer_due: due, .. }
        | State::Standby { hello_due: due }
        | State::Online { response_due: due } = &mut self.state
        {
            *due = false;
        }
        let (device, port) = (self.config.device, self.config.port);
        Hello { source: self.address, direction, device, port }.frame()
    }
}
