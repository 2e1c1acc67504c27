//! Automatic device replacement: a missing slave's address and configuration for the new device at MAC ID 63.
//!
//! A device out of the box comes up at MAC ID 63. While a slave that may be replaced is not found, the master looks
//! there; if exactly one missing slave's key fits the device, it gives the device that slave's MAC ID. The device starts
//! anew, and is brought up like any other, configuration included.
//!
//! | What is found | What happens |
//! |---|---|
//! | one missing slave fits | Set of the DeviceNet object's MAC ID; in a dry run only [`MasterEvent::Replacement`] |
//! | two missing slaves of one kind fit | refused: nobody can tell which of them it is |
//! | no missing slave fits | refused |
//! | two devices were heard at MAC ID 63 | refused: the second is faulted, and which of them is wanted is unknown |
//!
//! Source: 1769-SDN and 1756-DNB manuals (node recovery and configuration recovery).

use core::time::Duration;

use cip_core::code::{AttributeId, ClassId, DeviceType, GeneralStatus, InstanceId, VendorId};
use cip_core::codec::{Reader, Wire};
use cip_core::identity::Revision;
use cip_core::message::{AllocationChoice, AttributeRequest, Response};
use link_core::timers::TimerKey;
use link_core::{Frame, Instant, Timers};

use super::config::Config;
use super::door;
use super::event::MasterEvent;
use super::machine::Master;
use super::slot::Slot;
use super::status::ScannerStatus;
use crate::client::{Conversation, Progress, Route, Waits};
use crate::id::MacId;
use crate::message::{DeviceIdentity, DuplicateMacCheck};

/// Whether slaves are replaced.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum ReplacementMode {
    /// Nobody looks at MAC ID 63.
    #[default]
    Off,
    /// What would be done is told, and not done.
    DryRun,
    /// Missing slaves are replaced.
    On,
}

/// What became of the look at MAC ID 63.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Replacement {
    /// The device would get that MAC ID.
    WouldAssign(MacId),
    /// The device was given that MAC ID, and starts anew with it.
    Assigned(MacId),
    /// No missing slave has a key that fits the device.
    NoMatch,
    /// Several missing slaves have.
    SeveralMissing,
    /// Several devices were heard at MAC ID 63.
    SeveralCandidates,
    /// The device does not let its MAC ID be set.
    Refused,
}

/// The conversation with whoever is at MAC ID 63.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Candidate<const N: usize> {
    pub(super) conversation: Conversation<N>,
    stage: Looking,
    /// The device that checked MAC ID 63 last.
    heard: Option<DeviceIdentity>,
    /// Another one did, too.
    contested: bool,
    found: Found,
    pub(super) timers: Timers<Wait, 2>,
    pub(super) event: Option<Replacement>,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
enum Looking {
    /// Until there is a reason to look again.
    Away,
    /// `released`: the connection that an earlier look left was released before.
    Allocating {
        released: bool,
    },
    /// The connection of an earlier look that failed is released.
    Clearing,
    Asking(u16),
    Assigning(MacId),
    Releasing,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
struct Found {
    vendor: u16,
    device_type: u16,
    product_code: u16,
    revision: Option<Revision>,
}

/// The waits of the look at MAC ID 63.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Wait {
    Conversation,
    Look,
}

impl TimerKey<2> for Wait {
    const ALL: [Self; 2] = [Self::Conversation, Self::Look];
    const WHY: [&'static str; 2] = ["explicit response", "next look for a replacement"];

    fn index(self) -> usize {
        match self {
            Self::Conversation => 0,
            Self::Look => 1,
        }
    }
}

impl<const N: usize> Candidate<N> {
    pub(super) fn new(own: MacId) -> Self {
        let route = Route::group2_unconnected(own, MacId::MAX);
        Self {
            conversation: Conversation::new(route, Waits::UNCONNECTED),
            stage: Looking::Away,
            heard: None,
            contested: false,
            found: Found::default(),
            timers: Timers::new(),
            event: None,
        }
    }

    pub(super) fn keep_time(&mut self) {
        self.conversation.take_timer().apply(&mut self.timers, Wait::Conversation);
    }

    /// Ends the look, and looks again later.
    fn leave(&mut self, after: Duration) {
        self.stage = Looking::Away;
        self.conversation.cancel();
        self.keep_time();
        self.timers.set_after(Wait::Look, after);
    }

    pub(super) fn stop(&mut self) {
        self.leave(Duration::ZERO);
        self.timers.clear_all();
    }

