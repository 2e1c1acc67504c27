//! Making the connections of a device: the producers first, then the consumers, each told the producer's connection ID.
//!
//! What is to be done next follows from how far each connection is; one transaction at a time for each device, and all
//! devices at once.
//!
//! ```text
//!           request             granted                      settings
//! +------+ -------> (refused) ---------> +-------------+ -------------> +-------------+
//! | Idle |                               | Configuring |                | Established |
//! +------+ ----------------------------------------------------------->+-------------+
//!     ^                  granted, and nothing to set                          |
//!     |  not there  +---------+      the device may have been restarted       |
//!     +-------------| Unknown |<----------------------------------------------+
//!                   +---------+ ------> as planned: Established
//!                       |       ------> not as planned: Configuring, what differs is set
//!     +--------+        | a dynamic one that cannot be made what it should be
//!     | Ending |<-------+
//!     +--------+ deleted ------> Idle
//! ```

use cip_core::code::{AttributeId, ClassId, GeneralStatus, InstanceId, ServiceCode};
use cip_core::message::{AttributeRequest, Request};
use heapless::Vec;

use super::database::Source;
use super::machine::Manager;
use super::made::{Looked, Setting, Stage};
use super::slot::Task;
use super::state::{Cause, DeviceState};
use crate::client::{Route, explicit_request};
use crate::connection::ConnectionId;
use crate::message::{ConnectionRequest, Target};

/// What a device said: the data of its response, or why it refuses.
pub(super) type Answer = Result<Vec<u8, 16>, GeneralStatus>;

impl<const DEVICES: usize, const CONNECTIONS: usize> Manager<DEVICES, CONNECTIONS> {
    /// Begins the next transaction with a device, if there is anything to say.
    pub(super) fn advance_slot(&mut self, place: usize) {
        let Some(slot) = self.slots.get(place) else { return };
        if slot.task != Task::None || self.talk.is_with(slot.address()) {
            return;
        }
        match slot.state {
            DeviceState::Probing => self.probe_next(place),
            DeviceState::Connecting => self.connect_next(place),
            DeviceState::Running if slot.poll_due => self.poll_next(place),
            DeviceState::Retrying => self.retry(place),
            DeviceState::Running
            | DeviceState::Idle
            | DeviceState::Missing
            | DeviceState::Found
            | DeviceState::Assigned
            | DeviceState::Joining
            | DeviceState::Lost
            | DeviceState::Conflict => {}
        }
    }

    fn connect_next(&mut self, place: usize) {
        let Some(slot) = self.slots.get(place) else { return };
        let planned = (0_u8..).zip(slot.plan.connections.iter().zip(&slot.made));
        let producers = planned.clone().filter(|(_, (plan, _))| plan.consumes.is_none());
        let consumers = planned.filter(|(_, (plan, _))| plan.consumes.is_some());
        let task = producers.chain(consumers).find_map(|(number, (plan, made))| {
            let is_configured = plan.settings().first().is_some();
            let waits = plan.consumes.is_some_and(|source| self.source_id(source).is_none());
            let needs_explicit = slot.explicit.is_none().then_some(Task::OpenExplicit(number));
            match made.stage {
                Stage::Unknown if made.instance.is_some() => Some(Task::Check(number, Looked::State)),
                Stage::Unknown | Stage::Idle if waits => None,
                Stage::Unknown => Some(Task::List(number)),
                Stage::Idle if is_configured => needs_explicit.or(Some(Task::Connect(number))),
                Stage::Idle => Some(Task::Connect(number)),
                Stage::Configuring(setting) => needs_explicit.or(Some(Task::Write(number, setting))),
                Stage::Ending => needs_explicit.or(Some(Task::Delete(number))),
                Stage::Established | Stage::Refused(_) => None,
            }
        });
        match task {
            Some(task) => self.begin(place, task),
            None if slot.is_complete() => {
                self.enter(place, DeviceState::Running, Cause::Connected);
                if let Some(slot) = self.slot(place) {
                    slot.explicit = None;
                }
                self.begin_poll_wait(place);
            }
            // Something is missing that the manager cannot get now.
            None if slot.poll_due => self.poll_next(place),
            None => self.begin_poll_wait(place),
        }
    }

