//! Which response belongs to which request.

use cip_core::code::{AttributeId, ClassId, InstanceId, ServiceCode};
use cip_core::monitor::attribute::EXPECTED_PACKET_RATE;
use cip_core::monitor::{Asked, ConnectionState, Seen};

use crate::id::MacId;

/// A request that was seen and not answered yet, with what the response does not repeat.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Transaction {
    pub(super) seen: Seen,
    pub(super) requester: MacId,
    pub(super) xid: bool,
    pub(super) asked: Asked,
    /// The request was read in a body format that is only assumed.
    pub(super) assumed: bool,
}

impl Transaction {
    /// True if a response with this header and service byte answers the request.
    pub(super) fn is_answered_by(&self, to: MacId, xid: bool, service: ServiceCode) -> bool {
        self.requester == to
            && self.xid == xid
            && (service == self.asked.service || service == ServiceCode::ERROR_RESPONSE)
    }
}

impl Transaction {
    /// The second byte of an allocation.
    pub(super) fn allocator(&self) -> Option<MacId> {
        let [_, allocator, ..] = self.asked.argument.to_le_bytes();
        MacId::new(allocator)
    }

    /// True if a connection of the predefined set that is in this state is established when the server has done what is asked.
    pub(super) fn establishes(&self, instance: InstanceId, state: ConnectionState) -> bool {
        let is_its = self.asked.class == Some(ClassId::CONNECTION) && self.asked.instance == Some(instance);
        is_its
            && match (state, self.asked.service) {
                (ConnectionState::Configuring, ServiceCode::SET_ATTRIBUTE_SINGLE) => {
                    self.asked.attribute == Some(AttributeId(EXPECTED_PACKET_RATE))
                }
                (ConnectionState::Configuring, ServiceCode::APPLY_ATTRIBUTES)
                | (ConnectionState::TimedOut, ServiceCode::RESET) => true,
                _ => false,
            }
    }
}

/// The requests that wait on a port which serves several clients.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Waiting<const N: usize> {
    requests: [Option<Transaction>; N],
}

impl<const N: usize> Waiting<N> {
    pub(super) const fn new() -> Self {
        Self { requests: [None; N] }
    }

    /// Remembers a request. A client has one at a time: a newer one replaces it, in a full set the oldest of all.
    /// Returns false if the request of another client was forgotten.
    pub(super) fn insert(&mut self, request: Transaction) -> bool {
        let requests = &self.requests;
        let is_own =
            |slot: &Option<Transaction>| slot.is_some_and(|held| held.requester == request.requester);
        let own = requests.iter().position(is_own);
        let room = own.or_else(|| requests.iter().position(Option::is_none));
        let oldest = || {
            let ages = requests.iter().enumerate().min_by_key(|(_, slot)| slot.map_or(0, |held| held.seen.n));
            ages.map(|(index, _)| index)
        };
        let index = room.or_else(oldest);
        if let Some(slot) = index.and_then(|index| self.requests.get_mut(index)) {
            *slot = Some(request);
        }
        room.is_some()
    }

    /// The oldest request that the response answers.
    pub(super) fn find(&self, to: MacId, xid: bool, service: ServiceCode) -> Option<&Transaction> {
        let matching =
            self.requests.iter().flatten().filter(|request| request.is_answered_by(to, xid, service));
        matching.min_by_key(|request| request.seen.n)
    }

    /// The request of a client.
    pub(super) fn of(&self, requester: MacId) -> Option<&Transaction> {
        self.requests.iter().flatten().find(|request| request.requester == requester)
    }

    /// Forgets the request of frame `n`.
    pub(super) fn remove(&mut self, n: u64) {
        for slot in &mut self.requests {
            if slot.is_some_and(|request| request.seen.n == n) {
                *slot = None;
            }
        }
    }
}
