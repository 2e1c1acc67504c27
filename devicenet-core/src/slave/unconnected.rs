//! The Group 2 unconnected port: Allocate and Release on 0x406 + 8s, answered on 0x403 + 8s.
//!
//! | Condition | Reaction |
//! |---|---|
//! | fragment, or a response | ignored |
//! | too short for service, class and instance | ignored, or 0x13 |
//! | another service than 0x4B and 0x4C | 0x02 / 0x03 |
//! | another object than class 3, instance 1 | 0x16 |
//! | more requests at once than answers can wait | ignored: none is carried out whose answer would be lost |
//!
//! It is served for everybody, also while the explicit connection exists: so a second master learns that there is a
//! first one.

use cip_core::code::{AdditionalCode, ClassId, GeneralStatus, InstanceId, ServiceCode};
use cip_core::codec::Writer;
use cip_core::message::BodyFormat;
use cip_core::object::{Call, Failure};
use heapless::Vec;

use super::allocation::{Door, Requester};
use super::application::Application;
use super::config::Options;
use super::event::Ignored;
use super::machine::Slave;
use crate::id::{Identifier, MacId};
use crate::message::ExplicitHeader;

/// The response of an unconnected port, until it is sent.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Answer {
    /// On the line of the UCMM; else on that of the explicit connection.
    pub(super) ucmm: bool,
    pub(super) field: Vec<u8, 6, u8>,
}

impl<A: Application, const MESSAGE: usize, const DYNAMIC: usize> Slave<A, MESSAGE, DYNAMIC> {
    #[inline(never)]
    pub(super) fn unconnected_frame(&mut self, id: Identifier, field: &[u8]) {
        if DYNAMIC > 0 && !self.node.options.contains(Options::UNCONNECTED_PORT) {
            return self.foreign();
        }
        if let Err(why) = self.unconnected_request(field) {
            self.node.ignored(id, why);
        }
    }

    fn unconnected_request(&mut self, field: &[u8]) -> Result<(), Ignored> {
        let (header, body) = complete_request(field)?;
        self.check_room()?;
        let mut field = [0; 5];
        let mut out = Writer::new(&mut field);
        // There is room for it.
        let _ = out.u8(header);
        let (mut server, ..) = self.serving(Requester {
            mac: MacId::from_low_bits(header),
            door: Door::Unconnected,
            format: BodyFormat::Class8Instance8,
        });
        server.answer(body, &mut out)?;
        self.queue(false, out.written());
        Ok(())
    }

    /// No request is carried out whose answer would be lost.
    pub(super) fn check_room(&self) -> Result<(), Ignored> {
        self.check_departure()?;
        if self.answers.is_full() { Err(Ignored::Busy) } else { Ok(()) }
    }

    /// `field`: the header of the answer, and its body.
    pub(super) fn queue(&mut self, ucmm: bool, field: &[u8]) {
        let Ok(field) = Vec::from_slice(field) else {
            debug_assert!(false, "the answer of an unconnected port has up to six bytes");
            return;
        };
        // There is room: it was checked before the request was carried out.
        let _ = self.answers.push(Answer { ucmm, field });
    }

    /// The first answer that waits for a line.
    pub(super) fn take_answer(&mut self, ucmm: bool) -> Option<Answer> {
        // Without dynamic connections all answers wait for the same line.
        if DYNAMIC == 0 { self.answers.pop() } else { self.answers.pop_where(|answer| answer.ucmm == ucmm) }
    }

    /// Whether an answer waits for a line.
    pub(super) fn is_answer_due(&self, ucmm: bool) -> bool {
        if DYNAMIC == 0 {
            !self.answers.is_empty()
        } else {
            self.answers.iter().any(|answer| answer.ucmm == ucmm)
        }
    }
}

/// The header and the body of a request that is never fragmented.
pub(super) fn complete_request(field: &[u8]) -> Result<(u8, &[u8]), Ignored> {
    let (&header, body) = field.split_first().ok_or(Ignored::TooShort)?;
    if ExplicitHeader::from(header).fragmented {
        return Err(Ignored::Fragment);
    }
    match body.first() {
        Some(&service) if ServiceCode::split(service).1 => Err(Ignored::Response),
        Some(_) => Ok((header, body)),
        None => Err(Ignored::TooShort),
    }
}

/// Whether the port is there for this request.
pub(super) fn check(call: &Call<'_>) -> Result<(), Failure> {
    if call.service != ServiceCode::ALLOCATE && call.service != ServiceCode::RELEASE {
        return Err(Failure::new(GeneralStatus::RESOURCE_UNAVAILABLE)
            .with_additional(AdditionalCode::INVALID_UNCONNECTED_SERVICE));
    }
    if call.class != ClassId::DEVICENET || call.instance != InstanceId(1) {
        return Err(GeneralStatus::OBJECT_DOES_NOT_EXIST.into());
    }
    Ok(())
}
