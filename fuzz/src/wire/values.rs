//! Any value of each message: emitted and read back, within exactly the bytes that it says.
//!
//! A wire type without a generator here does not compile.

use arbitrary::{Result, Unstructured};
use cip_core::code::{
    AdditionalCode, AttributeId, ClassId, DataTypeCode, DeviceType, GeneralStatus, InstanceId, ServiceCode,
    VendorId,
};
use cip_core::codec::{Wire, Writer, laws};
use cip_core::epath::{ElectronicKey, Epath, ExtendedSymbol, LogicalKind, PathForm, Segment, Width};
use cip_core::message::*;

/// Makes one value of every message and checks the laws on it.
pub(super) fn check(input: &mut Unstructured<'_>) -> Result<()> {
    macro_rules! each {
        ($($Type:ty)*) => { $( <$Type as Generated>::check(input)?; )* };
    }
    super::for_each_wire_type!(each);
    request(input)?;
    attribute_request(input)?;
    segment(input)
}

/// A type of which values can be made from bytes.
trait Generated {
    /// Makes a value and checks the laws on it.
    fn check(input: &mut Unstructured<'_>) -> Result<()>;
}

/// Implements [`Generated`] by an expression that makes a value from `$input`.
macro_rules! generated {
    ($($Type:ty: |$input:ident| $value:expr;)*) => {$(
        impl Generated for $Type {
            fn check($input: &mut Unstructured<'_>) -> Result<()> {
                let mut buffer = [0; CAPACITY];
                laws::round_trip(&$value, &mut buffer);
                Ok(())
            }
        }
    )*};
}

/// As [`generated`], for messages without public fields: an expression for the bytes of a valid one.
macro_rules! generated_as_bytes {
    ($($Type:ident: |$input:ident| $bytes:expr;)*) => {$(
        impl Generated for $Type<'_> {
            fn check($input: &mut Unstructured<'_>) -> Result<()> {
                let mut buffer = [0; CAPACITY];
                let bytes = $bytes;
                laws::round_trip(&$Type::parse(&bytes).expect("a valid message"), &mut buffer);
                Ok(())
            }
        }
    )*};
}

generated! {
    AllocateRequest: |input| AllocateRequest { choice: choice(input)?, allocator: input.arbitrary()? };
    AllocateResponse: |input| AllocateResponse { body_format: input.arbitrary::<u8>()? & 0x0F };
    CreateResponse<'_>: |input| CreateResponse { instance: InstanceId(input.arbitrary()?), data: free(input)? };
    FindNextRequest: |input| FindNextRequest { max: input.arbitrary()? };
    MemberId: |input| MemberId(input.arbitrary()?);
    MemberRequest<'_>: |input| MemberRequest {
        attribute: input.arbitrary()?,
        member: input.arbitrary()?,
        value: free(input)?,
    };
    ReleaseRequest: |input| ReleaseRequest { choice: choice(input)? };
    ResetRequest: |input| ResetRequest { kind: input.arbitrary::<Option<u8>>()?.map(ResetType) };
    Response<'_>: |input| response(input)?;
}

generated_as_bytes! {
    AttributeReplies: |input| [&input.arbitrary::<[u8; 2]>()?[..], free(input)?].concat();
    AttributeStatusList: |input| counted::<2>(items(input, 4)?, 4);
    InstanceList: |input| counted::<1>(items(input, 2)?, 2);
    UintList: |input| counted::<2>(items(input, 2)?, 2);
    MultipleServicePacket: |input| {
        let services = [free(input)?, free(input)?, free(input)?];
        let mut buffer = [0; 128];
        let mut out = Writer::new(&mut buffer);
        emit_packets(&services[..input.int_in_range(0..=3)?], &mut out).expect("room enough");
        out.written().to_vec()
    };
}

