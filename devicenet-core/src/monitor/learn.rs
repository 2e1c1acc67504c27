//! What a successful request teaches about the connections and the identity of a node.

use cip_core::code::{AttributeId, ClassId, DeviceType, InstanceId, ServiceCode, VendorId};
use cip_core::codec::Wire;
use cip_core::epath::Epath;
use cip_core::identity::{DeviceIdentity, IdentityAttributes, OptionalAttributes};
use cip_core::message::{AllocationChoice, AttributeReplies, BodyFormat};
use cip_core::names::value_len;
use link_core::Instant;

use super::connection::{Connection, EXPLICIT_EPR};
use super::connections::{ConnectionState, Predefined};
use super::created;
use super::explicit::{Channel, Knowledge};
use super::nodes::{Allocation, Identity, Node, Roles};
use super::pairing::Transaction;
use super::problem::Problem;
use super::state::State;
use crate::id::{Identifier, MacId, Purpose};

/// Learns from the response to `request`. What the response reveals to be wrong is returned.
pub(super) fn success<const N: usize>(
    state: &mut State<N>,
    server: MacId,
    request: &Transaction,
    data: &[u8],
    at: Instant,
) -> Option<Problem> {
    let (class, instance) = (request.class?, request.instance?);
    if request.service == ServiceCode::GET_ATTRIBUTE_LIST {
        return several(state, server, request, data, at);
    }
    match class {
        ClassId::DEVICENET => devicenet(state, server, request, data, at),
        ClassId::IDENTITY => identity(state, server, instance, request, data, at),
        ClassId::CONNECTION => return connection(state, server, instance, request, data, at),
        _ => {}
    }
    None
}

/// Learns from the response to Get_Attribute_List as from as many single ones.
fn several<const N: usize>(
    state: &mut State<N>,
    server: MacId,
    request: &Transaction,
    data: &[u8],
    at: Instant,
) -> Option<Problem> {
    let (class, instance) = (request.class?, request.instance?);
    let len = |attribute, data: &[u8]| value_len(class, instance, attribute, data);
    let mut problem = None;
    for reply in AttributeReplies::parse(data).ok()?.iter(len).flatten() {
        let Ok(value) = reply.value else { continue };
        let service = ServiceCode::GET_ATTRIBUTE_SINGLE;
        let single = Transaction { service, attribute: Some(reply.attribute), ..*request };
        problem = problem.or(success(state, server, &single, value, at));
    }
    problem
}

fn devicenet<const N: usize>(
    state: &mut State<N>,
    server: MacId,
    request: &Transaction,
    data: &[u8],
    at: Instant,
) {
    if request.instance.is_none_or(InstanceId::is_class) {
        return;
    }
    let [choice, _] = request.argument.to_le_bytes();
    let choice = AllocationChoice::from_bits_retain(choice);
    match request.service {
        ServiceCode::ALLOCATE => {
            let format = data.first().and_then(|&code| BodyFormat::from_code(code)).unwrap_or_default();
            let master = request.allocator.unwrap_or(request.requester);
            allocated(state.node(server), choice, master, format, at);
            state.add_role(server, Roles::SLAVE);
            state.add_role(master, Roles::MASTER);
        }
        ServiceCode::RELEASE => released(state.node(server), choice, at),
        ServiceCode::GET_ATTRIBUTE_SINGLE if request.attribute == Some(ALLOCATION_INFORMATION) => {
            if let &[choice, master] = data {
                let choice = AllocationChoice::from_bits_retain(choice);
                state.node(server).allocation = Some(Allocation { choice, master: MacId::new(master) });
            }
        }
        // The node goes on under its new MAC ID.
        ServiceCode::SET_ATTRIBUTE_SINGLE if request.attribute == Some(MAC_ID) => {
            state.drop_connections(server, at);
        }
        _ => {}
    }
}

