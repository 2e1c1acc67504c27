//! What requests and responses say, from the service byte on.

use cip_core::code::{ClassId, ServiceCode};
use cip_core::codec::{ParseError, ParseErrorKind, Wire};
use cip_core::message::{
    AllocateRequest, AllocateResponse, AllocationChoice, BodyFormat, ReleaseRequest, Request, Response,
};

use super::connections::Flow;
use super::explicit::{Knowledge, Route};
use super::kind::Kind;
use super::learn;
use super::pairing::{Seen, Transaction};
use super::problem::Problem;
use super::reading::{Answered, Detail, Fields, Note, Reading, Span};
use super::state::State;
use crate::id::MacId;
use crate::message::ExplicitHeader;

/// A complete message, read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Parsed {
    pub(super) kind: Kind,
    pub(super) fields: Fields,
    pub(super) request: Option<Answered>,
    pub(super) problem: Option<Problem>,
    pub(super) note: Option<Note>,
    pub(super) assumed: bool,
}

impl Parsed {
    pub(super) fn new(kind: Kind) -> Self {
        Self { kind, fields: Fields::default(), request: None, problem: None, note: None, assumed: false }
    }

    /// The message is the frame.
    pub(super) fn apply(self, reading: &mut Reading<'_>) {
        reading.kind = self.kind;
        reading.fields = self.fields;
        self.apply_around(reading);
    }

    /// The frame completes the message: what concerns the frame.
    pub(super) fn apply_around(self, reading: &mut Reading<'_>) {
        reading.request = self.request;
        reading.flag_if(self.problem);
        reading.note = reading.note.or(self.note);
        reading.assumed |= self.assumed;
    }

    fn flag(&mut self, problem: Problem) {
        self.problem.get_or_insert(problem);
    }
}

/// Reads a complete message of an explicit connection. `before` is the number of bytes before the service byte in what
/// the reader of the fields will see.
pub(super) fn message<const N: usize>(
    state: &mut State<N>,
    route: &Route,
    seen: Seen,
    header: ExplicitHeader,
    body: &[u8],
    before: usize,
) -> Parsed {
    match route.flow {
        Flow::Consumed => connected_request(state, route, seen, header, body, before),
        Flow::Produced => connected_response(state, route, seen, header, body, before),
    }
}

fn connected_request<const N: usize>(
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
    channel.pending = transaction.map(|transaction| Transaction { assumed, ..transaction });
    parsed
}

/// Reads a request in a body format.
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
    let Some((&byte, rest)) = body.split_first() else {
        parsed.flag(Problem::TooShort { at_least: 2, found: 1 });
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
        parsed.flag(Problem::ResponseBitOnRequest);
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
                transaction.argument = le16(access.value);
                value = access.value;
            }
            Err(error) => parsed.flag(problem_of(error, request.data.len())),
        },
        _ => {}
    }
    parsed.fields.value = Span::tail(body.len().saturating_add(before), value.len());
    (parsed, Some(transaction))
}

fn connected_response<const N: usize>(
    state: &mut State<N>,
    route: &Route,
    seen: Seen,
    header: ExplicitHeader,
    body: &[u8],
    before: usize,
) -> Parsed {
    let (server, client) = (route.link.server, route.client);
    let mut parsed = match response(Kind::ExplicitResponse, body, before) {
        Ok(parsed) => parsed,
        Err(parsed) => return parsed,
    };
    let service = parsed.fields.service.unwrap_or(ServiceCode::ERROR_RESPONSE);
    let channel = state.channel(route.link);
    let (pending, asked) = (channel.pending, channel.asked);
    let connected = pending.filter(|request| request.is_answered_by(client, header.xid, service));
    // Both the connection and the unconnected port answer on one identifier: the older request is answered first.
    let port = match route.link.dynamic {
        None => state.node(server).port.find(client, header.xid, service).copied(),
        Some(_) => None,
    };
    let on_port = match (connected, port) {
        (Some(connected), Some(port)) => port.seen.n < connected.seen.n,
        (None, Some(_)) => true,
        (_, None) => false,
    };
    let Some(transaction) = (if on_port { port } else { connected }) else {
        unpaired(state, route, &mut parsed, pending.ok_or(asked), header, body);
        return parsed;
    };
    if on_port {
        state.node(server).port.remove(transaction.seen.n);
        parsed.kind = Kind::UnconnectedResponse;
    } else {
        state.channel(route.link).pending = None;
    }
    parsed.request = Some(transaction.seen.answered(seen.at));
    parsed.assumed = transaction.assumed;
    fill(&mut parsed, &transaction, body);
    if let Ok(Response::Success { data, .. }) = Response::parse(body) {
        parsed.problem = parsed.problem.or(learn::success(state, server, &transaction, data, seen.at));
    }
    parsed
}

/// Reads the service byte and what follows it of a response; `Err` is a message that is none.
pub(super) fn response(kind: Kind, body: &[u8], before: usize) -> Result<Parsed, Parsed> {
    let mut parsed = Parsed::new(kind);
    let total = body.len().saturating_add(before);
    let Some((&byte, rest)) = body.split_first() else {
        parsed.flag(Problem::TooShort { at_least: 2, found: 1 });
        return Err(parsed);
    };
    let (service, is_response) = ServiceCode::split(byte);
    parsed.fields.service = Some(service);
    parsed.fields.value = Span::tail(total, rest.len());
    if !is_response {
        parsed.flag(Problem::RequestBitOnResponse);
        return Err(parsed);
    }
    match Response::parse(body) {
        Ok(Response::Success { .. }) => {}
        Ok(Response::Error { status, additional }) => {
            parsed.fields.value = None;
            parsed.fields.status = Some(status);
            parsed.fields.additional = Some(additional);
        }
        Err(error) => parsed.flag(problem_of(error, body.len())),
    }
    Ok(parsed)
}

