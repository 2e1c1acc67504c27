//! Bringing a slave up: its explicit connection, its identity, its connections, its configuration.
//!
//! | Step | Request | On success | On failure |
//! |---|---|---|---|
//! | contact | Allocate of the explicit connection on the unconnected port, or Open with the UCMM | next | no answer on either: status 78 |
//! | contact | the same, answered "already in requested state" | Release, then Allocate again | status 83 |
//! | contact | the same, answered "owned by another master" | | status 83 |
//! | watchdog action | Set instance 1 attribute 12 to deferred delete | next | next |
//! | identity | Get vendor, device type, product code, and revision if it is in the key | next | Release, status 73 |
//! | I/O | Allocate of the I/O connections over the explicit connection | next | Release, status 83 |
//! | I/O | the same, answered "already in requested state" | Release of the I/O connections, then Allocate again | Release, status 83 |
//! | sizes | Get attributes 7 and 8 of each instance | next | Release, status 77 |
//! | configuration | the attribute writes of the entry | next | Release, status 89 |
//! | start | Set attributes 17 and 9 of each instance | running | Release, status 83 |
//!
//! Source: captures of an IAI controller and of Omron and Jasic masters for the messages; 1771-SDN and 1769-SDN manuals
//! for the order and the codes.

use cip_core::code::{AdditionalCode, AttributeId, ClassId, GeneralStatus, InstanceId};
use cip_core::codec::{Reader, Wire};
use cip_core::connection::WatchdogAction;
use cip_core::identity::Revision;
use cip_core::message::{AttributeRequest, Response};

use super::config::Config;
use super::difference::{Difference, Property};
use super::door;
use super::event::SlaveEvent;
use super::scan_list::IoInstance;
use super::slot::{Sending, Slot, SlotTimer};
use super::state::{Cause, Stage, Step};
use super::status::ScannerStatus;
use super::writes::AttributeWrite;
use crate::client::Route;
use crate::counter::count;
use crate::id::MacId;

/// What a step came to.
type Outcome = Result<(), (Cause, ScannerStatus)>;

impl<const N: usize> Slot<N> {
    /// A response while the slave is being brought up.
    pub(super) fn brought_further(&mut self, config: &Config, own: MacId, response: &Response<'_>) {
        self.absent = false;
        match self.stage {
            Stage::Contacting(contact) => self.contacted(config, own, contact, response),
            Stage::Configuring(step) => {
                if let Some(next) = self.released_first(step, response) {
                    return self.go_to(config, own, next);
                }
                match self.configured(step, response) {
                    Ok(()) => self.go_on(config, own, Some(step)),
                    Err((cause, status)) => self.give_up(config, own, cause, status),
                };
            }
            // The answer to a Release that was sent on giving up.
            Stage::Offline | Stage::Waiting | Stage::Running => {}
        }
    }

    pub(super) fn connected(&mut self, config: &Config, own: MacId) {
        self.enter(Stage::Configuring(Step::WatchdogAction), Cause::Connected);
        self.set_status(ScannerStatus::INITIALISING);
        self.go_on(config, own, None);
    }

    /// Asks for what comes after `done`, or starts the I/O.
    fn go_on(&mut self, config: &Config, own: MacId, done: Option<Step>) {
        match self.step_after(config, done) {
            Some(step) => self.go_to(config, own, step),
            None => self.established(),
        }
    }

    fn go_to(&mut self, config: &Config, own: MacId, step: Step) {
        self.stage = Stage::Configuring(step);
        if self.ask(config, own, step) {
            return self.keep_time();
        }
        // A write that the connection cannot carry; everything else fits.
        debug_assert!(matches!(step, Step::Write(_)), "{step:?}");
        self.give_up(config, own, Cause::Refused, ScannerStatus::REPLACEMENT_FAILED);
    }

