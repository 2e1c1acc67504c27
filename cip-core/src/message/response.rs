//! Responses.

use crate::code::{AdditionalCode, GeneralStatus, ServiceCode};
use crate::codec::{Full, ParseError, Reader, Tail, Wire, Writer};

/// A response from the service byte on.
///
/// | Byte | Success | Error |
/// |---|---|---|
/// | 0 | service code + 0x80 | 0x94 |
/// | 1 | data | general status |
/// | 2 | data | additional code, 0xFF if there is none |
/// | 3.. | data | nothing |
///
/// Only the length of an error response is fixed.
///
/// ```
/// use cip_core::codec::Wire;
/// use cip_core::message::Response;
///
/// assert_eq!(Response::parse(&[0x8E, 0x6C, 0x00])?.to_string(), "Get_Attribute_Single ok, data 6C 00");
/// assert_eq!(Response::parse(&[0x94, 0x14, 0xFF])?.to_string(), "error 0x14 Attribute not supported");
/// # Ok::<(), cip_core::codec::ParseError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Response<'a> {
    /// The service was carried out.
    Success {
        /// The service.
        service: ServiceCode,
        /// The service data.
        data: &'a [u8],
    },
    /// The service was refused.
    Error {
        /// Why.
        status: GeneralStatus,
        /// More about it, in words of the object.
        additional: AdditionalCode,
    },
}

impl Response<'_> {
    /// An error without an additional code.
    pub const fn error(status: GeneralStatus) -> Self {
        Self::Error { status, additional: AdditionalCode::NONE }
    }
}

impl<'a> Wire<'a> for Response<'a> {
    const NAME: &'static str = "response";
    const TAIL: Tail = Tail::Open;

    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        let offset = reader.offset();
        let byte = reader.u8("service")?;
        match ServiceCode::split(byte) {
            (_, false) => Err(ParseError::value("service", offset, byte.into())),
            (ServiceCode::ERROR_RESPONSE, true) => Ok(Self::Error {
                status: GeneralStatus(reader.u8("general status")?),
                additional: AdditionalCode(reader.u8("additional code")?),
            }),
            (service, true) => Ok(Self::Success { service, data: reader.rest() }),
        }
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        match *self {
            Self::Success { service, data } => {
                out.u8(service.response_byte())?;
                out.bytes(data)
            }
            Self::Error { status, additional } => {
                out.bytes(&[ServiceCode::ERROR_RESPONSE.response_byte(), status.0, additional.0])
            }
        }
    }

    fn wire_len(&self) -> usize {
        match self {
            Self::Success { data, .. } => data.len().saturating_add(1),
            Self::Error { .. } => 3,
        }
    }
}
