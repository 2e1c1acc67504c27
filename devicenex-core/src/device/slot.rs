//! One connection of a device, with all that belongs to it.

use cip_core::code::InstanceId;
use cip_core::connection::{
    ConnectionState, ExplicitConnection, ExplicitState, IoConnection, IoMode, IoState, Production, Settings,
    TransportClassTrigger,
};
use cip_core::transfer::Transfer;

use super::event::DeviceEvent;
use super::line::Line;
use super::timer::Waits;
use crate::connection::{self, ACKNOWLEDGES, GroupMessage, requester_instance};
use crate::id::{Direction, Identifier, MessageId, OperationalAddress, Route};
use crate::message::{ConnectionInstance, Predefined, Production as Kind};

/// A place for a connection.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Slot<L, const MESSAGE: usize> {
    pub(super) instance: u8,
    /// Whose request it was.
    pub(super) requester: OperationalAddress,
    pub(super) body: Body<L, MESSAGE>,
    pub(super) line: Line,
    pub(super) timers: Waits,
    pub(super) news: News,
}

#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) enum Body<L, const MESSAGE: usize> {
    Free,
    Explicit(Explicit<MESSAGE>),
    Io(Io<L>),
}

/// For explicit messages.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Explicit<const MESSAGE: usize> {
    pub(super) connection: ExplicitConnection,
    /// Of the requests.
    pub(super) request: MessageId,
    /// Of the responses.
    pub(super) response: MessageId,
    /// Of the request that arrives in fragments.
    pub(super) transaction: u8,
    pub(super) transfer: Pipe<MESSAGE>,
}

/// For implicit messages.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Io<L> {
    pub(super) connection: IoConnection<TransportClassTrigger>,
    /// Where the requester produces.
    pub(super) peer: GroupMessage,
    /// Where this node does.
    pub(super) own: GroupMessage,
    /// Attribute 5, if it was set.
    pub(super) told_to_consume: Option<Identifier>,
    pub(super) production: Production,
    /// The next fragment of a message is to be sent.
    pub(super) continued: bool,
    pub(super) mode: IoMode,
    pub(super) long: L,
}

/// What is to be told of a connection. It is kept here until somebody fetches it, so that there is always room.
#[derive(Clone, PartialEq, Eq, Hash, Debug, Default)]
pub(super) struct News {
    /// A change of state.
    pub(super) moved: Option<DeviceEvent>,
    pub(super) mode: Option<(ConnectionInstance, IoMode)>,
    pub(super) received: Option<ConnectionInstance>,
    /// The outputs must be put to rest.
    pub(super) rest: bool,
}

/// An explicit connection, or the connectionless port, as a pipe. Eight bytes in each frame, of which one in a first fragment
/// is the transaction ID.
pub(super) type Pipe<const MESSAGE: usize> = Transfer<Reply, MESSAGE, 8, 1>;

/// What a response needs to know of its request.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) struct Reply {
    pub(super) client: OperationalAddress,
    pub(super) transaction: u8,
}

impl News {
    /// The next of it.
    pub(super) fn take(&mut self) -> Option<DeviceEvent> {
        let mode = |(connection, mode)| DeviceEvent::Mode(connection, mode);
        self.moved
            .take()
            .or_else(|| self.mode.take().map(mode))
            .or_else(|| self.received.take().map(DeviceEvent::Received))
    }

    pub(super) const fn is_empty(&self) -> bool {
        self.moved.is_none() && self.mode.is_none() && self.received.is_none()
    }
}

impl Reply {
    pub(super) const NOBODY: Self = Self { client: OperationalAddress::NONE, transaction: 0 };
}

impl<L, const MESSAGE: usize> Slot<L, MESSAGE> {
    pub(super) const FREE: Self = Self {
        instance: 0,
        requester: OperationalAddress::NONE,
        body: Body::Free,
        line: Line::IDLE,
        timers: Waits::new(),
        news: News { moved: None, mode: None, received: None, rest: false },
    };

    /// Which connection it is.
    pub(super) fn connection(&self) -> ConnectionInstance {
        ConnectionInstance::of(self.id())
    }

    pub(super) fn id(&self) -> InstanceId {
        InstanceId(self.instance.into())
    }

    /// Attribute 1; a free place has no connection.
    pub(super) fn state(&self) -> ConnectionState {
        match &self.body {
            Body::Free => ConnectionState::NON_EXISTENT,
            Body::Explicit(explicit) => explicit.connection.state().into(),
            Body::Io(io) => io.connection.state().into(),
        }
    }

