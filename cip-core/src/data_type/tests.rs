use super::*;
use crate::codec::{Full, ParseErrorKind, Reader, Writer};
use proptest::{collection::vec, prelude::*};
use std::string::ToString;
use std::vec::Vec;

fn parse(ty: DataType, bytes: &[u8]) -> Value<'_> {
    let mut reader = Reader::new(bytes);
    let value = ty.read(&mut reader).unwrap();
    reader.finish("value").unwrap();
    value
}

#[test]
fn values_in_text() {
    let cases: [(DataType, &[u8], &str); 20] = [
        (DataType::Bool, &[1], "true"),
        (DataType::Sint, &[0xFF], "-1"),
        (DataType::Int, &[0x00, 0x80], "-32768"),
        (DataType::Udint, &[0xFF; 4], "4294967295"),
        (DataType::Ulint, &[0xFF; 8], "18446744073709551615"),
        (DataType::Real, &[0x00, 0x00, 0xC0, 0x3F], "1.5"),
        (DataType::Byte, &[0x0A], "0x0A"),
        (DataType::Word, &[0x34, 0x12], "0x1234"),
        (DataType::Lword, &[1, 0, 0, 0, 0, 0, 0, 0x80], "0x8000000000000001"),
        (DataType::Date, &[0, 0], "1972-01-01"),
        (DataType::TimeOfDay, &[0xFF, 0x5B, 0x26, 0x05], "23:59:59.999"),
        (DataType::DateAndTime, &[0, 0, 0, 0, 60, 0], "1972-03-01 00:00:00.000"),
        (DataType::String, &[2, 0, b'o', b'k'], "\"ok\""),
        (DataType::String2, &[1, 0, 0xAC, 0x20], "\"\u{20ac}\""),
        (DataType::StringN, &[3, 0, 1, 0, 1, 2, 3], "01 02 03"),
        (DataType::ShortString, b"\x02a\n", "\"a\\x0A\""),
        (DataType::Itime, &[0xFE, 0xFF], "-2 ms"),
        (DataType::Ltime, &[5, 0, 0, 0, 0, 0, 0, 0], "5 us"),
        (DataType::Epath, &[0x20, 0x04, 0x24, 0x65], "class 4 instance 101"),
        (DataType::Engunit, &[0x00, 0x13], "0x1300"),
    ];
    for (ty, bytes, text) in cases {
        assert_eq!(parse(ty, bytes).to_string(), text, "{ty:?}");
    }
}

#[test]
fn a_bool_is_0_or_1() {
    let error = DataType::Bool.read(&mut Reader::new(&[2])).unwrap_err();
    assert_eq!(error.kind, ParseErrorKind::Value { found: 2 });
}

#[test]
fn characters_are_whole() {
    let mut out = [0; 16];
    assert_eq!(Value::String2(&[1, 2, 3]).emit(&mut Writer::new(&mut out)), Err(Full));
    assert_eq!(Value::StringN { width: 0, bytes: &[] }.emit(&mut Writer::new(&mut out)), Err(Full));
    assert!(DataType::StringN.read(&mut Reader::new(&[0, 0, 0, 0])).is_err());
}

#[test]
fn codes_are_inverse() {
    for ty in DataType::ALL {
        assert_eq!(DataType::from_code(ty.code()), Some(ty));
    }
    assert_eq!(DataType::from_code(DataTypeCode::OLD_SHORT_STRING), Some(DataType::ShortString));
    assert_eq!(DataType::from_code(DataTypeCode(0xDF)), None);
    assert_eq!(DataType::from_code(DataTypeCode(0)), None);
}

proptest! {
    /// Compared as bytes, because a NaN does not equal itself.
    #[test]
    fn what_is_read_is_written_again(ty in prop::sample::select(&DataType::ALL[..]), bytes in vec(any::<u8>(), 0..24)) {
        let mut reader = Reader::new(&bytes);
        if let Ok(value) = ty.read(&mut reader) {
            let mut buffer = [0xA5; 32];
            let mut out = Writer::new(&mut buffer);
            value.emit(&mut out).unwrap();
            prop_assert_eq!(out.written(), &bytes[..reader.offset()]);
            prop_assert_eq!(value.data_type(), ty);
            prop_assert!(ty.size().is_none_or(|size| size == reader.offset()));
            let _ = value.to_string();
        } else if let Some(size) = ty.size() {
            prop_assert!(bytes.len() < size || ty == DataType::Bool);
        }
    }

    #[test]
    fn strict_prefixes_fail(ty in prop::sample::select(&DataType::ALL[..]), text in vec(any::<u8>(), 0..6)) {
        let mut buffer = [0; 32];
        let mut out = Writer::new(&mut buffer);
        let value = match ty {
            DataType::String => Value::String(&text),
            DataType::ShortString => Value::ShortString(&text),
            DataType::String2 => Value::String2(&[1, 2, 3, 4]),
            DataType::StringN => Value::StringN { width: 3, bytes: &[1, 2, 3] },
            DataType::Epath | DataType::StringI => return Ok(()),
            fixed => fixed.read(&mut Reader::new(&[0; 8])).unwrap(),
        };
        value.emit(&mut out).unwrap();
        let bytes: Vec<u8> = out.written().to_vec();
        for short in 0..bytes.len() {
            prop_assert!(ty.read(&mut Reader::new(&bytes[..short])).is_err());
        }
    }
}
