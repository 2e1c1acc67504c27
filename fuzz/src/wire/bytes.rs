//! Any bytes in the role of each message: refused, or accepted and emitted again as they were.

use std::fmt::{Debug, Display};

use cip_core::code::{
    AdditionalCode, AttributeId, ClassId, DataTypeCode, DeviceType, GeneralStatus, InstanceId, ServiceCode,
    VendorId,
};
use cip_core::codec::{Tail, Wire, Writer, laws};
use cip_core::epath::{Epath, LogicalPath, PathForm, Segment};
use cip_core::message::{
    AllocationChoice, AttributeReplies, AttributeSettings, AttributeStatusList, BodyFormat, EmitError,
    InstanceList, MultipleServicePacket, Request, Response, UintList,
};

/// Tries `data` as every message that there is.
pub(super) fn check(data: &[u8]) {
    macro_rules! cip {
        ($($Type:ty),*) => { $( wire_type::<$Type>(data); )* };
    }
    macro_rules! devicenet {
        ($($Type:ident),*) => { $( wire_type::<devicenet_core::message::$Type>(data); )* };
    }
    macro_rules! devicenex {
        ($($Type:ident),*) => { $( wire_type::<devicenex_core::message::$Type>(data); )* };
    }
    cip_core::for_each_wire_type!(cip);
    devicenex_core::for_each_wire_type!(devicenex);
    devicenet_core::for_each_wire_type!(devicenet);
    BodyFormat::ALL.into_iter().for_each(|format| request(format, data));
    views(data);
    path(Epath::packed(data));
    path(Epath::padded(data));
    codes(data);
}

fn wire_type<'a, T>(data: &'a [u8])
where
    T: Wire<'a> + Debug + PartialEq,
{
    // One byte more than the message, because the laws look behind its end.
    let mut buffer = [0; CAPACITY];
    let data = &data[..data.len().min(CAPACITY - 1)];
    if laws::accepted_bytes_survive::<T>(data, &mut buffer) {
        closed::<T>(data);
        if data.len() <= PRINTED {
            let _ = format!("{:?}", T::parse(data));
        }
    }
}

/// Every strict prefix and every trailing byte of a closed type is refused.
fn closed<'a, T: Wire<'a> + Debug>(data: &'a [u8]) {
    if T::TAIL == Tail::Open {
        return;
    }
    for len in 0..data.len() {
        assert!(T::parse(&data[..len]).is_err(), "{len} bytes of {} {data:02X?}", T::NAME);
    }
}

fn request(format: BodyFormat, data: &[u8]) {
    let Ok(request) = Request::parse(format, data) else { return };
    let mut buffer = vec![0; data.len()];
    let mut out = Writer::new(&mut buffer);
    assert_eq!(request.emit(format, &mut out), Ok(()), "{request:?}");
    assert_eq!(out.written(), data, "emit(parse(b)) == b, of {request:?}");
    assert_eq!(request.wire_len(format), data.len(), "{request:?}");
    if let Some(short) = data.len().checked_sub(1) {
        let mut out = Writer::new(&mut buffer[..short]);
        assert!(matches!(request.emit(format, &mut out), Err(EmitError::Full(_))), "{request:?}");
        assert!(out.is_empty(), "a failed request leaves nothing behind");
    }
    shown(&request);
    if let Ok(access) = request.attribute_access() {
        assert!(data.ends_with(access.value), "{access:?} is the end of {data:02X?}");
    }
    if let (Some(class), Some(instance)) = (request.target.class(), request.target.instance()) {
        assert!(format == BodyFormat::CipPath || format.can_address(class, instance), "{request:?}");
    }
}

/// What the accessors of the variable messages hand out lies within the message.
fn views(data: &[u8]) {
    if let Ok(list) = UintList::parse(data) {
        assert_eq!(list.iter().len() * 2 + 2, data.len());
        shown(&list);
    }
    if let Ok(list) = InstanceList::parse(data) {
        assert_eq!(list.iter().len() * 2 + 1, data.len());
    }
    if let Ok(list) = AttributeStatusList::parse(data) {
        assert_eq!(list.iter().len() * 4 + 2, data.len());
    }
    let len = |attribute: AttributeId, _: &[u8]| (attribute.0 < 8).then_some(attribute.0.into());
    if let Ok(list) = AttributeReplies::parse(data) {
        entries(list.count(), list.iter(len));
    }
    if let Ok(list) = AttributeSettings::parse(data) {
        entries(list.count(), list.iter(len));
    }
    if let Ok(packet) = MultipleServicePacket::parse(data) {
        let bytes: usize = packet.services().map(<[u8]>::len).sum();
        assert_eq!(2 + 2 * packet.services().count() + bytes, packet.wire_len());
    }
    if let Ok(response) = Response::parse(data) {
        shown(&response);
    }
}

