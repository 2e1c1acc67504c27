//! The connections of a network: what is kept of them, and what a summary says.

use core::fmt;
use core::time::Duration;

use cip_core::code::InstanceId;
use cip_core::message::BodyFormat;
use cip_core::monitor::{Connection, ConnectionState, Flow};

use super::reading::OnConnection;
use crate::connection::{GroupMessage, requester_instance};
use crate::id::{Group, Identifier, Layout, MessageId, OperationalAddress};
use crate::message::{ConnectionInstance, GroupSelect, IdentifierLength, Predefined, Production};

/// Which connection of its server a connection is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ConnectionName {
    /// That with this instance.
    Instance(InstanceId),
    /// One for explicit messages that was heard of by its messages only.
    Explicit,
    /// One that the server produces on an 11-bit identifier, and that was heard of by its messages only.
    Standard {
        /// The group.
        group: Group,
        /// The Message ID.
        message: MessageId,
    },
}

/// What is known of a connection: a copy for a summary.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ConnectionRecord {
    /// Who has the instance.
    pub server: OperationalAddress,
    /// Who has asked for it; `None` if that was not seen.
    pub client: Option<OperationalAddress>,
    /// Which connection.
    pub name: ConnectionName,
    /// The state at the time of the last frame observed.
    pub state: ConnectionState,
    /// The state is inferred and not told by a message.
    pub assumed: bool,
    /// The states it has been in: bit n for `ConnectionState::ALL[n]`.
    pub states_seen: u8,
    /// Group and Message ID that the server produces with.
    pub group: Option<GroupSelect>,
    /// The expected packet rate that the server uses, in milliseconds.
    pub epr: Option<u16>,
    /// Attribute 12.
    pub watchdog_action: Option<u8>,
    /// Bytes of implicit data that the server consumes.
    pub consumed_size: Option<u16>,
    /// Bytes of implicit data that the server produces.
    pub produced_size: Option<u16>,
    /// The identifier that the server produces on.
    pub produced: Option<Identifier>,
    /// The identifier that the server consumes, where attribute 5 has told it.
    pub consumed: Option<Identifier>,
    /// The response time of the last answer on it.
    pub last_latency: Option<Duration>,
    /// Frames in both directions.
    pub frames: u64,
    /// Data bytes in both directions.
    pub bytes: u64,
}

/// All that is known of a connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Held {
    pub(super) server: OperationalAddress,
    pub(super) client: Option<OperationalAddress>,
    pub(super) name: ConnectionName,
    pub(super) is_explicit: bool,
    pub(super) group: Option<GroupSelect>,
    /// With which the client produces.
    pub(super) client_message: Option<MessageId>,
    /// With which the server produces.
    pub(super) server_message: Option<MessageId>,
    /// What attribute 5 has told: what the server consumes.
    pub(super) consumed: Option<Identifier>,
    pub(super) format: BodyFormat,
    /// The server has told the body format.
    pub(super) is_format_told: bool,
    pub(super) last_latency: Option<Duration>,
    pub(super) connection: Connection,
}

/// What makes a connection produce, as far as the monitor minds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Manner {
    /// Requests and responses.
    Explicit,
    /// A command of the client, and the server's answer.
    Polled,
    /// New data or the passing of time, and an acknowledge.
    Acknowledged,
    /// To whoever consumes.
    Multicast,
    /// It consumes what another one produces.
    Consumer,
    /// It is not known.
    Unknown,
}

impl Held {
    pub(super) fn new(server: OperationalAddress, name: ConnectionName) -> Self {
        Self {
            server,
            client: None,
            name,
            is_explicit: name == ConnectionName::Explicit || name == ConnectionName::Instance(EXPLICIT),
            group: None,
            client_message: None,
            server_message: None,
            consumed: None,
            format: BodyFormat::Class8Instance8,
            is_format_told: false,
            last_latency: None,
            connection: Connection::NEW,
        }
    }

    pub(super) const fn instance(&self) -> Option<InstanceId> {
        match self.name {
            ConnectionName::Instance(instance) => Some(instance),
            ConnectionName::Explicit | ConnectionName::Standard { .. } => None,
        }
    }

    pub(super) fn manner(&self) -> Manner {
        if self.is_explicit {
            return Manner::Explicit;
        }
        match self.instance().map(ConnectionInstance::of) {
            Some(ConnectionInstance::Predefined(Predefined::Explicit)) => Manner::Explicit,
            Some(ConnectionInstance::Predefined(Predefined::Implicit(production, _))) => match production {
                Production::Polled => Manner::Polled,
                Production::ChangeOfState | Production::Cyclic => Manner::Acknowledged,
                Production::Broadcast | Production::MulticastProducer => Manner::Multicast,
                Production::MulticastConsumer => Manner::Consumer,
            },
            Some(ConnectionInstance::Dynamic(_) | ConnectionInstance::Reserved(_)) | None => Manner::Unknown,
        }
    }

    /// The identifier that the server produces on, by the profile.
    pub(super) fn produced(&self) -> Option<Identifier> {
        let message = self.server_message?;
        if let ConnectionName::Standard { group, message } = self.name {
            return Identifier::standard(group, message, self.server);
        }
        match self.group? {
            GroupSelect::IMPLICIT_29 => Some(Identifier::implicit(message, self.server, self.instance()?)),
            group => Identifier::standard(group.standard()?, message, self.server),
        }
    }

