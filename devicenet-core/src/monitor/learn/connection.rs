//! The Connection object.

use cip_core::code::{InstanceId, ServiceCode};
use cip_core::monitor::attribute::{CONSUMED_ID, PRODUCED_ID};
use cip_core::monitor::{Connection, ConnectionState};
use link_core::Instant;

use super::super::connections::Predefined;
use super::super::created;
use super::super::pairing::Transaction;
use super::super::problem::Problem;
use super::super::state::State;
use crate::id::{Identifier, MacId, Purpose};

pub(super) fn learn<const N: usize>(
    state: &mut State<N>,
    server: MacId,
    instance: InstanceId,
    request: &Transaction,
    data: &[u8],
    at: Instant,
) -> Option<Problem> {
    let owner = state.node(server).owner();
    let predefined = Predefined::from_instance(instance);
    if request.asked.service == ServiceCode::DELETE {
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
    if request.asked.service == ServiceCode::RESET && instance.is_class() {
        state.reset_connections(server, at);
        return None;
    }
    let held = state.instance(server, instance)?;
    match request.asked.service {
        ServiceCode::GET_ATTRIBUTE_SINGLE => {
            let attribute = request.asked.attribute?.0;
            held.was_read(attribute, data, at);
            return wrong_identifier(predefined?, server, owner, attribute, data);
        }
        ServiceCode::SET_ATTRIBUTE_SINGLE => {
            held.was_set(request.asked.attribute?.0, request.asked.argument, data, at, predefined.is_some());
        }
        ServiceCode::SET_ATTRIBUTES_ALL => held.forget(),
        ServiceCode::APPLY_ATTRIBUTES => held.enter(ConnectionState::Established, at),
        ServiceCode::RESET => held.restart(at),
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
pub(in crate::monitor) fn connection_id(request: &Transaction, data: &[u8]) -> Option<(u16, u16)> {
    let attribute = request.asked.attribute?.0;
    let raw = match (attribute, request.asked.service, data) {
        (PRODUCED_ID | CONSUMED_ID, ServiceCode::GET_ATTRIBUTE_SINGLE, &[low, high]) => {
            u16::from_le_bytes([low, high])
        }
        (PRODUCED_ID | CONSUMED_ID, ServiceCode::SET_ATTRIBUTE_SINGLE, _) => request.asked.word(),
        _ => return None,
    };
    Some((attribute, raw))
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

/// A connection that UCMM has opened.
pub(in crate::monitor) fn opened(at: Instant) -> Connection {
    let mut connection = Connection::NEW;
    connection.open(at);
    connection
}
