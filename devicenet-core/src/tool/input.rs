//! What a tool does with frames, events of the link, the fate of its frames, and time.

use core::time::Duration;

use link_core::{Frame, Instant, LinkEvent, TxOutcome};

use super::event::{Refusal, ToolEvent};
use super::machine::{OfflineTool, Outgoing, Timer};
use super::state::{Cause, Request, Sending, State, Task};
use crate::collision;
use crate::id::Identifier;
use crate::message::{CommunicationFaultedResponse, Direction, DuplicateMacCheck, OfflineOwnership, Wire};

impl OfflineTool {
    pub(super) fn frame(&mut self, frame: &Frame) {
        let Some(id) = Identifier::of_frame(frame) else { return };
        if !self.on_line {
            return;
        }
        match id {
            Identifier::OFFLINE_OWNERSHIP_REQUEST => self.ownership_request(frame.data()),
            Identifier::OFFLINE_OWNERSHIP_RESPONSE => self.ownership_response(),
            Identifier::COMMUNICATION_FAULTED_RESPONSE => self.answer(frame.data()),
            _ => self.check(id, frame.data()),
        }
    }

    /// The owner answers; so does a tool whose own first request was on the bus before: of two that claim at once, the
    /// bus decides.
    fn ownership_request(&mut self, data: &[u8]) {
        let other = OfflineOwnership::parse(data).ok().filter(|other| other.direction == Direction::Request);
        if other.is_none() {
            return self.bad_frame();
        }
        let defends = match self.state {
            State::Idle | State::Claiming { request: Request::First, sending: Sending::Due } => false,
            State::Claiming { request: Request::First, sending } => sending == Sending::Sent,
            State::Claiming { request: Request::Second, .. } | State::Owner { .. } => true,
        };
        if defends {
            self.response_due = true;
            self.counters.defended = self.counters.defended.saturating_add(1);
            self.raise(ToolEvent::Defended { by: other.map(|other| other.device) });
        }
    }

    /// Whatever it says: somebody else thinks that the set is his.
    fn ownership_response(&mut self) {
        match self.state {
            State::Idle => self.ignore(),
            State::Claiming { .. } | State::Owner { .. } => self.enter(State::Idle, Cause::OwnedByAnother),
        }
    }

    fn answer(&mut self, data: &[u8]) {
        let State::Owner { task, .. } = self.state else { return self.ignore() };
        let Ok(answer) = CommunicationFaultedResponse::parse(data) else { return self.bad_frame() };
        match (answer, task) {
            (CommunicationFaultedResponse::Who(answer), Task::Who(_)) => {
                self.found = self.found.saturating_add(1);
                self.counters.answers = self.counters.answers.saturating_add(1);
                self.raise(ToolEvent::Found(answer));
            }
            (CommunicationFaultedResponse::Identify(answer), Task::Identify(_) | Task::IdentifyDevice(_)) => {
                self.found = self.found.saturating_add(1);
                self.counters.answers = self.counters.answers.saturating_add(1);
                self.raise(ToolEvent::Identified(answer.nodes));
            }
            (CommunicationFaultedResponse::Who(_) | CommunicationFaultedResponse::Identify(_), _) => {
                self.ignore()
            }
        }
    }

    /// The device that was given a MAC ID checks it, twice, and is on line a second later; unless somebody objects.
    fn check(&mut self, id: Identifier, data: &[u8]) {
        let State::Owner { task: Task::ChangeMacId { device, mac, checks }, .. } = &mut self.state else {
            return;
        };
        if id != Identifier::duplicate_mac_check(*mac) {
            return;
        }
        let Ok(check) = DuplicateMacCheck::parse(data) else { return };
        let (device, mac) = (*device, *mac);
        match check.direction {
            Direction::Request if check.device == device => {
                *checks = checks.saturating_add(1);
                let request = *checks;
                self.timers.set_after(Timer::Answers, AFTER_CHECK);
                self.raise(ToolEvent::Checking { device, mac, request });
            }
            Direction::Response if check.device != device => {
                self.turn_to(Task::None);
                self.raise(ToolEvent::NotRecovered { device, mac, why: Refusal::Taken });
            }
            Direction::Request | Direction::Response => {}
        }
    }

    pub(super) fn link(&mut self, event: LinkEvent) {
        match event {
            // The controller repeats a frame by itself; two that repeat the same identifier with other data never end.
            LinkEvent::BusError(_)
                if collision::is_collision(event) && self.in_flight == Some(Outgoing::Message) =>
            {
                self.in_flight = Some(Outgoing::BackedOff);
                self.withdraw = true;
                self.back_off(collision::pause(self.access.mac_id(), self.counters.collisions));
                self.counters.collisions = self.counters.collisions.saturating_add(1);
                self.raise(ToolEvent::Collision);
            }
            LinkEvent::Up => self.filter_due = true,
            LinkEvent::Down
            | LinkEvent::BusOff
            | LinkEvent::ErrorWarning
            | LinkEvent::ErrorPassive
            | LinkEvent::ErrorActive
            | LinkEvent::BusError(_)
            | LinkEvent::Counters { .. }
            | LinkEvent::Overrun { .. }
            | LinkEvent::ModeSet(_)
            | LinkEvent::FilterSet
            | LinkEvent::Refused(_) => {}
        }
    }

