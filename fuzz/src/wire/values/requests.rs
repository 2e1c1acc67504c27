//! Requests, whose layout depends on the body format of the connection.

use arbitrary::{Result, Unstructured};
use cip_core::code::{AttributeId, ClassId, InstanceId, ServiceCode};
use cip_core::codec::Writer;
use cip_core::message::{AttributeAccess, AttributeRequest, BodyFormat, Request};

use super::{CAPACITY, free};

/// Makes two requests and checks them in every format.
pub(super) fn check(input: &mut Unstructured<'_>) -> Result<()> {
    request(input)?;
    attribute_request(input)
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
