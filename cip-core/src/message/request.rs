//! Requests.

use super::BodyFormat;
use crate::code::{AttributeId, ClassId, InstanceId, ServiceCode};
use crate::codec::{Full, ParseError, Reader, Writer};
use crate::epath::{Epath, LogicalPath};

/// The object that a request is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Target<'a> {
    /// Formats 0-3.
    Object {
        /// The class.
        class: ClassId,
        /// The instance; 0 is the class itself.
        instance: InstanceId,
    },
    /// Format 4: a packed path, not yet looked at.
    Path(Epath<'a>),
}

/// A request from the service byte on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Request<'a> {
    /// The service.
    pub service: ServiceCode,
    /// The object.
    pub target: Target<'a>,
    /// The service data.
    pub data: &'a [u8],
}

/// The attribute that a request is about, and the rest of its data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AttributeAccess<'a> {
    /// The attribute.
    pub attribute: AttributeId,
    /// What follows it: the value of a Set_Attribute_Single, nothing in a Get_Attribute_Single.
    pub value: &'a [u8],
}

/// Why a request could not be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum EmitError {
    /// The buffer is too small.
    #[error(transparent)]
    Full(#[from] Full),
    /// The service code has more than seven bits: on the wire the eighth says that a message is a response.
    #[error("{0} is not a service code: it has more than seven bits")]
    Service(ServiceCode),
    /// An ID is too large for the body format, or a path is not one of whole words.
    #[error("the {0} body format cannot address this object; use a connection with a wider one")]
    NotAddressable(BodyFormat),
}

impl Target<'_> {
    /// The class, if the request names one that can be read.
    pub fn class(&self) -> Option<ClassId> {
        match self {
            Self::Object { class, .. } => Some(*class),
            Self::Path(path) => path.logical().ok()?.class,
        }
    }

    /// The instance. A path that names a class and no instance means the class itself.
    pub fn instance(&self) -> Option<InstanceId> {
        match self {
            Self::Object { instance, .. } => Some(*instance),
            Self::Path(path) => {
                let logical = path.logical().ok()?;
                logical.instance.or(logical.class.map(|_| InstanceId::CLASS))
            }
        }
    }
}

impl<'a> Request<'a> {
    /// A request to an object, addressed in whatever format it is emitted.
    pub const fn new(service: ServiceCode, class: ClassId, instance: InstanceId, data: &'a [u8]) -> Self {
        Self { service, target: Target::Object { class, instance }, data }
    }

    /// Reads a request. The service data end with `body`.
    pub fn parse(format: BodyFormat, body: &'a [u8]) -> Result<Self, ParseError> {
        let mut reader = Reader::new(body);
        let (service, response) = ServiceCode::split(reader.u8("service")?);
        if response {
            return Err(ParseError::value("service", 0, service.response_byte().into()));
        }
        let target = Target::read(format, &mut reader)?;
        Ok(Self { service, target, data: reader.rest() })
    }

    /// Writes the request. After an error nothing of it is left in `out`.
    pub fn emit(&self, format: BodyFormat, out: &mut Writer<'_>) -> Result<(), EmitError> {
        let start = out.len();
        let result = self.emit_parts(format, out);
        if result.is_err() {
            out.truncate(start);
        }
        result
    }

    /// The number of bytes that [`emit`](Self::emit) writes.
    pub fn wire_len(&self, format: BodyFormat) -> usize {
        let target = match (format, self.target) {
            (BodyFormat::Class8Instance8, _) => 2,
            (BodyFormat::Class8Instance16 | BodyFormat::Class16Instance8, _) => 3,
            (BodyFormat::Class16Instance16, _) => 4,
            (BodyFormat::CipPath, Target::Path(path)) => path.bytes().len().saturating_add(1),
            (BodyFormat::CipPath, Target::Object { class, instance }) => {
                LogicalPath::object(class, instance).packed_len().next_multiple_of(2).saturating_add(1)
            }
        };
        self.data.len().saturating_add(target).saturating_add(1)
    }

    /// The attribute of a Get_Attribute_Single, a Set_Attribute_Single or a member service.
    ///
    /// It is the first byte of the service data, unless the path of format 4 has an attribute segment.
    pub fn attribute_access(&self) -> Result<AttributeAccess<'a>, ParseError> {
        if let Target::Path(path) = self.target
            && let Some(attribute) = path.logical()?.attribute
        {
            return Ok(AttributeAccess { attribute, value: self.data });
        }
        let mut reader = Reader::new(self.data);
        let attribute = AttributeId(reader.u8("attribute")?.into());
        Ok(AttributeAccess { attribute, value: reader.rest() })
    }

    fn emit_parts(&self, format: BodyFormat, out: &mut Writer<'_>) -> Result<(), EmitError> {
        emit_service(self.service, out)?;
        self.target.emit(format, out)?;
        Ok(out.bytes(self.data)?)
    }
}

