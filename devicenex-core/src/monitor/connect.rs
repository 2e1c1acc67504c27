//! Connection requests and responses, class 11101.

use cip_core::code::{AdditionalCode, ServiceCode};
use cip_core::message::BodyFormat;
use cip_core::monitor::{Asked, Connection, Explicit, Flaw, Seen};
use link_core::Instant;

use super::connections::{ConnectionName, Held, is_allowed};
use super::kind::Kind;
use super::nodes::Roles;
use super::problem::Problem;
use super::reading::{Detail, Reading};
use super::state::State;
use super::talk::{Ends, Pairing, Port, Request};
use crate::id::{Direction, Route};
use crate::message::{
    ConnectionInstance, ConnectionRequest, ConnectionResponse, Granted, GroupSelect, Predefined, Wire,
};

/// Reads a frame of class 11101.
pub(super) fn observe<const N: usize>(
    state: &mut State<N>,
    reading: &mut Reading<'_>,
    route: Route,
    transaction: u8,
) {
    reading.src = Some(route.source);
    reading.dst = Some(route.destination);
    reading.fields.transaction = Some(transaction);
    let (kind, client, server) = match route.direction {
        Direction::Request => (Kind::ConnectionRequest, route.source, route.destination),
        Direction::Response => (Kind::ConnectionResponse, route.destination, route.source),
    };
    reading.kind = kind;
    if client.is_none() || server.is_none() {
        reading.flag(Problem::NoAddress);
        return;
    }
    state.add_role(client, Roles::CLIENT);
    let ends = Ends { client, server, port: Port::Connection };
    match route.direction {
        Direction::Request => request(state, reading, ends, transaction),
        Direction::Response => {
            state.add_role(server, Roles::SERVER);
            response(state, reading, ends, transaction);
        }
    }
}

fn request<const N: usize>(state: &mut State<N>, reading: &mut Reading<'_>, ends: Ends, transaction: u8) {
    let frame = reading.frame;
    let connect = match ConnectionRequest::parse(frame.data()) {
        Ok(connect) => {
            reading.fields.detail = Detail::Connect(connect);
            reading.fields.explicit.service = Some(ServiceCode::ALLOCATE);
            if connect.group.name().is_none() {
                let found = connect.group.number().into();
                reading.flag(Flaw::ReservedValue { field: "group select", found });
            }
            Some(connect)
        }
        Err(error) => {
            reading.flag(Flaw::of_parse(error, frame.data().len()));
            None
        }
    };
    let request = Request {
        seen: Seen { n: reading.n, at: reading.at },
        transaction,
        asked: Asked::service(ServiceCode::ALLOCATE),
        format: BodyFormat::Class8Instance8,
        connect,
        assumed: false,
    };
    let is_kept = state.talk(ends, reading.at).is_none_or(|talk| talk.ask(request));
    state.lost.requests = state.lost.requests.saturating_add(u64::from(!is_kept));
}

fn response<const N: usize>(state: &mut State<N>, reading: &mut Reading<'_>, ends: Ends, transaction: u8) {
    let pairing = state.talk(ends, reading.at).map(|talk| talk.answer(transaction, |_| Ok(())));
    let request = match pairing {
        Some(Pairing::Answers(request)) => {
            reading.request = Some(request.seen.answered(reading.at));
            Some(request)
        }
        Some(Pairing::Wrong(flaw)) => {
            reading.flag(flaw);
            None
        }
        Some(Pairing::Assumed) | None => {
            reading.assumed = true;
            None
        }
    };
    let frame = reading.frame;
    if frame.data().first() == Some(&ServiceCode::ERROR_RESPONSE.response_byte()) {
        let read = Explicit::response(frame.data(), 0);
        reading.fields.explicit = read.explicit;
        reading.fields.explicit.requested = Some(ServiceCode::ALLOCATE);
        reading.flag_if(read.flaw);
        if let Some(status) = read.explicit.status {
            let additional = read.explicit.additional.unwrap_or(AdditionalCode::NONE);
            reading.flag(Problem::Refused { status, additional });
        }
        return;
    }
    let granted = match ConnectionResponse::parse(frame.data()) {
        Ok(granted) => granted,
        Err(error) => {
            reading.flag(Flaw::of_parse(error, frame.data().len()));
            return;
        }
    };
    reading.fields.explicit.service = Some(ServiceCode::ALLOCATE);
    let connect = request.and_then(|request| request.connect);
    let named = connect.and_then(|connect| connect.target).map(|target| target.instance);
    let instance = match granted.granted {
        Granted::Dynamic { instance } => Some(instance),
        Granted::Predefined { .. } => named,
    };
    reading.fields.detail = Detail::Granted { response: granted, instance };
    check(reading, connect, &granted);
    if let Some(held) = held(ends, connect, &granted, reading.at) {
        reading.connection = Some(held.told());
        state.insert(held);
    }
}

