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
//! | sizes | Get attributes 7 and 8 of each instance | next | Release, status 77 |
//! | configuration | the attribute writes of the entry | next | Release, status 89 |
//! | start | Set attributes 17 and 9 of each instance | running | Release, status 83 |
//!
//! Source: captures of an IAI controller and of Omron and Jasic masters for the messages; 1771-SDN and 1769-SDN manuals
//! for the order and the codes.

use core::time::Duration;

use cip_core::code::{AdditionalCode, AttributeId, ClassId, DeviceType, GeneralStatus, InstanceId, VendorId};
use cip_core::codec::{Reader, Wire};
use cip_core::connection::WatchdogAction;
use cip_core::identity::Revision;
use cip_core::message::{AllocationChoice, AttributeRequest, BodyFormat, Response};

use super::config::{Config, FirstContact};
use super::event::count;
use super::scan_list::IoInstance;
use super::slot::{Slot, SlotTimer};
use super::state::{Cause, Contact, Stage, Step};
use super::status::ScannerStatus;
use super::writes::AttributeWrite;
use crate::client::{Failure, Route};
use crate::id::MacId;
use crate::message::{FormatByte, GroupSelect, MessageId, OpenRequest, OpenResponse};

/// What a step came to.
type Outcome = Result<(), (Cause, ScannerStatus)>;

impl<const N: usize> Slot<N> {
    /// Knocks at the door that opened last time, or at the one that is configured.
    pub(super) fn begin(&mut self, config: &Config, own: MacId) {
        self.other_door = true;
        let contact = if self.ucmm || config.first_contact == FirstContact::Ucmm {
            Contact::Open
        } else {
            Contact::Allocate { released: false }
        };
        self.enter(Stage::Contacting(contact), Cause::RetryDue);
        self.contact(config, own, contact);
    }

    pub(super) fn contact(&mut self, config: &Config, own: MacId, contact: Contact) {
        self.stage = Stage::Contacting(contact);
        let slave = self.entry.mac_id;
        let everything = self.entry.choice().union(AllocationChoice::EXPLICIT);
        let body = match contact {
            Contact::Allocate { .. } => {
                [ALLOCATE, CLASS, INSTANCE, AllocationChoice::EXPLICIT.bits(), own.number()]
            }
            Contact::ReleaseAll => [RELEASE, CLASS, INSTANCE, released(everything), 0],
            Contact::ReleaseOne { bit } => [RELEASE, CLASS, INSTANCE, bit, 0],
            Contact::Open => [ALLOCATE, config.ucmm_format.code(), OPEN_GROUP_3, 0, 0],
        };
        let (route, len) = match contact {
            Contact::Allocate { .. } => (Route::group2_unconnected(own, slave), 5),
            Contact::ReleaseAll | Contact::ReleaseOne { .. } => (Route::group2_unconnected(own, slave), 4),
            Contact::Open => (Route::ucmm(own, slave), 3),
        };
        self.conversation.reroute(route, config.unconnected);
        self.say(body.get(..len).unwrap_or(&[]), config.tries);
    }

    /// Starts a transaction of this module, all of which fit.
    pub(super) fn say(&mut self, body: &[u8], tries: u8) {
        let started = self.conversation.start_body(body, tries);
        debug_assert!(started.is_ok(), "{started:?}");
        self.keep_time();
    }

    /// A response while the slave is being brought up.
    pub(super) fn brought_further(&mut self, config: &Config, own: MacId, response: &Response<'_>) {
        match self.stage {
            Stage::Contacting(contact) => self.contacted(config, own, contact, response),
            Stage::Configuring(step) => {
                match self.configured(step, response) {
                    Ok(()) => self.go_on(config, own, Some(step)),
                    Err((cause, status)) => self.give_up(config, own, cause, status),
                };
            }
            // The answer to a Release that was sent on giving up.
            Stage::Offline | Stage::Waiting | Stage::Running => {}
        }
    }

