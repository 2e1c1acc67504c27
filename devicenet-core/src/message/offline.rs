//! The offline connection set (Group 4): finding and repairing nodes that are silent because of a duplicate MAC ID.
//!
//! Reserved bits: every message to faulted nodes (0x7ED) with a reserved bit set is refused, because such a node must
//! ignore it. Bits 7-6 of byte 0 of the ownership messages are refused too; a tool that waits for an ownership response
//! need not read it, since any response means that the set is owned.

use cip_core::code::ServiceCode;
use cip_core::codec::{Full, ParseError, ParseErrorKind, Reader, Tail, Wire, Writer};

use super::fields::{constant, mac_id, service, service_of_either_direction};
use super::{DelayOffset, DeviceIdentity, Direction, NodeSelection, PortNumber};
use crate::id::MacId;

/// Offline Ownership request (0x7EF) and response (0x7EE).
///
/// | Byte | Content |
/// |---|---|
/// | 0 | bits 5-0 client MAC ID; bits 7-6 reserved, 0 |
/// | 1 | 0x4B request, 0xCB response |
/// | 2-3 | Vendor ID of the client, little-endian |
/// | 4-7 | Serial number of the client, little-endian |
///
/// In a response they are those of the present owner. Source: CIP Vol. 3, offline connection set.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct OfflineOwnership {
    /// Asking for the set, or defending it.
    pub direction: Direction,
    /// The tool's MAC ID.
    pub client: MacId,
    /// The tool.
    pub device: DeviceIdentity,
}

/// Who request, 0x7ED: faulted nodes tell who they are.
///
/// | Byte | Content |
/// |---|---|
/// | 0 | [`NodeSelection`] |
/// | 1 | 0x4B |
/// | 2 | time delay byte offset, 0-6: which byte of its response sets the time that a node waits before it sends it |
///
/// Source: ICP DAS I-7242D manual p. 93; CIP Vol. 3.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct WhoRequest {
    /// Who shall answer.
    pub nodes: NodeSelection,
    /// Byte 2.
    pub delay_offset: DelayOffset,
}

/// Who response, 0x7EC: the data of a duplicate MAC ID check request. It has no service byte and no MAC ID.
///
/// | Byte | Content |
/// |---|---|
/// | 0 | bit 7 0; bits 6-0 physical port number |
/// | 1-2 | Vendor ID, little-endian |
/// | 3-6 | Serial number, little-endian |
///
/// Source: ICP DAS I-7242D manual p. 93; CIP Vol. 3. Bit 7 set is refused: it would be a check *response*.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct WhoResponse {
    /// The port of the faulted node.
    pub port: PortNumber,
    /// The faulted node.
    pub device: DeviceIdentity,
}

/// Identify request, short (multicast) form, 0x7ED: is there a faulted node among these?
///
/// | Byte | Content |
/// |---|---|
/// | 0 | [`NodeSelection`] |
/// | 1 | 0x4C |
///
/// Source: CIP Vol. 3, offline connection set.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct IdentifyRequest {
    /// Who shall answer.
    pub nodes: NodeSelection,
}

/// Identify request, long (point-to-point) form, 0x7ED: the device shall flash its network status indicator red and
/// green.
///
/// | Byte | Content |
/// |---|---|
/// | 0 | 0x3F |
/// | 1 | 0x4C |
/// | 2-3 | Vendor ID, little-endian |
/// | 4-7 | Serial number, little-endian |
///
/// Source: CIP Vol. 3, offline connection set.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct IdentifyDeviceRequest {
    /// The device that is meant.
    pub device: DeviceIdentity,
}

/// Identify response, 0x7EC. All nodes that answer send the same bits, so that they can do so at once.
///
/// | Byte | Content |
/// |---|---|
/// | 0 | byte 0 of the request |
/// | 1 | 0xCC |
///
/// Source: CIP Vol. 3, offline connection set.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct IdentifyResponse {
    /// Who was asked.
    pub nodes: NodeSelection,
}

/// Change_MAC_ID request, 0x7ED. There is no response: the device starts anew with the MAC ID, and its duplicate MAC ID
/// checks are the sign of success.
///
/// | Byte | Content |
/// |---|---|
/// | 0 | bits 5-0 new MAC ID; bits 7-6 reserved, 0 |
/// | 1 | 0x4D |
/// | 2-3 | Vendor ID of the device, little-endian |
/// | 4-7 | Serial number of the device, little-endian |
///
/// Source: CIP Vol. 3, offline connection set.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ChangeMacIdRequest {
    /// The MAC ID that it shall use.
    pub mac: MacId,
    /// The device that is meant.
    pub device: DeviceIdentity,
}

/// Any message on 0x7ED, told apart by service and length.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum CommunicationFaultedRequest {
    /// 0x4B, 3 bytes.
    Who(WhoRequest),
    /// 0x4C, 2 bytes.
    Identify(IdentifyRequest),
    /// 0x4C, 8 bytes.
    IdentifyDevice(IdentifyDeviceRequest),
    /// 0x4D, 8 bytes.
    ChangeMacId(ChangeMacIdRequest),
}

/// Any message on 0x7EC, told apart by its length.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum CommunicationFaultedResponse {
    /// 7 bytes.
    Who(WhoResponse),
    /// 2 bytes.
    Identify(IdentifyResponse),
}

impl Wire<'_> for OfflineOwnership {
    const NAME: &'static str = "Offline Ownership";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        let client = mac_id(reader, "client MAC ID")?;
        let direction = service_of_either_direction(reader, ALLOCATE_OR_WHO)?;
        Ok(Self { direction, client, device: DeviceIdentity::read(reader)? })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u8(self.client.number())?;
        out.u8(ALLOCATE_OR_WHO.request_byte() | self.direction.bit())?;
        self.device.emit(out)
    }

    fn wire_len(&self) -> usize {
        8
    }
}

