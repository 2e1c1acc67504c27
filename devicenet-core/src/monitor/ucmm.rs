//! UCMM, Group 3 Message IDs 5 and 6: opening and closing of explicit connections.

use cip_core::code::{AdditionalCode, ServiceCode};
use cip_core::codec::Wire;
use cip_core::monitor::{Asked, Connection, Flaw, Seen, Span};

use super::explicit::Channel;
use super::kind::Kind;
use super::learn;
use super::nodes::Roles;
use super::pairing::Transaction;
use super::problem::Problem;
use super::reading::{Detail, Reading};
use super::responses;
use super::state::{Dynamic, State};
use crate::id::{Identifier, MacId};
use crate::message::{CloseRequest, ExplicitHeader, FormatByte, GroupSelect, OpenRequest, OpenResponse};

/// Reads a request on `0x780 + client`.
pub(super) fn request<const N: usize>(
    state: &mut State<N>,
    reading: &mut Reading<'_>,
    header: ExplicitHeader,
    client: MacId,
) {
    let server = header.mac;
    reading.kind = Kind::UnconnectedRequest;
    address(reading, client, server);
    if header.fragmented {
        reading.flag(Flaw::FragmentNotAllowed);
        return;
    }
    state.add_role(client, Roles::UCMM_CLIENT);
    let frame = reading.frame;
    let data = frame.data();
    let Some(&byte) = data.get(1) else {
        reading.flag(Flaw::TooShort { at_least: 2, found: 1 });
        return;
    };
    let (service, is_response) = ServiceCode::split(byte);
    reading.fields.explicit.service = Some(service);
    let mut argument = 0;
    if is_response {
        reading.flag(Flaw::ResponseBitOnRequest);
    } else {
        match service {
            OPEN => match OpenRequest::parse(data) {
                Ok(open) => {
                    let (format, group, source) =
                        (open.body_format.0, open.group.number(), open.source_message.number());
                    argument = u32::from_le_bytes([format, group << 4 | source, 0, 0]);
                    reading.fields.detail = Detail::Open { format: format & 0x0F, group, source };
                    check_open(reading, open.body_format, open.group, source);
                }
                Err(error) => reading.flag(Flaw::of_parse(error, data.len())),
            },
            CLOSE => match CloseRequest::parse(data) {
                Ok(close) => {
                    argument = close.connection.0.into();
                    reading.fields.explicit.instance = Some(close.connection);
                    reading.fields.detail = Detail::Close;
                }
                Err(error) => reading.flag(Flaw::of_parse(error, data.len())),
            },
            _ => reading.flag(Flaw::UnexpectedService { service }),
        }
    }
    let transaction = Transaction {
        seen: Seen { n: reading.n, at: reading.at },
        requester: client,
        xid: header.xid,
        asked: Asked { instance: reading.fields.explicit.instance, argument, ..Asked::service(service) },
        assumed: false,
    };
    if !state.node(server).ucmm.insert(transaction) {
        state.lost.requests = state.lost.requests.saturating_add(1);
    }
}

/// Reads a response on `0x740 + server`.
pub(super) fn response<const N: usize>(
    state: &mut State<N>,
    reading: &mut Reading<'_>,
    header: ExplicitHeader,
    server: MacId,
) {
    let client = header.mac;
    reading.kind = Kind::UnconnectedResponse;
    address(reading, server, client);
    if header.fragmented {
        reading.flag(Flaw::FragmentNotAllowed);
        return;
    }
    state.add_role(server, Roles::UCMM_SERVER);
    let frame = reading.frame;
    let data = frame.data();
    let body = data.get(1..).unwrap_or_default();
    let (parsed, is_response) = responses::read(reading.kind, body, 1);
    parsed.apply(reading);
    if !is_response {
        return;
    }
    let service = reading.fields.explicit.service.unwrap_or(ServiceCode::ERROR_RESPONSE);
    let waiting = &mut state.node(server).ucmm;
    let paired = waiting.find(client, header.xid, service).copied();
    match (paired, waiting.of(client)) {
        (Some(request), _) => {
            waiting.remove(request.seen.n);
            reading.request = Some(request.seen.answered(reading.at));
            reading.fields.explicit.requested = Some(request.asked.service);
            reading.fields.explicit.instance = request.asked.instance;
        }
        (None, Some(request)) if request.xid != header.xid => reading.flag(Flaw::TransactionMismatch),
        (None, Some(request)) => reading.flag(Flaw::ServiceMismatch { expected: request.asked.service }),
        (None, None) => reading.assumed = true,
    }
    if let Some(status) = reading.fields.explicit.status {
        let additional = reading.fields.explicit.additional.unwrap_or(AdditionalCode::NONE);
        reading.flag(Problem::OpenRefused { status, additional });
        return;
    }
    reading.fields.explicit.value = None;
    match service {
        OPEN => match OpenResponse::parse(data) {
            Ok(open) => opened(state, reading, &open, paired, server, client),
            Err(error) => reading.flag(Flaw::of_parse(error, data.len())),
        },
        CLOSE => {
            reading.fields.detail = Detail::Close;
            if data.len() != CLOSED_LEN {
                let found = u16::try_from(data.len()).unwrap_or_default();
                reading.flag(Flaw::Length { expected: 2, found });
            }
            if let Some(instance) = paired.and_then(|request| request.asked.instance) {
                state.close_dynamic(server, instance, reading.at);
            }
        }
        _ => {
            reading.fields.explicit.value = Span::tail(data.len(), data.len().saturating_sub(2));
            reading.flag(Flaw::UnexpectedService { service });
        }
    }
}