    /// The message is due again after `pause`.
    fn back_off(&mut self, pause: Duration) {
        if let Some(sending) = self.state.sending_mut() {
            *sending = Sending::BackingOff;
            self.timers.set_after(Timer::Answers, pause);
        }
    }

    pub(super) fn tx_done(&mut self, outcome: TxOutcome) {
        let Some(what) = self.in_flight.take() else {
            self.counters.stray_tx_done = self.counters.stray_tx_done.saturating_add(1);
            return;
        };
        self.withdraw = false;
        match (what, outcome) {
            (Outgoing::Abandoned, _) | (Outgoing::OwnershipResponse, TxOutcome::Sent) => {}
            (Outgoing::Message | Outgoing::BackedOff, TxOutcome::Sent) => self.message_sent(),
            (Outgoing::BackedOff, TxOutcome::Withdrawn | TxOutcome::Dropped | TxOutcome::Unknown) => {}
            // A set that nobody was asked for would have two owners.
            (Outgoing::Message, TxOutcome::Withdrawn | TxOutcome::Dropped | TxOutcome::Unknown) => {
                self.counters.not_sent = self.counters.not_sent.saturating_add(1);
                self.back_off(GIVEN_BACK);
            }
            // The other tool asks a second time.
            (Outgoing::OwnershipResponse, TxOutcome::Withdrawn | TxOutcome::Dropped | TxOutcome::Unknown) => {
                self.counters.not_sent = self.counters.not_sent.saturating_add(1);
            }
        }
    }

    fn message_sent(&mut self) {
        let wait = self.wait();
        // Its consequences may have been heard already.
        if let Some(sending @ (Sending::HandedOut | Sending::BackingOff | Sending::Due)) =
            self.state.sending_mut()
        {
            *sending = Sending::Sent;
            self.timers.set_after(Timer::Answers, wait);
        }
    }

    /// How long the consequences of the present message may take.
    fn wait(&self) -> Duration {
        match self.state {
            State::Idle | State::Claiming { .. } => self.config.ownership_wait,
            State::Owner { task, .. } => match task {
                Task::None | Task::Who(_) => self.config.who_wait,
                Task::Identify(_) | Task::IdentifyDevice(_) => self.config.identify_wait,
                Task::ChangeMacId { .. } => self.config.change_wait,
            },
        }
    }

    pub(super) fn expire(&mut self, until: Instant) {
        while self.timers.take_expired(until).is_some() {
            self.wait_over();
        }
    }

    fn wait_over(&mut self) {
        match self.state {
            State::Idle => {}
            State::Claiming { sending: Sending::Sent, request: Request::First } => {
                let next = State::Claiming { request: Request::Second, sending: Sending::Due };
                self.enter(next, Cause::WaitOver);
            }
            State::Claiming { sending: Sending::Sent, request: Request::Second } => {
                self.enter(State::Owner { task: Task::None, sending: Sending::Sent }, Cause::Unanswered);
            }
            State::Owner { task, sending: Sending::Sent } => self.task_over(task),
            State::Claiming { .. } | State::Owner { .. } => {
                if let Some(sending @ Sending::BackingOff) = self.state.sending_mut() {
                    *sending = Sending::Due;
                }
            }
        }
    }

    fn task_over(&mut self, task: Task) {
        let found = self.found;
        self.turn_to(Task::None);
        match task {
            Task::None => {}
            Task::Who(_) => self.raise(ToolEvent::WhoDone { found }),
            Task::Identify(_) | Task::IdentifyDevice(_) => {
                self.raise(ToolEvent::IdentifyDone { answered: found != 0 });
            }
            Task::ChangeMacId { device, mac, checks: 2.. } => {
                self.raise(ToolEvent::Recovered { device, mac });
            }
            Task::ChangeMacId { device, mac, .. } => {
                self.raise(ToolEvent::NotRecovered { device, mac, why: Refusal::Silent });
            }
        }
    }

    fn bad_frame(&mut self) {
        self.ignore();
        self.raise(ToolEvent::BadFrame);
    }

    fn ignore(&mut self) {
        self.counters.ignored = self.counters.ignored.saturating_add(1);
    }
}

/// From a check request to the next, or to the moment at which its sender is on line, and a little more.
const AFTER_CHECK: Duration = Duration::from_millis(1500);
/// Before what the controller gave back is handed out again.
const GIVEN_BACK: Duration = Duration::from_millis(100);
