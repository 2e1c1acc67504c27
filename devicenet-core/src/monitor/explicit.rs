//! Explicit messages on a connection: header, fragments, acknowledges.

use cip_core::fragment::{AckStatus, FragmentByte, FragmentKind};
use cip_core::message::BodyFormat;
use cip_core::monitor::{ConnectionState, Flaw, Flights, Flow, Frag, Seen, Slots, Stream};

use super::bodies::{self, Parsed};
use super::connections::Predefined;
use super::kind::Kind;
use super::nodes::Roles;
use super::pairing::Transaction;
use super::problem::Problem;
use super::reading::{Message, Reading};
use super::state::{Dynamic, Link, State};
use crate::id::{Identifier, MacId};
use crate::message::ExplicitHeader;

/// The messages that are under way on an explicit connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Channel {
    pub(super) format: BodyFormat,
    pub(super) knowledge: Knowledge,
    /// The request that waits for its response.
    pub(super) pending: Option<Transaction>,
    /// The fragments that want an acknowledge.
    flights: Flights,
    /// A complete request was seen: a response without one is unexpected from then on.
    pub(super) asked: bool,
}

/// How the body format is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Knowledge {
    /// It is not: the usual one is assumed.
    None,
    /// A request whose response was not seen has asked for it, or the length of a message suggests it.
    Likely,
    /// The server has told it.
    Told,
}

/// The connection, the direction and the streams of an explicit frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Route {
    pub(super) link: Link,
    pub(super) flow: Flow,
    pub(super) client: MacId,
    pub(super) stream: Stream,
    /// The stream of the other direction.
    pub(super) opposite: Option<Stream>,
    /// The client does not own the connection: the server ignores it.
    pub(super) intrudes: bool,
}

impl Channel {
    pub(super) const NEW: Self = Self {
        format: BodyFormat::Class8Instance8,
        knowledge: Knowledge::None,
        pending: None,
        flights: Flights::NEW,
        asked: false,
    };

    /// A connection that the server has just made.
    pub(super) const fn told(format: BodyFormat) -> Self {
        Self { format, knowledge: Knowledge::Told, ..Self::NEW }
    }

    /// A connection that was asked for.
    pub(super) const fn likely(format: BodyFormat) -> Self {
        Self { format, knowledge: Knowledge::Likely, ..Self::NEW }
    }
}

/// A frame on Message ID 3 or 4 of Group 2 whose header is `header`.
pub(super) fn predefined(identifier: Identifier, server: MacId, flow: Flow, header: ExplicitHeader) -> Route {
    let opposite = match flow {
        Flow::Consumed => Identifier::explicit_response(server),
        Flow::Produced => Identifier::explicit_request(server),
    };
    let master = header.mac.number();
    Route {
        link: Link { server, dynamic: None },
        flow,
        client: header.mac,
        stream: Stream::explicit(identifier.raw(), master),
        opposite: Some(Stream::explicit(opposite.raw(), master)),
        intrudes: false,
    }
}

/// Reads a frame of an explicit connection.
pub(super) fn observe<'s, const N: usize, const B: usize>(
    state: &mut State<N>,
    slots: &'s mut Slots<N, B>,
    reading: &mut Reading<'_>,
    header: ExplicitHeader,
    route: &Route,
) -> Option<Message<'s>> {
    let frame = reading.frame;
    let body = frame.data().get(1..).unwrap_or_default();
    let intrudes = address(state, reading, route);
    let route = &Route { intrudes, ..*route };
    if !header.fragmented {
        slots.discard(route.stream);
        if let Some(opposite) = route.opposite {
            slots.discard(opposite);
        }
        let channel = state.channel(route.link);
        let unacknowledged = if intrudes { None } else { channel.flights.give_up_all(reading.at) };
        let seen = Seen { n: reading.n, at: reading.at };
        bodies::message(state, route, seen, header, body, 1).apply(reading);
        reading.flag_if(unacknowledged);
        state.channel(route.link).flights.know();
        return None;
    }
    reading.kind = Kind::Fragment;
    let Some((&byte, piece)) = body.split_first() else {
        reading.flag(Flaw::TooShort { at_least: 3, found: 1 });
        return None;
    };
    let byte = FragmentByte::from(byte);
    reading.frag = Some(Frag::new(byte));
    if byte.kind == FragmentKind::Acknowledge {
        reading.kind = Kind::FragmentAck;
        acknowledge(state, slots, reading, header, route, byte, piece);
        return None;
    }
    fragment(state, slots, reading, header, route, byte, piece)
}

