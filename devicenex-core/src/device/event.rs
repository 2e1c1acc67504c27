//! What a device tells the application, and what it counts.

use core::fmt;

use cip_core::code::{ClassId, GeneralStatus, InstanceId, ServiceCode};
use cip_core::connection::{ExplicitCause, ExplicitState, IoCause, IoMode, IoState};
use cip_core::message::ResetType;
use cip_core::names::Operation;
use cip_core::object::Effect;
use link_core::TxOutcome;

use crate::access::AccessEvent;
use crate::id::{Identifier, OperationalAddress};
use crate::message::ConnectionInstance;

/// What happened.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum DeviceEvent {
    /// In network access. When `Online` is left all connections are gone.
    Access(AccessEvent),
    /// New data are in [`Application::consumed`](super::Application::consumed).
    Received(ConnectionInstance),
    /// What the consumed data mean has changed; the outputs are in the state that belongs to it.
    Mode(ConnectionInstance, IoMode),
    /// An I/O connection has another state.
    Io {
        /// Which.
        connection: ConnectionInstance,
        /// The state that was left.
        from: IoState,
        /// The state that was entered.
        to: IoState,
        /// Why.
        cause: IoCause,
    },
    /// An explicit connection has another state.
    Explicit {
        /// Which.
        connection: ConnectionInstance,
        /// The state that was left.
        from: ExplicitState,
        /// The state that was entered.
        to: ExplicitState,
        /// Why.
        cause: ExplicitCause,
    },
    /// A connection request was refused.
    Refused {
        /// Who asked.
        requester: OperationalAddress,
        /// For which connection; `None` if the request names none, or cannot be read.
        connection: Option<ConnectionInstance>,
        /// What it was told.
        status: GeneralStatus,
    },
    /// A service has been carried out that was more than a question, and changed something.
    Changed {
        /// Of the object.
        class: ClassId,
        /// Of the object.
        instance: InstanceId,
        /// Which.
        service: ServiceCode,
    },
    /// What an object of the application wants done.
    Effect(Effect),
    /// The device shall be reset. The node has started anew; the rest of the device, and for the types 1 and 2 its
    /// configuration, are the application's business.
    Reset(ResetType),
    /// The consumer has not acknowledged the change of state or cyclic message, nor its repetitions.
    NotAcknowledged(ConnectionInstance),
    /// A response in fragments was not acknowledged to its end, and is given up.
    ResponseAbandoned {
        /// Who asked.
        requester: OperationalAddress,
    },
    /// A frame was given back unsent although nobody asked for it.
    NotSent {
        /// Its identifier.
        id: Identifier,
        /// What the controller says.
        outcome: TxOutcome,
    },
    /// A frame for this node was not obeyed.
    Ignored {
        /// Its identifier.
        id: Identifier,
        /// Why.
        why: Ignored,
    },
}

/// Why a frame was not obeyed.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Ignored {
    /// Its source is 127, or the own address.
    Source,
    /// The connection does not exist, or is not established.
    NoConnection,
    /// It ends before its service, class and instance, or a fragment before its data.
    TooShort,
    /// It has the identifier of a request and the service of a response.
    Response,
    /// It is a fragment where messages are never fragmented.
    Fragment,
    /// It is a fragment out of its order.
    FragmentOrder,
    /// It is an acknowledge of something that was not sent.
    StrayAcknowledge,
    /// An implicit message has a length that the connection does not take.
    Length,
    /// The response would have to wait behind too many others.
    Busy,
    /// The node is about to leave its address.
    Leaving,
}

/// What a device counted besides its network access. Every counter stays at its maximum.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Counters {
    /// Frames for this node that were not obeyed; each was told with its reason.
    pub ignored: u16,
    /// Frames on line that are for nobody here.
    pub foreign: u32,
    /// Explicit requests that were answered, on connections and without one.
    pub requests: u16,
    /// Of these, the ones without a connection.
    pub connectionless: u16,
    /// Of all of them, the ones that were refused.
    pub refused: u16,
    /// Connection requests that were granted.
    pub connections: u16,
    /// Connection requests that were refused.
    pub connections_refused: u16,
    /// Implicit messages consumed, acknowledges included.
    pub consumed: u32,
    /// Implicit messages produced.
    pub produced: u32,
    /// Commands that were answered together with an earlier one, because the answer was still waiting.
    pub merged: u16,
    /// Connections that timed out.
    pub timed_out: u16,
    /// Frames that were given back unsent although nobody asked for it.
    pub not_sent: u16,
    /// Answers to transmissions that were not under way: the port breaks the contract.
    pub stray_tx_done: u16,
    /// Events that were lost because nobody fetched them.
    pub events_lost: u16,
}

/// One line, in the words of a trace.
impl fmt::Display for DeviceEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Access(event) => fmt::Display::fmt(&event, f),
            Self::Received(connection) => write!(f, "{connection}: data received"),
            Self::Mode(connection, mode) => write!(f, "{connection}: {mode}"),
            Self::Io { connection, from, to, cause } => write!(f, "{connection}: {from} -> {to}: {cause}"),
            Self::Explicit { connection, from, to, cause } => {
                write!(f, "{connection}: {from} -> {to}: {cause}")
            }
            Self::Refused { requester, connection, status } => {
                write!(f, "connection refused to OA {requester}")?;
                connection.map_or(Ok(()), |connection| write!(f, ", {connection}"))?;
                write!(f, ": {status}")
            }
            Self::Changed { class, instance, service } => {
                write!(f, "{} done", Operation { service, class, instance })
            }
            Self::Effect(effect) => write!(f, "effect 0x{:04X}", effect.bits()),
            Self::Reset(kind) => write!(f, "reset: {kind}"),
            Self::NotAcknowledged(connection) => write!(f, "{connection}: not acknowledged"),
            Self::ResponseAbandoned { requester } => {
                write!(f, "response to OA {requester} given up, not acknowledged")
            }
            Self::NotSent { id, outcome } => write!(f, "{id} not sent: {outcome:?}"),
            Self::Ignored { id, why } => write!(f, "{id} ignored: {why}"),
        }
    }
}

impl fmt::Display for Ignored {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Source => "from an address that no other node has",
            Self::NoConnection => "no such connection",
            Self::TooShort => "too short",
            Self::Response => "a response",
            Self::Fragment => "a fragment",
            Self::FragmentOrder => "fragment out of order",
            Self::StrayAcknowledge => "acknowledge of nothing",
            Self::Length => "wrong length",
            Self::Busy => "too many requests at once",
            Self::Leaving => "leaving its address",
        })
    }
}
