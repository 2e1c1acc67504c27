//! What a successful request teaches about the connections and the identity of a node.

mod allocation;
mod connection;
mod identity;

use cip_core::code::{ClassId, ServiceCode};
use cip_core::codec::Wire;
use cip_core::message::AttributeReplies;
use cip_core::names::value_len;
use link_core::Instant;

use super::pairing::Transaction;
use super::problem::Problem;
use super::state::{Link, State};

pub(super) use connection::{connection_id, opened};

/// Learns from the response to `request`, which came by `link`. What the response reveals to be wrong is returned.
pub(super) fn success<const N: usize>(
    state: &mut State<N>,
    link: Link,
    request: &Transaction,
    data: &[u8],
    at: Instant,
) -> Option<Problem> {
    let (class, instance) = (request.class?, request.instance?);
    if request.service == ServiceCode::GET_ATTRIBUTE_LIST {
        return several(state, link, request, data, at);
    }
    let server = link.server;
    match class {
        ClassId::DEVICENET => allocation::learn(state, link, request, data, at),
        ClassId::IDENTITY => identity::learn(state, server, instance, request, data, at),
        ClassId::CONNECTION => return connection::learn(state, server, instance, request, data, at),
        _ => {}
    }
    None
}

/// Learns from the response to Get_Attribute_List as from as many single ones.
fn several<const N: usize>(
    state: &mut State<N>,
    link: Link,
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
        problem = problem.or(success(state, link, &single, value, at));
    }
    problem
}