fn allocated(node: &mut Node, choice: AllocationChoice, master: MacId, format: BodyFormat, at: Instant) {
    node.settle(at);
    if node.told_owner().is_some_and(|held| held != master) {
        // Another master gets it only after all of its connections have ended.
        node.connections.iter_mut().for_each(|connection| connection.end(at));
        node.explicit = Channel::NEW;
    }
    if choice.contains(AllocationChoice::MULTICAST_POLL) {
        node.group = None;
    }
    if choice.contains(AllocationChoice::EXPLICIT) {
        node.connection(Predefined::Explicit).allocate(Predefined::Explicit, at);
        node.explicit = Channel::told(format);
    } else if node.explicit.knowledge == Knowledge::None {
        node.explicit.format = format;
        node.explicit.knowledge = Knowledge::Likely;
    }
    let changes = choice.intersects(AllocationChoice::CHANGE_OF_STATE | AllocationChoice::CYCLIC);
    let poll = node.connection(Predefined::Poll);
    if choice.contains(AllocationChoice::POLL) || (changes && poll.state != ConnectionState::Established) {
        poll.allocate(Predefined::Poll, at);
    }
    for (bit, which) in [
        (AllocationChoice::BIT_STROBE, Predefined::BitStrobe),
        (AllocationChoice::MULTICAST_POLL, Predefined::MulticastPoll),
    ] {
        if choice.contains(bit) {
            node.connection(which).allocate(which, at);
        }
    }
    if changes {
        node.connection(Predefined::CosCyclic).allocate(Predefined::CosCyclic, at);
    }
    let kept = node.allocation.filter(|held| held.master == Some(master)).map(|_| node.live_choice());
    let choice = kept.unwrap_or_default() | choice;
    node.allocation = Some(Allocation { choice, master: Some(master) });
}

fn released(node: &mut Node, choice: AllocationChoice, at: Instant) {
    let choice = choice.difference(AllocationChoice::ACK_SUPPRESSION);
    let kept = node.choice().map(|held| held.difference(choice));
    let changes = AllocationChoice::CHANGE_OF_STATE | AllocationChoice::CYCLIC;
    if choice.contains(AllocationChoice::EXPLICIT) {
        node.connection(Predefined::Explicit).end(at);
        node.explicit = Channel::NEW;
    }
    let keeps_poll = kept.is_some_and(|kept| kept.intersects(changes | AllocationChoice::POLL));
    if choice.contains(AllocationChoice::POLL) || (choice.intersects(changes) && !keeps_poll) {
        node.connection(Predefined::Poll).end(at);
    }
    if choice.contains(AllocationChoice::BIT_STROBE) {
        node.connection(Predefined::BitStrobe).end(at);
    }
    if choice.contains(AllocationChoice::MULTICAST_POLL) {
        node.connection(Predefined::MulticastPoll).end(at);
    }
    if choice.intersects(changes) {
        node.connection(Predefined::CosCyclic).end(at);
    }
    if let Some(kept) = kept {
        let gone = kept.difference(AllocationChoice::ACK_SUPPRESSION).is_empty();
        let master = node.owner().filter(|_| !gone);
        let choice = if gone { AllocationChoice::empty() } else { kept };
        node.allocation = Some(Allocation { choice, master });
    }
}

fn identity<const N: usize>(
    state: &mut State<N>,
    server: MacId,
    instance: InstanceId,
    request: &Transaction,
    data: &[u8],
    at: Instant,
) {
    if request.service == ServiceCode::RESET {
        state.drop_connections(server, at);
        return;
    }
    let node = state.node(server);
    if instance.is_class() {
        return;
    }
    if request.service == ServiceCode::SET_ATTRIBUTE_SINGLE && request.attribute == Some(AttributeId(10)) {
        let [interval, _] = request.argument.to_le_bytes();
        node.heartbeat_interval = Some(interval);
    }
    if request.service == ServiceCode::GET_ATTRIBUTES_ALL
        && let Ok(all) = IdentityAttributes::parse(data)
    {
        identity_of(node, &all);
        return;
    }
    if request.service != ServiceCode::GET_ATTRIBUTE_SINGLE {
        return;
    }
    let held = &mut node.identity;
    match (request.attribute.unwrap_or(AttributeId(0)).0, data) {
        (1, &[low, high]) => held.vendor = Some(VendorId(u16::from_le_bytes([low, high]))),
        (2, &[low, high]) => held.device_type = Some(DeviceType(u16::from_le_bytes([low, high]))),
        (3, &[low, high]) => held.product = Some(u16::from_le_bytes([low, high])),
        (4, &[major, minor]) => held.revision = Some((major, minor)),
        (6, &[a, b, c, d]) => held.serial = Some(u32::from_le_bytes([a, b, c, d])),
        (7, [len, name @ ..]) if usize::from(*len) == name.len() => node.set_name(name),
        (10, &[interval]) => node.heartbeat_interval = Some(interval),
        _ => {}
    }
}

