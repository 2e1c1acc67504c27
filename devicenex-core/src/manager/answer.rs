//! What a device answered, and what follows from it: connections that are granted, refused, there already.

use core::time::Duration;

use cip_core::client::Failure;
use cip_core::code::{GeneralStatus, InstanceId, ServiceCode};
use cip_core::message::Response;

use super::connect::Answer;
use super::database::Source;
use super::event::PlannedEvent;
use super::machine::Manager;
use super::made::{Setting, Stage};
use super::slot::{SlotTimer, Task};
use super::state::{Cause, DeviceState};
use crate::client::{Route, connection_response};
use crate::connection::{ConnectionId, GroupMessage};
use crate::counter::count;
use crate::id::OperationalAddress;
use crate::message::{ConnectionResponse, Granted, GroupSelect};

impl<const DEVICES: usize, const CONNECTIONS: usize> Manager<DEVICES, CONNECTIONS> {
    /// A device answered.
    pub(super) fn answered(&mut self, place: usize, task: Task, answer: Answer) {
        if self.slots.get(place).is_some_and(|slot| slot.state == DeviceState::Retrying)
            && is_alone(task, &answer)
        {
            // It is there: its connections are looked at.
            self.enter(place, DeviceState::Connecting, Cause::Answered);
            return self.advance_slot(place);
        }
        match task {
            Task::None => {}
            Task::Probe => self.probed(place, answer.as_deref().ok()),
            Task::Connect(number) => match answer {
                Ok(data) => self.granted(place, number, &data),
                Err(status) => self.refused(place, number, Some(status)),
            },
            Task::OpenExplicit(number) => self.opened(place, number, &answer),
            Task::Write(number, setting) => match answer {
                Ok(data) => self.written(place, number, setting, &data),
                Err(status) => self.refused(place, number, Some(status)),
            },
            Task::List(number) => self.listed(place, number, answer.as_deref().ok()),
            Task::Check(number, looked) => self.checked(place, number, looked, answer.as_deref().ok()),
            Task::Delete(number) => self.deleted(place, number),
            Task::Poll(number) => self.polled(place, number, answer.as_deref().ok()),
            Task::Alive => self.begin_poll_wait(place),
        }
        self.advance_slot(place);
    }

    fn granted(&mut self, place: usize, number: u8, data: &[u8]) {
        // Whatever it says, it is there.
        if self.slots.get(place).is_some_and(|slot| slot.state == DeviceState::Retrying) {
            self.enter(place, DeviceState::Connecting, Cause::Answered);
        }
        let Some(asked) = self.connection_request(place, number) else { return };
        let response = Response::Success { service: ServiceCode::ALLOCATE, data };
        let Some(granted) = connection_response(&asked, &response) else {
            return self.refused(place, number, None);
        };
        let Some(slot) = self.slot(place) else { return };
        let address = slot.address();
        let Some(plan) = slot.planned(number) else { return };
        let Some(made) = slot.made_mut(number) else { return };
        let (instance, rate) = match (granted.granted, asked.target) {
            (Granted::Predefined { expected_packet_rate }, Some(target)) => {
                (target.instance, expected_packet_rate)
            }
            (Granted::Dynamic { instance }, _) => (instance, plan.expected_packet_rate),
            (Granted::Predefined { .. }, None) => return self.refused(place, number, None),
        };
        made.instance = Some(instance.0);
        made.rate = Some(rate);
        made.due = plan.settings();
        made.produces =
            produced_id(&granted, address, instance).filter(|_| plan.is_heard() || plan.consumes.is_none());
        self.set_next(place, number);
    }

    /// What is to be set next; nothing more, and the connection is as planned.
    pub(super) fn set_next(&mut self, place: usize, number: u8) {
        let Some(made) = self.slot(place).and_then(|slot| slot.made_mut(number)) else { return };
        match made.due.first() {
            Some(setting) => made.set(Stage::Configuring(setting)),
            None => self.established(place, number),
        }
    }

