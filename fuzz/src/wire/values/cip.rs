//! Messages of CIP.

use arbitrary::{Result, Unstructured};
use cip_core::code::{AdditionalCode, DeviceType, GeneralStatus, InstanceId, ServiceCode, VendorId};
use cip_core::codec::{Wire, Writer, laws};
use cip_core::identity::{
    DeviceIdentity, DeviceState, IdentityAttributes, IdentityStatus, OptionalAttributes, ProductName,
    Revision,
};
use cip_core::message::{
    AllocateRequest, AllocateResponse, AllocationChoice, AttributeReplies, AttributeSettings,
    AttributeStatusList, CreateResponse, FindNextRequest, InstanceList, MemberId, MemberRequest,
    MultipleServicePacket, ReleaseRequest, ResetRequest, ResetType, Response, UintList, emit_packets,
};

use super::{at_most, free, generated, items};

generated! { owned
    AllocateRequest: |input| AllocateRequest { choice: choice(input)?, allocator: input.arbitrary()? };
    AllocateResponse: |input| AllocateResponse::from_code(input.arbitrary::<u8>()? & 0x0F).expect("four bits");
    FindNextRequest: |input| FindNextRequest { max: input.arbitrary()? };
    IdentityAttributes: |input| identity_attributes(input)?;
    MemberId: |input| MemberId(input.arbitrary()?);
    ProductName: |input| product_name(input)?;
    ReleaseRequest: |input| ReleaseRequest { choice: choice(input)? };
    ResetRequest: |input| ResetRequest { kind: input.arbitrary::<Option<u8>>()?.map(ResetType) };
    Revision: |input| Revision { major: input.arbitrary()?, minor: input.arbitrary()? };
}

generated! {
    CreateResponse: |input| CreateResponse { instance: InstanceId(input.arbitrary()?), data: free(input)? };
    MemberRequest: |input| MemberRequest {
        attribute: input.arbitrary()?,
        member: input.arbitrary()?,
        value: free(input)?,
    };
    Response: |input| response(input)?;
}

/// For messages that only their own bytes make: an expression for the bytes of a valid one.
macro_rules! generated_as_bytes {
    ($($Type:ident: |$input:ident| $bytes:expr;)*) => {$(
        impl super::Generated for $Type<'_> {
            fn check($input: &mut Unstructured<'_>) -> Result<()> {
                let mut buffer = [0; super::CAPACITY];
                let bytes = $bytes;
                laws::round_trip(&$Type::parse(&bytes).expect("a valid message"), &mut buffer);
                Ok(())
            }
        }
    )*};
}

generated_as_bytes! {
    AttributeReplies: |input| [&input.arbitrary::<[u8; 2]>()?[..], free(input)?].concat();
    AttributeSettings: |input| [&input.arbitrary::<[u8; 2]>()?[..], free(input)?].concat();
    AttributeStatusList: |input| counted::<2>(items(4, input)?, 4);
    InstanceList: |input| counted::<1>(items(2, input)?, 2);
    MultipleServicePacket: |input| packet(input)?;
    UintList: |input| counted::<2>(items(2, input)?, 2);
}

pub(super) fn choice(input: &mut Unstructured<'_>) -> Result<AllocationChoice> {
    Ok(AllocationChoice::from_bits_retain(input.arbitrary()?))
}

fn response<'a>(input: &mut Unstructured<'a>) -> Result<Response<'a>> {
    let (service, _) = ServiceCode::split(input.arbitrary()?);
    if service == ServiceCode::ERROR_RESPONSE {
        let (status, additional) = (GeneralStatus(input.arbitrary()?), AdditionalCode(input.arbitrary()?));
        return Ok(Response::Error { status, additional });
    }
    Ok(Response::Success { service, data: free(input)? })
}

fn product_name(input: &mut Unstructured<'_>) -> Result<ProductName> {
    Ok(ProductName::from_bytes(at_most(0x1F, input)?).expect("at most 32 characters"))
}

fn identity_attributes(input: &mut Unstructured<'_>) -> Result<IdentityAttributes> {
    let identity = DeviceIdentity {
        vendor: VendorId(input.arbitrary()?),
        device_type: DeviceType(input.arbitrary()?),
        product_code: input.arbitrary()?,
        revision: Revision { major: input.arbitrary()?, minor: input.arbitrary()? },
        serial: input.arbitrary()?,
        name: product_name(input)?,
    };
    let status = IdentityStatus::from_bits_retain(input.arbitrary()?);
    let (state, consistency) = (DeviceState(input.arbitrary()?), input.arbitrary()?);
    let optional = match input.arbitrary::<u8>()? & 3 {
        0 => OptionalAttributes::None,
        1 => OptionalAttributes::State(state),
        2 => OptionalAttributes::Consistency(state, consistency),
        _ => OptionalAttributes::Heartbeat(state, consistency, input.arbitrary()?),
    };
    Ok(IdentityAttributes { identity, status, optional })
}

fn packet(input: &mut Unstructured<'_>) -> Result<Vec<u8>> {
    let services = [free(input)?, free(input)?, free(input)?];
    let mut buffer = [0; 128];
    let mut out = Writer::new(&mut buffer);
    emit_packets(&services[..usize::from(input.arbitrary::<u8>()? & 3)], &mut out).expect("room enough");
    let packet = MultipleServicePacket::parse(out.written()).expect("what was emitted");
    assert!(packet.services().eq(services.into_iter().take(packet.services().count())));
    Ok(out.written().to_vec())
}

/// `items` of `size` bytes with their number in `N` bytes in front.
fn counted<const N: usize>(items: &[u8], size: usize) -> Vec<u8> {
    let count = (items.len() / size).to_le_bytes();
    [&count[..N], items].concat()
}
