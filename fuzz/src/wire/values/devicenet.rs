//! Messages of DeviceNet.

use arbitrary::{Result, Unstructured};
use cip_core::code::{AdditionalCode, ClassId, GeneralStatus, InstanceId, VendorId};
use cip_core::codec::laws;
use cip_core::fragment::{AckStatus, FragmentByte, FragmentKind};
use cip_core::message::{AllocateRequest, AllocateResponse, ReleaseRequest};
use devicenet_core::MacId;
use devicenet_core::message::{
    BitStrobeCommand, ChangeMacIdRequest, CloseRequest, CloseResponse, CommunicationFaultedRequest,
    CommunicationFaultedResponse, DelayOffset, DeviceIdentity, DeviceState, Direction, DuplicateMacCheck,
    EmptyIo, ErrorResponse, ExplicitFragment, ExplicitHeader, ExplicitMessage, FormatByte,
    FragmentAcknowledge, GroupSelect, Heartbeat, HeartbeatFlags, IdentifyDeviceRequest, IdentifyRequest,
    IdentifyResponse, IoFragment, Mask, MessageId, NodeSelection, OfflineOwnership, OpenRequest,
    OpenResponse, PortNumber, Shutdown, ShutdownCode, UnconnectedAllocate, UnconnectedAllocateResponse,
    UnconnectedRelease, UnconnectedReleaseResponse, WhoRequest, WhoResponse,
};

use super::cip::choice;
use super::{at_most, generated};

generated! { owned
    BitStrobeCommand: |input| BitStrobeCommand::from_bits(input.arbitrary()?);
    ChangeMacIdRequest: |input| change_mac_id(input)?;
    CloseRequest: |input| CloseRequest { xid: xid(input)?, server: mac(input)?, connection: instance(input)? };
    CloseResponse: |input| CloseResponse { xid: xid(input)?, client: mac(input)? };
    CommunicationFaultedRequest: |input| match input.arbitrary::<u8>()? & 3 {
        0 => CommunicationFaultedRequest::Who(who(input)?),
        1 => CommunicationFaultedRequest::Identify(IdentifyRequest { nodes: nodes(input)? }),
        2 => CommunicationFaultedRequest::IdentifyDevice(IdentifyDeviceRequest { device: device(input)? }),
        _ => CommunicationFaultedRequest::ChangeMacId(change_mac_id(input)?),
    };
    CommunicationFaultedResponse: |input| match input.arbitrary()? {
        true => CommunicationFaultedResponse::Who(WhoResponse { port: port(input)?, device: device(input)? }),
        false => CommunicationFaultedResponse::Identify(IdentifyResponse { nodes: nodes(input)? }),
    };
    DuplicateMacCheck: |input| DuplicateMacCheck {
        direction: direction(input)?,
        port: port(input)?,
        device: device(input)?,
    };
    EmptyIo: |_input| EmptyIo;
    ErrorResponse: |input| ErrorResponse {
        xid: xid(input)?,
        mac: mac(input)?,
        general: GeneralStatus(input.arbitrary()?),
        additional: AdditionalCode(input.arbitrary()?),
    };
    ExplicitHeader: |input| ExplicitHeader { fragmented: xid(input)?, xid: xid(input)?, mac: mac(input)? };
    FragmentAcknowledge: |input| FragmentAcknowledge::new(
        xid(input)?,
        mac(input)?,
        input.arbitrary()?,
        AckStatus::from(input.arbitrary::<u8>()?),
    );
    Heartbeat: |input| Heartbeat {
        node: mac(input)?,
        instance: instance(input)?,
        state: DeviceState(input.arbitrary()?),
        flags: HeartbeatFlags::from_bits_retain(input.arbitrary()?),
        configuration_consistency: input.arbitrary()?,
    };
    IdentifyDeviceRequest: |input| IdentifyDeviceRequest { device: device(input)? };
    IdentifyRequest: |input| IdentifyRequest { nodes: nodes(input)? };
    IdentifyResponse: |input| IdentifyResponse { nodes: nodes(input)? };
    OfflineOwnership: |input| OfflineOwnership {
        direction: direction(input)?,
        client: mac(input)?,
        device: device(input)?,
    };
    OpenRequest: |input| OpenRequest {
        xid: xid(input)?,
        server: mac(input)?,
        body_format: FormatByte(input.arbitrary()?),
        group: GroupSelect::new(input.arbitrary::<u8>()? & 0x0F).expect("four bits"),
        source_message: message_id(input)?,
    };
    OpenResponse: |input| OpenResponse {
        xid: xid(input)?,
        client: mac(input)?,
        body_format: FormatByte(input.arbitrary()?),
        destination_message: message_id(input)?,
        source_message: message_id(input)?,
        connection: instance(input)?,
    };
    Shutdown: |input| Shutdown {
        node: mac(input)?,
        class: ClassId(input.arbitrary()?),
        instance: instance(input)?,
        code: ShutdownCode(input.arbitrary()?),
    };
    UnconnectedAllocate: |input| UnconnectedAllocate {
        xid: xid(input)?,
        requester: mac(input)?,
        body: AllocateRequest { choice: choice(input)?, allocator: input.arbitrary()? },
    };
    UnconnectedAllocateResponse: |input| UnconnectedAllocateResponse {
        xid: xid(input)?,
        requester: mac(input)?,
        body: AllocateResponse::from_code(input.arbitrary::<u8>()? & 0x0F).expect("four bits"),
    };
    UnconnectedRelease: |input| UnconnectedRelease {
        xid: xid(input)?,
        requester: mac(input)?,
        body: ReleaseRequest { choice: choice(input)? },
    };
    UnconnectedReleaseResponse: |input| UnconnectedReleaseResponse { xid: xid(input)?, requester: mac(input)? };
    WhoRequest: |input| who(input)?;
    WhoResponse: |input| WhoResponse { port: port(input)?, device: device(input)? };
}

