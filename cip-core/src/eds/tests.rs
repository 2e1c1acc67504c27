//! Whole files.

use super::*;
use proptest::prelude::*;
use std::string::ToString;

/// A file without a flaw, of a device that does not exist.
pub(super) const DEMO: &str = include_str!("../../../tests/eds/block.eds");

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
    let shown: Vec<_> = layout.iter().map(|slot| (slot.name.as_str(), slot.first_bit, slot.bits)).collect();
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
fn identity() {
    finds(
        "VendCode = 4660",
        "VendCode = 0",
        "8:16: error: vendor 0 is nobody; write the number that ODVA gave to the vendor [identity]",
    );
    finds_all("ProdCode = 42", "ProdCode = 0", &[Code::Identity]);
    finds_all("MajRev = 1", "MajRev = 128", &[Code::Identity]);
    finds_all("MinRev = 2", "MinRev = 0", &[Code::Identity]);
    finds_all("01-16-2026", "01-14-2026", &[Code::ModifiedBeforeCreated]);
    finds_all("DeviceNet;", "EtherNetIP;", &[Code::NotDeviceNet]);
}

#[test]
fn io_info() {
    finds(
        "Default    = 0x0001",
        "Default = 0x0008",
        "15:15: error: the default has cyclic (0x0008), and `CyclicInfo` is missing; add it, or clear the bit [default_connection]",
    );
    finds_all("Default    = 0x0001", "Default = 0x0000", &[Code::NoDefaultConnection]);
    finds_all("Default    = 0x0001", "Default = 0x0005", &[Code::Incompatible, Code::Incompatible]);
    finds_all("Default    = 0x0001", "Default = 0x0021", &[Code::Reserved]);
    finds_all("StrobeInfo = 0x0003", "StrobeInfo = 0x0002", &[Code::Incompatible]);
    finds(
        "COSInfo    = 0x0004",
        "COSInfo    = 0x000C",
        "18:18: warning: change of state and cyclic are one connection and exclude each other; clear cyclic (0x0008) [incompatible]",
    );
    finds(
        "PollInfo   = 0x0003, 1, 1",
        "PollInfo   = 0x0003, 1, 2",
        "16:29: error: `Output2` does not exist; add it, or write 0 for none [unknown_io]",
    );
    finds_all("StrobeInfo = 0x0003, 1, 0", "StrobeInfo = 0x0003, 1, 1", &[Code::IoType, Code::StrobeSize]);
    finds_all("Input1  = 2, 12", "Input1  = 2, 17", &[Code::SignificantBits]);
    finds(
        "Input1  = 2, 12",
        "Input1  = 3, 12",
        "19:15: error: `Input1` has 3 bytes, and `Assem101` at its path has 2; correct one of them [sizes_differ]",
    );
    finds_all("Input1  = 2, 12", "Input1  = 9, 12", &[Code::SizesDiffer, Code::StrobeSize]);
    finds_all("Input1  = 2, 12", "Input1  = 0, 0", &[Code::ZeroSize, Code::SizesDiffer]);
    finds_all(
        "Output1 = 1, 8",
        "Output2 = 2, 0, 1, \"\", 6, \"20 04 24 66 30 03\", \"\"; Output1 = 1, 8",
        &[Code::SizesDiffer, Code::SizesDiffer],
    );
    finds(
        "\"20 04 24 66 30 03\", \"8",
        "\"20 04 24 67 30 03\", \"8",
        "21:43: note: [Assembly] does not describe what `Output1` carries [assembly_not_described]",
    );
}

