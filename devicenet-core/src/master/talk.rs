//! The application's explicit requests to a slave that runs.
//!
//! A Group 2 Only slave is asked over the explicit connection of the predefined set. If that has timed out, it is
//! allocated anew, which the owner may. With a UCMM-capable slave a connection is opened for the request and closed after
//! it.

use cip_core::code::{AttributeId, ClassId, GeneralStatus, InstanceId};
use cip_core::codec::{Wire, Writer};
use cip_core::message::{AllocationChoice, AttributeRequest, Request, Response};
use heapless::Vec;

use super::bring_up::refusal;
use super::config::Config;
use super::door;
use super::event::SlaveEvent;
use super::slot::{Slot, TalkStage};
use super::state::Cause;
use crate::client::{Failure, Route, StartError};
use crate::counter::count;
use crate::id::MacId;

impl<const N: usize> Slot<N> {
    /// Asks what [`Slot::talk`] holds.
    pub(super) fn begin_talk(&mut self, config: &Config, own: MacId) -> Result<(), StartError> {
        if self.ucmm && self.opened.is_none() {
            self.connect(config, own);
            return Ok(());
        }
        self.ask_for_application()?;
        self.talk.stage = TalkStage::Asking { reconnect: self.opened.is_none() };
        Ok(())
    }

    fn ask_for_application(&mut self) -> Result<(), StartError> {
        let talk = &self.talk;
        let started = match talk.attribute {
            Some(attribute) => {
                let request = AttributeRequest {
                    service: talk.service,
                    class: talk.class,
                    instance: talk.instance,
                    attribute,
                    value: &talk.data,
                };
                self.conversation.start_attribute(&request, talk.tries)
            }
            None => {
                let request = Request::new(talk.service, talk.class, talk.instance, &talk.data);
                self.conversation.start(&request, talk.tries)
            }
        };
        self.keep_time();
        started
    }

    /// Opens a connection, or allocates the predefined one again.
    fn connect(&mut self, config: &Config, own: MacId) {
        self.talk.stage = TalkStage::Connecting;
        if self.ucmm {
            self.ask_ucmm(config, own, &door::open(config.ucmm_format), config.tries);
        } else {
            self.ask_port(config, own, &door::allocate_explicit(own), config.tries);
        }
    }

    /// A response while the slave runs.
    pub(super) fn talked(&mut self, config: &Config, own: MacId, response: &Response<'_>) {
        match self.talk.stage {
            TalkStage::Idle => {}
            TalkStage::Connecting => {
                if !self.reconnected(config, own, response) {
                    return self.end_talk(Err(Failure::NoResponse));
                }
                match self.ask_for_application() {
                    Ok(()) => self.talk.stage = TalkStage::Asking { reconnect: false },
                    // The connection has another body format than the one that the request was checked against.
                    Err(_) => self.end_talk(Err(Failure::RequestTooLong)),
                }
            }
            TalkStage::Asking { .. } => {
                let mut buffer = [0; N];
                let mut out = Writer::new(&mut buffer);
                let kept = response.emit(&mut out).is_ok();
                self.talk.data = Vec::from_slice(out.written()).unwrap_or_default();
                self.end_talk(if kept { Ok(()) } else { Err(Failure::ResponseTooLong) });
                self.close(config, own);
            }
            TalkStage::Closing => self.talk.stage = TalkStage::Idle,
            TalkStage::Verifying if self.ucmm => self.told_owner(config, own, response),
            TalkStage::Verifying => {
                self.end_verification(config, own);
                if refusal(response) == Cause::OwnedByAnother {
                    return self.taken_over(config, own);
                }
                self.reconnected(config, own, response);
            }
        }
    }

    /// Somebody else polls the slave. Either it is another master's, which this one has not heard, or that one has not heard
    /// that it lost the slave: an Allocate of the explicit connection tells which, or the allocation information of a slave
    /// that may have no unconnected port. An application that asks something meanwhile comes first; the next poll of the
    /// other is soon enough.
    pub(super) fn verify_owner(&mut self, config: &Config, own: MacId) {
        let is_free = self.talk.stage == TalkStage::Idle && !self.conversation.is_busy();
        if self.is_running() && is_free {
            self.connect(config, own);
            self.talk.stage = TalkStage::Verifying;
        }
    }

