//! What the manager sends, and what it does with the answers to that.

use cip_core::client::Progress;
use cip_core::message::Response;
use heapless::Vec;
use link_core::{Action, Frame, TxOutcome, TxToken};

use super::connect::Answer;
use super::event::ManagerEvent;
use super::lanes::{ADDRESSES, Carried, REQUESTS};
use super::machine::Manager;
use super::slot::Task;
use super::state::DeviceState;
use crate::counter::{count, count_wide};
use crate::id::OperationalAddress;
use crate::message::{MiniWho, Roam};

impl<const DEVICES: usize, const CONNECTIONS: usize> Manager<DEVICES, CONNECTIONS> {
    pub(super) fn has_output(&self) -> bool {
        self.lanes.must_withdraw()
            || !self.events.is_empty()
            || (self.access().is_online() && (self.address_due().is_some() || self.request_due().is_some()))
    }

    pub(super) fn transmit(&mut self) -> Option<Action<ManagerEvent>> {
        if !self.access().is_online() {
            return None;
        }
        self.next_address().or_else(|| self.next_request())
    }

    /// A Mini-who, or the ROAM whose turn it is.
    fn address_due(&self) -> Option<Carried> {
        if self.lanes.addresses.carries.is_some() {
            return None;
        }
        if self.mini_who_due {
            return Some(Carried::MiniWho);
        }
        let mut turns = self.turns(self.lanes.roam_turn);
        turns.find_map(|place| {
            let slot = self.slots.get(place)?;
            (slot.roam_due && slot.state == DeviceState::Found).then(|| Carried::Roam(slot.address()))
        })
    }

    fn next_address(&mut self) -> Option<Action<ManagerEvent>> {
        let carried = self.address_due()?;
        let frame = match carried {
            Carried::Roam(address) => {
                let place = self.place(address)?;
                self.lanes.roam_turn = place.saturating_add(1);
                let slot = self.slot(place)?;
                slot.roam_due = false;
                Roam { target: slot.device?, requested: address }.frame()?
            }
            Carried::MiniWho | Carried::Request(_) | Carried::Talk | Carried::Abandoned => {
                self.mini_who_due = false;
                MiniWho { serial_low: self.access().config().device.serial_low() }.frame()?
            }
        };
        self.lanes.addresses.carries = Some(carried);
        Some(Action::Transmit(ADDRESSES, frame))
    }

    /// The application's request after that of the last device.
    fn request_due(&self) -> Option<Carried> {
        if self.lanes.requests.carries.is_some() {
            return None;
        }
        let mut turns = self.turns(self.lanes.request_turn);
        let due = turns.find_map(|place| {
            let slot = self.slots.get(place)?;
            slot.conversation.has_output().then(|| Carried::Request(slot.address()))
        });
        due.or_else(|| self.talk.conversation.has_output().then_some(Carried::Talk))
    }

    fn next_request(&mut self) -> Option<Action<ManagerEvent>> {
        let carried = self.request_due()?;
        let frame = match carried {
            Carried::Request(address) => {
                let place = self.place(address)?;
                self.lanes.request_turn = place.saturating_add(1);
                self.slot(place)?.conversation.poll()?
            }
            Carried::Talk | Carried::MiniWho | Carried::Roam(_) | Carried::Abandoned => {
                self.talk.conversation.poll()?
            }
        };
        self.lanes.requests.carries = Some(carried);
        Some(Action::Transmit(REQUESTS, frame))
    }

    /// All places, beginning with one.
    fn turns(&self, first: usize) -> impl Iterator<Item = usize> {
        (first..self.slots.len()).chain(0..first.min(self.slots.len()))
    }

    pub(super) fn tx_done(&mut self, token: TxToken, outcome: TxOutcome) {
        let carried = self.lanes.lane(token).and_then(super::lanes::Lane::take);
        match carried {
            None => count(&mut self.counters.stray_tx_done),
            Some(Carried::Abandoned) => {}
            Some(Carried::MiniWho) => self.mini_who_done(outcome),
            Some(Carried::Roam(address)) => self.roam_done(address, outcome),
            Some(Carried::Request(address)) => self.request_done(address, outcome),
            Some(Carried::Talk) => {
                let wanted = !self.talk.conversation.is_cancelled();
                self.talk.conversation.tx_done(outcome);
                self.keep_talk_time();
                self.count_unsent(outcome, wanted);
            }
        }
    }

    /// The conversation repeats it when its wait is over.
    fn count_unsent(&mut self, outcome: TxOutcome, wanted: bool) {
        if wanted && outcome != TxOutcome::Sent {
            count(&mut self.counters.not_sent);
        }
    }

    fn request_done(&mut self, address: OperationalAddress, outcome: TxOutcome) {
        let Some(slot) = self.place(address).and_then(|place| self.slot(place)) else { return };
        let wanted = !slot.conversation.is_cancelled();
        slot.conversation.tx_done(outcome);
        slot.keep_time();
        self.count_unsent(outcome, wanted);
    }

    /// An answer of a device to the manager.
    pub(super) fn answer(&mut self, source: OperationalAddress, frame: &Frame) {
        if let Some(place) = self.place(source)
            && self.answer_of_slot(place, frame)
        {
            return;
        }
        if !self.answer_of_talk(frame) {
            count_wide(&mut self.counters.ignored);
        }
    }

    /// Whether it is an answer to what the manager asked a planned device.
    fn answer_of_slot(&mut self, place: usize, frame: &Frame) -> bool {
        let Some(slot) = self.slot(place) else { return false };
        let answer: Result<Answer, _> = match slot.conversation.frame(frame) {
            Progress::NotMine | Progress::Ignored(_) => return false,
            Progress::Pending => {
                slot.keep_time();
                return true;
            }
            Progress::Response(Response::Success { data, .. }) => {
                Ok(Ok(Vec::from_slice(data).unwrap_or_default()))
            }
            Progress::Response(Response::Error { status, .. }) => Ok(Err(status)),
            Progress::Failed(failure) => Err(failure),
        };
        slot.keep_time();
        let task = core::mem::replace(&mut slot.task, Task::None);
        match answer {
            Ok(answer) => self.answered(place, task, answer),
            Err(failure) => self.failed(place, task, failure),
        }
        true
    }

    /// No answer came in time.
    pub(super) fn conversation_over(&mut self, place: usize) {
        let Some(slot) = self.slot(place) else { return };
        let failure = slot.conversation.timer_expired();
        slot.keep_time();
        if let Some(failure) = failure {
            let task = core::mem::replace(&mut slot.task, Task::None);
            self.failed(place, task, failure);
        }
    }
}
