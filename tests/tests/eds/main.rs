//! Electronic Data Sheets in `tests/eds`, checked and shown: snapshots of what a user reads. The device and its vendor do not
//! exist.
#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used, clippy::indexing_slicing)] // A test may panic.

mod decoded;

use cip_core::eds::{Code, Eds, Severity};
use devicenet_cli::eds::Report;
use devicenet_core::MacId;
use devicenet_core::master::ScanEntry;
use devicenet_tests::workspace_root;

/// Name of the file, what to look for in its snapshot.
const FILES: &[(&str, &str)] = &[
    ("block", "nothing: the file is right"),
    (
        "syntax",
        "one finding for each mistake of the pen, and none that follows from another; every entry is still read",
    ),
    (
        "structure",
        "sections and keywords that are missing, there twice, unknown; those of the vendor are left alone",
    ),
    ("missing", "the sections that every file has"),
    ("device", "numbers, dates and texts that cannot be those of a device"),
    ("io", "masks, sizes and paths of connections that contradict one another"),
    ("params", "types, limits, scaling, texts and links that contradict one another"),
    ("assemblies", "members that do not exist, do not fit, or go round in a circle"),
    ("old", "notes only: old numbers of data types; texts count from the minimum"),
];

#[test]
fn what_is_wrong_is_said_with_its_place() {
    for (name, look_for) in FILES {
        let eds = read(name);
        let mut text = Vec::new();
        Report::new(format!("{name}.eds"), &eds, &[])
            .text(&mut text, false)
            .expect("a vector takes everything");
        let text = String::from_utf8(text).expect("UTF-8");
        insta::with_settings!({ description => *look_for, omit_expression => true, prepend_module_to_snapshot => false }, {
            insta::assert_snapshot!(format!("check__{name}"), text);
        });
    }
}

#[test]
fn what_a_file_says_is_shown() {
    for (name, look_for) in [
        (
            "block",
            "everything that the file says: connections with their data, parameters with their limits in words",
        ),
        ("syntax", "what could be understood in spite of the mistakes"),
        ("old", "the types of old numbers, and texts that begin at the minimum"),
        ("assemblies", "what stands where, and why it is not known"),
    ] {
        let mut text = Vec::new();
        devicenet_cli::eds::text(&read(name), &mut text).expect("a vector takes everything");
        let text = String::from_utf8(text).expect("UTF-8");
        insta::with_settings!({ description => look_for, omit_expression => true, prepend_module_to_snapshot => false }, {
            insta::assert_snapshot!(format!("show__{name}"), text);
        });
    }
}

/// A code that no file shows could be one that nothing raises.
#[test]
fn every_code_is_shown_by_a_file() {
    // The characters of a file are tested byte by byte in `cip-core`.
    let characters = [
        Code::EncodingUtf16,
        Code::ByteOrderMark,
        Code::EncodingWindows1252,
        Code::BrokenCharacter,
        Code::ControlCharacter,
        Code::MixedLineEnds,
    ];
    let found: Vec<Code> = FILES
        .iter()
        .flat_map(|(name, _)| read(name).diagnostics().iter().map(|found| found.code).collect::<Vec<_>>())
        .collect();
    let missing: Vec<&Code> =
        Code::ALL.iter().filter(|code| !found.contains(code) && !characters.contains(code)).collect();
    assert!(missing.is_empty(), "no file shows {missing:?}");
}

#[test]
fn a_right_file_stays_right_in_every_encoding() {
    let text = std::fs::read_to_string(path("block")).expect("the file");
    let latin: Vec<u8> =
        text.replace("a fault", "a fault above 50 °C").chars().map(|c| u8::try_from(c).unwrap()).collect();
    let eds = Eds::parse(latin).expect("not too long");
    assert_eq!(eds.diagnostics(), []);
    assert_eq!(eds.param(1).expect("a parameter").help, "What outputs do on a fault above 50 °C");
    let utf16: Vec<u8> = [0xFEFF].into_iter().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    let eds = Eds::parse(utf16).expect("not too long");
    assert_eq!(eds.diagnostics().iter().map(|found| found.code).collect::<Vec<_>>(), [Code::EncodingUtf16]);
    assert_eq!(eds.params().len(), 4);
}

/// The files are written as they were read.
#[test]
fn nothing_is_lost() {
    for (name, _) in FILES {
        let bytes = std::fs::read(path(name)).expect("the file");
        let mut written = Vec::new();
        read(name).document().write(&mut written);
        assert_eq!(written, bytes, "{name}");
    }
}

#[test]
fn a_file_makes_an_entry_of_a_scan_list() {
    let device = read("block").scan_entry().expect("it says all that a master must know");
    let entry = ScanEntry::of_device(MacId::MAX, &device).expect("its connections go together");
    assert_eq!(entry.choice(), device.default.allocation_choice());
    assert_eq!(entry.key.vendor, Some(device.key.vendor));
}

#[test]
fn severities_are_those_of_the_codes() {
    assert_eq!(read("block").worst(), None);
    assert_eq!(read("old").worst(), Some(Severity::Note));
    assert_eq!(read("io").worst(), Some(Severity::Error));
}

fn read(name: &str) -> Eds {
    let bytes = std::fs::read(path(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
    Eds::parse(bytes).expect("not too long")
}

fn path(name: &str) -> std::path::PathBuf {
    workspace_root().join("tests/eds").join(format!("{name}.eds"))
}
