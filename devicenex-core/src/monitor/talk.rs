//! What two nodes are about: requests that wait, and fragments under way.

use core::time::Duration;

use cip_core::message::BodyFormat;
use cip_core::monitor::{Asked, Flaw, Flights, Flow, Seen};
use link_core::Instant;

use crate::id::OperationalAddress;
use crate::message::ConnectionRequest;

/// The messages between a client and a server on one of its ports.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Talk {
    pub(super) ends: Ends,
    pub(super) flights: Flights,
    /// The transaction ID of the message that is being put together, as its first fragment has told: of the client, of the
    /// server.
    transactions: [Option<u8>; 2],
    requests: [Option<Request>; REQUESTS],
    /// A complete request was seen: a response without one is unexpected from then on.
    pub(super) asked: bool,
    pub(super) active: Instant,
}

/// Who talks to whom, and where.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Ends {
    pub(super) client: OperationalAddress,
    pub(super) server: OperationalAddress,
    pub(super) port: Port,
}

/// Where a server is asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Port {
    /// For a connection.
    Connection,
    /// Without a connection.
    Connectionless,
    /// On an explicit connection.
    Explicit,
}

/// A request that was seen and not answered yet, with what the response does not repeat.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Request {
    pub(super) seen: Seen,
    pub(super) transaction: u8,
    pub(super) asked: Asked,
    pub(super) format: BodyFormat,
    /// The request for a connection, if it is one.
    pub(super) connect: Option<ConnectionRequest>,
    /// The request was read in a body format that is only assumed.
    pub(super) assumed: bool,
}

/// The request that a response answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Pairing {
    /// This one.
    Answers(Request),
    /// None: it was not seen.
    Assumed,
    /// None, and that is wrong.
    Wrong(Flaw),
}

impl Talk {
    pub(super) const fn new(ends: Ends, at: Instant) -> Self {
        Self {
            ends,
            flights: Flights::NEW,
            transactions: [None; 2],
            requests: [None; REQUESTS],
            asked: false,
            active: at,
        }
    }

    /// The transaction ID of the message that is being put together.
    pub(super) fn transaction(&mut self, flow: Flow) -> &mut Option<u8> {
        let [client, server] = &mut self.transactions;
        match flow {
            Flow::Consumed => client,
            Flow::Produced => server,
        }
    }

    /// Remembers a request. A newer one with the same transaction ID replaces it, in a full set the oldest of all. Returns
    /// false if another one was forgotten that could still be answered.
    pub(super) fn ask(&mut self, request: Request) -> bool {
        self.asked = true;
        let is_over = |slot: &Option<Request>| {
            slot.is_none_or(|held| {
                held.transaction == request.transaction
                    || request.seen.at.saturating_since(held.seen.at) > PATIENCE
            })
        };
        let room = self.requests.iter().position(is_over);
        let oldest = || {
            let ages = self.requests.iter().enumerate();
            let oldest = ages.min_by_key(|(_, slot)| slot.map_or(0, |held| held.seen.n));
            oldest.map(|(index, _)| index)
        };
        let index = room.or_else(oldest);
        if let Some(slot) = index.and_then(|index| self.requests.get_mut(index)) {
            *slot = Some(request);
        }
        room.is_some()
    }

    /// Takes the request that a response with this transaction ID answers, if it is one that `fits`.
    pub(super) fn answer(&mut self, transaction: u8, fits: impl Fn(&Request) -> Result<(), Flaw>) -> Pairing {
        let is_it = |slot: &&mut Option<Request>| slot.is_some_and(|held| held.transaction == transaction);
        if let Some(slot) = self.requests.iter_mut().find(is_it)
            && let Some(request) = *slot
        {
            return match fits(&request) {
                Ok(()) => {
                    *slot = None;
                    Pairing::Answers(request)
                }
                Err(flaw) => Pairing::Wrong(flaw),
            };
        }
        if self.requests.iter().flatten().next().is_some() {
            return Pairing::Wrong(Flaw::TransactionMismatch);
        }
        if self.asked { Pairing::Wrong(Flaw::UnexpectedResponse) } else { Pairing::Assumed }
    }
}

/// Requests of a client that wait at one server at a time.
const REQUESTS: usize = 4;
/// A request that was not answered for so long will not be.
const PATIENCE: Duration = Duration::from_secs(3);
