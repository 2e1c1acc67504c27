//! What requests say, from the service byte on.

use cip_core::code::{AttributeId, ClassId, InstanceId, ServiceCode};
use cip_core::codec::Wire;
use cip_core::message::{AllocateRequest, AllocationChoice, BodyFormat, ReleaseRequest, Request};
use cip_core::monitor::attribute::{CONSUMED_PATH, PRODUCED_PATH, instance_of};
use cip_core::monitor::{Flaw, Seen, Span};
use link_core::Instant;

use super::bodies::{Parsed, problem_of};
use super::explicit::{Knowledge, Route};
use super::kind::Kind;
use super::packet;
use super::pairing::Transaction;
use super::reading::{Detail, Fields};
use super::state::State;
use crate::id::MacId;
use crate::message::ExplicitHeader;

/// Reads a request on an explicit connection.
pub(super) fn connected<const N: usize>(
    state: &mut State<N>,
    route: &Route,
    seen: Seen,
    header: ExplicitHeader,
    body: &[u8],
    before: usize,
) -> Parsed {
    let channel = state.channel(route.link);
    if channel.knowledge == Knowledge::None
        && let Some(format) = likely_format(body)
    {
        channel.format = format;
    }
    let assumed = channel.knowledge != Knowledge::Told;
    let (mut parsed, transaction) =
        request(Kind::ExplicitRequest, channel.format, seen, route.client, header, body, before);
    parsed.assumed = assumed;
    channel.asked = true;
    let format = channel.format;
    // The server ignores a client that does not own the connection: the request of the one that does waits on.
    let waits = channel.pending.is_some_and(|held| held.requester != route.client);
    if route.intrudes && waits {
        return parsed;
    }
    let Some(transaction) = transaction else { return parsed };
    channel.pending = Some(Transaction { assumed, ..transaction });
    if packet::has_parts(transaction.service) {
        let problem = packet::asked(state, &Transaction { assumed, ..transaction }, format, body);
        parsed.problem = parsed.problem.or(problem.filter(|_| !assumed));
    }
    parsed
}

/// Reads a request inside of another.
pub(super) fn part(whole: &Transaction, format: BodyFormat, body: &[u8]) -> (Parsed, Option<Transaction>) {
    let header = ExplicitHeader { fragmented: false, xid: whole.xid, mac: whole.requester };
    let (parsed, part) = request(Kind::ExplicitRequest, format, whole.seen, whole.requester, header, body, 0);
    (parsed, part.map(|part| Transaction { assumed: whole.assumed, ..part }))
}

/// What a request inside of another says.
pub(super) fn part_fields(format: BodyFormat, body: &[u8]) -> Fields<'static> {
    let header = ExplicitHeader::from(0);
    let seen = Seen { n: 0, at: Instant::ZERO };
    request(Kind::ExplicitRequest, format, seen, header.mac, header, body, 0).0.fields
}

/// Reads a request in a body format. Some servers answer even to a message with the response bit set.
pub(super) fn request(
    kind: Kind,
    format: BodyFormat,
    seen: Seen,
    requester: MacId,
    header: ExplicitHeader,
    body: &[u8],
    before: usize,
) -> (Parsed, Option<Transaction>) {
    let mut parsed = Parsed::new(kind);
    parsed.fields.format = format;
    let Some((&byte, rest)) = body.split_first() else {
        parsed.flag(Flaw::TooShort { at_least: 2, found: 1 });
        return (parsed, None);
    };
    let (service, is_response) = ServiceCode::split(byte);
    parsed.fields.service = Some(service);
    let mut transaction = Transaction {
        seen,
        requester,
        xid: header.xid,
        service,
        class: None,
        instance: None,
        attribute: None,
        argument: 0,
        allocator: None,
        assumed: false,
    };
    if is_response {
        parsed.fields.value = Span::tail(body.len().saturating_add(before), rest.len());
        parsed.flag(Flaw::ResponseBitOnRequest);
        return (parsed, Some(transaction));
    }
    let request = match Request::parse(format, body) {
        Ok(request) => request,
        Err(error) => {
            parsed.fields.value = Span::tail(body.len().saturating_add(before), rest.len());
            parsed.flag(problem_of(error, body.len()));
            return (parsed, Some(transaction));
        }
    };
    let (class, instance) = (request.target.class(), request.target.instance());
    parsed.fields.class = class;
    parsed.fields.instance = instance;
    transaction.class = class;
    transaction.instance = instance;
    let mut value = request.data;
    match (class, service) {
        (Some(ClassId::DEVICENET), ServiceCode::ALLOCATE) => {
            value = &[];
            allocate(request.data, &mut parsed, &mut transaction);
        }
        (Some(ClassId::DEVICENET), ServiceCode::RELEASE) => {
            value = &[];
            release(request.data, &mut parsed, &mut transaction);
        }
        _ if names_attribute(service) => match request.attribute_access() {
            Ok(access) => {
                parsed.fields.attribute = Some(access.attribute);
                transaction.attribute = Some(access.attribute);
                transaction.argument = argument(class, access.attribute, access.value);
                value = access.value;
            }
            Err(error) => parsed.flag(problem_of(error, request.data.len())),
        },
        _ => {}
    }
    parsed.fields.value = Span::tail(body.len().saturating_add(before), value.len());
    (parsed, Some(transaction))
}

