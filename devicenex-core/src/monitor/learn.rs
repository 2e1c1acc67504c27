//! What a successful request teaches about the connections and the identity of a node.

use cip_core::code::{ClassId, InstanceId, ServiceCode};
use cip_core::codec::Wire;
use cip_core::identity::IdentityAttributes;
use cip_core::monitor::attribute::{CONSUMED_ID, PRODUCED_ID};
use cip_core::monitor::{Asked, packet};
use link_core::Instant;

use super::connections::{ConnectionName, Held};
use super::nodes::Node;
use super::problem::Problem;
use super::state::State;
use super::talk::Request;
use super::vocabulary::DEVICENEX;
use crate::connection::ConnectionId;
use crate::id::OperationalAddress;

/// Learns from the response to `request`. What the response reveals to be wrong is returned.
pub(super) fn success<const N: usize>(
    state: &mut State<N>,
    server: OperationalAddress,
    request: &Request,
    data: &[u8],
    at: Instant,
) -> Option<Problem> {
    if packet::has_parts(request.asked.service) {
        let parts = state.packets.answer(request.seen.n);
        let mut problem = None;
        let flaw = packet::answered(&parts, &request.asked, data, |asked, data| {
            problem = problem.or(single(state, server, asked, data, at));
        });
        return problem.or(flaw.map(Into::into));
    }
    single(state, server, &request.asked, data, at)
}

fn single<const N: usize>(
    state: &mut State<N>,
    server: OperationalAddress,
    asked: &Asked,
    data: &[u8],
    at: Instant,
) -> Option<Problem> {
    let (class, instance) = (asked.class?, asked.instance?);
    if asked.service == ServiceCode::GET_ATTRIBUTE_LIST {
        let mut problem = None;
        packet::replies(asked, data, &DEVICENEX, |asked, value| {
            problem = problem.or(single(state, server, asked, value, at));
        });
        return problem;
    }
    match class {
        ClassId::IDENTITY => {
            if asked.service == ServiceCode::RESET {
                state.drop_connections(server, at);
            } else if !instance.is_class()
                && let Some(node) = state.node(server)
            {
                identity(node, asked, data);
            }
        }
        ClassId::CONNECTION => return connection(state, server, instance, asked, data, at),
        _ => {}
    }
    None
}

fn identity(node: &mut Node, asked: &Asked, data: &[u8]) {
    if asked.service == ServiceCode::GET_ATTRIBUTES_ALL
        && let Ok(all) = IdentityAttributes::parse(data)
    {
        node.device_type = Some(all.identity.device_type);
        node.minor_revision = Some(all.identity.revision.minor);
        node.set_name(all.identity.name.as_bytes());
    }
    if asked.service != ServiceCode::GET_ATTRIBUTE_SINGLE {
        return;
    }
    match (asked.attribute.map(|attribute| attribute.0), data) {
        (Some(2), &[low, high]) => node.device_type = Some(u16::from_le_bytes([low, high]).into()),
        (Some(4), &[_, minor]) => node.minor_revision = Some(minor),
        (Some(7), [len, name @ ..]) if usize::from(*len) == name.len() => node.set_name(name),
        _ => {}
    }
}

fn connection<const N: usize>(
    state: &mut State<N>,
    server: OperationalAddress,
    instance: InstanceId,
    asked: &Asked,
    data: &[u8],
    at: Instant,
) -> Option<Problem> {
    if instance.is_class() {
        return None;
    }
    if state.instance(server, instance).is_none() {
        state.insert(Held::unknown(server, ConnectionName::Instance(instance), at));
    }
    let held = state.instance(server, instance)?;
    let attribute = asked.attribute.map(|attribute| attribute.0);
    match (asked.service, attribute) {
        (ServiceCode::GET_ATTRIBUTE_SINGLE, Some(attribute)) => {
            held.connection.was_read(attribute, data, at);
            let &[a, b, c, d] = data else { return None };
            let found = ConnectionId::from(u32::from_le_bytes([a, b, c, d]));
            match attribute {
                CONSUMED_ID => held.consumed = found.identifier(),
                PRODUCED_ID => {
                    let expected = ConnectionId::from(held.produced()?);
                    let is_wrong = found != expected && found != ConnectionId::NONE;
                    return is_wrong.then_some(Problem::WrongConnectionId { expected, found });
                }
                _ => {}
            }
        }
        (ServiceCode::SET_ATTRIBUTE_SINGLE, Some(CONSUMED_ID)) => {
            held.consumed = ConnectionId::from(asked.argument).identifier();
        }
        (ServiceCode::SET_ATTRIBUTE_SINGLE, Some(attribute)) => {
            held.connection.was_set(attribute, asked.argument, data, at, true);
        }
        (ServiceCode::APPLY_ATTRIBUTES, _) => {
            held.connection.enter(cip_core::monitor::ConnectionState::Established, at);
        }
        (ServiceCode::RESET, _) => held.connection.restart(at),
        (ServiceCode::DELETE, _) => held.connection.end(at),
        _ => {}
    }
    None
}