    fn contacted(&mut self, config: &Config, own: MacId, contact: Contact, response: &Response<'_>) {
        match (contact, response) {
            (Contact::Allocate { .. }, Response::Success { data, .. }) => {
                let format = data.first().and_then(|&byte| BodyFormat::from_code(byte & FORMAT));
                let Some(format) = format else {
                    return self.give_up(config, own, Cause::Refused, ScannerStatus::INITIALISATION_REFUSED);
                };
                let route = Route::predefined(own, self.entry.mac_id, format);
                self.conversation.reroute(route, config.connected);
                self.opened = None;
                self.ucmm = false;
                self.connected(config, own);
            }
            (
                Contact::Allocate { released: false },
                Response::Error { status: GeneralStatus::ALREADY_IN_REQUESTED_STATE, .. },
            ) => self.contact(config, own, Contact::ReleaseAll),
            (Contact::Allocate { .. }, Response::Error { .. }) => {
                self.give_up(config, own, refusal(response), ScannerStatus::INITIALISATION_REFUSED);
            }
            (Contact::ReleaseAll, Response::Success { .. }) => {
                self.contact(config, own, Contact::Allocate { released: true });
            }
            // Not all of it exists: one after another, and never mind the errors.
            (Contact::ReleaseAll, Response::Error { .. }) => {
                self.contact(config, own, Contact::ReleaseOne { bit: AllocationChoice::EXPLICIT.bits() });
            }
            (Contact::ReleaseOne { bit }, _) => {
                let wanted = released(self.entry.choice());
                let next = IO_CHOICES.into_iter().find(|&choice| choice > bit && wanted & choice != 0);
                self.contact(
                    config,
                    own,
                    next.map_or(Contact::Allocate { released: true }, |bit| Contact::ReleaseOne { bit }),
                );
            }
            (Contact::Open, Response::Success { data, .. }) => match self.route_opened(own, data) {
                Some((route, connection)) => {
                    self.conversation.reroute(route, config.connected);
                    self.opened = Some(connection);
                    self.ucmm = true;
                    self.connected(config, own);
                }
                None => self.give_up(config, own, Cause::Refused, ScannerStatus::INITIALISATION_REFUSED),
            },
            (Contact::Open, Response::Error { .. }) => {
                self.give_up(config, own, Cause::Refused, ScannerStatus::INITIALISATION_REFUSED);
            }
        }
    }

    /// The connection that the data of an Open response describe.
    pub(super) fn route_opened(&self, own: MacId, data: &[u8]) -> Option<(Route, InstanceId)> {
        let &[format, messages, low, high] = data else { return None };
        let asked = OpenRequest {
            xid: false,
            server: self.entry.mac_id,
            body_format: FormatByte(format),
            group: GroupSelect::GROUP_3,
            source_message: MessageId::new(OPEN_GROUP_3 & 0x0F)?,
        };
        let answer = OpenResponse {
            xid: false,
            client: own,
            body_format: FormatByte(format),
            destination_message: MessageId::new(messages >> 4)?,
            source_message: MessageId::new(messages & 0x0F)?,
            connection: InstanceId(u16::from_le_bytes([low, high])),
        };
        Some((Route::opened(own, &asked, &answer)?, answer.connection))
    }

    fn connected(&mut self, config: &Config, own: MacId) {
        self.enter(Stage::Configuring(Step::WatchdogAction), Cause::Connected);
        self.set_status(ScannerStatus::INITIALISING);
        self.go_on(config, own, None);
    }