#[test]
fn params() {
    finds(
        "MaxInst = 4",
        "MaxInst = 5",
        "23:15: error: `MaxInst` is 5, and the highest parameter is 4; write 4 [parameter_count]",
    );
    finds_all("Descriptor = 0x0009", "Descriptor = 0x0019", &[Code::Reserved]);
    finds(
        "0x0004, 0xC7, 2",
        "0x0004, 0xBF, 2",
        "31:49: error: 0xBF is no data type; write 0xC1 to 0xDE, such as 0xC7 for UINT [unknown_data_type]",
    );
    finds(
        "0x0004, 0xC7, 2",
        "0x0004, 2, 2",
        "31:49: note: 2 is the number of UINT in old files; write 0xC7 [old_data_type]",
    );
    finds(
        "0x0004, 0xC7, 2",
        "0x0004, 0xC7, 4",
        "31:55: error: UINT has 2 bytes, and the data size is 4; write 2 [data_size]",
    );
    finds(
        "0, 1000, 8",
        "0, 65536, 8",
        "33:12: error: the maximum is 65536; UINT has 0 to 65535 [value_range]",
    );
    finds_all("0, 1000, 8", "0, 1000.5, \"8\"", &[Code::ValueRange, Code::ValueRange]);
    finds_all("0, 1000, 8", "1000, 0, 8", &[Code::MinimumAboveMaximum]);
    finds_all("0, 1000, 8", "0, 1000, 1001", &[Code::DefaultOutOfRange]);
    finds_all("\"Fault action\"", "\"Action on a fault of the network\"", &[Code::LongParameterText]);
    finds(
        "\"20 0F 24 01 30 01\"",
        "\"20 0F 24 03 30 01\"",
        "27:20: warning: the path leads to instance 3 of the Parameter object; parameter 1 is instance 1 [parameter_instance]",
    );
    finds_all("\"20 0F 24 02 30 01\"", "\"20 0F 24 02\"", &[Code::PathSize, Code::PathIncomplete]);
    finds_all("\"20 0F 24 02 30 01\"", "\"20 64 24 02 30 01\"", &[]);
    finds_all(
        "\"20 0F 24 02 30 01\"",
        "\"20 01 24 01 30 07\"",
        &[Code::ObjectMismatch, Code::ObjectMismatch],
    );
    finds_all(
        "Param4 = 0, , ,",
        "Param4 = 0, 6, \"20 0F 24 01 30 01\",",
        &[Code::ParameterInstance, Code::SamePath],
    );
    finds_all("1, 10, 1, 0,", "1, 0, , 0,", &[Code::Scaling, Code::Scaling]);
    finds_all("0x0004, 0xC7", "0x0000, 0xC7", &[Code::ScalingUnused]);
    finds_all("0x0004, 0xC7", "0x000C, 0xC7", &[Code::ScalingLink]);
    finds_all("0x0032, 0xC6", "0x0072, 0xC6", &[Code::ScalingLink]);
    finds(
        "1, 10, 1, 0,  0, 0, 0, 0",
        "1, 10, 1, 0,  0, 9, 0, 0",
        "33:39: error: there is no parameter 9; name one of [Params], or write 0 [unknown_parameter]",
    );
}

#[test]
fn texts_and_groups() {
    finds(
        "0x0002, 0xC6",
        "0x0000, 0xC6",
        "27:41: warning: there are texts for its values, and descriptor bit 1 does not announce them; set 0x0002 [enum_announced]",
    );
    finds_all("0x0004, 0xC7", "0x0006, 0xC7", &[Code::EnumAnnounced]);
    finds_all("1, \"Hold last state\"", "1, \"Hold last state\", 2", &[Code::EnumPairs]);
    finds_all("1, \"Hold last state\"", "0, \"Hold last state\"", &[Code::EnumDuplicate]);
    finds(
        "1, \"Hold last state\"",
        "2, \"Hold last state\"",
        "30:23: warning: the parameter has no value 2; correct it, or the limits [enum_out_of_range]",
    );
    finds(
        "7, \"IN7\"",
        "8, \"IN7\"",
        "37:33: warning: the parameter has no bit 8; correct it, or the limits [enum_out_of_range]",
    );
    finds_all("Enum4 =", "Enum5 =", &[Code::EnumAnnounced, Code::UnknownParameter]);
    finds(
        "\"General\", 2, 1, 2",
        "\"General\", 3, 1, 2",
        "43:25: error: the group has 2 members, and 3 are announced; write 2 [member_count]",
    );
    finds_all(
        "\"General\", 2, 1, 2",
        "\"General\", 3, 1, 1, 9",
        &[Code::DuplicateMember, Code::UnknownParameter],
    );
    finds_all("\"General\", 2, 1, 2", "\"General\", 3, 1, 2, Variant1", &[]);
}