fn choice(input: &mut Unstructured<'_>) -> Result<AllocationChoice> {
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

/// A request in each body format that can address its object.
fn request(input: &mut Unstructured<'_>) -> Result<()> {
    let (service, _) = ServiceCode::split(input.arbitrary()?);
    let (class, instance) = (ClassId(input.arbitrary()?), InstanceId(input.arbitrary()?));
    let request = Request::new(service, class, instance, free(input)?);
    for format in BodyFormat::ALL {
        let mut buffer = [0; CAPACITY];
        let mut out = Writer::new(&mut buffer);
        let emitted = request.emit(format, &mut out);
        let addressable = format.can_address(class, instance);
        assert_eq!(emitted.is_ok(), addressable, "{request:?} as {format}: {emitted:?}");
        if emitted.is_err() {
            assert!(out.is_empty(), "a failed request leaves nothing behind");
            continue;
        }
        assert_eq!(out.len(), request.wire_len(format), "{request:?} as {format}");
        let read = Request::parse(format, out.written()).expect("what was emitted");
        assert_eq!((read.service, read.data), (service, request.data));
        assert_eq!((read.target.class(), read.target.instance()), (Some(class), Some(instance)), "{format}");
    }
    Ok(())
}

/// An attribute is found again, wherever the format puts it.
fn attribute_request(input: &mut Unstructured<'_>) -> Result<()> {
    let request = AttributeRequest {
        service: ServiceCode::split(input.arbitrary()?).0,
        class: ClassId(input.arbitrary()?),
        instance: InstanceId(input.arbitrary()?),
        attribute: AttributeId(input.arbitrary::<u16>()? & 0x1FF),
        value: free(input)?,
    };
    for format in BodyFormat::ALL {
        let mut buffer = [0; CAPACITY];
        let mut out = Writer::new(&mut buffer);
        if request.emit(format, &mut out).is_err() {
            assert!(out.is_empty(), "a failed request leaves nothing behind");
            continue;
        }
        let read = Request::parse(format, out.written()).expect("what was emitted");
        let expected = AttributeAccess { attribute: request.attribute, value: request.value };
        assert_eq!(read.attribute_access(), Ok(expected), "{request:?} as {format}");
    }
    Ok(())
}

/// A segment of each kind, alone in a path of each form.
fn segment(input: &mut Unstructured<'_>) -> Result<()> {
    let segment = any_segment(input)?;
    for form in [PathForm::Packed, PathForm::Padded] {
        let mut buffer = [0; CAPACITY];
        let mut out = Writer::new(&mut buffer);
        assert_eq!(segment.emit(form, &mut out), Ok(()), "{segment:?}");
        let path = match form {
            PathForm::Packed => Epath::packed(out.written()),
            PathForm::Padded => Epath::padded(out.written()),
        };
        assert!(path.segments().eq([Ok(segment)]), "{segment:?} as {path:?}");
        for len in 1..path.bytes().len() {
            let mut cut = Segment::read(&mut cip_core::codec::Reader::new(&path.bytes()[..len]), form);
            assert!(cut.as_mut().is_err(), "{len} bytes of {path:?}");
        }
    }
    Ok(())
}

fn any_segment<'a>(input: &mut Unstructured<'a>) -> Result<Segment<'a>> {
    Ok(match input.int_in_range(0..=9)? {
        0 => Segment::Port { port: input.arbitrary()?, link: free(input)? },
        1 => logical(input)?,
        2 => Segment::ElectronicKey(ElectronicKey {
            vendor: VendorId(input.arbitrary()?),
            device_type: DeviceType(input.arbitrary()?),
            product_code: input.arbitrary()?,
            compatible: input.arbitrary()?,
            major: input.arbitrary::<u8>()? & 0x7F,
            minor: input.arbitrary()?,
        }),
        3 => match input.arbitrary::<u8>()? & 0x1F {
            short @ 0..=0x0F => {
                Segment::Network { subtype: short, data: items(input, 1)?.get(..1).unwrap_or(&[0]) }
            }
            long => Segment::Network { subtype: long, data: items(input, 2)? },
        },
        4 => match free(input)? {
            [] => Segment::Symbol(b"A"),
            name => Segment::Symbol(name),
        },
        5 => {
            let (size, format) =
                *input.choose(&[(1, 0xC6), (2, 0xC7), (4, 0xC8), (2, 0x21), (6, 0x42), (62, 0x3F)])?;
            let data = items(input, 1)?.get(..size).unwrap_or(&[0; 62][..size]);
            Segment::ExtendedSymbol(ExtendedSymbol { format, data })
        }
        6 => Segment::Data(items(input, 2)?),
        7 => Segment::AnsiSymbol(free(input)?),
        8 => Segment::ConstructedType { code: 0xA0 | (input.arbitrary::<u8>()? & 0x1F), data: free(input)? },
        _ => Segment::ElementaryType(DataTypeCode(0xC0 | (input.arbitrary::<u8>()? & 0x1F))),
    })
}

fn logical<'a>(input: &mut Unstructured<'a>) -> Result<Segment<'a>> {
    let kind = *input.choose(&[
        LogicalKind::Class,
        LogicalKind::Instance,
        LogicalKind::Member,
        LogicalKind::ConnectionPoint,
        LogicalKind::Attribute,
        LogicalKind::Service,
    ])?;
    let value: u32 = input.arbitrary()?;
    Ok(match *input.choose(&[Width::Bits8, Width::Bits16, Width::Bits32])? {
        _ if kind == LogicalKind::Service => {
            Segment::Logical { kind, width: Width::Bits8, value: value & 0xFF }
        }
        Width::Bits8 => Segment::Logical { kind, width: Width::Bits8, value: value & 0xFF },
        Width::Bits16 => Segment::Logical { kind, width: Width::Bits16, value: value & 0xFFFF },
        Width::Bits32 => Segment::Logical { kind, width: Width::Bits32, value },
    })
}

/// Up to 31 bytes of free data.
fn free<'a>(input: &mut Unstructured<'a>) -> Result<&'a [u8]> {
    let len = usize::from(input.arbitrary::<u8>()? & 0x1F).min(input.len());
    input.bytes(len)
}

/// A whole number of items of `size` bytes.
fn items<'a>(input: &mut Unstructured<'a>, size: usize) -> Result<&'a [u8]> {
    let len = free(input)?;
    Ok(&len[..len.len() / size * size])
}

/// `items` of `size` bytes with their number in `N` bytes in front.
fn counted<const N: usize>(items: &[u8], size: usize) -> Vec<u8> {
    let count = (items.len() / size).to_le_bytes();
    [&count[..N], items].concat()
}

const CAPACITY: usize = 256;
