//! Connections that are there already, or may be: found, compared with the plan, and made what they should be.
//!
//! | Read | If it is not as planned |
//! |---|---|
//! | state: established | it is asked for; a dynamic one that has timed out is deleted before that |
//! | produced connection ID | of another node: it is asked for; of another Message ID: told |
//! | consumed connection ID | told, and set |
//! | transport class and trigger, where it is planned | told, and set |
//! | watchdog action, where something is to be missed | told, and set |
//! | expected packet rate: the planned one, or that which the device kept when it was made | told, and set |
//!
//! A dynamic connection has a number that the manager may not know any more: those of the device are listed and looked at, until one
//! is that which is planned. What cannot be set on it is no reason to leave it: it is deleted and made anew.

use cip_core::code::InstanceId;
use cip_core::connection::{TransportClassTrigger, WatchdogAction};

use super::connect::{ESTABLISHED, TIMED_OUT};
use super::database::PlannedConnection;
use super::event::{Difference, PlannedEvent};
use super::machine::Manager;
use super::made::{Looked, Setting, Settings, Stage};
use super::slot::Task;
use crate::connection::{ConnectionId, GroupMessage};
use crate::id::{Identifier, Layout, OperationalAddress};

impl<const DEVICES: usize, const CONNECTIONS: usize> Manager<DEVICES, CONNECTIONS> {
    /// The connections that a device has, or that it does not tell.
    pub(super) fn listed(&mut self, place: usize, number: u8, value: Option<&[u8]>) {
        let Some(slot) = self.slot(place) else { return };
        match value {
            Some([count, numbers @ ..]) if usize::from(*count) == numbers.len() => slot.list(numbers),
            _ => slot.list(&[]),
        }
        self.next_candidate(place, number);
    }

    /// The next of the listed connections; after the last, a new one is made.
    fn next_candidate(&mut self, place: usize, number: u8) {
        let Some(slot) = self.slot(place) else { return };
        let Some(plan) = slot.planned(number) else { return };
        let candidate =
            slot.listed.as_mut().and_then(|listed| (!listed.is_empty()).then(|| listed.remove(0)));
        if candidate.is_none() {
            slot.listed = None;
        }
        let Some(made) = slot.made_mut(number) else { return };
        made.gone(&plan);
        if let Some(candidate) = candidate {
            made.instance = Some(candidate.into());
            made.set(Stage::Unknown);
        }
    }

    /// A connection that may be there was looked at.
    pub(super) fn checked(&mut self, place: usize, number: u8, looked: Looked, value: Option<&[u8]>) {
        let source = self.planned_source(place, number);
        let Some(slot) = self.slot(place) else { return };
        let (address, is_candidate) = (slot.address(), slot.listed.is_some());
        let Some(plan) = slot.planned(number) else { return };
        let Some(made) = slot.made_mut(number) else { return };
        let instance = InstanceId(made.instance.unwrap_or_default());
        let difference = match (looked, value) {
            (Looked::State, Some(&[ESTABLISHED])) => {
                made.due = Settings::default();
                None
            }
            // It will not go by itself.
            (Looked::State, Some(&[TIMED_OUT])) if plan.instance.is_none() => {
                made.due = Settings::default();
                made.due.insert(Setting::Trigger);
                None
            }
            (Looked::ProducedId, Some(&[a, b, c, d])) => {
                let id = ConnectionId::from(u32::from_le_bytes([a, b, c, d]));
                if !is_produced_by(id, address) {
                    return self.next_candidate(place, number);
                }
                made.produces = Some(id);
                let planned = GroupMessage::new(plan.group(), plan.message).ok();
                let planned = planned.map(|at| ConnectionId::from(at.produced(address, instance)));
                let planned = planned.filter(|planned| *planned != id);
                planned.map(|planned| Difference::Produces { planned, actual: id })
            }
            (Looked::ConsumedId, Some(&[a, b, c, d])) => {
                let actual = ConnectionId::from(u32::from_le_bytes([a, b, c, d]));
                made.consumes = Some(actual);
                if is_candidate && source != Some(actual) {
                    return self.next_candidate(place, number);
                }
                // What its producer produces on may become known in the meantime.
                None
            }
            (Looked::Trigger, Some(&[actual])) => {
                let actual = TransportClassTrigger(actual);
                let planned = plan.trigger.filter(|planned| *planned != actual);
                planned.map(|planned| Difference::Trigger { planned, actual })
            }
            (Looked::WatchdogAction, Some(&[actual])) => {
                let (planned, actual) = (plan.watchdog_action, WatchdogAction(actual));
                (planned != actual).then_some(Difference::WatchdogAction { planned, actual })
            }
            (Looked::PacketRate, Some(&[low, high])) => {
                let actual = u16::from_le_bytes([low, high]);
                // What it kept when it was made is as planned.
                let planned = made.rate.unwrap_or(plan.expected_packet_rate);
                made.rate = Some(actual);
                (planned != actual)
                    .then_some(Difference::PacketRate { planned: plan.expected_packet_rate, actual })
            }
            // A device that does not tell them cannot be told them.
            (Looked::Trigger | Looked::WatchdogAction, _) => None,
            // It is not there, or not as it should be.
            (Looked::State | Looked::ProducedId | Looked::ConsumedId | Looked::PacketRate, _) => {
                return self.next_candidate(place, number);
            }
        };
        if let Some(setting) = difference.as_ref().and_then(Difference::setting) {
            made.due.insert(setting);
        }
        if let Some(difference) = difference {
            self.tell(place, PlannedEvent::Differs { instance, difference });
        }
        match next_look(looked, &plan) {
            Some(looked) => self.begin(place, Task::Check(number, looked)),
            None => self.compared(place, number),
        }
    }

