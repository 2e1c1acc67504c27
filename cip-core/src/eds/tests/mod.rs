//! Whole files.

mod sections;

use super::*;
use proptest::prelude::*;
use std::string::ToString;

/// A file without a flaw, of a device that does not exist.
pub(super) const DEMO: &str = include_str!("../../../../tests/eds/block.eds");

/// What is found in the file after one change.
#[track_caller]
fn findings(from: &str, to: &str) -> Vec<String> {
    assert_eq!(DEMO.matches(from).count(), 1, "{from} is not once in the file");
    let eds = Eds::parse(DEMO.replace(from, to)).unwrap();
    eds.diagnostics().iter().map(ToString::to_string).collect()
}

/// One finding, and where.
#[track_caller]
fn finds(from: &str, to: &str, expected: &str) {
    assert_eq!(findings(from, to), [expected], "{from} -> {to}");
}

#[track_caller]
fn finds_all(from: &str, to: &str, codes: &[Code]) {
    let eds = Eds::parse(DEMO.replace(from, to)).unwrap();
    let found: Vec<_> = eds.diagnostics().iter().map(|diagnostic| diagnostic.code).collect();
    assert_eq!(found, codes, "{from} -> {to}: {:#?}", eds.diagnostics());
}

#[test]
fn a_file_without_a_flaw() {
    let eds = Eds::parse(DEMO).unwrap();
    assert_eq!(eds.diagnostics(), []);
    assert_eq!(eds.worst(), None);
}

#[test]
fn what_it_says() {
    let eds = Eds::parse(DEMO).unwrap();
    let created = eds.file().created;
    assert_eq!(created.date.map(|date| date.to_string()).as_deref(), Some("2026-01-15"));
    assert_eq!(created.time.map(|time| time.to_string()).as_deref(), Some("10:00:00"));
    assert_eq!(eds.device().product_name.as_deref(), Some("EXAMPLE-88"));
    assert_eq!(eds.classes(), ["DeviceNet"]);
    let filter = eds.param(2).unwrap();
    assert_eq!((filter.path.len(), filter.data_type), (6, Some(crate::data_type::DataType::Uint)));
    assert_eq!(filter.maximum, Some(Constant::Integer(1000)));
    assert_eq!(filter.text_of_bytes(&[8, 0], |_| None).as_deref(), Some("0.8 ms"));
    assert_eq!(eds.groups()[0].members, [GroupMember::Param(1), GroupMember::Param(2)]);
    let assembly = eds.assembly_at(&[0x20, 0x04, 0x24, 0x65, 0x30, 0x03]).unwrap();
    let layout = eds.layout(assembly).unwrap();
    let shown: Vec<_> = layout.iter().map(|slot| (&*slot.name, slot.first_bit, slot.bits)).collect();
    assert_eq!(shown, [("Inputs", 0, 8), ("State", 8, 4)]);
    let values: Vec<_> = layout.iter().filter_map(|slot| slot.value_in(&[0x81, 0xF2])).collect();
    assert_eq!(values, [0x81, 0x02]);
    assert_eq!(layout[0].bytes_in(&[0x81, 0xF2]), Some(&[0x81][..]));
    assert_eq!(layout[1].value_in(&[0x81]), None);
}

#[test]
fn structure() {
    finds_all("[File]", "[Fille]", &[Code::MissingSection, Code::MisspeltSection]);
    finds_all("[Device]", "[Device]\n[device]", &[Code::EmptySection, Code::DuplicateSection]);
    finds_all("[ParamClass]", "[Parms]", &[Code::MisspeltSection]);
    finds_all("[ParamClass]", "[Other]", &[Code::UnknownSection]);
    finds_all("[ParamClass]", "[4660_Parms]", &[]);
    finds_all("[ParamClass]", "[Connection Manager]", &[]);
    finds_all("$ A demonstration", "[1_X] A = 1; $", &[Code::SectionOrder]);
    finds(
        "[Groups]",
        "[Groupes]",
        "42:1: warning: nothing is known of section [Groupes]; is it [Groups]? [misspelt_section]",
    );
    finds(
        "VendName",
        "VendNmae = \"x\"; VendName",
        "8:23: warning: `VendNmae` is no keyword of [Device]; is it `VendName`? [unknown_keyword]",
    );
    finds(
        "VendName",
        "1_Name = \"x\"; VendName = \"y\"; VENDNAME",
        "8:53: error: `VENDNAME` is on line 8 already, which counts; remove one of them [duplicate_keyword]",
    );
    finds("MajRev = 1;", "", "7:1: error: `MajRev` is missing; add it to this section [missing_keyword]");
    finds("Group1 ", "Group01 ", "43:5: warning: `Group01`: leave the zeros out [keyword_number]");
    finds_all("Group1 ", "Group0 ", &[Code::KeywordNumber]);
    finds("Group1 ", "Group2 ", "43:5: note: number 2 follows 0; number 1 is missing [number_gap]");
    finds_all(
        "Param4 = ",
        "Param70000 =",
        &[Code::ParameterCount, Code::KeywordNumber, Code::UnknownParameter, Code::UnknownParameter],
    );
}

