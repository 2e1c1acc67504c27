//! Watching what was made: the data of producers are heard, everything else is asked for its state.

use cip_core::code::InstanceId;
use link_core::Frame;

use super::event::PlannedEvent;
use super::machine::Manager;
use super::made::Stage;
use super::slot::{SlotTimer, Task};
use super::state::{Cause, DeviceState};
use crate::connection::ConnectionId;
use crate::counter::count;
use crate::id::{Identifier, OperationalAddress};

impl<const DEVICES: usize, const CONNECTIONS: usize> Manager<DEVICES, CONNECTIONS> {
    /// Data of a device.
    pub(super) fn data(&mut self, source: OperationalAddress, frame: &Frame) {
        let now = self.timers.now();
        let id = ConnectionId::from(Identifier::of_frame(frame));
        let Some(slot) = self.place(source).and_then(|place| self.slot(place)) else { return };
        for (_, plan, made) in slot.connections_mut() {
            if made.stage == Stage::Established && made.produces == Some(id) && plan.is_heard() {
                made.feed(now, core::time::Duration::ZERO);
            }
        }
    }

    /// Nothing was heard of a producer for four packet rates.
    pub(super) fn fell_silent(&mut self, place: usize, number: u8) {
        let Some(slot) = self.slot(place) else { return };
        let Some(made) = slot.made_mut(number) else { return };
        let instance = InstanceId(made.instance.unwrap_or_default());
        made.set(Stage::Idle);
        count(&mut self.counters.timed_out);
        self.tell(place, PlannedEvent::TimedOut(instance));
        self.retry_with(place, Some(number));
    }

    /// The device does not answer when it is asked for the state of a connection.
    pub(super) fn not_polled(&mut self, place: usize) {
        self.retry_with(place, None);
    }

    fn retry_with(&mut self, place: usize, number: Option<u8>) {
        let Some(slot) = self.slot(place) else { return };
        match slot.state {
            DeviceState::Connecting | DeviceState::Running => {
                slot.timed_out = number;
                self.enter(place, DeviceState::Retrying, Cause::TimedOut);
                self.advance_slot(place);
            }
            DeviceState::Idle
            | DeviceState::Probing
            | DeviceState::Missing
            | DeviceState::Found
            | DeviceState::Assigned
            | DeviceState::Joining
            | DeviceState::Retrying
            | DeviceState::Lost
            | DeviceState::Conflict => {}
        }
    }

    /// The connection that timed out is asked for again; or the device, whether it is there.
    pub(super) fn retry(&mut self, place: usize) {
        let number = self.slots.get(place).and_then(|slot| slot.timed_out);
        self.begin(place, number.map_or(Task::Alive, Task::Connect));
    }

    pub(super) fn begin_poll_wait(&mut self, place: usize) {
        let span = self.config.poll_interval;
        let Some(slot) = self.slot(place) else { return };
        slot.poll_due = false;
        if span != 0 && slot.timers.at(SlotTimer::Poll).is_none() {
            slot.timers.set_after_millis(SlotTimer::Poll, span.into());
        }
    }

    pub(super) fn poll_over(&mut self, place: usize) {
        if let Some(slot) = self.slot(place) {
            slot.poll_due = true;
        }
        self.advance_slot(place);
    }

    /// Asks for the state of the next connection that is not heard.
    pub(super) fn poll_next(&mut self, place: usize) {
        let Some(slot) = self.slot(place) else { return };
        slot.poll_due = false;
        let is_asked = |(number, plan, made): (u8, &super::PlannedConnection, &mut super::made::Made)| {
            let is_heard = plan.is_heard() && made.rate != Some(0);
            (made.stage == Stage::Established && !is_heard).then_some(number)
        };
        let polled = slot.polled;
        let first = slot.connections_mut().find_map(is_asked);
        let next = slot.connections_mut().filter(|(number, ..)| *number > polled).find_map(is_asked);
        let is_heard = slot.made.iter().any(|made| made.stage == Stage::Established);
        match next.or(first) {
            Some(number) => {
                slot.polled = number;
                self.begin(place, Task::Poll(number));
            }
            // What it produces shows that it is there.
            None if is_heard => self.begin_poll_wait(place),
            None => self.begin(place, Task::Alive),
        }
    }

    /// What a device says about a connection: its state, or that it does not have it.
    pub(super) fn polled(&mut self, place: usize, number: u8, value: Option<&[u8]>) {
        if value == Some(&[super::connect::ESTABLISHED]) {
            return self.begin_poll_wait(place);
        }
        let Some(slot) = self.slot(place) else { return };
        let Some(plan) = slot.planned(number) else { return };
        let Some(made) = slot.made_mut(number) else { return };
        let instance = InstanceId(made.instance.unwrap_or_default());
        match value {
            Some(_) => made.renew(&plan),
            None => made.gone(&plan),
        }
        let was_running = slot.state == DeviceState::Running;
        count(&mut self.counters.timed_out);
        self.tell(place, PlannedEvent::TimedOut(instance));
        if was_running {
            self.enter(place, DeviceState::Connecting, Cause::Disturbed);
        }
    }
}
