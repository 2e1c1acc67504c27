//! Explicit messages, from the service byte on: what requests ask, and what responses answer.

use super::Flaw;
use super::attribute::{CONSUMED_PATH, EXPECTED_PACKET_RATE, PRODUCED_PATH, instance_of};
use super::packet::Parts;
use super::span::Span;
use crate::code::{AdditionalCode, AttributeId, ClassId, GeneralStatus, InstanceId, ServiceCode};
use crate::codec::{ParseError, ParseErrorKind, Wire};
use crate::message::{BodyFormat, Request, Response};

/// What a complete explicit message says. A field that the message does not have, and that the request it answers does not
/// give either, is `None`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Explicit<'a> {
    /// The service code without the response bit: [`ServiceCode::ERROR_RESPONSE`] in an error response.
    pub service: Option<ServiceCode>,
    /// In a response, the service of the request that it answers.
    pub requested: Option<ServiceCode>,
    /// The class; in a response that of the request.
    pub class: Option<ClassId>,
    /// The instance; in a response that of the request.
    pub instance: Option<InstanceId>,
    /// The attribute; in a response that of the request.
    pub attribute: Option<AttributeId>,
    /// General status of an error response.
    pub status: Option<GeneralStatus>,
    /// Additional code of an error response.
    pub additional: Option<AdditionalCode>,
    /// Where the attribute value or the service data stand.
    pub value: Option<Span>,
    /// The body format of a request.
    pub format: BodyFormat,
    /// Of a response to Multiple_Service_Packet: the requests that it answers.
    pub parts: Option<&'a Parts>,
    /// The response to Set_Attribute_Single of the expected packet rate.
    pub rate: Option<PacketRate>,
}

/// An expected packet rate, in milliseconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct PacketRate {
    /// The value asked for.
    pub requested: u16,
    /// The value used.
    pub used: u16,
}

/// What a request was about: all that its response does not repeat.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Asked {
    /// The service.
    pub service: ServiceCode,
    /// The class.
    pub class: Option<ClassId>,
    /// The instance.
    pub instance: Option<InstanceId>,
    /// The attribute, of a service for one attribute.
    pub attribute: Option<AttributeId>,
    /// The first four bytes of the value or of the service data, those that are missing 0; of a connection path the instance
    /// that it names (0: none).
    pub argument: u32,
}

impl Asked {
    /// A request of which only the service can be read.
    #[must_use]
    pub const fn service(service: ServiceCode) -> Self {
        Self { service, class: None, instance: None, attribute: None, argument: 0 }
    }

    /// The first two bytes of the argument.
    #[must_use]
    pub const fn word(&self) -> u16 {
        let [low, high, ..] = self.argument.to_le_bytes();
        u16::from_le_bytes([low, high])
    }
}

/// A request, read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReadRequest<'b> {
    /// What it says.
    pub explicit: Explicit<'static>,
    /// What to remember for its response; `None` for a message without a service.
    pub asked: Option<Asked>,
    /// The service data, for services that only the network knows.
    pub data: &'b [u8],
    /// What is wrong with it.
    pub flaw: Option<Flaw>,
}

/// A response, read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReadResponse {
    /// What it says; without what only its request has told, see [`Explicit::answers`].
    pub explicit: Explicit<'static>,
    /// False for a message that is none.
    pub is_response: bool,
    /// What is wrong with it.
    pub flaw: Option<Flaw>,
}

impl Explicit<'static> {
    /// A message that is all data, as those of I/O are.
    #[must_use]
    pub fn of_data(data: &[u8]) -> Self {
        Self { value: Span::tail(data.len(), data.len()), ..Self::default() }
    }

    /// Reads a request in a body format. `before` is the number of bytes before the service byte in what spans refer to.
    /// Some servers answer even to a message with the response bit set.
    #[must_use]
    pub fn request(format: BodyFormat, body: &[u8], before: usize) -> ReadRequest<'_> {
        let mut explicit = Self { format, ..Self::default() };
        let Some((&byte, rest)) = body.split_first() else {
            let flaw = Some(Flaw::TooShort { at_least: 2, found: 1 });
            return ReadRequest { explicit, asked: None, data: &[], flaw };
        };
        let (service, is_response) = ServiceCode::split(byte);
        explicit.service = Some(service);
        let total = body.len().saturating_add(before);
        let mut asked = Asked::service(service);
        let unread = |mut explicit: Self, flaw| {
            explicit.value = Span::tail(total, rest.len());
            ReadRequest { explicit, asked: Some(asked), data: &[], flaw: Some(flaw) }
        };
        if is_response {
            return unread(explicit, Flaw::ResponseBitOnRequest);
        }
        let request = match Request::parse(format, body) {
            Ok(request) => request,
            Err(error) => return unread(explicit, Flaw::of_parse(error, body.len())),
        };
        (asked.class, asked.instance) = (request.target.class(), request.target.instance());
        (explicit.class, explicit.instance) = (asked.class, asked.instance);
        let mut value = request.data;
        let mut flaw = None;
        asked.argument = le32(value);
        if names_attribute(service) {
            match request.attribute_access() {
                Ok(access) => {
                    explicit.attribute = Some(access.attribute);
                    asked.attribute = Some(access.attribute);
                    asked.argument = argument(asked.class, access.attribute, access.value);
                    value = access.value;
                }
                Err(error) => flaw = Some(Flaw::of_parse(error, request.data.len())),
            }
        }
        explicit.value = Span::tail(total, value.len());
        ReadRequest { explicit, asked: Some(asked), data: request.data, flaw }
    }

    /// Reads a response: the service byte and what follows it.
    #[must_use]
    pub fn response(body: &[u8], before: usize) -> ReadResponse {
        let mut explicit = Self::default();
        let Some((&byte, rest)) = body.split_first() else {
            let flaw = Some(Flaw::TooShort { at_least: 2, found: 1 });
            return ReadResponse { explicit, is_response: false, flaw };
        };
        let (service, is_response) = ServiceCode::split(byte);
        explicit.service = Some(service);
        explicit.value = Span::tail(body.len().saturating_add(before), rest.len());
        if !is_response {
            return ReadResponse { explicit, is_response, flaw: Some(Flaw::RequestBitOnResponse) };
        }
        let mut flaw = None;
        match Response::parse(body) {
            Ok(Response::Success { .. }) => {}
            Ok(Response::Error { status, additional }) => {
                explicit.value = None;
                explicit.status = Some(status);
                explicit.additional = Some(additional);
            }
            Err(error) => flaw = Some(Flaw::of_parse(error, body.len())),
        }
        ReadResponse { explicit, is_response, flaw }
    }
}