fn opened<const N: usize>(
    state: &mut State<N>,
    reading: &mut Reading<'_>,
    open: &OpenResponse,
    request: Option<Transaction>,
    server: MacId,
    client: MacId,
) {
    let (destination, source) = (open.destination_message.number(), open.source_message.number());
    let format = open.body_format.0 & 0x0F;
    reading.fields.explicit.instance = Some(open.connection);
    reading.fields.detail = Detail::Opened { format, destination, source };
    if open.body_format.reserved_bits() != 0 {
        reading.flag(Flaw::ReservedBits { field: "body format" });
    }
    let asked = request.map(asked);
    // Without the request: only Group 2 has a destination Message ID, and Group 3 is the usual choice.
    let group = match asked {
        Some((group, _)) => group,
        None if destination != 0 => GroupSelect::GROUP_2.number(),
        None => GroupSelect::GROUP_3.number(),
    };
    let Some(message_group) = group_of(group) else { return };
    if let Some(problem) = unusable(message_group, destination, source) {
        reading.flag(problem);
        return;
    }
    let requests = match message_group {
        2 => Identifier::group2(server, destination),
        _ => asked.and_then(|(_, source)| identifier(message_group, source, client)),
    };
    let responses = match message_group {
        2 => Identifier::group2(server, source),
        _ => identifier(message_group, source, server),
    };
    let body_format = open.body_format.format();
    if body_format.is_none() {
        reading.flag(Flaw::ReservedValue { field: "body format", found: format.into() });
    }
    let mut connection = learn::opened(reading.at);
    connection.assumed = request.is_none();
    let dynamic = Dynamic {
        client,
        server,
        group: message_group,
        instance: Some(open.connection),
        requests,
        responses,
        is_io: false,
        connection,
        channel: Channel::told(body_format.unwrap_or_default()),
    };
    state.insert_dynamic(dynamic);
}

/// A frame on an identifier of Group 1 or 3 that no known connection uses: if an Open asked for it, the response was
/// missed, and the connection is taken to exist.
pub(super) fn adopt<const N: usize>(
    state: &mut State<N>,
    at: link_core::Instant,
    identifier: Identifier,
    header: MacId,
) -> Option<usize> {
    let source = identifier.mac_id()?;
    if let Some(index) = state
        .dynamics
        .iter_mut()
        .position(|slot| slot.as_mut().is_some_and(|held| held.complete(identifier, source, header)))
    {
        return Some(index);
    }
    // From the client: it has asked for this very identifier.
    if let Some(request) =
        state.node(header).ucmm.of(source).filter(|request| request.asked.service == OPEN).copied()
        && self_chosen(request, source) == Some(identifier)
    {
        return state.insert_dynamic(missed(request, source, header, Some(identifier), None, at));
    }
    // From the server: it answers on an identifier of its own.
    let request =
        state.node(source).ucmm.of(header).filter(|request| request.asked.service == OPEN).copied()?;
    let requests = self_chosen(request, header)?;
    (requests.group() == identifier.group())
        .then(|| missed(request, header, source, Some(requests), Some(identifier), at))
        .and_then(|dynamic| state.insert_dynamic(dynamic))
}

/// A connection of which nothing was seen but this frame.
pub(super) fn unknown<const N: usize>(
    state: &mut State<N>,
    at: link_core::Instant,
    identifier: Identifier,
    header: MacId,
    from_client: bool,
) -> Option<usize> {
    let source = identifier.mac_id()?;
    let (client, server) = if from_client { (source, header) } else { (header, source) };
    let mut connection = Connection::NEW;
    connection.active = at;
    state.insert_dynamic(Dynamic {
        client,
        server,
        group: identifier.group().number()?,
        instance: None,
        requests: from_client.then_some(identifier),
        responses: (!from_client).then_some(identifier),
        is_io: false,
        connection,
        channel: Channel::NEW,
    })
}