    /// With the UCMM: the connection is there, over which the slave is asked, or its answer.
    fn told_owner(&mut self, config: &Config, own: MacId, response: &Response<'_>) {
        if self.opened.is_none() {
            let owner = AttributeRequest::get(ClassId::DEVICENET, InstanceId(1), ALLOCATION_INFORMATION);
            let asked = self.reconnected(config, own, response)
                && self.conversation.start_attribute(&owner, config.tries).is_ok();
            self.keep_time();
            if !asked {
                self.leave_verification(config, own);
            }
            return;
        }
        match response {
            // A slave that is nobody's answers no poll: its watchdog judges.
            &Response::Success { data: &[_, owner], .. } if owner != own.number() && owner != NOBODY => {
                self.taken_over(config, own);
            }
            Response::Success { .. } | Response::Error { .. } => self.leave_verification(config, own),
        }
    }

    fn leave_verification(&mut self, config: &Config, own: MacId) {
        self.end_verification(config, own);
        self.close(config, own);
    }

    /// Back to the explicit connection, whatever the slave would have said. One that the UCMM opened for the question is left
    /// to who asks next.
    pub(super) fn end_verification(&mut self, config: &Config, own: MacId) {
        if self.talk.stage == TalkStage::Verifying {
            self.talk.stage = TalkStage::Idle;
            if self.ucmm {
                self.conversation.cancel();
            } else {
                let route = Route::predefined(own, self.entry.mac_id, self.format);
                self.conversation.reroute(route, config.connected);
            }
            self.keep_time();
        }
    }

    fn reconnected(&mut self, config: &Config, own: MacId, response: &Response<'_>) -> bool {
        let slave = self.entry.mac_id;
        match (self.ucmm, response) {
            (true, Response::Success { data, .. }) => {
                let Some((route, connection)) = self.route_opened(own, data) else { return false };
                self.opened = Some(connection);
                self.conversation.reroute(route, config.connected);
                true
            }
            (false, Response::Success { data, .. }) => {
                let Some(format) = door::format_told(data) else { return false };
                self.format = format;
                self.conversation.reroute(Route::predefined(own, slave, format), config.connected);
                true
            }
            // It was there all the time: the request was lost, or only its response. What may not be carried out twice is
            // not sent twice.
            (false, Response::Error { status: GeneralStatus::ALREADY_IN_REQUESTED_STATE, .. }) => {
                let route = Route::predefined(own, slave, self.format);
                self.conversation.reroute(route, config.connected);
                self.talk.tries > 1
            }
            (_, Response::Error { .. }) => false,
        }
    }

    /// No response while the slave runs.
    pub(super) fn talk_failed(&mut self, config: &Config, own: MacId, failure: Failure) {
        match (self.talk.stage, failure) {
            (TalkStage::Asking { reconnect: true }, Failure::NoResponse | Failure::NotAcknowledged) => {
                self.connect(config, own)
            }
            (TalkStage::Asking { .. } | TalkStage::Connecting, _) => {
                self.end_talk(Err(failure));
                self.close(config, own);
            }
            (TalkStage::Closing, _) => self.talk.stage = TalkStage::Idle,
            // Nobody is at the door through which the slave was brought up, while another polls it: it may be another device. Bringing
            // it up anew tries both doors.
            (TalkStage::Verifying, Failure::NoResponse | Failure::NotAcknowledged)
                if self.opened.is_none() =>
            {
                self.lost(Cause::TimedOut);
            }
            (TalkStage::Verifying, _) => self.leave_verification(config, own),
            (TalkStage::Idle, _) => {}
        }
    }

    /// The slave is lost, or the master: so is the request.
    pub(super) fn abandon_talk(&mut self) {
        match self.talk.stage {
            TalkStage::Connecting | TalkStage::Asking { .. } => self.end_talk(Err(Failure::NoResponse)),
            TalkStage::Idle | TalkStage::Closing | TalkStage::Verifying => self.talk.stage = TalkStage::Idle,
        }
        self.opened = None;
    }

    fn end_talk(&mut self, result: Result<(), Failure>) {
        self.talk.stage = TalkStage::Idle;
        if result.is_err() {
            self.talk.data.clear();
            count(&mut self.counters.explicit_failed);
        }
        self.raise(result.map_or_else(SlaveEvent::RequestFailed, |()| SlaveEvent::Response));
    }

    /// Closes what the UCMM opened for a request, or for one that could not be sent.
    pub(super) fn close(&mut self, config: &Config, own: MacId) {
        if self.opened.is_some() {
            self.let_go(config, own, AllocationChoice::EXPLICIT);
            self.opened = None;
            self.talk.stage = TalkStage::Closing;
        }
    }
}

/// BYTE allocation choice, USINT MAC ID of the master.
const ALLOCATION_INFORMATION: AttributeId = AttributeId(5);
/// The MAC ID of the master in it while there is none.
const NOBODY: u8 = 255;