fn identity_of(node: &mut Node, all: &IdentityAttributes) {
    let DeviceIdentity { vendor, device_type, product_code, revision, serial, name } = &all.identity;
    node.identity = Identity {
        vendor: Some(*vendor),
        serial: Some(*serial),
        device_type: Some(*device_type),
        product: Some(*product_code),
        revision: Some((revision.major, revision.minor)),
    };
    node.set_name(name.as_bytes());
    if let OptionalAttributes::Heartbeat(_, _, interval) = all.optional {
        node.heartbeat_interval = Some(interval);
    }
}

fn connection<const N: usize>(
    state: &mut State<N>,
    server: MacId,
    instance: InstanceId,
    request: &Transaction,
    data: &[u8],
    at: Instant,
) -> Option<Problem> {
    let owner = state.node(server).owner();
    let predefined = Predefined::from_instance(instance);
    if request.service == ServiceCode::DELETE {
        match predefined {
            Some(which) => state.node(server).connection(which).end(at),
            None if instance.is_class() => state.drop_connections(server, at),
            None => state.close_dynamic(server, instance, at),
        }
        return None;
    }
    if predefined == Some(Predefined::MulticastPoll)
        && let Some(group) = group_of(request, data)
    {
        state.node(server).group = Some(group);
    }
    if predefined.is_none() {
        created::learn(state, server, instance, request, data, at);
    }
    if request.service == ServiceCode::RESET && instance.is_class() {
        state.reset_connections(server, at);
        return None;
    }
    let held = state.instance(server, instance)?;
    match request.service {
        ServiceCode::GET_ATTRIBUTE_SINGLE => {
            let attribute = request.attribute?.0;
            got(held, attribute, data, at);
            return wrong_identifier(predefined?, server, owner, attribute, data);
        }
        ServiceCode::SET_ATTRIBUTE_SINGLE => {
            set(held, request.attribute?.0, request.argument, data, at, predefined.is_some());
        }
        ServiceCode::SET_ATTRIBUTES_ALL => held.forget(),
        ServiceCode::APPLY_ATTRIBUTES | ServiceCode::RESET => held.enter(ConnectionState::Established, at),
        _ => {}
    }
    None
}

/// The multicast group that attribute 5 of a multicast poll connection names: what was read, or what was set.
fn group_of(request: &Transaction, data: &[u8]) -> Option<MacId> {
    let (_, raw) = connection_id(request, data).filter(|&(attribute, _)| attribute == CONSUMED_ID)?;
    let identifier = Identifier::new(raw)?;
    identifier.mac_id().filter(|_| identifier.purpose() == Purpose::MulticastPollCommand)
}

/// Attribute 4 or 5 of the Connection object: what was read, or what was set.
pub(super) fn connection_id(request: &Transaction, data: &[u8]) -> Option<(u16, u16)> {
    let attribute = request.attribute?.0;
    let raw = match (attribute, request.service, data) {
        (PRODUCED_ID | CONSUMED_ID, ServiceCode::GET_ATTRIBUTE_SINGLE, &[low, high]) => {
            u16::from_le_bytes([low, high])
        }
        (PRODUCED_ID | CONSUMED_ID, ServiceCode::SET_ATTRIBUTE_SINGLE, _) => request.argument,
        _ => return None,
    };
    Some((attribute, raw))
}

fn got(held: &mut Connection, attribute: u16, data: &[u8], at: Instant) {
    match (attribute, data) {
        (STATE, &[value]) => {
            if let Some(state) = ConnectionState::from_attribute(value)
                && (state != held.state || held.assumed)
            {
                let active = held.active;
                held.enter(state, at);
                if state == ConnectionState::Established && active != Instant::ZERO {
                    held.touch(at);
                }
            }
        }
        (PRODUCED_SIZE, &[low, high]) => held.produced.size = Some(u16::from_le_bytes([low, high])),
        (CONSUMED_SIZE, &[low, high]) => held.consumed.size = Some(u16::from_le_bytes([low, high])),
        (EXPECTED_PACKET_RATE, &[low, high]) => held.epr = Some(u16::from_le_bytes([low, high])),
        (WATCHDOG_ACTION, &[action]) => held.watchdog_action = Some(action),
        (PRODUCED_PATH, path) => held.produced.path = instance_of(path),
        (CONSUMED_PATH, path) => held.consumed.path = instance_of(path),
        (INHIBIT_TIME, &[low, high]) => held.inhibit = Some(u16::from_le_bytes([low, high])),
        (TIMEOUT_MULTIPLIER, &[multiplier]) => held.multiplier = multiplier,
        _ => {}
    }
}

