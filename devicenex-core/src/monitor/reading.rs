//! What the monitor makes of a frame.

use core::time::Duration;

use cip_core::code::InstanceId;
use cip_core::monitor::{Answered, ConnectionState, Explicit, Frag, Remark, Remarks};
use link_core::{Frame, Instant};

use super::connections::ConnectionName;
use super::kind::Kind;
use super::problem::Problem;
use crate::id::{Direction, Identifier, Layout, OperationalAddress};
use crate::message::{ConnectionRequest, ConnectionResponse, DeviceIdentity};

/// A frame, read.
///
/// `Display` is the one line that a trace shows; [`words`](Self::words) is the same without the problem. With feature
/// `serde` it serialises to one flat object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading<'a> {
    /// When the frame was on the bus.
    pub at: Instant,
    /// Its number in the recording.
    pub n: u64,
    /// The frame.
    pub frame: Frame,
    /// What its identifier says.
    pub layout: Layout,
    /// Who has sent it, where the identifier or what was learned tells; OA 127 of a device without an address.
    pub src: Option<OperationalAddress>,
    /// Who shall receive it; `None` also for a broadcast.
    pub dst: Option<OperationalAddress>,
    /// The connection that it is on.
    pub connection: Option<OnConnection>,
    /// What it is.
    pub kind: Kind,
    /// What it says.
    pub fields: Fields<'a>,
    /// The fragmentation byte, in a fragment or its acknowledge.
    pub frag: Option<Frag>,
    /// The whole message, in the frame that completes a fragmented one.
    pub message: Option<Message<'a>>,
    /// The frame that it answers: the request of a response, the fragment of an acknowledge, the Mini-who or ROAM that a
    /// Hello follows.
    pub request: Option<Answered>,
    /// Why it is wrong or suspicious.
    pub problem: Option<Problem>,
    /// What else a reader should know, without anything being wrong.
    pub note: Option<Note>,
    /// It could not be known for certain without frames that the recording does not contain.
    pub assumed: bool,
}

/// The connection that a frame is on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OnConnection {
    /// Who has the instance, whichever way the frame goes.
    pub server: OperationalAddress,
    /// Who has asked for it, if that was seen.
    pub client: Option<OperationalAddress>,
    /// Which connection of the server.
    pub name: ConnectionName,
    /// Its state at the frame.
    pub state: ConnectionState,
}

/// What a complete message says. The data of an implicit message stand where an explicit message has its value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Fields<'a> {
    /// What it says as an explicit message.
    pub explicit: Explicit<'a>,
    /// The transaction ID of a message between two nodes.
    pub transaction: Option<u8>,
    /// The device of a Hello or ROAM.
    pub device: Option<DeviceIdentity>,
    /// The physical port of a Hello.
    pub port: Option<u8>,
    /// What only some messages have.
    pub detail: Detail,
}

/// What only some messages have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Detail {
    /// Nothing.
    #[default]
    None,
    /// Which Hello of a node it is.
    Hello(Stage),
    /// Mini-who.
    MiniWho {
        /// The low half of the sender's serial number.
        serial_low: u16,
    },
    /// ROAM.
    Roam {
        /// The address that the device shall have.
        requested: OperationalAddress,
    },
    /// A connection is asked for.
    Connect(ConnectionRequest),
    /// A connection is granted.
    Granted {
        /// What the response says.
        response: ConnectionResponse,
        /// Which connection, if the response or the request tells.
        instance: Option<InstanceId>,
    },
}

/// Which Hello it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Stage {
    /// The first of two.
    First,
    /// The second of two.
    Second,
    /// That of a device in Standby, after a Mini-who.
    Asked,
    /// That of a node which has the address, to another that wants it.
    Response,
    /// That of a node which has the address, without anybody having asked.
    Announcement,
}

/// A message put together from its fragments.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Message<'a> {
    /// The kind that the message would have in one frame.
    pub kind: Kind,
    /// What it says.
    pub fields: Fields<'a>,
    /// The whole of it: an explicit message from the service byte on, or the data of an implicit one.
    pub data: &'a [u8],
}