#[test]
fn old_texts_count_from_the_minimum() {
    let file =
        DEMO.replace("Enum4 = 0, \"Idle\", 1, \"Run\", 2, \"Fault\";", "").replace("0, 3, 0", "10, 12, 10");
    let eds = Eds::parse(file + "[EnumPar] Param4 = \"Idle\", \"Run\"; Param1 = \"x\";").unwrap();
    let codes: Vec<_> = eds.diagnostics().iter().map(|found| found.code).collect();
    assert_eq!(codes, [Code::EnumDuplicate]);
    let texts = &eds.param(4).unwrap().texts;
    assert_eq!(texts.iter().map(|text| text.value).collect::<Vec<_>>(), [10, 11]);
    assert_eq!(eds.param(4).unwrap().text_of(11), Some("Run"));
}

#[test]
fn assemblies() {
    finds(
        "4, Param4, 4, ;",
        "4, Param4;",
        "45:56: error: the members have 12 bits, and 2 bytes are 16; correct the size, or fill up with a member `bits,` without a reference [assembly_size]",
    );
    finds_all("4, Param4, 4, ;", "4, Param9, 4, ;", &[Code::UnknownParameter]);
    finds_all("4, Param4, 4, ;", "4, Assem9, 4, ;", &[Code::UnknownAssembly]);
    finds_all("4, Param4, 4, ;", "4, Param4, 4;", &[Code::MemberPairs]);
    finds_all("8, Param3, 4, Param4, 4, ;", "16, Param3;", &[Code::MemberSize]);
    finds_all("4, Param4, 4, ;", "4, Param4:4, 4, \"20 04\";", &[]);
    finds_all("4, Param4, 4, ;", "4, 4, 4, \"Status\";", &[Code::MemberReference, Code::MemberReference]);
    finds_all(
        "1, 0x0000, , , 8, ;",
        "1, 0x0000, , , , Assem103; Assem103 = \"\", , , , , , , Assem104; Assem104 = \"\", , , , , , , Assem103;",
        &[Code::AssemblyCycle],
    );
}

#[test]
fn assemblies_inside_of_assemblies() {
    let text = "[Params] Param1 = 0, , , 0, 0xC6, 1, \"A\", \"\", \"\", , , ;\n[Assembly]\n\
                Assem1 = \"\", \"\", 5, 0, , , , Param1, , Assem2, 4, Param1:4, 4, , 8, Variant1;\n\
                Assem2 = \"\", \"\", 2, 0, , , 4, Param1;\n\
                Variant1 = \"V\", , , , , Param1, 0, Assem3, 1, Assem3;\n\
                BitStringVariant1 = \"W\", , Param1, 0, Assem3, Assem3, 1, , Assem2;\n\
                Assem3 = \"\", , , , , , 8, ;";
    let eds = Eds::parse(text).unwrap();
    let layout = eds.layout(eds.assembly(1).unwrap()).unwrap();
    let shown: Vec<_> =
        layout.iter().map(|slot| (slot.name.as_str(), slot.first_bit, slot.bits, slot.param_bit)).collect();
    assert_eq!(shown, [("A", 0, 8, 0), ("A", 8, 4, 0), ("A", 24, 4, 4), ("V", 32, 8, 0)]);
    assert_eq!(eds.variants()[0].choices.len(), 2);
    assert_eq!(eds.variants()[1].choices[1].references, [Reference::Padding, Reference::Assembly(2)]);
    let codes: Vec<_> = eds.diagnostics().iter().map(|found| found.code).collect();
    // File and device are missing, and the four bits of the second assembly are not its two bytes.
    assert_eq!(codes, [Code::MissingSection, Code::MissingSection, Code::AssemblySize]);
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
