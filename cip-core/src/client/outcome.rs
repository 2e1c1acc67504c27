//! What a conversation tells its owner, and how long it waits.

use core::time::Duration;

use link_core::Timers;
use link_core::timers::TimerKey;

use crate::message::{EmitError, Response};

/// How long a client waits.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Waits {
    /// T_ack, for the acknowledge of a fragment. Default 1 s.
    pub acknowledge: Duration,
    /// For the response. Default 2.5 s; for the unconnected port and the UCMM 1 s is usual
    /// ([`Waits::UNCONNECTED`]).
    #[doc(alias = "client.response_timeout_ms")]
    pub response: Duration,
    /// For the next fragment of a response. Default 3 s.
    #[doc(alias = "frag.rx_timeout_ms")]
    pub next_fragment: Duration,
}

impl Waits {
    /// On an explicit connection.
    pub const CONNECTED: Self = Self {
        acknowledge: Duration::from_millis(1000),
        response: Duration::from_millis(2500),
        next_fragment: Duration::from_millis(3000),
    };
    /// On the unconnected port and with the UCMM.
    pub const UNCONNECTED: Self = Self { response: Duration::from_millis(1000), ..Self::CONNECTED };
}

/// What the owner must do with the timer that it keeps for a conversation.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum TimerChange {
    /// Leave it as it is.
    #[default]
    Keep,
    /// Start it, or start it anew.
    Set(Duration),
    /// Stop it.
    Clear,
}

impl TimerChange {
    /// Does it to the owner's timer for the conversation.
    pub fn apply<K: TimerKey<N>, const N: usize>(self, timers: &mut Timers<K, N>, key: K) {
        match self {
            Self::Keep => {}
            Self::Set(span) => timers.set_after(key, span),
            Self::Clear => timers.clear(key),
        }
    }
}

/// What a frame meant to a conversation.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Progress<'a> {
    /// Another identifier, or the header names another client: not for this conversation.
    NotMine,
    /// It took the conversation further.
    Pending,
    /// The response, the end of the transaction. An error response is one too.
    Response(Response<'a>),
    /// The transaction came to nothing.
    Failed(Failure),
    /// For this conversation, but of no use.
    Ignored(Ignored),
}

/// Why a transaction came to nothing.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Failure {
    /// No response, or not all of it, after the last repetition.
    #[error("no response: the node is absent, or its connection is gone")]
    NoResponse,
    /// A fragment of the request was sent twice and not acknowledged.
    #[error(
        "a fragment of the request was not acknowledged: the node is absent, or does not support fragments"
    )]
    NotAcknowledged,
    /// The server cannot take so long a request (acknowledge status 1, or a reserved one).
    #[error("the request is too long for the server")]
    RequestTooLong,
    /// The response does not fit; the server was told so.
    #[error("the response is too long for this client")]
    ResponseTooLong,
    /// The response was put together and is none.
    #[error("the response is malformed")]
    Malformed,
}

/// Why a frame for the conversation was of no use.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Ignored {
    /// Too short, or a request.
    Malformed,
    /// Nothing is being waited for.
    Unexpected,
    /// The transaction ID is not that of the request: a response that comes too late.
    Stale,
    /// Another service than the one that was asked for.
    OtherService,
    /// An acknowledge of another fragment.
    OtherAcknowledge,
    /// A fragment of the response out of its order.
    OutOfSequence,
}

/// Why a transaction could not be started.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StartError {
    /// One at a time.
    #[error("a transaction is under way: wait for its end, or cancel it")]
    Busy,
    /// The request has no service byte.
    #[error("the request is empty: it must begin with a service")]
    Empty,
    /// The request does not fit into the conversation's buffer.
    #[error("the request is longer than the {capacity} bytes that this client can hold")]
    TooLong {
        /// The bytes that would fit.
        capacity: usize,
    },
    /// The body format of the connection cannot express the class or instance, or the service has more than seven bits.
    #[error(transparent)]
    NotAddressable(EmitError),
}