    /// I/O connections that an earlier life of this master left are released and allocated again: what is to be done
    /// next for that.
    fn released_first(&self, step: Step, response: &Response<'_>) -> Option<Step> {
        let one_by_one = |bit| {
            self.io_choice_after(bit)
                .map_or(Step::AllocateIo { released: true }, |bit| Step::ReleaseIo { bit: Some(bit) })
        };
        match (step, *response) {
            (
                Step::AllocateIo { released: false },
                Response::Error { status: GeneralStatus::ALREADY_IN_REQUESTED_STATE, .. },
            ) => Some(Step::ReleaseIo { bit: None }),
            (Step::ReleaseIo { bit: None }, Response::Success { .. }) => {
                Some(Step::AllocateIo { released: true })
            }
            // Not all of it exists: one after another, and never mind the errors.
            (Step::ReleaseIo { bit: None }, Response::Error { .. }) => Some(one_by_one(0)),
            (Step::ReleaseIo { bit: Some(bit) }, _) => Some(one_by_one(bit)),
            _ => None,
        }
    }

    /// Sends the request of a step; false if it cannot be sent.
    fn ask(&mut self, config: &Config, own: MacId, step: Step) -> bool {
        let identity =
            |attribute| AttributeRequest::get(ClassId::IDENTITY, InstanceId(1), AttributeId(attribute));
        let connection = |instance: IoInstance, attribute| {
            AttributeRequest::get(ClassId::CONNECTION, instance.instance(), AttributeId(attribute))
        };
        let inhibit = |instance| self.entry.agreed(instance).map_or(0, |agreed| agreed.inhibit).to_le_bytes();
        let rate = |instance| {
            self.entry.agreed(instance).map_or(0, |agreed| agreed.expected_packet_rate).to_le_bytes()
        };
        let tries = config.tries;
        let started = match step {
            Step::WatchdogAction => {
                let value = [WatchdogAction::DEFERRED_DELETE.0];
                let request =
                    AttributeRequest::set(ClassId::CONNECTION, InstanceId(1), WATCHDOG_ACTION, &value);
                self.conversation.start_attribute(&request, tries)
            }
            Step::Vendor => self.conversation.start_attribute(&identity(1), tries),
            Step::DeviceType => self.conversation.start_attribute(&identity(2), tries),
            Step::ProductCode => self.conversation.start_attribute(&identity(3), tries),
            Step::Revision => self.conversation.start_attribute(&identity(4), tries),
            Step::AllocateIo { .. } => {
                let data = [self.entry.choice().bits(), own.number()];
                let request = cip_core::message::Request::new(
                    cip_core::code::ServiceCode::ALLOCATE,
                    ClassId::DEVICENET,
                    InstanceId(1),
                    &data,
                );
                self.conversation.start(&request, tries)
            }
            Step::ReleaseIo { bit } => {
                let data = [bit.unwrap_or(door::released(self.entry.choice()))];
                let request = cip_core::message::Request::new(
                    cip_core::code::ServiceCode(door::RELEASE),
                    ClassId::DEVICENET,
                    InstanceId(1),
                    &data,
                );
                self.conversation.start(&request, tries)
            }
            Step::ProducedSize(instance) => {
                self.conversation.start_attribute(&connection(instance, 7), tries)
            }
            Step::ConsumedSize(instance) => {
                self.conversation.start_attribute(&connection(instance, 8), tries)
            }
            Step::Write(offset) => {
                let mut reader = Reader::new(self.writes.get(usize::from(offset)..).unwrap_or(&[]));
                let Ok(write) = AttributeWrite::read(&mut reader) else { return false };
                let request =
                    AttributeRequest::set(write.class, write.instance, write.attribute, write.value);
                self.conversation.start_attribute(&request, tries)
            }
            Step::InhibitTime(instance) => {
                let value = inhibit(instance);
                let request =
                    AttributeRequest::set(ClassId::CONNECTION, instance.instance(), AttributeId(17), &value);
                self.conversation.start_attribute(&request, tries)
            }
            Step::PacketRate(instance) => {
                let value = rate(instance);
                let request =
                    AttributeRequest::set(ClassId::CONNECTION, instance.instance(), AttributeId(9), &value);
                self.conversation.start_attribute(&request, tries)
            }
            Step::Close => {
                let route = Route::ucmm(own, self.entry.mac_id);
                self.conversation.reroute(route, config.unconnected);
                let connection = self.opened.unwrap_or(InstanceId::CLASS);
                self.conversation.start_body(&door::close(connection), tries)
            }
        };
        started.is_ok()
    }

