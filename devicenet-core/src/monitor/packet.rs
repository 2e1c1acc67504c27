//! Requests that consist of others: Multiple_Service_Packet and Set_Attribute_List. Their responses repeat neither what
//! was asked nor what was set, so it is kept until they come.

use cip_core::code::ServiceCode;
use cip_core::codec::Wire;
use cip_core::message::{
    AttributeSettings, AttributeStatusList, BodyFormat, MultipleServicePacket, Request, Response,
};
use cip_core::monitor::Flaw;
use cip_core::names::value_len;
use link_core::Instant;

use super::bodies::problem_of;
use super::pairing::Transaction;
use super::problem::Problem;
use super::state::{Link, State};
use super::{learn, requests, responses};

/// The requests inside of one, in their order; `None` for one that cannot be read.
pub(super) type Parts = heapless::Vec<Option<Transaction>, PARTS>;

/// The last requests that consist of others.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Packets {
    held: [Packet; PACKETS],
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct Packet {
    /// The frame that has completed it.
    n: Option<u64>,
    is_answered: bool,
    parts: Parts,
}

impl Packets {
    pub(super) const fn new() -> Self {
        Self { held: [const { Packet { n: None, is_answered: true, parts: Parts::new() } }; PACKETS] }
    }

    /// The parts of the request of frame `n`.
    pub(super) fn of(&self, n: u64) -> Option<&Parts> {
        self.held.iter().find(|packet| packet.n == Some(n)).map(|packet| &packet.parts)
    }

    /// Keeps the parts of a request. Returns false if another one was forgotten that still waits.
    fn insert(&mut self, n: u64, parts: Parts) -> bool {
        let oldest = self.held.iter_mut().min_by_key(|packet| (!packet.is_answered, packet.n));
        let Some(packet) = oldest else { return false };
        let is_free = packet.is_answered;
        *packet = Packet { n: Some(n), is_answered: false, parts };
        is_free
    }

    /// The parts of the request of frame `n`, which is answered.
    fn answer(&mut self, n: u64) -> Parts {
        let held = self.held.iter_mut().find(|packet| packet.n == Some(n));
        held.map_or_else(Parts::new, |packet| {
            packet.is_answered = true;
            packet.parts.clone()
        })
    }
}

/// True for the services whose requests consist of others.
pub(super) fn has_parts(service: ServiceCode) -> bool {
    matches!(service, ServiceCode::MULTIPLE_SERVICE_PACKET | ServiceCode::SET_ATTRIBUTE_LIST)
}

/// Keeps what is inside of a request, and says what is wrong with it.
pub(super) fn asked<const N: usize>(
    state: &mut State<N>,
    request: &Transaction,
    format: BodyFormat,
    body: &[u8],
) -> Option<Problem> {
    let data = Request::parse(format, body).ok()?.data;
    let (parts, problem) = match request.service {
        ServiceCode::MULTIPLE_SERVICE_PACKET => services(request, format, data),
        _ => (settings(request, data), None),
    };
    if !state.packets.insert(request.seen.n, parts) {
        state.lost.requests = state.lost.requests.saturating_add(1);
    }
    problem
}

/// The requests in a Multiple_Service_Packet.
fn services(request: &Transaction, format: BodyFormat, data: &[u8]) -> (Parts, Option<Problem>) {
    let packet = match MultipleServicePacket::parse(data) {
        Ok(packet) => packet,
        Err(error) => return (Parts::new(), Some(problem_of(error, data.len()))),
    };
    let mut problem = None;
    let read = |body| {
        let (parsed, part) = requests::part(request, format, body);
        problem = problem.or(parsed.problem);
        part
    };
    let parts = packet.services().map(read).take(PARTS).collect();
    (parts, problem)
}

/// The attributes of a Set_Attribute_List, up to the first whose length is not known.
fn settings(request: &Transaction, data: &[u8]) -> Parts {
    let (Some(class), Some(instance), Ok(settings)) =
        (request.class, request.instance, AttributeSettings::parse(data))
    else {
        return Parts::new();
    };
    let single = |(attribute, value)| Transaction {
        service: ServiceCode::SET_ATTRIBUTE_SINGLE,
        attribute: Some(attribute),
        argument: requests::argument(request.class, attribute, value),
        ..*request
    };
    let entries = settings.iter(|attribute, data| value_len(class, instance, attribute, data));
    entries.map_while(Result::ok).map(|entry| Some(single(entry))).take(PARTS).collect()
}

/// Learns from the response to a request with parts as from the responses to each. What it reveals to be wrong is
/// returned.
pub(super) fn answered<const N: usize>(
    state: &mut State<N>,
    link: Link,
    request: &Transaction,
    data: &[u8],
    at: Instant,
) -> Option<Problem> {
    let parts = state.packets.answer(request.seen.n);
    if request.service == ServiceCode::SET_ATTRIBUTE_LIST {
        return set(state, link, &parts, data, at);
    }
    let packet = match MultipleServicePacket::parse(data) {
        Ok(packet) => packet,
        Err(error) => return Some(problem_of(error, data.len())),
    };
    let mut problem = None;
    for (part, body) in parts.iter().zip(packet.services()) {
        let Some(part) = part else { continue };
        problem = problem.or(responses::part(Some(part), body).problem);
        match Response::parse(body) {
            Ok(Response::Success { service, data }) if service == part.service => {
                problem = problem.or(learn::success(state, link, part, data, at));
            }
            Ok(Response::Success { .. }) => {
                problem = problem.or(Some(Problem::Flaw(Flaw::ServiceMismatch { expected: part.service })));
            }
            Ok(Response::Error { .. }) | Err(_) => {}
        }
    }
    let is_whole = !parts.is_empty() && parts.len() < PARTS;
    if is_whole && packet.services().count() > parts.len() {
        problem = problem.or(Some(Problem::Flaw(Flaw::UnexpectedResponse)));
    }
    problem
}

/// Learns what a Set_Attribute_List has set.
fn set<const N: usize>(
    state: &mut State<N>,
    link: Link,
    parts: &Parts,
    data: &[u8],
    at: Instant,
) -> Option<Problem> {
    let statuses = AttributeStatusList::parse(data).ok()?;
    let mut problem = None;
    for (part, (attribute, status)) in parts.iter().flatten().zip(statuses.iter()) {
        if part.attribute == Some(attribute) && status == 0 {
            problem = problem.or(learn::success(state, link, part, &[], at));
        }
    }
    problem
}

/// Requests with parts that are kept at a time.
const PACKETS: usize = 4;
/// Parts of a request that are kept.
const PARTS: usize = 16;
