//! Messages of DeviceNeX.

use arbitrary::{Result, Unstructured};
use cip_core::code::{AdditionalCode, GeneralStatus, InstanceId, VendorId};
use cip_core::codec::laws;
use cip_core::connection::WatchdogAction;
use cip_core::fragment::{AckStatus, FragmentByte, FragmentKind};
use devicenex_core::OperationalAddress;
use devicenex_core::id::MessageId;
use devicenex_core::message::{
    ConnectionRequest, ConnectionResponse, ConnectionlessRequest, ConnectionlessResponse, ErrorResponse,
    ExplicitMessage, FirstFragment, FormatByte, FragmentAcknowledge, Granted, GroupSelect, HelloData,
    ImplicitFragment, NextFragment, PortByte, RestOfIdentity, RoamData, Target,
};

use super::{at_most, generated};

generated! { owned
    HelloData: |input| HelloData { device: device(input)?, port: PortByte(input.arbitrary()?) };
    RoamData: |input| RoamData {
        target: device(input)?,
        requested: OperationalAddress::from_low_bits(input.arbitrary()?),
    };
    ConnectionRequest: |input| ConnectionRequest {
        predefined: input.arbitrary()?,
        group: group(input)?,
        source_message: message(input)?,
        target: target(input)?,
    };
    ConnectionResponse: |input| ConnectionResponse {
        group: group(input)?,
        source_message: message(input)?,
        body_format: FormatByte(input.arbitrary()?),
        granted: match input.arbitrary()? {
            true => Granted::Predefined { expected_packet_rate: input.arbitrary()? },
            false => Granted::Dynamic { instance: InstanceId(input.arbitrary()?) },
        },
    };
    ErrorResponse: |input| ErrorResponse {
        general: GeneralStatus(input.arbitrary()?),
        additional: AdditionalCode(input.arbitrary()?),
    };
    ConnectionlessRequest: |input| ConnectionlessRequest {
        class: input.arbitrary()?,
        instance: input.arbitrary()?,
        attribute: input.arbitrary()?,
    };
    FirstFragment: |input| FirstFragment { transaction: input.arbitrary()?, body: input.arbitrary()? };
    FragmentAcknowledge: |input| FragmentAcknowledge { status: AckStatus::from(input.arbitrary::<u8>()?) };
}

generated! {
    ConnectionlessResponse: |input| ConnectionlessResponse { value: at_most(7, input)? };
    ExplicitMessage: |input| ExplicitMessage { body: body(input)? };
    NextFragment: |input| NextFragment { body: body(input)? };
    ImplicitFragment: |input| ImplicitFragment { fragment: fragment(input)?, data: at_most(7, input)? };
}

fn device(input: &mut Unstructured<'_>) -> Result<RestOfIdentity> {
    Ok(RestOfIdentity {
        serial_high: input.arbitrary()?,
        vendor: VendorId(input.arbitrary()?),
        product_code: input.arbitrary()?,
        major_revision: input.arbitrary()?,
    })
}

fn group(input: &mut Unstructured<'_>) -> Result<GroupSelect> {
    Ok(GroupSelect::new(input.arbitrary::<u8>()? & 7).expect("three bits"))
}

fn message(input: &mut Unstructured<'_>) -> Result<MessageId> {
    Ok(MessageId::from_low_bits(input.arbitrary()?))
}

fn target(input: &mut Unstructured<'_>) -> Result<Option<Target>> {
    if input.arbitrary()? {
        return Ok(None);
    }
    Ok(Some(Target {
        instance: InstanceId(input.arbitrary()?),
        expected_packet_rate: input.arbitrary()?,
        watchdog_action: WatchdogAction(input.arbitrary()?),
    }))
}

/// One to eight bytes.
fn body<'a>(input: &mut Unstructured<'a>) -> Result<&'a [u8]> {
    let bytes = at_most(7, input)?;
    Ok(if bytes.is_empty() { &[0x0E] } else { bytes })
}

/// Not an acknowledge.
fn fragment(input: &mut Unstructured<'_>) -> Result<FragmentByte> {
    let byte = FragmentByte::from(input.arbitrary::<u8>()?);
    let kind = if byte.kind == FragmentKind::Acknowledge { FragmentKind::First } else { byte.kind };
    Ok(FragmentByte::new(kind, byte.count()))
}
