//! The Group 2 unconnected port: Allocate and Release of the predefined master/slave connection set, as whole frames.
//!
//! Requests are on `0x406 + 8s`, responses on `0x403 + 8s`; the header carries the requester's MAC ID in both. Here the
//! request is always addressed in the 8/8 format. The same services sent on an open explicit connection are ordinary
//! explicit requests: their bodies are in [`cip_core::message`].
//!
//! Reserved bits: those of the choice and of the allocator byte are kept, because a server answers them with an error;
//! those of the format byte of a response are refused.

use cip_core::code::{AdditionalCode, GeneralStatus, ServiceCode};
use cip_core::codec::{Full, ParseError, Reader, Wire, Writer};
use cip_core::message::{AllocateRequest, AllocateResponse, ReleaseRequest};

use super::fields::{constant, service};
use super::{Direction, ExplicitHeader};
use crate::id::MacId;

/// Allocate_Master/Slave_Connection_Set to the unconnected port.
///
/// | Byte | Content |
/// |---|---|
/// | 0 | header: FRAG 0, XID, requester's MAC ID |
/// | 1 | 0x4B |
/// | 2 | class 0x03 |
/// | 3 | instance 0x01 |
/// | 4 | allocation choice |
/// | 5 | allocator's MAC ID, bits 5-0; bits 7-6 reserved, 0 |
///
/// Source: ICP DAS CAN-8124/8224/8424 manual p. 112; CIP Vol. 3.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct UnconnectedAllocate {
    /// XID.
    pub xid: bool,
    /// Who asks, and is answered.
    pub requester: MacId,
    /// What is to be allocated, for whom.
    pub body: AllocateRequest,
}

/// The response to [`UnconnectedAllocate`].
///
/// | Byte | Content |
/// |---|---|
/// | 0 | header: FRAG 0, XID copied, requester's MAC ID |
/// | 1 | 0xCB |
/// | 2 | bits 3-0 body format of the explicit connection; bits 7-4 reserved, 0 |
///
/// Source: ICP DAS CAN-8124/8224/8424 manual p. 112; CIP Vol. 3.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct UnconnectedAllocateResponse {
    /// XID.
    pub xid: bool,
    /// Who asked.
    pub requester: MacId,
    /// The body format that the requester must use.
    pub body: AllocateResponse,
}

/// Release_Master/Slave_Connection_Set to the unconnected port. The releasing master is the one in the header.
///
/// | Byte | Content |
/// |---|---|
/// | 0 | header: FRAG 0, XID, requester's MAC ID |
/// | 1 | 0x4C |
/// | 2 | class 0x03 |
/// | 3 | instance 0x01 |
/// | 4 | release choice, bits 6 and 7 reserved |
///
/// Source: POSITAL/BEI MHK5 manual UME-OCD-D2 p. 10, which prints a choice with bit 6 set; CIP Vol. 3.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct UnconnectedRelease {
    /// XID.
    pub xid: bool,
    /// Who asks, and is answered.
    pub requester: MacId,
    /// What is to be released.
    pub body: ReleaseRequest,
}

/// The response to [`UnconnectedRelease`].
///
/// | Byte | Content |
/// |---|---|
/// | 0 | header: FRAG 0, XID copied, requester's MAC ID |
/// | 1 | 0xCC |
///
/// Source: CIP Vol. 3.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct UnconnectedReleaseResponse {
    /// XID.
    pub xid: bool,
    /// Who asked.
    pub requester: MacId,
}

/// Error response to any explicit request, connected, unconnected or UCMM.
///
/// | Byte | Content |
/// |---|---|
/// | 0 | header: FRAG 0, XID copied, MAC ID |
/// | 1 | 0x94 |
/// | 2 | general status |
/// | 3 | additional code, 0xFF if none |
///
/// Source: MKS Baratron DMA manual, appendix D; Mitsubishi FR-A8ND manual.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ErrorResponse {
    /// XID.
    pub xid: bool,
    /// The MAC ID in the header.
    pub mac: MacId,
    /// What is wrong.
    pub general: GeneralStatus,
    /// What exactly; depends on object and service.
    pub additional: AdditionalCode,
}

