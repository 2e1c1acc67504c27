//! Requests and responses in words.

use core::fmt;

use super::{AllocateRequest, AllocateResponse, ReleaseRequest, Request, ResetRequest, Response, Target};
use crate::code::{AdditionalCode, AttributeId, ClassId, InstanceId, ServiceCode};
use crate::codec::Wire;
use crate::names::{additional_code_name, service_name};
use crate::text::{Hex, write_decimal, write_hex8};
use crate::value::AttributeValue;

/// What a request was about: all that is needed to understand its response, which does not repeat it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Subject {
    /// The class.
    pub class: ClassId,
    /// The instance.
    pub instance: InstanceId,
    /// The attribute, of a service for one attribute.
    pub attribute: Option<AttributeId>,
}

/// A response together with what its request was about.
///
/// ```
/// use cip_core::codec::Wire;
/// use cip_core::message::{Answer, BodyFormat, Request, Response};
///
/// let request = Request::parse(BodyFormat::Class8Instance8, &[0x10, 0x05, 0x02, 0x09, 0x0A, 0x0E])?;
/// assert_eq!(request.to_string(), "Set_Attribute_Single Connection instance 2, expected_packet_rate 3594 ms");
/// let answer = Answer { subject: request.subject(), response: Response::parse(&[0x90, 0x10, 0x0E])? };
/// assert_eq!(answer.to_string(), "Set_Attribute_Single ok, expected_packet_rate 3600 ms");
/// # Ok::<(), cip_core::codec::ParseError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Answer<'a> {
    /// What the request was about, if it is known.
    pub subject: Option<Subject>,
    /// The response.
    pub response: Response<'a>,
}

impl Request<'_> {
    /// What the request is about; `None` if its path names no class.
    pub fn subject(&self) -> Option<Subject> {
        let (class, instance) = (self.target.class()?, self.target.instance()?);
        let single =
            matches!(self.service, ServiceCode::GET_ATTRIBUTE_SINGLE | ServiceCode::SET_ATTRIBUTE_SINGLE);
        let attribute = self.attribute_access().ok().filter(|_| single).map(|access| access.attribute);
        Some(Subject { class, instance, attribute })
    }
}

impl fmt::Display for Target<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Object { class, instance } => {
                fmt::Display::fmt(class, f)?;
                if instance.is_class() {
                    return f.write_str(" class");
                }
                f.write_str(" instance ")?;
                write_decimal(f, instance.0.into())
            }
            Self::Path(path) => fmt::Display::fmt(path, f),
        }
    }
}

impl fmt::Display for Request<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let subject = self.subject();
        write_service(f, subject, self.service)?;
        f.write_str(" ")?;
        fmt::Display::fmt(&self.target, f)?;
        let Some(subject) = subject else {
            return write_data(f, self.data);
        };
        if let Some((attribute, access)) = subject.attribute.zip(self.attribute_access().ok()) {
            f.write_str(", ")?;
            return write_attribute(f, subject, attribute, access.value);
        }
        match (subject.class, self.service) {
            (ClassId::DEVICENET, ServiceCode::ALLOCATE) => match AllocateRequest::parse(self.data) {
                Ok(allocate) => {
                    f.write_str(", ")?;
                    fmt::Display::fmt(&allocate.choice, f)?;
                    f.write_str(", master ")?;
                    write_decimal(f, allocate.allocator.into())
                }
                Err(_) => write_data(f, self.data),
            },
            (ClassId::DEVICENET, ServiceCode::RELEASE) => match ReleaseRequest::parse(self.data) {
                Ok(release) => {
                    f.write_str(", ")?;
                    fmt::Display::fmt(&release.choice, f)
                }
                Err(_) => write_data(f, self.data),
            },
            (ClassId::IDENTITY, ServiceCode::RESET) => match ResetRequest::parse(self.data) {
                Ok(ResetRequest { kind: Some(kind) }) => {
                    f.write_str(", ")?;
                    fmt::Display::fmt(&kind, f)
                }
                Ok(ResetRequest { kind: None }) | Err(_) => write_data(f, self.data),
            },
            _ => write_data(f, self.data),
        }
    }
}

impl fmt::Display for Response<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&Answer { subject: None, response: *self }, f)
    }
}

impl fmt::Display for Answer<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (service, data) = match self.response {
            Response::Success { service, data } => (service, data),
            Response::Error { status, additional } => {
                f.write_str("error 0x")?;
                write_hex8(f, status.0)?;
                if let Some(name) = status.name() {
                    f.write_str(" ")?;
                    f.write_str(name)?;
                }
                return write_additional(f, self.subject, additional);
            }
        };
        write_service(f, self.subject, service)?;
        f.write_str(" ok")?;
        let Some(subject) = self.subject else {
            return write_data(f, data);
        };
        if let Some(attribute) = subject.attribute.filter(|_| !data.is_empty()) {
            f.write_str(", ")?;
            return write_attribute(f, subject, attribute, data);
        }
        let allocate = subject.class == ClassId::DEVICENET && service == ServiceCode::ALLOCATE;
        let format = AllocateResponse::parse(data).ok().filter(|_| allocate);
        match format.and_then(|response| response.body_format()) {
            Some(format) => {
                f.write_str(", body format ")?;
                fmt::Display::fmt(&format, f)
            }
            None => write_data(f, data),
        }
    }
}

fn write_service(f: &mut fmt::Formatter<'_>, subject: Option<Subject>, service: ServiceCode) -> fmt::Result {
    match subject.and_then(|subject| service_name(subject.class, service)) {
        Some(name) => f.write_str(name),
        None => fmt::Display::fmt(&service, f),
    }
}

/// The name of the attribute, and its value if there is one.
fn write_attribute(
    f: &mut fmt::Formatter<'_>,
    subject: Subject,
    attribute: AttributeId,
    data: &[u8],
) -> fmt::Result {
    let value = AttributeValue { class: subject.class, instance: subject.instance, attribute, data };
    value.write_name(f)?;
    if data.is_empty() {
        return Ok(());
    }
    f.write_str(" ")?;
    value.write_value(f)
}

fn write_data(f: &mut fmt::Formatter<'_>, data: &[u8]) -> fmt::Result {
    if data.is_empty() {
        return Ok(());
    }
    f.write_str(", data ")?;
    fmt::Display::fmt(&Hex(data), f)
}

fn write_additional(
    f: &mut fmt::Formatter<'_>,
    subject: Option<Subject>,
    code: AdditionalCode,
) -> fmt::Result {
    if code == AdditionalCode::NONE {
        return Ok(());
    }
    f.write_str(", additional 0x")?;
    write_hex8(f, code.0)?;
    let Some(name) = subject.and_then(|subject| additional_code_name(subject.class, code)) else {
        return Ok(());
    };
    f.write_str(" ")?;
    f.write_str(name)
}