    /// What a device is to consume, once its producer has a connection.
    pub(super) fn source_id(&self, source: Source) -> Option<ConnectionId> {
        let made = self.slots.get(self.place(source.address)?)?.made(source.connection)?;
        if made.stage == Stage::Established { made.produces } else { None }
    }

    /// Begins a transaction about a connection.
    pub(super) fn begin(&mut self, place: usize, task: Task) {
        let Some(slot) = self.slots.get(place) else { return };
        let instance = |number| slot.made(number).and_then(|made| made.instance);
        match task {
            Task::None | Task::Probe => {}
            Task::Connect(number) => self.ask_for(place, number),
            Task::OpenExplicit(_) => {
                let asked = self.explicit_request(slot.dynamic);
                self.ask_for_connection(place, task, &asked);
            }
            Task::Write(number, setting) => self.write(place, number, setting),
            Task::List(_) => self.read(place, task, (LINK, 1, INSTANCES)),
            Task::Delete(number) => self.delete(place, number),
            Task::Check(number, looked) => match instance(number) {
                Some(instance) => self.read(place, task, (CONNECTION, instance, looked.attribute())),
                None => self.set_stage(place, number, Stage::Idle),
            },
            Task::Poll(number) => match instance(number) {
                Some(instance) => self.read(place, task, (CONNECTION, instance, Looked::State.attribute())),
                None => self.set_stage(place, number, Stage::Idle),
            },
            Task::Alive => self.read(place, task, (LINK, 1, ADDRESS)),
        }
    }

    /// The explicit connection of the predefined set; or a dynamic one, if another client has that.
    pub(super) fn explicit_request(&self, dynamic: bool) -> ConnectionRequest {
        let predefined = explicit_request(self.config.message, EXPLICIT_RATE);
        if dynamic { ConnectionRequest { predefined: false, target: None, ..predefined } } else { predefined }
    }

    /// What is asked for; the same for the answer to be read by.
    pub(super) fn connection_request(&self, place: usize, number: u8) -> Option<ConnectionRequest> {
        let plan = self.slots.get(place)?.planned(number)?;
        let target = plan.number().map(|instance| Target {
            instance,
            expected_packet_rate: plan.expected_packet_rate,
            watchdog_action: plan.watchdog_action,
        });
        let (group, source_message) = (plan.group(), plan.message);
        Some(ConnectionRequest { predefined: target.is_some(), group, source_message, target })
    }

    fn ask_for(&mut self, place: usize, number: u8) {
        if let Some(asked) = self.connection_request(place, number) {
            self.ask_for_connection(place, Task::Connect(number), &asked);
        }
    }

    fn ask_for_connection(&mut self, place: usize, task: Task, asked: &ConnectionRequest) {
        let (own, waits, tries) = (self.own(), self.config.waits, self.config.connect_tries);
        let Some(slot) = self.slot(place) else { return };
        slot.conversation.reroute(Route::connection(own, slot.plan.address), waits);
        let started = slot.conversation.start_message(asked, tries);
        debug_assert_eq!(started, Ok(()));
        slot.task = task;
        slot.keep_time();
    }

    /// Reads an attribute without a connection.
    pub(super) fn read(&mut self, place: usize, task: Task, (class, instance, attribute): (u16, u16, u8)) {
        let (own, waits) = (self.own(), self.config.waits);
        let tries = match task {
            // A device that is there answers; and one that does not is asked once more before it counts as lost.
            Task::Probe | Task::Poll(_) => 1,
            Task::None
            | Task::Connect(_)
            | Task::OpenExplicit(_)
            | Task::Write(..)
            | Task::List(_)
            | Task::Check(..)
            | Task::Delete(_)
            | Task::Alive => self.config.connect_tries,
        };
        let Some(slot) = self.slot(place) else { return };
        slot.conversation.reroute(Route::connectionless(own, slot.plan.address), waits);
        let request =
            AttributeRequest::get(ClassId(class), InstanceId(instance), AttributeId(attribute.into()));
        let started = slot.conversation.start_attribute(&request, tries);
        debug_assert_eq!(started, Ok(()));
        slot.task = task;
        slot.keep_time();
    }

