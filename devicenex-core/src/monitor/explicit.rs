//! Explicit messages, on a connection or without one: complete ones, fragments, acknowledges.

use cip_core::code::ServiceCode;
use cip_core::codec::Wire as _;
use cip_core::fragment::{AckStatus, FragmentByte, FragmentKind};
use cip_core::message::{BodyFormat, Response};
use cip_core::monitor::packet::has_parts;
use cip_core::monitor::{
    Answered, ConnectionState, Explicit, Flaw, Flow, Frag, Seen, Slots, Stream, likely_format,
};

use super::connections::{ConnectionName, Held};
use super::kind::Kind;
use super::learn;
use super::nodes::Roles;
use super::problem::Problem;
use super::reading::{Fields, Message, Reading};
use super::state::State;
use super::talk::{Ends, Pairing, Port, Request};
use super::vocabulary::DEVICENEX;
use crate::id::{Direction, Framing, OperationalAddress, Route};

/// A frame of an explicit message: from whom to whom, and where.
#[derive(Debug, Clone, Copy)]
struct Path {
    ends: Ends,
    flow: Flow,
    /// Position of the connection; `None` without one.
    connection: Option<usize>,
    stream: Stream,
    /// The stream of the other direction.
    opposite: Stream,
}

/// A complete message, read.
struct Parsed {
    kind: Kind,
    fields: Fields<'static>,
    request: Option<Answered>,
    problem: Option<Problem>,
    assumed: bool,
}

/// Reads a frame of class 11100 or 10mmm.
pub(super) fn observe<'s, const N: usize, const B: usize>(
    state: &mut State<N>,
    slots: &'s mut Slots<N, B>,
    reading: &mut Reading<'_>,
    port: Port,
    route: Route,
    framing: Framing,
) -> Option<Message<'s>> {
    reading.src = Some(route.source);
    reading.dst = Some(route.destination);
    let (flow, client, server) = match route.direction {
        Direction::Request => (Flow::Consumed, route.source, route.destination),
        Direction::Response => (Flow::Produced, route.destination, route.source),
    };
    let ends = Ends { client, server, port };
    reading.kind = kind(port, flow);
    if client.is_none() || server.is_none() {
        reading.flag(Problem::NoAddress);
        return None;
    }
    state.add_role(client, Roles::CLIENT);
    if flow == Flow::Produced {
        state.add_role(server, Roles::SERVER);
    }
    let connection = if port == Port::Explicit { connection(state, reading, ends, flow) } else { None };
    let path = Path {
        ends,
        flow,
        connection,
        stream: stream(route.source, route.destination, port, flow),
        opposite: stream(route.destination, route.source, port, flow.opposite()),
    };
    match framing {
        Framing::Complete { transaction } => {
            complete(state, slots, reading, &path, transaction);
            None
        }
        Framing::Fragment(byte) => {
            reading.kind = Kind::Fragment;
            reading.frag = Some(Frag::new(byte));
            if byte.kind == FragmentKind::Acknowledge {
                reading.kind = Kind::FragmentAck;
                acknowledge(state, slots, reading, &path, byte);
                return None;
            }
            fragment(state, slots, reading, &path, byte)
        }
    }
}

/// What the connection has to say of a frame on it, and where it is kept.
fn connection<const N: usize>(
    state: &mut State<N>,
    reading: &mut Reading<'_>,
    ends: Ends,
    flow: Flow,
) -> Option<usize> {
    let Ends { client, server, .. } = ends;
    let at = reading.at;
    let index = match state.explicit(server, client) {
        Some(index) => index,
        None => {
            let held = Held::unknown(server, ConnectionName::Explicit, at);
            state.insert(Held { client: Some(client), ..held })?
        }
    };
    let held = state.held(index)?;
    held.client = Some(client);
    held.settle(at);
    held.connection.count(reading.frame.data().len());
    held.connection.explicit(reading, flow, at);
    reading.connection = Some(held.told());
    Some(index)
}