generated! {
    ExplicitFragment: |input| ExplicitFragment {
        xid: xid(input)?,
        mac: mac(input)?,
        fragment: fragment(input)?,
        body: body(6, input)?,
    };
    ExplicitMessage: |input| ExplicitMessage { xid: xid(input)?, mac: mac(input)?, body: body(7, input)? };
    IoFragment: |input| IoFragment { fragment: fragment(input)?, data: at_most(7, input)? };
}

fn xid(input: &mut Unstructured<'_>) -> Result<bool> {
    input.arbitrary()
}

fn mac(input: &mut Unstructured<'_>) -> Result<MacId> {
    Ok(MacId::new(input.arbitrary::<u8>()? & 0x3F).expect("six bits"))
}

/// One to `most` bytes of a body; a message has at least the service byte.
fn body<'a>(most: usize, input: &mut Unstructured<'a>) -> Result<&'a [u8]> {
    Ok(match at_most(7, input)? {
        [] => &[0x0E],
        body => &body[..body.len().min(most)],
    })
}

fn instance(input: &mut Unstructured<'_>) -> Result<InstanceId> {
    Ok(InstanceId(input.arbitrary()?))
}

fn port(input: &mut Unstructured<'_>) -> Result<PortNumber> {
    Ok(PortNumber::new(input.arbitrary::<u8>()? & 0x7F).expect("seven bits"))
}

fn device(input: &mut Unstructured<'_>) -> Result<DeviceIdentity> {
    Ok(DeviceIdentity { vendor: VendorId(input.arbitrary()?), serial: input.arbitrary()? })
}

fn direction(input: &mut Unstructured<'_>) -> Result<Direction> {
    Ok(if input.arbitrary()? { Direction::Response } else { Direction::Request })
}

fn message_id(input: &mut Unstructured<'_>) -> Result<MessageId> {
    Ok(MessageId::new(input.arbitrary::<u8>()? & 0x0F).expect("four bits"))
}

fn nodes(input: &mut Unstructured<'_>) -> Result<NodeSelection> {
    Ok(match input.arbitrary()? {
        true => NodeSelection::MacId(mac(input)?),
        false => NodeSelection::Mask(Mask::new(input.arbitrary::<u8>()? & 0x3F).expect("six bits")),
    })
}

fn who(input: &mut Unstructured<'_>) -> Result<WhoRequest> {
    let delay_offset = DelayOffset::new(input.arbitrary::<u8>()? % 7).expect("0 to 6");
    Ok(WhoRequest { nodes: nodes(input)?, delay_offset })
}

fn change_mac_id(input: &mut Unstructured<'_>) -> Result<ChangeMacIdRequest> {
    Ok(ChangeMacIdRequest { mac: mac(input)?, device: device(input)? })
}

fn fragment(input: &mut Unstructured<'_>) -> Result<FragmentByte> {
    let kind = match input.arbitrary::<u8>()? % 3 {
        0 => FragmentKind::First,
        1 => FragmentKind::Middle,
        _ => FragmentKind::Last,
    };
    Ok(FragmentByte::new(kind, input.arbitrary()?))
}