    fn write(&mut self, place: usize, number: u8, setting: Setting) {
        let waits = self.config.waits;
        let planned = self.slots.get(place).and_then(|slot| slot.planned(number));
        let source = planned.and_then(|plan| plan.consumes).and_then(|source| self.source_id(source));
        let (Some(plan), Some(slot)) = (planned, self.slot(place)) else { return };
        let Some(instance) = slot.made(number).and_then(|made| made.instance) else { return };
        let mut value = Vec::<u8, 4>::new();
        let fits = match (setting, source) {
            (Setting::ConsumedId, Some(id)) => value.extend_from_slice(&u32::from(id).to_le_bytes()),
            // Its producer was lost in the meantime: it begins again when that is back, and the others go on.
            (Setting::ConsumedId, None) => {
                self.set_stage(place, number, Stage::Idle);
                return self.advance_slot(place);
            }
            (Setting::Trigger, _) => value.extend_from_slice(&[plan.trigger.map_or(0, |trigger| trigger.0)]),
            (Setting::WatchdogAction, _) => value.extend_from_slice(&[plan.watchdog_action.0]),
            (Setting::PacketRate, _) => value.extend_from_slice(&plan.expected_packet_rate.to_le_bytes()),
        };
        debug_assert!(fits.is_ok());
        let Some(route) = slot.explicit else { return };
        if let (Setting::ConsumedId, Some(made)) = (setting, slot.made_mut(number)) {
            made.consumes = source;
        }
        slot.conversation.reroute(route, waits);
        let attribute = AttributeId(setting.attribute().into());
        let request = AttributeRequest::set(ClassId(CONNECTION), InstanceId(instance), attribute, &value);
        if slot.conversation.start_attribute(&request, 2).is_err() {
            return self.refused(place, number, None);
        }
        slot.task = Task::Write(number, setting);
        slot.keep_time();
    }

    /// A dynamic connection that is not what it should be.
    fn delete(&mut self, place: usize, number: u8) {
        let waits = self.config.waits;
        let Some(slot) = self.slot(place) else { return };
        let (Some(route), Some(instance)) = (slot.explicit, slot.made(number).and_then(|made| made.instance))
        else {
            return self.set_stage(place, number, Stage::Idle);
        };
        slot.conversation.reroute(route, waits);
        let request = Request::new(ServiceCode::DELETE, ClassId(CONNECTION), InstanceId(instance), &[]);
        if slot.conversation.start(&request, 2).is_err() {
            return self.refused(place, number, None);
        }
        slot.task = Task::Delete(number);
        slot.keep_time();
    }
}

impl Looked {
    /// Of the Connection object.
    const fn attribute(self) -> u8 {
        match self {
            Self::State => 1,
            Self::ProducedId => 4,
            Self::ConsumedId => 5,
            Self::Trigger => 3,
            Self::WatchdogAction => 12,
            Self::PacketRate => 9,
        }
    }
}

impl Setting {
    /// Of the Connection object.
    const fn attribute(self) -> u8 {
        match self {
            Self::Trigger => 3,
            Self::ConsumedId => 5,
            Self::PacketRate => 9,
            Self::WatchdogAction => 12,
        }
    }
}

/// The class of the Connection object.
const CONNECTION: u16 = 0x05;
/// The class of the link object, and the attribute that is the address.
const LINK: u16 = 0x03;
const ADDRESS: u8 = 1;
/// And that which lists the connections.
const INSTANCES: u8 = 5;
/// Values of the state attribute.
pub(super) const ESTABLISHED: u8 = 3;
pub(super) const TIMED_OUT: u8 = 4;
/// Of the explicit connection, in ms: it is deleted four of them after the last message.
const EXPLICIT_RATE: u16 = 2500;