/// `applies`: the expected packet rate establishes a connection of the predefined set; others wait for Apply_Attributes.
fn set(held: &mut Connection, attribute: u16, argument: u16, data: &[u8], at: Instant, applies: bool) {
    let [low, _] = argument.to_le_bytes();
    let path = Some(InstanceId(argument)).filter(|instance| !instance.is_class());
    match attribute {
        EXPECTED_PACKET_RATE => {
            // A response without data means that the value sent is used.
            let used = match *data {
                [low, high] => u16::from_le_bytes([low, high]),
                _ => argument,
            };
            held.epr = Some(used);
            match held.state {
                // A new rate does not bring a connection back that has timed out.
                ConnectionState::TimedOut if !held.assumed => {}
                ConnectionState::Established => held.active = at,
                _ if applies => held.enter(ConnectionState::Established, at),
                _ => {}
            }
        }
        PRODUCED_SIZE => held.produced.size = Some(argument),
        CONSUMED_SIZE => held.consumed.size = Some(argument),
        WATCHDOG_ACTION => held.watchdog_action = Some(low),
        INHIBIT_TIME => held.inhibit = Some(argument),
        TIMEOUT_MULTIPLIER => held.multiplier = low,
        // Another assembly: the sizes follow it and are to be learned again.
        PRODUCED_PATH => {
            held.produced.size = None;
            held.produced.path = path;
        }
        CONSUMED_PATH => {
            held.consumed.size = None;
            held.consumed.path = path;
        }
        _ => {}
    }
}

/// Attributes 4 and 5 of a predefined connection must name the identifiers of the set.
fn wrong_identifier(
    which: Predefined,
    server: MacId,
    owner: Option<MacId>,
    attribute: u16,
    data: &[u8],
) -> Option<Problem> {
    let &[low, high] = data else { return None };
    let found = u16::from_le_bytes([low, high]);
    let identifier = match (which, attribute) {
        (Predefined::Explicit, PRODUCED_ID) => Identifier::explicit_response(server),
        (Predefined::Explicit, CONSUMED_ID) => Identifier::explicit_request(server),
        (Predefined::Poll, PRODUCED_ID) => Identifier::poll_response(server),
        (Predefined::Poll, CONSUMED_ID) => Identifier::poll_command(server),
        (Predefined::BitStrobe, PRODUCED_ID) => Identifier::bit_strobe_response(server),
        (Predefined::BitStrobe, CONSUMED_ID) => Identifier::bit_strobe_command(owner?),
        (Predefined::CosCyclic, PRODUCED_ID) => Identifier::change_of_state(server),
        (Predefined::CosCyclic, CONSUMED_ID) => Identifier::change_of_state_acknowledge(server),
        (Predefined::MulticastPoll, PRODUCED_ID) => Identifier::multicast_poll_response(server),
        _ => return None,
    };
    let expected = identifier.raw();
    // 0xFFFF: the connection does not use this direction.
    (found != expected && found != 0xFFFF).then_some(Problem::WrongConnectionId { expected, found })
}

/// The instance that a connection path names.
pub(super) fn instance_of(path: &[u8]) -> Option<InstanceId> {
    Epath::packed(path).logical().ok()?.instance
}

/// A connection that UCMM has opened.
pub(super) fn opened(at: Instant) -> Connection {
    let mut connection = Connection::NEW;
    connection.allocate(Predefined::Explicit, at);
    connection.epr = Some(EXPLICIT_EPR);
    connection
}

const MAC_ID: AttributeId = AttributeId(1);
const ALLOCATION_INFORMATION: AttributeId = AttributeId(5);
const STATE: u16 = 1;
pub(super) const PRODUCED_ID: u16 = 4;
pub(super) const CONSUMED_ID: u16 = 5;
const PRODUCED_SIZE: u16 = 7;
const CONSUMED_SIZE: u16 = 8;
pub(super) const EXPECTED_PACKET_RATE: u16 = 9;
const WATCHDOG_ACTION: u16 = 12;
pub(super) const PRODUCED_PATH: u16 = 14;
pub(super) const CONSUMED_PATH: u16 = 16;
const INHIBIT_TIME: u16 = 17;
const TIMEOUT_MULTIPLIER: u16 = 18;