/// Gives a response what only its request has said.
pub(super) fn fill(parsed: &mut Parsed, transaction: &Transaction, body: &[u8]) {
    let fields = &mut parsed.fields;
    fields.requested = Some(transaction.service);
    fields.class = transaction.class;
    fields.instance = transaction.instance;
    fields.attribute = transaction.attribute;
    let of_set = transaction.class == Some(ClassId::DEVICENET)
        && matches!(transaction.service, ServiceCode::ALLOCATE | ServiceCode::RELEASE);
    if of_set {
        let [choice, _] = transaction.argument.to_le_bytes();
        fields.choice = Some(AllocationChoice::from_bits_retain(choice));
        if let (Some(status), Some(additional)) = (fields.status, fields.additional) {
            parsed.flag(Problem::Refused { status, additional });
            return;
        }
    }
    let Ok(Response::Success { service, data }) = Response::parse(body) else { return };
    let of_rate = transaction.class == Some(ClassId::CONNECTION)
        && transaction.attribute.is_some_and(|attribute| attribute.0 == learn::EXPECTED_PACKET_RATE)
        && service == ServiceCode::SET_ATTRIBUTE_SINGLE;
    if of_set && service == ServiceCode::ALLOCATE {
        allocated(parsed, data);
    } else if of_rate && let &[low, high] = data {
        let used = u16::from_le_bytes([low, high]);
        parsed.fields.detail = Detail::PacketRate { requested: Some(transaction.argument), used };
    }
}

/// A response whose request is not known: another one is pending, or none is, and whether one ever was.
fn unpaired<const N: usize>(
    state: &mut State<N>,
    route: &Route,
    parsed: &mut Parsed,
    pending: Result<Transaction, bool>,
    header: ExplicitHeader,
    body: &[u8],
) {
    let client = route.client;
    let service = parsed.fields.service.unwrap_or(ServiceCode::ERROR_RESPONSE);
    match pending {
        Ok(request) if request.requester != client => {
            parsed.flag(Problem::WrongRequester { expected: request.requester });
        }
        Ok(request) if request.xid != header.xid => parsed.flag(Problem::TransactionMismatch),
        Ok(request) if request.service != service => {
            parsed.flag(Problem::ServiceMismatch { expected: request.service });
        }
        Ok(_) | Err(true) => parsed.flag(Problem::UnexpectedResponse),
        Err(false) => parsed.assumed = true,
    }
    if let Ok(Response::Success { service: ServiceCode::ALLOCATE, data: &[format] }) = Response::parse(body) {
        allocated(parsed, &[format]);
        let channel = state.channel(route.link);
        if channel.knowledge == Knowledge::None
            && let Some(format) = BodyFormat::from_code(format)
        {
            channel.format = format;
            channel.knowledge = Knowledge::Likely;
        }
    }
}

fn allocate(data: &[u8], parsed: &mut Parsed, transaction: &mut Transaction) {
    match AllocateRequest::parse(data) {
        Ok(AllocateRequest { choice, allocator }) => {
            parsed.fields.choice = Some(choice);
            parsed.fields.detail = Detail::Allocate { allocator };
            transaction.argument = u16::from_le_bytes([choice.bits(), allocator]);
            transaction.allocator = MacId::new(allocator);
            if !AllocationChoice::all().contains(choice) {
                parsed.flag(Problem::ReservedBits { field: "allocation choice" });
            }
            if transaction.allocator.is_none() {
                parsed.flag(Problem::ReservedBits { field: "allocator's MAC ID" });
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
                parsed.flag(Problem::ReservedBits { field: "release choice" });
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

fn allocated(parsed: &mut Parsed, data: &[u8]) {
    match AllocateResponse::parse(data) {
        Ok(AllocateResponse { body_format }) => {
            parsed.fields.detail = Detail::Allocated { format: body_format };
            if BodyFormat::from_code(body_format).is_none() {
                parsed.flag(Problem::ReservedValue { field: "body format", found: body_format.into() });
            }
        }
        Err(error) => parsed.flag(problem_of(error, data.len())),
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

/// A parse error as a problem; its offsets count from the service byte or service data, which is where the reader
/// looks for what is missing.
pub(super) fn problem_of(error: ParseError, len: usize) -> Problem {
    let narrow = |value: usize| u16::try_from(value).unwrap_or(u16::MAX);
    match error.kind {
        ParseErrorKind::Short { expected, .. } => {
            Problem::TooShort { at_least: narrow(error.offset.saturating_add(expected)), found: narrow(len) }
        }
        ParseErrorKind::Trailing { .. } => {
            Problem::Length { expected: narrow(error.offset), found: narrow(len) }
        }
        ParseErrorKind::Value { found } => {
            let found = u16::try_from(found).unwrap_or(u16::MAX);
            Problem::ReservedValue { field: error.field, found }
        }
    }
}

fn le16(value: &[u8]) -> u16 {
    match *value {
        [] => 0,
        [low] => low.into(),
        [low, high, ..] => u16::from_le_bytes([low, high]),
    }
}