/// A Get_Attribute_Single, Set_Attribute_Single or another request for one attribute, for a client that does not care
/// where the body format puts the attribute.
///
/// ```
/// use cip_core::code::{AttributeId, ClassId, InstanceId, ServiceCode};
/// use cip_core::codec::Writer;
/// use cip_core::message::{AttributeRequest, BodyFormat};
///
/// let request = AttributeRequest::get(ClassId::IDENTITY, InstanceId(1), AttributeId(7));
/// let mut buffer = [0; 16];
/// let mut out = Writer::new(&mut buffer);
/// request.emit(BodyFormat::Class8Instance8, &mut out)?;
/// assert_eq!(out.written(), [0x0E, 0x01, 0x01, 0x07]);
/// let mut out = Writer::new(&mut buffer);
/// request.emit(BodyFormat::CipPath, &mut out)?;
/// assert_eq!(out.written(), [0x0E, 0x03, 0x20, 0x01, 0x24, 0x01, 0x30, 0x07]);
/// # Ok::<(), cip_core::message::EmitError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AttributeRequest<'a> {
    /// The service.
    pub service: ServiceCode,
    /// The class.
    pub class: ClassId,
    /// The instance.
    pub instance: InstanceId,
    /// The attribute.
    pub attribute: AttributeId,
    /// The value to set.
    pub value: &'a [u8],
}

impl<'a> AttributeRequest<'a> {
    /// Get_Attribute_Single.
    pub const fn get(class: ClassId, instance: InstanceId, attribute: AttributeId) -> Self {
        Self { service: ServiceCode::GET_ATTRIBUTE_SINGLE, class, instance, attribute, value: &[] }
    }

    /// Set_Attribute_Single.
    pub const fn set(class: ClassId, instance: InstanceId, attribute: AttributeId, value: &'a [u8]) -> Self {
        Self { service: ServiceCode::SET_ATTRIBUTE_SINGLE, class, instance, attribute, value }
    }

    /// Writes the request. After an error nothing of it is left in `out`.
    pub fn emit(&self, format: BodyFormat, out: &mut Writer<'_>) -> Result<(), EmitError> {
        let start = out.len();
        let result = self.emit_parts(format, out);
        if result.is_err() {
            out.truncate(start);
        }
        result
    }

    fn emit_parts(&self, format: BodyFormat, out: &mut Writer<'_>) -> Result<(), EmitError> {
        emit_service(self.service, out)?;
        if format == BodyFormat::CipPath {
            emit_path(LogicalPath::object(self.class, self.instance).with_attribute(self.attribute), out)?;
        } else {
            Target::Object { class: self.class, instance: self.instance }.emit(format, out)?;
            out.u8(u8::try_from(self.attribute.0).map_err(|_| EmitError::NotAddressable(format))?)?;
        }
        Ok(out.bytes(self.value)?)
    }
}

impl<'a> Target<'a> {
    fn read(format: BodyFormat, reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        let class = match format {
            BodyFormat::Class8Instance8 | BodyFormat::Class8Instance16 => reader.u8("class")?.into(),
            BodyFormat::Class16Instance16 | BodyFormat::Class16Instance8 => reader.u16("class")?,
            BodyFormat::CipPath => {
                let words = usize::from(reader.u8("path size")?);
                return Ok(Self::Path(Epath::packed(reader.bytes(words.saturating_mul(2), "path")?)));
            }
        };
        let instance = match format {
            BodyFormat::Class8Instance8 | BodyFormat::Class16Instance8 => reader.u8("instance")?.into(),
            BodyFormat::Class8Instance16 | BodyFormat::Class16Instance16 | BodyFormat::CipPath => {
                reader.u16("instance")?
            }
        };
        Ok(Self::Object { class: ClassId(class), instance: InstanceId(instance) })
    }

    fn emit(&self, format: BodyFormat, out: &mut Writer<'_>) -> Result<(), EmitError> {
        let not_addressable = EmitError::NotAddressable(format);
        let (class, instance) = match (*self, format) {
            (Self::Path(path), BodyFormat::CipPath) => {
                let bytes = path.bytes();
                if !bytes.len().is_multiple_of(2) {
                    return Err(not_addressable);
                }
                out.u8(u8::try_from(bytes.len() / 2).map_err(|_| not_addressable)?)?;
                return Ok(out.bytes(bytes)?);
            }
            (Self::Path(_), _) => return Err(not_addressable),
            (Self::Object { class, instance }, BodyFormat::CipPath) => {
                return emit_path(LogicalPath::object(class, instance), out);
            }
            (Self::Object { class, instance }, _) => (class.0, instance.0),
        };
        match format {
            BodyFormat::Class8Instance8 | BodyFormat::Class8Instance16 => {
                out.u8(u8::try_from(class).map_err(|_| not_addressable)?)?;
            }
            BodyFormat::Class16Instance16 | BodyFormat::Class16Instance8 | BodyFormat::CipPath => {
                out.u16(class)?
            }
        }
        match format {
            BodyFormat::Class8Instance8 | BodyFormat::Class16Instance8 => {
                out.u8(u8::try_from(instance).map_err(|_| not_addressable)?)?;
            }
            BodyFormat::Class8Instance16 | BodyFormat::Class16Instance16 | BodyFormat::CipPath => {
                out.u16(instance)?
            }
        }
        Ok(())
    }
}

fn emit_service(service: ServiceCode, out: &mut Writer<'_>) -> Result<(), EmitError> {
    if !service.is_valid() {
        return Err(EmitError::Service(service));
    }
    Ok(out.u8(service.request_byte())?)
}

fn emit_path(path: LogicalPath, out: &mut Writer<'_>) -> Result<(), EmitError> {
    let size_at = out.len();
    out.u8(0)?;
    let start = out.len();
    path.emit_words(out)?.map_err(|_| EmitError::NotAddressable(BodyFormat::CipPath))?;
    let words = out.len().saturating_sub(start) / 2;
    let words = u8::try_from(words).map_err(|_| EmitError::NotAddressable(BodyFormat::CipPath))?;
    Ok(out.patch(size_at, &[words])?)
}