/// The message is the frame.
fn complete<const N: usize, const B: usize>(
    state: &mut State<N>,
    slots: &mut Slots<N, B>,
    reading: &mut Reading<'_>,
    path: &Path,
    transaction: u8,
) {
    slots.discard(path.stream);
    slots.discard(path.opposite);
    let at = reading.at;
    let mut unacknowledged = None;
    if let Some(talk) = state.talk(path.ends, at) {
        unacknowledged = talk.flights.give_up_all(at);
        talk.flights.know();
    }
    let seen = Seen { n: reading.n, at };
    let frame = reading.frame;
    let parsed = message(state, path, seen, Some(transaction), frame.data());
    reading.kind = parsed.kind;
    reading.fields = parsed.fields;
    around(reading, &parsed);
    reading.flag_if(unacknowledged);
}

fn fragment<'s, const N: usize, const B: usize>(
    state: &mut State<N>,
    slots: &'s mut Slots<N, B>,
    reading: &mut Reading<'_>,
    path: &Path,
    byte: FragmentByte,
) -> Option<Message<'s>> {
    let (at, seen) = (reading.at, Seen { n: reading.n, at: reading.at });
    let frame = reading.frame;
    let mut piece = frame.data();
    if piece.is_empty() {
        reading.flag(Flaw::TooShort { at_least: 1, found: 0 });
    }
    if path.ends.port == Port::Connectionless && path.flow == Flow::Consumed {
        reading.flag(Flaw::FragmentNotAllowed);
    }
    let mut transaction = None;
    let mut known = false;
    if let Some(talk) = state.talk(path.ends, at) {
        known = talk.flights.is_known(path.flow);
        talk.flights.learn(path.flow, byte.kind);
        reading.flag_if(talk.flights.send(path.flow, seen, byte, false));
        if byte.kind == FragmentKind::First {
            // A new message: what the other side was sending is given up.
            reading.flag_if(talk.flights.give_up(path.flow.opposite(), at));
            *talk.transaction(path.flow) = piece.first().copied();
        }
        transaction = *talk.transaction(path.flow);
    }
    if byte.kind == FragmentKind::First {
        slots.discard(path.opposite);
        piece = piece.get(1..).unwrap_or_default();
    }
    reading.fields.transaction = transaction;
    let (piece, _) = slots.explicit(path.stream, at, false, byte, piece);
    let body = piece.whole(reading, byte, known)?;
    let parsed = message(state, path, seen, transaction, body);
    around(reading, &parsed);
    Some(Message { kind: parsed.kind, fields: parsed.fields, data: body })
}

fn acknowledge<const N: usize, const B: usize>(
    state: &mut State<N>,
    slots: &mut Slots<N, B>,
    reading: &mut Reading<'_>,
    path: &Path,
    byte: FragmentByte,
) {
    let frame = reading.frame;
    let frag = Frag { byte, status: frame.data().first().copied() };
    reading.frag = Some(frag);
    if let Some(AckStatus::Reserved(found)) = frag.status.map(AckStatus::from) {
        reading.flag(Flaw::ReservedValue { field: "acknowledge status", found: found.into() });
    }
    if frame.data().len() != 1 {
        let found = u16::try_from(frame.data().len()).unwrap_or_default();
        reading.flag(Flaw::Length { expected: 1, found });
    }
    let (acknowledged, at) = (path.flow.opposite(), reading.at);
    let Some(talk) = state.talk(path.ends, at) else { return };
    if talk.flights.acknowledge(reading, acknowledged, at, frag, false) {
        slots.discard(path.opposite);
    }
}

/// Reads a complete message. Its transaction ID is `None` if its first fragment was not seen.
fn message<const N: usize>(
    state: &mut State<N>,
    path: &Path,
    seen: Seen,
    transaction: Option<u8>,
    body: &[u8],
) -> Parsed {
    match path.flow {
        Flow::Consumed => request(state, path, seen, transaction, body),
        Flow::Produced => response(state, path, seen, transaction, body),
    }
}