    /// What the connection is to consume, if it is known.
    fn planned_source(&self, place: usize, number: u8) -> Option<ConnectionId> {
        self.source_id(self.slots.get(place)?.planned(number)?.consumes?)
    }

    /// All was looked at.
    fn compared(&mut self, place: usize, number: u8) {
        let source = self.planned_source(place, number);
        let Some(slot) = self.slot(place) else { return };
        slot.listed = None;
        let Some(plan) = slot.planned(number) else { return };
        let Some(made) = slot.made_mut(number) else { return };
        if let (Some(planned), Some(actual)) = (source, made.consumes)
            && planned != actual
        {
            made.due.insert(Setting::ConsumedId);
            let instance = InstanceId(made.instance.unwrap_or_default());
            let difference = Difference::Consumes { planned, actual };
            self.tell(place, PlannedEvent::Differs { instance, difference });
        }
        let Some(made) = self.slot(place).and_then(|slot| slot.made_mut(number)) else { return };
        let is_made_once = matches!(made.due.first(), Some(Setting::Trigger | Setting::ConsumedId));
        if plan.instance.is_none() && is_made_once {
            return made.renew(&plan);
        }
        self.set_next(place, number);
    }
}

/// What is read after that.
fn next_look(looked: Looked, plan: &PlannedConnection) -> Option<Looked> {
    let trigger = plan.trigger.map(|_| Looked::Trigger);
    let is_missed = plan.consumes.is_some() && plan.expected_packet_rate != 0;
    let watchdog = is_missed.then_some(Looked::WatchdogAction);
    match looked {
        Looked::State if plan.consumes.is_some() => Some(Looked::ConsumedId),
        Looked::State => Some(Looked::ProducedId),
        Looked::ProducedId | Looked::ConsumedId => trigger.or(watchdog).or(Some(Looked::PacketRate)),
        Looked::Trigger => watchdog.or(Some(Looked::PacketRate)),
        Looked::WatchdogAction => Some(Looked::PacketRate),
        Looked::PacketRate => None,
    }
}

impl Difference {
    /// By what it is made as planned.
    const fn setting(&self) -> Option<Setting> {
        match self {
            Self::Produces { .. } => None,
            Self::Consumes { .. } => Some(Setting::ConsumedId),
            Self::Trigger { .. } => Some(Setting::Trigger),
            Self::WatchdogAction { .. } => Some(Setting::WatchdogAction),
            Self::PacketRate { .. } => Some(Setting::PacketRate),
        }
    }
}

/// Whether a connection ID is one on which a node can produce.
fn is_produced_by(id: ConnectionId, address: OperationalAddress) -> bool {
    match id.identifier().map(Identifier::layout) {
        Some(Layout::Implicit { source, acknowledge: false, .. } | Layout::Standard { source, .. }) => {
            source == address
        }
        Some(_) | None => false,
    }
}
