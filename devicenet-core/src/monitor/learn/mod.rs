//! What a successful request teaches about the connections and the identity of a node.

mod allocation;
mod connection;
mod identity;

use cip_core::code::{ClassId, ServiceCode};
use cip_core::monitor::{Vocabulary, packet};
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
    let (class, instance) = (request.asked.class?, request.asked.instance?);
    if request.asked.service == ServiceCode::GET_ATTRIBUTE_LIST {
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

/// Learns from the response to a request with parts as from the responses to each.
pub(super) fn parts<const N: usize>(
    state: &mut State<N>,
    link: Link,
    request: &Transaction,
    data: &[u8],
    at: Instant,
) -> Option<Problem> {
    let parts = state.packets.answer(request.seen.n);
    let mut problem = None;
    let flaw = packet::answered(&parts, &request.asked, data, |&asked, data| {
        let part = Transaction { asked, ..*request };
        problem = problem.or(success(state, link, &part, data, at));
    });
    problem.or(flaw.map(Into::into))
}

/// Learns from the response to Get_Attribute_List as from as many single ones.
fn several<const N: usize>(
    state: &mut State<N>,
    link: Link,
    request: &Transaction,
    data: &[u8],
    at: Instant,
) -> Option<Problem> {
    let mut problem = None;
    packet::replies(&request.asked, data, &Vocabulary::DEVICENET, |&asked, value| {
        let single = Transaction { asked, ..*request };
        problem = problem.or(success(state, link, &single, value, at));
    });
    problem
}