    /// The step that comes after `done` for this slave; `None` if nothing is left to do.
    fn step_after(&self, config: &Config, done: Option<Step>) -> Option<Step> {
        let mut step = match done {
            None => Step::WatchdogAction,
            Some(step) => self.following(step)?,
        };
        while !self.is_needed(config, step) {
            step = self.following(step)?;
        }
        Some(step)
    }

    /// The order of the steps, needed or not.
    fn following(&self, step: Step) -> Option<Step> {
        let next = |instance: IoInstance| IoInstance::ALL.get(instance.index().saturating_add(1)).copied();
        Some(match step {
            Step::WatchdogAction => Step::Vendor,
            Step::Vendor => Step::DeviceType,
            Step::DeviceType => Step::ProductCode,
            Step::ProductCode => Step::Revision,
            Step::Revision => Step::AllocateIo { released: false },
            Step::ReleaseIo { .. } => Step::AllocateIo { released: true },
            Step::AllocateIo { .. } => Step::ProducedSize(IoInstance::Poll),
            Step::ProducedSize(instance) => Step::ConsumedSize(instance),
            Step::ConsumedSize(instance) => next(instance).map_or(Step::Write(0), Step::ProducedSize),
            Step::Write(offset) => {
                self.write_after(offset).map_or(Step::InhibitTime(IoInstance::Poll), Step::Write)
            }
            Step::InhibitTime(instance) => Step::PacketRate(instance),
            Step::PacketRate(instance) => next(instance).map_or(Step::Close, Step::InhibitTime),
            Step::Close => return None,
        })
    }

    fn is_needed(&self, config: &Config, step: Step) -> bool {
        let agreed = |instance| self.entry.agreed(instance);
        match step {
            Step::WatchdogAction => config.deferred_delete && self.opened.is_none(),
            Step::Vendor | Step::DeviceType | Step::ProductCode => true,
            Step::Revision => self.entry.key.revision.is_some(),
            Step::AllocateIo { .. } => !self.entry.choice().is_empty(),
            Step::ReleaseIo { .. } => true,
            Step::ProducedSize(instance) => agreed(instance).is_some_and(|agreed| agreed.produce.is_some()),
            Step::ConsumedSize(instance) => agreed(instance).is_some_and(|agreed| agreed.consume.is_some()),
            Step::Write(offset) => usize::from(offset) < self.writes.len(),
            Step::InhibitTime(instance) => agreed(instance).is_some_and(|agreed| agreed.inhibit != 0),
            Step::PacketRate(instance) => agreed(instance).is_some(),
            Step::Close => self.opened.is_some(),
        }
    }

    fn write_after(&self, offset: u16) -> Option<u16> {
        let mut reader = Reader::new(self.writes.get(usize::from(offset)..)?);
        AttributeWrite::read(&mut reader).ok()?;
        if reader.is_empty() {
            return None;
        }
        offset.checked_add(u16::try_from(reader.offset()).ok()?)
    }

