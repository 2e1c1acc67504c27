//! Implicit messages, with 11 and 29 bits.

use cip_core::code::InstanceId;
use cip_core::monitor::{ConnectionState, Flaw, Flow, FragmentationGuess, Progress, Seen, Slots, Stream};

use super::connections::{ConnectionName, Held, Manner};
use super::kind::Kind;
use super::nodes::Roles;
use super::problem::Problem;
use super::reading::{Fields, Message, Reading};
use super::state::State;
use crate::id::{Identifier, Layout, OperationalAddress};

/// Reads the data of a producer.
pub(super) fn observe<'s, const N: usize, const B: usize>(
    state: &mut State<N>,
    slots: &'s mut Slots<N, B>,
    reading: &mut Reading<'_>,
    source: OperationalAddress,
    guess: FragmentationGuess,
) -> Option<Message<'s>> {
    reading.kind = Kind::Implicit;
    reading.src = Some(source);
    if source.is_none() {
        reading.flag(Problem::NoAddress);
        return None;
    }
    state.add_role(source, Roles::PRODUCER);
    let identifier = Identifier::of_frame(&reading.frame);
    let (at, len) = (reading.at, reading.frame.data().len());
    let (index, flow) = find(state, reading.layout, source, at)?;
    let consumers = consume(state, identifier, index, at, len);
    let held = state.held(index)?;
    held.settle(at);
    let manner = held.manner();
    if (flow, manner, len) == (Flow::Consumed, Manner::Acknowledged, 0) {
        // With 11 bits there is no bit for it.
        reading.kind = Kind::ImplicitAck;
        acknowledged(reading, held);
        return None;
    }
    let peer = match (flow, manner) {
        (Flow::Consumed, _) => Some(held.server),
        (Flow::Produced, Manner::Polled | Manner::Acknowledged) => held.client,
        (Flow::Produced, _) => None,
    };
    reading.dst = peer.or(consumers);
    let connection = &mut held.connection;
    connection.count(len);
    connection.side(flow).heard = true;
    reading.assumed |= connection.state == ConnectionState::Unknown;
    let stream = Stream::io(stream(identifier));
    let part = connection.side(flow).frame(slots, at, stream, reading.frame.data(), guess);
    reading.fields.explicit.value = part.value;
    reading.frag = part.frag;
    part.tell(reading);
    match part.progress {
        Progress::Complete => moves(reading, held, flow, manner, false),
        Progress::Reconsidered => moves(reading, held, flow, manner, true),
        Progress::Begun => held.connection.waiting = None,
        Progress::Part => {}
    }
    reading.connection = Some(held.told());
    part.message.map(|data| Message { kind: Kind::Implicit, fields: Fields::of_data(data), data })
}

/// A whole message has gone one way. Its first fragment was paired already if it is `reconsidered`.
fn moves(reading: &mut Reading<'_>, held: &mut Held, flow: Flow, manner: Manner, reconsidered: bool) {
    let at = reading.at;
    let seen = Seen { n: reading.n, at };
    let connection = &mut held.connection;
    if reconsidered {
        connection.waiting = None;
    }
    match (flow, manner) {
        (Flow::Consumed, _) => {
            if matches!(connection.state, ConnectionState::TimedOut | ConnectionState::NonExistent) {
                connection.is_missing(reading);
            }
            if let Some(before) = connection.waiting.replace(seen)
                && connection.answers
                && connection.is_alive()
            {
                reading.flag(Flaw::PollUnanswered { n: before.n });
            }
            connection.touch(at);
        }
        (Flow::Produced, Manner::Polled) => {
            if !reconsidered && let Some(command) = connection.answer(reading, connection.consumed.heard, at)
            {
                held.last_latency = Some(command.answered(at).latency);
            }
            connection.prove(reading, at);
        }
        (Flow::Produced, Manner::Acknowledged) => {
            if let Some(before) = connection.waiting.replace(seen)
                && connection.answers
            {
                reading.flag(Flaw::Unacknowledged { n: before.n });
            }
            if !connection.answers {
                connection.touch(at);
            }
            connection.prove(reading, at);
        }
        (Flow::Produced, Manner::Multicast | Manner::Consumer | Manner::Explicit | Manner::Unknown) => {
            connection.touch(at);
            connection.prove(reading, at);
        }
    }
}

