//! What is wrong in a section, or between two.

use super::*;

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
        layout.iter().map(|slot| (&*slot.name, slot.first_bit, slot.bits, slot.param_bit)).collect();
    assert_eq!(shown, [("A", 0, 8, 0), ("A", 8, 4, 0), ("A", 24, 4, 4), ("V", 32, 8, 0)]);
    assert_eq!(eds.variants()[0].choices.len(), 2);
    assert_eq!(eds.variants()[1].choices[1].references, [Reference::Padding, Reference::Assembly(2)]);
    let codes: Vec<_> = eds.diagnostics().iter().map(|found| found.code).collect();
    // File and device are missing, and the four bits of the second assembly are not its two bytes.
    assert_eq!(codes, [Code::MissingSection, Code::MissingSection, Code::AssemblySize]);
}
