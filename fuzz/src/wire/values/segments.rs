//! Segments of paths.

use arbitrary::{Result, Unstructured};
use cip_core::code::{DataTypeCode, DeviceType, VendorId};
use cip_core::codec::{Reader, Writer};
use cip_core::epath::{ElectronicKey, Epath, ExtendedSymbol, LogicalKind, PathForm, Segment, Width};

use super::{CAPACITY, free, items};

/// A segment of each kind, alone in a path of each form.
pub(super) fn check(input: &mut Unstructured<'_>) -> Result<()> {
    let segment = segment(input)?;
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
            let cut = Segment::read(&mut Reader::new(&path.bytes()[..len]), form);
            assert!(cut.is_err(), "{len} bytes of {path:?}");
        }
    }
    Ok(())
}

fn segment<'a>(input: &mut Unstructured<'a>) -> Result<Segment<'a>> {
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
                Segment::Network { subtype: short, data: free(input)?.get(..1).unwrap_or(&[0]) }
            }
            long => Segment::Network { subtype: long, data: items(2, input)? },
        },
        4 => match free(input)? {
            [] => Segment::Symbol(b"A"),
            name => Segment::Symbol(name),
        },
        5 => {
            let (size, format) =
                *input.choose(&[(1, 0xC6), (2, 0xC7), (4, 0xC8), (2, 0x21), (6, 0x42), (62, 0x3F)])?;
            let data = free(input)?.get(..size).unwrap_or(&[0; 62][..size]);
            Segment::ExtendedSymbol(ExtendedSymbol { format, data })
        }
        6 => Segment::Data(items(2, input)?),
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