impl Dynamic {
    /// Takes an identifier for the direction that is not known yet, if the frame fits.
    fn complete(&mut self, identifier: Identifier, source: MacId, header: MacId) -> bool {
        if self.is_io || identifier.group().number() != Some(self.group) {
            return false;
        }
        if self.requests.is_none()
            && self.responses.is_some()
            && (source, header) == (self.client, self.server)
        {
            self.requests = Some(identifier);
            return true;
        }
        if self.responses.is_none()
            && self.requests.is_some()
            && (source, header) == (self.server, self.client)
        {
            self.responses = Some(identifier);
            return true;
        }
        false
    }
}

fn missed(
    request: Transaction,
    client: MacId,
    server: MacId,
    requests: Option<Identifier>,
    responses: Option<Identifier>,
    at: link_core::Instant,
) -> Dynamic {
    let [format, ..] = request.asked.argument.to_le_bytes();
    let mut connection = learn::opened(at);
    connection.assumed = true;
    let group = group_of(asked(request).0).unwrap_or(3);
    let channel = Channel::likely(FormatByte(format).format().unwrap_or_default());
    Dynamic { client, server, group, instance: None, requests, responses, is_io: false, connection, channel }
}

fn address(reading: &mut Reading<'_>, source: MacId, destination: MacId) {
    reading.fields.is_ucmm = true;
    reading.src = Some(source);
    reading.dst = Some(destination);
    if source == destination {
        reading.flag(Problem::HeaderRepeatsIdentifier { mac: source });
    }
}

fn check_open(reading: &mut Reading<'_>, format: FormatByte, group: GroupSelect, source: u8) {
    if format.reserved_bits() != 0 {
        reading.flag(Flaw::ReservedBits { field: "body format" });
    }
    if group.name().is_none() {
        reading.flag(Flaw::ReservedValue { field: "group select", found: group.number().into() });
    }
    if group == GroupSelect::GROUP_3 && source > GROUP_3_LAST {
        reading.flag(Flaw::ReservedValue { field: "source Message ID", found: source.into() });
    }
}

/// What is wrong with the Message IDs of an Open response. In Group 2 IDs 6 and 7 are never assigned and the two differ;
/// in the other groups there is no destination Message ID, and Group 3 has 0-4 for it.
fn unusable(group: u8, destination: u8, source: u8) -> Option<Problem> {
    let reserved = |field, found: u8| Some(Problem::Flaw(Flaw::ReservedValue { field, found: found.into() }));
    match group {
        2 if source > GROUP_2_LAST || source == destination => reserved("source Message ID", source),
        2 if destination > GROUP_2_LAST => reserved("destination Message ID", destination),
        3 if source > GROUP_3_LAST => reserved("source Message ID", source),
        1 | 3 if destination != 0 => reserved("destination Message ID", destination),
        _ => None,
    }
}

/// Group Select and source Message ID of an Open request.
fn asked(request: Transaction) -> (u8, u8) {
    let [_, byte, ..] = request.asked.argument.to_le_bytes();
    (byte >> 4, byte & 0x0F)
}

/// The identifier that the client of an Open request has chosen for its requests; it does so in Groups 1 and 3.
fn self_chosen(request: Transaction, client: MacId) -> Option<Identifier> {
    let (group, source) = asked(request);
    match group_of(group)? {
        2 => None,
        group => identifier(group, source, client),
    }
}

fn identifier(group: u8, message: u8, source: MacId) -> Option<Identifier> {
    match group {
        1 => Identifier::group1(message, source),
        _ => Identifier::group3(message, source),
    }
}

/// The message group of a Group Select; the node ping and reserved values have none.
fn group_of(select: u8) -> Option<u8> {
    match GroupSelect::new(select)? {
        GroupSelect::GROUP_1 => Some(1),
        GroupSelect::GROUP_2 => Some(2),
        GroupSelect::GROUP_3 => Some(3),
        _ => None,
    }
}

pub(super) const OPEN: ServiceCode = ServiceCode(0x4B);
pub(super) const CLOSE: ServiceCode = ServiceCode(0x4C);
const CLOSED_LEN: usize = 2;
const GROUP_2_LAST: u8 = 5;
const GROUP_3_LAST: u8 = 4;