    /// A connection that exists.
    pub(super) fn is_open(&self) -> bool {
        self.state() != ConnectionState::NON_EXISTENT
    }

    pub(super) const fn is_free(&self) -> bool {
        matches!(self.body, Body::Free)
    }

    pub(super) fn is_explicit_of(&self, requester: OperationalAddress) -> bool {
        matches!(self.body, Body::Explicit(_)) && self.requester == requester && self.is_open()
    }

    pub(super) fn is_established_io_of(&self, requester: OperationalAddress) -> bool {
        self.requester == requester && self.io_state() == Some(IoState::Established)
    }

    pub(super) fn io_state(&self) -> Option<IoState> {
        match &self.body {
            Body::Io(io) => Some(io.connection.state()),
            Body::Free | Body::Explicit(_) => None,
        }
    }

    /// What an I/O connection does.
    pub(super) const fn io_trigger(&self) -> Option<TransportClassTrigger> {
        match &self.body {
            Body::Io(io) => Some(io.trigger()),
            Body::Free | Body::Explicit(_) => None,
        }
    }

    pub(super) fn settings(&self) -> Option<&Settings> {
        match &self.body {
            Body::Free => None,
            Body::Explicit(explicit) => Some(explicit.connection.settings()),
            Body::Io(io) => Some(io.connection.settings()),
        }
    }

    /// Attribute 4.
    pub(super) fn produced(&self, own: OperationalAddress) -> Option<Identifier> {
        match &self.body {
            Body::Free => None,
            Body::Explicit(explicit) => {
                let route =
                    Route { destination: self.requester, direction: Direction::Response, source: own };
                connection::explicit(explicit.response, route)
            }
            Body::Io(io) => io.produced(own, self.id()),
        }
    }

    /// Attribute 5.
    pub(super) fn consumed(&self, own: OperationalAddress) -> Option<Identifier> {
        match &self.body {
            Body::Free => None,
            Body::Explicit(explicit) => {
                let route = Route { destination: own, direction: Direction::Request, source: self.requester };
                connection::explicit(explicit.request, route)
            }
            Body::Io(io) => io.consumed(own, self.requester, self.connection()),
        }
    }

    /// Nothing of it is left but what is to be told, and a frame that must be withdrawn.
    pub(super) fn free(&mut self) {
        self.body = Body::Free;
        self.timers.clear_all();
        self.line.abandon(false);
    }

    /// An explicit connection that has ended, and has nothing more to send, nor with the controller.
    pub(super) fn is_done(&self) -> bool {
        match &self.body {
            Body::Explicit(explicit) => {
                explicit.connection.state() == ExplicitState::NonExistent
                    && explicit.transfer.is_quiet()
                    && !explicit.transfer.must_acknowledge()
                    && self.line.is_free()
            }
            Body::Io(io) => io.connection.state() == IoState::NonExistent,
            Body::Free => false,
        }
    }
}

impl<L> Io<L> {
    pub(super) const fn trigger(&self) -> TransportClassTrigger {
        self.connection.kind()
    }

    /// Whether it sends anything: a server does if it answers.
    pub(super) const fn produces(&self) -> bool {
        !self.trigger().is_server() || self.trigger().class() != 0
    }

    pub(super) const fn consumes(&self) -> bool {
        self.trigger().is_server() || self.trigger().class() != 0
    }

    /// Whether all that it sends is acknowledges.
    pub(super) fn only_acknowledges(&self) -> bool {
        self.trigger() == ACKNOWLEDGES
    }

    pub(super) fn produced(&self, own: OperationalAddress, instance: InstanceId) -> Option<Identifier> {
        if !self.produces() {
            None
        } else if self.only_acknowledges() {
            Some(self.own.acknowledge(own, instance))
        } else {
            Some(self.own.produced(own, instance))
        }
    }

    fn consumed(
        &self,
        own: OperationalAddress,
        requester: OperationalAddress,
        connection: ConnectionInstance,
    ) -> Option<Identifier> {
        if !self.consumes() {
            return None;
        }
        let default = || match connection {
            // The producing end of a multicast pair is six instances before its consuming end.
            ConnectionInstance::Predefined(Predefined::Implicit(Kind::MulticastConsumer, length)) => {
                let producer = Predefined::Implicit(Kind::MulticastProducer, length);
                self.peer.produced(requester, InstanceId(producer.number().into()))
            }
            _ if self.trigger().is_server() => {
                self.peer.produced(requester, requester_instance(own, connection.number()))
            }
            _ => self.peer.acknowledge(requester, requester_instance(own, connection.number())),
        };
        Some(self.told_to_consume.unwrap_or_else(default))
    }
}
