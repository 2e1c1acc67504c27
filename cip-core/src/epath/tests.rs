use super::*;
use crate::code::{AttributeId, ClassId, DataTypeCode, DeviceType, InstanceId, VendorId};
use proptest::{collection::vec, prelude::*};
use std::string::ToString;
use std::vec::Vec;

fn segments(bytes: &[u8]) -> Vec<Segment<'_>> {
    Epath::packed(bytes).segments().collect::<Result<_, _>>().unwrap()
}

fn reemitted(path: Epath<'_>) -> Option<Vec<u8>> {
    let mut buffer = [0xA5; 600];
    let mut out = Writer::new(&mut buffer);
    for segment in path.segments() {
        segment.ok()?.emit(path.form(), &mut out).expect("a segment that was read can be written");
    }
    Some(out.written().to_vec())
}

#[test]
fn paths_of_devicenet_products() {
    let cases: [(&[u8], &str); 6] = [
        (&[0x20, 0x04, 0x24, 0x65, 0x30, 0x03], "class 4 instance 101 attribute 3"),
        (&[0x21, 0x04, 0x00, 0x25, 0x65, 0x00, 0x30, 0x03], "class 4 instance 101 attribute 3"),
        (&[0x20, 0x2B, 0x24, 0x01], "class 43 instance 1"),
        (&[0x21, 0x00, 0x03, 0x24, 0x05], "class 768 instance 5"),
        // Rockwell 160-DN2: the assembly number as a symbol of three characters.
        (&[0x63, 0x30, 0x36, 0x35], "symbol \"065\""),
        (&[], "empty path"),
    ];
    for (bytes, text) in cases {
        let path = Epath::packed(bytes);
        assert_eq!(path.to_string(), text);
        assert_eq!(reemitted(path).as_deref(), Some(bytes));
    }
}

#[test]
fn padded_paths_have_a_zero_before_wide_values() {
    let path = Epath::padded(&[0x21, 0x00, 0x04, 0x00, 0x24, 0x65]);
    assert_eq!(path.to_string(), "class 4 instance 101");
    assert_eq!(reemitted(path).as_deref(), Some(path.bytes()));
    let wrong = Epath::padded(&[0x21, 0x04, 0x00, 0x25, 0x65, 0x00]);
    assert_eq!(
        wrong.segments().next().unwrap().unwrap_err().to_string(),
        "pad byte at offset 1: value 0x04 is not allowed"
    );
}

