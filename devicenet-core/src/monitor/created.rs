//! I/O connections that were made by Create: attributes 4 and 5 of the Connection object name their identifiers.

use cip_core::code::{InstanceId, ServiceCode};
use cip_core::codec::Wire;
use cip_core::message::CreateResponse;
use cip_core::monitor::attribute::PRODUCED_ID;
use cip_core::monitor::{Connection, ConnectionState, Flow, Slots};
use link_core::Instant;

use super::FragmentationGuess;
use super::connections::Predefined;
use super::explicit::Channel;
use super::io;
use super::kind::Kind;
use super::learn::connection_id;
use super::nodes::Node;
use super::pairing::Transaction;
use super::reading::{Fields, Message, Reading};
use super::state::{Dynamic, State};
use crate::id::{Identifier, MacId, MessageGroup, Purpose};

/// Learns from a successful request to the Connection object of `server`: Create, and the identifiers of what it made.
pub(super) fn learn<const N: usize>(
    state: &mut State<N>,
    server: MacId,
    instance: InstanceId,
    request: &Transaction,
    data: &[u8],
    at: Instant,
) {
    if request.asked.service == ServiceCode::CREATE && instance.is_class() {
        if let Ok(CreateResponse { instance, .. }) = CreateResponse::parse(data) {
            let mut connection = Connection::NEW;
            connection.enter(ConnectionState::Configuring, at);
            state.insert_dynamic(new(request.requester, server, instance, connection));
        }
        return;
    }
    let Some((attribute, raw)) = connection_id(request, data) else { return };
    let is_set = request.asked.service == ServiceCode::SET_ATTRIBUTE_SINGLE;
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
    /// The producer, if it is known.
    producer: Option<MacId>,
    /// Where the connection stands that tells the size, and the direction of the frame on it.
    held: (usize, Flow),
    /// The consumer, if it is the only one known.
    consumer: Option<MacId>,
}

/// The created connections that produce or consume an identifier.
pub(super) fn find<const N: usize>(state: &State<N>, identifier: Identifier) -> Option<Ends> {
    if state.created == 0 || is_predefined(state, identifier) {
        return None;
    }
    let (mut producer, mut first, mut consumers) = (None, None, 0_usize);
    // Group 1 and 3 have the source in the identifier; in Group 2 it can be the destination.
    let mut source = identifier.mac_id();
    for (index, slot) in state.dynamics.iter().enumerate() {
        let Some(held) = slot else { continue };
        match held.io_flow(identifier) {
            Some(Flow::Produced) => producer = Some((index, held.server)),
            Some(Flow::Consumed) => {
                first = first.or(Some((index, held.server)));
                consumers = consumers.saturating_add(1);
                source = source.filter(|&source| source != held.server);
            }
            None => {}
        }
    }
    let produced = producer.map(|(index, _)| (index, Flow::Produced));
    let held = produced.or(first.map(|(index, _)| (index, Flow::Consumed)))?;
    let consumer = first.filter(|_| consumers == 1).map(|(_, server)| server);
    let producer = producer.map(|(_, server)| server).or(source);
    Some(Ends { identifier, producer, held, consumer })
}

/// True if a connection of the predefined set, of which a message has told, uses the identifier. A server does not give
/// one of those away.
fn is_predefined<const N: usize>(state: &State<N>, identifier: Identifier) -> bool {
    let Some(mac) = identifier.mac_id() else { return false };
    let uses = |node: &Node, which| {
        let mut connection = *node.peek(which);
        connection.settle(state.now, which == Predefined::Explicit, true);
        let is_there = !matches!(
            connection.state,
            ConnectionState::Unknown | ConnectionState::NonExistent | ConnectionState::TimedOut
        );
        is_there && !connection.assumed
    };
    let mut slaves = state.nodes();
    match identifier.purpose() {
        Purpose::ExplicitRequest | Purpose::ExplicitResponse => {
            slaves.any(|(slave, node)| slave == mac && uses(node, Predefined::Explicit))
        }
        Purpose::PollCommand => slaves.any(|(slave, node)| slave == mac && uses(node, Predefined::Poll)),
        Purpose::ChangeOfStateAcknowledge => {
            slaves.any(|(slave, node)| slave == mac && uses(node, Predefined::CosCyclic))
        }
        Purpose::BitStrobeCommand => {
            slaves.any(|(_, node)| node.owner() == Some(mac) && uses(node, Predefined::BitStrobe))
        }
        Purpose::MulticastPollCommand => slaves
            .any(|(_, node)| node.multicast_group() == Some(mac) && uses(node, Predefined::MulticastPoll)),
        // Message ID 6 is never given away, and 7 is no connection's.
        Purpose::Group2UnconnectedRequest => true,
        _ => false,
    }
}

/// Reads a frame between them.
pub(super) fn observe<'s, const N: usize, const B: usize>(
    state: &mut State<N>,
    slots: &'s mut Slots<N, B>,
    reading: &mut Reading<'_>,
    ends: Ends,
    guess: FragmentationGuess,
) -> Option<Message<'s>> {
    let Ends { identifier, producer, held: (index, flow), consumer } = ends;
    reading.kind = Kind::Io;
    reading.src = producer;
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
        held.connection.prove(reading, at);
        held.connection.touch(at);
    }
    reading.dynamic = Some(held.told());
    let (_, message) = io::data(slots, reading, held.connection.side(flow), identifier, guess);
    message.map(|data| {
        let fields = Fields::of_data(data);
        Message { kind: Kind::Io, fields, data }
    })
}

impl Dynamic {
    /// The direction of an I/O frame with this identifier, if the connection has to do with it.
    fn io_flow(&self, identifier: Identifier) -> Option<Flow> {
        if !self.is_io {
            return None;
        }
        let (produces, consumes) = (self.responses == Some(identifier), self.requests == Some(identifier));
        // Outside of Group 2 the identifier names the producer.
        let is_own = identifier.mac_id() == Some(self.server);
        let is_open = identifier.group() == MessageGroup::Group2;
        match (produces && (is_own || is_open), consumes && (!is_own || is_open)) {
            (true, _) => Some(Flow::Produced),
            (false, true) => Some(Flow::Consumed),
            (false, false) => None,
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