fn request<const N: usize>(
    state: &mut State<N>,
    path: &Path,
    seen: Seen,
    transaction: Option<u8>,
    body: &[u8],
) -> Parsed {
    // Without a connection the body format is always 8/8.
    let mut format = BodyFormat::Class8Instance8;
    let mut assumed = false;
    if let Some(held) = path.connection.and_then(|index| state.held(index)) {
        if !held.is_format_told
            && let Some(likely) = likely_format(body)
        {
            held.format = likely;
        }
        format = held.format;
        assumed = !held.is_format_told;
    }
    let read = Explicit::request(format, body, 0);
    let fields = Fields { explicit: read.explicit, transaction, ..Fields::default() };
    let mut problem = read.flaw.map(Problem::from);
    let kind = kind(path.ends.port, path.flow);
    if let Some(service) = read.explicit.service
        && kind == Kind::ConnectionlessRequest
        && service != ServiceCode::GET_ATTRIBUTE_SINGLE
    {
        problem = problem.or(Some(Flaw::UnexpectedService { service }.into()));
    }
    if let (Some(asked), Some(transaction)) = (read.asked, transaction) {
        let request = Request { seen, transaction, asked, format, connect: None, assumed };
        let is_kept = state.talk(path.ends, seen.at).is_none_or(|talk| talk.ask(request));
        state.lost.requests = state.lost.requests.saturating_add(u64::from(!is_kept));
        if has_parts(asked.service) {
            let kept = state.packets.keep(seen.n, &asked, format, body, &DEVICENEX);
            state.lost.requests = state.lost.requests.saturating_add(u64::from(kept.is_other_lost));
            problem = problem.or(kept.flaw.map(Problem::from).filter(|_| !assumed));
        }
    }
    Parsed { kind, fields, request: None, problem, assumed }
}

fn response<const N: usize>(
    state: &mut State<N>,
    path: &Path,
    seen: Seen,
    transaction: Option<u8>,
    body: &[u8],
) -> Parsed {
    let read = Explicit::response(body, 0);
    let fields = Fields { explicit: read.explicit, transaction, ..Fields::default() };
    let kind = kind(path.ends.port, path.flow);
    let problem = read.flaw.map(Problem::from);
    let mut parsed = Parsed { kind, fields, request: None, problem, assumed: false };
    let Some(transaction) = transaction.filter(|_| read.is_response) else { return parsed };
    let service = read.explicit.service.unwrap_or(ServiceCode::ERROR_RESPONSE);
    let fits = |request: &Request| {
        if service == request.asked.service || service == ServiceCode::ERROR_RESPONSE {
            Ok(())
        } else {
            Err(Flaw::ServiceMismatch { expected: request.asked.service })
        }
    };
    let pairing = state.talk(path.ends, seen.at).map(|talk| talk.answer(transaction, fits));
    let request = match pairing {
        Some(Pairing::Answers(request)) => request,
        Some(Pairing::Wrong(flaw)) => {
            parsed.problem = parsed.problem.or(Some(flaw.into()));
            return parsed;
        }
        Some(Pairing::Assumed) | None => {
            parsed.assumed = true;
            return parsed;
        }
    };
    let answered = request.seen.answered(seen.at);
    parsed.request = Some(answered);
    parsed.assumed = request.assumed;
    parsed.fields.explicit.answers(&request.asked, body);
    if let Some(held) = path.connection.and_then(|index| state.held(index)) {
        held.last_latency = Some(answered.latency);
        if held.connection.state != ConnectionState::Established {
            held.connection.infer(ConnectionState::Established, seen.at);
        }
    }
    if let Ok(Response::Success { data, .. }) = Response::parse(body) {
        let learned = learn::success(state, path.ends.server, &request, data, seen.at);
        parsed.problem = parsed.problem.or(learned.filter(|_| !request.assumed));
    }
    parsed
}

/// What concerns the frame that is or completes a message.
fn around(reading: &mut Reading<'_>, parsed: &Parsed) {
    reading.request = parsed.request;
    reading.flag_if(parsed.problem);
    reading.assumed |= parsed.assumed;
}

const fn kind(port: Port, flow: Flow) -> Kind {
    match (port, flow) {
        (Port::Explicit, Flow::Consumed) => Kind::ExplicitRequest,
        (Port::Explicit, Flow::Produced) => Kind::ExplicitResponse,
        (_, Flow::Consumed) => Kind::ConnectionlessRequest,
        (_, Flow::Produced) => Kind::ConnectionlessResponse,
    }
}

/// Fragments of one sender to one receiver, in one direction of one port, are pieces of one message.
fn stream(from: OperationalAddress, to: OperationalAddress, port: Port, flow: Flow) -> Stream {
    let port = if port == Port::Explicit { 1 } else { 0 };
    let flow = if flow == Flow::Produced { 2 } else { 0 };
    Stream::explicit(EXPLICIT | u32::from(from.number()) << 8 | u32::from(to.number()), port | flow)
}

/// Apart from the streams of implicit messages, whose numbers are identifiers.
const EXPLICIT: u32 = 0x4000_0000;
