//! The data of services that do not concern a single attribute.

use core::fmt::{self, Formatter};

use super::value::write_attribute;
use super::{write_bytes, write_status};
use crate::code::{AdditionalCode, AttributeId, ClassId, InstanceId, ServiceCode};
use crate::codec::Wire;
use crate::message::{
    AttributeReplies, AttributeReply, AttributeSettings, AttributeStatusList, CreateResponse,
    FindNextRequest, InstanceList, MemberId, MultipleServicePacket, ResetRequest, UintList,
};
use crate::monitor::{Explicit, Vocabulary};
use crate::text::{Hex, write_decimal, write_prefixed_hex};

/// Service data with a known layout.
#[derive(Debug, Clone, Copy)]
pub(super) enum ServiceText<'a> {
    /// The attributes that are asked for.
    Names(UintList<'a>),
    /// What is to be set.
    Settings(AttributeSettings<'a>),
    /// What was read.
    Replies(AttributeReplies<'a>),
    /// What has become of each attribute to be set.
    Statuses(AttributeStatusList<'a>),
    /// A member, and its value.
    Member(u16, &'a [u8]),
    /// The value of a member.
    MemberValue(&'a [u8]),
    /// Requests in one.
    Requests(MultipleServicePacket<'a>),
    /// Their responses.
    Responses(MultipleServicePacket<'a>),
    /// What a reset does.
    Reset(ResetRequest),
    /// How many instances to return.
    FindNext(FindNextRequest),
    /// The instances found.
    Instances(InstanceList<'a>),
    /// The instance made.
    Created(CreateResponse<'a>),
}

impl<'a> ServiceText<'a> {
    /// The layout of `data`; `None` if there is none, or the data do not have it.
    pub(super) fn of(fields: &Explicit<'_>, vocabulary: &Vocabulary, data: &'a [u8]) -> Option<Self> {
        let is_response = fields.requested.is_some();
        let service = fields.requested.or(fields.service)?;
        let is_addressed = fields.class.is_some() && fields.instance.is_some();
        if data.is_empty() || fields.status.is_some() || !is_addressed {
            return None;
        }
        match (service, is_response) {
            (ServiceCode::GET_ATTRIBUTE_LIST, false) => UintList::parse(data).ok().map(Self::Names),
            (ServiceCode::GET_ATTRIBUTE_LIST, true) => {
                let replies = AttributeReplies::parse(data).ok()?;
                replies
                    .iter(lengths(fields, vocabulary))
                    .all(|reply| reply.is_ok())
                    .then_some(Self::Replies(replies))
            }
            (ServiceCode::SET_ATTRIBUTE_LIST, false) => {
                let settings = AttributeSettings::parse(data).ok()?;
                settings
                    .iter(lengths(fields, vocabulary))
                    .all(|entry| entry.is_ok())
                    .then_some(Self::Settings(settings))
            }
            (ServiceCode::SET_ATTRIBUTE_LIST, true) => {
                AttributeStatusList::parse(data).ok().map(Self::Statuses)
            }
            (ServiceCode::MULTIPLE_SERVICE_PACKET, false) => {
                MultipleServicePacket::parse(data).ok().map(Self::Requests)
            }
            (ServiceCode::MULTIPLE_SERVICE_PACKET, true) => {
                MultipleServicePacket::parse(data).ok().map(Self::Responses)
            }
            (service, false) if names_member(service) => match *data {
                [low, high, ref value @ ..] => Some(Self::Member(u16::from_le_bytes([low, high]), value)),
                _ => None,
            },
            (ServiceCode::INSERT_MEMBER, true) => {
                MemberId::parse(data).ok().map(|MemberId(member)| Self::Member(member, &[]))
            }
            (service, true) if names_member(service) => Some(Self::MemberValue(data)),
            (ServiceCode::RESET, false) if fields.class == Some(ClassId::IDENTITY) && data.len() == 1 => {
                ResetRequest::parse(data).ok().map(Self::Reset)
            }
            (ServiceCode::FIND_NEXT_OBJECT_INSTANCE, false) => {
                FindNextRequest::parse(data).ok().map(Self::FindNext)
            }
            (ServiceCode::FIND_NEXT_OBJECT_INSTANCE, true) => {
                InstanceList::parse(data).ok().map(Self::Instances)
            }
            (ServiceCode::CREATE, true) => CreateResponse::parse(data).ok().map(Self::Created),
            _ => None,
        }
    }

    pub(super) fn write(
        &self,
        f: &mut Formatter<'_>,
        fields: &Explicit<'_>,
        vocabulary: &Vocabulary,
    ) -> fmt::Result {
        let Some((class, instance)) = fields.class.zip(fields.instance) else { return Ok(()) };
        match self {
            Self::Names(list) => separated(f, ", ", list.attributes(), |f, attribute| {
                write_name(f, vocabulary, class, instance, attribute)
            }),
            Self::Settings(settings) => separated(
                f,
                ", ",
                settings.iter(lengths(fields, vocabulary)).flatten(),
                |f, (attribute, value)| write_attribute(f, vocabulary, class, instance, attribute, value),
            ),
            Self::Replies(replies) => separated(
                f,
                ", ",
                replies.iter(lengths(fields, vocabulary)).flatten(),
                |f, reply| match reply {
                    AttributeReply { attribute, value: Ok(value) } => {
                        write_attribute(f, vocabulary, class, instance, attribute, value)
                    }
                    AttributeReply { attribute, value: Err(status) } => {
                        write_name(f, vocabulary, class, instance, attribute)?;
                        f.write_str(" error ")?;
                        write_status(f, status, AdditionalCode::NONE, None)
                    }
                },
            ),
            Self::Statuses(list) => separated(f, ", ", list.iter(), |f, (attribute, status)| {
                write_name(f, vocabulary, class, instance, attribute)?;
                match u8::try_from(status) {
                    Ok(0) => f.write_str(" ok"),
                    Ok(status) => {
                        f.write_str(" error ")?;
                        write_status(f, status.into(), AdditionalCode::NONE, None)
                    }
                    Err(_) => {
                        f.write_str(" error ")?;
                        write_prefixed_hex(f, status.into())
                    }
                }
            }),
            Self::Member(member, value) => {
                write_attribute_of(f, vocabulary, fields)?;
                f.write_str("member ")?;
                write_decimal(f, (*member).into())?;
                write_bytes(f, value)
            }
            Self::MemberValue(value) => {
                write_attribute_of(f, vocabulary, fields)?;
                fmt::Display::fmt(&Hex(value), f)
            }
            Self::Requests(packet) => separated(f, "; ", packet.services(), |f, body| {
                write_part(f, vocabulary, false, &Explicit::request(fields.format, body, 0).explicit, body)
            }),
            Self::Responses(packet) => {
                let mut asked = fields.parts.into_iter().flatten();
                separated(f, "; ", packet.services(), |f, body| {
                    let mut part = Explicit::response(body, 0).explicit;
                    if let Some(asked) = asked.next().and_then(Option::as_ref) {
                        part.answers(asked, body);
                    }
                    write_part(f, vocabulary, true, &part, body)
                })
            }
            Self::Reset(ResetRequest { kind }) => match kind {
                Some(kind) => fmt::Display::fmt(kind, f),
                None => Ok(()),
            },
            Self::FindNext(FindNextRequest { max }) => {
                f.write_str("at most ")?;
                write_decimal(f, (*max).into())
            }
            Self::Instances(list) => {
                separated(f, ", ", list.iter(), |f, instance| fmt::Display::fmt(&instance, f))
            }
            Self::Created(CreateResponse { instance, data }) => {
                fmt::Display::fmt(instance, f)?;
                write_bytes(f, data)
            }
        }
    }
}

/// A request or response inside of another. A packet inside of a packet is not taken apart.
fn write_part(
    f: &mut Formatter<'_>,
    vocabulary: &Vocabulary,
    is_response: bool,
    part: &Explicit<'_>,
    body: &[u8],
) -> fmt::Result {
    if body.is_empty() {
        return f.write_str("nothing");
    }
    let is_packet = part.requested.or(part.service) == Some(ServiceCode::MULTIPLE_SERVICE_PACKET);
    let class = part.class.filter(|_| !is_packet);
    let value = part.value.map(|span| span.of(body)).unwrap_or_default();
    Explicit { class, ..*part }.write(f, vocabulary, is_response, value)
}

/// The services for one member of an attribute.
fn names_member(service: ServiceCode) -> bool {
    matches!(
        service,
        ServiceCode::GET_MEMBER
            | ServiceCode::SET_MEMBER
            | ServiceCode::INSERT_MEMBER
            | ServiceCode::REMOVE_MEMBER
    )
}

/// How many bytes the value of an attribute takes.
fn lengths<'v>(
    fields: &Explicit<'_>,
    vocabulary: &'v Vocabulary,
) -> impl Fn(AttributeId, &[u8]) -> Option<usize> + use<'v> {
    let target = fields.class.zip(fields.instance);
    move |attribute, data| {
        let (class, instance) = target?;
        vocabulary.value_len(class, instance, attribute, data)
    }
}

/// Every item, and between them the separator; `none` without any.
fn separated<T>(
    f: &mut Formatter<'_>,
    separator: &str,
    items: impl Iterator<Item = T>,
    mut write: impl FnMut(&mut Formatter<'_>, T) -> fmt::Result,
) -> fmt::Result {
    let mut is_first = true;
    for item in items {
        if !core::mem::take(&mut is_first) {
            f.write_str(separator)?;
        }
        write(f, item)?;
    }
    if is_first { f.write_str("none") } else { Ok(()) }
}

/// The name of the attribute that the fields name, and a space.
fn write_attribute_of(f: &mut Formatter<'_>, vocabulary: &Vocabulary, fields: &Explicit<'_>) -> fmt::Result {
    let (Some(class), Some(instance), Some(attribute)) = (fields.class, fields.instance, fields.attribute)
    else {
        return Ok(());
    };
    write_name(f, vocabulary, class, instance, attribute)?;
    f.write_str(" ")
}

fn write_name(
    f: &mut Formatter<'_>,
    vocabulary: &Vocabulary,
    class: ClassId,
    instance: InstanceId,
    attribute: AttributeId,
) -> fmt::Result {
    match vocabulary.attribute_name(class, instance, attribute) {
        Some(name) => f.write_str(name),
        None => fmt::Display::fmt(&attribute, f),
    }
}
