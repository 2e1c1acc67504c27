//! What a slave tells the application, and what it counts.

use core::fmt::{self, Debug};
use core::hash::Hash;

use cip_core::code::{ClassId, InstanceId, ServiceCode};
use cip_core::connection::{ExplicitCause, ExplicitState, IoCause, IoState};
use cip_core::message::{AllocationChoice, ResetType};
use cip_core::names::Operation;
use cip_core::object::Effect;
use link_core::{BitRate, Queue, TxOutcome};

use super::application::{Application, IoKind, IoMode, Parts};
use super::indicator::ModuleStatus;
use crate::access::{AccessEvent, NetworkStatus};
use crate::counter;
use crate::id::{Identifier, MacId};

/// What happened in a slave.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Event {
    /// In network access.
    Access(AccessEvent),
    /// Everywhere else.
    Slave(SlaveEvent),
}

/// What happened in the connections and objects of a slave.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
// It begins with 1, so that places without one are zeros.
pub enum SlaveEvent {
    /// New data are in [`Application::consumed`](super::Application::consumed).
    Received(IoKind) = 1,
    /// What the consumed data mean has changed; the outputs are in the state that belongs to it.
    Mode(IoKind, IoMode),
    /// An I/O connection has another state.
    Io {
        /// Which.
        connection: IoKind,
        /// The state that was left.
        from: IoState,
        /// The state that was entered.
        to: IoState,
        /// Why.
        cause: IoCause,
    },
    /// An explicit connection has another state.
    Explicit {
        /// Its instance of the Connection object: 1, or 6 and up.
        instance: u8,
        /// The state that was left.
        from: ExplicitState,
        /// The state that was entered.
        to: ExplicitState,
        /// Why.
        cause: ExplicitCause,
    },
    /// The allocation information has changed (DeviceNet object, attribute 5).
    Allocation {
        /// The connections that are allocated and have not timed out.
        choice: AllocationChoice,
        /// The master that owns the slave.
        master: Option<MacId>,
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
    /// The device shall be reset. The slave has started anew; the rest of the device, and for the types 1 and 2 its
    /// configuration, are the application's business.
    Reset(ResetType),
    /// Keep this MAC ID over power cycles.
    StoreMacId(MacId),
    /// Keep this bit rate over power cycles.
    StoreBitRate(BitRate),
    /// Keep this value of Quick Connect over power cycles.
    StoreQuickConnect(bool),
    /// Keep this heartbeat interval, in seconds, over power cycles.
    StoreHeartbeatInterval(u8),
    /// This bit rate was detected, and is used from now on.
    BitRateDetected(BitRate),
    /// The network status indicator shows something else.
    NetworkStatus(NetworkStatus),
    /// The module status indicator shows something else.
    ModuleStatus(ModuleStatus),
    /// The master has not acknowledged the change of state or cyclic message, nor its repetitions.
    NotAcknowledged,
    /// A response in fragments was not acknowledged to its end, and is given up.
    ResponseAbandoned {
        /// The instance of the Connection object.
        instance: u8,
    },
    /// A frame was given back unsent although nobody asked for it.
    NotSent {
        /// The identifier that it would have had.
        id: Identifier,
        /// What the controller says.
        outcome: TxOutcome,
    },
    /// A frame for this node was not obeyed.
    Ignored {
        /// Where it was.
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
    /// The connection does not exist, or is not established.
    NoConnection,
    /// It is from another node than the one at the other end of the connection.
    ForeignNode,
    /// It has no header, or ends before its service, class and instance.
    TooShort,
    /// It is a response.
    Response,
    /// It is a fragment where messages are never fragmented.
    Fragment,
    /// It is a fragment out of its order.
    FragmentOrder,
    /// It is an acknowledge of something that was not sent.
    StrayAcknowledge,
    /// An I/O message has a length that the connection does not take.
    Length,
    /// The response would have to wait behind too many others.
    Busy,
    /// The node is about to leave the network.
    Leaving,
}

/// What a slave counted besides its network access. Every counter stays at its maximum.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Counters {
    /// Frames for this node that were not obeyed; each was told with its reason.
    pub ignored: u16,
    /// Frames on line that are for nobody here: those of other nodes, and of the node's own identifiers.
    pub foreign: u32,
    /// Explicit requests that were answered.
    pub requests: u16,
    /// Of these, the ones that were refused.
    pub refused: u16,
    /// I/O messages consumed.
    pub consumed: u32,
    /// I/O messages produced.
    pub produced: u32,
    /// I/O commands that were answered together with an earlier one, because the answer was still waiting.
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

/// Room for events, by how many connections can have some.
pub trait EventQueue: Clone + Eq + Hash + Debug + Default {
    /// False if there is no room.
    fn push(&mut self, event: SlaveEvent) -> bool;
    /// The oldest.
    fn pop(&mut self) -> Option<SlaveEvent>;
    /// Whether there is none.
    fn is_empty(&self) -> bool;
}

impl<const N: usize> EventQueue for Queue<SlaveEvent, N> {
    fn push(&mut self, event: SlaveEvent) -> bool {
        Self::push(self, event).is_ok()
    }

    fn pop(&mut self) -> Option<SlaveEvent> {
        self.pop()
    }

    fn is_empty(&self) -> bool {
        self.is_empty()
    }
}

/// Events that are still to be told. One input that comes in time never has more than fit. One that comes after several deadlines
/// does all that is overdue at once, and may have more; what is lost then is counted.
#[derive(Clone, PartialEq, Eq, Hash, Debug, Default)]
pub(super) struct Events<Q> {
    queue: Q,
    pub(super) counters: Counters,
}

impl<Q: EventQueue> Events<Q> {
    #[inline(never)]
    pub(super) fn raise<A: Application>(&mut self, event: SlaveEvent) {
        if A::PARTS.contains(Parts::EVENTS) && !self.queue.push(event) {
            count::<A>(&mut self.counters.events_lost);
        }
    }

    /// The oldest; before all others, what was received.
    pub(super) fn pop<A: Application>(&mut self, received: &mut Received) -> Option<SlaveEvent> {
        if !A::PARTS.contains(Parts::EVENTS) {
            return None;
        }
        received.pop::<A>().map(SlaveEvent::Received).or_else(|| self.queue.pop())
    }

    pub(super) fn is_empty<A: Application>(&self, received: Received) -> bool {
        !A::PARTS.contains(Parts::EVENTS) || (self.queue.is_empty() && received.0 == 0)
    }
}

/// The connections whose received data are still to be told, one bit each. Apart from the [`Events`], where they
/// would take four bytes of RAM instead of one.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub(super) struct Received(u8);

impl Received {
    pub(super) const fn insert<A: Application>(&mut self, connection: IoKind) {
        if A::PARTS.contains(Parts::EVENTS) {
            self.0 |= bit(connection);
        }
    }

    fn pop<A: Application>(&mut self) -> Option<IoKind> {
        let kind = IoKind::find::<A>(|kind| self.0 & bit(kind) != 0)?;
        self.0 &= !bit(kind);
        Some(kind)
    }
}

/// One more, if the slave has [`Parts::COUNTERS`].
#[inline]
pub(super) const fn count<A: Application>(counter: &mut u16) {
    if A::PARTS.contains(Parts::COUNTERS) {
        counter::count(counter);
    }
}

/// One more of what is frequent.
#[inline]
pub(super) const fn count_wide<A: Application>(counter: &mut u32) {
    if A::PARTS.contains(Parts::COUNTERS) {
        counter::count_wide(counter);
    }
}

const fn bit(connection: IoKind) -> u8 {
    match connection {
        IoKind::Poll => 1,
        IoKind::BitStrobe => 2,
        IoKind::ChangeOfState => 4,
        IoKind::MulticastPoll => 8,
    }
}

/// One line, in the words of a trace.
impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Access(event) => fmt::Display::fmt(event, f),
            Self::Slave(event) => fmt::Display::fmt(event, f),
        }
    }
}