#[test]
fn characters() {
    let codes = |bytes: &[u8]| {
        let mut file = DEMO.as_bytes().to_vec();
        file.extend_from_slice(bytes);
        Eds::parse(file).unwrap().diagnostics().iter().map(|found| found.code).collect::<Vec<_>>()
    };
    assert_eq!(codes(b"$ 25 \xB0C\n"), []);
    assert_eq!(codes("$ 25 °C\n".as_bytes()), [Code::EncodingUtf8]);
    assert_eq!(codes(b"$ Maker\x92s\n"), [Code::EncodingWindows1252]);
    assert_eq!(codes(b"$ \x81\n"), [Code::ControlCharacter]);
    assert_eq!(codes(b"\x1A"), [Code::ControlCharacter]);
    assert_eq!(codes(b"$ x\r\n"), [Code::MixedLineEnds]);
    let with_mark = |mark: &[u8], text: Vec<u8>| {
        let eds = Eds::parse([mark, &text].concat()).unwrap();
        assert_eq!(eds.device().product_code, Some(42));
        eds.diagnostics().iter().map(|found| (found.code, found.place)).collect::<Vec<_>>()
    };
    let start = Place { line: 1, column: 1 };
    assert_eq!(with_mark(b"\xEF\xBB\xBF", DEMO.into()), [(Code::ByteOrderMark, start)]);
    let broken = with_mark(b"\xEF\xBB\xBF", [DEMO.as_bytes(), b"$\xFF"].concat());
    assert_eq!(broken.last(), Some(&(Code::BrokenCharacter, Place { line: 47, column: 2 })));
    let little = DEMO.encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert_eq!(with_mark(b"\xFF\xFE", little), [(Code::EncodingUtf16, start)]);
    let big = DEMO.encode_utf16().flat_map(u16::to_be_bytes).collect();
    assert_eq!(with_mark(b"\xFE\xFF", big), [(Code::EncodingUtf16, start)]);
}

#[test]
fn fields() {
    finds(
        "ProdCode = 42;",
        "ProdCode = 65536;",
        "10:16: error: `ProdCode` is 65536; write a number from 0 to 65535 [number_range]",
    );
    finds(
        "ProdCode = 42;",
        "ProdCode = ;",
        "10:16: error: `ProdCode` is missing; write it here [missing_field]",
    );
    finds(
        "ProdCode = 42;",
        "ProdCode = \"42\";",
        "10:16: error: `ProdCode` is `\"42\"`; write a whole number, decimal or `0x` hexadecimal [not_a_number]",
    );
    finds(
        "ProdCode = 42;",
        "ProdCode = 42, 43;",
        "10:20: warning: `ProdCode` has 1 field; remove what follows, or a `,` too many before [too_many_fields]",
    );
    finds("\"EX88\"", "EX88", "11:41: error: `Catalog` is `EX88`; put it into quotes `\"` [not_a_string]");
    finds(
        "01-15-2026",
        "2026-01-15",
        "4:18: error: `CreateDate` is `2026-01-15`; write it as month-day-year, like 01-31-2026 [bad_date]",
    );
    finds(
        "10:00:00",
        "10:00",
        "4:44: error: `CreateTime` is `10:00`; write it as hours:minutes:seconds, like 08:30:00 [bad_time]",
    );
    finds(
        "Revision = 1.0",
        "Revision = 1",
        "6:16: error: `Revision` is `1`; write it as major.minor, like 1.0 [bad_revision]",
    );
    finds_all("\"EXAMPLE-88\"", "\"0123456789012345678901234567890123\"", &[Code::StringTooLong]);
    finds(
        "Param1 = 0,",
        "Param1 = 1,",
        "27:14: warning: the field is reserved and is `1`; write 0 [reserved]",
    );
    finds(
        "\"20 0F 24 01 30 01\"",
        "\"20 0F 24 01 30 0\"",
        "27:20: error: the path is \"20 0F 24 01 30 0\"; write its bytes with two hexadecimal digits each, like \"20 04 24 65 30 03\" [bad_path]",
    );
    finds(
        "6, \"20 0F 24 01 30 01\"",
        "5, \"20 0F 24 01 30 01\"",
        "27:17: error: the path has 6 bytes, and its size is 5; write 6 [path_size]",
    );
    finds_all("\"20 0F 24 01 30 01\"", "\"20 0F 24 01 FF 01\"", &[Code::PathSegments]);
}

