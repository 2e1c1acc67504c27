//! Between which identifiers a client and a server talk.

use cip_core::client::{Channel, Heard, Part};
use cip_core::codec::{ParseError, Wire};
use cip_core::fragment::{Fragment, explicit_fragment, is_fragmented_explicit};
use cip_core::message::BodyFormat;
use link_core::Frame;

use crate::id::{Identifier, MacId};
use crate::message::{
    self, ExplicitFragment, ExplicitMessage, FragmentAcknowledge, GroupSelect, OpenRequest, OpenResponse,
};

/// The two identifiers of a conversation, and the MAC IDs that stand in the headers.
///
/// | Route | Request | Response | MAC ID in the request's header |
/// |---|---|---|---|
/// | [`predefined`](Self::predefined) | `0x404 + 8s` | `0x403 + 8s` | client |
/// | [`group2_unconnected`](Self::group2_unconnected) | `0x406 + 8s` | `0x403 + 8s` | client |
/// | [`ucmm`](Self::ucmm) | `0x780 + c` | `0x740 + s` | server |
/// | [`opened`](Self::opened), Groups 1 and 3 | the client's message | the server's message | server |
/// | [`opened`](Self::opened), Group 2 | the server's MAC ID, its destination message | the server's MAC ID, its source message | client |
///
/// A response's header always has the client's MAC ID. Source: CIP Vol. 3, explicit message header; capture of an IAI
/// controller (Group 3).
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Route {
    client: MacId,
    server: MacId,
    request: Identifier,
    response: Identifier,
    request_header: MacId,
    format: BodyFormat,
}

impl Route {
    /// The explicit connection of the predefined master/slave connection set. `format` is what the Allocate response
    /// told.
    #[must_use]
    pub const fn predefined(client: MacId, server: MacId, format: BodyFormat) -> Self {
        Self {
            client,
            server,
            request: Identifier::explicit_request(server),
            response: Identifier::explicit_response(server),
            request_header: client,
            format,
        }
    }

    /// The unconnected port of a Group 2 server: Allocate and Release only.
    #[must_use]
    pub const fn group2_unconnected(client: MacId, server: MacId) -> Self {
        Self {
            client,
            server,
            request: Identifier::group2_unconnected_request(server),
            response: Identifier::explicit_response(server),
            request_header: client,
            format: BodyFormat::Class8Instance8,
        }
    }

    /// The UCMM: Open and Close only.
    #[must_use]
    pub const fn ucmm(client: MacId, server: MacId) -> Self {
        Self {
            client,
            server,
            request: Identifier::unconnected_request(client),
            response: Identifier::unconnected_response(server),
            request_header: server,
            format: BodyFormat::Class8Instance8,
        }
    }

    /// The connection that a server opened. `None` if the answer names a reserved group, Message ID or body format, or
    /// opened nothing (a node ping).
    #[must_use]
    pub fn opened(client: MacId, asked: &OpenRequest, answer: &OpenResponse) -> Option<Self> {
        let server = asked.server;
        let own = asked.source_message.number();
        let theirs = answer.source_message.number();
        let (request, response, request_header) = match asked.group {
            GroupSelect::GROUP_1 if own <= GROUP_1_LAST && theirs <= GROUP_1_LAST => {
                (Identifier::group1(own, client)?, Identifier::group1(theirs, server)?, server)
            }
            GroupSelect::GROUP_2 => {
                let to_server = answer.destination_message.number();
                if to_server > GROUP_2_LAST || theirs > GROUP_2_LAST || to_server == theirs {
                    return None;
                }
                (Identifier::group2(server, to_server)?, Identifier::group2(server, theirs)?, client)
            }
            GroupSelect::GROUP_3 if own <= GROUP_3_LAST && theirs <= GROUP_3_LAST => {
                (Identifier::group3(own, client)?, Identifier::group3(theirs, server)?, server)
            }
            _ => return None,
        };
        Some(Self { client, server, request, response, request_header, format: answer.body_format.format()? })
    }

    /// Whose requests.
    #[must_use]
    pub const fn client(&self) -> MacId {
        self.client
    }

    /// Whose responses.
    #[must_use]
    pub const fn server(&self) -> MacId {
        self.server
    }

    /// What requests, and acknowledges of response fragments, are sent on.
    #[must_use]
    pub const fn request(&self) -> Identifier {
        self.request
    }

    /// What responses, and acknowledges of request fragments, come on.
    #[must_use]
    pub const fn response(&self) -> Identifier {
        self.response
    }

    /// How requests are addressed.
    #[must_use]
    pub const fn format(&self) -> BodyFormat {
        self.format
    }
}

/// The transaction ID is one bit, in the header of every frame.
impl Channel for Route {
    type Transaction = bool;

    /// The first transaction has XID 0.
    const BEFORE_FIRST: bool = true;

    fn after(xid: bool) -> bool {
        !xid
    }

    fn xid(xid: Option<bool>) -> bool {
        xid.unwrap_or_default()
    }

    fn is_fragmented(body: &[u8]) -> bool {
        is_fragmented_explicit(body)
    }

    fn cut(body: &[u8], index: usize) -> Option<Fragment<'_>> {
        explicit_fragment(body, index)
    }

    fn format(&self) -> BodyFormat {
        self.format
    }

    fn frame(&self, xid: bool, part: Part<'_>) -> Option<Frame> {
        let mac = self.request_header;
        match part {
            Part::Complete(body) => message::frame(self.request, &ExplicitMessage { xid, mac, body }),
            Part::Fragment(Fragment { byte, data }) => {
                message::frame(self.request, &ExplicitFragment { xid, mac, fragment: byte, body: data })
            }
            Part::Acknowledge { count, status } => {
                message::frame(self.request, &FragmentAcknowledge::new(xid, mac, count, status))
            }
        }
    }

    fn hear<'a>(&self, frame: &'a Frame) -> Option<Result<Heard<'a, bool>, ParseError>> {
        let data = frame.data();
        let header = *data.first()?;
        if Identifier::of_frame(frame) != Some(self.response) || header & HEADER_MAC != self.client.number() {
            return None;
        }
        if header & HEADER_FRAGMENTED == 0 {
            let message = ExplicitMessage::parse(data);
            return Some(
                message.map(|message| Heard::Complete { transaction: message.xid, body: message.body }),
            );
        }
        if let Ok(acknowledge) = FragmentAcknowledge::parse(data) {
            return Some(Ok(Heard::Acknowledge {
                transaction: Some(acknowledge.xid),
                count: acknowledge.count(),
                status: acknowledge.status,
            }));
        }
        Some(ExplicitFragment::parse(data).map(|fragment| Heard::Fragment {
            transaction: Some(fragment.xid),
            fragment: Fragment { byte: fragment.fragment, data: fragment.body },
        }))
    }
}

/// The last Message ID of each group that may be opened.
const GROUP_1_LAST: u8 = 0xB;
const GROUP_2_LAST: u8 = 5;
const GROUP_3_LAST: u8 = 4;
const HEADER_MAC: u8 = 0x3F;
const HEADER_FRAGMENTED: u8 = 0x80;