fn allocate(data: &[u8], parsed: &mut Parsed, transaction: &mut Transaction) {
    match AllocateRequest::parse(data) {
        Ok(AllocateRequest { choice, allocator }) => {
            parsed.fields.choice = Some(choice);
            parsed.fields.detail = Detail::Allocate { allocator };
            transaction.argument = u16::from_le_bytes([choice.bits(), allocator]);
            transaction.allocator = MacId::new(allocator);
            if !AllocationChoice::all().contains(choice) {
                parsed.flag(Flaw::ReservedBits { field: "allocation choice" });
            }
            if transaction.allocator.is_none() {
                parsed.flag(Flaw::ReservedBits { field: "allocator's MAC ID" });
            }
        }
        Err(error) => {
            if let Some(&choice) = data.first() {
                parsed.fields.choice = Some(AllocationChoice::from_bits_retain(choice));
            }
            parsed.flag(problem_of(error, data.len()));
        }
    }
}

fn release(data: &[u8], parsed: &mut Parsed, transaction: &mut Transaction) {
    match ReleaseRequest::parse(data) {
        Ok(ReleaseRequest { choice }) => {
            parsed.fields.choice = Some(choice);
            transaction.argument = choice.bits().into();
            // Bit 6 is reserved as well, but products set it and receivers ignore it.
            if !AllocationChoice::all().contains(choice) {
                parsed.flag(Flaw::ReservedBits { field: "release choice" });
            }
        }
        Err(error) => {
            if let Some(&choice) = data.first() {
                parsed.fields.choice = Some(AllocationChoice::from_bits_retain(choice));
            }
            parsed.flag(problem_of(error, data.len()));
        }
    }
}

/// The services whose data begin with an attribute.
fn names_attribute(service: ServiceCode) -> bool {
    matches!(
        service,
        ServiceCode::GET_ATTRIBUTE_SINGLE
            | ServiceCode::SET_ATTRIBUTE_SINGLE
            | ServiceCode::GET_MEMBER
            | ServiceCode::SET_MEMBER
            | ServiceCode::INSERT_MEMBER
            | ServiceCode::REMOVE_MEMBER
    )
}

/// The body format that a Get_Attribute_Single of this length is in, for a connection whose opening was not seen.
fn likely_format(body: &[u8]) -> Option<BodyFormat> {
    match *body {
        [0x0E, _, _, _] => Some(BodyFormat::Class8Instance8),
        [0x0E, _, 0, _, _] => Some(BodyFormat::Class16Instance8),
        [0x0E, _, _, 0, _] => Some(BodyFormat::Class8Instance16),
        [0x0E, 3, 0x20, _, 0x24, _, 0x30, _] => Some(BodyFormat::CipPath),
        [0x0E, _, high, _, 0 | 1, _] if high <= 4 => Some(BodyFormat::Class16Instance16),
        _ => None,
    }
}

/// What the response to a Set does not repeat: the first two bytes of the value, of a connection path the instance that
/// it names (0: none).
pub(super) fn argument(class: Option<ClassId>, attribute: AttributeId, value: &[u8]) -> u16 {
    if class == Some(ClassId::CONNECTION) && matches!(attribute.0, PRODUCED_PATH | CONSUMED_PATH) {
        return instance_of(value).unwrap_or(InstanceId::CLASS).0;
    }
    le16(value)
}

fn le16(value: &[u8]) -> u16 {
    match *value {
        [] => 0,
        [low] => low.into(),
        [low, high, ..] => u16::from_le_bytes([low, high]),
    }
}
