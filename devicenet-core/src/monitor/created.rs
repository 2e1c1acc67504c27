//! I/O connections that were made by Create: attributes 4 and 5 of the Connection object name their identifiers.

use cip_core::code::{InstanceId, ServiceCode};
use cip_core::codec::Wire;
use cip_core::message::CreateResponse;
use link_core::Instant;

use super::FragmentationGuess;
use super::connection::{Connection, Flow};
use super::connections::ConnectionState;
use super::explicit::Channel;
use super::io::{self, prove};
use super::kind::Kind;
use super::learn::{PRODUCED_ID, connection_id};
use super::pairing::Transaction;
use super::reading::{Fields, Message, Reading, Span};
use super::slots::Slots;
use super::state::{Dynamic, State};
use crate::id::{Identifier, MacId};

/// Learns from a successful request to the Connection object of `server`: Create, and the identifiers of what it made.
pub(super) fn learn<const N: usize>(
    state: &mut State<N>,
    server: MacId,
    instance: InstanceId,
    request: &Transaction,
    data: &[u8],
    at: Instant,
) {
    if request.service == ServiceCode::CREATE && instance.is_class() {
        if let Ok(CreateResponse { instance, .. }) = CreateResponse::parse(data) {
            let mut connection = Connection::NEW;
            connection.enter(ConnectionState::Configuring, at);
            state.insert_dynamic(new(request.requester, server, instance, connection));
        }
        return;
    }
    let Some((attribute, raw)) = connection_id(request, data) else { return };
    let is_set = request.service == ServiceCode::SET_ATTRIBUTE_SINGLE;
    if is_set && state.dynamic(server, instance).is_none() {
        // The connections of UCMM and of the predefined set do not let their identifiers be set.
        let connection = Connection { active: at, ..Connection::NEW };
        state.insert_dynamic(new(request.requester, server, instance, connection));
    }
    let Some(held) = state.dynamic(server, instance).filter(|held| held.is_io) else { return };
    let identifier = Identifier::new(raw);
    match attribute {
        PRODUCED_ID => held.responses = identifier,
        _ => held.requests = identifier,
    }
    held.group = identifier.and_then(|identifier| identifier.group().number()).unwrap_or(held.group);
}

/// The ends of an I/O connection that a frame belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Ends {
    identifier: Identifier,
    /// Where the connection stands that tells the size, and the direction of the frame on it.
    held: (usize, Flow),
    /// The consumer, if it is the only one known.
    consumer: Option<MacId>,
}

/// The created connections that produce or consume an identifier.
pub(super) fn find<const N: usize>(state: &State<N>, identifier: Identifier) -> Option<Ends> {
    if state.created == 0 {
        return None;
    }
    let (mut producer, mut first, mut consumers) = (None, None, 0_usize);
    for (index, slot) in state.dynamics.iter().enumerate() {
        let Some(held) = slot else { continue };
        match held.io_flow(identifier) {
            Some(Flow::Produced) => producer = Some((index, Flow::Produced)),
            Some(Flow::Consumed) => {
                first = first.or(Some((index, held.server)));
                consumers = consumers.saturating_add(1);
            }
            None => {}
        }
    }
    let held = producer.or(first.map(|(index, _)| (index, Flow::Consumed)))?;
    let consumer = first.filter(|_| consumers == 1).map(|(_, server)| server);
    Some(Ends { identifier, held, consumer })
}

/// Reads a frame between them.
pub(super) fn observe<'s, const N: usize, const B: usize>(
    state: &mut State<N>,
    slots: &'s mut Slots<N, B>,
    reading: &mut Reading<'_>,
    ends: Ends,
    guess: FragmentationGuess,
) -> Option<Message<'s>> {
    let Ends { identifier, held: (index, flow), consumer } = ends;
    reading.kind = Kind::Io;
    reading.src = identifier.mac_id();
    reading.dst = consumer;
    let (at, len) = (reading.at, reading.frame.data().len());
    for held in state.dynamics.iter_mut().flatten() {
        let Some(flow) = held.io_flow(identifier) else { continue };
        held.connection.count(len);
        if flow == Flow::Consumed {
            held.connection.settle(at, false, false);
            held.connection.touch(at);
        }
    }
    let held = state.dynamics.get_mut(index)?.as_mut()?;
    reading.assumed = held.connection.state == ConnectionState::Unknown;
    if flow == Flow::Produced {
        prove(reading, &mut held.connection);
        held.connection.touch(at);
    }
    reading.dynamic = Some(held.told());
    let (_, message) = io::data(slots, reading, &mut held.connection, identifier, flow, guess);
    message.map(|data| {
        let fields = Fields { value: Span::tail(data.len(), data.len()), ..Fields::default() };
        Message { kind: Kind::Io, fields, data }
    })
}

impl Dynamic {
    /// The direction of an I/O frame with this identifier, if the connection has to do with it.
    fn io_flow(&self, identifier: Identifier) -> Option<Flow> {
        let is_own = identifier.mac_id() == Some(self.server);
        match (self.is_io, is_own) {
            (true, true) => (self.responses == Some(identifier)).then_some(Flow::Produced),
            (true, false) => (self.requests == Some(identifier)).then_some(Flow::Consumed),
            (false, _) => None,
        }
    }
}

fn new(client: MacId, server: MacId, instance: InstanceId, connection: Connection) -> Dynamic {
    Dynamic {
        client,
        server,
        group: 1,
        instance: Some(instance),
        requests: None,
        responses: None,
        is_io: true,
        connection,
        channel: Channel::NEW,
    }
}