    /// The direction of an implicit message on this connection, if it is one.
    pub(super) fn flow(&self, layout: Layout) -> Option<Flow> {
        if self.is_explicit {
            return None;
        }
        match layout {
            Layout::Implicit { source, instance, .. } => {
                let is_wide = self.group.is_none_or(|group| group == GroupSelect::IMPLICIT_29);
                if source == self.server && self.instance() == Some(instance) && is_wide {
                    return Some(Flow::Produced);
                }
                let is_its =
                    self.instance().map(|own| requester_instance(self.server, own)) == Some(instance);
                (is_its && is_wide && self.client.is_none_or(|client| client == source))
                    .then_some(Flow::Consumed)
            }
            Layout::Standard { group, message, source } => {
                let is_group = self.group.and_then(GroupSelect::standard) == Some(group);
                let is_its =
                    |end, end_message| end == Some(source) && end_message == Some(message) && is_group;
                if self.name == (ConnectionName::Standard { group, message }) && source == self.server
                    || is_its(Some(self.server), self.server_message)
                {
                    return Some(Flow::Produced);
                }
                (is_its(self.client, self.client_message) && self.hears_client()).then_some(Flow::Consumed)
            }
            _ => None,
        }
    }

    /// Whether its server consumes what its client produces.
    fn hears_client(&self) -> bool {
        match self.manner() {
            Manner::Polled | Manner::Acknowledged | Manner::Unknown => true,
            // A consumer is told the identifier, or has it from the beginning.
            Manner::Explicit | Manner::Multicast | Manner::Consumer => false,
        }
    }

    /// Lets the watchdog of the server expire, if it has one that depends on what is heard.
    pub(super) fn settle(&mut self, now: link_core::Instant) {
        let has_watchdog = match self.manner() {
            Manner::Explicit | Manner::Polled | Manner::Consumer => true,
            Manner::Unknown => self.consumed.is_some(),
            // An acknowledge may not be wanted.
            Manner::Acknowledged => self.connection.answers,
            Manner::Multicast => false,
        };
        if has_watchdog {
            self.connection.settle(now, self.is_explicit, false);
        }
    }

    /// What a predefined consumer consumes as long as nobody says more: what its client would produce on its own multicast
    /// connection.
    pub(super) fn consumes_client(&mut self) {
        if let (Manner::Consumer, Some(client), Some(group), Some(message)) =
            (self.manner(), self.client, self.group, self.client_message)
            && let Ok(at) = GroupMessage::new(group, message)
        {
            let instance = if group.standard().is_some() { 6 } else { 7 };
            self.consumed = Some(at.produced(client, InstanceId(instance)));
        }
    }

    pub(super) fn told(&self) -> OnConnection {
        let Self { server, client, name, .. } = *self;
        OnConnection { server, client, name, state: self.connection.state }
    }

    /// `None` if neither a state nor a frame of it was seen.
    pub(super) fn record(&self) -> Option<ConnectionRecord> {
        let Self { connection, .. } = self;
        let is_known = connection.states_seen != 0 || connection.frames != 0;
        is_known.then_some(ConnectionRecord {
            server: self.server,
            client: self.client,
            name: self.name,
            state: connection.state,
            assumed: connection.assumed,
            states_seen: connection.states_seen,
            group: self.group,
            epr: connection.epr,
            watchdog_action: connection.watchdog_action,
            consumed_size: connection.consumed.size,
            produced_size: connection.produced.size,
            produced: self.produced(),
            consumed: self.consumed,
            last_latency: self.last_latency,
            frames: connection.frames,
            bytes: connection.bytes,
        })
    }
}

impl ConnectionRecord {
    /// The states it has been in.
    pub fn states(&self) -> impl Iterator<Item = ConnectionState> + use<> {
        let seen = self.states_seen;
        ConnectionState::ALL.into_iter().filter(move |state| seen & state.bit() != 0)
    }
}

/// `multicast, producing, 29 bits`; `dynamic 128`; `explicit`; `group 1 message 3`.
impl fmt::Display for ConnectionName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Instance(instance) => fmt::Display::fmt(&ConnectionInstance::of(*instance), f),
            Self::Explicit => f.write_str("explicit"),
            Self::Standard { group, message } => write!(f, "group {} message {message}", group.number()),
        }
    }
}

/// The Group Select that the instance of a predefined connection allows.
pub(super) fn is_allowed(instance: InstanceId, group: GroupSelect) -> bool {
    match ConnectionInstance::of(instance) {
        ConnectionInstance::Predefined(Predefined::Explicit) => group == GroupSelect::EXPLICIT_29,
        ConnectionInstance::Predefined(Predefined::Implicit(_, IdentifierLength::Extended)) => {
            group == GroupSelect::IMPLICIT_29
        }
        ConnectionInstance::Predefined(Predefined::Implicit(_, IdentifierLength::Standard)) => {
            group.standard().is_some()
        }
        ConnectionInstance::Dynamic(_) | ConnectionInstance::Reserved(_) => true,
    }
}

/// The predefined connection for explicit messages.
const EXPLICIT: InstanceId = InstanceId(1);