    /// Whether the answer to a step lets the slave go on.
    fn configured(&mut self, step: Step, response: &Response<'_>) -> Outcome {
        if step == Step::Close {
            self.opened = None;
        }
        let data = match (*response, step) {
            (Response::Success { data, .. }, _) => data,
            (Response::Error { .. }, Step::WatchdogAction | Step::ReleaseIo { .. } | Step::Close) => {
                return Ok(());
            }
            (Response::Error { .. }, Step::Write(_)) => {
                self.tell_refusal(response);
                return Err((Cause::Refused, ScannerStatus::REPLACEMENT_FAILED));
            }
            // A small slave without attributes 7 and 8 is believed.
            (
                Response::Error { status: GeneralStatus::ATTRIBUTE_NOT_SUPPORTED, .. },
                Step::ProducedSize(_) | Step::ConsumedSize(_),
            ) => return Ok(()),
            (Response::Error { .. }, _) => {
                self.tell_refusal(response);
                return Err((refusal(response), ScannerStatus::INITIALISATION_REFUSED));
            }
        };
        let mut reader = Reader::new(data);
        let found = reader.u16("value").ok();
        let key = self.entry.key;
        let agreed = |instance| self.entry.agreed(instance);
        let (property, wanted) = match step {
            Step::Vendor => (Property::Vendor, key.vendor.map(|vendor| vendor.0)),
            Step::DeviceType => (Property::DeviceType, key.device_type.map(|device_type| device_type.0)),
            Step::ProductCode => (Property::ProductCode, key.product_code),
            Step::Revision => {
                let is_accepted = Revision::parse(data).is_ok_and(|found| key.accepts_revision(found));
                let wanted = key.revision.filter(|_| !is_accepted);
                (Property::Revision, wanted.map(|key| u16::from_le_bytes([key.major, key.minor])))
            }
            Step::ProducedSize(instance) => {
                (Property::ProducedSize(instance), agreed(instance).and_then(|agreed| agreed.produce))
            }
            Step::ConsumedSize(instance) => {
                (Property::ConsumedSize(instance), agreed(instance).and_then(|agreed| agreed.consume))
            }
            Step::PacketRate(instance) => {
                // Some slaves answer without the value that they use; and no time-out is not what was asked for.
                let wanted = agreed(instance).map_or(0, |agreed| agreed.expected_packet_rate);
                let used = found.filter(|&used| used != 0).unwrap_or(wanted);
                if let Some(input) = self.input_mut(instance) {
                    input.rate = used;
                }
                return Ok(());
            }
            Step::WatchdogAction
            | Step::AllocateIo { .. }
            | Step::ReleaseIo { .. }
            | Step::Write(_)
            | Step::InhibitTime(_)
            | Step::Close => return Ok(()),
        };
        match wanted {
            Some(wanted) if found != Some(wanted) => {
                self.raise(SlaveEvent::Differs(Difference { property, wanted, found }));
                Err(property.mismatch())
            }
            _ => Ok(()),
        }
    }

    /// Tells of a response that ends the attempt.
    pub(super) fn tell_refusal(&mut self, response: &Response<'_>) {
        if let Response::Error { status, additional } = *response {
            self.raise(SlaveEvent::Refused { status, additional });
        }
    }

    fn established(&mut self) {
        self.failures = 0;
        self.timers.clear(SlotTimer::Conversation);
        self.enter(Stage::Running, Cause::Established);
        count(&mut self.counters.established);
        self.set_status(ScannerStatus::NORMAL);
        for instance in IoInstance::ALL {
            let expects = self.entry.agreed(instance).is_some_and(|agreed| agreed.produce.is_some());
            if expects {
                self.feed_watchdog(instance);
            }
        }
        if self.sends_output() {
            self.output.sending = Sending::Due(0);
        }
    }
}

pub(super) fn refusal(response: &Response<'_>) -> Cause {
    match response {
        Response::Error {
            status: GeneralStatus::OBJECT_STATE_CONFLICT,
            additional: ALLOCATION_CONFLICT,
            ..
        } => Cause::OwnedByAnother,
        Response::Error { .. } | Response::Success { .. } => Cause::Refused,
    }
}

const WATCHDOG_ACTION: AttributeId = AttributeId(12);
/// Additional code of the DeviceNet object: another master owns the connection set.
const ALLOCATION_CONFLICT: AdditionalCode = AdditionalCode(0x01);