#[test]
fn every_segment_type() {
    let key = ElectronicKey {
        vendor: VendorId(1),
        device_type: DeviceType(12),
        product_code: 0x1234,
        compatible: true,
        major: 2,
        minor: 7,
    };
    let cases: [(&[u8], Segment<'_>, &str); 12] = [
        (&[0x01, 0x05], Segment::Port { port: 1, link: &[5] }, "port 1 link 05"),
        (&[0x12, 0x02, 0x31, 0x32], Segment::Port { port: 2, link: b"12" }, "port 2 link 31 32"),
        (&[0x0F, 0x34, 0x12, 0x05], Segment::Port { port: 0x1234, link: &[5] }, "port 4660 link 05"),
        (
            &[0x34, 0x04, 0x01, 0x00, 0x0C, 0x00, 0x34, 0x12, 0x82, 0x07],
            Segment::ElectronicKey(key),
            "key vendor 1 type 12 product 4660 revision 2.7 or compatible",
        ),
        (&[0x43, 0x0A], Segment::Network { subtype: 3, data: &[10] }, "network 0x03: 0A"),
        (
            &[0x51, 0x01, 0x0A, 0x0B],
            Segment::Network { subtype: 0x11, data: &[10, 11] },
            "network 0x11: 0A 0B",
        ),
        (
            &[0x60, 0xC7, 0x34, 0x12],
            Segment::ExtendedSymbol(ExtendedSymbol { format: 0xC7, data: &[0x34, 0x12] }),
            "symbol 0xC7: 34 12",
        ),
        (&[0x80, 0x01, 0xAA, 0xBB], Segment::Data(&[0xAA, 0xBB]), "data AA BB"),
        (&[0x91, 0x03, b'a', b'b', b'c', 0], Segment::AnsiSymbol(b"abc"), "symbol \"abc\""),
        (
            &[0xA0, 0x02, 0x34, 0x12],
            Segment::ConstructedType { code: 0xA0, data: &[0x34, 0x12] },
            "type 0xA0: 34 12",
        ),
        (&[0xC7], Segment::ElementaryType(DataTypeCode::UINT), "type UINT"),
        (
            &[0x2E, 0x01, 0x00, 0x01, 0x00],
            Segment::Logical { kind: LogicalKind::ConnectionPoint, width: Width::Bits32, value: 0x1_0001 },
            "connection point 65537",
        ),
    ];
    for (bytes, segment, text) in cases {
        assert_eq!(segments(bytes), [segment]);
        assert_eq!(segment.to_string(), text);
        assert_eq!(reemitted(Epath::packed(bytes)).as_deref(), Some(bytes));
        for short in 1..bytes.len() {
            let mut short = Epath::packed(&bytes[..short]).segments();
            assert!(short.any(|segment| segment.is_err()), "a prefix of {bytes:02X?}");
        }
    }
}

/// What would be read as something else is not written, and nothing is left of it.
#[test]
fn a_segment_that_its_layout_cannot_hold_is_refused() {
    let key = ElectronicKey {
        vendor: VendorId(1),
        device_type: DeviceType(12),
        product_code: 1,
        compatible: false,
        major: 0x80,
        minor: 1,
    };
    let symbol = |format, data| Segment::ExtendedSymbol(ExtendedSymbol { format, data });
    let logical = |kind, width, value| Segment::Logical { kind, width, value };
    let cases: [(Segment<'_>, &str); 17] = [
        (Segment::ElectronicKey(key), "key major revision"),
        (symbol(0x20, &[]), "symbol format"),
        (symbol(0xC5, &[1]), "symbol format"),
        (symbol(0xC7, &[1]), "symbol"),
        (symbol(0x41, &[1, 2]), "symbol"),
        (logical(LogicalKind::Class, Width::Bits8, 0x100), "class"),
        (logical(LogicalKind::Instance, Width::Bits16, 0x1_0000), "instance"),
        (logical(LogicalKind::Service, Width::Bits16, 1), "service"),
        (Segment::Network { subtype: 0x20, data: &[1] }, "network segment subtype"),
        (Segment::Network { subtype: 3, data: &[1, 2] }, "network segment"),
        (Segment::Network { subtype: 0x11, data: &[1] }, "network segment"),
        (Segment::Data(&[1]), "data segment"),
        (Segment::Data(&[0; 512]), "data segment"),
        (Segment::Symbol(&[]), "symbol"),
        (Segment::AnsiSymbol(&[b'a'; 256]), "symbol"),
        (Segment::ConstructedType { code: 0xC0, data: &[] }, "data type"),
        (Segment::ElementaryType(DataTypeCode(0xE0)), "data type"),
    ];
    for (segment, field) in cases {
        let mut buffer = [0; 600];
        let mut out = Writer::new(&mut buffer);
        assert_eq!(
            segment.emit(PathForm::Packed, &mut out),
            Err(SegmentError::Unfit { field }),
            "{segment:?}"
        );
        assert!(out.is_empty(), "{segment:?}");
    }
    let short = Segment::Data(&[1, 2]).emit(PathForm::Packed, &mut Writer::new(&mut [0; 3]));
    assert_eq!(short, Err(SegmentError::Full(Full)));
}

#[test]
fn reserved_segments_end_the_path() {
    for byte in [0x23, 0x35, 0x39, 0x3C, 0x81, 0xE0, 0xFF] {
        let bytes = [0x20, 0x04, byte, 0, 0, 0, 0, 0];
        let mut found = Epath::packed(&bytes).segments();
        assert!(found.next().unwrap().is_ok());
        assert_eq!(found.next().unwrap().unwrap_err().offset, 2, "0x{byte:02X}");
        assert!(found.next().is_none());
    }
    assert_eq!(Epath::packed(&[0x20, 0x04, 0xE0, 0x01]).to_string(), "class 4 malformed E0 01");
}

#[test]
fn a_malformed_segment_is_shown_from_its_first_byte() {
    let cases: [(&[u8], &str); 4] = [
        (&[0x20, 0x04, 0x25, 0x65], "class 4 malformed 25 65"),
        (&[0x20], "malformed 20"),
        (&[0x20, 0x04, 0x34, 0x05, 0x01], "class 4 malformed 34 05 01"),
        (&[0x63, b'0', b'6'], "malformed 63 30 36"),
    ];
    for (bytes, text) in cases {
        assert_eq!(Epath::packed(bytes).to_string(), text);
    }
}

#[test]
fn ids_of_a_path() {
    let path = Epath::packed(&[0x21, 0x04, 0x00, 0x25, 0x65, 0x00, 0x30, 0x03]).logical().unwrap();
    assert_eq!(path, LogicalPath::object(ClassId::ASSEMBLY, InstanceId(101)).with_attribute(AttributeId(3)));
    let error = Epath::packed(&[0x20, 0x04, 0x26, 0, 0, 1, 0]).logical().unwrap_err();
    assert_eq!((error.field, error.offset), ("instance", 2));
}

#[test]
fn a_path_of_words_widens_one_id() {
    let mut buffer = [0; 16];
    let mut out = Writer::new(&mut buffer);
    LogicalPath::object(ClassId(0x300), InstanceId(5)).emit_words(&mut out).unwrap().unwrap();
    assert_eq!(out.written(), [0x21, 0x00, 0x03, 0x25, 0x05, 0x00]);

    let odd = LogicalPath::object(ClassId(0x300), InstanceId(0x300)).with_attribute(AttributeId(0x300));
    assert_eq!(odd.emit_words(&mut Writer::new(&mut [0; 16])), Ok(Err(Unpackable)));
}

proptest! {
    #[test]
    fn what_is_read_is_written_again(bytes in vec(any::<u8>(), 0..40), padded: bool) {
        let path = if padded { Epath::padded(&bytes) } else { Epath::packed(&bytes) };
        let _ = path.to_string();
        if let Some(written) = reemitted(path) {
            // A port below 15 in the extended form, or a one-byte link address with a length, is shortened.
            prop_assert!(written == bytes || has_port(path));
            let again = if padded { Epath::padded(&written) } else { Epath::packed(&written) };
            prop_assert!(path.segments().eq(again.segments()));
        }
    }

    #[test]
    fn logical_paths_survive(class: u16, instance: u16, attribute in proptest::option::of(any::<u16>())) {
        let path = LogicalPath {
            attribute: attribute.map(AttributeId),
            ..LogicalPath::object(ClassId(class), InstanceId(instance))
        };
        let mut buffer = [0; 16];
        let mut out = Writer::new(&mut buffer);
        path.emit(PathForm::Packed, &mut out).unwrap();
        prop_assert_eq!(out.len(), path.packed_len());
        prop_assert_eq!(Epath::packed(out.written()).logical(), Ok(path));
    }
}

fn has_port(path: Epath<'_>) -> bool {
    path.segments().flatten().any(|segment| matches!(segment, Segment::Port { .. }))
}
