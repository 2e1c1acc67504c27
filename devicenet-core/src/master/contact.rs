//! The first contact with a slave, and the last word to it.
//!
//! ```text
//! Allocate on the unconnected port --- no answer ---> Open with the UCMM --- no answer ---> not found
//!    |        ^                                          |
//!    |        | released                                 | opened
//!    |        +---- Release of all, or bit by bit <--+   |
//!    |                                               |   v
//!    +--- "already in requested state" --------------+  identity, connections, configuration
//! ```

use core::time::Duration;

use cip_core::code::{GeneralStatus, InstanceId};
use cip_core::message::{AllocationChoice, BodyFormat, Response};

use super::bring_up::refusal;
use super::config::{Config, FirstContact};
use super::event::count;
use super::slot::{Slot, SlotTimer};
use super::state::{Cause, Contact, Stage, Step};
use super::status::ScannerStatus;
use crate::client::{Failure, Route};
use crate::id::MacId;
use crate::message::{FormatByte, GroupSelect, MessageId, OpenRequest, OpenResponse};

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

    pub(super) fn contacted(
        &mut self,
        config: &Config,
        own: MacId,
        contact: Contact,
        response: &Response<'_>,
    ) {
        match (contact, response) {
            (Contact::Allocate { .. }, Response::Success { data, .. }) => {
                let format = data.first().and_then(|&byte| BodyFormat::from_code(byte & FORMAT));
                let Some(format) = format else {
                    return self.give_up(config, own, Cause::Refused, ScannerStatus::INITIALISATION_REFUSED);
                };
                let route = Route::predefined(own, self.entry.mac_id, format);
                self.conversation.reroute(route, config.connected);
                self.format = format;
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
                let next = self.io_choice_after(bit);
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

    /// The I/O connections of the entry one by one, each as a release choice.
    pub(super) fn io_choice_after(&self, bit: u8) -> Option<u8> {
        let wanted = released(self.entry.choice());
        IO_CHOICES.into_iter().find(|&choice| choice > bit && wanted & choice != 0)
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
                self.absent = true;
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
    pub(super) fn give_up(&mut self, config: &Config, own: MacId, cause: Cause, status: ScannerStatus) {
        let held = match self.stage {
            Stage::Configuring(step) if cause != Cause::NoAnswer => self.held_at(step),
            Stage::Offline
            | Stage::Waiting
            | Stage::Contacting(_)
            | Stage::Configuring(_)
            | Stage::Running => AllocationChoice::empty(),
        };
        count(&mut self.counters.attempts_failed);
        self.wait(cause, status, back_off(config, self.failures));
        self.failures = self.failures.saturating_add(1);
        if !held.is_empty() {
            self.let_go(config, own, held);
        }
    }

    /// What is allocated at a step. A Release of anything more would be refused as a whole.
    fn held_at(&self, step: Step) -> AllocationChoice {
        match step {
            Step::WatchdogAction
            | Step::Vendor
            | Step::DeviceType
            | Step::ProductCode
            | Step::Revision
            | Step::AllocateIo { .. }
            | Step::ReleaseIo { .. } => AllocationChoice::EXPLICIT,
            Step::ProducedSize(_)
            | Step::ConsumedSize(_)
            | Step::Write(_)
            | Step::InhibitTime(_)
            | Step::PacketRate(_)
            | Step::Close => self.entry.choice().union(AllocationChoice::EXPLICIT),
        }
    }

    /// Releases the connections, or closes the one that the UCMM opened; nobody waits for the answer.
    pub(super) fn let_go(&mut self, config: &Config, own: MacId, held: AllocationChoice) {
        let slave = self.entry.mac_id;
        let (route, body) = match self.opened {
            Some(connection) => {
                let [low, high] = connection.0.to_le_bytes();
                (Route::ucmm(own, slave), [RELEASE, low, high, 0])
            }
            None => (Route::group2_unconnected(own, slave), [RELEASE, CLASS, INSTANCE, released(held)]),
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
pub(super) fn released(choice: AllocationChoice) -> u8 {
    choice.difference(AllocationChoice::ACK_SUPPRESSION).bits()
}

/// Also Open with the UCMM.
const ALLOCATE: u8 = 0x4B;
/// Also Close with the UCMM.
pub(super) const RELEASE: u8 = 0x4C;
/// The DeviceNet object.
const CLASS: u8 = 0x03;
const INSTANCE: u8 = 0x01;
/// Group Select 3, and the Message ID for the master's requests on connections that the UCMM opens.
pub(super) const OPEN_GROUP_3: u8 = 0x34;
/// The choices of I/O connections, one bit each.
const IO_CHOICES: [u8; 5] = [0x02, 0x04, 0x08, 0x10, 0x20];
/// The body format in an Allocate response.
const FORMAT: u8 = 0x0F;