/// What is wrong with a granted connection.
fn check(reading: &mut Reading<'_>, connect: Option<ConnectionRequest>, granted: &ConnectionResponse) {
    let format = granted.body_format.0;
    if format & 0xF0 != 0 {
        reading.flag(Flaw::ReservedBits { field: "body format" });
    }
    if granted.body_format.body_format().is_none() {
        reading.flag(Flaw::ReservedValue { field: "body format", found: u16::from(format & 0x0F) });
    }
    if granted.group.name().is_none() {
        let found = granted.group.number().into();
        reading.flag(Flaw::ReservedValue { field: "group select", found });
    }
    let Some(connect) = connect else { return };
    if connect.predefined != matches!(granted.granted, Granted::Predefined { .. }) {
        reading.flag(Problem::NotAsAsked { field: "predefined or dynamic" });
    }
    let named = connect.target.map(|target| target.instance);
    match (granted.granted, named) {
        (Granted::Dynamic { instance }, Some(named)) if instance != named => {
            reading.flag(Problem::NotAsAsked { field: "the instance" });
        }
        (Granted::Dynamic { instance }, _)
            if !matches!(ConnectionInstance::of(instance), ConnectionInstance::Dynamic(_)) =>
        {
            reading.flag(Flaw::ReservedValue { field: "connection instance", found: instance.0 });
        }
        _ => {}
    }
    if named.is_some_and(|named| !is_allowed(named, granted.group)) {
        reading.flag(Problem::NotAsAsked { field: "the group" });
    }
}

/// The connection that a response makes; `None` if nothing tells which it is.
fn held(
    ends: Ends,
    connect: Option<ConnectionRequest>,
    granted: &ConnectionResponse,
    at: Instant,
) -> Option<Held> {
    let Ends { client, server, .. } = ends;
    let target = connect.and_then(|connect| connect.target);
    let (instance, told_rate) = match granted.granted {
        Granted::Predefined { expected_packet_rate } => (target?.instance, Some(expected_packet_rate)),
        Granted::Dynamic { instance } => (instance, None),
    };
    let is_explicit = granted.group == GroupSelect::EXPLICIT_29
        || ConnectionInstance::of(instance) == ConnectionInstance::Predefined(Predefined::Explicit);
    let mut connection = Connection::NEW;
    match (target, is_explicit) {
        // A short request asks for a connection that is to be configured.
        (None, _) if connect.is_some() => connection.allocate(at),
        (None, true) => connection.open(at),
        (None, false) => connection.allocate(at),
        (Some(target), _) => {
            if is_explicit {
                connection.open(at);
            } else {
                connection.allocate(at);
            }
            connection.epr = told_rate.or(Some(target.expected_packet_rate));
            connection.watchdog_action = Some(target.watchdog_action.0);
            connection.restart(at);
            // An implicit connection waits for its first message for longer.
            connection.fresh = !is_explicit;
        }
    }
    let mut held = Held {
        client: Some(client),
        is_explicit,
        group: Some(granted.group),
        client_message: connect.map(|connect| connect.source_message),
        server_message: Some(granted.source_message),
        format: granted.body_format.body_format().unwrap_or_default(),
        is_format_told: granted.body_format.body_format().is_some(),
        connection,
        ..Held::new(server, ConnectionName::Instance(instance))
    };
    held.consumes_client();
    Some(held)
}