/// As many entries as the list says, unless an error ends it.
fn entries<T, E>(count: u16, entries: impl Iterator<Item = Result<T, E>>) {
    let mut good = 0;
    let mut failed = false;
    for entry in entries {
        assert!(!failed, "nothing comes after an error");
        failed = entry.is_err();
        good += u16::from(entry.is_ok());
    }
    assert!(if failed { good <= count } else { good == count }, "{good} of {count}");
}

/// A path is its segments, one after another, whether all of them can be read or not.
fn path(path: Epath<'_>) {
    let mut rest = path.bytes();
    let mut buffer = vec![0; rest.len() + 2];
    let mut malformed = false;
    for segment in path.segments() {
        assert!(!malformed, "nothing comes after an error");
        let Ok(segment) = segment else {
            malformed = true;
            continue;
        };
        shown(&segment);
        let mut out = Writer::new(&mut buffer);
        assert_eq!(segment.emit(path.form(), &mut out), Ok(()), "{segment:?}");
        let emitted = out.written();
        if let Some(after) = rest.strip_prefix(emitted) {
            rest = after;
        } else {
            // A port can be written in a longer way than needed; it means the same.
            assert!(matches!(segment, Segment::Port { .. }), "{segment:?} from {rest:02X?}");
            assert_eq!(only_segment(emitted, path.form()), Some(segment));
            return;
        }
    }
    assert_eq!(rest.is_empty(), !malformed, "{rest:02X?} of {path:?}");
    assert!(!malformed || path.to_string().contains("malformed "), "{path}");
    if let Ok(logical) = path.logical() {
        assert!(!malformed, "{path:?}");
        logical_path(logical);
    }
}

fn only_segment(bytes: &[u8], form: PathForm) -> Option<Segment<'_>> {
    let path = if form == PathForm::Packed { Epath::packed(bytes) } else { Epath::padded(bytes) };
    let mut segments = path.segments();
    let segment = segments.next()?.ok();
    assert!(segments.next().is_none());
    segment
}

/// The shortest path to the same IDs, and the shortest of whole words, name the same IDs.
fn logical_path(logical: LogicalPath) {
    let mut buffer = [0; 32];
    let mut out = Writer::new(&mut buffer);
    logical.emit(PathForm::Packed, &mut out).expect("five IDs of at most five bytes");
    assert_eq!(out.len(), logical.packed_len());
    assert_eq!(Epath::packed(out.written()).logical(), Ok(logical));
    let mut out = Writer::new(&mut buffer);
    logical.emit(PathForm::Padded, &mut out).expect("five IDs of at most six bytes");
    assert_eq!(Epath::padded(out.written()).logical(), Ok(logical));
    let mut out = Writer::new(&mut buffer);
    if logical.emit_words(&mut out).expect("no longer than 32 bytes").is_ok() {
        assert!(out.len().is_multiple_of(2), "{logical:?}");
        assert_eq!(Epath::packed(out.written()).logical(), Ok(logical));
    }
}

/// Every code prints, and a name stands for one meaning.
fn codes(data: &[u8]) {
    let &[low, high, ..] = data else { return };
    let wide = u16::from_le_bytes([low, high]);
    shown(&ServiceCode(low));
    shown(&GeneralStatus(low));
    shown(&AdditionalCode(low));
    shown(&ClassId(wide));
    shown(&InstanceId(wide));
    shown(&AttributeId(wide));
    shown(&VendorId(wide));
    shown(&DeviceType(wide));
    shown(&AllocationChoice::from_bits_retain(low));
    let data_type = DataTypeCode(low);
    shown(&data_type);
    assert_eq!(data_type.canonical().canonical(), data_type.canonical());
    let (service, response) = ServiceCode::split(low);
    assert_eq!(if response { service.response_byte() } else { service.request_byte() }, low);
}

/// `Display` and `Debug` are total, and never silent.
fn shown(value: &(impl Display + Debug)) {
    assert!(!value.to_string().is_empty(), "{value:?}");
}

/// Longer than any input that the campaigns use, and than any message that is counted in one byte.
const CAPACITY: usize = 1024;
/// To print longer messages takes most of the time, and shows nothing that shorter ones do not.
const PRINTED: usize = 64;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vector_from_a_manual_is_accepted_in_its_role() {
        // ICP DAS CAN-8124/8224/8424 User Manual v2.0, p. 112.
        let allocate = [0x4B, 0x03, 0x01, 0x07, 0x0A];
        assert!(Request::parse(BodyFormat::Class8Instance8, &allocate).is_ok());
        check(&allocate);
    }

    #[test]
    fn a_port_segment_may_be_longer_than_needed() {
        path(Epath::packed(&[0x11, 0x01, 0x05]));
    }
}