    fn opened(&mut self, place: usize, number: u8, answer: &Answer) {
        let own = self.own();
        let Some(dynamic) = self.slots.get(place).map(|slot| slot.dynamic) else { return };
        let asked = self.explicit_request(dynamic);
        let Some(slot) = self.slot(place) else { return };
        // The next time it is again the other kind.
        slot.dynamic = false;
        let data = match answer {
            Ok(data) => data,
            Err(_) if !dynamic => {
                slot.dynamic = true;
                return;
            }
            Err(status) => return self.refused(place, number, Some(*status)),
        };
        let response = Response::Success { service: ServiceCode::ALLOCATE, data };
        slot.explicit = connection_response(&asked, &response)
            .and_then(|granted| Route::opened(own, slot.plan.address, &asked, &granted));
        if slot.explicit.is_none() {
            self.refused(place, number, None);
        }
    }

    fn written(&mut self, place: usize, number: u8, setting: Setting, data: &[u8]) {
        let Some(slot) = self.slot(place) else { return };
        slot.reopened = false;
        let Some(plan) = slot.planned(number) else { return };
        let Some(made) = slot.made_mut(number) else { return };
        // The response tells the rate that the device keeps.
        if let (Setting::PacketRate, &[low, high]) = (setting, data) {
            made.rate = Some(u16::from_le_bytes([low, high]));
        }
        made.due.remove(setting);
        let consumes = made.consumes;
        let source = plan.consumes.and_then(|source| self.source_id(source));
        if setting >= Setting::ConsumedId && source.is_some() && source != consumes {
            // Its producer has another connection meanwhile.
            return self.consumes_another(place, number, setting == Setting::PacketRate);
        }
        self.set_next(place, number);
    }

    /// A consumer is to be told another producer. A dynamic one takes that only while it is being configured.
    pub(super) fn consumes_another(&mut self, place: usize, number: u8, is_established: bool) {
        let Some(slot) = self.slot(place) else { return };
        let Some(plan) = slot.planned(number) else { return };
        let Some(made) = slot.made_mut(number) else { return };
        if is_established && plan.instance.is_none() {
            return made.renew(&plan);
        }
        made.due.insert(Setting::ConsumedId);
        self.set_next(place, number);
    }

    /// A dynamic connection is gone, or never was there.
    fn deleted(&mut self, place: usize, number: u8) {
        let Some(slot) = self.slot(place) else { return };
        let Some(plan) = slot.planned(number) else { return };
        if let Some(made) = slot.made_mut(number) {
            made.gone(&plan);
        }
    }

    /// A connection is as planned.
    pub(super) fn established(&mut self, place: usize, number: u8) {
        let now = self.timers.now();
        let Some(slot) = self.slot(place) else { return };
        let Some(plan) = slot.planned(number) else { return };
        let Some(made) = slot.made_mut(number) else { return };
        made.set(Stage::Established);
        if plan.is_heard() {
            made.feed(now, FIRST_MESSAGE);
        }
        let connected = PlannedEvent::Connected {
            instance: InstanceId(made.instance.unwrap_or_default()),
            produces: made.produces.filter(|_| plan.is_heard() || plan.consumes.is_none()),
            expected_packet_rate: made.rate.unwrap_or_default(),
        };
        let source = Source { address: slot.address(), connection: number };
        self.tell(place, connected);
        self.follow_producer(source);
    }

    /// A producer has a connection: those that consume it are told, or looked at.
    fn follow_producer(&mut self, source: Source) {
        let Some(id) = self.source_id(source) else { return };
        for place in 0..self.slots.len() {
            let Some(slot) = self.slot(place) else { return };
            let mut waits = false;
            let mut disturbed = false;
            for (_, plan, made) in slot.connections_mut().filter(|(_, plan, _)| plan.consumes == Some(source))
            {
                waits |= made.stage == Stage::Idle;
                if made.stage != Stage::Established {
                    continue;
                }
                if made.consumes != Some(id) && plan.instance.is_none() {
                    made.renew(plan);
                    disturbed = true;
                } else if made.consumes != Some(id) {
                    made.due.insert(Setting::ConsumedId);
                    made.set(Stage::Configuring(Setting::ConsumedId));
                    disturbed = true;
                } else if plan.expected_packet_rate != 0 {
                    // It may have timed out meanwhile.
                    made.set(Stage::Unknown);
                    disturbed = true;
                }
            }
            if disturbed && slot.state == DeviceState::Running {
                self.enter(place, DeviceState::Connecting, Cause::Disturbed);
            }
            if disturbed || waits {
                self.advance_slot(place);
            }
        }
    }