    /// Asks for what comes after `done`, or starts the I/O.
    fn go_on(&mut self, config: &Config, own: MacId, done: Option<Step>) {
        let mut done = done;
        loop {
            let Some(step) = self.step_after(config, done) else { return self.established() };
            self.stage = Stage::Configuring(step);
            if self.ask(config, own, step) {
                return self.keep_time();
            }
            // A write that the connection cannot carry.
            if matches!(step, Step::Write(_)) {
                return self.give_up(config, own, Cause::Refused, ScannerStatus::REPLACEMENT_FAILED);
            }
            done = Some(step);
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
            Step::AllocateIo => {
                let data = [self.entry.choice().bits(), own.number()];
                let request = cip_core::message::Request::new(
                    cip_core::code::ServiceCode::ALLOCATE,
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
                let [low, high] = self.opened.map_or(0, |connection| connection.0).to_le_bytes();
                let route = Route::ucmm(own, self.entry.mac_id);
                self.conversation.reroute(route, config.unconnected);
                self.conversation.start_body(&[RELEASE, low, high], tries)
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
            Step::Revision => Step::AllocateIo,
            Step::AllocateIo => Step::ProducedSize(IoInstance::Poll),
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
            Step::AllocateIo => !self.entry.choice().is_empty(),
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
        let data = match (*response, step) {
            (Response::Success { data, .. }, _) => data,
            (Response::Error { .. }, Step::WatchdogAction | Step::Close) => return Ok(()),
            (Response::Error { .. }, Step::Write(_)) => {
                return Err((Cause::Refused, ScannerStatus::REPLACEMENT_FAILED));
            }
            // A small slave without attributes 7 and 8 is believed.
            (
                Response::Error { status: GeneralStatus::ATTRIBUTE_NOT_SUPPORTED, .. },
                Step::ProducedSize(_) | Step::ConsumedSize(_),
            ) => return Ok(()),
            (Response::Error { .. }, _) => {
                return Err((refusal(response), ScannerStatus::INITIALISATION_REFUSED));
            }
        };
        let mut reader = Reader::new(data);
        let mut number = || reader.u16("value").ok();
        let key = self.entry.key;
        let matches = match step {
            Step::Vendor => key.vendor.is_none_or(|key| number().map(VendorId) == Some(key)),
            Step::DeviceType => key.device_type.is_none_or(|key| number().map(DeviceType) == Some(key)),
            Step::ProductCode => key.product_code.is_none_or(|key| number() == Some(key)),
            Step::Revision => Revision::parse(data).is_ok_and(|found| key.accepts_revision(found)),
            Step::ProducedSize(instance) => {
                let wanted = self.entry.agreed(instance).and_then(|agreed| agreed.produce);
                return size(wanted, number());
            }
            Step::ConsumedSize(instance) => {
                let wanted = self.entry.agreed(instance).and_then(|agreed| agreed.consume);
                return size(wanted, number());
            }
            Step::PacketRate(instance) => {
                // Some slaves answer without the value that they use.
                let wanted = self.entry.agreed(instance).map_or(0, |agreed| agreed.expected_packet_rate);
                let used = number().unwrap_or(wanted);
                if let Some(input) = self.input_mut(instance) {
                    input.rate = used;
                }
                true
            }
            Step::WatchdogAction | Step::AllocateIo | Step::Write(_) | Step::InhibitTime(_) | Step::Close => {
                true
            }
        };
        if matches { Ok(()) } else { Err((Cause::KeyMismatch, ScannerStatus::WRONG_DEVICE)) }
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
            self.output.due = Some(0);
        }
    }

    /// No response, or none that can be used, while the slave is being brought up.
    pub(super) fn went_unanswered(&mut self, config: &Config, own: MacId, failure: Failure) {
        match (self.stage, failure) {
            (Stage::Contacting(Contact::Allocate { .. }), _) if self.other_door => {
                self.other_door = false;
                self.contact(config, own, Contact::Open);
            }
            (Stage::Contacting(Contact::Open), _) if self.other_door => {
                self.other_door = false;
                self.ucmm = false;
                self.contact(config, own, Contact::Allocate { released: false });
            }
            (Stage::Contacting(_), _) => {
                self.ucmm = false;
                self.give_up(config, own, Cause::NoAnswer, ScannerStatus::NOT_FOUND);
            }
            (Stage::Configuring(_), Failure::NoResponse | Failure::NotAcknowledged) => {
                self.give_up(config, own, Cause::NoAnswer, ScannerStatus::STOPPED_COMMUNICATING);
            }
            (Stage::Configuring(_), _) => {
                self.give_up(config, own, Cause::Refused, ScannerStatus::INITIALISATION_REFUSED);
            }
            (Stage::Offline | Stage::Waiting | Stage::Running, _) => {}
        }
    }

    /// Ends an attempt, and lets go of what was allocated.
    fn give_up(&mut self, config: &Config, own: MacId, cause: Cause, status: ScannerStatus) {
        let lets_go = matches!(self.stage, Stage::Configuring(_)) && cause != Cause::NoAnswer;
        count(&mut self.counters.attempts_failed);
        self.wait(cause, status, back_off(config, self.failures));
        self.failures = self.failures.saturating_add(1);
        if lets_go {
            self.let_go(config, own);
        }
    }

    /// Releases the connections, or closes the one that the UCMM opened; nobody waits for the answer.
    pub(super) fn let_go(&mut self, config: &Config, own: MacId) {
        let slave = self.entry.mac_id;
        let everything = released(self.entry.choice().union(AllocationChoice::EXPLICIT));
        let (route, body) = match self.opened {
            Some(connection) => {
                let [low, high] = connection.0.to_le_bytes();
                (Route::ucmm(own, slave), [RELEASE, low, high, 0])
            }
            None => (Route::group2_unconnected(own, slave), [RELEASE, CLASS, INSTANCE, everything]),
        };
        let len = if self.opened.is_some() { 3 } else { 4 };
        self.conversation.reroute(route, config.unconnected);
        self.say(body.get(..len).unwrap_or(&[]), 1);
    }

    /// Back to waiting, for `pause`.
    pub(super) fn wait(&mut self, cause: Cause, status: ScannerStatus, pause: Duration) {
        self.conversation.cancel();
        self.keep_time();
        self.enter(Stage::Waiting, cause);
        self.set_status(status);
        self.timers.set_after(SlotTimer::Retry, pause);
    }
}

/// Doubles with each failure.
fn back_off(config: &Config, failures: u8) -> Duration {
    let doubled =
        1_u32.checked_shl(failures.into()).and_then(|factor| config.retry_after.checked_mul(factor));
    doubled.unwrap_or(config.retry_at_most).min(config.retry_at_most)
}

/// A release choice: acknowledge suppression is no connection.
fn released(choice: AllocationChoice) -> u8 {
    choice.difference(AllocationChoice::ACK_SUPPRESSION).bits()
}

fn refusal(response: &Response<'_>) -> Cause {
    match response {
        Response::Error {
            status: GeneralStatus::OBJECT_STATE_CONFLICT,
            additional: ALLOCATION_CONFLICT,
            ..
        } => Cause::OwnedByAnother,
        Response::Error { .. } | Response::Success { .. } => Cause::Refused,
    }
}

fn size(wanted: Option<u16>, found: Option<u16>) -> Outcome {
    if wanted == found { Ok(()) } else { Err((Cause::SizeMismatch, ScannerStatus::SIZE_MISMATCH)) }
}

/// Also Open with the UCMM.
const ALLOCATE: u8 = 0x4B;
/// Also Close with the UCMM.
const RELEASE: u8 = 0x4C;
/// The DeviceNet object.
const CLASS: u8 = 0x03;
const INSTANCE: u8 = 0x01;
/// Group Select 3, and the Message ID for the master's requests on connections that the UCMM opens.
pub(super) const OPEN_GROUP_3: u8 = 0x34;
/// The choices of I/O connections, one bit each.
const IO_CHOICES: [u8; 5] = [0x02, 0x04, 0x08, 0x10, 0x20];
/// The body format in an Allocate response.
const FORMAT: u8 = 0x0F;
const WATCHDOG_ACTION: AttributeId = AttributeId(12);
/// Additional code of the DeviceNet object: another master owns the connection set.
const ALLOCATION_CONFLICT: AdditionalCode = AdditionalCode(0x01);
