//! Explicit messages, on a connection or without one: complete ones, fragments, acknowledges.
//!
//! The identifier says which of them it is ([`Framing`](crate::id::Framing)), so the eight bytes of data are all body. What
//! DeviceNet has in byte 0 and 1 is in the identifier here **\[D\]**.

use cip_core::code::{AdditionalCode, GeneralStatus, ServiceCode};
use cip_core::codec::{Full, ParseError, Reader, Tail, Wire, Writer};
use cip_core::fragment::AckStatus;
use link_core::Frame;

use super::fields::{constant, rest};

/// An explicit message in one frame.
///
/// | Byte | Content |
/// |---|---|
/// | 0 | service, bit 7: 0 request, 1 response |
/// | 1-7 | the rest of the body, 0 to 7 bytes |
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ExplicitMessage<'a> {
    /// From the service byte on, 1 to 8 bytes.
    pub body: &'a [u8],
}

/// The first fragment of an explicit message.
///
/// | Byte | Content |
/// |---|---|
/// | 0 | transaction ID: in the identifier the fragment takes its place |
/// | 1-7 | the first seven bytes of the body |
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct FirstFragment {
    /// Chosen by the requester, echoed by the server.
    pub transaction: u8,
    /// A first fragment is always full.
    pub body: [u8; 7],
}

/// A middle or last fragment of an explicit message.
///
/// | Byte | Content |
/// |---|---|
/// | 0-7 | a part of the body: eight bytes in a middle fragment, 1 to 8 in the last |
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct NextFragment<'a> {
    /// The part.
    pub body: &'a [u8],
}

/// The acknowledge of a fragment, in the other direction. Its count is in the identifier.
///
/// | Byte | Content |
/// |---|---|
/// | 0 | status, as in DeviceNet: 0 success, 1 too much data, 2-255 reserved |
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct FragmentAcknowledge {
    /// Whether the receiver goes on.
    pub status: AckStatus,
}

/// A connectionless request: Get_Attribute_Single, the only service that a connection is not needed for **\[P\]**.
///
/// | Byte | Content |
/// |---|---|
/// | 0 | 0x0E |
/// | 1 | class |
/// | 2 | instance |
/// | 3 | attribute |
///
/// The body format is 8/8 **\[D\]**.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ConnectionlessRequest {
    /// Of 8 bits, as everything here.
    pub class: u8,
    /// The instance.
    pub instance: u8,
    /// The attribute.
    pub attribute: u8,
}

/// The response to a connectionless request that fits into one frame; a longer one is fragmented.
///
/// | Byte | Content |
/// |---|---|
/// | 0 | 0x8E |
/// | 1-7 | the value, 0 to 7 bytes |
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ConnectionlessResponse<'a> {
    /// The value of the attribute.
    pub value: &'a [u8],
}

/// A request was not carried out: of any kind, a connection request included **\[D\]**.
///
/// | Byte | Content |
/// |---|---|
/// | 0 | 0x94 |
/// | 1 | general status |
/// | 2 | additional code, 0xFF if there is none |
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ErrorResponse {
    /// Why.
    pub general: GeneralStatus,
    /// More about it.
    pub additional: AdditionalCode,
}

impl ErrorResponse {
    /// The answer to a connectionless request for another service than Get_Attribute_Single: 0x94, 0x08, 0xFF.
    pub const SERVICE_NOT_SUPPORTED: Self = Self::new(GeneralStatus::SERVICE_NOT_SUPPORTED);

    /// An error without an additional code.
    #[must_use]
    pub const fn new(general: GeneralStatus) -> Self {
        Self { general, additional: AdditionalCode(0xFF) }
    }
}

impl<'a> Wire<'a> for ExplicitMessage<'a> {
    const NAME: &'static str = "explicit message";
    const TAIL: Tail = Tail::Open;

    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        let mut service = *reader;
        service.u8("service")?;
        Ok(Self { body: rest(reader, Frame::MAX_DATA, Self::NAME)? })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.bytes(self.body)
    }

    fn wire_len(&self) -> usize {
        self.body.len()
    }
}

impl Wire<'_> for FirstFragment {
    const NAME: &'static str = "first fragment";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        Ok(Self { transaction: reader.u8("transaction ID")?, body: reader.array("body")? })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u8(self.transaction)?;
        out.bytes(&self.body)
    }

    fn wire_len(&self) -> usize {
        8
    }
}

impl<'a> Wire<'a> for NextFragment<'a> {
    const NAME: &'static str = "fragment";
    const TAIL: Tail = Tail::Open;

    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        let mut first = *reader;
        first.u8("body")?;
        Ok(Self { body: rest(reader, Frame::MAX_DATA, Self::NAME)? })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.bytes(self.body)
    }

    fn wire_len(&self) -> usize {
        self.body.len()
    }
}

impl Wire<'_> for FragmentAcknowledge {
    const NAME: &'static str = "fragment acknowledge";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        Ok(Self { status: AckStatus::from(reader.u8("status")?) })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u8(self.status.into())
    }

    fn wire_len(&self) -> usize {
        1
    }
}

impl Wire<'_> for ConnectionlessRequest {
    const NAME: &'static str = "connectionless request";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        constant(reader, "service", ServiceCode::GET_ATTRIBUTE_SINGLE.request_byte())?;
        Ok(Self {
            class: reader.u8("class")?,
            instance: reader.u8("instance")?,
            attribute: reader.u8("attribute")?,
        })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        let service = ServiceCode::GET_ATTRIBUTE_SINGLE.request_byte();
        out.bytes(&[service, self.class, self.instance, self.attribute])
    }

    fn wire_len(&self) -> usize {
        4
    }
}

impl<'a> Wire<'a> for ConnectionlessResponse<'a> {
    const NAME: &'static str = "connectionless response";
    const TAIL: Tail = Tail::Open;

    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        constant(reader, "service", ServiceCode::GET_ATTRIBUTE_SINGLE.response_byte())?;
        Ok(Self { value: rest(reader, MAX_VALUE, Self::NAME)? })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u8(ServiceCode::GET_ATTRIBUTE_SINGLE.response_byte())?;
        out.bytes(self.value)
    }

    fn wire_len(&self) -> usize {
        self.value.len().saturating_add(1)
    }
}

impl Wire<'_> for ErrorResponse {
    const NAME: &'static str = "error response";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        constant(reader, "service", ServiceCode::ERROR_RESPONSE.response_byte())?;
        Ok(Self {
            general: GeneralStatus(reader.u8("general status")?),
            additional: AdditionalCode(reader.u8("additional code")?),
        })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.bytes(&[ServiceCode::ERROR_RESPONSE.response_byte(), self.general.0, self.additional.0])
    }

    fn wire_len(&self) -> usize {
        3
    }
}

const MAX_VALUE: usize = 7;
