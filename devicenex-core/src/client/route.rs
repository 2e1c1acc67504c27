//! Between which nodes, and over which port, a client and a server talk.

use cip_core::client::{Channel, Heard, Part};
use cip_core::code::{InstanceId, ServiceCode};
use cip_core::codec::{ParseError, Reader, Wire};
use cip_core::connection::WatchdogAction;
use cip_core::fragment::{Fragment, FragmentByte, FragmentKind, explicit_piece};
use cip_core::message::{BodyFormat, Response};
use link_core::Frame;

use crate::id::{self, Direction, Framing, Identifier, Layout, MessageId, OperationalAddress};
use crate::message::{
    self, ConnectionRequest, ConnectionResponse, ExplicitMessage, FirstFragment, FragmentAcknowledge,
    Granted, GroupSelect, NextFragment, Target,
};

/// The two addresses of a conversation, and the port of the server.
///
/// | Route | Identifiers | Body format |
/// |---|---|---|
/// | [`connectionless`](Self::connectionless) | class 11100 | 8/8 |
/// | [`connection`](Self::connection) | class 11101 | none |
/// | [`opened`](Self::opened), [`explicit`](Self::explicit) | class 10mmm: requests with the client's Message ID, responses with the server's | as the server told |
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Route {
    client: OperationalAddress,
    server: OperationalAddress,
    port: Port,
    format: BodyFormat,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
enum Port {
    Connection,
    Connectionless,
    Explicit { to_server: MessageId, to_client: MessageId },
}

/// The request for the explicit connection of the predefined set, which the client will send on with that Message ID. A
/// connection of which nothing is heard for four expected packet rates (in ms) is deleted.
#[must_use]
pub const fn explicit_request(message: MessageId, expected_packet_rate: u16) -> ConnectionRequest {
    ConnectionRequest {
        predefined: true,
        group: GroupSelect::EXPLICIT_29,
        source_message: message,
        target: Some(Target {
            instance: InstanceId(1),
            expected_packet_rate,
            watchdog_action: WatchdogAction::AUTO_DELETE,
        }),
    }
}

/// What a connection request was answered with; `None` for an error, and for an answer that does not go with the request.
#[must_use]
pub fn connection_response(asked: &ConnectionRequest, response: &Response<'_>) -> Option<ConnectionResponse> {
    let Response::Success { data, .. } = response else { return None };
    let mut reader = Reader::new(data);
    let response = ConnectionResponse::read_after_service(&mut reader).ok().filter(|_| reader.is_empty())?;
    let predefined = matches!(response.granted, Granted::Predefined { .. });
    (predefined == asked.predefined).then_some(response)
}

impl Route {
    /// Requests without a connection: Get_Attribute_Single only.
    #[must_use]
    pub const fn connectionless(client: OperationalAddress, server: OperationalAddress) -> Self {
        Self { client, server, port: Port::Connectionless, format: BodyFormat::Class8Instance8 }
    }

    /// Connection requests.
    #[must_use]
    pub const fn connection(client: OperationalAddress, server: OperationalAddress) -> Self {
        Self { client, server, port: Port::Connection, format: BodyFormat::Class8Instance8 }
    }

    /// An explicit connection; `None` for a Message ID above 7.
    #[must_use]
    pub fn explicit(
        client: OperationalAddress,
        server: OperationalAddress,
        to_server: MessageId,
        to_client: MessageId,
        format: BodyFormat,
    ) -> Option<Self> {
        if to_server.number() > LAST_MESSAGE || to_client.number() > LAST_MESSAGE {
            return None;
        }
        Some(Self { client, server, port: Port::Explicit { to_server, to_client }, format })
    }

    /// The explicit connection that a server granted; `None` if the request or the answer is not about explicit messages
    /// with 29 bits, or names a Message ID above 7 or a reserved body format.
    #[must_use]
    pub fn opened(
        client: OperationalAddress,
        server: OperationalAddress,
        asked: &ConnectionRequest,
        granted: &ConnectionResponse,
    ) -> Option<Self> {
        if asked.group != GroupSelect::EXPLICIT_29 || granted.group != GroupSelect::EXPLICIT_29 {
            return None;
        }
        let format = granted.body_format.body_format()?;
        Self::explicit(client, server, asked.source_message, granted.source_message, format)
    }

    /// Whose requests.
    #[must_use]
    pub const fn client(&self) -> OperationalAddress {
        self.client
    }

    /// Whose responses.
    #[must_use]
    pub const fn server(&self) -> OperationalAddress {
        self.server
    }

    fn identifier(&self, framing: Framing) -> Option<Identifier> {
        let route =
            id::Route { destination: self.server, direction: Direction::Request, source: self.client };
        match (self.port, framing) {
            (Port::Connection, Framing::Complete { transaction }) => {
                Some(Identifier::connection(route, transaction))
            }
            (Port::Connection, Framing::Fragment(_)) => None,
            (Port::Connectionless, framing) => Some(Identifier::connectionless(route, framing)),
            (Port::Explicit { to_server, .. }, framing) => Identifier::explicit(to_server, route, framing),
        }
    }

    /// How an answer to the client is framed; `None` for everything else.
    fn answer(&self, frame: &Frame) -> Option<Framing> {
        let (route, framing) = match (self.port, Identifier::of_frame(frame).layout()) {
            (Port::Connection, Layout::Connection { route, transaction }) => {
                (route, Framing::Complete { transaction })
            }
            (Port::Connectionless, Layout::Connectionless { route, framing }) => (route, framing),
            (Port::Explicit { to_client, .. }, Layout::Explicit { message, route, framing })
                if message == to_client =>
            {
                (route, framing)
            }
            _ => return None,
        };
        let expected =
            id::Route { destination: self.client, direction: Direction::Response, source: self.server };
        (route == expected && !frame.is_remote()).then_some(framing)
    }
}

/// The transaction ID is a byte: in the identifier of a complete message, in the data of a first fragment, and nowhere
/// else.
impl Channel for Route {
    type Transaction = u8;

    const BEFORE_FIRST: u8 = u8::MAX;

    fn after(transaction: u8) -> u8 {
        transaction.wrapping_add(1)
    }

    fn xid(_: Option<u8>) -> bool {
        false
    }

    fn is_fragmented(body: &[u8]) -> bool {
        body.len() > Frame::MAX_DATA
    }

    fn cut(body: &[u8], index: usize) -> Option<Fragment<'_>> {
        explicit_piece::<{ Frame::MAX_DATA }, 1>(body, index)
    }

    fn format(&self) -> BodyFormat {
        self.format
    }

    fn frame(&self, transaction: u8, part: Part<'_>) -> Option<Frame> {
        match part {
            Part::Complete(body) => {
                message::frame(self.identifier(Framing::Complete { transaction })?, &ExplicitMessage { body })
            }
            Part::Fragment(Fragment { byte, data }) => {
                let id = self.identifier(Framing::Fragment(byte))?;
                if byte.kind == FragmentKind::First {
                    let body = data.try_into().ok()?;
                    return message::frame(id, &FirstFragment { transaction, body });
                }
                message::frame(id, &NextFragment { body: data })
            }
            Part::Acknowledge { count, status } => {
                let byte = FragmentByte::new(FragmentKind::Acknowledge, count);
                message::frame(self.identifier(Framing::Fragment(byte))?, &FragmentAcknowledge { status })
            }
        }
    }

    fn hear<'a>(&self, frame: &'a Frame) -> Option<Result<Heard<'a, u8>, ParseError>> {
        let data = frame.data();
        let byte = match self.answer(frame)? {
            Framing::Complete { transaction } => {
                let message = ExplicitMessage::parse(data);
                return Some(message.map(|message| Heard::Complete { transaction, body: message.body }));
            }
            Framing::Fragment(byte) => byte,
        };
        Some(match byte.kind {
            FragmentKind::First => FirstFragment::parse(data).map(|first| Heard::Fragment {
                transaction: Some(first.transaction),
                fragment: Fragment { byte, data: data.get(1..).unwrap_or_default() },
            }),
            FragmentKind::Middle | FragmentKind::Last => NextFragment::parse(data).map(|next| {
                Heard::Fragment { transaction: None, fragment: Fragment { byte, data: next.body } }
            }),
            FragmentKind::Acknowledge => FragmentAcknowledge::parse(data).map(|acknowledge| {
                Heard::Acknowledge { transaction: None, count: byte.count(), status: acknowledge.status }
            }),
        })
    }

    /// A connection response has no bit 7 in its service **\[R\]**.
    fn response<'a>(&self, body: &'a [u8]) -> Result<Response<'a>, ParseError> {
        match (self.port, body) {
            (Port::Connection, [service, data @ ..]) if *service == ServiceCode::ALLOCATE.request_byte() => {
                Ok(Response::Success { service: ServiceCode::ALLOCATE, data })
            }
            _ => Response::parse(body),
        }
    }
}

/// Of an explicit connection.
const LAST_MESSAGE: u8 = 7;