    fn ask_port(&mut self, config: &Config, own: MacId, body: &[u8]) {
        let route = Route::group2_unconnected(own, MacId::MAX);
        self.conversation.reroute(route, config.unconnected);
        let started = self.conversation.start_body(body, 1);
        debug_assert!(started.is_ok(), "{started:?}");
        self.keep_time();
    }

    fn ask(&mut self, attribute: u16) {
        self.stage = Looking::Asking(attribute);
        let request = AttributeRequest::get(ClassId::IDENTITY, InstanceId(1), AttributeId(attribute));
        let started = self.conversation.start_attribute(&request, 1);
        debug_assert!(started.is_ok(), "{started:?}");
        self.keep_time();
    }

    /// Takes an attribute of the Identity object; false if it is malformed.
    fn learn(&mut self, attribute: u16, data: &[u8]) -> bool {
        let mut reader = Reader::new(data);
        match attribute {
            4 => {
                self.found.revision = Revision::parse(data).ok();
                self.found.revision.is_some()
            }
            _ => {
                let Ok(number) = reader.u16("identity") else { return false };
                match attribute {
                    1 => self.found.vendor = number,
                    2 => self.found.device_type = number,
                    _ => self.found.product_code = number,
                }
                true
            }
        }
    }
}

impl<const SLAVES: usize, const MESSAGE: usize> Master<SLAVES, MESSAGE> {
    /// Whether anybody is missing who may be replaced, and MAC ID 63 is nobody's own.
    fn looks(&self) -> bool {
        self.on_line
            && self.config.replacement != ReplacementMode::Off
            && !self.board.listed().contains(MacId::MAX)
            && self.access().mac_id() != MacId::MAX
            && self.slots.iter().any(is_missing)
    }

    /// Looks at MAC ID 63 from time to time while it is of use.
    pub(super) fn follow_missing(&mut self) {
        let looks = self.looks();
        if !looks {
            if self.candidate.stage == Looking::Away {
                self.candidate.timers.clear(Wait::Look);
            }
        } else if self.candidate.stage == Looking::Away && self.candidate.timers.at(Wait::Look).is_none() {
            self.candidate.timers.set_after(Wait::Look, Duration::ZERO);
        }
    }

    pub(super) fn expire_candidate(&mut self, until: Instant) {
        while let Some(wait) = self.candidate.timers.take_expired(until) {
            match wait {
                Wait::Look if self.looks() && self.candidate.stage == Looking::Away => self.look(false),
                Wait::Look => {}
                Wait::Conversation => {
                    let failure = self.candidate.conversation.timer_expired();
                    self.candidate.keep_time();
                    if failure.is_some() {
                        self.candidate.leave(self.config.replacement_retry);
                    }
                }
            }
        }
    }

    fn look(&mut self, released: bool) {
        let own = self.access().mac_id();
        self.candidate.stage = Looking::Allocating { released };
        self.candidate.ask_port(&self.config, own, &door::allocate_explicit(own));
    }

    /// Somebody checks MAC ID 63: out of the box, on line in a second or two.
    pub(super) fn candidate_heard(&mut self, frame: &Frame) {
        let Ok(check) = DuplicateMacCheck::parse(frame.data()) else { return };
        let other = self.candidate.heard.replace(check.device).is_some_and(|heard| heard != check.device);
        self.candidate.contested |= other;
        if self.candidate.stage == Looking::Away && self.looks() {
            self.candidate.timers.set_after(Wait::Look, super::receive::AFTER_CHECK);
        }
    }

    /// A frame from MAC ID 63.
    pub(super) fn candidate_frame(&mut self, frame: &Frame) -> bool {
        let mut buffer = [0; MESSAGE];
        let mut out = cip_core::codec::Writer::new(&mut buffer);
        match self.candidate.conversation.frame(frame) {
            Progress::NotMine => return false,
            Progress::Ignored(_) | Progress::Pending => {}
            Progress::Failed(_) => self.candidate.leave(self.config.replacement_retry),
            Progress::Response(response) => {
                let copied = response.emit(&mut out);
                debug_assert!(copied.is_ok(), "a response fits where it came from");
                self.candidate.keep_time();
                if let Ok(response) = Response::parse(out.written()) {
                    self.candidate_answers(&response);
                }
            }
        }
        self.candidate.keep_time();
        true
    }

