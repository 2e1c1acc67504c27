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

use core::hash::{Hash, Hasher};

use cip_core::code::{AdditionalCode, ClassId, GeneralStatus, InstanceId, ServiceCode};
use cip_core::codec::Writer;
use cip_core::message::BodyFormat;
use cip_core::object::{Call, Failure};

use super::allocation::{Door, Requester};
use super::application::Application;
use super::config::Options;
use super::event::Ignored;
use super::machine::Slave;
use crate::id::{Identifier, MacId};
use crate::message::ExplicitHeader;

/// The response of an unconnected port, until it is sent. What lies behind its end is no part of it.
#[derive(Clone, Debug)]
pub(super) struct Answer {
    pub(super) port: UnconnectedPort,
    /// The header and the body: the first `len` of these.
    pub(super) field: [u8; 6],
    pub(super) len: u8,
}

/// Whose it is. It begins with 1, so that places without an answer are zeros.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[repr(u8)]
pub(super) enum UnconnectedPort {
    /// Of group 2: it goes out on the line of the explicit connection.
    Group2 = 1,
    /// The UCMM, which has a line of its own.
    Ucmm,
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
        let mut field = [0; 6];
        let mut out = Writer::new(&mut field);
        // There is room for it.
        let _ = out.u8(header);
        let (mut server, ..) = self.serving(Requester {
            mac: MacId::from_low_bits(header),
            door: Door::Unconnected,
            format: BodyFormat::Class8Instance8,
        });
        server.answer(body, &mut out)?;
        let len = out.len();
        self.queue(UnconnectedPort::Group2, field, len);
        Ok(())
    }

    /// No request is carried out whose answer would be lost.
    pub(super) fn check_room(&self) -> Result<(), Ignored> {
        self.check_departure()?;
        if self.answers.is_full() { Err(Ignored::Busy) } else { Ok(()) }
    }

    /// `field`: the header of the answer, and its body, as long as `len` says.
    pub(super) fn queue(&mut self, port: UnconnectedPort, field: [u8; 6], len: usize) {
        // There is room: it was checked before the request was carried out.
        let _ = self.answers.push(Answer { port, field, len: u8::try_from(len).unwrap_or(u8::MAX) });
    }

    /// The first answer that waits for a line.
    pub(super) fn take_answer(&mut self, port: UnconnectedPort) -> Option<Answer> {
        // Without dynamic connections all answers wait for the same line.
        if DYNAMIC == 0 { self.answers.pop() } else { self.answers.pop_where(|answer| answer.port == port) }
    }

    /// Whether an answer waits for a line.
    pub(super) fn is_answer_due(&self, port: UnconnectedPort) -> bool {
        if DYNAMIC == 0 {
            !self.answers.is_empty()
        } else {
            self.answers.iter().any(|answer| answer.port == port)
        }
    }
}

impl Answer {
    /// The data field of its frame.
    pub(super) fn field(&self) -> &[u8] {
        self.field.get(..self.len.into()).unwrap_or_default()
    }
}

impl PartialEq for Answer {
    fn eq(&self, other: &Self) -> bool {
        (self.port, self.field()) == (other.port, other.field())
    }
}

impl Eq for Answer {}

impl Hash for Answer {
    fn hash<H: Hasher>(&self, state: &mut H) {
        (self.port, self.field()).hash(state);
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