#[test]
fn assemblies_that_grow_without_bound_end() {
    use core::fmt::Write as _;
    let mut text = String::from("[Assembly]\n");
    for number in 1..40 {
        let inner = std::format!(", Assem{}", number + 1).repeat(40).replace(',', ", ,");
        writeln!(text, "Assem{number} = \"\", , , , , {};", inner.trim_start_matches(" ,")).unwrap();
    }
    let eds = Eds::parse(text).unwrap();
    assert_eq!(eds.layout(eds.assembly(1).unwrap()), None);
}

#[test]
fn a_file_that_is_too_long() {
    let error = Eds::parse(std::vec![b' '; MAX_FILE + 1]).unwrap_err();
    assert_eq!(error.to_string(), "16777217 bytes are too many for an EDS, at most 16777216 are read");
}

/// Work does not grow faster than the file, whatever is in it.
#[test]
fn long_lines_and_many_findings() {
    for piece in ["\"", "\\\"", "[", "a=", ",", ";", "$\n", "\"a\"b,", "\u{e9}=", "[a]b=1;", "Param1=1;"] {
        let text = std::format!("[Params]\n{}", piece.repeat(200_000 / piece.len()));
        let eds = Eds::parse(text.clone()).unwrap();
        assert!(eds.diagnostics().len() <= MAX_DIAGNOSTICS);
        let mut written = Vec::new();
        eds.document().write(&mut written);
        assert_eq!(written, text.as_bytes());
    }
}

/// What one name is, many places say: none of them has a copy of it.
#[test]
fn long_names_in_many_places() {
    use core::fmt::Write as _;
    let long = "x".repeat(1_000_000);
    let mut of_section = std::format!("[{long}]\n");
    let mut of_param =
        std::format!("[Params] Param1 = 0,,, 0, 0xC6, 1, \"{long}\";\n[Assembly] Assem1 = \"\",,,,,");
    for number in 0..30_000 {
        writeln!(of_section, "a{number}=;").unwrap();
        of_param.push_str(",,Param1");
    }
    let zeros = "0".repeat(1_000_000);
    let of_entry = std::format!("[Params] Enum{zeros}1 = {};", ",".repeat(10_000));
    Eds::parse(of_section).unwrap();
    let eds = Eds::parse(of_param + ";").unwrap();
    assert_eq!(eds.layout(eds.assembly(1).unwrap()).map(|slots| slots.len()), Some(30_000));
    assert!(eds.param(1).unwrap().name.len() < 10_000);
    let eds = Eds::parse(of_entry).unwrap();
    assert_eq!(eds.diagnostics().len(), MAX_DIAGNOSTICS);
    assert!(eds.diagnostics().iter().all(|found| found.message.len() < 600));
}

proptest! {
    #[test]
    fn any_bytes_are_read_and_written(bytes: Vec<u8>) {
        let eds = Eds::parse(bytes.clone()).unwrap();
        let mut written = Vec::new();
        eds.document().write(&mut written);
        prop_assert_eq!(&written, &bytes);
        let again = Eds::parse(written).unwrap();
        prop_assert_eq!(again.diagnostics(), eds.diagnostics());
    }

    /// A byte of the file is another: every finding has a place inside of it.
    #[test]
    fn a_changed_byte(at in 0..DEMO.len(), byte: u8) {
        let mut bytes = DEMO.as_bytes().to_vec();
        bytes[at] = byte;
        let eds = Eds::parse(bytes).unwrap();
        for found in eds.diagnostics() {
            prop_assert!(found.span.start <= found.span.end && found.span.end <= DEMO.len());
            prop_assert!(found.place.line >= 1 && found.place.column >= 1);
            prop_assert!(!found.message.is_empty());
        }
        let _ = eds.scan_entry();
        for assembly in eds.assemblies() {
            let _ = eds.layout(assembly);
        }
    }
}