/// One line, in the words of a trace.
impl fmt::Display for SlaveEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Received(connection) => write!(f, "{connection}: data received"),
            Self::Mode(connection, mode) => write!(f, "{connection}: {mode}"),
            Self::Io { connection, from, to, cause } => write!(f, "{connection}: {from} -> {to}: {cause}"),
            Self::Explicit { instance, from, to, cause } => {
                write!(f, "explicit connection {instance}: {from} -> {to}: {cause}")
            }
            Self::Allocation { choice, master: Some(master) } => write!(f, "allocated to {master}: {choice}"),
            Self::Allocation { master: None, .. } => f.write_str("not allocated"),
            Self::Changed { class, instance, service } => {
                write!(f, "{} done", Operation { service, class, instance })
            }
            Self::Effect(effect) => write!(f, "effect 0x{:04X}", effect.bits()),
            Self::Reset(kind) => write!(f, "reset: {kind}"),
            Self::StoreMacId(mac) => write!(f, "store MAC ID {mac}"),
            Self::StoreBitRate(rate) => write!(f, "store bit rate {rate}"),
            Self::StoreQuickConnect(on) => write!(f, "store Quick Connect {}", u8::from(on)),
            Self::StoreHeartbeatInterval(seconds) => write!(f, "store heartbeat interval {seconds} s"),
            Self::BitRateDetected(rate) => write!(f, "bit rate {rate} detected"),
            Self::NetworkStatus(status) => write!(f, "network status {status}"),
            Self::ModuleStatus(status) => write!(f, "module status {status}"),
            Self::NotAcknowledged => f.write_str("COS/cyclic message not acknowledged"),
            Self::ResponseAbandoned { instance } => {
                write!(f, "explicit connection {instance}: response given up, not acknowledged")
            }
            Self::NotSent { id, outcome } => write!(f, "{id} not sent: {outcome:?}"),
            Self::Ignored { id, why } => write!(f, "{id} ignored: {why}"),
        }
    }
}

impl fmt::Display for Ignored {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoConnection => "no such connection",
            Self::ForeignNode => "from a foreign node",
            Self::TooShort => "too short",
            Self::Response => "a response",
            Self::Fragment => "a fragment",
            Self::FragmentOrder => "fragment out of order",
            Self::StrayAcknowledge => "acknowledge of nothing",
            Self::Length => "wrong length",
            Self::Busy => "too many requests at once",
            Self::Leaving => "leaving the network",
        })
    }
}