/// Reads an acknowledge of change-of-state or cyclic data. It names a connection of the node that sends it.
pub(super) fn acknowledge<const N: usize>(
    state: &mut State<N>,
    reading: &mut Reading<'_>,
    source: OperationalAddress,
    instance: InstanceId,
) {
    reading.kind = Kind::ImplicitAck;
    reading.src = Some(source);
    if source.is_none() {
        reading.flag(Problem::NoAddress);
        return;
    }
    state.add_role(source, Roles::CONSUMER);
    let told = target(instance).map(|(server, instance)| (server, ConnectionName::Instance(instance)));
    let consumed = state.instance(source, instance).and_then(|own| own.consumed);
    let is_peer = |held: &Held| match (told, consumed) {
        (Some(told), _) => told == (held.server, held.name),
        (None, Some(consumed)) => held.produced() == Some(consumed),
        (None, None) => held.client == Some(source) && held.manner() == Manner::Acknowledged,
    };
    let held = state.connections.iter_mut().flatten().filter(|held| held.server != source && is_peer(held));
    // That which waits for longest.
    let waits =
        |held: &&mut Held| (held.connection.waiting.is_none(), held.connection.waiting.map(|seen| seen.n));
    let Some(held) = held.min_by_key(waits) else {
        reading.assumed = true;
        return;
    };
    held.settle(reading.at);
    acknowledged(reading, held);
}

/// What a connection produces is acknowledged.
fn acknowledged(reading: &mut Reading<'_>, held: &mut Held) {
    reading.dst = Some(held.server);
    let at = reading.at;
    let connection = &mut held.connection;
    connection.count(reading.frame.data().len());
    if let Some(message) = connection.answer(reading, connection.produced.heard, at) {
        held.last_latency = Some(message.answered(at).latency);
    }
    connection.touch(at);
    reading.connection = Some(held.told());
}

/// The connection that a message is on, and its direction. One that nothing has told of is kept as it is heard.
fn find<const N: usize>(
    state: &mut State<N>,
    layout: Layout,
    source: OperationalAddress,
    at: link_core::Instant,
) -> Option<(usize, Flow)> {
    let flows = state.connections.iter().enumerate().filter_map(|(index, slot)| {
        let held = slot.as_ref()?;
        Some((index, held.flow(layout)?, held.connection.active))
    });
    // What a server produces is told by its address and instance; what a client does, by less.
    let best = flows.max_by_key(|&(_, flow, active)| (flow == Flow::Produced, active));
    if let Some((index, flow, _)) = best {
        return Some((index, flow));
    }
    if let Layout::Implicit { instance, .. } = layout
        && let Some((server, instance)) = target(instance)
    {
        let held = Held::unknown(server, ConnectionName::Instance(instance), at);
        let index = state.insert(Held { client: Some(source), ..held })?;
        return Some((index, Flow::Consumed));
    }
    let name = match layout {
        Layout::Implicit { instance, .. } => ConnectionName::Instance(instance),
        Layout::Standard { group, message, .. } => ConnectionName::Standard { group, message },
        _ => return None,
    };
    let index = state.insert(Held::unknown(source, name, at))?;
    let held = state.held(index)?;
    held.server_message = match layout {
        Layout::Implicit { message, .. } | Layout::Standard { message, .. } => Some(message),
        _ => None,
    };
    Some((index, Flow::Produced))
}

/// The target and its instance, in an identifier of a requester. See
/// [`requester_instance`](crate::connection::requester_instance).
fn target(instance: InstanceId) -> Option<(OperationalAddress, InstanceId)> {
    let [instance, target] = instance.0.to_le_bytes();
    let address = OperationalAddress::from_low_bits(target);
    (target & 0x80 != 0 && !address.is_none()).then_some((address, InstanceId(instance.into())))
}

/// The connections that consume an identifier hear the message. Returns the consumer, if there is one and no other.
fn consume<const N: usize>(
    state: &mut State<N>,
    identifier: Identifier,
    producer: usize,
    at: link_core::Instant,
    len: usize,
) -> Option<OperationalAddress> {
    let mut only = None;
    let mut others = false;
    for (index, slot) in state.connections.iter_mut().enumerate() {
        let Some(held) = slot.as_mut().filter(|held| held.consumed == Some(identifier)) else { continue };
        if index == producer {
            continue;
        }
        others |= only.replace(held.server).is_some();
        held.settle(at);
        held.connection.count(len);
        held.connection.consumed.heard = true;
        held.connection.touch(at);
    }
    only.filter(|_| !others)
}

/// A number for the identifier that no identifier of the other length has.
fn stream(identifier: Identifier) -> u32 {
    match identifier.id() {
        link_core::Id::Standard(id) => id.as_raw().into(),
        link_core::Id::Extended(id) => id.as_raw() | 0x8000_0000,
    }
}