/// Something to know about a frame that is not wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Note {
    /// It is on a connection that is not established by what was seen before.
    NoConnection(ConnectionState),
    /// A message that this frame is part of does not fit into the monitor.
    NotStored,
    /// A node that was on line says Hello again: it has restarted.
    Restarted,
    /// The network manager has given the address to another device than the one that had it.
    Replaced,
    /// The device was heard under another address before.
    Moved {
        /// That address.
        from: OperationalAddress,
    },
    /// A frame that was sent before.
    Repeated,
}

impl<'a> Reading<'a> {
    pub(super) fn new(at: Instant, n: u64, frame: &Frame) -> Self {
        Self {
            at,
            n,
            frame: *frame,
            layout: Identifier::of_frame(frame).layout(),
            src: None,
            dst: None,
            connection: None,
            kind: Kind::Foreign,
            fields: Fields::default(),
            frag: None,
            message: None,
            request: None,
            problem: None,
            note: None,
            assumed: false,
        }
    }

    /// The message group, 1-3, of an 11-bit identifier.
    #[must_use]
    pub const fn group(&self) -> Option<u8> {
        match self.layout {
            Layout::Standard { group, .. } => Some(group.number()),
            _ => None,
        }
    }

    /// The Message ID of an explicit or implicit message.
    #[must_use]
    pub const fn msg(&self) -> Option<u8> {
        match self.layout {
            Layout::Explicit { message, .. }
            | Layout::Implicit { message, .. }
            | Layout::Standard { message, .. } => Some(message.number()),
            _ => None,
        }
    }

    /// The attribute value, service data or implicit data of the frame; `None` if it carries none. Of a fragmented message
    /// ask [`Message::value`].
    #[must_use]
    pub fn value(&self) -> Option<&[u8]> {
        self.fields.explicit.value.map(|span| span.of(self.frame.data()))
    }

    /// How long the request has waited that this response answers. An acknowledge of a fragment is no response, nor is a
    /// Hello.
    #[must_use]
    pub fn response_time(&self) -> Option<Duration> {
        let is_response = !matches!(self.kind, Kind::FragmentAck | Kind::HelloRequest);
        self.request.filter(|_| is_response).map(|request| request.latency)
    }

    /// The node that answers without a connection, of a frame of class 11100.
    #[must_use]
    pub fn connectionless_server(&self) -> Option<OperationalAddress> {
        match self.layout {
            Layout::Connectionless { route, .. } => match route.direction {
                Direction::Request => Some(route.destination),
                Direction::Response => Some(route.source),
            },
            _ => None,
        }
    }

    /// Keeps the first problem found.
    pub(super) fn flag(&mut self, problem: impl Into<Problem>) {
        self.problem.get_or_insert(problem.into());
    }

    pub(super) fn flag_if(&mut self, problem: Option<impl Into<Problem>>) {
        if let Some(problem) = problem {
            self.flag(problem);
        }
    }
}

impl Remarks for Reading<'_> {
    fn remark(&mut self, remark: Remark) {
        match remark {
            Remark::Flaw(flaw) => self.flag(flaw),
            Remark::NoConnection(state) => self.note = Some(Note::NoConnection(state)),
            Remark::NotStored => self.note = Some(Note::NotStored),
            Remark::Repeated => self.note = Some(Note::Repeated),
            Remark::Assumed => self.assumed = true,
            Remark::Answers(request) => self.request = Some(request),
        }
    }
}

impl<'a> Message<'a> {
    /// The attribute value, service data or implicit data; `None` if it carries none.
    #[must_use]
    pub fn value(&self) -> Option<&'a [u8]> {
        self.fields.explicit.value.map(|span| span.of(self.data))
    }
}

impl Fields<'_> {
    /// Of a message that is all data.
    pub(super) fn of_data(data: &[u8]) -> Self {
        Self { explicit: Explicit::of_data(data), ..Self::default() }
    }
}

impl Stage {
    /// The machine-readable name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::First => "first",
            Self::Second => "second",
            Self::Asked => "asked",
            Self::Response => "response",
            Self::Announcement => "announcement",
        }
    }
}
