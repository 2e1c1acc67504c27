//! The DeviceNet object: allocation and release of the predefined connection set, and the MAC ID.

use cip_core::code::{AttributeId, InstanceId, ServiceCode};
use cip_core::message::{AllocationChoice, BodyFormat};
use cip_core::monitor::{Connection, ConnectionState};
use link_core::Instant;

use super::super::connections::Predefined;
use super::super::explicit::{Channel, Knowledge};
use super::super::nodes::{Allocation, Node, Parent, Roles};
use super::super::pairing::Transaction;
use super::super::state::{Link, State};
use crate::id::MacId;

pub(super) fn learn<const N: usize>(
    state: &mut State<N>,
    link: Link,
    request: &Transaction,
    data: &[u8],
    at: Instant,
) {
    if request.asked.instance.is_none_or(InstanceId::is_class) {
        return;
    }
    let server = link.server;
    let [choice, ..] = request.asked.argument.to_le_bytes();
    let choice = AllocationChoice::from_bits_retain(choice);
    match request.asked.service {
        ServiceCode::ALLOCATE => {
            let format = data.first().and_then(|&code| BodyFormat::from_code(code)).unwrap_or_default();
            let master = request.allocator().unwrap_or(request.requester);
            state.settle(server, at);
            let parent = state.held(link).map(|held| Parent { client: held.client, instance: held.instance });
            allocated(state.node(server), choice, master, format, at, parent);
            state.add_role(server, Roles::SLAVE);
            state.add_role(master, Roles::MASTER);
        }
        ServiceCode::RELEASE => {
            state.settle(server, at);
            released(state.node(server), choice, at);
        }
        ServiceCode::GET_ATTRIBUTE_SINGLE if request.asked.attribute == Some(ALLOCATION_INFORMATION) => {
            if let &[choice, master] = data {
                let choice = AllocationChoice::from_bits_retain(choice);
                state.node(server).allocation = Some(Allocation { choice, master: MacId::new(master) });
            }
        }
        // The node goes on under its new MAC ID.
        ServiceCode::SET_ATTRIBUTE_SINGLE if request.asked.attribute == Some(MAC_ID) => {
            state.drop_connections(server, at);
        }
        _ => {}
    }
}

fn allocated(
    node: &mut Node,
    choice: AllocationChoice,
    master: MacId,
    format: BodyFormat,
    at: Instant,
    through: Option<Parent>,
) {
    if node.choice().is_some() && node.told_owner().is_none() {
        // The ownership had lapsed. What has timed out stays only until now.
        let timed_out = |connection: &&mut Connection| connection.state == ConnectionState::TimedOut;
        node.connections.iter_mut().filter(timed_out).for_each(Connection::lapse);
    } else if node.told_owner().is_some_and(|held| held != master) {
        // Another master gets it only after all of its connections have ended.
        node.connections.iter_mut().for_each(|connection| connection.end(at));
        node.explicit = Channel::NEW;
    }
    if choice.contains(AllocationChoice::MULTICAST_POLL) {
        node.group = None;
    }
    if choice.contains(AllocationChoice::EXPLICIT) {
        node.connection(Predefined::Explicit).open(at);
        node.explicit = Channel::told(format);
    } else if node.explicit.knowledge == Knowledge::None {
        node.explicit.format = format;
        node.explicit.knowledge = Knowledge::Likely;
    }
    let changes = choice.intersects(CHANGES);
    // Instance 2 serves poll and the master's changes: what it is already, it stays.
    let shares = changes || node.choice().is_some_and(|held| held.intersects(CHANGES));
    let poll = node.connection(Predefined::Poll);
    let exists = poll.is_alive() || poll.state == ConnectionState::Configuring;
    if (changes || choice.contains(AllocationChoice::POLL)) && !(shares && exists) {
        poll.allocate(at);
    }
    for (bit, which) in [
        (AllocationChoice::BIT_STROBE, Predefined::BitStrobe),
        (AllocationChoice::MULTICAST_POLL, Predefined::MulticastPoll),
    ] {
        if choice.contains(bit) {
            node.connection(which).allocate(at);
        }
    }
    if changes {
        node.connection(Predefined::CosCyclic).allocate(at);
    }
    let explicit = node.peek(Predefined::Explicit).state;
    let is_own = !matches!(explicit, ConnectionState::NonExistent | ConnectionState::Unknown);
    node.parent = through.filter(|_| !is_own);
    let kept = node.allocation.filter(|held| held.master == Some(master)).map(|_| node.live_choice());
    let choice = kept.unwrap_or_default() | choice;
    node.allocation = Some(Allocation { choice, master: Some(master) });
}

fn released(node: &mut Node, choice: AllocationChoice, at: Instant) {
    let choice = choice.difference(AllocationChoice::ACK_SUPPRESSION);
    let kept = node.choice().map(|_| node.live_choice().difference(choice));
    if choice.contains(AllocationChoice::EXPLICIT) {
        node.connection(Predefined::Explicit).end(at);
        node.explicit = Channel::NEW;
    }
    let shared = CHANGES | AllocationChoice::POLL;
    if choice.intersects(shared) && !kept.unwrap_or_default().intersects(shared) {
        node.connection(Predefined::Poll).end(at);
    }
    if choice.contains(AllocationChoice::BIT_STROBE) {
        node.connection(Predefined::BitStrobe).end(at);
    }
    if choice.contains(AllocationChoice::MULTICAST_POLL) {
        node.connection(Predefined::MulticastPoll).end(at);
    }
    if choice.intersects(CHANGES) {
        node.connection(Predefined::CosCyclic).end(at);
    }
    if let Some(kept) = kept {
        let gone = kept.difference(AllocationChoice::ACK_SUPPRESSION).is_empty();
        let master = node.owner().filter(|_| !gone);
        let choice = if gone { AllocationChoice::empty() } else { kept };
        node.allocation = Some(Allocation { choice, master });
    }
}

/// What needs instance 4, and instance 2 for the other direction.
const CHANGES: AllocationChoice = AllocationChoice::CHANGE_OF_STATE.union(AllocationChoice::CYCLIC);
const MAC_ID: AttributeId = AttributeId(1);
const ALLOCATION_INFORMATION: AttributeId = AttributeId(5);