impl Wire<'_> for UnconnectedAllocate {
    const NAME: &'static str = "Allocate on the unconnected port";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        let header = ExplicitHeader::read_complete(reader)?;
        request_to_devicenet_object(reader, ServiceCode::ALLOCATE)?;
        Ok(Self { xid: header.xid, requester: header.mac, body: AllocateRequest::read(reader)? })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        ExplicitHeader::complete(self.xid, self.requester).emit(out)?;
        out.bytes(&[ServiceCode::ALLOCATE.request_byte(), DEVICENET_CLASS, INSTANCE])?;
        self.body.emit(out)
    }

    fn wire_len(&self) -> usize {
        6
    }
}

impl Wire<'_> for UnconnectedAllocateResponse {
    const NAME: &'static str = "Allocate response";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        let header = ExplicitHeader::read_complete(reader)?;
        service(reader, ServiceCode::ALLOCATE, Direction::Response)?;
        Ok(Self { xid: header.xid, requester: header.mac, body: AllocateResponse::read(reader)? })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        ExplicitHeader::complete(self.xid, self.requester).emit(out)?;
        out.u8(ServiceCode::ALLOCATE.response_byte())?;
        self.body.emit(out)
    }

    fn wire_len(&self) -> usize {
        3
    }
}

impl Wire<'_> for UnconnectedRelease {
    const NAME: &'static str = "Release on the unconnected port";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        let header = ExplicitHeader::read_complete(reader)?;
        request_to_devicenet_object(reader, ServiceCode::RELEASE)?;
        Ok(Self { xid: header.xid, requester: header.mac, body: ReleaseRequest::read(reader)? })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        ExplicitHeader::complete(self.xid, self.requester).emit(out)?;
        out.bytes(&[ServiceCode::RELEASE.request_byte(), DEVICENET_CLASS, INSTANCE])?;
        self.body.emit(out)
    }

    fn wire_len(&self) -> usize {
        5
    }
}

impl Wire<'_> for UnconnectedReleaseResponse {
    const NAME: &'static str = "Release response";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        let header = ExplicitHeader::read_complete(reader)?;
        service(reader, ServiceCode::RELEASE, Direction::Response)?;
        Ok(Self { xid: header.xid, requester: header.mac })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        ExplicitHeader::complete(self.xid, self.requester).emit(out)?;
        out.u8(ServiceCode::RELEASE.response_byte())
    }

    fn wire_len(&self) -> usize {
        2
    }
}

impl Wire<'_> for ErrorResponse {
    const NAME: &'static str = "error response";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        let header = ExplicitHeader::read_complete(reader)?;
        service(reader, ServiceCode::ERROR_RESPONSE, Direction::Response)?;
        Ok(Self {
            xid: header.xid,
            mac: header.mac,
            general: GeneralStatus(reader.u8("general status")?),
            additional: AdditionalCode(reader.u8("additional code")?),
        })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        ExplicitHeader::complete(self.xid, self.mac).emit(out)?;
        out.bytes(&[ServiceCode::ERROR_RESPONSE.response_byte(), self.general.0, self.additional.0])
    }

    fn wire_len(&self) -> usize {
        4
    }
}

/// Service, class 3, instance 1.
fn request_to_devicenet_object(reader: &mut Reader<'_>, code: ServiceCode) -> Result<(), ParseError> {
    service(reader, code, Direction::Request)?;
    constant(reader, "class", DEVICENET_CLASS)?;
    constant(reader, "instance", INSTANCE)
}

const DEVICENET_CLASS: u8 = 0x03;
const INSTANCE: u8 = 0x01;