/// Source, destination, roles, and what the owner and the watchdog have to say. True if the server ignores the frame
/// because another master owns the connection.
fn address<const N: usize>(state: &mut State<N>, reading: &mut Reading<'_>, route: &Route) -> bool {
    let (server, client) = (route.link.server, route.client);
    let (source, destination) = match route.flow {
        Flow::Consumed => (client, server),
        Flow::Produced => (server, client),
    };
    reading.src = Some(source);
    reading.dst = Some(destination);
    let at = reading.at;
    let mut intrudes = false;
    if client == server {
        reading.flag(Problem::HeaderRepeatsIdentifier { mac: server });
    }
    if route.link.dynamic.is_none() {
        state.add_role(client, Roles::MASTER);
        if route.flow == Flow::Produced {
            state.add_role(server, Roles::SLAVE);
        }
        state.settle(server, at);
        let node = state.node(server);
        let owner = node.told_owner();
        let connection = node.connection(Predefined::Explicit);
        if route.flow == Flow::Consumed
            && connection.state == ConnectionState::Established
            && let Some(owner) = owner.filter(|&owner| owner != client)
        {
            reading.flag(Problem::NotOwner { owner });
            intrudes = true;
        }
    } else {
        state.connection(route.link).settle(at, true, false);
    }
    let connection = state.connection(route.link);
    connection.count(reading.frame.data().len());
    if intrudes {
        return true;
    }
    connection.explicit(reading, route.flow, at);
    reading.dynamic = state.held(route.link).map(Dynamic::told);
    false
}

fn fragment<'s, const N: usize, const B: usize>(
    state: &mut State<N>,
    slots: &'s mut Slots<N, B>,
    reading: &mut Reading<'_>,
    header: ExplicitHeader,
    route: &Route,
    byte: FragmentByte,
    piece: &[u8],
) -> Option<Message<'s>> {
    if piece.is_empty() {
        reading.flag(Flaw::TooShort { at_least: 3, found: 2 });
    }
    let (at, seen) = (reading.at, Seen { n: reading.n, at: reading.at });
    let flights = &mut state.channel(route.link).flights;
    let known = flights.is_known(route.flow);
    flights.learn(route.flow, byte.kind);
    if !route.intrudes {
        reading.flag_if(flights.send(route.flow, seen, byte, header.xid));
    }
    if byte.kind == FragmentKind::First {
        // A new message: what the other side was sending is given up.
        if !route.intrudes {
            reading.flag_if(flights.give_up(route.flow.opposite(), at));
        }
        if let Some(opposite) = route.opposite {
            slots.discard(opposite);
        }
    }
    let (piece, mismatch) = slots.explicit(route.stream, at, header.xid, byte, piece);
    reading.flag_if(mismatch);
    let body = piece.whole(reading, byte, known)?;
    let parsed = bodies::message(state, route, seen, header, body, 0);
    let Parsed { kind, fields, .. } = parsed;
    parsed.apply_around(reading);
    Some(Message { kind, fields, data: body })
}

fn acknowledge<const N: usize, const B: usize>(
    state: &mut State<N>,
    slots: &mut Slots<N, B>,
    reading: &mut Reading<'_>,
    header: ExplicitHeader,
    route: &Route,
    byte: FragmentByte,
    rest: &[u8],
) {
    let frag = Frag { byte, status: rest.first().copied() };
    reading.frag = Some(frag);
    if let Some(AckStatus::Reserved(found)) = frag.status.map(AckStatus::from) {
        let polled = route.link.dynamic.is_none()
            && route.flow == Flow::Produced
            && state.node(route.link.server).connection(Predefined::Poll).waiting.is_some();
        reading.flag(if polled {
            Problem::MisplacedPollResponse
        } else {
            Problem::Flaw(Flaw::ReservedValue { field: "acknowledge status", found: found.into() })
        });
    }
    let len = reading.frame.data().len();
    if len != ACK_LEN {
        let found = u16::try_from(len).unwrap_or_default();
        reading.flag(Flaw::Length { expected: 3, found });
    }
    if route.intrudes {
        return;
    }
    let (acknowledged, at) = (route.flow.opposite(), reading.at);
    let flights = &mut state.channel(route.link).flights;
    if flights.acknowledge(reading, acknowledged, at, frag, header.xid)
        && let Some(stream) = route.opposite
    {
        slots.discard(stream);
    }
}

const ACK_LEN: usize = 3;
