//! What responses say, from the service byte on, and which request they answer.

use cip_core::code::{ClassId, ServiceCode};
use cip_core::codec::Wire;
use cip_core::message::{AllocateResponse, AllocationChoice, BodyFormat, Response};
use cip_core::monitor::packet::has_parts;
use cip_core::monitor::{ConnectionState, Explicit, Flaw, Seen};

use super::bodies::Parsed;
use super::explicit::{Knowledge, Route};
use super::kind::Kind;
use super::learn;
use super::pairing::Transaction;
use super::problem::Problem;
use super::reading::Detail;
use super::state::State;
use crate::message::ExplicitHeader;

/// Reads a response on an explicit connection, or one to the unconnected port, which shares the identifier.
pub(super) fn connected<const N: usize>(
    state: &mut State<N>,
    route: &Route,
    seen: Seen,
    header: ExplicitHeader,
    body: &[u8],
    before: usize,
) -> Parsed {
    let (server, client) = (route.link.server, route.client);
    let (mut parsed, is_response) = read(Kind::ExplicitResponse, body, before);
    if !is_response {
        return parsed;
    }
    let service = parsed.fields.explicit.service.unwrap_or(ServiceCode::ERROR_RESPONSE);
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
        let connection = state.connection(route.link);
        if connection.state != ConnectionState::Established {
            connection.infer(ConnectionState::Established, seen.at);
        }
        if route.link.dynamic.is_none() {
            state.node(server).answers_owner(client);
        }
    }
    parsed.request = Some(transaction.seen.answered(seen.at));
    parsed.assumed = transaction.assumed;
    fill(&mut parsed, &transaction, body);
    if let Ok(Response::Success { data, .. }) = Response::parse(body) {
        let learned = match has_parts(transaction.asked.service) {
            true => learn::parts(state, route.link, &transaction, data, seen.at),
            false => learn::success(state, route.link, &transaction, data, seen.at),
        };
        parsed.problem = parsed.problem.or(learned.filter(|_| !transaction.assumed));
    }
    parsed
}

/// Reads the service byte and what follows it of a response; false is a message that is none.
pub(super) fn read(kind: Kind, body: &[u8], before: usize) -> (Parsed, bool) {
    let read = Explicit::response(body, before);
    let mut parsed = Parsed::new(kind);
    parsed.fields.explicit = read.explicit;
    parsed.problem = read.flaw.map(Into::into);
    (parsed, read.is_response)
}

/// Gives a response what only its request has said.
fn fill(parsed: &mut Parsed, transaction: &Transaction, body: &[u8]) {
    let asked = &transaction.asked;
    let fields = &mut parsed.fields;
    fields.explicit.answers(asked, body);
    let of_set = asked.class == Some(ClassId::DEVICENET)
        && matches!(asked.service, ServiceCode::ALLOCATE | ServiceCode::RELEASE);
    if !of_set {
        return;
    }
    let [choice, ..] = asked.argument.to_le_bytes();
    fields.choice = Some(AllocationChoice::from_bits_retain(choice));
    if let (Some(status), Some(additional)) = (fields.explicit.status, fields.explicit.additional) {
        parsed.flag(Problem::Refused { status, additional });
        return;
    }
    if let Ok(Response::Success { service: ServiceCode::ALLOCATE, data }) = Response::parse(body) {
        allocated(parsed, data);
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
    let service = parsed.fields.explicit.service.unwrap_or(ServiceCode::ERROR_RESPONSE);
    match pending {
        Ok(request) if request.requester != client => {
            parsed.flag(Problem::WrongRequester { expected: request.requester });
        }
        Ok(request) if request.xid != header.xid => parsed.flag(Flaw::TransactionMismatch),
        Ok(request) if request.asked.service != service => {
            parsed.flag(Flaw::ServiceMismatch { expected: request.asked.service });
        }
        Ok(_) | Err(true) => parsed.flag(Flaw::UnexpectedResponse),
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

fn allocated(parsed: &mut Parsed, data: &[u8]) {
    match AllocateResponse::parse(data) {
        Ok(response) => {
            let format = response.code();
            parsed.fields.detail = Detail::Allocated { format };
            if response.body_format().is_none() {
                parsed.flag(Flaw::ReservedValue { field: "body format", found: format.into() });
            }
        }
        Err(error) => parsed.flag(Flaw::of_parse(error, data.len())),
    }
}