    /// A device refuses a connection: it is asked again later.
    pub(super) fn refused(&mut self, place: usize, number: u8, status: Option<GeneralStatus>) {
        let span = self.config.retry_wait;
        count(&mut self.counters.refused);
        let Some(slot) = self.slot(place) else { return };
        let Some(made) = slot.made_mut(number) else { return };
        let instance = made.instance.map(InstanceId);
        made.set(Stage::Refused(status));
        let instance = instance.or_else(|| slot.planned(number).and_then(|plan| plan.number()));
        if slot.timers.at(SlotTimer::Retry).is_none() {
            slot.timers.set_after_millis(SlotTimer::Retry, span);
        }
        self.tell(place, PlannedEvent::Refused { instance, status });
    }

    pub(super) fn retry_over(&mut self, place: usize) {
        let Some(slot) = self.slot(place) else { return };
        for (_, plan, made) in slot.connections_mut() {
            if matches!(made.stage, Stage::Refused(_)) {
                made.gone(plan);
            }
        }
        self.advance_slot(place);
    }

    pub(super) fn set_stage(&mut self, place: usize, number: u8, stage: Stage) {
        if let Some(made) = self.slot(place).and_then(|slot| slot.made_mut(number)) {
            made.set(stage);
        }
    }

    /// A transaction with a device came to nothing.
    pub(super) fn failed(&mut self, place: usize, task: Task, failure: Failure) {
        let silent = matches!(failure, Failure::NoResponse | Failure::NotAcknowledged);
        if !silent && self.slots.get(place).is_some_and(|slot| slot.state == DeviceState::Retrying) {
            // An answer that is of no use says as well that it is there.
            self.enter(place, DeviceState::Connecting, Cause::Answered);
        }
        let Some(slot) = self.slot(place) else { return };
        match task {
            Task::None => {}
            Task::Probe if silent && slot.probe == super::slot::Probe::default() => self.nobody(place),
            Task::Probe => self.conflict(place, None),
            // The explicit connection may have timed out.
            Task::Write(..) | Task::Delete(_) if silent && !slot.reopened => {
                slot.reopened = true;
                slot.explicit = None;
                self.advance_slot(place);
            }
            Task::Poll(_) if silent => self.not_polled(place),
            Task::Alive if silent && slot.state == DeviceState::Running => self.not_polled(place),
            Task::Connect(_) | Task::OpenExplicit(_) | Task::List(_) | Task::Check(..) | Task::Alive
                if silent =>
            {
                self.lost(place);
            }
            Task::Write(number, _) | Task::Delete(number) => {
                // The next attempt begins with an explicit connection of its own.
                slot.reopened = false;
                slot.explicit = None;
                self.refused(place, number, None);
                self.advance_slot(place);
            }
            Task::Connect(number) | Task::OpenExplicit(number) => {
                self.refused(place, number, None);
                self.advance_slot(place);
            }
            Task::List(number) | Task::Check(number, _) | Task::Poll(number) => {
                self.set_stage(place, number, Stage::Idle);
                self.advance_slot(place);
            }
            Task::Alive => {
                self.begin_poll_wait(place);
                self.advance_slot(place);
            }
        }
    }
}

/// Whether the answer of a device that had fallen silent says no more than that it is there.
fn is_alone(task: Task, answer: &Answer) -> bool {
    match task {
        Task::Connect(_) => answer.is_err(),
        Task::None
        | Task::Probe
        | Task::OpenExplicit(_)
        | Task::Write(..)
        | Task::List(_)
        | Task::Check(..)
        | Task::Delete(_)
        | Task::Poll(_)
        | Task::Alive => true,
    }
}

/// On what the device produces.
fn produced_id(
    granted: &ConnectionResponse,
    address: OperationalAddress,
    instance: InstanceId,
) -> Option<ConnectionId> {
    let at = GroupMessage::new(granted.group, granted.source_message).ok()?;
    (granted.group != GroupSelect::EXPLICIT_29).then(|| at.produced(address, instance).into())
}

/// A producer may take that long for its first message, however often it sends.
const FIRST_MESSAGE: Duration = Duration::from_secs(1);