impl<'a> Explicit<'a> {
    /// Gives a response to Multiple_Service_Packet the requests that it answers.
    pub fn answers_parts(&mut self, parts: Option<&'a Parts>) {
        if self.requested == Some(ServiceCode::MULTIPLE_SERVICE_PACKET) {
            self.parts = parts;
        }
    }

    /// Gives a response what only its request has said.
    pub fn answers(&mut self, asked: &Asked, body: &[u8]) {
        self.requested = Some(asked.service);
        self.class = asked.class;
        self.instance = asked.instance;
        self.attribute = asked.attribute;
        let is_rate = asked.class == Some(ClassId::CONNECTION)
            && asked.attribute == Some(AttributeId(EXPECTED_PACKET_RATE));
        if let Ok(Response::Success { service: ServiceCode::SET_ATTRIBUTE_SINGLE, data: &[low, high] }) =
            Response::parse(body)
            && is_rate
        {
            let used = u16::from_le_bytes([low, high]);
            self.rate = Some(PacketRate { requested: asked.word(), used });
        }
    }
}

impl Flaw {
    /// A parse error; its offsets count from the service byte or service data, which is where the reader looks for what is
    /// missing.
    #[must_use]
    pub fn of_parse(error: ParseError, len: usize) -> Self {
        let narrow = |value: usize| u16::try_from(value).unwrap_or(u16::MAX);
        match error.kind {
            ParseErrorKind::Short { expected, .. } => {
                Self::TooShort { at_least: narrow(error.offset.saturating_add(expected)), found: narrow(len) }
            }
            ParseErrorKind::Trailing { .. } => {
                Self::Length { expected: narrow(error.offset), found: narrow(len) }
            }
            ParseErrorKind::Value { found } => {
                let found = u16::try_from(found).unwrap_or(u16::MAX);
                Self::ReservedValue { field: error.field, found }
            }
        }
    }
}

/// The body format that a Get_Attribute_Single of this length is in, for a connection whose opening was not seen.
#[must_use]
pub fn likely_format(body: &[u8]) -> Option<BodyFormat> {
    match *body {
        [0x0E, _, _, _] => Some(BodyFormat::Class8Instance8),
        [0x0E, _, 0, _, _] => Some(BodyFormat::Class16Instance8),
        [0x0E, _, _, 0, _] => Some(BodyFormat::Class8Instance16),
        [0x0E, 3, 0x20, _, 0x24, _, 0x30, _] => Some(BodyFormat::CipPath),
        [0x0E, _, high, _, 0 | 1, _] if high <= 4 => Some(BodyFormat::Class16Instance16),
        _ => None,
    }
}

/// The services whose data begin with an attribute.
fn names_attribute(service: ServiceCode) -> bool {
    matches!(
        service,
        ServiceCode::GET_ATTRIBUTE_SINGLE
            | ServiceCode::SET_ATTRIBUTE_SINGLE
            | ServiceCode::GET_MEMBER
            | ServiceCode::SET_MEMBER
            | ServiceCode::INSERT_MEMBER
            | ServiceCode::REMOVE_MEMBER
    )
}

/// What the response to a Set does not repeat.
pub(super) fn argument(class: Option<ClassId>, attribute: AttributeId, value: &[u8]) -> u32 {
    if class == Some(ClassId::CONNECTION) && matches!(attribute.0, PRODUCED_PATH | CONSUMED_PATH) {
        return instance_of(value).unwrap_or(InstanceId::CLASS).0.into();
    }
    le32(value)
}

fn le32(value: &[u8]) -> u32 {
    let mut bytes = [0; 4];
    for (byte, &found) in bytes.iter_mut().zip(value) {
        *byte = found;
    }
    u32::from_le_bytes(bytes)
}