    fn candidate_answers(&mut self, response: &Response<'_>) {
        let own = self.access().mac_id();
        let retry = self.config.replacement_retry;
        match (self.candidate.stage, response) {
            (Looking::Away, _) => {}
            (Looking::Allocating { .. }, Response::Success { data, .. }) => {
                let Some(format) = door::format_told(data) else { return self.candidate.leave(retry) };
                let route = Route::predefined(own, MacId::MAX, format);
                self.candidate.conversation.reroute(route, self.config.connected);
                self.candidate.ask(1);
            }
            (
                Looking::Allocating { released: false },
                Response::Error { status: GeneralStatus::ALREADY_IN_REQUESTED_STATE, .. },
            ) => {
                self.candidate.stage = Looking::Clearing;
                self.candidate.ask_port(&self.config, own, &door::release(AllocationChoice::EXPLICIT));
            }
            (Looking::Clearing, _) => self.look(true),
            (Looking::Asking(attribute), Response::Success { data, .. }) => {
                if !self.candidate.learn(attribute, data) {
                    return self.conclude(Replacement::NoMatch);
                }
                match attribute {
                    1..=3 => self.candidate.ask(attribute.saturating_add(1)),
                    _ => self.judge(),
                }
            }
            (Looking::Assigning(slave), Response::Success { .. }) => {
                self.candidate.event = Some(Replacement::Assigned(slave));
                self.candidate.heard = None;
                self.candidate.leave(retry);
            }
            (Looking::Assigning(_), Response::Error { .. }) => self.conclude(Replacement::Refused),
            (Looking::Asking(_), Response::Error { .. }) => self.conclude(Replacement::NoMatch),
            (Looking::Allocating { .. }, Response::Error { .. }) | (Looking::Releasing, _) => {
                self.candidate.leave(retry);
            }
        }
    }

    /// The device is known: whose place is it?
    fn judge(&mut self) {
        if self.candidate.contested {
            self.candidate.contested = false;
            return self.conclude(Replacement::SeveralCandidates);
        }
        let found = self.candidate.found;
        let fits = |slot: &&Slot<MESSAGE>| is_missing(slot) && matches(slot, &found);
        let mut fitting = self.slots.iter().filter(fits).map(|slot| slot.entry.mac_id);
        let verdict = match (fitting.next(), fitting.next()) {
            (None, _) => Replacement::NoMatch,
            (Some(_), Some(_)) => Replacement::SeveralMissing,
            (Some(slave), None) if self.config.replacement == ReplacementMode::On => {
                return self.assign(slave);
            }
            (Some(slave), None) => Replacement::WouldAssign(slave),
        };
        self.conclude(verdict);
    }

    fn assign(&mut self, slave: MacId) {
        self.candidate.stage = Looking::Assigning(slave);
        let value = [slave.number()];
        let request = AttributeRequest::set(ClassId::DEVICENET, InstanceId(1), AttributeId(1), &value);
        let started = self.candidate.conversation.start_attribute(&request, 1);
        debug_assert!(started.is_ok(), "{started:?}");
        self.candidate.keep_time();
    }

    /// Tells the verdict, and lets the device go.
    fn conclude(&mut self, verdict: Replacement) {
        let own = self.access().mac_id();
        self.candidate.event = Some(verdict);
        for slot in self.board.all_mut(&mut self.slots).filter(|slot| is_missing(slot)) {
            if !matches!(verdict, Replacement::WouldAssign(_)) {
                slot.set_status(ScannerStatus::REPLACEMENT_FAILED);
            }
        }
        self.candidate.stage = Looking::Releasing;
        self.candidate.ask_port(&self.config, own, &door::release(AllocationChoice::EXPLICIT));
    }

    pub(super) fn candidate_event(&mut self) -> Option<MasterEvent> {
        let replacement = self.candidate.event.take()?;
        Some(MasterEvent::Replacement(replacement))
    }
}

/// In the scan list, may be replaced, and nobody answers.
fn is_missing<const N: usize>(slot: &Slot<N>) -> bool {
    slot.entry.replaceable && slot.absent
}

/// Whether a device can stand in for a slave: a key that asks for nothing fits nobody.
fn matches<const N: usize>(slot: &Slot<N>, found: &Found) -> bool {
    let key = &slot.entry.key;
    key.product_code == Some(found.product_code)
        && key.vendor == Some(VendorId(found.vendor))
        && key.device_type.is_none_or(|key| key == DeviceType(found.device_type))
        && found.revision.is_some_and(|revision| key.accepts_revision(revision))
}