impl Wire<'_> for WhoRequest {
    const NAME: &'static str = "Who request";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        let nodes = NodeSelection::read(reader)?;
        service(reader, ALLOCATE_OR_WHO, Direction::Request)?;
        let offset = reader.offset();
        let byte = reader.u8("time delay byte offset")?;
        let delay_offset = DelayOffset::new(byte);
        let delay_offset =
            delay_offset.ok_or(ParseError::value("time delay byte offset", offset, byte.into()))?;
        Ok(Self { nodes, delay_offset })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u8(self.nodes.byte())?;
        out.u8(ALLOCATE_OR_WHO.request_byte())?;
        out.u8(self.delay_offset.number())
    }

    fn wire_len(&self) -> usize {
        3
    }
}

impl Wire<'_> for WhoResponse {
    const NAME: &'static str = "Who response";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        let offset = reader.offset();
        let byte = reader.u8("port number")?;
        let port = PortNumber::new(byte).ok_or(ParseError::value("port number", offset, byte.into()))?;
        Ok(Self { port, device: DeviceIdentity::read(reader)? })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u8(self.port.number())?;
        self.device.emit(out)
    }

    fn wire_len(&self) -> usize {
        7
    }
}

impl Wire<'_> for IdentifyRequest {
    const NAME: &'static str = "Identify request";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        let nodes = NodeSelection::read(reader)?;
        service(reader, IDENTIFY, Direction::Request)?;
        Ok(Self { nodes })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u8(self.nodes.byte())?;
        out.u8(IDENTIFY.request_byte())
    }

    fn wire_len(&self) -> usize {
        2
    }
}

impl Wire<'_> for IdentifyDeviceRequest {
    const NAME: &'static str = "Identify request to a device";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        constant(reader, "byte 0 of the long form", ALL_NODES)?;
        service(reader, IDENTIFY, Direction::Request)?;
        Ok(Self { device: DeviceIdentity::read(reader)? })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u8(ALL_NODES)?;
        out.u8(IDENTIFY.request_byte())?;
        self.device.emit(out)
    }

    fn wire_len(&self) -> usize {
        8
    }
}

impl Wire<'_> for IdentifyResponse {
    const NAME: &'static str = "Identify response";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        let nodes = NodeSelection::read(reader)?;
        service(reader, IDENTIFY, Direction::Response)?;
        Ok(Self { nodes })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u8(self.nodes.byte())?;
        out.u8(IDENTIFY.response_byte())
    }

    fn wire_len(&self) -> usize {
        2
    }
}

impl Wire<'_> for ChangeMacIdRequest {
    const NAME: &'static str = "Change_MAC_ID request";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        let mac = mac_id(reader, "new MAC ID")?;
        service(reader, CHANGE_MAC_ID, Direction::Request)?;
        Ok(Self { mac, device: DeviceIdentity::read(reader)? })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u8(self.mac.number())?;
        out.u8(CHANGE_MAC_ID.request_byte())?;
        self.device.emit(out)
    }

    fn wire_len(&self) -> usize {
        8
    }
}

impl Wire<'_> for CommunicationFaultedRequest {
    const NAME: &'static str = "Communication Faulted request";
    /// The short Identify is a prefix of the long one.
    const TAIL: Tail = Tail::Open;

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        match *reader.peek() {
            [_, 0x4B, ..] => WhoRequest::read(reader).map(Self::Who),
            [_, 0x4C] => IdentifyRequest::read(reader).map(Self::Identify),
            [_, 0x4C, ..] => IdentifyDeviceRequest::read(reader).map(Self::IdentifyDevice),
            [_, 0x4D, ..] => ChangeMacIdRequest::read(reader).map(Self::ChangeMacId),
            [_, service, ..] => {
                Err(ParseError::value("service", reader.offset().saturating_add(1), service.into()))
            }
            [] | [_] => Err(ParseError {
                field: "service",
                offset: reader.offset().saturating_add(1),
                kind: ParseErrorKind::Short { expected: 1, found: 0 },
            }),
        }
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        match self {
            Self::Who(message) => message.emit(out),
            Self::Identify(message) => message.emit(out),
            Self::IdentifyDevice(message) => message.emit(out),
            Self::ChangeMacId(message) => message.emit(out),
        }
    }

    fn wire_len(&self) -> usize {
        match self {
            Self::Who(message) => message.wire_len(),
            Self::Identify(message) => message.wire_len(),
            Self::IdentifyDevice(message) => message.wire_len(),
            Self::ChangeMacId(message) => message.wire_len(),
        }
    }
}

impl Wire<'_> for CommunicationFaultedResponse {
    const NAME: &'static str = "Communication Faulted response";
    /// Nothing but the length tells the two apart.
    const TAIL: Tail = Tail::Open;

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        if reader.remaining() <= 2 {
            return IdentifyResponse::read(reader).map(Self::Identify);
        }
        WhoResponse::read(reader).map(Self::Who)
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        match self {
            Self::Who(message) => message.emit(out),
            Self::Identify(message) => message.emit(out),
        }
    }

    fn wire_len(&self) -> usize {
        match self {
            Self::Who(message) => message.wire_len(),
            Self::Identify(message) => message.wire_len(),
        }
    }
}

/// Allocate_Offline_Connection_Set on 0x7EE and 0x7EF, and Who on 0x7ED.
const ALLOCATE_OR_WHO: ServiceCode = ServiceCode(0x4B);
const IDENTIFY: ServiceCode = ServiceCode(0x4C);
const CHANGE_MAC_ID: ServiceCode = ServiceCode(0x4D);
/// Byte 0 of the long Identify.
const ALL_NODES: u8 = 0x3F;
