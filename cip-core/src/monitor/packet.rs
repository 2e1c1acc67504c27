//! Requests that consist of others: Multiple_Service_Packet and Set_Attribute_List. Their responses repeat neither what
//! was asked nor what was set, so it is kept until they come.

use super::explicit::{Asked, Explicit, argument};
use super::{Flaw, Vocabulary};
use crate::code::{AttributeId, ServiceCode};
use crate::codec::Wire;
use crate::message::{
    AttributeReplies, AttributeSettings, AttributeStatusList, BodyFormat, MultipleServicePacket, Request,
    Response,
};

/// The requests inside of one, in their order; `None` for one that cannot be read.
pub type Parts = heapless::Vec<Option<Asked>, PARTS>;

/// The last requests that consist of others.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Packets {
    held: [Packet; PACKETS],
}

/// What becomes of a request that consists of others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Kept {
    /// What is wrong with it.
    pub flaw: Option<Flaw>,
    /// Another one was forgotten for it that still waits.
    pub is_other_lost: bool,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct Packet {
    /// The frame that has completed it.
    n: Option<u64>,
    is_answered: bool,
    parts: Parts,
}

impl Packets {
    /// None so far.
    #[must_use]
    pub const fn new() -> Self {
        Self { held: [const { Packet { n: None, is_answered: true, parts: Parts::new() } }; PACKETS] }
    }

    /// The parts of the request of frame `n`.
    #[must_use]
    pub fn of(&self, n: u64) -> Option<&Parts> {
        self.held.iter().find(|packet| packet.n == Some(n)).map(|packet| &packet.parts)
    }

    /// Keeps what is inside of the request of frame `n`.
    pub fn keep(
        &mut self,
        n: u64,
        asked: &Asked,
        format: BodyFormat,
        body: &[u8],
        vocabulary: &Vocabulary,
    ) -> Kept {
        let Ok(request) = Request::parse(format, body) else {
            return Kept { flaw: None, is_other_lost: false };
        };
        let (parts, flaw) = match asked.service {
            ServiceCode::MULTIPLE_SERVICE_PACKET => services(format, request.data),
            _ => (settings(asked, request.data, vocabulary), None),
        };
        Kept { flaw, is_other_lost: !self.insert(n, parts) }
    }

    /// The parts of the request of frame `n`, which is answered.
    pub fn answer(&mut self, n: u64) -> Parts {
        let held = self.held.iter_mut().find(|packet| packet.n == Some(n));
        held.map_or_else(Parts::new, |packet| {
            packet.is_answered = true;
            packet.parts.clone()
        })
    }

    /// Returns false if another one was forgotten that still waits.
    fn insert(&mut self, n: u64, parts: Parts) -> bool {
        let oldest = self.held.iter_mut().min_by_key(|packet| (!packet.is_answered, packet.n));
        let Some(packet) = oldest else { return false };
        let is_free = packet.is_answered;
        *packet = Packet { n: Some(n), is_answered: false, parts };
        is_free
    }
}

impl Default for Packets {
    fn default() -> Self {
        Self::new()
    }
}

/// True for the services whose requests consist of others.
#[must_use]
pub fn has_parts(service: ServiceCode) -> bool {
    matches!(service, ServiceCode::MULTIPLE_SERVICE_PACKET | ServiceCode::SET_ATTRIBUTE_LIST)
}

/// Tells `learn` of each part of a request that a response answers with success, and of its data. What the response reveals
/// to be wrong is returned.
pub fn answered(
    parts: &Parts,
    asked: &Asked,
    data: &[u8],
    mut learn: impl FnMut(&Asked, &[u8]),
) -> Option<Flaw> {
    if asked.service == ServiceCode::SET_ATTRIBUTE_LIST {
        let statuses = AttributeStatusList::parse(data).ok()?;
        for (part, (attribute, status)) in parts.iter().flatten().zip(statuses.iter()) {
            if part.attribute == Some(attribute) && status == 0 {
                learn(part, &[]);
            }
        }
        return None;
    }
    let packet = match MultipleServicePacket::parse(data) {
        Ok(packet) => packet,
        Err(error) => return Some(Flaw::of_parse(error, data.len())),
    };
    let mut flaw = None;
    for (part, body) in parts.iter().zip(packet.services()) {
        let Some(part) = part else { continue };
        flaw = flaw.or(Explicit::response(body, 0).flaw);
        match Response::parse(body) {
            Ok(Response::Success { service, data }) if service == part.service => learn(part, data),
            Ok(Response::Success { .. }) => {
                flaw = flaw.or(Some(Flaw::ServiceMismatch { expected: part.service }));
            }
            Ok(Response::Error { .. }) | Err(_) => {}
        }
    }
    let is_whole = !parts.is_empty() && parts.len() < PARTS;
    if is_whole && packet.services().count() > parts.len() {
        flaw = flaw.or(Some(Flaw::UnexpectedResponse));
    }
    flaw
}

/// Tells `learn` of each attribute that a response to Get_Attribute_List has brought, as of a Get_Attribute_Single.
pub fn replies(asked: &Asked, data: &[u8], vocabulary: &Vocabulary, mut learn: impl FnMut(&Asked, &[u8])) {
    let (Some(class), Some(instance), Ok(replies)) =
        (asked.class, asked.instance, AttributeReplies::parse(data))
    else {
        return;
    };
    let len = |attribute, data: &[u8]| vocabulary.value_len(class, instance, attribute, data);
    for reply in replies.iter(len).flatten() {
        let Ok(value) = reply.value else { continue };
        let service = ServiceCode::GET_ATTRIBUTE_SINGLE;
        learn(&Asked { service, attribute: Some(reply.attribute), ..*asked }, value);
    }
}

/// The requests in a Multiple_Service_Packet.
fn services(format: BodyFormat, data: &[u8]) -> (Parts, Option<Flaw>) {
    let packet = match MultipleServicePacket::parse(data) {
        Ok(packet) => packet,
        Err(error) => return (Parts::new(), Some(Flaw::of_parse(error, data.len()))),
    };
    let mut flaw = None;
    let read = |body| {
        let part = Explicit::request(format, body, 0);
        flaw = flaw.or(part.flaw);
        part.asked
    };
    let parts = packet.services().map(read).take(PARTS).collect();
    (parts, flaw)
}

/// The attributes of a Set_Attribute_List, up to the first whose length is not known.
fn settings(asked: &Asked, data: &[u8], vocabulary: &Vocabulary) -> Parts {
    let (Some(class), Some(instance), Ok(settings)) =
        (asked.class, asked.instance, AttributeSettings::parse(data))
    else {
        return Parts::new();
    };
    let single = |(attribute, value): (AttributeId, &[u8])| Asked {
        service: ServiceCode::SET_ATTRIBUTE_SINGLE,
        attribute: Some(attribute),
        argument: argument(asked.class, attribute, value),
        ..*asked
    };
    let entries = settings.iter(|attribute, data| vocabulary.value_len(class, instance, attribute, data));
    entries.map_while(Result::ok).map(|entry| Some(single(entry))).take(PARTS).collect()
}

/// Requests with parts that are kept at a time.
const PACKETS: usize = 4;
/// Parts of a request that are kept.
const PARTS: usize = 16;
