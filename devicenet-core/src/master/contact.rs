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
use cip_core::message::{AllocationChoice, Response};

use super::bring_up::refusal;
use super::config::{Config, FirstContact};
use super::door;
use super::slot::{Slot, SlotTimer};
use super::state::{Cause, Contact, Stage, Step};
use super::status::ScannerStatus;
use crate::client::{Failure, Route};
use crate::counter::count;
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
        let everything = self.entry.choice().union(AllocationChoice::EXPLICIT);
        let tries = config.tries;
        match contact {
            Contact::Allocate { .. } => self.ask_port(config, own, &door::allocate_explicit(own), tries),
            Contact::ReleaseAll => self.ask_port(config, own, &door::release(everything), tries),
            Contact::ReleaseOne { bit } => {
                let choice = AllocationChoice::from_bits_retain(bit);
                self.ask_port(config, own, &door::release(choice), tries);
            }
            Contact::Open => self.ask_ucmm(config, own, &door::open(config.ucmm_format), tries),
        }
    }

    /// Says something at the unconnected port of Group 2.
    pub(super) fn ask_port(&mut self, config: &Config, own: MacId, body: &[u8], tries: u8) {
        let route = Route::group2_unconnected(own, self.entry.mac_id);
        self.conversation.reroute(route, config.unconnected);
        self.say(body, tries);
    }

    /// Says something to the UCMM.
    pub(super) fn ask_ucmm(&mut self, config: &Config, own: MacId, body: &[u8], tries: u8) {
        self.conversation.reroute(Route::ucmm(own, self.entry.mac_id), config.unconnected);
        self.say(body, tries);
    }

    /// Starts a transaction of this module, all of which fit.
    fn say(&mut self, body: &[u8], tries: u8) {
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
                let Some(format) = door::format_told(data) else {
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
                self.tell_refusal(response);
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
                self.tell_refusal(response);
                self.give_up(config, own, Cause::Refused, ScannerStatus::INITIALISATION_REFUSED);
            }
        }
    }

    /// The I/O connections of the entry one by one, each as a release choice.
    pub(super) fn io_choice_after(&self, bit: u8) -> Option<u8> {
        let wanted = door::released(self.entry.choice());
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
            source_message: MessageId::new(door::SOURCE_MESSAGE)?,
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
        self.retreat(config, cause, status);
        if !held.is_empty() {
            self.let_go(config, own, held);
        }
    }

    /// The slave has let another master allocate it: whatever this one had there is gone, or it would have refused. Nothing
    /// is released, for it might be the other's, but for a connection that the UCMM opened.
    pub(super) fn taken_over(&mut self, config: &Config, own: MacId) {
        match self.stage {
            // An answer of its own is on the way.
            Stage::Offline | Stage::Waiting | Stage::Contacting(_) => return,
            Stage::Configuring(_) => {}
            Stage::Running => {
                count(&mut self.counters.timeouts);
                let opened = self.opened;
                self.abandon_talk();
                self.opened = opened;
            }
        }
        self.retreat(config, Cause::OwnedByAnother, ScannerStatus::INITIALISATION_REFUSED);
        if self.opened.is_some() {
            self.let_go(config, own, AllocationChoice::EXPLICIT);
        }
    }

    /// One more attempt has failed: the pause before the next is longer.
    fn retreat(&mut self, config: &Config, cause: Cause, status: ScannerStatus) {
        count(&mut self.counters.attempts_failed);
        self.wait(cause, status, back_off(config, self.failures));
        self.failures = self.failures.saturating_add(1);
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
        match self.opened {
            Some(connection) => self.ask_ucmm(config, own, &door::close(connection), 1),
            None => self.ask_port(config, own, &door::release(held), 1),
        }
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

/// The choices of I/O connections, one bit each.
const IO_CHOICES: [u8; 5] = [0x02, 0x04, 0x08, 0x10, 0x20];
